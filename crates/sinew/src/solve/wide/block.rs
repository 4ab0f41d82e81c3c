//! Eight constraints of one law, side by side: in which form they are kept, and how they are projected.

use super::temper::{Asks, Temper, yielding};
use super::{each, less, load_sums, store_sums};
use crate::constraints::{Constraint, Pace, Wide};
use crate::lanes::{LANES, Lanes, Vector};
use crate::particles::Places;

/// One to eight constraints. Where there are fewer, the first stands there again: it computes the same and writes the same.
#[derive(Clone, Debug)]
pub(super) struct Block<W, const N: usize> {
    rows: [[u32; LANES]; N],
    law: W,
    yielding: [f32; LANES],
    /// Which temper they have.
    temper: u32,
}

impl<W: Wide<N>, const N: usize> Block<W, N> {
    /// `None` if the law of one is another, or has another kernel.
    pub(super) fn of(constraints: &[Constraint], tempers: &mut Vec<Temper>) -> Option<Self> {
        let eight: [&Constraint; LANES] =
            core::array::from_fn(|lane| constraints.get(lane).unwrap_or(&constraints[0]));
        let law = W::of(eight)?;
        let rows = eight.map(W::rows);
        let softness = eight.map(|c| c.law.equation().softness());
        let bound = eight.map(|c| c.law.equation().bound());
        Some(Self {
            rows: core::array::from_fn(|i| rows.map(|rows| rows[i])),
            law,
            yielding: softness.map(yielding),
            temper: super::number(tempers, Temper::of(softness, bound)),
        })
    }
}

/// Projects blocks once, in their order; returns the largest error found, metres, of soft ones how far they moved. `sums` are cut to a block each.
#[inline(always)]
pub(super) fn sweep<L: Lanes, W: Wide<N>, const N: usize>(
    blocks: &[Block<W, N>],
    tempers: &[Temper],
    places: &mut Places,
    sums: core::slice::ChunksMut<f32>,
    pace: Pace,
) -> f32 {
    let (mut each, mut each_of) = ([1.0; LANES], u32::MAX);
    let mut worst = L::zero();
    for (block, sums) in blocks.iter().zip(sums) {
        let temper = &tempers[block.temper as usize];
        if block.temper != each_of {
            each = if temper.shares { temper.each(pace.sweeps) } else { [1.0; LANES] };
            each_of = block.temper;
        }
        worst = project::<L, W, N>(block, temper, &each, places, sums, pace.h).max(worst);
    }
    worst.largest(0.0)
}

/// The largest error of the hard ones, metres, moving nothing.
#[inline(always)]
pub(super) fn measure<L: Lanes, W: Wide<N>, const N: usize>(
    blocks: &[Block<W, N>],
    tempers: &[Temper],
    places: &Places,
) -> f32 {
    let mut worst = L::zero();
    for block in blocks {
        let mut room = [[0; LANES]; N];
        let rows = less(&block.rows, places.first, &mut room);
        let (points, inverse) = load::<L, N>(rows, places);
        let found = solve::<L, W, N>(&block.law, &points, &inverse);
        let hard = tempers[block.temper as usize].hard::<L>();
        worst = hard.and(found.active).and(found.error).max(worst);
    }
    worst.largest(0.0)
}

/// What a law says of eight constraints.
struct Found<L, const N: usize> {
    value: L,
    /// Zero where there is nothing to be done.
    gradients: [Vector<L>; N],
    /// `Σ w‖∇C‖²`.
    weights: L,
    /// The value as a length, metres.
    error: L,
    /// Where there is something to be done, and can be.
    active: L,
}

/// Values, gradients and what follows: as `solve` in `equation.rs`.
///
/// Weights that are finite come of finite gradients; pinned particles alone leave zero, and nothing to be done.
#[inline(always)]
fn solve<L: Lanes, W: Wide<N>, const N: usize>(
    law: &W,
    points: &[Vector<L>; N],
    inverse: &[L; N],
) -> Found<L, N> {
    let (value, mut gradients) = law.evaluate(points);
    let (zero, most) = (L::zero(), L::splat(f32::MAX));
    let (mut weights, mut steepness) = (zero, zero);
    each!(i of N {
        let square = gradients[i].length_squared();
        steepness = steepness + square;
        weights = weights + inverse[i] * square;
    });
    let size = value.abs();
    let sound = zero.lt(size).and(size.le(most));
    let active = sound.and(zero.lt(weights)).and(weights.le(most));
    if !active.all() {
        each!(i of N {
            let Vector { x, y, z } = gradients[i];
            gradients[i] = Vector::new(active.and(x), active.and(y), active.and(z));
        });
    }
    let error = if W::IS_LENGTH {
        size
    } else {
        L::splat(core::f32::consts::SQRT_2) * size / steepness.sqrt()
    };
    Found { value, gradients, weights, error, active }
}

/// Where the particles are, and their inverse masses.
#[inline(always)]
fn load<L: Lanes, const N: usize>(
    rows: &[[u32; LANES]; N],
    places: &Places,
) -> ([Vector<L>; N], [L; N]) {
    let mut points = [Vector::new(L::zero(), L::zero(), L::zero()); N];
    let mut inverse = [L::zero(); N];
    each!(i of N {
        (points[i], inverse[i]) = Vector::of(L::rows(places.position, &rows[i]));
    });
    (points, inverse)
}

/// One block once; the errors found.
#[inline(always)]
fn project<L: Lanes, W: Wide<N>, const N: usize>(
    block: &Block<W, N>,
    temper: &Temper,
    each: &[f32; LANES],
    places: &mut Places,
    sums: &mut [f32],
    h: f32,
) -> L {
    let mut room = [[0; LANES]; N];
    let rows = less(&block.rows, places.first, &mut room);
    let (points, inverse) = load::<L, N>(rows, places);
    let found = solve::<L, W, N>(&block.law, &points, &inverse);
    let Found { value, gradients, weights, error, active } = found;
    // Limits are kept more often than not.
    if !active.any() {
        return L::zero();
    }
    let zero = L::zero();
    let change = if temper.plain {
        value / weights
    } else {
        let mut moved = zero;
        if temper.damped {
            each!(i of N {
                let (start, _) = Vector::of(L::rows(places.start, &rows[i]));
                moved = moved + gradients[i].dot(points[i] - start);
            });
        }
        let sum = load_sums::<L>(sums);
        let asks = Asks { value, weights, moved, sum };
        let (change, summed) = temper.change(&asks, &block.yielding, each, h);
        let sound = active.and(change.abs().le(L::splat(f32::MAX)));
        store_sums(sound.select(summed, sum), sums);
        change
    };
    let change = active.and(change.abs().le(L::splat(f32::MAX))).and(change);
    let mut farthest = zero;
    // Backwards: a row that stands twice moves at its first place alone, which has the last word.
    each!(i of N backwards {
        let step = gradients[i] * (inverse[i] * change);
        L::put_rows(places.position, &rows[i], (points[i] - step).with(inverse[i]));
        farthest = step.length_squared().max(farthest);
    });
    // A soft one is not meant to be kept. It asks for another sweep as long as sweeps still move it.
    let error =
        if temper.all_hard { error } else { temper.hard::<L>().select(error, farthest.sqrt()) };
    active.and(error)
}
