//! Keys: the position of each constraint in a plan, as one number to sort by.

use super::GroupKind;
use crate::constraints::{Bound, ConstraintKind, Distance};

/// The position of a constraint in a plan, and its input index. Keys compare field by field, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    /// Island, rank, phase, cluster and colour.
    pub(super) group: u64,
    /// Member index of its first particle in the island, so that neighbours in memory are neighbours in a group.
    pub(super) first: u32,
    /// Input index.
    pub(super) number: u32,
}

/// The rank of distances: after all constraint kinds that precede them.
pub(super) const DISTANCES: u32 = 32;
/// The rank of rods: after all of their island but rigid shapes.
pub(super) const RODS: u32 = 33;
/// The rank of rigid shapes.
const RIGID: u32 = 34;

/// The components of a group's key, most significant first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fields {
    pub(super) island: u32,
    pub(super) rank: u32,
    pub(super) phase: u32,
    pub(super) cluster: u32,
    pub(super) colour: u32,
}

impl Fields {
    /// 32 bits for the island, then 6 for the rank, 2 for the phase, 12 for the cluster and 12 for the colour.
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

    /// Whether a key belongs to an island before island `island`.
    pub(super) fn is_before(key: u64, island: usize) -> bool {
        ((key >> 32) as usize) < island
    }

    /// The part of the key that is common to a cluster batch: all but the colour.
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

/// Whether a distance is a hard equality, which the shortest kernels solve.
pub(super) fn is_rod(d: &Distance) -> bool {
    d.softness.is_hard() && d.bound == Bound::Equal
}

/// The rank of a distance in a sweep.
pub(super) fn rank_of(d: &Distance) -> u32 {
    if is_rod(d) { RODS } else { DISTANCES }
}

/// The rank of another constraint in a sweep.
pub(super) fn rank_of_kind(kind: &ConstraintKind) -> u32 {
    if matches!(kind, ConstraintKind::Rigid(_)) { RIGID } else { kind.rank() }
}
