//! Compliant distances of a grid, solved as rods with compliance: strided ones in eights in columns. The others are left to the kernel for any soft distances.

use core::ops::Range;

use super::columns::{Compliance, RodPull, Tail, separate};
use super::{Rods, StridedBatch, ends};
use crate::constraints::{Distance, Softness, SubstepContext, project};
use crate::lanes::{
    Columns, EightPairs, InstructionSet, LANES, Lanes, PAIR_ORDER, SetLanes, Work, with,
};

/// How compliant distances of one stride follow each other.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pattern {
    /// At two rows, so that both their first and their second ends are neighbours in a column.
    Apart,
    /// At four rows, between particles two rows apart: pairs of neighbours in a column.
    Neighbours,
}

/// Fewest distances that are worth a batch of their own.
const MIN_BATCH: usize = 2;

impl Pattern {
    /// Unused lanes are written back as they were read, so their particles must not be moved in between: the first and the second ends may have no row in
    /// common.
    fn of(stride: u32) -> Option<Self> {
        match stride {
            2 => Some(Self::Neighbours),
            _ if stride % 2 == 1 || stride >= 2 * LANES as u32 => Some(Self::Apart),
            _ => None,
        }
    }

    /// Rows from one to the next.
    fn step(self) -> u32 {
        if self == Self::Apart { 2 } else { 4 }
    }

    /// Lane of the distance that follows the first one by this many steps.
    fn lane(self, steps: usize) -> usize {
        if self == Self::Apart { steps } else { PAIR_ORDER[steps] }
    }
}

/// The compliance, m/N, of a distance that can be swept here: a compliant one without damping; `None` for any other.
pub(in crate::solve) fn compliance(d: &Distance) -> Option<f32> {
    match d.softness {
        Softness::Compliant { compliance, damping: 0.0 } if compliance > 0.0 => Some(compliance),
        _ => None,
    }
}

impl Rods {
    /// Adds soft distances of one colour in a cluster batch of these rows. Returns the range of their strided batches, and the distances that are not strided.
    pub(crate) fn add_soft_to_columns(
        &mut self,
        distances: &[Distance],
        rows: &Range<u32>,
    ) -> (Range<usize>, Vec<Distance>) {
        let (begin, mut loose) = (self.strided_batches.len(), Vec::new());
        self.reserve(rows.len());
        // Distances that may be in one batch, and within it those that may be in one group of eight.
        let batch = |d: &Distance| {
            let compliance = compliance(d).unwrap_or(0.0);
            (ends(d).1 - ends(d).0, compliance.to_bits())
        };
        let class =
            |d: &Distance| Pattern::of(batch(d).0).map_or(0, |pattern| ends(d).0 % pattern.step());
        // Stable sort: the input is sorted by first row, and each class stays so.
        let mut sorted = distances.to_vec();
        sorted.sort_by_key(|d| (batch(d), class(d)));
        for own in sorted.chunk_by(|one, other| batch(one) == batch(other)) {
            match (Pattern::of(batch(&own[0]).0), compliance(&own[0])) {
                (Some(pattern), Some(compliance)) => {
                    let (first, mut tails) = (self.pairs.len(), Vec::new());
                    for own in own.chunk_by(|one, other| class(one) == class(other)) {
                        self.add_eights(own, pattern, rows.start, &mut tails, &mut loose);
                    }
                    let full = first..self.pairs.len();
                    self.pairs.extend(tails);
                    let (neighbours, tails) =
                        (pattern == Pattern::Neighbours, full.end..self.pairs.len());
                    self.strided_batches.push(StridedBatch { compliance, neighbours, full, tails });
                }
                _ => loose.extend_from_slice(own),
            }
        }
        (begin..self.strided_batches.len(), loose)
    }

    /// Adds the distances of one class, ascending. Unused lanes have the rest length NaN.
    fn add_eights(
        &mut self,
        mut left: &[Distance],
        pattern: Pattern,
        first: u32,
        tails: &mut Vec<EightPairs>,
        loose: &mut Vec<Distance>,
    ) {
        while let [begin, ..] = left {
            let (a, b) = ends(begin);
            let steps = |d: &Distance| ((ends(d).0 - a) / pattern.step()) as usize;
            let count = left.iter().take_while(|d| steps(d) < LANES).count();
            if count < MIN_BATCH {
                loose.extend_from_slice(&left[..count]);
            } else {
                let mut rests = [f32::NAN; LANES];
                for d in &left[..count] {
                    rests[pattern.lane(steps(d))] = d.rest;
                }
                let (a, b) = (a - first, b - first);
                let pair = match pattern {
                    Pattern::Apart => EightPairs::new(a, b, rests, self.half),
                    Pattern::Neighbours => EightPairs::of_neighbours(a, rests, self.half),
                };
                if count == LANES { &mut self.pairs } else { &mut *tails }.push(pair);
            }
            left = &left[count..];
        }
    }

