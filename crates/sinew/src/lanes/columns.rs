//! Particles as columns of x, y, z and w (`SoA`), with access to eight consecutive entries at a time and few bounds checks.
//!
//! Even and odd rows are stored apart, so that pairs of neighbouring rows `(2k, 2k + 1)` are also contiguous: eight even rows, and eight odd ones.
#![allow(unsafe_code)]

use core::marker::PhantomData;

use glam::Vec4;

use super::{InstructionSet, LANES, Lanes, kernel};

/// Positions and inverse masses of consecutive rows. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    /// x, y, z, w one after the other; in each the even rows from 0 on, and the odd rows from `half` on.
    lines: Vec<Line>,
    half: usize,
}

/// A cache line. Eight numbers that lie across two lines cost twice as much.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Line([f32; LINE]);

const LINE: usize = 16;

impl Columns {
    /// Where the odd rows begin in a column for a number of rows. Up to seven lanes beyond the last row are loaded, and stored unchanged.
    ///
    /// The eight half columns begin at different offsets modulo 4096 bytes. They are used side by side, and a core compares only the last twelve bits of two
    /// addresses to find that a load may depend on an earlier store (4K aliasing).
    pub(crate) fn half(rows: usize) -> usize {
        const WAY: usize = 64 * LINE;
        const OFF: usize = 9 * LINE;
        let least = rows.div_ceil(2) + LANES;
        least.saturating_sub(OFF).next_multiple_of(WAY) + OFF
    }

    /// The index of a row in a column with its odd rows from `half` on.
    #[inline(always)]
    fn place(row: u32, half: usize) -> usize {
        (row / 2) as usize + (row % 2) as usize * half
    }

    /// The index of a row.
    #[inline(always)]
    pub(crate) fn at(&self, row: u32) -> usize {
        Self::place(row, self.half)
    }

    /// `x y z w` at an index.
    #[inline(always)]
    pub(crate) fn get(&self, at: usize) -> Vec4 {
        let numbers = self.numbers();
        let of = |column: usize| numbers[2 * self.half * column + at];
        Vec4::new(of(0), of(1), of(2), of(3))
    }

    /// Writes `x y z` at an index.
    #[inline(always)]
    pub(crate) fn set(&mut self, at: usize, p: Vec4) {
        for (column, number) in [p.x, p.y, p.z].into_iter().enumerate() {
            let at = 2 * self.half * column + at;
            self.numbers_mut()[at] = number;
        }
    }

    /// Makes room for columns with their odd rows from `half` on, rounded up to a multiple of sixteen. The contents are unspecified. With debug assertions they
    /// are NaN, so that reading an entry that was never written shows in the results.
    pub(crate) fn reset(&mut self, half: usize) {
        self.half = half.next_multiple_of(LINE);
        if cfg!(debug_assertions) {
            self.lines.clear();
        }
        let unwritten = if cfg!(debug_assertions) { f32::NAN } else { 0.0 };
        self.lines.resize(8 * self.half / LINE, Line([unwritten; LINE]));
    }

    /// Moves some rows, of which the first is even, to the front.
    pub(crate) fn keep(&mut self, rows: core::ops::Range<usize>) {
        let (half, lanes) = (self.half, rows.start / 2..rows.end.div_ceil(2));
        self.numbers_mut().chunks_mut(half).for_each(|of| of.copy_within(lanes.clone(), 0));
    }

    /// Zeroes sixteen rows, as far as they are in range.
    pub(crate) fn blank(&mut self, row: usize) {
        let half = self.half;
        for row in row..row + 2 * LANES {
            let (lane, odd) = (row / 2, row % 2);
            let lines = self.numbers_mut().chunks_mut(half).skip(odd).step_by(2);
            lines.filter_map(|line| line.get_mut(lane)).for_each(|number| *number = 0.0);
        }
    }

    /// Copies particles into the rows from `row` on, an even number.
    pub(crate) fn transpose_in(
        &mut self,
        row: usize,
        packed: &[Vec4],
        instructions: InstructionSet,
    ) {
        transpose_in(self, row, packed, instructions);
    }

