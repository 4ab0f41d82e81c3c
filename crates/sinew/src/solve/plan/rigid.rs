//! Islands that are nothing but one rigid body: rods connect all of its particles pairwise at the distances of its collider, and there are no other
//! constraints.

use glam::Vec3;

use super::{GroupKind, Plan};
use crate::collide::BodyCollider;
use crate::constraints::Distance;
use crate::islands::Island;

/// Greatest number of particles of such an island: its connectivity is stored as one bit per pair in a `u64` per particle.
const MAX_PARTICLES: usize = 64;

/// Greatest difference between a rod's length and the distance of its ends in the collider, as a share of the latter.
const TOLERANCE: f32 = 1e-5;

impl Plan {
    /// Whether an island consists of the particles of a body collider, connected pairwise by rods of the collider's distances, and has no other constraints.
    pub(crate) fn is_rigid_body_of(&self, collider: &BodyCollider, island: &Island) -> bool {
        let members = &self.islands.members[island.members.clone()];
        let groups = &self.groups[island.groups.clone()];
        let (Some(&first), Some(&last), count) = (members.first(), members.last(), members.len())
        else {
            return false;
        };
        if count != collider.rows.len()
            || count > MAX_PARTICLES
            || (last - first) as usize + 1 != count
            || !collider.rows.iter().all(|row| (first..=last).contains(row))
            || groups.iter().any(|group| group.kind != GroupKind::Rods)
        {
            return false;
        }
        let mut rest = [Vec3::ZERO; MAX_PARTICLES];
        for (&row, &place) in collider.rows.iter().zip(&*collider.rest) {
            rest[(row - first) as usize] = place;
        }
        let mut tied = [0_u64; MAX_PARTICLES];
        let mut holds = |d: &Distance| {
            let (a, b) = ((d.a - first) as usize, (d.b - first) as usize);
            tied[a] |= 1 << b;
            tied[b] |= 1 << a;
            let apart = (rest[a].as_dvec3() - rest[b].as_dvec3()).length() as f32;
            (d.rest - apart).abs() <= TOLERANCE * apart
        };
        let rods = groups.iter().flat_map(|group| &self.distances[group.range.clone()]);
        let fit = rods.fold(true, |fit, d| holds(d) & fit);
        let all = u64::MAX >> (MAX_PARTICLES - count);
        fit && tied[..count].iter().enumerate().all(|(i, &others)| others | 1 << i == all)
    }
}
