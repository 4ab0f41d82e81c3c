//! Rods on particles as they lie in memory.

use core::ops::Range;

use glam::Vec4;

use super::{Relaxation, RodRun, Rods, StridedBatch, project, project_from_start};
use crate::constraints::{GradientAt, project_rod};
use crate::lanes::{InstructionSet, LANES, Lanes, SetLanes, Vector, kernel};
use crate::particles::Places;

impl Rods {
    /// Projects some runs and blocks once, and returns the largest error found, metres.
    pub(crate) fn sweep(
        &self,
        places: &mut Places,
        runs: Range<usize>,
        blocks: Range<usize>,
        (gradient_at, relaxation): (GradientAt, Option<Relaxation>),
        instructions: InstructionSet,
    ) -> f32 {
        let (rods, which) = (self, (runs, blocks));
        match gradient_at {
            GradientAt::Current => {
                sweep_packed::<false>(rods, places, which, relaxation, instructions)
            }
            GradientAt::StepStart => sweep_packed::<true>(rods, places, which, None, instructions),
        }
    }

    /// The remaining error of some runs and blocks: largest error, metres, and largest share of a rest length. Moves nothing.
    pub(crate) fn measure(
        &self,
        positions: &[Vec4],
        runs: Range<usize>,
        blocks: Range<usize>,
        instructions: InstructionSet,
    ) -> (f32, f32) {
        measure_packed(self, positions, runs, blocks, instructions)
    }

    /// Projects strided batches of a cluster batch on packed particles, along the rods' directions at the start of the substep, which columns do not store.
    pub(crate) fn sweep_strided_from_start(
        &self,
        places: &mut Places,
        strided_batches: Range<usize>,
        rows: &Range<u32>,
        instructions: InstructionSet,
    ) -> f32 {
        let strided_batches = &self.strided_batches[strided_batches];
        sweep_from_start(self, places, strided_batches, rows.start, instructions)
    }
}

kernel!(
    /// The kernel of [`Rods::sweep`]. `START`: along the rods' directions at the start of the substep.
    fn sweep_packed<L: Lanes, const START: bool>(
        rods: &Rods,
        places: &mut Places<'_>,
        which: (Range<usize>, Range<usize>),
        relaxation: Option<Relaxation>,
    ) -> f32 {
        let (runs, blocks) = which;
        let (mut worst, mut separated) = (L::zero(), 0.0_f32);
        for run in &rods.runs[runs] {
            let (rests, pattern) = (rods.rests_of(run), run.pattern());
            for (eight, rest) in rests.iter().enumerate() {
                let along = (eight * LANES) as u32;
                let whole = along + LANES as u32 <= run.count;
                let (a, b) = (run.a + along * run.step, run.b + along * run.step);
                let (a, b) = (places.at(a), places.at(b));
                if !whole || pattern == LoadPattern::Rows {
                    let left = run.count - along;
                    let rows = [run.rows(a, left), run.rows(b, left)];
                    let (found, together) =
                        eight_rods::<L, START>(places, rows, &run.padded(rest, left), relaxation);
                    (worst, separated) = (found.max(worst), separated.max(together));
                    continue;
                }
                let (one, other) = load::<L>(places.position, pattern, a, b);
                let rests = L::load(rest);
                let (one, other, error, moves) = if START {
                    let start = load::<L>(places.start, pattern, a, b);
                    project_from_start(one, other, start, rests, L::zero().same(L::zero()))
                } else {
                    project(one, other, rests, relaxation)
                };
                if pattern == LoadPattern::Pairs {
                    L::put_pairs(places.position, a, one, other);
                } else {
                    L::put_run(places.position, a, one);
                    L::put_run(places.position, b, other);
                }
                worst = error.max(worst);
                if !moves.all() {
                    let rows = [run.rows(a, LANES as u32), run.rows(b, LANES as u32)];
                    separated =
                        separated.max(separate(places.position, L::ALL ^ moves.bits(), rows, rest));
                }
            }
        }
        for block in &rods.blocks[blocks] {
            let rows = [less(&block.a, places.first), less(&block.b, places.first)];
            let (found, together) = eight_rods::<L, START>(places, rows, &block.rest, relaxation);
            (worst, separated) = (found.max(worst), separated.max(together));
        }
        worst.largest(separated)
    }
);

kernel!(
    /// The kernel of [`Rods::measure`].
    fn measure_packed<L: Lanes>(
        rods: &Rods,
        positions: &[Vec4],
        runs: Range<usize>,
        blocks: Range<usize>,
    ) -> (f32, f32) {
        let mut worst = (L::zero(), L::zero());
        for run in &rods.runs[runs] {
            for (eight, rest) in rods.rests_of(run).iter().enumerate() {
                let along = (eight * LANES) as u32;
                let left = run.count - along;
                let at = |row: u32| run.rows((row + along * run.step) as usize, left);
                let (one, other) = (L::rows(positions, &at(run.a)), L::rows(positions, &at(run.b)));
                worst = max_error(worst, one, other, L::load(&run.padded(rest, left)));
            }
        }
        for block in &rods.blocks[blocks] {
            let (one, other) = (L::rows(positions, &block.a), L::rows(positions, &block.b));
            worst = max_error(worst, one, other, L::load(&block.rest));
        }
        (worst.0.largest(0.0), worst.1.largest(0.0))
    }
);

