//! Tethers (long range attachments; Kim, Chentanez, Müller, *Long Range Attachments: A Method to Simulate Inextensible Clothing in Computer Games*, 2012): a
//! particle that hangs on a pin through many rods is kept directly within the length of the path through them.
//!
//! A sweep propagates a pull by a few rods only, and a thread of N pieces under an acceleration `a` is stretched by about `N a h²` in one sweep of a substep. A
//! tether is the bound that those rods imply together: a particle is no farther from its pin than the shortest path along the cloth. It requires nothing that
//! the rods do not require, so the converged solution is the same with and without it, and one projection replaces N sweeps of the rods. As its other end does
//! not move, tethers need no colours.
//!
//! Tethers are derived from the rods and the pins alone: they are neither added by a user nor saved, and after a tear or an unpinned corner they change in the
//! same step. Each particle has up to two: to the nearest pin, and to the farther of two pins that are far from each other. The outer end of a flag thus hangs
//! by its upper corner as well as by the pin at its own height.
//!
//! Small islands apply tethers once in a substep, large ones before each sweep; large grid cloth, which has [spans](spans), after each sweep, too.
//!
//! Without tethers a hanging rope stretches in proportion to the square of the substep. It acts as a spring that is stiffer the shorter the substep is, and
//! where the length of the step varies this pumps in energy: a rope of 20 pieces, or of 5 with a load, reached the speed limit in alternating ticks of 1/120
//! and 1/60 s.
//!
//! Between particles that are all free, [spans](spans) do the same on a smaller scale.

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
use project::hold_one;
pub(super) use project::project_tether;
pub(super) use spans::Spans;

/// Statics islands of no more particles have no tethers: with them, a rope between two pins still moved by micrometres after 20 000 such steps.
const SMALL_IN_STATICS: usize = 64;

/// The tethers of a plan. Derived from its rods and the pins; scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tethers {
    pub(in crate::solve) islands: Vec<IslandTethers>,
    pub(in crate::solve) spans: Vec<Spans>,
    /// The hard rods of islands that take microsteps: for tethers, and for strain limiting.
    pub(in crate::solve) graphs: Vec<RodGraph>,
    /// Their rods near ties to other bodies, which are swept more often.
    pub(in crate::solve) tie_rods: Vec<TieRods>,
    /// Whether the plan was compiled since they were computed.
    pub(in crate::solve) stale: bool,
}

/// The tethers of one island.
#[derive(Clone, Debug, Default)]
pub(crate) struct IslandTethers {
    /// A hash of the rods and of the pins. Equal for the same rods in another island, or in this one in another plan.
    pub(in crate::solve) key: u64,
    /// The rows of its pinned particles, ascending.
    pub(in crate::solve) pins: Vec<u32>,
    /// Distances of its members from the pins. `None` without pins, and where the lengths were copied from an identical island.
    pub(in crate::solve) fields: Option<PinFields>,
    /// For each member the index of the pin and the length of both tethers, metres; infinite where there is none.
    pub(in crate::solve) each: Vec<[(u32, f32); 2]>,
    /// Whether any member has a first tether, and whether any has a second one.
    has_tethers: [bool; 2],
    pub(in crate::solve) blocks: Vec<TetherBlock>,
    /// The paths of the tethers along rods, where loads are measured.
    pub(in crate::solve) paths: Option<TetherPaths>,
}

/// The paths of tethers along rods: to the nearest pin, and to each of two that are far from each other.
#[derive(Clone, Debug)]
pub(in crate::solve) struct TetherPaths {
    /// Indices of those two pins.
    pub(in crate::solve) far: [u32; 2],
    /// For each of the three, all members from the farthest on: the member, the previous one on its path, and the plan's index of the rod between them.
    pub(in crate::solve) inwards: [Vec<(u32, u32, u32)>; 3],
}

/// Tethers of eight members, every second one, which are neighbours in a column.
#[derive(Clone, Debug)]
pub(in crate::solve) struct TetherBlock {
    /// The first member, counted from the island's first.
    member: u32,
    /// Their rows. Unused lanes repeat the first.
    rows: [u32; LANES],
    /// Indices of their pins among the island's, and whether all are the same.
    pins: [u32; LANES],
    one_pin: bool,
    /// Metres; infinite where there is none.
    length: [f32; LANES],
}

impl Tethers {
    /// Marks all tethers as out of date, after the plan was compiled.
    pub(super) fn mark_stale(&mut self) {
        self.stale = true;
    }

    /// The tethers by which an island is to be solved, if any.
    pub(super) fn of(&self, island: &Island) -> Option<&IslandTethers> {
        let settings = &island.settings;
        let is_small_statics = settings.statics && island.members.len() <= SMALL_IN_STATICS;
        let wanted = island.has_long_range() && !is_small_statics;
        self.made(island).filter(|own| wanted && !own.blocks.is_empty())
    }

