//! Rods on particles as columns of x, y, z and w: what a grid is swept in.
//!
//! In columns, eight rods of a run are eight loads, the formula, and six stores; packed, half of the work is turning particles into lanes and back. So a cluster, which
//! fits into a core's first cache, is turned once, swept, and turned back.
//!

use core::ops::Range;

use super::{Block, Eight, Rods, moved, stretch};
use crate::constraints::project_rod;
use crate::lanes::{Columns, LANES, Lanes};
use crate::particles::Places;

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
            let eights = &self.eights[runs.clone()];
            worst = sweep_eights::<L>(columns, eights, worst, &mut parted);
            for block in &self.blocks[blocks.clone()] {
                worst = sweep_block::<L>(columns, block, &rows, worst, &mut parted);
            }
        }
        columns.turn_out::<L>(&mut places.position[span]);
        worst.largest(parted)
    }

    /// What is left to correct of the same: largest error, metres, and largest share of a rest length. Moves nothing.
    #[inline(always)]
    pub(crate) fn measure_columns<'a, L: Lanes>(
        &self,
        places: &Places,
        groups: impl Iterator<Item = (&'a Range<usize>, &'a Range<usize>)>,
        rows: Range<u32>,
        columns: &mut Columns,
    ) -> (f32, f32) {
        columns.turn_in::<L>(&places.position[places.at(rows.start)..places.at(rows.end)]);
        let (mut error, mut strain) = (L::zero(), L::zero());
        let mut loose = (0.0_f32, 0.0_f32);
        for (runs, blocks) in groups {
            let view = columns.eights();
            for eight in &self.eights[runs.clone()] {
                let rest = L::load(&eight.rest);
                let (_, left, _) = stretch(view.load(eight.a), view.load(eight.b), rest);
                let share = L::zero().lt(rest).and(left / rest);
                (error, strain) = (left.max(error), share.max(strain));
            }
            let (left, share) = self.measure::<L>(places.position, 0..0, blocks.clone());
            loose = (loose.0.max(left), loose.1.max(share));
        }
        (error.largest(loose.0), strain.largest(loose.1))
    }
}

/// The eights of a colour.
#[inline(always)]
fn sweep_eights<L: Lanes>(
    columns: &mut Columns,
    eights: &[Eight],
    mut worst: L,
    parted: &mut f32,
) -> L {
    let mut view = columns.eights();
    let mut all_move = L::zero().same(L::zero());
    for eight in eights {
        let (one, other, rest) = (view.load(eight.a), view.load(eight.b), L::load(&eight.rest));
        let (scale, error, moves) = stretch(one, other, rest);
        let (mut one_, mut other_) = moved(one, other, scale);
        let live = rest.le(rest);
        if !live.all() {
            // What lies beyond the last rod may be anything, NaN too, and belongs to others.
            (one_, other_) = (only(live, one_, one), only(live, other_, other));
        }
        // The lanes beyond the first ends may be rows at the second ones, which therefore are written last.
        view.put(eight.a, one_);
        view.put(eight.b, other_);
        worst = error.max(worst);
        all_move = all_move.and(live.select(moves, all_move));
    }
    if !all_move.all() {
        for eight in eights {
            *parted = parted.max(part(columns, eight.a as usize, eight.b as usize, &eight.rest));
        }
    }
    worst
}

/// The new ones where a mask is set, and the old ones elsewhere.
#[inline(always)]
fn only<L: Lanes>(live: L, [x, y, z, w]: [L; 4], [ox, oy, oz, _]: [L; 4]) -> [L; 4] {
    [live.select(x, ox), live.select(y, oy), live.select(z, oz), w]
}

/// Eight rods of any rows.
#[inline(always)]
fn sweep_block<L: Lanes>(
    columns: &mut Columns,
    block: &Block,
    rows: &Range<u32>,
    worst: L,
    parted: &mut f32,
) -> L {
    let (mut a, mut b) = ([0; LANES], [0; LANES]);
    let half = Columns::half(rows.len());
    let mut packed = [glam::Vec4::ZERO; 2 * LANES];
    for lane in 0..LANES {
        a[lane] = Columns::place(block.a[lane] - rows.start, half);
        b[lane] = Columns::place(block.b[lane] - rows.start, half);
        (packed[lane], packed[LANES + lane]) = (columns.get(a[lane]), columns.get(b[lane]));
    }
    let (one, other) = (L::run(&packed, 0), L::run(&packed, LANES));
    let (scale, error, moves) = stretch(one, other, L::load(&block.rest));
    let (one, other) = moved(one, other, scale);
    L::put_run(&mut packed, 0, one);
    L::put_run(&mut packed, LANES, other);
    for lane in 0..LANES {
        columns.set(a[lane], packed[lane]);
        columns.set(b[lane], packed[LANES + lane]);
    }
    if !moves.all() {
        for lane in 0..LANES {
            *parted = parted.max(part(columns, a[lane], b[lane], &[block.rest[lane]]));
        }
    }
    error.max(worst)
}

/// Parts those of some neighbouring rods whose ends are in one place, one after the other: it is rare. What has a direction was projected.
#[cold]
fn part(columns: &mut Columns, a: usize, b: usize, rests: &[f32]) -> f32 {
    let mut worst = 0.0_f32;
    for (i, &rest) in rests.iter().enumerate().filter(|(_, rest)| !rest.is_nan()) {
        let ends = [a + i, b + i];
        let mut pair = ends.map(|at| columns.get(at));
        // As the kernel decides: a distance whose square is nothing is none.
        let d = (pair[0] - pair[1]).truncate();
        if d.x * d.x + d.y * d.y + d.z * d.z == 0.0 {
            worst = worst.max(project_rod(&mut pair, 0, 1, rest));
            columns.set(ends[0], pair[0]);
            columns.set(ends[1], pair[1]);
        }
    }
    worst
}
