//! A single `f32` as a [`Number`], for formulas that are needed for a single item as well as for eight.

use super::Number;

/// One lane of a mask: all ones if it is set.
#[inline(always)]
pub(super) fn mask(set: bool) -> f32 {
    f32::from_bits(if set { u32::MAX } else { 0 })
}

impl Number for f32 {
    const ALL: u32 = 1;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Self {
        mask(self < other)
    }

    #[inline(always)]
    fn le(self, other: Self) -> Self {
        mask(self <= other)
    }

    #[inline(always)]
    fn same(self, other: Self) -> Self {
        mask(self == other)
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self::from_bits(self.to_bits() & other.to_bits())
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self::from_bits(self.to_bits() | other.to_bits())
    }

    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        if self.any() { yes } else { no }
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.to_bits() != 0)
    }
}
