//! Rods on particles stored as columns of x, y, z and w, the form in which grids are swept.
//!
//! In columns, eight rods of a strided batch take eight loads, the formula, and six stores; packed, half of the work is transposing particles into lanes and
//! back. So a cluster, which fits into a core's L1 cache, is transposed once, swept, and transposed back. Where nothing else reads its particles in between, it
//! stays in columns for all substeps of a step ([`wavefront`](crate::solve)).

use core::ops::Range;

use glam::Vec4;

use super::{
    Correction, FullCorrection, Relaxation, RodBlock, Rods, StridedBatch, max_error, moved,
    project, stretch, stretch_of,
};
use crate::constraints::project_rod;
use crate::lanes::{Columns, InstructionSet, LANES, Lanes, PairKernel, Vector, Work, with};
use crate::particles::Places;

/// Ranges of the strided batches and of the blocks of a colour.
type Colour<'a> = (&'a Range<usize>, &'a Range<usize>);

impl Rods {
    /// Projects groups of rods (their strided batches and blocks) once, in order, on particles in columns. `rows` are the first row of the cluster batch and
    /// the first row of the columns. Returns the largest error found, metres.
    pub(crate) fn sweep_columns<'a>(
        &self,
        columns: &mut Columns,
        groups: impl Iterator<Item = Colour<'a>>,
        rows: (u32, u32),
        relaxation: Option<Relaxation>,
        instructions: InstructionSet,
    ) -> f32 {
        let rods = self;
        match relaxation {
            None => with(
                instructions,
                SweepColumns { rods, columns, groups, rows, correction: FullCorrection },
            ),
            Some(correction) => {
                with(instructions, SweepColumns { rods, columns, groups, rows, correction })
            }
        }
    }

    /// The remaining error of such groups: largest error, metres, and largest share of a rest length. Moves nothing.
    pub(crate) fn measure_columns<'a>(
        &self,
        places: &Places,
        groups: impl Iterator<Item = Colour<'a>>,
        rows: Range<u32>,
        columns: &mut Columns,
        instructions: InstructionSet,
    ) -> (f32, f32) {
        let range = places.at(rows.start)..places.at(rows.end);
        columns.reset(self.half);
        columns.transpose_in(0, &places.position[range], instructions);
        self.measure_transposed(columns, groups, (rows.start, rows.start), instructions)
    }

    /// Like [`measure_columns`](Self::measure_columns), on particles that are already in columns. `rows` as in [`sweep_columns`](Self::sweep_columns).
    pub(crate) fn measure_transposed<'a>(
        &self,
        columns: &mut Columns,
        groups: impl Iterator<Item = Colour<'a>>,
        rows: (u32, u32),
        instructions: InstructionSet,
    ) -> (f32, f32) {
        with(instructions, MeasureColumns { rods: self, columns, groups, rows })
    }
}

/// The work of [`Rods::sweep_columns`].
struct SweepColumns<'a, G, C> {
    rods: &'a Rods,
    columns: &'a mut Columns,
    groups: G,
    rows: (u32, u32),
    correction: C,
}

impl<'a, G: Iterator<Item = Colour<'a>>, C: Correction> Work for SweepColumns<'_, G, C> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { rods, columns, groups, rows, correction } = self;
        let (mut worst, mut separated) = (L::zero(), 0.0_f32);
        for (strided_batches, blocks) in groups {
            for strided_batches in &rods.strided_batches[strided_batches.clone()] {
                let from = (rows.0 - rows.1) as usize / 2;
                let which = (strided_batches, from);
                worst =
                    rods.sweep_strided::<L, C>(columns, which, correction, worst, &mut separated);
            }
            for block in &rods.blocks[blocks.clone()] {
                worst = sweep_block::<L, C>(
                    columns,
                    (block, rows.1),
                    correction,
                    worst,
                    &mut separated,
                );
            }
        }
        worst.largest(separated)
    }
}

/// The work of [`Rods::measure_transposed`].
struct MeasureColumns<'a, G> {
    rods: &'a Rods,
    columns: &'a mut Columns,
    groups: G,
    rows: (u32, u32),
}

