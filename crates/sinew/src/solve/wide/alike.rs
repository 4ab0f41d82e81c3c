//! The constraints of [flocks](crate::solve::flock): each lane has that of another body, between particles of the same numbers there.

use core::ops::Range;

use super::block::{self, Eight};
use super::lengths::{self, EightLengths};
use super::spots::{Seen, Spots};
use super::temper::Temper;
use super::{Laws, List, Which, number};
use crate::constraints::{
    Angles, Areas, Bends, Cones, Constraint, Distance, Hinges, Pace, Tetrahedra, Wide,
};
use crate::lanes::{InstructionSet, LANES, Lanes, Work, with};
use crate::solve::flock::{Pen, Spot};

/// Constraints of flocks, kind by kind.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct Alike {
    tempers: Vec<Temper>,
    lengths: Vec<Own<EightLengths, 2>>,
    bends: Vec<Own<Eight<Bends>, 4>>,
    areas: Vec<Own<Eight<Areas>, 3>>,
    tetrahedra: Vec<Own<Eight<Tetrahedra>, 4>>,
    angles: Vec<Own<Eight<Angles>, 3>>,
    hinges: Vec<Own<Eight<Hinges>, 4>>,
    cones: Vec<Own<Eight<Cones>, 5>>,
}

/// One constraint of each of eight bodies.
#[derive(Clone, Debug)]
struct Own<E, const N: usize> {
    /// Numbers of its particles in the body.
    at: [u32; N],
    eight: E,
}

/// Which of them stand for a group.
#[derive(Clone, Debug)]
pub(in crate::solve) struct Part {
    list: List,
    range: Range<usize>,
    /// Where their sums begin among the flock's.
    sums: usize,
}

/// The same group in each of eight bodies, of which the first rows are given, and what it is solved by in the first of them alone.
pub(in crate::solve) struct Groups<'a, T> {
    pub(in crate::solve) each: [&'a [T]; LANES],
    pub(in crate::solve) first: [u32; LANES],
    pub(in crate::solve) laws: &'a Laws,
    pub(in crate::solve) which: &'a Which,
    /// Where the sums begin among the flock's.
    pub(in crate::solve) sums: usize,
}

