//! Hard rods, eight side by side: what everything waits for, and the form in which a plan keeps rods for it.
//!
//! What is solved together is of one colour, so no two of the eight share a particle, and the order among them does not matter. The formula is that
//! of [`project_rod`](crate::constraints::project_rod), operation by operation ([`stretch`], [`moved`]). Two ways to it:
//!
//! - `packed`: particles as they lie, `[x y z w]`, turned into lanes and back for every eight rods. For any mesh.
//! - `columns`: a cluster whose rods mostly run in step, a grid's, is turned once, swept as columns of x, y, z and w without any further turning, and
//!   turned back. `soft` are distances of a grid that yield by a compliance: rods there, by the same formula.

mod columns;
mod packed;
mod soft;

pub(super) use packed::worse;
pub(super) use soft::compliance;

use core::ops::Range;

use crate::constraints::Distance;
use crate::lanes::{Columns, LANES, Lanes, Number, Pair, Vector};

/// cos² of 0.35 rad, by which a rod may turn in a substep so that the direction that it had at the start still serves to correct it.
pub(super) const COS_SQUARED: f32 = 0.882_43;

/// The rods of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rods {
    runs: Vec<RodRun>,
    /// Rest lengths of the runs, metres.
    rests: Vec<f32>,
    /// What is swept in columns: by colour.
    strided_batches: Vec<StridedBatch>,
    /// Their rods, with their rest lengths, NaN for lanes beyond the last rod.
    pairs: Vec<Pair>,
    /// Where odd rows begin in their columns.
    half: usize,
    blocks: Vec<RodBlock>,
}

/// Rods of one colour in step by two rows, so that both their first and their second ends are neighbours in a column; or soft ones of one compliance. Their
/// rows count from the first one of their cluster batch.
#[derive(Clone, Debug)]
struct StridedBatch {
    /// How much they yield, m/N: zero of rods.
    compliance: f32,
    /// Whether they are pairs of neighbours in a column, in step by four rows; only soft ones are.
    neighbours: bool,
    /// Eights.
    full: Range<usize>,
    /// The last ones of each run, fewer than eight.
    tails: Range<usize>,
}

/// Rods in step: `(a, b), (a + s, b + s), (a + 2s, b + 2s), …`
#[derive(Clone, Copy, Debug, PartialEq)]
struct RodRun {
    a: u32,
    b: u32,
    /// The step `s`, 1 or 2.
    step: u32,
    /// Where its rest lengths are, filled up to a multiple of eight.
    rests: u32,
    count: u32,
}

/// Columns have room for so many cluster batches of the longest kind: for as many substeps, nearly.
const BUNDLES: usize = 16;

/// Any eight rods of one colour. Where there are fewer, one stands there again: it computes the same and writes the same.
#[derive(Clone, Copy, Debug)]
struct RodBlock {
    a: [u32; LANES],
    b: [u32; LANES],
    rest: [f32; LANES],
}

/// How long the lists are.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RodCounts {
    runs: usize,
    rests: usize,
    strided_batches: usize,
    pairs: usize,
    blocks: usize,
    /// Where odd rows begin.
    half: usize,
}

impl Rods {
    pub(super) fn counts(&self) -> RodCounts {
        RodCounts {
            runs: self.runs.len(),
            rests: self.rests.len(),
            strided_batches: self.strided_batches.len(),
            pairs: self.pairs.len(),
            blocks: self.blocks.len(),
            half: self.half,
        }
    }

    /// Forgets what came after it had so many, and keeps the memory.
    pub(super) fn truncate(&mut self, counts: &RodCounts) {
        self.runs.truncate(counts.runs);
        self.rests.truncate(counts.rests);
        self.strided_batches.truncate(counts.strided_batches);
        self.pairs.truncate(counts.pairs);
        self.blocks.truncate(counts.blocks);
        self.set_half(counts.half);
    }

    /// Takes the rods of one colour, sorted by their first particles, and returns which runs and which blocks they are. `alone` for those that share
    /// particles: each has a block to itself.
    pub(crate) fn add(&mut self, rods: &[Distance], alone: bool) -> (Range<usize>, Range<usize>) {
        let (runs, blocks) = (self.runs.len(), self.blocks.len());
        let mut loose = Vec::new();
        if alone {
            rods.chunks(1).for_each(|rod| self.blocks.push(RodBlock::of(rod)));
        } else {
            self.find_runs(rods, &[1, 2], LANES / 2, &mut loose);
        }
        loose.chunks(LANES).for_each(|rods| self.blocks.push(RodBlock::of(rods)));
        (runs..self.runs.len(), blocks..self.blocks.len())
    }