/// Maximum of errors and strains with those of eight more rods. A rod between two pins counts as zero.
#[inline(always)]
pub(in crate::solve) fn max_error<L: Lanes>(
    (error, strain): (L, L),
    one: [L; 4],
    other: [L; 4],
    rest: L,
) -> (L, L) {
    let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
    let left = L::zero().lt(wa + wb).and(((a - b).length() - rest).abs());
    let share = L::zero().lt(rest).and(left / rest);
    (left.max(error), share.max(strain))
}

kernel!(
    /// The kernel of [`Rods::sweep_strided_from_start`]; `first` is the first row of the cluster batch.
    fn sweep_from_start<L: Lanes>(
        rods: &Rods,
        places: &mut Places<'_>,
        strided_batches: &[StridedBatch],
        first: u32,
    ) -> f32 {
        let (mut worst, mut separated) = (L::zero(), 0.0_f32);
        let first = places.at(first) as u32;
        for strided_batches in strided_batches {
            for pair in &rods.pairs[strided_batches.full.start..strided_batches.tails.end] {
                let (mut ends, mut rest) = ([[0; LANES]; 2], pair.numbers);
                for lane in 0..LANES {
                    // Unused lanes repeat the first rod.
                    let own = if rest[lane].is_nan() { 0 } else { lane };
                    rest[lane] = rest[own];
                    let (a, b) = pair.rows(own, rods.half);
                    (ends[0][lane], ends[1][lane]) = (first + a, first + b);
                }
                let (found, together) = eight_rods::<L, true>(places, ends, &rest, None);
                (worst, separated) = (found.max(worst), separated.max(together));
            }
        }
        worst.largest(separated)
    }
);

/// Eight rods of any rows. Returns the errors found, and the largest error of those with coincident ends.
#[inline(always)]
fn eight_rods<L: Lanes, const START: bool>(
    places: &mut Places,
    [a, b]: [[u32; LANES]; 2],
    rest: &[f32; LANES],
    relaxation: Option<Relaxation>,
) -> (L, f32) {
    let (one, other) = (L::rows(places.position, &a), L::rows(places.position, &b));
    let (one, other, error, moves) = if START {
        let start = (L::rows(places.start, &a), L::rows(places.start, &b));
        project_from_start(one, other, start, L::load(rest), L::zero().same(L::zero()))
    } else {
        project(one, other, L::load(rest), relaxation)
    };
    L::put_rows(places.position, &a, one);
    L::put_rows(places.position, &b, other);
    let stuck = L::ALL ^ moves.bits();
    (error, if stuck == 0 { 0.0 } else { separate(places.position, stuck, [a, b], rest) })
}

/// How eight rods of a run are loaded.
#[derive(Clone, Copy, PartialEq, Eq)]
enum LoadPattern {
    /// Both ends from consecutive rows.
    Runs,
    /// From consecutive rows, each connected to the next one.
    Pairs,
    /// Row by row.
    Rows,
}

impl RodRun {
    #[inline(always)]
    fn pattern(&self) -> LoadPattern {
        match self.step {
            1 => LoadPattern::Runs,
            2 if self.b == self.a + 1 => LoadPattern::Pairs,
            _ => LoadPattern::Rows,
        }
    }

    /// The rows of eight of its rods, beginning at `first`; where fewer are `left`, the first one is repeated.
    #[inline(always)]
    fn rows(&self, first: usize, left: u32) -> [u32; LANES] {
        let mut rows = [first as u32; LANES];
        for (lane, row) in (0..).zip(&mut rows) {
            *row += if lane < left { lane * self.step } else { 0 };
        }
        rows
    }

    /// Their rest lengths, padded likewise.
    #[inline(always)]
    fn padded(&self, rest: &[f32; LANES], left: u32) -> [f32; LANES] {
        let mut padded = *rest;
        padded.iter_mut().skip(left as usize).for_each(|rest_| *rest_ = rest[0]);
        padded
    }
}

/// Both ends of eight rods of a run.
#[inline(always)]
fn load<L: Lanes>(packed: &[Vec4], pattern: LoadPattern, a: usize, b: usize) -> ([L; 4], [L; 4]) {
    if pattern == LoadPattern::Pairs {
        L::pairs(packed, a)
    } else {
        (L::run(packed, a), L::run(packed, b))
    }
}

/// Converts rows to indices into slices that begin with row `first`.
#[inline(always)]
fn less(rows: &[u32; LANES], first: u32) -> [u32; LANES] {
    let mut places = *rows;
    if first != 0 {
        for place in &mut places {
            *place = place.wrapping_sub(first);
        }
    }
    places
}

/// Projects those of eight rods whose ends coincide or are pinned, one after the other.
#[cold]
fn separate(
    positions: &mut [Vec4],
    stuck: u32,
    rows: [[u32; LANES]; 2],
    rest: &[f32; LANES],
) -> f32 {
    let mut worst = 0.0_f32;
    // Lanes that repeat the first rod count once.
    let again = |lane: usize| lane > 0 && rows.iter().all(|rows| rows[lane] == rows[0]);
    for lane in SetLanes(stuck).filter(|&lane| !again(lane)) {
        worst = worst.max(project_rod(positions, rows[0][lane], rows[1][lane], rest[lane]));
    }
    worst
}
