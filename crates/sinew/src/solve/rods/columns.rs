//! Rods on particles as columns of x, y, z and w: what a grid is swept in.
//!
//! In columns, eight rods of a run are eight loads, the formula, and six stores; packed, half of the work is turning particles into lanes and back. A cluster of 2048
//! particles is 32 kB as columns, so they stay in a core's own cache from turning in to turning out.

use core::ops::Range;

use glam::Vec4;

use super::{Block, Rods, Run, project};
use crate::constraints::project_rod;
use crate::lanes::{LANES, Lanes};
use crate::particles::Places;

/// Positions and inverse masses of consecutive rows, a column each for even rows and for odd ones. Scratch.
///
/// So the rods along a row, `(2k, 2k + 1)` and then `(2k + 1, 2k + 2)`, are runs of neighbours like all others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Columns {
    /// x, y, z, w: of each, those of even rows from 0 on, those of odd rows from `half` on.
    each: [Vec<f32>; 4],
    half: usize,
}

impl Rods {
    /// Projects groups of rods (their runs and blocks) once, in their order, on the particles of `rows`; returns the largest error found, metres.
    #[inline(always)]
    pub(crate) fn sweep_columns<'a, L: Lanes>(
        &self,
        places: &mut Places,
        groups: impl Iterator<Item = (&'a Range<usize>, &'a Range<usize>)>,
        rows: Range<u32>,
        columns: &mut Columns,
    ) -> f32 {
        let span = places.at(rows.start)..places.at(rows.end);
        columns.turn_in::<L>(&places.position[span.clone()]);
        let (mut worst, mut parted) = (L::zero(), 0.0_f32);
        for (runs, blocks) in groups {
            for run in &self.runs[runs.clone()] {
                let rests = self.rests_of(run);
                worst = columns.sweep_run::<L>(run, rows.start, rests, worst, &mut parted);
            }
            for block in &self.blocks[blocks.clone()] {
                worst = columns.sweep_block::<L>(block, rows.start, worst, &mut parted);
            }
        }
        columns.turn_out::<L>(&mut places.position[span]);
        worst.largest(parted)
    }
}

impl Columns {
    /// Where a row is.
    #[inline(always)]
    fn at(&self, row: u32) -> usize {
        (row / 2) as usize + (row % 2) as usize * self.half
    }

    /// Takes particles.
    #[inline(always)]
    fn turn_in<L: Lanes>(&mut self, packed: &[Vec4]) {
        // Up to seven lanes beyond the last row are loaded, and stored as they were.
        self.half = packed.len().div_ceil(2) + LANES;
        for column in &mut self.each {
            column.resize(2 * self.half, 0.0);
        }
        let half = self.half;
        let [x, y, z, w] = &mut self.each;
        let ((xe, xo), (ye, yo)) = (x.split_at_mut(half), y.split_at_mut(half));
        let ((ze, zo), (we, wo)) = (z.split_at_mut(half), w.split_at_mut(half));
        let (eights, last) = packed.as_chunks::<LANES>();
        let xs = fours(xe).iter_mut().zip(fours(xo));
        let ys = fours(ye).iter_mut().zip(fours(yo));
        let zs = fours(ze).iter_mut().zip(fours(zo));
        let ws = fours(we).iter_mut().zip(fours(wo));
        for ((((eight, x), y), z), w) in eights.iter().zip(xs).zip(ys).zip(zs).zip(ws) {
            let [a, b, c, d] = L::run_by_parity(eight, 0);
            a.store_halves(x.0, x.1);
            b.store_halves(y.0, y.1);
            c.store_halves(z.0, z.1);
            d.store_halves(w.0, w.1);
        }
        for (row, p) in (packed.len() - last.len()..).zip(last) {
            let at = self.at(row as u32);
            for (column, value) in self.each.iter_mut().zip(p.to_array()) {
                column[at] = value;
            }
        }
    }

