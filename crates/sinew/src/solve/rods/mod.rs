//! Hard rods, eight side by side: what everything waits for, and the form in which a plan keeps rods for it.
//!
//! What is solved together is of one colour, so no two of the eight share a particle, and the order among them does not matter. The formula is that of
//! [`project_rod`](crate::constraints::project_rod), operation by operation ([`project`]). Two ways to it:
//!
//! - `packed`: particles as they lie, `[x y z w]`, turned into lanes and back for every eight rods. For any mesh.
//! - `columns`: a cluster whose rods mostly run in step, a grid's, is turned once, swept as columns of x, y, z and w without any further turning, and turned back.

mod columns;
mod packed;

use core::ops::Range;

use crate::constraints::Distance;
use crate::lanes::{LANES, Lanes, Vector};

pub(crate) use columns::Columns;

/// The rods of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rods {
    runs: Vec<Run>,
    /// Rest lengths of the runs, metres.
    rests: Vec<f32>,
    blocks: Vec<Block>,
}

/// Rods in step: `(a, b), (a + s, b + s), (a + 2s, b + 2s), …`
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    a: u32,
    b: u32,
    /// The step `s`, 1 or 2.
    step: u32,
    /// Where its rest lengths are, filled up to a multiple of eight.
    rests: u32,
    count: u32,
}

/// Any eight rods of one colour. Where there are fewer, one stands there again: it computes the same and writes the same.
#[derive(Clone, Copy, Debug)]
struct Block {
    a: [u32; LANES],
    b: [u32; LANES],
    rest: [f32; LANES],
}

impl Rods {
    /// Forgets all, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.runs.clear();
        self.rests.clear();
        self.blocks.clear();
    }

    /// Takes the rods of one colour, sorted by their first particles, and returns which runs and which blocks they are. `alone` for those that share particles:
    /// each has a block to itself. `by_parity` for columns, which keep even and odd rows apart: so their runs go by twos.
    pub(crate) fn add(
        &mut self,
        rods: &[Distance],
        alone: bool,
        by_parity: bool,
    ) -> (Range<usize>, Range<usize>) {
        let (runs, blocks) = (self.runs.len(), self.blocks.len());
        let mut loose = Vec::new();
        if alone {
            rods.chunks(1).for_each(|rod| self.blocks.push(Block::of(rod)));
        } else if by_parity {
            for parity in 0..2 {
                let of_parity = rods.iter().filter(|rod| ends(rod).0 % 2 == parity);
                self.find_runs(&of_parity.copied().collect::<Vec<_>>(), &[2], &mut loose);
            }
        } else {
            self.find_runs(rods, &[1, 2], &mut loose);
        }
        loose.chunks(LANES).for_each(|rods| self.blocks.push(Block::of(rods)));
        (runs..self.runs.len(), blocks..self.blocks.len())
    }

    /// Takes the runs of these steps out of some rods; what is left is loose.
    fn find_runs(&mut self, rods: &[Distance], steps: &[u32], loose: &mut Vec<Distance>) {
        let mut rest = rods;
        while let Some(first) = rest.first() {
            let (step, length) = run(rest, steps);
            // A few more than eights are worth lanes of their own if half of those are used.
            let over = length % LANES;
            let count = if over >= LANES / 2 { length } else { length - over };
            if count > 0 {
                let ((a, b), rests) = (ends(first), self.rests.len() as u32);
                self.runs.push(Run { a, b, step, rests, count: count as u32 });
                self.rests.extend(rest[..count].iter().map(|rod| rod.rest));
                self.rests.resize(self.rests.len().next_multiple_of(LANES), first.rest);
            }
            // Of what is no run, the second may still be the first of one.
            let taken = if count > 0 { length } else { 1 };
            loose.extend_from_slice(&rest[count..taken]);
            rest = &rest[taken..];
        }
    }

    /// The rest lengths of a run, eight by eight.
    #[inline(always)]
    fn rests_of(&self, run: &Run) -> &[[f32; LANES]] {
        let eights = (run.count as usize).div_ceil(LANES);
        self.rests[run.rests as usize..][..eights * LANES].as_chunks().0
    }
}

impl Block {
    /// One to eight rods.
    fn of(rods: &[Distance]) -> Self {
        let rod = |lane: usize| rods.get(lane).unwrap_or(&rods[0]);
        Self {
            a: core::array::from_fn(|lane| ends(rod(lane)).0),
            b: core::array::from_fn(|lane| ends(rod(lane)).1),
            rest: core::array::from_fn(|lane| rod(lane).rest),
        }
    }
}

/// The particles of a rod, lower row first: nothing in the formula knows them apart.
fn ends(rod: &Distance) -> (u32, u32) {
    (rod.a.min(rod.b), rod.a.max(rod.b))
}

/// How many rods from the first on make a run, and by which of the steps.
fn run(rods: &[Distance], steps: &[u32]) -> (u32, usize) {
    let (a, b) = ends(&rods[0]);
    let step = rods.get(1).map_or(0, |next| ends(next).0 - a);
    if !steps.contains(&step) {
        return (1, 1);
    }
    let follows =
        |(rod, place): &(&Distance, u32)| ends(rod) == (a + place * step, b + place * step);
    (step, rods.iter().zip(0..).take_while(follows).count())
}

/// Eight rods once: both ends moved, the errors found, and a mask of those that have a direction and something that can move.
///
/// As [`project_rod`](crate::constraints::project_rod): `d = a - b`, `s = (‖d‖ - L)/(‖d‖ (w_a + w_b))`, `a -= w_a s d`, `b += w_b s d`. With the positions
/// at the start of the substep, as [`project_rod_from_start`](crate::constraints::project_rod_from_start) where that can be.
#[inline(always)]
fn project<L: Lanes>(
    one: [L; 4],
    other: [L; 4],
    rest: L,
    start: Option<([L; 4], [L; 4])>,
) -> ([L; 4], [L; 4], L, L) {
    let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
    let mut d = a - b;
    let square = d.length_squared();
    let length = square.sqrt();
    let value = length - rest;
    let weights = wa + wb;
    let divisor = length * weights;
    let mut moves = L::zero().lt(divisor);
    let mut scale = moves.and(value / divisor);
    if let Some((a, b)) = start {
        let (from, _) = Vector::of(a);
        let (to, _) = Vector::of(b);
        let bond = from - to;
        let along = d.dot(bond);
        let short = rest * rest;
        let usable = (short * L::splat(1.0 / 3.0)).lt(along).and(L::zero().lt(weights));
        let newton = (square - short) / (L::splat(2.0) * weights * along);
        scale = usable.select(newton, scale);
        d = bond.or_else(usable, d);
        moves = moves.or(usable);
    }
    let error = moves.and(value.abs());
    ((a - d * (wa * scale)).with(wa), (b + d * (wb * scale)).with(wb), error, moves)
}
