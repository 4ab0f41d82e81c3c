//! What the solver says of its own work.

/// How the last step went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolverReport {
    /// Substeps taken.
    pub substeps: u32,
    /// Sweeps of whichever island needed most, summed over the substeps.
    pub sweeps: u32,
    /// The most sweeps that one island needed in one substep.
    pub most_sweeps: u32,
    /// Whether every island met the tolerance in every substep before its sweeps were spent.
    pub converged: bool,
    /// Largest error left in any hard constraint at the end of the step, metres.
    pub error: f32,
    /// Largest error left in a hard distance as a share of its rest length.
    pub strain: f32,
    /// Rows that turned non-finite and were put back to where the step began, at rest.
    pub frozen: Vec<u32>,
}
