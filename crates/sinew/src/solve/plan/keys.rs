//! Keys: where each constraint goes in a plan, as one number to sort by.

use super::GroupKind;
use crate::constraints::{Bound, ConstraintKind, Distance};

/// Where a constraint goes, and which it is. They are compared from the first field to the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    /// Island, rank, phase, cluster and colour.
    pub(super) group: u64,
    /// Place of its first particle in the island, so that neighbours in memory are neighbours in a group.
    pub(super) first: u32,
    /// Which one, in the order given.
    pub(super) number: u32,
}

/// The rank of distances: after the constraints that precede them.
pub(super) const DISTANCES: u32 = 32;
/// The rank of rods, after the rest of their island.
pub(super) const RODS: u32 = 33;
/// The rank of rigid shapes.
const RIGID: u32 = 34;

/// What the key of a group is made of, most significant first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fields {
    pub(super) island: u32,
    pub(super) rank: u32,
    pub(super) phase: u32,
    pub(super) cluster: u32,
    pub(super) colour: u32,
}

impl Fields {
    /// 32 bits for the island, then 6, 2, 12 and 12.
    pub(super) fn key(self) -> u64 {
        let low = ((self.rank << 2 | self.phase) << 12 | self.cluster) << 12 | self.colour;
        u64::from(self.island) << 32 | u64::from(low)
    }

    pub(super) fn of(key: u64) -> Self {
        let low = key as u32;
        let (rank, phase) = (low >> 26, low >> 24 & 3);
        let (cluster, colour) = (low >> 12 & 0xFFF, low & 0xFFF);
        Self { island: (key >> 32) as u32, rank, phase, cluster, colour }
    }

    /// Whether a key is of an island before that of a number.
    pub(super) fn is_before(key: u64, island: usize) -> bool {
        ((key >> 32) as usize) < island
    }

    /// What the keys of a cluster batch have in common: all but the colour.
    pub(super) fn cluster_batch(key: u64) -> u64 {
        key >> 12
    }

    pub(super) fn kind(self) -> GroupKind {
        match self.rank {
            DISTANCES => GroupKind::Distances,
            RODS => GroupKind::Rods,
            _ => GroupKind::Constraints,
        }
    }
}

/// Whether a distance is a hard one of equality, which the shortest kernels take.
pub(super) fn is_rod(d: &Distance) -> bool {
    d.softness.is_hard() && d.bound == Bound::Equal
}

/// Where distances stand in a sweep.
pub(super) fn rank_of(d: &Distance) -> u32 {
    if is_rod(d) { RODS } else { DISTANCES }
}

/// And other constraints.
pub(super) fn rank_of_kind(kind: &ConstraintKind) -> u32 {
    if matches!(kind, ConstraintKind::Rigid(_)) { RIGID } else { kind.rank() }
}
