//! Laws eight at a time: the same values and gradients as an [`Equation`](super::Equation) has, in lanes.

use crate::lanes::{LANES, Lanes, Vector};

/// Eight constraints of one kind and of `N` particles each.
///
/// `evaluate` is the kind's own formula; where it takes another way for round-off or for speed, it says so. What has no value or no gradient may come
/// out as zero, infinite or NaN: the projector leaves such lanes alone, as the scalar one does.
pub(crate) trait Wide<const N: usize>: Sized {
    /// Whether the value is a length in metres, as [`Equation::is_length`](super::Equation::is_length) has it.
    const IS_LENGTH: bool = false;

    /// What holds the numbers of one.
    type Kind;

    /// The numbers of eight of them, which bind so many particles each.
    fn of(eight: [&Self::Kind; LANES], particles: [usize; LANES]) -> Self;

    /// The rows of one. If one row stands twice the gradients that it has at its later places must be zero.
    fn rows(rows: &[u32]) -> [u32; N] {
        core::array::from_fn(|i| rows[i])
    }

    /// Whether [`is_kept`](Self::is_kept) has anything to tell.
    const IS_LIMIT: bool = false;

    /// A mask of those that are kept for certain, so that their value is zero, where that can be told for less than what `evaluate` costs. Most
    /// limits are kept most of the time. To be inlined always.
    #[inline(always)]
    fn is_kept<L: Lanes>(&self, _points: &[Vector<L>; N]) -> L {
        L::zero()
    }

    /// Values, and gradients by each particle. To be inlined always.
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; N]) -> (L, [Vector<L>; N]);
}

/// A number of each of eight: as `array::map`, by a tenth of the code.
pub(super) fn numbers<T: Copy>(eight: [T; LANES], of: impl Fn(T) -> f32) -> [f32; LANES] {
    let mut numbers = [0.0; LANES];
    for (to, one) in numbers.iter_mut().zip(eight) {
        *to = of(one);
    }
    numbers
}

/// How far the cosine of an angle must be above that of a limit for the angle to be below the limit whatever was rounded on the way.
pub(super) const CLEAR: f32 = 1e-4;

/// A mask of where `x = cos φ · √square` with a cosine above `least`.
#[inline(always)]
pub(super) fn is_below<L: Lanes>(x: L, square: L, least: L) -> L {
    let sound = L::zero().lt(square).and(square.le(L::splat(f32::MAX)));
    sound.and((least * square.sqrt()).lt(x))
}

/// How far a number is above a range, or (negative) below.
#[inline(always)]
pub(super) fn beyond<L: Lanes>(x: L, min: L, max: L) -> L {
    max.lt(x).select(x - max, x.lt(min).and(x - min))
}

/// Whether a number is more than zero and not infinite.
#[inline(always)]
pub(super) fn is_size<L: Lanes>(x: L) -> L {
    L::zero().lt(x).and(x.le(L::splat(f32::MAX)))
}