    /// The same for a cluster batch of so many rows that is swept in columns: returns which strided batches, and which blocks.
    pub(crate) fn add_to_columns(
        &mut self,
        rods: &[Distance],
        alone: bool,
        rows: &Range<u32>,
    ) -> (Range<usize>, Range<usize>) {
        let (strided_batches, runs, rests) =
            (self.strided_batches.len(), self.runs.len(), self.rests.len());
        let (_, blocks) = if alone { self.add(rods, true) } else { (0..0, 0..0) };
        let mut loose = Vec::new();
        for parity in if alone { 0..0 } else { 0..2 } {
            let of_parity = rods.iter().filter(|rod| ends(rod).0 % 2 == parity);
            self.find_runs(&of_parity.copied().collect::<Vec<_>>(), &[2], 2, &mut loose);
        }
        self.widen(rows.len());
        let (begin, mut tails) = (self.pairs.len(), Vec::new());
        for RodRun { a, b, rests, count, .. } in self.runs.split_off(runs) {
            let lengths = &self.rests[rests as usize..][..count as usize];
            for (some, along) in lengths.chunks(LANES).zip((0..).step_by(2 * LANES)) {
                let mut eight = [f32::NAN; LANES];
                eight[..some.len()].copy_from_slice(some);
                let (a, b) = (a - rows.start + along, b - rows.start + along);
                let pair = Pair::new(a, b, eight, self.half);
                if some.len() == LANES { &mut self.pairs } else { &mut tails }.push(pair);
            }
        }
        let full = begin..self.pairs.len();
        self.pairs.extend(tails);
        let tails = full.end..self.pairs.len();
        let batch = StridedBatch { compliance: 0.0, neighbours: false, tails, full };
        self.strided_batches.push(batch);
        self.rests.truncate(rests);
        let first = if alone { blocks.start } else { self.blocks.len() };
        loose.chunks(LANES).for_each(|rods| self.blocks.push(RodBlock::of(rods)));
        (strided_batches..self.strided_batches.len(), first..self.blocks.len())
    }

    /// Lets columns have room for some cluster batches of so many rows, which a [wavefront](super::wavefront) is on its way through.
    fn widen(&mut self, rows: usize) {
        self.set_half(self.half.max(Columns::half(BUNDLES * rows.next_power_of_two())));
    }

    fn set_half(&mut self, half: usize) {
        let old = core::mem::replace(&mut self.half, half);
        if half != old {
            self.pairs.iter_mut().for_each(|pair| *pair = pair.moved(old, half));
        }
    }

    /// Where odd rows begin in the columns that rods are swept in.
    pub(super) fn half(&self) -> usize {
        self.half
    }

