//! Eight double-precision numbers side by side, for sums that must not lose what single precision rounds away. Only has the operations that these need.

use core::ops::{Add, Div, Mul, Neg, Sub};

use super::{Arithmetic, LANES};

/// Eight `f64` side by side. Like [`Lanes`](super::Lanes), it has only `+ - × ÷` and comparisons.
pub(crate) trait Doubles: Arithmetic {
    /// The same number in each lane.
    fn splat(x: f64) -> Self;
    /// Loads eight numbers.
    fn load(from: &[f64; LANES]) -> Self;
    /// Stores into an array.
    fn store(self, to: &mut [f64; LANES]);
    /// One bit for each lane where `self < other`, lane 0 lowest; not set for NaN.
    fn lt(self, other: Self) -> u32;
    /// The same for `self <= other`.
    fn le(self, other: Self) -> u32;

    /// The eight numbers.
    #[inline(always)]
    fn array(self) -> [f64; LANES] {
        let mut array = [0.0; LANES];
        self.store(&mut array);
        array
    }

    /// One bit for each lane that is neither NaN nor infinite; these minus themselves are NaN.
    #[inline(always)]
    #[allow(clippy::eq_op, reason = "a number minus itself is zero exactly if it is finite")]
    fn finite(self) -> u32 {
        (self - self).le(Self::splat(0.0))
    }
}

/// Eight numbers computed one by one: the reference for the others, and the fallback where there is no wide implementation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Each<N>(pub(super) [N; LANES]);

impl<N: Arithmetic> Each<N> {
    #[inline(always)]
    pub(super) fn zip(self, other: Self, of: impl Fn(N, N) -> N) -> Self {
        Self(core::array::from_fn(|i| of(self.0[i], other.0[i])))
    }
}

impl Each<f64> {
    #[inline(always)]
    fn bits(self, other: Self, of: impl Fn(f64, f64) -> bool) -> u32 {
        (0..LANES).map(|i| u32::from(of(self.0[i], other.0[i])) << i).sum()
    }
}

macro_rules! each {
    ($($of:ident $operation:ident $sign:tt),*) => {$(
        impl<N: Arithmetic> $of for Each<N> {
            type Output = Self;
            #[inline(never)]
            fn $operation(self, other: Self) -> Self {
                self.zip(other, |a, b| a $sign b)
            }
        }
    )*};
}

each!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<N: Arithmetic> Neg for Each<N> {
    type Output = Self;
    #[inline(never)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl Doubles for Each<f64> {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn load(from: &[f64; LANES]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        *to = self.0;
    }

    #[inline(never)]
    fn lt(self, other: Self) -> u32 {
        self.bits(other, |a, b| a < b)
    }

    #[inline(never)]
    fn le(self, other: Self) -> u32 {
        self.bits(other, |a, b| a <= b)
    }
}
