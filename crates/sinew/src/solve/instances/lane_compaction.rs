//! Lane compaction: instance batches of identical bodies are solved together, and bodies may change lanes.
//!
//! Of eight bodies that lie about, most hold after a sweep or two, and one that has just landed on its elbow spends all of its sweeps: seven lanes
//! would go on for the sake of that one. So as soon as one body of a batch has converged, the others wait for a lane of another storage, the
//! compacted one, where they go on together with those of other batches; a lane that converges is given to the next. A lane has the bits that its
//! body has alone, whatever is beside it, so nothing depends on which bodies were compacted together.

use super::lane_storage::LaneStorage;
use super::solve::BatchContext;
use crate::collide::NormalImpulses;
use crate::lanes::LANES;

/// Lane storage of instance batches that are solved together. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct LaneCompaction {
    /// One for each batch, and more, which are kept for their memory.
    storages: Vec<LaneStorage>,
    instance_batches: usize,
    /// Those that wait for a lane of the compacted storage.
    waiting: Vec<LanePlace>,
    compacted: LaneStorage,
    /// Whose bodies are in its lanes.
    lane_owners: [Option<LanePlace>; LANES],
}

/// A lane of a lane storage.
#[derive(Clone, Copy, Debug)]
struct LanePlace {
    storage: usize,
    lane: usize,
}

impl LaneCompaction {
    /// Makes room for so many instance batches.
    pub(super) fn make_room(&mut self, instance_batches: usize) {
        self.instance_batches = instance_batches;
        if self.storages.len() < instance_batches {
            self.storages.resize_with(instance_batches, LaneStorage::default);
        }
    }

    /// The lane storages of its instance batches.
    pub(super) fn storages(&mut self) -> &mut [LaneStorage] {
        &mut self.storages[..self.instance_batches]
    }

    /// Solves all lane storages, which have been predicted.
    pub(super) fn solve(&mut self, context: &BatchContext, normal_impulses: &mut NormalImpulses) {
        for storage in self.storages() {
            context.begin(storage);
        }
        self.compacted.clear_as(&self.storages[0]);
        let mut turn = 0;
        while let Some((storage, may_leave)) = self.take_turn(turn) {
            // Who touches surfaces by rows of his own stays: what is known of those is known of his own lanes.
            let may_leave =
                may_leave && !context.surfaces.is_some_and(|surfaces| surfaces.touches(storage));
            // While others wait for a lane, as soon as one is free is soon enough.
            let few = if may_leave { LANES as u32 - 1 } else { 0 };
            context.sweep(storage, normal_impulses, few);
            turn += 1;
        }
    }

    /// The lane storage to be swept next, and whether a lane that gets free in it is of use: one batch after the other, then the compacted storage
    /// until none waits.
    fn take_turn(&mut self, turn: usize) -> Option<(&mut LaneStorage, bool)> {
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
                storages[place.storage].take_back(place.lane, compacted, lane);
            }
            *owner = waiting.pop();
            if let Some(place) = owner {
                compacted.admit(lane, &storages[place.storage], place.lane);
            }
        }
        (compacted.convergence.going != 0).then_some((compacted, !waiting.is_empty()))
    }
}
