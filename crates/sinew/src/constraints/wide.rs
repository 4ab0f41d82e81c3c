//! Constraints eight at a time: the values and gradients of an [`Equation`](super::Equation), in SIMD lanes.

use crate::lanes::{LANES, Lanes, Number, Vector};

/// Eight constraints of one kind, of `N` particles each.
///
/// `evaluate` uses the formula of the kind; an implementation that deviates for round-off or speed documents it. Where there is no value or gradient, the lane
/// may be zero, infinite or NaN: the projection skips such lanes, as the scalar one does.
pub(crate) trait Wide<const N: usize>: Sized {
    /// Whether the value is a length in metres; see [`Equation::is_length`](super::Equation::is_length).
    const IS_LENGTH: bool = false;

    /// The scalar constraint type.
    type Kind;

    /// Packs the parameters of eight constraints, which bind `particles` particles each.
    fn of(eight: [&Self::Kind; LANES], particles: [usize; LANES]) -> Self;

    /// The rows of one constraint. If a row is listed twice, the gradients at its later places must be zero.
    fn rows(rows: &[u32]) -> [u32; N] {
        core::array::from_fn(|i| rows[i])
    }

    /// Whether the kind implements [`is_kept`](Self::is_kept).
    const IS_LIMIT: bool = false;

    /// A mask of the lanes whose constraint certainly holds, so that its value is zero, where that is cheaper to find than by `evaluate`. Most limits hold most
    /// of the time. Implementations must be inlined.
    #[inline(always)]
    fn is_kept<L: Lanes>(&self, _points: &[Vector<L>; N]) -> L {
        L::zero()
    }

    /// Values, and gradients by each particle. Implementations must be inlined.
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; N]) -> (L, [Vector<L>; N]);
}

/// One parameter of each of eight constraints. Equivalent to `array::map`, with a tenth of the code.
pub(super) fn numbers<T: Copy>(eight: [T; LANES], of: impl Fn(T) -> f32) -> [f32; LANES] {
    let mut numbers = [0.0; LANES];
    for (to, one) in numbers.iter_mut().zip(eight) {
        *to = of(one);
    }
    numbers
}

/// Margin by which the cosine of an angle must exceed that of a limit for the angle to be below the limit despite rounding.
pub(super) const CLEAR: f32 = 1e-4;

/// A mask of where `x = cos φ · √square` has a cosine above `least`.
#[inline(always)]
pub(super) fn is_below<L: Lanes>(x: L, square: L, least: L) -> L {
    let sound = L::zero().lt(square).and(square.le(L::splat(f32::MAX)));
    sound.and((least * square.sqrt()).lt(x))
}

/// How far `x` is above the range, or (negative) below it.
#[inline(always)]
pub(super) fn beyond<N: Number>(x: N, min: N, max: N) -> N {
    max.lt(x).select(x - max, x.lt(min).and(x - min))
}

/// Whether a number is positive and finite.
#[inline(always)]
pub(super) fn is_size<L: Lanes>(x: L) -> L {
    L::zero().lt(x).and(x.le(L::splat(f32::MAX)))
}