impl Alike {
    /// Forgets all, and keeps the memory.
    pub(in crate::solve) fn clear(&mut self) {
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

    /// Takes distances.
    pub(in crate::solve) fn add_distances(&mut self, groups: &Groups<Distance>) -> Part {
        let Groups { each, first, laws, which, sums } = groups;
        let begin = self.lengths.len();
        for place in 0..each[0].len() {
            let (mut eight, temper) = EightLengths::of(each.map(|group| &group[place]));
            let temper = temper.asked_as(laws.temper(which, place));
            eight.temper = number(&mut self.tempers, temper);
            let Distance { a, b, .. } = each[0][place];
            self.lengths.push(Own { at: [a - first[0], b - first[0]], eight });
        }
        Part { list: List::Lengths, range: begin..self.lengths.len(), sums: *sums }
    }

    /// Takes constraints; `None` if their laws are not the same after all.
    pub(in crate::solve) fn add(&mut self, groups: &Groups<Constraint>) -> Option<Part> {
        let Self { tempers, bends, areas, tetrahedra, angles, hinges, cones, .. } = self;
        let range = match groups.which.list {
            List::Lengths => return None,
            List::Bends => take(bends, tempers, groups)?,
            List::Areas => take(areas, tempers, groups)?,
            List::Tetrahedra => take(tetrahedra, tempers, groups)?,
            List::Angles => take(angles, tempers, groups)?,
            List::Hinges => take(hinges, tempers, groups)?,
            List::Cones => take(cones, tempers, groups)?,
        };
        Some(Part { list: groups.which.list, range, sums: groups.sums })
    }

    /// Projects a group once; returns the largest error found in each body, metres, or what it was before. Nothing is asked of bodies of the mask
    /// `aside`: what becomes of them does not matter.
    pub(in crate::solve) fn sweep(
        &self,
        part: &Part,
        pen: &mut Pen,
        pace: Pace,
        (aside, worst): (u32, Eight32),
        instructions: InstructionSet,
    ) -> Eight32 {
        let Self { tempers, lengths, bends, areas, tetrahedra, angles, hinges, cones } = self;
        let (range, sums) = (part.range.clone(), part.sums);
        macro_rules! sweep {
            ($list:ident) => {{
                let list = &$list[range];
                with(instructions, Sweep { list, tempers, pen, sums, pace, aside, worst })
            }};
        }
        match part.list {
            List::Lengths => sweep!(lengths),
            List::Bends => sweep!(bends),
            List::Areas => sweep!(areas),
            List::Tetrahedra => sweep!(tetrahedra),
            List::Angles => sweep!(angles),
            List::Hinges => sweep!(hinges),
            List::Cones => sweep!(cones),
        }
    }

    /// How far the hard ones of a group are from being kept in each body: the largest error, metres, and of distances the largest share of a rest
    /// length. Moves nothing.
    pub(in crate::solve) fn measure(
        &self,
        part: &Part,
        now: &[Spot],
        instructions: InstructionSet,
    ) -> [Eight32; 2] {
        let Self { tempers, lengths, bends, areas, tetrahedra, angles, hinges, cones } = self;
        let range = part.range.clone();
        macro_rules! measure {
            ($list:ident) => {
                with(instructions, Measure { list: &$list[range], tempers, now })
            };
        }
        match part.list {
            List::Lengths => measure!(lengths),
            List::Bends => measure!(bends),
            List::Areas => measure!(areas),
            List::Tetrahedra => measure!(tetrahedra),
            List::Angles => measure!(angles),
            List::Hinges => measure!(hinges),
            List::Cones => measure!(cones),
        }
    }
}

impl Laws {
    /// How hard the block is that a constraint of a group is in.
    fn temper(&self, which: &Which, place: usize) -> &Temper {
        let block = which.blocks.start + place / which.each;
        let temper = match which.list {
            List::Lengths => self.lengths[block].eight.temper,
            List::Bends => self.bends[block].eight.temper,
            List::Areas => self.areas[block].eight.temper,
            List::Tetrahedra => self.tetrahedra[block].eight.temper,
            List::Angles => self.angles[block].eight.temper,
            List::Hinges => self.hinges[block].eight.temper,
            List::Cones => self.cones[block].eight.temper,
        };
        &self.tempers[temper as usize]
    }
}

impl Which {
    /// Whether another group is of the same law, and is cut in the same way.
    pub(in crate::solve) fn is_like(&self, other: &Self) -> bool {
        self.list == other.list && self.each == other.each
    }
}

/// Appends them, or nothing.
fn take<W: Wide<N>, const N: usize>(
    list: &mut Vec<Own<Eight<W>, N>>,
    tempers: &mut Vec<Temper>,
    groups: &Groups<Constraint>,
) -> Option<Range<usize>> {
    let Groups { each, first, laws, which, .. } = groups;
    let begin = list.len();
    for place in 0..each[0].len() {
        let Some((mut eight, temper)) = Eight::of(each.map(|group| &group[place])) else {
            list.truncate(begin);
            return None;
        };
        let temper = temper.asked_as(laws.temper(which, place));
        eight.temper = number(tempers, temper);
        let at = W::rows(&each[0][place]).map(|row| row - first[0]);
        list.push(Own { at, eight });
    }
    Some(begin..list.len())
}

/// A number of each of eight bodies.
type Eight32 = [f32; LANES];

/// What there is to be done with one constraint of each of eight bodies.
trait Each<const N: usize> {
    /// Which temper they have.
    fn temper(&self) -> u32;
    /// As [`block::project`] has it.
    fn project<L: Lanes>(
        &self,
        how: (&Temper, &Eight32, f32, L),
        spots: &mut InPen<N>,
        sums: &mut Eight32,
    ) -> L;
    /// The errors of the hard ones, metres, and of distances as shares of their rest lengths.
    fn left<L: Lanes>(&self, tempers: &[Temper], spots: &Still<N>) -> (L, L);
}

impl<W: Wide<N>, const N: usize> Each<N> for Eight<W> {
    fn temper(&self) -> u32 {
        self.temper
    }

