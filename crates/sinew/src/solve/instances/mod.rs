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
//! - `topology` finds them when a plan is compiled;
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
mod topology;

use core::ops::Range;

use super::wide::{InstancedConstraints, InstancedGroup};
use crate::lanes::LANES;

pub(crate) use batch_solve::{BatchMotion, BatchSolve, WholeStep};
use chains::InstancedLink;
pub(crate) use lane_compaction::LaneCompaction;
pub(crate) use lane_storage::{LaneParticles, LaneStorage};

/// Eight bodies of so many particles, with their velocities and all, fit into a core's first cache: 32 kB and a half. Larger ones have enough of each
/// colour to fill the lanes.
pub(crate) const MOST: usize = 64;
// What is solved side by side has the bits that it has alone.
const _: () = assert!(MOST <= super::chains::LONG);

/// The instance batches of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct InstanceBatches {
    all: Vec<InstanceBatch>,
    parts: Vec<InstancePart>,
    rods: Vec<InstancedRod>,
    chains: Vec<Range<usize>>,
    links: Vec<InstancedLink>,
    instanced: InstancedConstraints,
}

/// Three to eight consecutive islands that are built alike, whose rows follow each other.
#[derive(Clone, Debug)]
struct InstanceBatch {
    islands: Range<usize>,
    /// The first row of the first island, and how many each has.
    first: u32,
    members: u32,
    /// What a sweep consists of, in its order.
    parts: Range<usize>,
    /// The chains with which a sweep begins.
    chains: Range<usize>,
    /// How many constraints may have sums.
    multipliers: usize,
    /// Bodies of batches with the same number here are identical. `None` if those of this one are not.
    topology: Option<usize>,
}

/// Constraints of one kind that a sweep takes one after the other.
#[derive(Clone, Debug)]
enum InstancePart {
    /// Which of the instance batches' rods.
    Rods(Range<usize>),
    Constraints(InstancedGroup),
}

/// A hard rod of each of eight bodies, between particles of the same numbers.
#[derive(Clone, Copy, Debug)]
struct InstancedRod {
    a: u32,
    b: u32,
    rest: [f32; LANES],
}

impl InstanceBatches {
    /// Whether the last of some instance batches and the first of others are of the same bodies.
    pub(crate) fn have_same_topology(&self, some: Range<usize>, others: Range<usize>) -> bool {
        match (self.all[some].last(), self.all[others].first()) {
            (Some(last), Some(first)) => last.has_same_topology(first),
            _ => false,
        }
    }
}

impl InstanceBatch {
    /// All rows of its bodies.
    fn rows(&self) -> Range<u32> {
        self.first..self.first + self.islands.len() as u32 * self.members
    }

    /// Whether the bodies of both are the same in every number.
    fn has_same_topology(&self, other: &Self) -> bool {
        self.topology.is_some() && self.topology == other.topology
    }

    /// In which place, from that of row `begin` on, particle `i` of each body is. Lanes that are left have the last body again: it computes the same
    /// and writes the same.
    #[inline(always)]
    fn places(&self, begin: u32, i: u32) -> [u32; LANES] {
        let last = self.islands.len() as u32 - 1;
        let mut places = [0; LANES];
        for (place, lane) in places.iter_mut().zip(0..) {
            *place = self.first - begin + last.min(lane) * self.members + i;
        }
        places
    }
}
