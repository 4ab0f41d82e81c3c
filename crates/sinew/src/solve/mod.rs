//! Solving: in which order the kernels of the [constraints](crate::constraints) run, and how often.
//!
//! - `plan` compiles the distances into islands, and each island into colours;
//! - `cascade` runs Gauss–Seidel sweeps over each island until the largest error in it is small enough or the sweeps are spent;
//! - `report` says how that went.

mod cascade;
mod plan;
mod report;

pub use report::SolverReport;

pub(crate) use cascade::{cascade, measure};
pub(crate) use plan::Plan;

/// How hard the solver tries. Every number has a documented range and is clamped to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings {
    /// Substeps in a step, 1 to 256, default 10. At equal work many substeps with few sweeps beat one step with many.
    pub substeps: u32,
    /// The most sweeps over all constraints in a substep (the lectures' `N_MAX`), 1 to 1000, default 4.
    pub max_sweeps: u32,
    /// Error in metres at which an island stops being swept early in a substep, 0 or more, default 1e-4. A negative or non-finite one counts as 0.
    pub tolerance: f32,
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self { substeps: 10, max_sweeps: 4, tolerance: 1e-4 }
    }
}

impl SolverSettings {
    /// The same with every number inside its range.
    pub fn clamped(self) -> Self {
        Self {
            substeps: self.substeps.clamp(1, 256),
            max_sweeps: self.max_sweeps.clamp(1, 1000),
            tolerance: if self.tolerance.is_finite() { self.tolerance.max(0.0) } else { 0.0 },
        }
    }
}