    #[inline(always)]
    fn project<L: Lanes>(
        &self,
        how: (&Temper, &Eight32, f32, L),
        spots: &mut InPen<N>,
        sums: &mut Eight32,
    ) -> L {
        block::project::<L, W, N>(self, how, spots, sums)
    }

    #[inline(always)]
    fn left<L: Lanes>(&self, tempers: &[Temper], spots: &Still<N>) -> (L, L) {
        (block::left::<L, W, N>(self, tempers, spots), L::zero())
    }
}

impl Each<2> for EightLengths {
    fn temper(&self) -> u32 {
        self.temper
    }

    #[inline(always)]
    fn project<L: Lanes>(
        &self,
        how: (&Temper, &Eight32, f32, L),
        spots: &mut InPen<2>,
        sums: &mut Eight32,
    ) -> L {
        lengths::project::<L>(self, how, spots, sums)
    }

    #[inline(always)]
    fn left<L: Lanes>(&self, tempers: &[Temper], spots: &Still<2>) -> (L, L) {
        lengths::left::<L>(self, tempers, spots)
    }
}

/// As [`Alike::sweep`] has it, of one list.
struct Sweep<'a, E, const N: usize> {
    list: &'a [Own<E, N>],
    tempers: &'a [Temper],
    pen: &'a mut Pen,
    sums: usize,
    pace: Pace,
    aside: u32,
    worst: Eight32,
}

impl<E: Each<N>, const N: usize> Work for Sweep<'_, E, N> {
    type Output = Eight32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Eight32 {
        let Self { list, tempers, pen, sums, pace, aside, worst } = self;
        let (mut each, mut each_of) = ([1.0; LANES], u32::MAX);
        let (aside, mut worst) = (L::mask(aside), L::load(&worst));
        let Pen { now, start, sums: all, .. } = pen;
        for (own, sum) in list.iter().zip(&mut all[sums..]) {
            let temper = &tempers[own.eight.temper() as usize];
            if own.eight.temper() != each_of {
                each = if temper.shares { temper.each(pace.sweeps) } else { [1.0; LANES] };
                each_of = own.eight.temper();
            }
            let mut spots = InPen { at: &own.at, now, start };
            let how = (temper, &each, pace.h, aside);
            worst = own.eight.project::<L>(how, &mut spots, sum).max(worst);
        }
        worst.array()
    }
}

/// As [`Alike::measure`] has it, of one list.
struct Measure<'a, E, const N: usize> {
    list: &'a [Own<E, N>],
    tempers: &'a [Temper],
    now: &'a [Spot],
}

impl<E: Each<N>, const N: usize> Work for Measure<'_, E, N> {
    type Output = [Eight32; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Eight32; 2] {
        let Self { list, tempers, now } = self;
        let mut worst = (L::zero(), L::zero());
        for own in list {
            let spots = Still { at: &own.at, now };
            let (left, share) = own.eight.left::<L>(tempers, &spots);
            worst = (left.max(worst.0), share.max(worst.1));
        }
        [worst.0.array(), worst.1.array()]
    }
}

/// The particles of one constraint of each of eight bodies, to be looked at.
struct Still<'a, const N: usize> {
    at: &'a [u32; N],
    now: &'a [Spot],
}

impl<const N: usize> Seen<N> for Still<'_, N> {
    #[inline(always)]
    fn now<L: Lanes>(&self, i: usize) -> [L; 4] {
        self.now[self.at[i] as usize].load()
    }
}

/// The same, to be moved.
struct InPen<'a, const N: usize> {
    at: &'a [u32; N],
    now: &'a mut [Spot],
    start: &'a [Spot],
}

impl<const N: usize> Seen<N> for InPen<'_, N> {
    #[inline(always)]
    fn now<L: Lanes>(&self, i: usize) -> [L; 4] {
        self.now[self.at[i] as usize].load()
    }
}

impl<const N: usize> Spots<N> for InPen<'_, N> {
    #[inline(always)]
    fn start<L: Lanes>(&self, i: usize) -> [L; 4] {
        self.start[self.at[i] as usize].load()
    }

    #[inline(always)]
    fn put<L: Lanes>(&mut self, i: usize, eight: [L; 4]) {
        self.now[self.at[i] as usize].put(eight);
    }
}