    /// Projects soft strided batches once, in order, on particles in columns; `rows` are the first row of the cluster batch and the first row of the columns.
    /// `sums` are their accumulated multipliers, followed by those of others; empty if none are kept. Returns the largest movement, metres, and the number of
    /// multipliers used.
    pub(crate) fn sweep_soft(
        &self,
        columns: &mut Columns,
        batches: Range<usize>,
        rows: (u32, u32),
        sums: &mut [f32],
        (substep_context, instructions): (SubstepContext, InstructionSet),
    ) -> (f32, usize) {
        let from = (rows.0 - rows.1) as usize / 2;
        let batches = &self.strided_batches[batches];
        let sweep = SweepSoft { rods: self, columns, batches, from, sums, substep_context };
        with(instructions, sweep)
    }
}

/// The work of [`Rods::sweep_soft`].
struct SweepSoft<'a> {
    rods: &'a Rods,
    columns: &'a mut Columns,
    batches: &'a [StridedBatch],
    /// Number of lanes from the first row of the columns to the first row of the cluster batch.
    from: usize,
    sums: &'a mut [f32],
    substep_context: SubstepContext,
}

impl Work for SweepSoft<'_> {
    type Output = (f32, usize);

    #[inline(always)]
    fn run<L: Lanes>(self) -> (f32, usize) {
        let Self { rods, columns, batches, from, sums, substep_context } = self;
        let (mut worst, mut separated, mut done) = (L::zero(), 0.0_f32, 0);
        for batch in batches {
            let begin = done;
            let alpha =
                L::splat(batch.compliance * (1.0 / (substep_context.h * substep_context.h)));
            let (full, tails) = (&rods.pairs[batch.full.clone()], &rods.pairs[batch.tails.clone()]);
            let soft = Soft { alpha, sums: &mut *sums, done };
            let mut pull = RodPull { worst, all_move: L::zero().same(L::zero()), soft };
            if batch.neighbours {
                columns.view().each::<L, true>(full, from, &mut pull);
            } else {
                columns.view().each::<L, false>(full, from, &mut pull);
            }
            let mut tail = Tail(pull);
            if batch.neighbours {
                columns.view().each::<L, true>(tails, from, &mut tail);
            } else {
                columns.view().each::<L, false>(tails, from, &mut tail);
            }
            let Tail(RodPull { worst: found, all_move, soft }) = tail;
            (worst, done) = (found, soft.done);
            if !all_move.all() {
                let eights = full.iter().chain(tails);
                let own = sums.get_mut(begin..).unwrap_or_default();
                let found = separate_all(columns, eights, batch, from, own, substep_context);
                separated = separated.max(found);
            }
        }
        (worst.largest(separated), done)
    }
}

/// Accumulated multipliers of soft distances; `done` of them have been used.
struct Soft<'a, L> {
    alpha: L,
    sums: &'a mut [f32],
    done: usize,
}

impl<L: Lanes> Compliance<L> for Soft<'_, L> {
    #[inline(always)]
    fn terms(&self, live: u32) -> Option<(L, L)> {
        let sums = self.sums.get(self.done..).unwrap_or_default();
        let sum = match sums.first_chunk() {
            _ if sums.is_empty() => L::zero(),
            Some(eight) if live == L::ALL => L::load(eight),
            _ => {
                let mut eight = [0.0; LANES];
                for (lane, sum) in SetLanes(live).zip(sums) {
                    eight[lane] = *sum;
                }
                L::load(&eight)
            }
        };
        Some((self.alpha, sum))
    }

    #[inline(always)]
    fn accumulate(&mut self, live: u32, change: L) {
        let sums = self.sums.get_mut(self.done..).unwrap_or_default();
        self.done += live.count_ones() as usize;
        match sums.first_chunk_mut() {
            Some(eight) if live == L::ALL => (L::load(eight) + change).store(eight),
            _ => {
                let change = change.array();
                for (lane, sum) in SetLanes(live).zip(sums) {
                    *sum += change[lane];
                }
            }
        }
    }
}

/// Separates coincident ends, one distance after the other.
#[cold]
fn separate_all<'a>(
    columns: &mut Columns,
    eights: impl Iterator<Item = &'a EightPairs>,
    batch: &StridedBatch,
    from: usize,
    sums: &mut [f32],
    substep_context: SubstepContext,
) -> f32 {
    let (mut worst, mut done) = (0.0_f32, 0);
    for pair in eights {
        let (a, b) = columns.view().find(pair, from);
        for lane in (0..LANES).filter(|lane| !pair.numbers[*lane].is_nan()) {
            let pairs = 2 * PAIR_ORDER[lane];
            let ends = match batch.neighbours {
                false => [a + lane, b + lane],
                true => [a + pairs, a + pairs + 1],
            };
            let mut none = 0.0;
            let sum = sums.get_mut(done).unwrap_or(&mut none);
            done += 1;
            worst = worst.max(separate(columns, ends, |points| {
                let distance = Distance::new(0, 1, pair.numbers[lane]);
                let distance = distance.with_compliance(batch.compliance);
                let start = *points;
                project(points, &start, &distance, substep_context, sum)
            }));
        }
    }
    worst
}