impl<'a, G: Iterator<Item = Colour<'a>>> Work for MeasureColumns<'_, G> {
    type Output = (f32, f32);

    #[inline(always)]
    fn run<L: Lanes>(self) -> (f32, f32) {
        let Self { rods, columns, groups, rows } = self;
        let from = (rows.0 - rows.1) as usize / 2;
        let mut worst = (L::zero(), L::zero());
        for (strided_batches, blocks) in groups {
            for strided_batches in &rods.strided_batches[strided_batches.clone()] {
                let view = columns.view();
                for pair in &rods.pairs[strided_batches.full.start..strided_batches.tails.end] {
                    let ((a, b), rest) = (view.find(pair, from), L::load(&pair.numbers));
                    let (_, left, _) = stretch(view.load(a), view.load(b), rest);
                    let left = rest.le(rest).and(left);
                    let share = L::zero().lt(rest).and(left / rest);
                    worst = (left.max(worst.0), share.max(worst.1));
                }
            }
            for block in &rods.blocks[blocks.clone()] {
                let [one, other] = [&block.a, &block.b]
                    .map(|rows_of| rows_of.map(|row| columns.get(columns.at(row - rows.1))));
                let rest = L::load(&block.rest);
                worst = max_error(worst, L::run(&one, 0), L::run(&other, 0), rest);
            }
        }
        (worst.0.largest(0.0), worst.1.largest(0.0))
    }
}

impl Rods {
    /// Sweeps a strided batch of a colour. `from` is the number of lanes from the first row of the columns to the first row of the cluster batch.
    #[inline(always)]
    fn sweep_strided<L: Lanes, C: Correction>(
        &self,
        columns: &mut Columns,
        (strided_batches, from): (&StridedBatch, usize),
        correction: C,
        worst: L,
        separated: &mut f32,
    ) -> L {
        let mut pull = RodPull { worst, all_move: L::zero().same(L::zero()), soft: correction };
        columns.view().each::<L, false>(&self.pairs[strided_batches.full.clone()], from, &mut pull);
        let mut tail = Tail(pull);
        columns.view().each::<L, false>(
            &self.pairs[strided_batches.tails.clone()],
            from,
            &mut tail,
        );
        let Tail(RodPull { worst, all_move, .. }) = tail;
        if !all_move.all() {
            for pair in &self.pairs[strided_batches.full.start..strided_batches.tails.end] {
                let (a, b) = columns.view().find(pair, from);
                for (lane, &rest) in pair.numbers.iter().enumerate().filter(|one| !one.1.is_nan()) {
                    *separated = separated.max(separate_rod(columns, [a + lane, b + lane], rest));
                }
            }
        }
        worst
    }
}

/// The compliance of rods. A compile-time constant of the kernel.
pub(super) trait Compliance<L: Lanes> {
    /// `α/h²` of eight rods, 1/kg, and their accumulated multipliers; `live` is a bit mask of the lanes in use.
    fn terms(&self, live: u32) -> Option<(L, L)>;
    /// The part of such errors that is corrected; `None` for all.
    #[inline(always)]
    fn share(&self, _error: L, _rest: L) -> Option<L> {
        None
    }
    /// Adds to the accumulated multipliers.
    fn accumulate(&mut self, live: u32, change: L);
}

/// Hard rods have no compliance, but may be corrected in part.
impl<L: Lanes, C: Correction> Compliance<L> for C {
    #[inline(always)]
    fn terms(&self, _: u32) -> Option<(L, L)> {
        None
    }

    #[inline(always)]
    fn share(&self, error: L, rest: L) -> Option<L> {
        Correction::share(*self, error, rest)
    }

    #[inline(always)]
    fn accumulate(&mut self, _: u32, _: L) {}
}

/// State of a sweep over full batches of eight: the largest errors, and the lanes in which all rods could be projected.
pub(super) struct RodPull<L, S> {
    pub(super) worst: L,
    pub(super) all_move: L,
    pub(super) soft: S,
}

impl<L: Lanes, S: Compliance<L>> RodPull<L, S> {
    /// The correction of eight rods, of which some lanes are live: multiplier of the direction, error, and mask of those that could be projected.
    #[inline(always)]
    fn pull(&mut self, weights: [L; 2], rest: L, length: L, live: u32) -> (L, L, L) {
        let (mut scale, error, moves) = stretch_of(length, weights, rest, self.soft.terms(live));
        if let Some(share) = self.soft.share(error, rest) {
            scale = scale * share;
        }
        self.soft.accumulate(live, scale * length);
        (scale, error, moves)
    }
}

impl<L: Lanes, S: Compliance<L>> PairKernel<L> for RodPull<L, S> {
    #[inline(always)]
    fn length(&self, [x, y, z]: [L; 3], [p, q, r]: [L; 3]) -> L {
        (Vector::new(x, y, z) - Vector::new(p, q, r)).length()
    }

