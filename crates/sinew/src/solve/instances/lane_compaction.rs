//! Lane compaction: batches of identical bodies are solved together, and bodies that have not converged are moved into common lanes.
//!
//! Of eight bodies lying about, most converge after a sweep or two, while one that has just landed on its elbow uses up all of its sweeps; seven lanes would go
//! on for that one body alone. So as soon as one body of a batch has converged, the others of the batch are queued for a lane of another storage, the compacted
//! one, where they continue beside bodies of other batches. A lane that converges there is given to the next body in the queue. A lane computes the same bits
//! as its body alone, whatever is in the other lanes, so the result does not depend on which bodies were compacted together.

use super::lane_storage::LaneStorage;
use super::solve::BatchContext;
use crate::collide::NormalImpulses;
use crate::lanes::LANES;

/// Lane storages of instance batches that are solved together. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct LaneCompaction {
    /// One for each batch. Surplus ones are kept for their memory.
    storages: Vec<LaneStorage>,
    instance_batches: usize,
    /// Bodies that are queued for a lane of the compacted storage.
    waiting: Vec<LanePlace>,
    compacted: LaneStorage,
    /// Where the body in each lane of the compacted storage came from.
    lane_owners: [Option<LanePlace>; LANES],
}

/// A lane of one of the storages.
#[derive(Clone, Copy, Debug)]
struct LanePlace {
    storage: usize,
    lane: usize,
}

impl LaneCompaction {
    /// Makes room for a number of instance batches.
    pub(super) fn make_room(&mut self, instance_batches: usize) {
        self.instance_batches = instance_batches;
        if self.storages.len() < instance_batches {
            self.storages.resize_with(instance_batches, LaneStorage::default);
        }
    }

    /// The lane storages of the current instance batches.
    pub(super) fn storages(&mut self) -> &mut [LaneStorage] {
        &mut self.storages[..self.instance_batches]
    }

    /// Solves all lane storages, which have already been predicted.
    pub(super) fn solve(&mut self, context: &BatchContext, normal_impulses: &mut NormalImpulses) {
        for storage in self.storages() {
            context.begin(storage);
        }
        self.compacted.clear_like(&self.storages[0]);
        let mut turn = 0;
        while let Some((storage, may_leave)) = self.next_storage(turn) {
            // Bodies with rows that may touch surfaces keep their lanes: what contacts read of a row, velocities included, is only complete there.
            let may_leave =
                may_leave && !context.surfaces.is_some_and(|surfaces| surfaces.touches(storage));
            // While bodies are queued, the sweeps stop as soon as one lane is free.
            let few = if may_leave { LANES as u32 - 1 } else { 0 };
            context.sweep(storage, normal_impulses, few);
            turn += 1;
        }
    }

    /// The lane storage to sweep next, and whether freeing a lane in it is useful. Visits one batch after the other, then the compacted storage until its queue
    /// is empty and its lanes have converged.
    fn next_storage(&mut self, turn: usize) -> Option<(&mut LaneStorage, bool)> {
        let Self { storages, instance_batches, waiting, compacted, lane_owners } = self;
        let storages = &mut storages[..*instance_batches];
        if let Some(storage) = turn.checked_sub(1).filter(|&storage| storage < storages.len()) {
            let left = (0..storages[storage].bodies)
                .filter(|&lane| storages[storage].convergence.is_going(lane));
            waiting.extend(left.map(|lane| LanePlace { storage, lane }));
        }
        if turn < storages.len() {
            let are_others = storages.len() > 1;
            return Some((&mut storages[turn], are_others));
        }
        for (lane, owner) in lane_owners.iter_mut().enumerate() {
            if compacted.convergence.is_going(lane) {
                continue;
            }
            if let Some(place) = owner.take() {
                storages[place.storage].copy_back(place.lane, compacted, lane);
            }
            *owner = waiting.pop();
            if let Some(place) = owner {
                compacted.copy_body(lane, &storages[place.storage], place.lane);
            }
        }
        (compacted.convergence.going != 0).then_some((compacted, !waiting.is_empty()))
    }
}
