//! What a thread needs while it solves, and keeps the memory of.

use glam::Vec4;

use super::chains::ChainScratch;
use super::constraint_ref::{ConstraintRef, Local};
use super::instances::{LaneCompaction, LaneParticles};
use super::jacobi::Asked;
use super::momentum::MomentumDrift;
use super::most_violated_first::Queue;
use super::plan::Task;
use super::remaining::Remaining;
use super::strain_limit::StrainScratch;
use super::wavefront::Wavefront;
use crate::integrate::StepRows;
use crate::lanes::Columns;

/// What a thread needs while it solves. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct ThreadScratch {
    pub(super) local: Local,
    pub(super) columns: Columns,
    /// Where the pins of an island are that has tethers.
    pub(super) pins: Vec<Vec4>,
    pub(super) chains: ChainScratch,
    pub(super) constraint_refs: Vec<ConstraintRef>,
    pub(super) asked: Asked,
    pub(super) queue: Queue,
    pub(super) lane_compaction: LaneCompaction,
    /// Of measuring them.
    pub(super) lane_particles: Vec<LaneParticles>,
    /// What is left of a task beside its instance batches.
    pub(super) remaining: Remaining,
    /// Where a large island is meanwhile.
    pub(super) wavefront: Wavefront,
    /// Rows of a task by how they step.
    pub(super) step_rows: Vec<StepRows>,
    pub(super) microsteps: MicrostepScratch,
    /// Islands whose corrections gave them what has to be taken off again.
    pub(super) momentum_drifts: Vec<(u32, MomentumDrift)>,
}

impl ThreadScratch {
    /// For looking at constraints one by one.
    pub(super) fn constraints(&mut self) -> (&mut Local, &mut Vec<ConstraintRef>) {
        (&mut self.local, &mut self.constraint_refs)
    }

    /// Begins with a task.
    pub(super) fn begin(&mut self, task: &Task) {
        self.remaining.reset(task);
        self.momentum_drifts.clear();
    }
}

/// What taking microsteps needs. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct MicrostepScratch {
    /// Where each particle was when the substep began.
    pub(super) start: Vec<Vec4>,
    /// The places of pinned particles that are led, and where to.
    pub(super) led: Vec<(usize, Vec4)>,
    /// How far a relaxation moved each particle.
    pub(super) moved: Vec<Vec4>,
    pub(super) strain: StrainScratch,
}
