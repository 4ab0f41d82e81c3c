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
//! Small islands are held once in a substep, and large ones before each sweep of it.
//!
//! Without them a hanging rope is stretched by the square of the substep. It then is a spring that is the stiffer the shorter the substep is, and where
//! the length of the step changes that pumps: of 20 pieces, or of 5 with a load, it came to the most speed in ticks of 1/120 and 1/60 s in turn.
//!
//! Between particles that are all free, [spans](spans) do the same at a smaller scale.

mod geodesic;
mod project;
mod spans;
#[cfg(test)]
mod tests;

use core::hash::Hasher;
use core::ops::Range;

use glam::Vec4;

use super::plan::{GroupKind, Plan};
use crate::constraints::{Bound, Distance, Softness};
use crate::islands::Island;
use crate::lanes::LANES;
use crate::particles::{Particles, Places};
use geodesic::{Field, Web};
pub(super) use project::hold;
use spans::Spans;

/// An island of no more particles has no tethers: there is one rod, or two, between any of them and its pin.
const SMALL: usize = 3;

/// Nor has an island of no more where everything walks to rest: by tethers a rope between two pins still moved by micrometres after 20 000 such steps.
const SMALL_IN_STATICS: usize = 64;

/// The tethers of a plan. Derived from its rods and the pins; scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tethers {
    islands: Vec<IslandTethers>,
    spans: Vec<Spans>,
    /// Whether the plan was compiled since they were made.
    stale: bool,
}

/// Those of one island.
#[derive(Clone, Debug, Default)]
pub(crate) struct IslandTethers {
    /// A hash of the rods and of what is pinned. The same rods of another island, or of this one in another plan, have the same.
    key: u64,
    /// The rows of its pinned particles, ascending.
    pins: Vec<u32>,
    /// Of each member, to which of the pins, and how long, metres; infinite without.
    each: Vec<[(u32, f32); 2]>,
    blocks: Vec<TetherBlock>,
    /// Along which rods they are, where that is asked for.
    ways: Option<Ways>,
}

/// The ways of tethers along rods: to the nearest pin, and to either of two that are far from each other.
#[derive(Clone, Debug)]
struct Ways {
    /// Which of the pins those two are.
    far: [u32; 2],
    /// Of each of the three, all members from the farthest on: which one, the one before it on its way, and the plan's number of the rod between.
    inwards: [Vec<(u32, u32, u32)>; 3],
}

/// Tethers of eight members, each the second after the one before: as columns have them side by side.
#[derive(Clone, Debug)]
struct TetherBlock {
    /// The first of the members, counted from that of the island.
    member: u32,
    /// Their rows. Where there are fewer than eight, the first again.
    rows: [u32; LANES],
    /// To which of the island's pins.
    pins: [u32; LANES],
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
        let wanted = settings.tethers && !walks;
        self.made(island).filter(|own| wanted && !own.blocks.is_empty())
    }

    /// The spans by which an island is to be solved, if it has any.
    pub(super) fn spans_of(&self, island: &Island) -> Option<&Spans> {
        let wanted = island.settings.tethers && island.microsteps > 1;
        let own = self.spans.get(island.spans? as usize);
        own.filter(|own| wanted && !own.is_empty())
    }

    fn made(&self, island: &Island) -> Option<&IslandTethers> {
        self.islands.get(island.tethers? as usize)
    }
}

