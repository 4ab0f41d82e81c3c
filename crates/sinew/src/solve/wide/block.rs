//! Eight constraints of one law, side by side: in which form they are kept, and how they are projected.

use super::spots::{Packed, Seen, Spots};
use super::temper::{Asks, Temper, yielding};
use super::{each, less, load_sums, store_sums};
use crate::constraints::{Constraint, Pace, Wide};
use crate::lanes::{LANES, Lanes, Vector, Work};
use crate::particles::Places;

/// One to eight constraints. Where there are fewer, the first stands there again: it computes the same and writes the same.
#[derive(Clone, Debug)]
pub(super) struct Block<W, const N: usize> {
    rows: [[u32; LANES]; N],
    pub(super) eight: Eight<W>,
}

/// Eight constraints but for their particles.
#[derive(Clone, Debug)]
pub(super) struct Eight<W> {
    law: W,
    yielding: [f32; LANES],
    /// Which temper they have.
    pub(super) temper: u32,
}

impl<W: Wide<N>, const N: usize> Block<W, N> {
    /// `None` if the law of one is another, or has another kernel.
    pub(super) fn of(constraints: &[Constraint], tempers: &mut Vec<Temper>) -> Option<Self> {
        let eight: [&Constraint; LANES] =
            core::array::from_fn(|lane| constraints.get(lane).unwrap_or(&constraints[0]));
        let rows = eight.map(W::rows);
        let (eight, temper) = Eight::of(eight)?;
        let eight = Eight { temper: super::number(tempers, temper), ..eight };
        Some(Self { rows: core::array::from_fn(|i| rows.map(|rows| rows[i])), eight })
    }
}

impl<W> Eight<W> {
    /// Eight constraints, and their temper, which has no number yet.
    pub(super) fn of<const N: usize>(eight: [&Constraint; LANES]) -> Option<(Self, Temper)>
    where
        W: Wide<N>,
    {
        let softness = eight.map(|c| c.law.equation().softness());
        let bound = eight.map(|c| c.law.equation().bound());
        let own = Self { law: W::of(eight)?, yielding: softness.map(yielding), temper: 0 };
        Some((own, Temper::of(softness, bound)))
    }
}

/// Projects blocks once, in their order; returns the largest error found, metres, of soft ones how far they moved. `sums` are cut to a block each.
pub(super) struct Sweep<'a, 'b, W, const N: usize> {
    pub(super) blocks: &'a [Block<W, N>],
    pub(super) tempers: &'a [Temper],
    pub(super) places: &'a mut Places<'b>,
    pub(super) sums: core::slice::ChunksMut<'a, f32>,
    pub(super) pace: Pace,
}

impl<W: Wide<N>, const N: usize> Work for Sweep<'_, '_, W, N> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { blocks, tempers, places, sums, pace } = self;
        let (mut each, mut each_of) = ([1.0; LANES], u32::MAX);
        let mut worst = L::zero();
        for (block, sums) in blocks.iter().zip(sums) {
            let temper = &tempers[block.eight.temper as usize];
            if block.eight.temper != each_of {
                each = if temper.shares { temper.each(pace.sweeps) } else { [1.0; LANES] };
                each_of = block.eight.temper;
            }
            let mut room = [[0; LANES]; N];
            let rows = less(&block.rows, places.first, &mut room);
            let (position, start) = (&mut *places.position, places.start);
            let mut spots = Packed { rows, position, start };
            let how = (temper, &each, pace.h, L::zero());
            worst = project::<L, W, N>(&block.eight, how, &mut spots, sums).max(worst);
        }
        worst.largest(0.0)
    }
}

/// The largest error of the hard ones, metres, moving nothing.
pub(super) struct Measure<'a, 'b, W, const N: usize> {
    pub(super) blocks: &'a [Block<W, N>],
    pub(super) tempers: &'a [Temper],
    pub(super) places: &'a Places<'b>,
}

impl<W: Wide<N>, const N: usize> Work for Measure<'_, '_, W, N> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { blocks, tempers, places } = self;
        let mut worst = L::zero();
        for block in blocks {
            let mut room = [[0; LANES]; N];
            let rows = less(&block.rows, places.first, &mut room);
            let spots = Packed { rows, position: &*places.position, start: places.start };
            worst = left::<L, W, N>(&block.eight, tempers, &spots).max(worst);
        }
        worst.largest(0.0)
    }
}

/// The errors of the hard ones of eight, metres.
#[inline(always)]
pub(super) fn left<L: Lanes, W: Wide<N>, const N: usize>(
    eight: &Eight<W>,
    tempers: &[Temper],
    spots: &impl Seen<N>,
) -> L {
    let (points, inverse) = load::<L, N>(spots);
    if W::IS_LIMIT && eight.law.is_kept(&points).all() {
        return L::zero();
    }
    let found = solve::<L, W, N>(&eight.law, &points, &inverse);
    let hard = tempers[eight.temper as usize].hard::<L>();
    hard.and(found.active).and(found.error)
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
fn load<L: Lanes, const N: usize>(spots: &impl Seen<N>) -> ([Vector<L>; N], [L; N]) {
    let mut points = [Vector::new(L::zero(), L::zero(), L::zero()); N];
    let mut inverse = [L::zero(); N];
    each!(i of N {
        (points[i], inverse[i]) = Vector::of(spots.now::<L>(i));
    });
    (points, inverse)
}

/// Eight constraints once, with their temper, what each share is, the substep, seconds, and a mask of those of which nothing is asked: what becomes
/// of them does not matter. Returns the errors found.
#[inline(always)]
pub(super) fn project<L: Lanes, W: Wide<N>, const N: usize>(
    eight: &Eight<W>,
    (temper, each, h, aside): (&Temper, &[f32; LANES], f32, L),
    spots: &mut impl Spots<N>,
    sums: &mut [f32],
) -> L {
    let (points, inverse) = load::<L, N>(spots);
    if W::IS_LIMIT && eight.law.is_kept(&points).or(aside).all() {
        return L::zero();
    }
    let found = solve::<L, W, N>(&eight.law, &points, &inverse);
    let Found { value, gradients, weights, error, active } = found;
    // Limits are kept more often than not.
    if !aside.select(L::zero(), active).any() {
        return L::zero();
    }
    let zero = L::zero();
    let change = if temper.plain {
        value / weights
    } else {
        let mut moved = zero;
        if temper.damped {
            each!(i of N {
                let (start, _) = Vector::of(spots.start::<L>(i));
                moved = moved + gradients[i].dot(points[i] - start);
            });
        }
        let sum = load_sums::<L>(sums);
        let asks = Asks { value, weights, moved, sum };
        let (change, summed) = temper.change(&asks, &eight.yielding, each, h);
        let sound = active.and(change.abs().le(L::splat(f32::MAX)));
        store_sums(sound.select(summed, sum), sums);
        change
    };
    let change = active.and(change.abs().le(L::splat(f32::MAX))).and(change);
    let mut farthest = zero;
    // Backwards: a row that stands twice moves at its first place alone, which has the last word.
    each!(i of N backwards {
        let step = gradients[i] * (inverse[i] * change);
        spots.put(i, (points[i] - step).with(inverse[i]));
        farthest = step.length_squared().max(farthest);
    });
    // A soft one is not meant to be kept. It asks for another sweep as long as sweeps still move it.
    let error =
        if temper.all_hard { error } else { temper.hard::<L>().select(error, farthest.sqrt()) };
    active.and(error)
}