    #[inline(always)]
    fn scale(&mut self, weights: [L; 2], rest: L, length: L) -> L {
        let (scale, error, moves) = self.pull(weights, rest, length, L::ALL);
        self.worst = error.max(self.worst);
        self.all_move = self.all_move.and(moves);
        scale
    }

    #[inline(always)]
    fn moved(&self, one: [L; 4], other: [L; 4], _: L, scale: L) -> ([L; 4], [L; 4]) {
        moved(one, other, scale)
    }
}

/// The same for partial batches. Lanes beyond the last rod may hold anything, NaN included, and belong to other constraints.
pub(super) struct Tail<P>(pub(super) P);

impl<L: Lanes, S: Compliance<L>> PairKernel<L> for Tail<RodPull<L, S>> {
    #[inline(always)]
    fn length(&self, one: [L; 3], other: [L; 3]) -> L {
        self.0.length(one, other)
    }

    #[inline(always)]
    fn scale(&mut self, weights: [L; 2], rest: L, length: L) -> L {
        let live = rest.le(rest);
        let (scale, error, moves) = self.0.pull(weights, rest, length, live.bits());
        self.0.worst = live.and(error).max(self.0.worst);
        self.0.all_move = self.0.all_move.and(live.select(moves, self.0.all_move));
        live.and(scale)
    }

    /// Subtracts zero in unused lanes, which changes no bit. A blend would be compiled to masked stores, which take as long as all the rest.
    #[inline(always)]
    fn moved(&self, one: [L; 4], other: [L; 4], rest: L, scale: L) -> ([L; 4], [L; 4]) {
        let ((a, wa), (b, wb)) = (Vector::of(one), Vector::of(other));
        let (live, d) = (rest.le(rest), a - b);
        let only = |v: Vector<L>| Vector::new(live.and(v.x), live.and(v.y), live.and(v.z));
        ((a - only(d) * (wa * scale)).with(wa), (b - only(-d) * (wb * scale)).with(wb))
    }
}

/// Eight rods of any rows; the columns begin with row `first`.
#[inline(always)]
fn sweep_block<L: Lanes, C: Correction>(
    columns: &mut Columns,
    (block, first): (&RodBlock, u32),
    correction: C,
    worst: L,
    separated: &mut f32,
) -> L {
    let (mut a, mut b) = ([0; LANES], [0; LANES]);
    let mut packed = [Vec4::ZERO; 2 * LANES];
    for lane in 0..LANES {
        a[lane] = columns.at(block.a[lane] - first);
        b[lane] = columns.at(block.b[lane] - first);
        (packed[lane], packed[LANES + lane]) = (columns.get(a[lane]), columns.get(b[lane]));
    }
    let (one, other) = (L::run(&packed, 0), L::run(&packed, LANES));
    let (one, other, error, moves) = project(one, other, L::load(&block.rest), correction);
    L::put_run(&mut packed, 0, one);
    L::put_run(&mut packed, LANES, other);
    for lane in 0..LANES {
        columns.set(a[lane], packed[lane]);
        columns.set(b[lane], packed[LANES + lane]);
    }
    if !moves.all() {
        for lane in 0..LANES {
            let found = separate_rod(columns, [a[lane], b[lane]], block.rest[lane]);
            *separated = separated.max(found);
        }
    }
    error.max(worst)
}

#[cold]
fn separate_rod(columns: &mut Columns, ends: [usize; 2], rest: f32) -> f32 {
    separate(columns, ends, |pair| project_rod(pair, 0, 1, rest))
}

/// Projects a pair of entries if they coincide, which is rarely needed, and returns what the projection returns. Distances with a direction have been projected
/// already.
pub(super) fn separate(
    columns: &mut Columns,
    ends: [usize; 2],
    project: impl FnOnce(&mut [Vec4; 2]) -> f32,
) -> f32 {
    let mut pair = ends.map(|at| columns.get(at));
    // The same test as in the kernel: a distance whose square underflows to zero counts as none.
    let d = (pair[0] - pair[1]).truncate();
    if d.x * d.x + d.y * d.y + d.z * d.z != 0.0 {
        return 0.0;
    }
    let found = project(&mut pair);
    columns.set(ends[0], pair[0]);
    columns.set(ends[1], pair[1]);
    found
}