impl Plan {
    /// Gives the islands their tethers for this step. Whether an island is free has been found.
    pub(crate) fn tether(&mut self, particles: &Particles) {
        let mut tethers = core::mem::take(&mut self.tethers);
        let stale = core::mem::take(&mut tethers.stale);
        if stale {
            tethers.spans.clear();
        }
        let mut before = if stale { core::mem::take(&mut tethers.islands) } else { Vec::new() };
        for number in 0..self.islands.list.len() {
            let island = &mut self.islands.list[number];
            if stale {
                (island.tethers, island.spans) = (None, None);
            }
            let spans = island.microsteps > 1 && island.settings.tethers && island.spans.is_none();
            if spans {
                tethers.spans.push(self.spans(number));
                self.islands.list[number].spans = Some(tethers.spans.len() as u32 - 1);
            }
            let island = &mut self.islands.list[number];
            let small = island.members.len() <= SMALL && !island.measured;
            if small {
                island.tethers = None;
            }
            if small || island.groups.is_empty() || island.rigid || !island.settings.tethers {
                continue;
            }
            let island = &self.islands.list[number];
            let members = &self.islands.members[island.members.clone()];
            let held = |row: &u32| particles.position[*row as usize].w == 0.0;
            let own = tethers.made(island);
            let pins = || members.iter().copied().filter(held);
            if own.map_or(island.free, |own| own.pins.iter().copied().eq(pins())) {
                continue;
            }
            let place = match island.tethers {
                Some(place) => place as usize,
                None => tethers.islands.len(),
            };
            let pins: Vec<u32> = if island.free { Vec::new() } else { pins().collect() };
            let key = self.key(island, &pins);
            let known = before.iter().position(|other| other.key == key);
            // Many islands in a row may be alike.
            let twin = tethers.islands.last().filter(|last| last.key == key);
            let each = match (known, twin) {
                (Some(at), _) => before.swap_remove(at).each,
                (None, Some(twin)) => twin.each.clone(),
                (None, None) => self.lengths(island, &pins),
            };
            let blocks = blocks(members, &each);
            let made = IslandTethers { key, pins, each, blocks, ways: None };
            if place == tethers.islands.len() {
                tethers.islands.push(made);
            } else {
                tethers.islands[place] = made;
            }
            self.islands.list[number].tethers = Some(place as u32);
        }
        for island in self.islands.list.iter().filter(|island| island.measured) {
            let Some(place) = island.tethers else { continue };
            let made = &mut tethers.islands[place as usize];
            if made.ways.is_none() && !made.blocks.is_empty() {
                made.ways = Some(self.ways(island, &made.pins));
            }
        }
        self.tethers = tethers;
    }

    /// The ways of the tethers of an island along its rods.
    fn ways(&self, island: &Island, pins: &[u32]) -> Ways {
        let fields = self.fields(island, pins);
        // Numbers of hard distances, as `hard` lists them.
        let groups = self.groups[island.groups.clone()].iter();
        let numbers: Vec<u32> = groups
            .filter(|group| group.kind != GroupKind::Constraints)
            .flat_map(|group| group.range.clone())
            .filter(|&number| is_hard(&self.distances[number]))
            .map(|number| number as u32)
            .collect();
        let inwards = [&fields.nearest, &fields.from[0], &fields.from[1]].map(|field| {
            let all = field.inwards().into_iter();
            all.map(|(member, before, rod)| (member, before, numbers[rod as usize])).collect()
        });
        Ways { far: fields.far, inwards }
    }

    /// The hard distances of an island that hold particles together, with the first row of its members.
    fn hard(&self, island: &Island) -> (u32, impl Iterator<Item = &Distance>) {
        let groups = self.groups[island.groups.clone()].iter();
        let distances = groups
            .filter(|group| group.kind != GroupKind::Constraints)
            .flat_map(|group| &self.distances[group.range.clone()])
            .filter(|d| is_hard(d));
        (self.islands.members[island.members.start], distances)
    }

    fn key(&self, island: &Island, pins: &[u32]) -> u64 {
        let mut hash = Fnv::default();
        let (first, distances) = self.hard(island);
        hash.write_u32(island.members.len() as u32);
        for d in distances {
            hash.write_u32(d.a - first);
            hash.write_u32(d.b - first);
            hash.write_u32(d.rest.to_bits());
        }
        pins.iter().for_each(|pin| hash.write_u32(pin - first));
        hash.finish()
    }

    /// How far the members of an island are from its pins, of which there is one at least.
    fn fields(&self, island: &Island, pins: &[u32]) -> Fields {
        let members = &self.islands.members[island.members.clone()];
        let place = |row: u32| members.partition_point(|&member| member < row) as u32;
        let (_, distances) = self.hard(island);
        let rods: Vec<_> = distances.map(|d| (place(d.a), place(d.b), d.rest)).collect();
        let web = Web::new(members.len(), &rods);
        let sources: Vec<u32> = pins.iter().map(|&pin| place(pin)).collect();
        let nearest = web.field(&sources);
        // Two pins far from each other: the farthest from any, and the farthest from that.
        let farthest = |from: &Field| {
            let reached = (0..sources.len()).filter(|&pin| from.length(sources[pin]).is_finite());
            reached.fold(0, |far, pin| {
                if from.length(sources[pin]) > from.length(sources[far]) { pin } else { far }
            })
        };
        let one = farthest(&web.field(&sources[..1]));
        let from_one = web.field(&sources[one..=one]);
        let other = farthest(&from_one);
        let from_other = web.field(&sources[other..=other]);
        let far = [one as u32, other as u32];
        Fields { sources, nearest, far, from: [from_one, from_other] }
    }

