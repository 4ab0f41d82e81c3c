//! Particles as columns of x, y, z and w, and stretches of them that are read and written without asking for every eight whether it is there.
//!
//! Even rows and odd ones are kept apart, so that pairs of neighbours, too, are eights of neighbours: `(2k, 2k + 1)` is a stretch of even rows and one of odd
//! ones.
#![allow(unsafe_code)]

use core::marker::PhantomData;

use glam::Vec4;

use super::{LANES, Lanes};

/// Positions and inverse masses of consecutive rows. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    /// x, y, z, w one after the other; of each the even rows from 0 on, and the odd rows from `half` on.
    lines: Vec<Line>,
    half: usize,
}

/// As the cache has them: an eight that lies across two of them costs twice as much.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Line([f32; LINE]);

const LINE: usize = 16;

impl Columns {
    /// Where the odd rows begin in a column of so many rows. Up to seven lanes beyond the last row are loaded, and stored as they were.
    pub(crate) fn half(rows: usize) -> usize {
        (rows.div_ceil(2) + LANES).next_multiple_of(LINE)
    }

    /// Where a row is in a column whose odd rows begin at `half`.
    #[inline(always)]
    pub(crate) fn place(row: u32, half: usize) -> usize {
        (row / 2) as usize + (row % 2) as usize * half
    }

    /// The reverse.
    #[inline(always)]
    pub(crate) fn row(place: usize, half: usize) -> u32 {
        let (pair, odd) = if place < half { (place, 0) } else { (place - half, 1) };
        2 * pair as u32 + odd
    }

    #[inline(always)]
    fn at(&self, row: u32) -> usize {
        Self::place(row, self.half)
    }

    /// `x y z w` there.
    #[inline(always)]
    pub(crate) fn get(&self, at: usize) -> Vec4 {
        let numbers = self.numbers();
        let of = |column: usize| numbers[2 * self.half * column + at];
        Vec4::new(of(0), of(1), of(2), of(3))
    }

    /// Writes `x y z` there.
    #[inline(always)]
    pub(crate) fn set(&mut self, at: usize, p: Vec4) {
        for (column, number) in [p.x, p.y, p.z].into_iter().enumerate() {
            let at = 2 * self.half * column + at;
            self.numbers_mut()[at] = number;
        }
    }

    /// Takes particles.
    #[inline(always)]
    pub(crate) fn turn_in<L: Lanes>(&mut self, packed: &[Vec4]) {
        self.half = Self::half(packed.len());
        self.lines.resize(8 * self.half / LINE, Line([0.0; LINE]));
        let (eights, last) = packed.as_chunks::<LANES>();
        let half = self.half;
        let [x, y, z, w] = halves(self.numbers_mut(), half);
        let columns = x.0.iter_mut().zip(x.1).zip(y.0.iter_mut().zip(y.1));
        let others = z.0.iter_mut().zip(z.1).zip(w.0.iter_mut().zip(w.1));
        for ((eight, (x, y)), (z, w)) in eights.iter().zip(columns).zip(others) {
            let [a, b, c, d] = L::run_by_parity(eight, 0);
            a.store_halves(x.0, x.1);
            b.store_halves(y.0, y.1);
            c.store_halves(z.0, z.1);
            d.store_halves(w.0, w.1);
        }
        for (row, &p) in (packed.len() - last.len()..).zip(last) {
            let at = self.at(row as u32);
            self.set(at, p);
            let at = 6 * self.half + at;
            self.numbers_mut()[at] = p.w;
        }
    }

    /// Gives them back.
    #[inline(always)]
    pub(crate) fn turn_out<L: Lanes>(&mut self, packed: &mut [Vec4]) {
        let count = packed.len();
        let (eights, last) = packed.as_chunks_mut::<LANES>();
        let half = self.half;
        let [x, y, z, w] = halves(self.numbers_mut(), half);
        let columns = x.0.iter().zip(x.1).zip(y.0.iter().zip(y.1));
        let others = z.0.iter().zip(z.1).zip(w.0.iter().zip(w.1));
        for ((eight, (x, y)), (z, w)) in eights.iter_mut().zip(columns).zip(others) {
            let (x, y) = (L::load_halves(x.0, x.1), L::load_halves(y.0, y.1));
            let (z, w) = (L::load_halves(z.0, z.1), L::load_halves(w.0, w.1));
            L::put_run_by_parity(eight, 0, [x, y, z, w]);
        }
        for (row, p) in (count - last.len()..).zip(last) {
            *p = self.get(self.at(row as u32));
        }
    }

    /// A view in which eights are asked for one by one.
    #[inline(always)]
    pub(crate) fn eights(&mut self) -> Eights<'_> {
        let column = 2 * self.half;
        let numbers = self.numbers_mut();
        debug_assert_eq!(numbers.len(), 4 * column);
        Eights { numbers: numbers.as_mut_ptr(), column, columns: PhantomData }
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

type Fours<'a> = &'a mut [[f32; LANES / 2]];

/// The even and the odd rows of each column, four by four.
#[inline(always)]
fn halves(numbers: &mut [f32], half: usize) -> [(Fours<'_>, Fours<'_>); 4] {
    let (xy, zw) = numbers.split_at_mut(4 * half);
    let ((x, y), (z, w)) = (xy.split_at_mut(2 * half), zw.split_at_mut(2 * half));
    [fours(x, half), fours(y, half), fours(z, half), fours(w, half)]
}

#[inline(always)]
fn fours(column: &mut [f32], half: usize) -> (Fours<'_>, Fours<'_>) {
    let (even, odd) = column.split_at_mut(half);
    (even.as_chunks_mut().0, odd.as_chunks_mut().0)
}

/// Columns, eight by eight from any place on.
pub(crate) struct Eights<'a> {
    numbers: *mut f32,
    /// Length of each of the four columns.
    column: usize,
    columns: PhantomData<&'a mut [f32]>,
}

impl Eights<'_> {
    /// `x y z w` of the eight from a place on. Panics if they are not there.
    #[inline(always)]
    pub(crate) fn load<L: Lanes>(&self, at: u32) -> [L; 4] {
        assert!(at as usize + LANES <= self.column, "an eight that does not exist");
        // SAFETY: they are within the first of four columns, as just checked, and the other columns are as long; the borrow of the columns is ours.
        unsafe {
            let x = self.numbers.add(at as usize);
            let (y, z, w) = (x.add(self.column), x.add(2 * self.column), x.add(3 * self.column));
            [L::load(&*x.cast()), L::load(&*y.cast()), L::load(&*z.cast()), L::load(&*w.cast())]
        }
    }

    /// Writes `x y z` of them. Panics if they are not there.
    #[inline(always)]
    pub(crate) fn put<L: Lanes>(&mut self, at: u32, [a, b, c, _]: [L; 4]) {
        assert!(at as usize + LANES <= self.column, "an eight that does not exist");
        // SAFETY: as in `load`; one reference at a time.
        unsafe {
            let x = self.numbers.add(at as usize);
            let (y, z) = (x.add(self.column), x.add(2 * self.column));
            a.store(&mut *x.cast());
            b.store(&mut *y.cast());
            c.store(&mut *z.cast());
        }
    }
}
