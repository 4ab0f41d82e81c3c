//! Tie rods: the rods of large cloth about a particle that something else is tied to, which are swept more often than the others.
//!
//! All that hangs on a rope hangs on the few rods at its end, and the particle there weighs next to nothing: a sweep, which hands a pull on by a rod or two, leaves to
//! those rods what it does not hand on. Of a hammock of 64 × 64 on four ropes they were off by 42 %, of cloth that is pinned there by 2 %. So those within two rods
//! of a tie, and the tie, have some sweeps of their own in each sweep of the cloth, as many as do not weigh: eight of a hundred rods in sixteen thousand. They ask for
//! nothing that the others do not ask for, and to and fro, so that none of them is always the last.

use glam::Vec4;

use super::rod_graph::RodGraph;
use super::rods::{Whole, project};
use super::turned_places::TurnedPlaces;

/// So many rods from a tie on are tie rods. Of the hammock above, by 2, 4 and 8, with eight sweeps: 11.7, 12.5 and 12.3 %.
const RINGS: usize = 2;

/// So often they are swept in a sweep. The same by 0, 8 and 32, of the four rings: 42, 12.5 and 6.7 %, in 1.7, 2.3 and 4.8 ms.
const SWEEPS: usize = 8;

/// But no more than this share of what a sweep of all rods is.
const SHARE: usize = 4;

/// The tie rods of an island. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct TieRods {
    /// Rows of the two ends, length, metres, and whether it may be shorter.
    rods: Vec<(u32, u32, f32, bool)>,
    /// How often they are swept in each sweep of the cloth.
    sweeps: usize,
    /// [Edits](crate::particles::Particles::edits) of the particles when they were found.
    pub(super) edits: u64,
}

impl TieRods {
    /// Of an island with such rods between its members, of which some, which ascend, are tied to another body.
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

    /// None, of an island that nothing is tied to.
    pub(super) fn none(edits: u64) -> Self {
        Self { edits, ..Self::default() }
    }

    /// How often they are swept.
    pub(super) fn sweeps(&self) -> usize {
        self.sweeps
    }

    /// Projects all of them once, from the first to the last or `back`. Returns the largest error found, metres.
    pub(super) fn project(&self, at: &mut TurnedPlaces, back: bool) -> f32 {
        let mut worst = 0.0_f32;
        let mut each = |&(a, b, rest, slackens): &(u32, u32, f32, bool)| {
            let ends = [at.get(a), at.get(b)];
            if slackens && (ends[0] - ends[1]).truncate().length_squared() <= rest * rest {
                return;
            }
            let [one, other] = [ends[0].to_array(), ends[1].to_array()];
            let (one, other, error, _) = project::<f32>(one, other, rest, Whole);
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
