//! Constraints other than hard rods, eight side by side: soft distances, ropes and struts, and most laws.
//!
//! As [rods](super::rods) are: those of one colour share no particle, so eight of them go at once, in any order. The formula of each is that of its
//! scalar twin in [`constraints`](crate::constraints), to a few units in the last place; how hard it is, is one formula for all ([`temper`]).
//!
//! - `temper` is the softness of eight constraints, whatever each one's is;
//! - `block` projects eight constraints of one law, by their values and gradients ([`Wide`](crate::constraints::Wide));
//! - `lengths` projects eight distances;
//! - `spots` is where the particles of eight are, in memory or in the lanes of a [flock](super::flock); `alike` are the constraints of those.

mod alike;
mod block;
mod lengths;
mod spots;
mod temper;
#[cfg(test)]
mod tests;

use core::ops::Range;

use crate::constraints::{
    Angles, Areas, Bends, Cones, Constraint, Distance, Hinges, Law, Pace, Tetrahedra, Wide,
};
use crate::lanes::{InstructionSet, LANES, Lanes, with};
use crate::particles::Places;
pub(super) use alike::{Alike, Groups, Part};
use block::Block;
use lengths::Lengths;
use temper::Temper;

/// The constraints of a plan that have wide kernels.
#[derive(Clone, Debug, Default)]
pub(crate) struct Laws {
    tempers: Vec<Temper>,
    lengths: Vec<Lengths>,
    bends: Vec<Block<Bends, 4>>,
    areas: Vec<Block<Areas, 3>>,
    tetrahedra: Vec<Block<Tetrahedra, 4>>,
    angles: Vec<Block<Angles, 3>>,
    hinges: Vec<Block<Hinges, 4>>,
    cones: Vec<Block<Cones, 5>>,
}

/// Which of them a group has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Which {
    list: List,
    blocks: Range<usize>,
    /// How many of the group's constraints are in a block: eight, or one where they share particles.
    each: usize,
}

/// The lists that there are.
#[derive(Clone, Copy, Debug, PartialEq)]
enum List {
    Lengths,
    Bends,
    Areas,
    Tetrahedra,
    Angles,
    Hinges,
    Cones,
}

impl Laws {
    /// Forgets all, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        let Self { tempers, lengths, bends, areas, tetrahedra, angles, hinges, cones } = self;
        tempers.clear();
        lengths.clear();
        bends.clear();
        areas.clear();
        tetrahedra.clear();
        angles.clear();
        hinges.clear();
        cones.clear();
    }

    /// Takes the constraints of a group, all of one colour, in their order; `alone` those that share particles: each has a block to itself. `None`
    /// where there is no wide kernel for them, or not the same one for all.
    pub(crate) fn add(&mut self, constraints: &[Constraint], alone: bool) -> Option<Which> {
        let each = if alone { 1 } else { LANES };
        let Self { tempers, bends, areas, tetrahedra, angles, hinges, cones, .. } = self;
        let (list, blocks) = match &constraints.first()?.law {
            Law::Bend(_) => (List::Bends, take(bends, tempers, constraints, each)?),
            Law::Area(_) => (List::Areas, take(areas, tempers, constraints, each)?),
            Law::Tetrahedron(_) => {
                (List::Tetrahedra, take(tetrahedra, tempers, constraints, each)?)
            }
            Law::Angle(_) => (List::Angles, take(angles, tempers, constraints, each)?),
            Law::Hinge(_) => (List::Hinges, take(hinges, tempers, constraints, each)?),
            Law::Cone(_) => (List::Cones, take(cones, tempers, constraints, each)?),
            _ => return None,
        };
        Some(Which { list, blocks, each })
    }

    /// Takes distances, likewise.
    pub(crate) fn add_distances(&mut self, distances: &[Distance], alone: bool) -> Which {
        let (first, each) = (self.lengths.len(), if alone { 1 } else { LANES });
        for eight in distances.chunks(each) {
            self.lengths.push(Lengths::of(eight, &mut self.tempers));
        }
        Which { list: List::Lengths, blocks: first..self.lengths.len(), each }
    }

    /// Projects a group once; `multipliers` are what its constraints have summed up, in their order. Returns the largest error found, metres; of soft
    /// ones, how far they moved.
    pub(crate) fn sweep(
        &self,
        places: &mut Places,
        which: &Which,
        multipliers: &mut [f32],
        pace: Pace,
        instructions: InstructionSet,
    ) -> f32 {
        let (sums, range) = (multipliers.chunks_mut(which.each), which.blocks.clone());
        let Self { tempers, lengths, bends, areas, tetrahedra, angles, hinges, cones } = self;
        macro_rules! sweep {
            ($kernel:ident of $list:ident) => {{
                let blocks = &$list[range];
                with(instructions, $kernel::Sweep { blocks, tempers, places, sums, pace })
            }};
        }
        match which.list {
            List::Lengths => sweep!(lengths of lengths),
            List::Bends => sweep!(block of bends),
            List::Areas => sweep!(block of areas),
            List::Tetrahedra => sweep!(block of tetrahedra),
            List::Angles => sweep!(block of angles),
            List::Hinges => sweep!(block of hinges),
            List::Cones => sweep!(block of cones),
        }
    }

    /// How far the hard ones of a group are from being kept, metres, the largest; moves nothing.
    pub(crate) fn measure(
        &self,
        places: &Places,
        which: &Which,
        instructions: InstructionSet,
    ) -> f32 {
        let range = which.blocks.clone();
        let Self { tempers, lengths, bends, areas, tetrahedra, angles, hinges, cones } = self;
        macro_rules! measure {
            ($kernel:ident of $list:ident) => {
                with(instructions, $kernel::Measure { blocks: &$list[range], tempers, places })
            };
        }
        match which.list {
            List::Lengths => measure!(lengths of lengths),
            List::Bends => measure!(block of bends),
            List::Areas => measure!(block of areas),
            List::Tetrahedra => measure!(block of tetrahedra),
            List::Angles => measure!(block of angles),
            List::Hinges => measure!(block of hinges),
            List::Cones => measure!(block of cones),
        }
    }
}

