//! Tethers (long range attachments; Kim, Chentanez, Müller, *Long Range Attachments: A Method to Simulate Inextensible Clothing in Computer Games*, 2012):
//! what hangs on a pin through many rods is held at once to no more than the way through them.
//!
//! A sweep hands a pull on by some rods, and a thread of N pieces under an acceleration `a` is stretched by about `N a h²` in one sweep of a substep.
//! A tether is the bound that those rods imply together: a particle is no farther from its pin than the shortest way along the cloth. It asks for nothing
//! that the rods do not ask for, so what is solved to the end is the same with and without, and it takes one projection where the rods take N sweeps.
//! As its other end does not move, tethers need no colours.
//!
//! They follow from the rods and from what is pinned, and from nothing else: nobody adds them, nothing saves them, and a tear or an unpinned corner has
//! others in the same step. Each particle has up to two: to the pin nearest to it, and to the farthest of two pins that are far from each other. A flag's
//! outer end hangs by its upper corner as well as by the pin at its own height.
//!
//! Small islands are held once in a substep, and large ones before each sweep of it; large grid cloth, which has [spans](spans), after each sweep, too.
//!
//! Without them a hanging rope is stretched by the square of the substep. It then is a spring that is the stiffer the shorter the substep is, and where
//! the length of the step changes that pumps: of 20 pieces, or of 5 with a load, it came to the most speed in ticks of 1/120 and 1/60 s in turn.
//!
//! Between particles that are all free, [spans](spans) do the same at a smaller scale.

mod geodesic;
mod pin_fields;
mod project;
mod spans;
#[cfg(test)]
mod tests;

use core::ops::Range;

use glam::Vec4;

use super::rod_graph::RodGraph;
use super::tie_rods::TieRods;
use crate::islands::Island;
use crate::lanes::LANES;
use crate::particles::Places;
pub(super) use pin_fields::PinFields;
pub(super) use project::hold;
use project::hold_one;
pub(super) use spans::Spans;

/// An island of no more particles has no tethers where everything walks to rest: by tethers a rope between two pins still moved by micrometres after 20 000 such steps.
const SMALL_IN_STATICS: usize = 64;

/// The tethers of a plan. Derived from its rods and the pins; scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tethers {
    pub(in crate::solve) islands: Vec<IslandTethers>,
    pub(in crate::solve) spans: Vec<Spans>,
    /// The hard rods of islands that take microsteps: for tethers, and for strain limiting.
    pub(in crate::solve) graphs: Vec<RodGraph>,
    /// What is tied to them.
    pub(in crate::solve) tie_rods: Vec<TieRods>,
    /// Whether the plan was compiled since they were made.
    pub(in crate::solve) stale: bool,
}

/// Those of one island.
#[derive(Clone, Debug, Default)]
pub(crate) struct IslandTethers {
    /// A hash of the rods and of what is pinned. The same rods of another island, or of this one in another plan, have the same.
    pub(in crate::solve) key: u64,
    /// The rows of its pinned particles, ascending.
    pub(in crate::solve) pins: Vec<u32>,
    /// How far its members are from those. None of what was found to be like another island.
    pub(in crate::solve) fields: Option<PinFields>,
    /// Of each member, to which of the pins, and how long, metres; infinite without.
    pub(in crate::solve) each: Vec<[(u32, f32); 2]>,
    /// Whether any member has a first one, and whether any has a second one.
    are_there: [bool; 2],
    pub(in crate::solve) blocks: Vec<TetherBlock>,
    /// Along which rods they are, where that is asked for.
    pub(in crate::solve) ways: Option<TetherPaths>,
}

/// The ways of tethers along rods: to the nearest pin, and to either of two that are far from each other.
#[derive(Clone, Debug)]
pub(in crate::solve) struct TetherPaths {
    /// Which of the pins those two are.
    pub(in crate::solve) far: [u32; 2],
    /// Of each of the three, all members from the farthest on: which one, the one before it on its way, and the plan's number of the rod between.
    pub(in crate::solve) inwards: [Vec<(u32, u32, u32)>; 3],
}

