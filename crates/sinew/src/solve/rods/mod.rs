//! Hard rods, eight at a time: the hot loop of the solver, and the form in which a plan stores rods for it.
//!
//! Rods that are solved together have one colour, so no two of the eight share a particle and their order does not matter. The formula is that of
//! [`project_rod`](crate::constraints::project_rod), operation by operation ([`stretch`], [`moved`]). There are two kernels:
//!
//! - `packed`: particles as they lie in memory, `[x y z w]`, are transposed into lanes and back for every eight rods. For any mesh.
//! - `columns`: a cluster whose rods are mostly strided, as those of a grid, is transposed once, swept as columns of x, y, z and w, and transposed back. `soft`
//!   solves compliant distances of a grid there, with the same formula.

mod columns;
mod packed;
mod soft;

pub(super) use packed::max_error;
pub(super) use soft::compliance;

use core::ops::Range;

use crate::constraints::Distance;
use crate::lanes::{Columns, EightPairs, LANES, Lanes, Number, Vector};

/// cos² of 0.35 rad: the most that a rod may turn in a substep for its direction at the start of the substep to serve as the direction of correction.
pub(super) const COS_SQUARED: f32 = 0.882_43;

/// The rods of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rods {
    runs: Vec<RodRun>,
    /// Rest lengths of the runs, metres.
    rests: Vec<f32>,
    /// The batches that are swept in columns, by colour.
    strided_batches: Vec<StridedBatch>,
    /// Their rods with their rest lengths; NaN in lanes beyond the last rod.
    pairs: Vec<EightPairs>,
    /// Index at which odd rows begin in a column.
    half: usize,
    blocks: Vec<RodBlock>,
}

/// Rods of one colour, each two rows after the previous one, so that both their first and their second ends are neighbours in a column; or compliant distances
/// of one compliance. Rows count from the first one of the cluster batch.
#[derive(Clone, Debug)]
struct StridedBatch {
    /// Compliance, m/N; zero for rods.
    compliance: f32,
    /// Whether they connect neighbours of a column, and follow each other at four rows. Compliant distances only.
    neighbours: bool,
    /// Range of full batches of eight among the pairs.
    full: Range<usize>,
    /// Range of the partial batches, the last one of each run.
    tails: Range<usize>,
}

/// Strided rods: `(a, b), (a + s, b + s), (a + 2s, b + 2s), …`
#[derive(Clone, Copy, Debug, PartialEq)]
struct RodRun {
    a: u32,
    b: u32,
    /// The stride `s`, 1 or 2.
    step: u32,
    /// Offset of its rest lengths, which are padded to a multiple of eight.
    rests: u32,
    count: u32,
}

/// Capacity of the columns, in cluster batches of the largest kind. A wavefront has about one of them in flight for each substep.
const MAX_IN_FLIGHT: usize = 16;

/// Eight rods of one colour at any rows. Unused lanes repeat the first rod: they compute and write the same values.
#[derive(Clone, Copy, Debug)]
struct RodBlock {
    a: [u32; LANES],
    b: [u32; LANES],
    rest: [f32; LANES],
}

