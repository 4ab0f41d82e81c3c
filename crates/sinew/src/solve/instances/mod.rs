//! Instance batches: bodies of the same topology, solved eight at a time, one body in each lane.
//!
//! A box of eight particles has too few constraints of a colour to fill eight lanes, and gathering and scattering particles for each constraint costs more than
//! the formula. Eight boxes have eight of everything. So their particles are transposed once into [`LaneStorage`], particle `i` of all eight side by side. Each
//! constraint of the body is then one operation on lanes, without colours and without gathering. If a whole step is taken at once, the particles stay there for
//! all its substeps.
//!
//! **The result must not depend on the other lanes**, nor on whether a body is in a batch at all: a lane computes the same bits as its body alone. So the
//! constraints of a body are projected in the order of its own plan, in which those of one colour may come in any order; the formulas are those of the
//! eight-wide kernels for a single body; and a body that has converged is kept unchanged while others go on. Which bodies form a batch is therefore free to
//! choose. It depends on the plan alone so that timings are reproducible.
//!
//! - The [plan](super::plan::instance_batches) finds the batches when it is compiled.
//! - `lane_storage` holds their particles meanwhile.
//! - `solve` sweeps a storage until each body has converged. A sweep consists of `rods`, `chains` and the plan's [constraint batches](super::wide), then of
//!   `surfaces`, which projects particles out of planes and colliders. `convergence` is its state.
//! - `lane_compaction` collects the bodies that take longer than the others of their batch.
//! - `motion` predicts positions. `momentum_drift` derives velocities and removes the momentum that round-off added.
//! - `batch_solve` runs all of this, batch by batch.
//! - `measure` measures the errors that remain in the end.

mod batch_solve;
mod chains;
mod convergence;
mod lane_compaction;
mod lane_storage;
mod measure;
mod momentum_drift;
mod motion;
mod rods;
mod solve;
mod surfaces;
#[cfg(test)]
mod tests;

pub(crate) use batch_solve::{BatchMotion, BatchScratch, BatchSolve, WholeStep};
pub(crate) use lane_compaction::LaneCompaction;
use lane_storage::LaneStorage;