/// Tethers of eight members, each the second after the one before: as columns have them side by side.
#[derive(Clone, Debug)]
pub(in crate::solve) struct TetherBlock {
    /// The first of the members, counted from that of the island.
    member: u32,
    /// Their rows. Where there are fewer than eight, the first again.
    rows: [u32; LANES],
    /// To which of the island's pins, and whether that is one for all.
    pins: [u32; LANES],
    one_pin: bool,
    /// Metres; infinite where there is none.
    length: [f32; LANES],
}

impl Tethers {
    /// The plan has been compiled.
    pub(super) fn expire(&mut self) {
        self.stale = true;
    }

    /// Those by which an island is to be solved, if it has any.
    pub(super) fn of(&self, island: &Island) -> Option<&IslandTethers> {
        let settings = &island.settings;
        let walks = settings.statics && island.members.len() <= SMALL_IN_STATICS;
        let wanted = settings.long_range && !walks;
        self.made(island).filter(|own| wanted && !own.blocks.is_empty())
    }

    /// The spans by which an island is to be solved, if it has any.
    pub(super) fn spans_of(&self, island: &Island) -> Option<&Spans> {
        let wanted = island.settings.long_range && island.microsteps > 1;
        let own = self.spans.get(island.spans? as usize);
        own.filter(|own| wanted && !own.is_empty())
    }

    /// The hard rods of an island that takes microsteps, between its members.
    pub(super) fn graph_of(&self, island: &Island) -> Option<&RodGraph> {
        self.graphs.get(island.rod_graph? as usize)
    }

    /// The tie rods of an island that takes microsteps.
    pub(super) fn tie_rods_of(&self, island: &Island) -> Option<&TieRods> {
        let own = self.tie_rods.get(island.tie_rods? as usize);
        own.filter(|own| island.microsteps > 1 && own.sweeps() > 0)
    }

    pub(in crate::solve) fn made(&self, island: &Island) -> Option<&IslandTethers> {
        self.islands.get(island.tethers? as usize)
    }
}

/// How long a tether of a way of so many metres is: rounded up, for it must not ask for more than the rods do.
fn taut(length: f64) -> f32 {
    (length * (1.0 + 1e-6)) as f32
}

impl IslandTethers {
    /// Of an island of such members, of which a run may be in columns: the hash of its rods and pins, and those; how far its members are from them, if that was reckoned; and to which of the pins
    /// each is tied, and how long, metres; infinite without.
    pub(super) fn of(
        (members, run): (&[u32], Range<usize>),
        (key, pins): (u64, Vec<u32>),
        fields: Option<PinFields>,
        each: Vec<[(u32, f32); 2]>,
    ) -> Self {
        let are_there = [0, 1].map(|which| each.iter().any(|own| own[which].1.is_finite()));
        let sections = [0..run.start, run.clone(), run.end..members.len()];
        let blocks = sections.into_iter().flat_map(|own| blocks(members, &each, own)).collect();
        Self { key, pins, fields, each, are_there, blocks, ways: None }
    }

    /// Where its pins are, in columns that begin with the row `first`.
    pub(super) fn pins(&self, position: &[Vec4], first: u32) -> impl Iterator<Item = Vec4> {
        self.pins.iter().map(move |row| position[(row - first) as usize])
    }

    /// The tethers of a member: where its pin is, in columns that begin with the row `first`, and how long each is, metres; infinite without.
    pub(super) fn of_member(&self, member: usize, position: &[Vec4], first: u32) -> [Vec4; 2] {
        let [near, far] = self.each[member];
        let tether = |(pin, length): (u32, f32)| {
            let row = self.pins.get(pin as usize).map_or(first, |row| *row);
            position[(row - first) as usize].truncate().extend(length)
        };
        [tether(near), tether(far)]
    }

    /// Whether any member has a first one, and whether any has a second one.
    pub(super) fn are_there(&self) -> [bool; 2] {
        self.are_there
    }

    /// Whether another island has the same tethers, to pins of the same places among its members.
    pub(super) fn are_like(&self, other: &Self) -> bool {
        self.key == other.key
    }