    /// Copies them back.
    pub(crate) fn transpose_out(
        &mut self,
        row: usize,
        packed: &mut [Vec4],
        instructions: InstructionSet,
    ) {
        transpose_out(self, row, packed, instructions);
    }

    /// A view for access to eight entries at a time.
    #[inline(always)]
    pub(crate) fn view(&mut self) -> ColumnsView<'_> {
        let column = 2 * self.half;
        let numbers = self.numbers_mut();
        debug_assert_eq!(numbers.len(), 4 * column);
        ColumnsView { numbers: numbers.as_mut_ptr(), column, columns: PhantomData }
    }

    #[inline(always)]
    fn numbers(&self) -> &[f32] {
        // SAFETY: a line is sixteen floats and nothing else.
        unsafe { core::slice::from_raw_parts(self.lines.as_ptr().cast(), self.lines.len() * LINE) }
    }

    #[inline(always)]
    fn numbers_mut(&mut self) -> &mut [f32] {
        let count = self.lines.len() * LINE;
        // SAFETY: a line is sixteen floats and nothing else.
        unsafe { core::slice::from_raw_parts_mut(self.lines.as_mut_ptr().cast(), count) }
    }
}

kernel!(
    /// Transposes particles into columns, from an even row on.
    fn transpose_in<L: Lanes>(to: &mut Columns, row: usize, packed: &[Vec4]) {
        let (eights, last) = packed.as_chunks::<LANES>();
        let half = to.half;
        let [x, y, z, w] = halves(to.numbers_mut(), half, row / 2);
        let columns = x.0.iter_mut().zip(x.1).zip(y.0.iter_mut().zip(y.1));
        let others = z.0.iter_mut().zip(z.1).zip(w.0.iter_mut().zip(w.1));
        for ((eight, (x, y)), (z, w)) in eights.iter().zip(columns).zip(others) {
            let [a, b, c, d] = L::run_by_parity(eight, 0);
            a.store_halves(x.0, x.1);
            b.store_halves(y.0, y.1);
            c.store_halves(z.0, z.1);
            d.store_halves(w.0, w.1);
        }
        for (row, &p) in (row + packed.len() - last.len()..).zip(last) {
            let at = to.at(row as u32);
            to.set(at, p);
            let at = 6 * to.half + at;
            to.numbers_mut()[at] = p.w;
        }
    }
);

kernel!(
    /// Transposes them back.
    fn transpose_out<L: Lanes>(from: &mut Columns, row: usize, packed: &mut [Vec4]) {
        let count = row + packed.len();
        let (eights, last) = packed.as_chunks_mut::<LANES>();
        let half = from.half;
        let [x, y, z, w] = halves(from.numbers_mut(), half, row / 2);
        let columns = x.0.iter().zip(x.1).zip(y.0.iter().zip(y.1));
        let others = z.0.iter().zip(z.1).zip(w.0.iter().zip(w.1));
        for ((eight, (x, y)), (z, w)) in eights.iter_mut().zip(columns).zip(others) {
            let (x, y) = (L::load_halves(x.0, x.1), L::load_halves(y.0, y.1));
            let (z, w) = (L::load_halves(z.0, z.1), L::load_halves(w.0, w.1));
            L::put_run_by_parity(eight, 0, [x, y, z, w]);
        }
        for (row, p) in (count - last.len()..).zip(last) {
            *p = from.get(from.at(row as u32));
        }
    }
);

type HalfColumn<'a> = &'a mut [[f32; LANES / 2]];

/// The even and the odd rows of each column, in chunks of four, from a lane on.
#[inline(always)]
fn halves(numbers: &mut [f32], half: usize, from: usize) -> [(HalfColumn<'_>, HalfColumn<'_>); 4] {
    let (xy, zw) = numbers.split_at_mut(4 * half);
    let ((x, y), (z, w)) = (xy.split_at_mut(2 * half), zw.split_at_mut(2 * half));
    [fours(x, half, from), fours(y, half, from), fours(z, half, from), fours(w, half, from)]
}

#[inline(always)]
fn fours(column: &mut [f32], half: usize, from: usize) -> (HalfColumn<'_>, HalfColumn<'_>) {
    let (even, odd) = column.split_at_mut(half);
    (even[from..].as_chunks_mut().0, odd[from..].as_chunks_mut().0)
}