    /// Of each member of an island, to which of the pins it is tethered, and how long that is.
    fn lengths(&self, island: &Island, pins: &[u32]) -> Vec<[(u32, f32); 2]> {
        const NONE: (u32, f32) = (0, f32::INFINITY);
        if pins.is_empty() {
            return Vec::new();
        }
        let Fields { sources, nearest, far: [one, other], from: [from_one, from_other] } =
            self.fields(island, pins);
        let mut each: Vec<_> = (0..island.members.len() as u32)
            .map(|member| {
                let near = (nearest.source(member), nearest.length(member));
                let ends = [(one, &from_one), (other, &from_other)];
                let ends = ends.map(|(pin, field)| (pin, field.length(member)));
                let far = ends.into_iter().filter(|end| end.0 != near.0 && end.1.is_finite());
                let far = far.reduce(|a, b| if b.1 > a.1 { b } else { a });
                [near, far.unwrap_or((near.0, f64::INFINITY))]
            })
            .map(|tethers| tethers.map(|(pin, length)| (pin, taut(length))))
            .collect();
        for &source in &sources {
            each[source as usize] = [NONE; 2];
        }
        // What nothing hard leads to.
        for tethers in &mut each {
            *tethers = tethers.map(|own| if own.1.is_finite() { own } else { NONE });
        }
        each
    }
}

/// How far members are from the pins of their island.
struct Fields {
    /// The pins among the members.
    sources: Vec<u32>,
    /// From the nearest of them.
    nearest: Field,
    /// Which two are far from each other, and how far members are from either.
    far: [u32; 2],
    from: [Field; 2],
}

/// Whether a distance is one that tethers may rely on.
fn is_hard(d: &Distance) -> bool {
    d.softness == Softness::Hard && d.bound != Bound::AtLeast
}

/// How long a tether of a way of so many metres is: rounded up, for it must not ask for more than the rods do.
fn taut(length: f64) -> f32 {
    (length * (1.0 + 1e-6)) as f32
}

/// Puts the tethers of members eight by eight: first those to the nearest pins, then the others.
fn blocks(members: &[u32], each: &[[(u32, f32); 2]]) -> Vec<TetherBlock> {
    let mut blocks = Vec::new();
    for begin in (0..each.len()).step_by(2 * LANES) {
        for which in 0..2 {
            for parity in 0..2 {
                let member = |lane: usize| {
                    let member = begin + parity + 2 * lane;
                    if member < each.len() { member } else { begin + parity }
                };
                if begin + parity >= each.len() {
                    continue;
                }
                let of = |lane: usize| each[member(lane)][which];
                if (0..LANES).all(|lane| of(lane).1 == f32::INFINITY) {
                    continue;
                }
                blocks.push(TetherBlock {
                    member: (begin + parity) as u32,
                    rows: core::array::from_fn(|lane| members[member(lane)]),
                    pins: core::array::from_fn(|lane| of(lane).0),
                    length: core::array::from_fn(|lane| of(lane).1),
                });
            }
        }
    }
    blocks
}

impl IslandTethers {
    /// Where its pins are, in columns that begin with the row `first`.
    pub(super) fn pins(&self, position: &[Vec4], first: u32) -> impl Iterator<Item = Vec4> {
        self.pins.iter().map(move |row| position[(row - first) as usize])
    }

    /// The tethers of a member: where its pin is, in columns that begin with the row `first`, and how long each is, metres; infinite without.
    pub(super) fn of_member(&self, member: usize, position: &[Vec4], first: u32) -> [Vec4; 2] {
        self.each[member].map(|(pin, length)| {
            let row = self.pins.get(pin as usize).map_or(first, |row| *row);
            position[(row - first) as usize].truncate().extend(length)
        })
    }

    /// Whether any member has a first one, and whether any has a second one.
    pub(super) fn are_there(&self) -> [bool; 2] {
        [0, 1].map(|which| self.each.iter().any(|own| own[which].1.is_finite()))
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
                let d = (*q - pins[pin as usize]).truncate();
                let distance = d.length();
                if q.w > 0.0 && distance > length {
                    let far = distance - length;
                    *did += f64::from(far) / f64::from(q.w);
                    *q -= (d * (far / distance)).extend(0.0);
                    worst = worst.max(far);
                }
            }
        }
        worst
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

    /// The blocks of some members, of which the first and the end are multiples of 16.
    fn among(&self, members: &Range<usize>) -> &[TetherBlock] {
        let place = |end: usize| self.blocks.partition_point(|block| (block.member as usize) < end);
        &self.blocks[place(members.start)..place(members.end)]
    }
}

/// Fowler, Noll and Vo's hash (FNV-1a), word by word: the same on every machine, which the standard library's need not be.
#[derive(Default)]
struct Fnv(u64);

impl Hasher for Fnv {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u32(u32::from(byte)));
    }

    fn write_u32(&mut self, word: u32) {
        let mixed = (self.0 ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3);
        self.0 = mixed ^ mixed >> 29;
    }
}
