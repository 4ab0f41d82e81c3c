//! The solver's report.

use crate::collide::Impact;

/// How the last step went: iteration counts, errors that remain, and what was limited. Read it with [`Simulation::report`](crate::Simulation::report).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolverReport {
    /// Number of substeps taken.
    pub substeps: u32,
    /// Sweeps of the island that needed most, summed over the substeps.
    pub sweeps: u32,
    /// The largest number of sweeps that an island needed in one substep.
    pub most_sweeps: u32,
    /// Whether every island was within its tolerance in every substep before its sweeps were used up.
    pub converged: bool,
    /// Largest remaining error of any hard constraint or contact at the end of the step, metres.
    pub error: f32,
    /// Largest remaining error of a hard distance as a share of its rest length.
    pub strain: f32,
    /// Rows of particles that became non-finite. They were put back to their positions at the start of the step, at rest.
    pub frozen: Vec<u32>,
    /// Rows of particles that were slowed down to [the speed limit](crate::SolverSettings::max_speed).
    pub too_fast: Vec<u32>,
    /// Contact events of the step, for bodies and colliders that report them: one entry for each pair of participants, sorted by participants.
    pub impacts: Vec<Impact>,
    /// One report for each island, in the order of their first particles.
    pub islands: Vec<IslandReport>,
}

/// How the last step of one island went. An island is a set of particles that constraints connect, usually a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IslandReport {
    /// Sweeps over its constraints, summed over the substeps. Zero for an island without constraints.
    pub sweeps: u32,
    /// The largest number of sweeps in one substep.
    pub most_sweeps: u32,
    /// Sweeps in the last substep.
    pub last_sweeps: u32,
    /// Whether it was within the tolerance in every substep.
    pub converged: bool,
    /// Number of substeps in which it turned too fast to be corrected along the start of the step.
    pub fallbacks: u32,
    /// Largest remaining error of a hard constraint or contact, metres.
    pub error: f32,
    /// Largest remaining error of a hard distance as a share of its rest length.
    pub strain: f32,
    /// Time spent on solving it, seconds; zero unless [`SolverSettings::timed`](crate::SolverSettings::timed) is on. Not part of any state.
    pub seconds: f64,
    /// Whether the remaining errors were measured during the step. Reset at its end.
    pub(crate) measured: bool,
    /// Whether the last substep began with a larger violation than may be recovered in it.
    pub(crate) violated: bool,
}

impl IslandReport {
    /// Records the sweeps of a substep and whether it converged.
    pub(super) fn note(&mut self, sweeps: u32, converged: bool) {
        self.sweeps += sweeps;
        self.converged &= converged;
        self.note_substep(sweeps);
    }

    /// Records the sweeps of a substep whose parts have been recorded already.
    pub(super) fn note_substep(&mut self, sweeps: u32) {
        self.most_sweeps = self.most_sweeps.max(sweeps);
        self.last_sweeps = sweeps;
    }

    /// Records the remaining error at the end of a step.
    pub(super) fn note_left(&mut self, (error, strain): (f32, f32)) {
        (self.error, self.strain, self.measured) = (error, strain, true);
    }

    /// Appends the report of the substeps that follow.
    pub(super) fn append(&mut self, next: &Self) {
        self.sweeps += next.sweeps;
        self.converged &= next.converged;
        self.most_sweeps = self.most_sweeps.max(next.most_sweeps);
        self.last_sweeps = next.last_sweeps;
        (self.error, self.strain, self.measured) = (next.error, next.strain, next.measured);
    }
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
