//! Tie rods: the rods of large cloth near a particle that is tied to another body. They are swept more often than the others.
//!
//! Everything that hangs on a rope hangs on the few rods at its end, where the particle weighs next to nothing. A sweep propagates a pull by one or two rods
//! and leaves the rest of the error in these. In a hammock of 64 × 64 on four ropes they were off by 42 %, in cloth pinned at the same places by 2 %. So the
//! rods within two rods of a tie are swept several times in each sweep of the cloth. That costs little: eight sweeps of a hundred rods, of sixteen thousand.
//! They impose nothing that a full sweep does not. The direction alternates, so that no rod is always the last.

use glam::Vec4;

use super::mixed_places::MixedPlaces;
use super::rod_graph::RodGraph;
use super::rods::{FullCorrection, project};

/// Tie rods are those within this many rods of a tie. The hammock above is off by 11.7, 12.5 and 12.3 % with 2, 4 and 8, at eight sweeps.
const RINGS: usize = 2;

/// Sweeps over the tie rods in each sweep of the cloth. The same scene with four rings is off by 42, 12.5 and 6.7 % with 0, 8 and 32 sweeps, which take 1.7,
/// 2.3 and 4.8 ms.
const SWEEPS: usize = 8;

/// The tie rods may cost at most one part in this many of a sweep of all rods.
const SHARE: usize = 4;

/// The tie rods of an island. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct TieRods {
    /// Rows of the two ends, rest length in metres, and whether it may be shorter.
    rods: Vec<(u32, u32, f32, bool)>,
    /// Sweeps over them in each sweep of the cloth.
    sweeps: usize,
    /// [Edits](crate::particles::Particles::edits) of the particles when they were found.
    pub(super) edits: u64,
}

impl TieRods {
    /// The tie rods of an island with this graph of rods between its members. `tied` are the members tied to another body, ascending.
    pub(super) fn of(graph: &RodGraph, members: &[u32], mut tied: Vec<u32>, edits: u64) -> Self {
        let mut from = 0;
        let mut is_in = vec![false; members.len()];
        tied.iter().for_each(|&one| is_in[one as usize] = true);
        for _ in 0..RINGS {
            for place in core::mem::replace(&mut from, tied.len())..tied.len() {
                for rod in graph.rods_of(tied[place]) {
                    if !core::mem::replace(&mut is_in[rod.to as usize], true) {
                        tied.push(rod.to);
                    }
                }
            }
        }
        tied.sort_unstable();
        let is_in = &is_in[..];
        let row = |member: u32| members[member as usize];
        let within = tied.iter().flat_map(|&one| {
            let rods = graph.rods_of(one).iter();
            let rods = rods.filter(move |rod| rod.to > one && is_in[rod.to as usize]);
            rods.map(move |rod| (members[one as usize], row(rod.to), rod.rest, rod.slackens))
        });
        let rods: Vec<_> = within.collect();
        let most = graph.ends() / 2 / SHARE;
        let sweeps = SWEEPS.min(most / rods.len().max(1));
        Self { rods, sweeps, edits }
    }

    /// No tie rods, for an island that nothing is tied to.
    pub(super) fn none(edits: u64) -> Self {
        Self { edits, ..Self::default() }
    }

    /// Sweeps over them in each sweep of the cloth.
    pub(super) fn sweeps(&self) -> usize {
        self.sweeps
    }

    /// Projects all of them once, from the first to the last or, with `back`, from the last to the first. Returns the largest error found, metres.
    pub(super) fn project(&self, at: &mut MixedPlaces, back: bool) -> f32 {
        let mut worst = 0.0_f32;
        let mut each = |&(a, b, rest, slackens): &(u32, u32, f32, bool)| {
            let ends = [at.get(a), at.get(b)];
            if slackens && (ends[0] - ends[1]).truncate().length_squared() <= rest * rest {
                return;
            }
            let [one, other] = [ends[0].to_array(), ends[1].to_array()];
            let (one, other, error, _) = project::<f32>(one, other, rest, FullCorrection);
            at.set(a, Vec4::from_array(one));
            at.set(b, Vec4::from_array(other));
            worst = worst.max(error);
        };
        if back {
            self.rods.iter().rev().for_each(&mut each);
        } else {
            self.rods.iter().for_each(&mut each);
        }
        worst
    }
}