/// Lengths of the lists.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RodCounts {
    runs: usize,
    rests: usize,
    strided_batches: usize,
    pairs: usize,
    blocks: usize,
    /// Index at which odd rows begin in a column.
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

    /// Truncates the lists to earlier lengths; keeps the memory.
    pub(super) fn truncate(&mut self, counts: &RodCounts) {
        self.runs.truncate(counts.runs);
        self.rests.truncate(counts.rests);
        self.strided_batches.truncate(counts.strided_batches);
        self.pairs.truncate(counts.pairs);
        self.blocks.truncate(counts.blocks);
        self.set_half(counts.half);
    }

    /// Adds the rods of one colour, sorted by their first particles, and returns the ranges of their runs and blocks. `alone` marks rods that share particles:
    /// each gets a block of its own.
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

    /// Like [`add`](Self::add), for a cluster batch of these rows that is swept in columns: returns the ranges of strided batches and of blocks.
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
        self.reserve(rows.len());
        let (begin, mut tails) = (self.pairs.len(), Vec::new());
        for RodRun { a, b, rests, count, .. } in self.runs.split_off(runs) {
            let lengths = &self.rests[rests as usize..][..count as usize];
            for (some, along) in lengths.chunks(LANES).zip((0..).step_by(2 * LANES)) {
                let mut eight = [f32::NAN; LANES];
                eight[..some.len()].copy_from_slice(some);
                let (a, b) = (a - rows.start + along, b - rows.start + along);
                let pair = EightPairs::new(a, b, eight, self.half);
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

    /// Gives columns capacity for the cluster batches of this many rows that a [wavefront](super::wavefront) has in flight.
    fn reserve(&mut self, rows: usize) {
        self.set_half(self.half.max(Columns::half(MAX_IN_FLIGHT * rows.next_power_of_two())));
    }

    fn set_half(&mut self, half: usize) {
        let old = core::mem::replace(&mut self.half, half);
        if half != old {
            self.pairs.iter_mut().for_each(|pair| *pair = pair.moved(old, half));
        }
    }

    /// Index at which odd rows begin in the columns that rods are swept in.
    pub(super) fn half(&self) -> usize {
        self.half
    }

    /// Extracts runs of these strides from some rods; the remaining ones are appended to `loose`.
    fn find_runs(
        &mut self,
        rods: &[Distance],
        steps: &[u32],
        min_tail: usize,
        loose: &mut Vec<Distance>,
    ) {
        let mut rest = rods;
        while let Some(first) = rest.first() {
            let (step, length) = run(rest, steps);
            // A partial batch may be worth lanes of its own.
            let over = length % LANES;
            let count = if over >= min_tail { length } else { length - over };
            if count > 0 {
                let ((a, b), rests) = (ends(first), self.rests.len() as u32);
                self.runs.push(RodRun { a, b, step, rests, count: count as u32 });
                self.rests.extend(rest[..count].iter().map(|rod| rod.rest));
                self.rests.resize(self.rests.len().next_multiple_of(LANES), first.rest);
            }
            // If the first rod begins no run, the second one still may.
            let taken = if count > 0 { length } else { 1 };
            loose.extend_from_slice(&rest[count..taken]);
            rest = &rest[taken..];
        }
    }

    /// The rest lengths of a run, in eights.
    #[inline(always)]
    fn rests_of(&self, run: &RodRun) -> &[[f32; LANES]] {
        let eights = (run.count as usize).div_ceil(LANES);
        self.rests[run.rests as usize..][..eights * LANES].as_chunks().0
    }
}

impl RodBlock {
    /// A block of one to eight rods.
    fn of(rods: &[Distance]) -> Self {
        let rod = |lane: usize| rods.get(lane).unwrap_or(&rods[0]);
        Self {
            a: core::array::from_fn(|lane| ends(rod(lane)).0),
            b: core::array::from_fn(|lane| ends(rod(lane)).1),
            rest: core::array::from_fn(|lane| rod(lane).rest),
        }
    }
}

/// Under-relaxation: the part of their errors that rods correct in a sweep which distributes contradictory errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Relaxation {
    /// Share of the error beyond the tolerance that is corrected.
    pub(crate) share: f32,
    /// Error that is left uncorrected, as a share of the rest length.
    pub(crate) tolerance: f32,
}

/// The part of their errors that rods correct in a sweep. A compile-time constant of a kernel, except where it is an `Option`.
pub(super) trait Correction: Copy {
    /// The shares for eight rods; `None` for all of the error.
    fn share<N: Number>(self, error: N, rest: N) -> Option<N>;
}

/// All of every error.
#[derive(Clone, Copy)]
pub(super) struct FullCorrection;

