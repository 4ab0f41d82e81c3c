//! What the solver says of its own work.

use crate::collide::Impact;

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
    /// Rows that were slowed down to [the most speed](crate::SolverSettings::max_speed).
    pub too_fast: Vec<u32>,
    /// What has touched what, where a body or a collider asked for it: a line for each two, sorted by who they are.
    pub impacts: Vec<Impact>,
    /// The islands one by one, in the order of their first particles.
    pub islands: Vec<IslandReport>,
}

/// How the last step of one island went: of particles that constraints connect, and so of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IslandReport {
    /// Sweeps over its constraints, summed over the substeps; none of what has none.
    pub sweeps: u32,
    /// The most that it needed in one substep.
    pub most_sweeps: u32,
    /// Those of the last substep.
    pub last_sweeps: u32,
    /// Whether it met the tolerance in every substep.
    pub converged: bool,
    /// Substeps in which it turned too fast to be corrected along the start of the step.
    pub fallbacks: u32,
    /// Largest error left in a hard constraint, metres.
    pub error: f32,
    /// Largest error left in a hard distance as a share of its rest length.
    pub strain: f32,
    /// Time that solving it took, seconds; zero unless [`SolverSettings::timed`](crate::SolverSettings::timed). Not part of any state.
    pub seconds: f64,
    /// Whether what is left has been measured on the way. Taken back when the step ends.
    pub(crate) measured: bool,
    /// Whether the last substep began with more violated than may be recovered in it.
    pub(crate) violated: bool,
}

impl Default for IslandReport {
    fn default() -> Self {
        Self {
            sweeps: 0,
            most_sweeps: 0,
            last_sweeps: 0,
            converged: true,
            fallbacks: 0,
            error: 0.0,
            strain: 0.0,
            seconds: 0.0,
            measured: false,
            violated: false,
        }
    }
}