/// Columns with access to eight consecutive entries from any index on.
pub(crate) struct ColumnsView<'a> {
    numbers: *mut f32,
    /// Length of each of the four columns.
    column: usize,
    columns: PhantomData<&'a mut [f32]>,
}

/// Two runs of eight consecutive entries in a column, the first and the second ends of eight pairs, with a number for each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EightPairs {
    /// The indices at which they begin.
    a: u32,
    b: u32,
    pub(crate) numbers: [f32; LANES],
}

impl EightPairs {
    /// Runs that begin with rows `a` and `b` and go on by two rows, in columns with their odd rows from `half` on.
    pub(crate) fn new(a: u32, b: u32, numbers: [f32; LANES], half: usize) -> Self {
        let place = |row: u32| Columns::place(row, half) as u32;
        Self { a: place(a), b: place(b), numbers }
    }

    /// Sixteen rows from `first` on, each two after the one before, as eight pairs of neighbours in a column, in the order of
    /// [`PAIR_ORDER`](super::PAIR_ORDER).
    pub(crate) fn of_neighbours(first: u32, numbers: [f32; LANES], half: usize) -> Self {
        Self::new(first, first + 2 * LANES as u32, numbers, half)
    }

    /// The same rows in columns with their odd rows from `to` on instead of `half`.
    pub(crate) fn moved(&self, half: usize, to: usize) -> Self {
        let (a, b) = self.rows(0, half);
        Self::new(a, b, self.numbers, to)
    }

    /// The rows of one lane.
    pub(crate) fn rows(&self, lane: usize, half: usize) -> (u32, u32) {
        let row = |first: u32| {
            let odd = first as usize >= half;
            (2 * (first as usize - if odd { half } else { 0 } + lane)) as u32 + u32::from(odd)
        };
        (row(self.a), row(self.b))
    }
}

/// A pair that has been checked to be within the columns.
#[derive(Clone, Copy)]
struct CheckedPair<'a> {
    a: usize,
    b: usize,
    numbers: &'a [f32; LANES],
}

impl<'a> CheckedPair<'a> {
    #[inline(always)]
    fn of(eights: &ColumnsView, pair: &'a EightPairs, from: usize) -> Self {
        let (a, b) = eights.find(pair, from);
        Self { a, b, numbers: &pair.numbers }
    }
}

/// A computation on pairs in three steps that are pipelined: while the square root of one pair is pending, the division of the one before is, and the one
/// before that is moved. A trait rather than closures, which cannot be forced to be inlined.
pub(crate) trait PairKernel<L> {
    /// The distances between the two ends.
    fn length(&self, one: [L; 3], other: [L; 3]) -> L;
    /// The factors by which to move the ends, from their `w`, the numbers of the pair and the distances.
    fn scale(&mut self, weights: [L; 2], numbers: L, length: L) -> L;
    /// The ends moved by these factors.
    fn moved(&self, one: [L; 4], other: [L; 4], numbers: L, scale: L) -> ([L; 4], [L; 4]);
}

