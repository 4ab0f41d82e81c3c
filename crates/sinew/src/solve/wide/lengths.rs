//! Eight distances side by side: soft ones, ropes and struts. What is hard both ways is a rod, with kernels of its own.

use super::spots::{Packed, Seen, Spots};
use super::temper::{Asks, Temper, yielding};
use super::{less, load_sums, store_sums};
use crate::constraints::{Bound, Distance, Pace};
use crate::lanes::{LANES, Lanes, Vector, Work};
use crate::particles::Places;

/// One to eight distances. Where there are fewer, the first stands there again.
#[derive(Clone, Debug)]
pub(super) struct Lengths {
    rows: [[u32; LANES]; 2],
    pub(super) eight: EightLengths,
}

/// Eight distances but for their particles.
#[derive(Clone, Debug)]
pub(super) struct EightLengths {
    rest: [f32; LANES],
    yielding: [f32; LANES],
    /// Of struts: the square of a length that is safely above the rest length, m². Infinite of others.
    clear: [f32; LANES],
    pub(super) temper: u32,
}

impl Lengths {
    pub(super) fn of(distances: &[Distance], tempers: &mut Vec<Temper>) -> Self {
        let eight: [&Distance; LANES] =
            core::array::from_fn(|lane| distances.get(lane).unwrap_or(&distances[0]));
        let rows = [eight.map(|d| d.a), eight.map(|d| d.b)];
        let (eight, temper) = EightLengths::of(eight);
        Self { rows, eight: EightLengths { temper: super::number(tempers, temper), ..eight } }
    }
}

impl EightLengths {
    /// Eight distances, and their temper, which has no number yet.
    pub(super) fn of(eight: [&Distance; LANES]) -> (Self, Temper) {
        let temper = Temper::of(eight.map(|d| d.softness), eight.map(|d| d.bound));
        let (rest, yielding) = (eight.map(|d| d.rest), eight.map(|d| yielding(d.softness)));
        (Self { rest, yielding, clear: eight.map(clear), temper: 0 }, temper)
    }
}

/// Above this, a strut is longer than it has to be whatever was rounded on the way, m²: squares that are too small to have all their digits are not.
fn clear(distance: &Distance) -> f32 {
    match distance.bound {
        Bound::AtLeast => (distance.rest * distance.rest * (1.0 + 1e-5)).max(1e-30),
        _ => f32::INFINITY,
    }
}

/// Projects blocks once, in their order; returns the largest error found, metres, of soft ones how far they moved. `sums` are cut to a block each.
pub(super) struct Sweep<'a, 'b> {
    pub(super) blocks: &'a [Lengths],
    pub(super) tempers: &'a [Temper],
    pub(super) places: &'a mut Places<'b>,
    pub(super) sums: core::slice::ChunksMut<'a, f32>,
    pub(super) pace: Pace,
}

impl Work for Sweep<'_, '_> {
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
            let mut room = [[0; LANES]; 2];
            let rows = less(&block.rows, places.first, &mut room);
            let (position, start) = (&mut *places.position, places.start);
            let mut spots = Packed { rows, position, start };
            let how = (temper, &each, pace.h, L::zero());
            worst = project::<L>(&block.eight, how, &mut spots, sums).max(worst);
        }
        worst.largest(0.0)
    }
}

/// The largest error of the hard ones, metres, moving nothing.
pub(super) struct Measure<'a, 'b> {
    pub(super) blocks: &'a [Lengths],
    pub(super) tempers: &'a [Temper],
    pub(super) places: &'a Places<'b>,
}

impl Work for Measure<'_, '_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { blocks, tempers, places } = self;
        let mut worst = L::zero();
        for block in blocks {
            let mut room = [[0; LANES]; 2];
            let rows = less(&block.rows, places.first, &mut room);
            let spots = Packed { rows, position: &*places.position, start: places.start };
            worst = left::<L>(&block.eight, tempers, &spots).0.max(worst);
        }
        worst.largest(0.0)
    }
}

/// The errors of the hard ones of eight, metres, and as shares of their rest lengths.
#[inline(always)]
pub(super) fn left<L: Lanes>(
    eight: &EightLengths,
    tempers: &[Temper],
    spots: &impl Seen<2>,
) -> (L, L) {
    let (a, wa) = Vector::of(spots.now::<L>(0));
    let (b, wb) = Vector::of(spots.now::<L>(1));
    let (temper, rest) = (&tempers[eight.temper as usize], L::load(&eight.rest));
    let value = (a - b).length() - rest;
    let asked = temper.hard::<L>().and(L::zero().lt(wa + wb));
    let error = temper.holds(value).select(L::zero(), value.abs());
    let left = asked.and(error);
    (left, L::zero().lt(rest).and(left / rest))
}

/// Eight distances once, with their temper, what each share is, the substep, seconds, and a mask of those of which nothing is asked; the errors
/// found. As [`project`](crate::constraints::project): with `n = d/‖d‖`, `d = a - b`, the gradients are `±n`, so that `Σ w‖∇C‖² = w_a + w_b`.
/// Coincident ends are pushed apart along the x axis, `a` towards +x.
#[inline(always)]
pub(super) fn project<L: Lanes>(
    eight: &EightLengths,
    (temper, each, h, aside): (&Temper, &[f32; LANES], f32, L),
    spots: &mut impl Spots<2>,
    sums: &mut [f32],
) -> L {
    let (a, wa) = Vector::of(spots.now::<L>(0));
    let (b, wb) = Vector::of(spots.now::<L>(1));
    let (zero, one, most) = (L::zero(), L::splat(1.0), L::splat(f32::MAX));
    let d = a - b;
    // Limbs are apart more often than not, and that can be told without a root.
    let square = d.length_squared();
    if temper.plain && L::load(&eight.clear).lt(square).or(aside).all() {
        return zero;
    }
    let length = square.sqrt();
    let value = length - L::load(&eight.rest);
    let weights = wa + wb;
    let sum = if temper.plain { zero } else { load_sums::<L>(sums) };
    let mut active = zero.lt(weights).and(weights.le(most)).and(value.abs().le(most));
    let holds = temper.holds(value);
    active = sum.same(zero).and(holds).select(zero, active);
    if !aside.select(zero, active).any() {
        return zero;
    }
    let parted = zero.lt(length);
    let inverse = one / length;
    let n = Vector {
        x: parted.select(d.x * inverse, one),
        y: parted.and(d.y * inverse),
        z: parted.and(d.z * inverse),
    };
    let change = if temper.plain {
        value / weights
    } else {
        let mut moved = zero;
        if temper.damped {
            let (from, _) = Vector::of(spots.start::<L>(0));
            let (to, _) = Vector::of(spots.start::<L>(1));
            moved = n.dot(d - (from - to));
        }
        let asks = Asks { value, weights, moved, sum };
        let (change, summed) = temper.change(&asks, &eight.yielding, each, h);
        let sound = active.and(change.abs().le(most));
        store_sums(sound.select(summed, sum), sums);
        change
    };
    active = active.and(change.abs().le(most));
    let (to_a, to_b) = (wa * change, wb * change);
    let moved_a = (a - n * to_a).or_else(active, a);
    let moved_b = (b + n * to_b).or_else(active, b);
    spots.put(0, moved_a.with(wa));
    spots.put(1, moved_b.with(wb));
    let hard = holds.select(zero, value.abs());
    let error = if temper.all_hard {
        hard
    } else {
        // A soft one is not meant to be kept. It asks for another sweep as long as sweeps still move it.
        temper.hard::<L>().select(hard, (change * weights).abs())
    };
    active.and(error)
}