/// Appends blocks of `each` constraints, or nothing if not all of them fit.
fn take<W: Wide<N>, const N: usize>(
    blocks: &mut Vec<Block<W, N>>,
    tempers: &mut Vec<Temper>,
    constraints: &[Constraint],
    each: usize,
) -> Option<Range<usize>> {
    let first = blocks.len();
    for some in constraints.chunks(each) {
        let Some(block) = Block::of(some, tempers) else {
            blocks.truncate(first);
            return None;
        };
        blocks.push(block);
    }
    Some(first..blocks.len())
}

/// The number of a temper, which is the last one's if they are the same: so bodies of one softness have one, which stays in the cache.
fn number(tempers: &mut Vec<Temper>, temper: Temper) -> u32 {
    if tempers.last() != Some(&temper) {
        tempers.push(temper);
    }
    (tempers.len() - 1) as u32
}

/// Rows as places in slices that begin with the row `first`; in `room` if they are others. Those in memory are left there: a copy would go into a
/// register, and from there, more slowly, lane by lane to where addresses are made.
#[inline(always)]
fn less<'a, const N: usize>(
    rows: &'a [[u32; LANES]; N],
    first: u32,
    room: &'a mut [[u32; LANES]; N],
) -> &'a [[u32; LANES]; N] {
    if first == 0 {
        return rows;
    }
    for (to, from) in room.iter_mut().zip(rows) {
        for (to, from) in to.iter_mut().zip(from) {
            *to = from.wrapping_sub(first);
        }
    }
    room
}

/// Does something for each of up to five particles, with its number a constant: a loop that the compiler may choose not to unroll keeps all vectors
/// in memory.
macro_rules! each {
    ($i:ident of $n:ident $body:block) => {
        each!(@ $i $n $body 0 1 2 3 4)
    };
    ($i:ident of $n:ident backwards $body:block) => {
        each!(@ $i $n $body 4 3 2 1 0)
    };
    (@ $i:ident $n:ident $body:block $($number:literal)*) => {
        $(if $number < $n {
            let $i = $number;
            $body
        })*
    };
}

use each;

/// What one to eight constraints have summed up; the first one's again where there are fewer.
#[inline(always)]
fn load_sums<L: Lanes>(sums: &[f32]) -> L {
    match sums.try_into() {
        Ok(eight) => L::load(eight),
        Err(_) => {
            let mut eight = [sums.first().copied().unwrap_or(0.0); LANES];
            for (to, from) in eight.iter_mut().zip(sums) {
                *to = *from;
            }
            L::load(&eight)
        }
    }
}

/// Writes them back.
#[inline(always)]
fn store_sums<L: Lanes>(lanes: L, sums: &mut [f32]) {
    if let Ok(eight) = <&mut [f32; LANES]>::try_from(&mut *sums) {
        lanes.store(eight);
    } else {
        for (to, from) in sums.iter_mut().zip(lanes.array()) {
            *to = from;
        }
    }
}