impl Correction for FullCorrection {
    #[inline(always)]
    fn share<N: Number>(self, _: N, _: N) -> Option<N> {
        None
    }
}

impl Correction for Relaxation {
    #[inline(always)]
    fn share<N: Number>(self, error: N, rest: N) -> Option<N> {
        let beyond = (error - rest * N::splat(self.tolerance)) / error;
        // NaN where the error is zero.
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

/// Projects both ends to the nearest point, or part of the way. Returns the ends, the errors, and a mask of the rods that are done: projected, or with both
/// ends pinned.
#[inline(always)]
pub(super) fn project<N: Number>(
    one: [N; 4],
    other: [N; 4],
    rest: N,
    correction: impl Correction,
) -> ([N; 4], [N; 4], N, N) {
    let (mut scale, error, moves) = stretch(one, other, rest);
    if let Some(share) = correction.share(error, rest) {
        scale = scale * share;
    }
    let (one, other) = moved(one, other, scale);
    (one, other, error, moves)
}

/// The particles of a rod, lower row first. The formula is symmetric in them.
pub(in crate::solve) fn ends(rod: &Distance) -> (u32, u32) {
    (rod.a.min(rod.b), rod.a.max(rod.b))
}

/// The stride and the length of the run that begins with the first rod.
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

/// The correction of eight rods: the multiplier `s` of their direction, the error, metres, and a mask of those that are done, because they have a direction or
/// no end that can move.
#[inline(always)]
fn stretch<N: Number>(one: [N; 4], other: [N; 4], rest: N) -> (N, N, N) {
    let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
    stretch_of((a - b).length(), [wa, wb], rest, None)
}

/// Like [`stretch`], given the lengths. Compliant rods pass `α/h²`, 1/kg, and their accumulated multipliers; their error is how far they are moved.
///
/// As [`project_rod`](crate::constraints::project_rod): with `d = a - b`, `s = (‖d‖ - L)/(‖d‖ (w_a + w_b))`. A compliance α reduces the error by `α/h² Λ` and
/// adds to the effective inverse mass: `s = (‖d‖ - L - Λ α/h²)/(‖d‖ (w_a + w_b + α/h²))`, and `Λ` grows by `s ‖d‖` (see
/// [`multiplier`](crate::constraints::SubstepContext)).
#[inline(always)]
fn stretch_of<N: Number>(length: N, [wa, wb]: [N; 2], rest: N, alpha: Option<(N, N)>) -> (N, N, N) {
    let (value, weights) = (length - rest, wa + wb);
    let divisor = length * weights;
    let moves = N::zero().lt(divisor);
    // A rod between two pins is done even if its ends coincide; along the edge of a flag there are many such rods.
    let settled = moves.or(weights.le(N::zero()));
    let Some((alpha, sum)) = alpha else {
        return (moves.and(value / divisor), moves.and(value.abs()), settled);
    };
    let scale = moves.and((value - alpha * sum) / (length * (weights + alpha)));
    (scale, (scale * divisor).abs(), settled)
}

/// Moves both ends: `a -= w_a s d`, `b += w_b s d`.
#[inline(always)]
fn moved<N: Number>(one: [N; 4], other: [N; 4], scale: N) -> ([N; 4], [N; 4]) {
    let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
    let d = a - b;
    ((a - d * (wa * scale)).with(wa), (b + d * (wb * scale)).with(wb))
}

/// Projects both ends along the rods' directions at the start of the substep, as [`project_rod_from_start`](crate::constraints::project_rod_from_start) does,
/// where that is possible and the mask `may` is set, and to the nearest point elsewhere.
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
    // Saves a division in nearly all cases.
    if !usable.all() {
        (scale, pattern) = (usable.select(scale, nearest), bond.or_else(usable, d));
    }
    let (a, b) = (a - pattern * (wa * scale), b + pattern * (wb * scale));
    (a.with(wa), b.with(wb), error, moves.or(usable))
}
