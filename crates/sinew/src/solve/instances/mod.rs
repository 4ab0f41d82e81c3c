//! Instance batches: bodies of the same topology, eight side by side, each in a lane of its own.
//!
//! A box of eight particles has too few constraints of a colour to fill eight lanes, and particles gathered for each of them and put back cost more
//! than the formula. Eight boxes have eight of everything. So their particles are turned into lanes once ([`LaneStorage`]), particle `i` of all of
//! them side by side, and each constraint of the body is then one operation in lanes: no colours needed, nothing gathered. Where a whole step is
//! taken at once they stay there for all its substeps.
//!
//! **What is beside a body must not matter**, nor whether it is in an instance batch at all: a lane has the bits that its body has alone. So the
//! constraints of a body are enforced in the order of its own plan, in which those of one colour may come in any order; formulas are those of eights
//! of one body; and a body that has converged is kept as it is while others go on. Which bodies make an instance batch may therefore depend on
//! anything; that it depends on the plan alone is for the sake of those who measure.
//!
//! - the [plan](super::plan::instance_batches) finds them when it is compiled;
//! - `lane_storage` is where their particles are meanwhile;
//! - `solve` sweeps them until each holds, `rods`, `chains` and the plan's [constraint batches](super::wide) are what it does, `surfaces` puts them out of
//!   planes and colliders, `convergence` is how it goes;
//! - `lane_compaction` lets those that take longer than the others of their batch go on together;
//! - `motion` predicts and derives, `momentum_drift` keeps round-off out of their momenta;
//! - `batch_solve` does all that, batch by batch;
//! - `measure` looks at what is left in the end.

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