    /// Gives them back.
    #[inline(always)]
    fn turn_out<L: Lanes>(&mut self, packed: &mut [Vec4]) {
        let count = packed.len();
        let half = self.half;
        let [x, y, z, w] = &mut self.each;
        let ((xe, xo), (ye, yo)) = (x.split_at_mut(half), y.split_at_mut(half));
        let ((ze, zo), (we, wo)) = (z.split_at_mut(half), w.split_at_mut(half));
        let (eights, last) = packed.as_chunks_mut::<LANES>();
        let xs = fours(xe).iter().zip(fours(xo));
        let ys = fours(ye).iter().zip(fours(yo));
        let zs = fours(ze).iter().zip(fours(zo));
        let ws = fours(we).iter().zip(fours(wo));
        for ((((eight, x), y), z), w) in eights.iter_mut().zip(xs).zip(ys).zip(zs).zip(ws) {
            let (x, y) = (L::load_halves(x.0, x.1), L::load_halves(y.0, y.1));
            let (z, w) = (L::load_halves(z.0, z.1), L::load_halves(w.0, w.1));
            L::put_run_by_parity(eight, 0, [x, y, z, w]);
        }
        for (row, p) in (count - last.len()..).zip(last) {
            *p = self.row(self.at(row as u32));
        }
    }

    fn row(&self, at: usize) -> Vec4 {
        let [x, y, z, w] = &self.each;
        Vec4::new(x[at], y[at], z[at], w[at])
    }

    /// A run of step 2. Its rods share no particle, so that its first ends lie before its second ones, or in the other half.
    #[inline(always)]
    fn sweep_run<L: Lanes>(
        &mut self,
        run: &Run,
        first: u32,
        rests: &[[f32; LANES]],
        mut worst: L,
        parted: &mut f32,
    ) -> L {
        let (a, b) = (self.at(run.a - first), self.at(run.b - first));
        let whole = run.count as usize / LANES;
        let mut all_move = L::zero().same(L::zero());
        let [x, y, z, w] = &mut self.each;
        let (xa, xb) = two_stretches(x, a, b, whole);
        let (ya, yb) = two_stretches(y, a, b, whole);
        let (za, zb) = two_stretches(z, a, b, whole);
        let (wa, wb) = two_stretches(w, a, b, whole);
        let ones = xa.iter_mut().zip(ya).zip(za).zip(wa.iter());
        let others = xb.iter_mut().zip(yb).zip(zb).zip(wb.iter());
        for ((one, other), rest) in ones.zip(others).zip(rests) {
            let (((ax, ay), az), aw) = one;
            let (((bx, by), bz), bw) = other;
            let one = [L::load(ax), L::load(ay), L::load(az), L::load(aw)];
            let other = [L::load(bx), L::load(by), L::load(bz), L::load(bw)];
            let (one, other, error, moves) = project(one, other, L::load(rest), None);
            one[0].store(ax);
            one[1].store(ay);
            one[2].store(az);
            other[0].store(bx);
            other[1].store(by);
            other[2].store(bz);
            worst = error.max(worst);
            all_move = all_move.and(moves);
        }
        if let Some(rest) = rests.get(whole) {
            let live = L::load(&FIRST[run.count as usize % LANES]);
            let (a, b) = (a + whole * LANES, b + whole * LANES);
            let (one, other) = (self.eight::<L>(a), self.eight::<L>(b));
            let (one_, other_, error, moves) = project(one, other, L::load(rest), None);
            // The lanes beyond may be rows at the other ends, which therefore come second.
            self.put_eight(a, live, one_, one);
            self.put_eight(b, live, other_, other);
            worst = live.and(error).max(worst);
            all_move = all_move.and(live.select(moves, all_move));
        }
        if !all_move.all() {
            let count = run.count as usize;
            *parted = parted.max(self.part(a, b, &rests.as_flattened()[..count]));
        }
        worst
    }

    #[inline(always)]
    fn eight<L: Lanes>(&self, at: usize) -> [L; 4] {
        let [x, y, z, w] = &self.each;
        [L::load(eight(x, at)), L::load(eight(y, at)), L::load(eight(z, at)), L::load(eight(w, at))]
    }

    /// Writes the new ones where a mask is set, and the old ones elsewhere.
    #[inline(always)]
    fn put_eight<L: Lanes>(&mut self, at: usize, live: L, new: [L; 4], old: [L; 4]) {
        for i in 0..3 {
            let column = &mut self.each[i][at..at + LANES].as_chunks_mut::<LANES>().0[0];
            live.select(new[i], old[i]).store(column);
        }
    }