    /// The spans by which an island is to be solved, if any.
    pub(super) fn spans_of(&self, island: &Island) -> Option<&Spans> {
        let wanted = island.has_long_range() && island.microsteps > 1;
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

/// The length of a tether for a path of this many metres: rounded up, since it must not require more than the rods do.
fn tether_length(length: f64) -> f32 {
    (length * (1.0 + 1e-6)) as f32
}

impl IslandTethers {
    /// The tethers of an island with these `members`, of which `run` may be in columns. `key` is the hash of its rods and pins; `fields` are the distances from
    /// the pins, if they were computed; `each` holds the index of the pin and the length, metres, of both tethers of each member; infinite where there is none.
    pub(super) fn of(
        (members, run): (&[u32], Range<usize>),
        (key, pins): (u64, Vec<u32>),
        fields: Option<PinFields>,
        each: Vec<[(u32, f32); 2]>,
    ) -> Self {
        let has_tethers = [0, 1].map(|which| each.iter().any(|own| own[which].1.is_finite()));
        let sections = [0..run.start, run.clone(), run.end..members.len()];
        let blocks = sections.into_iter().flat_map(|own| blocks(members, &each, own)).collect();
        Self { key, pins, fields, each, has_tethers, blocks, paths: None }
    }

    /// Positions of its pins, in an array that begins with row `first`.
    pub(super) fn pins(&self, position: &[Vec4], first: u32) -> impl Iterator<Item = Vec4> {
        self.pins.iter().map(move |row| position[(row - first) as usize])
    }

    /// The tethers of a member: the position of the pin, in an array that begins with row `first`, and the length in `w`, metres; infinite where there is none.
    pub(super) fn of_member(&self, member: usize, position: &[Vec4], first: u32) -> [Vec4; 2] {
        let [near, far] = self.each[member];
        let tether = |(pin, length): (u32, f32)| {
            let row = self.pins.get(pin as usize).map_or(first, |row| *row);
            position[(row - first) as usize].truncate().extend(length)
        };
        [tether(near), tether(far)]
    }

    /// Whether any member has a first tether, and whether any has a second one.
    pub(super) fn has_tethers(&self) -> [bool; 2] {
        self.has_tethers
    }

    /// Whether another island has the same tethers, to pins of the same member indices.
    pub(super) fn is_same_as(&self, other: &Self) -> bool {
        self.key == other.key
    }

    /// The rows of the pins.
    pub(super) fn pin_rows(&self) -> &[u32] {
        &self.pins
    }

    /// For each member the index of the pin and the length of both tethers, metres; infinite where there is none.
    pub(super) fn each(&self) -> &[[(u32, f32); 2]] {
        &self.each
    }

    /// Moves members that are too far from their pins to the allowed distance, one after the other, and adds the impulse of each tether times the substep to
    /// `did`, kg·m. Returns the largest excess found, metres.
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

    /// Moves a member to the distance that its tethers allow, in positions that begin with row `first`; returns whether it was farther away.
    pub(super) fn hold_member(&self, member: usize, position: &mut [Vec4], first: u32) -> bool {
        let pins = self.of_member(member, position, first);
        let out = pins.map(|pin| hold_one(&mut position[member], pin, pin.w));
        out.into_iter().any(|far| far > 0.0)
    }

    /// Distributes what the tethers of each member did, kg·m, to the rods on their paths: `add_load` is called with each rod and what it would have carried.
    pub(super) fn distribute(
        &self,
        did: &[[f64; 2]],
        carried: &mut Vec<f64>,
        mut add_load: impl FnMut(u32, f64),
    ) {
        let Some(paths) = &self.paths else { return };
        for (which, inwards) in paths.inwards.iter().enumerate() {
            carried.clear();
            carried.extend(did.iter().zip(&self.each).map(|(did, tethers)| match which {
                0 => did[0],
                _ => {
                    let far = paths.far[which - 1];
                    // Both pins may be the same one.
                    let first = which == 1 || paths.far[0] != far;
                    if first && tethers[1].0 == far { did[1] } else { 0.0 }
                }
            }));
            for &(member, before, rod) in inwards {
                let force = carried[member as usize];
                if force != 0.0 {
                    add_load(rod, force);
                    carried[before as usize] += force;
                }
            }
        }
    }

    /// The blocks of some members, whose start and end are multiples of 16 from the beginning of a section.
    fn among(&self, members: &Range<usize>) -> &[TetherBlock] {
        &self.blocks[self.places_among(members)]
    }

    fn places_among(&self, members: &Range<usize>) -> Range<usize> {
        let place = |end: usize| self.blocks.partition_point(|block| (block.member as usize) < end);
        place(members.start)..place(members.end)
    }
}

/// Packs the tethers of a section of members in eights: first those to the nearest pins, then the others.
fn blocks(members: &[u32], each: &[[(u32, f32); 2]], section: Range<usize>) -> Vec<TetherBlock> {
    let mut blocks = Vec::new();
    // Without a pin there are no tethers.
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