    /// The rows of the pins.
    pub(super) fn pin_rows(&self) -> &[u32] {
        &self.pins
    }

    /// Of each member, to which of the pins its tethers are, and how long, metres; infinite without.
    pub(super) fn each(&self) -> &[[(u32, f32); 2]] {
        &self.each
    }

    /// Puts the members that are too far from their pins where they may be, one after the other, and adds what that took to what their tethers did, kg·m.
    /// Returns how far out the farthest was, metres.
    pub(super) fn project_noting(
        &self,
        places: &mut Places,
        members: &[u32],
        pins: &[Vec4],
        did: &mut [[f64; 2]],
    ) -> f32 {
        let mut worst = 0.0_f32;
        for ((&row, tethers), did) in members.iter().zip(&self.each).zip(did) {
            for (&(pin, length), did) in tethers.iter().zip(did) {
                let q = &mut places.position[(row - places.first) as usize];
                let far = hold_one(q, pins[pin as usize], length);
                if far > 0.0 {
                    *did += f64::from(far) / f64::from(q.w);
                    worst = worst.max(far);
                }
            }
        }
        worst
    }

    /// Puts a member where its tethers let it be, in positions that begin with the row `first`; returns whether it was elsewhere.
    pub(super) fn hold_member(&self, member: usize, position: &mut [Vec4], first: u32) -> bool {
        let pins = self.of_member(member, position, first);
        let out = pins.map(|pin| hold_one(&mut position[member], pin, pin.w));
        out.into_iter().any(|far| far > 0.0)
    }

    /// Hands what the tethers of each member did, kg·m, on to the rods on their ways: each is told what it would have borne.
    pub(super) fn hand_on(
        &self,
        did: &[[f64; 2]],
        carried: &mut Vec<f64>,
        mut bears: impl FnMut(u32, f64),
    ) {
        let Some(ways) = &self.ways else { return };
        for (which, inwards) in ways.inwards.iter().enumerate() {
            carried.clear();
            carried.extend(did.iter().zip(&self.each).map(|(did, tethers)| match which {
                0 => did[0],
                _ => {
                    let far = ways.far[which - 1];
                    // Both may be one and the same.
                    let first = which == 1 || ways.far[0] != far;
                    if first && tethers[1].0 == far { did[1] } else { 0.0 }
                }
            }));
            for &(member, before, rod) in inwards {
                let force = carried[member as usize];
                if force != 0.0 {
                    bears(rod, force);
                    carried[before as usize] += force;
                }
            }
        }
    }

    /// The blocks of some members, of which the first and the end are multiples of 16 from where a section begins.
    fn among(&self, members: &Range<usize>) -> &[TetherBlock] {
        &self.blocks[self.places_among(members)]
    }

    fn places_among(&self, members: &Range<usize>) -> Range<usize> {
        let place = |end: usize| self.blocks.partition_point(|block| (block.member as usize) < end);
        place(members.start)..place(members.end)
    }
}

/// Puts the tethers of a section of members eight by eight: first those to the nearest pins, then the others.
fn blocks(members: &[u32], each: &[[(u32, f32); 2]], section: Range<usize>) -> Vec<TetherBlock> {
    let mut blocks = Vec::new();
    // Without a pin there is none.
    let section = if each.is_empty() { 0..0 } else { section };
    for begin in section.clone().step_by(2 * LANES) {
        for (which, parity) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let member = |lane: usize| {
                let member = begin + parity + 2 * lane;
                if member < section.end { member } else { begin + parity }
            };
            if begin + parity >= section.end {
                continue;
            }
            let of = |lane: usize| each[member(lane)][which];
            if (0..LANES).all(|lane| of(lane).1 == f32::INFINITY) {
                continue;
            }
            let pin = of(0).0;
            blocks.push(TetherBlock {
                member: (begin + parity) as u32,
                rows: core::array::from_fn(|lane| members[member(lane)]),
                pins: core::array::from_fn(|lane| of(lane).0),
                one_pin: (0..LANES).all(|lane| of(lane).0 == pin),
                length: core::array::from_fn(|lane| of(lane).1),
            });
        }
    }
    blocks
}