    /// Eight rods of any rows.
    #[inline(always)]
    fn sweep_block<L: Lanes>(
        &mut self,
        block: &Block,
        first: u32,
        worst: L,
        parted: &mut f32,
    ) -> L {
        let (mut a, mut b) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            (a[lane], b[lane]) = (self.at(block.a[lane] - first), self.at(block.b[lane] - first));
        }
        let (one, other) = (self.gather::<L>(&a), self.gather::<L>(&b));
        let (one, other, error, moves) = project(one, other, L::load(&block.rest), None);
        self.scatter(&a, one);
        self.scatter(&b, other);
        if !moves.all() {
            for lane in 0..LANES {
                *parted = parted.max(self.part(a[lane], b[lane], &[block.rest[lane]]));
            }
        }
        error.max(worst)
    }

    #[inline(always)]
    fn gather<L: Lanes>(&self, at: &[usize; LANES]) -> [L; 4] {
        let mut lanes = [[0.0; LANES]; 4];
        for (lanes, column) in lanes.iter_mut().zip(&self.each) {
            for (lane, &at) in lanes.iter_mut().zip(at) {
                *lane = column[at];
            }
        }
        let [x, y, z, w] = &lanes;
        [L::load(x), L::load(y), L::load(z), L::load(w)]
    }

    #[inline(always)]
    fn scatter<L: Lanes>(&mut self, at: &[usize; LANES], [x, y, z, _]: [L; 4]) {
        let lanes = [x.array(), y.array(), z.array()];
        for (lanes, column) in lanes.iter().zip(&mut self.each) {
            for (&lane, &at) in lanes.iter().zip(at) {
                column[at] = lane;
            }
        }
    }

    /// Parts those of some neighbouring rods whose ends are in one place, one after the other: it is rare. What has a direction was projected.
    #[cold]
    fn part(&mut self, a: usize, b: usize, rests: &[f32]) -> f32 {
        let mut worst = 0.0_f32;
        for (i, &rest) in rests.iter().enumerate() {
            let ends = [a + i, b + i];
            let mut pair = ends.map(|at| self.row(at));
            // As the kernel decides: a distance whose square is nothing is none.
            let d = (pair[0] - pair[1]).truncate();
            if d.x * d.x + d.y * d.y + d.z * d.z == 0.0 {
                worst = worst.max(project_rod(&mut pair, 0, 1, rest));
                for (at, p) in ends.into_iter().zip(pair) {
                    let [x, y, z, _] = &mut self.each;
                    (x[at], y[at], z[at]) = (p.x, p.y, p.z);
                }
            }
        }
        worst
    }
}

/// Masks of the first few lanes.
const FIRST: [[f32; LANES]; LANES] = {
    let mut masks = [[0.0; LANES]; LANES];
    let mut count = 0;
    while count < LANES {
        let mut lane = 0;
        while lane < count {
            masks[count][lane] = f32::from_bits(u32::MAX);
            lane += 1;
        }
        count += 1;
    }
    masks
};

#[inline(always)]
fn eight(column: &[f32], at: usize) -> &[f32; LANES] {
    &column[at..at + LANES].as_chunks().0[0]
}

/// A column four by four.
#[inline(always)]
fn fours(column: &mut [f32]) -> &mut [[f32; LANES / 2]] {
    column.as_chunks_mut().0
}

/// Two stretches of a column of so many eights, which do not overlap.
#[inline(always)]
fn two_stretches(
    column: &mut [f32],
    a: usize,
    b: usize,
    eights: usize,
) -> (&mut [[f32; LANES]], &mut [[f32; LANES]]) {
    let count = eights * LANES;
    let (low, high) = column.split_at_mut(a.max(b));
    let first = low[a.min(b)..].get_mut(..count).unwrap_or_default();
    let second = high.get_mut(..count).unwrap_or_default();
    let (first, second) = (first.as_chunks_mut().0, second.as_chunks_mut().0);
    if a < b { (first, second) } else { (second, first) }
}