    /// Takes the runs of these steps out of some rods; what is left is loose.
    fn find_runs(
        &mut self,
        rods: &[Distance],
        steps: &[u32],
        worth: usize,
        loose: &mut Vec<Distance>,
    ) {
        let mut rest = rods;
        while let Some(first) = rest.first() {
            let (step, length) = run(rest, steps);
            // A few more than eights may be worth lanes of their own.
            let over = length % LANES;
            let count = if over >= worth { length } else { length - over };
            if count > 0 {
                let ((a, b), rests) = (ends(first), self.rests.len() as u32);
                self.runs.push(RodRun { a, b, step, rests, count: count as u32 });
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
    fn rests_of(&self, run: &RodRun) -> &[[f32; LANES]] {
        let eights = (run.count as usize).div_ceil(LANES);
        self.rests[run.rests as usize..][..eights * LANES].as_chunks().0
    }
}

impl RodBlock {
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

/// How much of their errors rods take in a sweep that is to share out what they cannot all have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Relaxation {
    /// Of what is beyond the tolerance.
    pub(crate) share: f32,
    /// As a share of the rest length: what is off by less is left.
    pub(crate) tolerance: f32,
}

/// How much of their errors rods take in a sweep. A constant of a kernel, but where it is an option.
pub(super) trait Correction: Copy {
    /// That of eight; `None` for all.
    fn share<N: Number>(self, error: N, rest: N) -> Option<N>;
}

/// All of every error.
#[derive(Clone, Copy)]
pub(super) struct Whole;

impl Correction for Whole {
    #[inline(always)]
    fn share<N: Number>(self, _: N, _: N) -> Option<N> {
        None
    }
}

impl Correction for Relaxation {
    #[inline(always)]
    fn share<N: Number>(self, error: N, rest: N) -> Option<N> {
        let beyond = (error - rest * N::splat(self.tolerance)) / error;
        // Of none it is no number.
        Some(beyond.max(N::splat(0.0)) * N::splat(self.share))
    }
}

impl Correction for Option<Relaxation> {
    #[inline(always)]
    fn share<N: Number>(self, error: N, rest: N) -> Option<N> {
        match self {
            Some(relaxation) => relaxation.share(error, rest),
            None => None,
        }
    }
}

/// Both ends moved to the nearest point, or some of the way, the errors, and which of the rods were projected or have no end that moves.
#[inline(always)]
pub(super) fn project<N: Number>(
    one: [N; 4],
    other: [N; 4],
    rest: N,
    how: impl Correction,
) -> ([N; 4], [N; 4], N, N) {
    let (mut scale, error, moves) = stretch(one, other, rest);
    if let Some(share) = how.share(error, rest) {
        scale = scale * share;
    }
    let (one, other) = moved(one, other, scale);
    (one, other, error, moves)
}

/// The particles of a rod, lower row first: nothing in the formula knows them apart.
pub(in crate::solve) fn ends(rod: &Distance) -> (u32, u32) {
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

/// How far eight rods are to be moved: the multiplier `s` of their direction, the error, metres, and a mask of those of which nothing is left to do: they
/// have a direction, or no end that moves.
#[inline(always)]
fn stretch<N: Number>(one: [N; 4], other: [N; 4], rest: N) -> (N, N, N) {
    let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
    stretch_of((a - b).length(), [wa, wb], rest, None)
}

/// The same of rods of some length; or of some that yield, with `α/h²`, 1/kg, and what each has summed up: of those the error is how far they are moved.
///
/// As [`project_rod`](crate::constraints::project_rod): with `d = a - b`, `s = (‖d‖ - L)/(‖d‖ (w_a + w_b))`. What yields by a compliance α asks for `α/h² Λ`
/// less, and resists by as much more: `s = (‖d‖ - L - Λ α/h²)/(‖d‖ (w_a + w_b + α/h²))`, and `Λ` grows by `s ‖d‖` (see
/// [`multiplier`](crate::constraints::SubstepContext)).
#[inline(always)]
fn stretch_of<N: Number>(
    length: N,
    [wa, wb]: [N; 2],
    rest: N,
    yields: Option<(N, N)>,
) -> (N, N, N) {
    let (value, weights) = (length - rest, wa + wb);
    let divisor = length * weights;
    let moves = N::zero().lt(divisor);
    // Between two pins there is nothing to part, and along the edge of a flag there are many such rods.
    let settled = moves.or(weights.le(N::zero()));
    let Some((yields, sum)) = yields else {
        return (moves.and(value / divisor), moves.and(value.abs()), settled);
    };
    let scale = moves.and((value - yields * sum) / (length * (weights + yields)));
    (scale, (scale * divisor).abs(), settled)
}

/// Moves them: `a -= w_a s d`, `b += w_b s d`.
#[inline(always)]
fn moved<N: Number>(one: [N; 4], other: [N; 4], scale: N) -> ([N; 4], [N; 4]) {
    let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
    let d = a - b;
    ((a - d * (wa * scale)).with(wa), (b + d * (wb * scale)).with(wb))
}

/// Both, along where the rods pointed when the substep began, as [`project_rod_from_start`](crate::constraints::project_rod_from_start) does where
/// that can be, and to the nearest point elsewhere, as where `may`, a mask, is not set.
#[inline(always)]
pub(super) fn project_from_start<L: Lanes>(
    one: [L; 4],
    other: [L; 4],
    (from, to): ([L; 4], [L; 4]),
    rest: L,
    may: L,
) -> ([L; 4], [L; 4], L, L) {
    let (nearest, error, moves) = stretch(one, other, rest);
    let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
    let (d, bond) = (a - b, Vector::of(from).0 - Vector::of(to).0);
    let (weights, along, short) = (wa + wb, d.dot(bond), rest * rest);
    let usable = (short * L::splat(1.0 / 3.0)).lt(along).and(L::zero().lt(weights)).and(may);
    let (mut scale, mut pattern) =
        ((d.length_squared() - short) / (L::splat(2.0) * weights * along), bond);
    // A division less, nearly always.
    if !usable.all() {
        (scale, pattern) = (usable.select(scale, nearest), bond.or_else(usable, d));
    }
    let (a, b) = (a - pattern * (wa * scale), b + pattern * (wb * scale));
    (a.with(wa), b.with(wb), error, moves.or(usable))
}