impl ColumnsView<'_> {
    /// `x y z w` of the eight entries from `at` on. Panics if they are out of range.
    #[inline(always)]
    pub(crate) fn load<L: Lanes>(&self, at: usize) -> [L; 4] {
        assert!(at + LANES <= self.column, "an eight that does not exist");
        // SAFETY: they are within a column, as just checked.
        unsafe { self.get(at) }
    }

    /// Writes `x y z` of them. Panics if they are out of range.
    #[inline(always)]
    pub(crate) fn put<L: Lanes>(&mut self, at: usize, eight: [L; 4]) {
        assert!(at + LANES <= self.column, "an eight that does not exist");
        // SAFETY: they are within a column, as just checked.
        unsafe { self.set(at, eight) }
    }

    /// Writes `w` of them. Panics if they are out of range.
    #[inline(always)]
    pub(crate) fn put_fourth<L: Lanes>(&mut self, at: usize, fourth: L) {
        assert!(at + LANES <= self.column, "an eight that does not exist");
        // SAFETY: they are within the last of four columns, as just checked; `ColumnsView` borrows the columns exclusively.
        unsafe { fourth.store(&mut *self.numbers.add(3 * self.column + at).cast()) }
    }

    /// `x y z w` of eight consecutive rows, in the order of [`PARITY_ORDER`](super::PARITY_ORDER). `at` has the indices of the first two. Panics if they are out
    /// of range.
    #[inline(always)]
    pub(crate) fn load_run<L: Lanes>(&self, at: [usize; 2]) -> [L; 4] {
        assert!(at[0].max(at[1]) + LANES / 2 <= self.column, "an eight that does not exist");
        // SAFETY: they are within a column, as just checked, and all four are as long; `ColumnsView` borrows the columns exclusively.
        let of = |column: usize| unsafe {
            let column = self.numbers.add(column * self.column);
            (&*column.add(at[0]).cast(), &*column.add(at[1]).cast())
        };
        let (x, y, z, w) = (of(0), of(1), of(2), of(3));
        [
            L::load_halves(x.0, x.1),
            L::load_halves(y.0, y.1),
            L::load_halves(z.0, z.1),
            L::load_halves(w.0, w.1),
        ]
    }

    /// Writes `x y z` of them. Panics if they are out of range.
    #[inline(always)]
    pub(crate) fn put_run<L: Lanes>(&mut self, at: [usize; 2], [x, y, z, _]: [L; 4]) {
        let end = at[0].max(at[1]) + LANES / 2;
        assert!(end <= self.column && at[0].abs_diff(at[1]) >= LANES / 2, "no such eight");
        // SAFETY: they are within a column, as just checked, and apart; `ColumnsView` borrows the columns exclusively.
        unsafe {
            let (first, second) = (self.numbers.add(at[0]), self.numbers.add(at[1]));
            let (y_, z_) = (self.column, 2 * self.column);
            x.store_halves(&mut *first.cast(), &mut *second.cast());
            y.store_halves(&mut *first.add(y_).cast(), &mut *second.add(y_).cast());
            z.store_halves(&mut *first.add(z_).cast(), &mut *second.add(z_).cast());
        }
    }

    /// The indices of the two runs of a pair, counted from lane `from` of the columns on. Panics if they are out of range.
    #[inline(always)]
    pub(crate) fn find(&self, pair: &EightPairs, from: usize) -> (usize, usize) {
        let (a, b) = (from + pair.a as usize, from + pair.b as usize);
        assert!(a.max(b) + LANES <= self.column, "an eight that does not exist");
        (a, b)
    }

    /// Applies `work` to some pairs, of which no two have a used lane in common; with `NEIGHBOURS` to pairs [of neighbours](EightPairs::of_neighbours). `from`
    /// as in [`find`](Self::find).
    #[inline(always)]
    pub(crate) fn each<L: Lanes, const NEIGHBOURS: bool>(
        &mut self,
        pairs: &[EightPairs],
        from: usize,
        work: &mut impl PairKernel<L>,
    ) {
        let [first, pairs @ ..] = pairs else { return };
        let mut old = CheckedPair::of(self, first, from);
        // SAFETY: a `CheckedPair` is within these columns.
        let mut scale = unsafe {
            let length = self.length::<L, NEIGHBOURS>(old, work);
            self.scale::<L, NEIGHBOURS>(old, length, work)
        };
        if let [second, pairs @ ..] = pairs {
            let mut now = CheckedPair::of(self, second, from);
            // SAFETY: a `CheckedPair` is within these columns.
            let mut length = unsafe { self.length::<L, NEIGHBOURS>(now, work) };
            for pair in pairs {
                let next = CheckedPair::of(self, pair, from);
                // SAFETY: a `CheckedPair` is within these columns.
                unsafe {
                    let following = self.length::<L, NEIGHBOURS>(next, work);
                    let after = self.scale::<L, NEIGHBOURS>(now, length, work);
                    self.apply::<L, NEIGHBOURS>(old, scale, work);
                    (length, scale) = (following, after);
                }
                (old, now) = (now, next);
            }
            // SAFETY: a `CheckedPair` is within these columns.
            unsafe {
                let after = self.scale::<L, NEIGHBOURS>(now, length, work);
                self.apply::<L, NEIGHBOURS>(old, scale, work);
                (old, scale) = (now, after);
            }
        }
        // SAFETY: a `CheckedPair` is within these columns.
        unsafe { self.apply::<L, NEIGHBOURS>(old, scale, work) }
    }

    /// # Safety
    /// The pair was checked against these columns. The same holds for the next two functions.
    #[inline(always)]
    unsafe fn length<L: Lanes, const NEIGHBOURS: bool>(
        &self,
        at: CheckedPair,
        work: &impl PairKernel<L>,
    ) -> L {
        // SAFETY: as the caller guarantees.
        unsafe {
            let ([x, y, z, _], [p, q, r, _]) = self.both::<L, NEIGHBOURS>(at);
            work.length([x, y, z], [p, q, r])
        }
    }

    #[inline(always)]
    unsafe fn scale<L: Lanes, const NEIGHBOURS: bool>(
        &self,
        at: CheckedPair,
        length: L,
        work: &mut impl PairKernel<L>,
    ) -> L {
        // SAFETY: as the caller guarantees.
        unsafe {
            let ([_, _, _, one], [_, _, _, other]) = self.both::<L, NEIGHBOURS>(at);
            work.scale([one, other], L::load(at.numbers), length)
        }
    }

    #[inline(always)]
    unsafe fn apply<L: Lanes, const NEIGHBOURS: bool>(
        &mut self,
        at: CheckedPair,
        scale: L,
        work: &impl PairKernel<L>,
    ) {
        // SAFETY: as the caller guarantees.
        unsafe {
            let numbers = L::load(at.numbers);
            let (one, other) = self.both::<L, NEIGHBOURS>(at);
            let (one, other) = work.moved(one, other, numbers, scale);
            if NEIGHBOURS {
                let ([x, y, z, w], [p, q, r, _]) = (one, other);
                let ((x, p), (y, q), (z, r)) = (x.interleave(p), y.interleave(q), z.interleave(r));
                self.set(at.a, [x, y, z, w]);
                self.set(at.b, [p, q, r, w]);
            } else {
                self.set(at.a, one);
                self.set(at.b, other);
            }
        }
    }

    /// `x y z w` of the first and of the second ends.
    ///
    /// # Safety
    /// The pair was checked against these columns.
    #[inline(always)]
    unsafe fn both<L: Lanes, const NEIGHBOURS: bool>(&self, at: CheckedPair) -> ([L; 4], [L; 4]) {
        // SAFETY: as the caller guarantees.
        let (one, other) = unsafe { (self.get::<L>(at.a), self.get::<L>(at.b)) };
        if !NEIGHBOURS {
            return (one, other);
        }
        let ([x, y, z, w], [p, q, r, s]) = (one, other);
        let ((x, p), (y, q), (z, r), (w, s)) =
            (x.deinterleave(p), y.deinterleave(q), z.deinterleave(r), w.deinterleave(s));
        ([x, y, z, w], [p, q, r, s])
    }

    /// # Safety
    /// `at + LANES` is not beyond the length of a column.
    #[inline(always)]
    unsafe fn get<L: Lanes>(&self, at: usize) -> [L; 4] {
        // SAFETY: they are within the first of four columns, as the caller guarantees, and the other columns are as long; `ColumnsView` borrows the columns
        // exclusively.
        unsafe {
            let x = self.numbers.add(at);
            let (y, z, w) = (x.add(self.column), x.add(2 * self.column), x.add(3 * self.column));
            [L::load(&*x.cast()), L::load(&*y.cast()), L::load(&*z.cast()), L::load(&*w.cast())]
        }
    }

    /// # Safety
    /// `at + LANES` is not beyond the length of a column.
    #[inline(always)]
    unsafe fn set<L: Lanes>(&mut self, at: usize, [a, b, c, _]: [L; 4]) {
        // SAFETY: as in `get`; one reference at a time.
        unsafe {
            let x = self.numbers.add(at);
            let (y, z) = (x.add(self.column), x.add(2 * self.column));
            a.store(&mut *x.cast());
            b.store(&mut *y.cast());
            c.store(&mut *z.cast());
        }
    }
}
