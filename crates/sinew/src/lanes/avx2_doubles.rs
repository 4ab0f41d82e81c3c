//! Eight double-precision numbers in two AVX2 registers of four.
#![allow(unsafe_code)]

use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Neg, Sub};

use super::{Doubles, LANES};

/// Lanes 0 to 3, and 4 to 7.
///
/// Like [`Eight`](super::avx2::Eight), from which alone it is made, it exists only where the machine has AVX2. Each `unsafe` below relies on that.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fours(pub(super) __m256d, pub(super) __m256d);

macro_rules! each {
    ($($of:ident $operation:ident $instruction:ident),*) => {$(
        impl $of for Fours {
            type Output = Self;
            #[inline(always)]
            fn $operation(self, other: Self) -> Self {
                // SAFETY: see `Fours`.
                unsafe { Self($instruction(self.0, other.0), $instruction(self.1, other.1)) }
            }
        }
    )*};
}

each!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

impl Neg for Fours {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see `Fours`.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Self(_mm256_xor_pd(self.0, sign), _mm256_xor_pd(self.1, sign))
        }
    }
}

/// Comparisons that return one bit for each lane.
macro_rules! comparison {
    ($($name:ident $which:ident),*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> u32 {
            // SAFETY: see `Fours`.
            unsafe {
                let low = _mm256_movemask_pd(_mm256_cmp_pd::<$which>(self.0, other.0));
                let high = _mm256_movemask_pd(_mm256_cmp_pd::<$which>(self.1, other.1));
                (low | high << 4) as u32
            }
        }
    )*};
}

impl Doubles for Fours {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: see `Fours`.
        unsafe { Self(_mm256_set1_pd(x), _mm256_set1_pd(x)) }
    }

    #[inline(always)]
    fn load(from: &[f64; LANES]) -> Self {
        // SAFETY: see `Fours`; twice four doubles are there.
        unsafe { Self(_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(4))) }
    }

    #[inline(always)]
    fn store(self, to: &mut [f64; LANES]) {
        // SAFETY: see `Fours`; there is room for twice four doubles.
        unsafe {
            _mm256_storeu_pd(to.as_mut_ptr(), self.0);
            _mm256_storeu_pd(to.as_mut_ptr().add(4), self.1);
        }
    }

    comparison!(lt _CMP_LT_OQ, le _CMP_LE_OQ);
}
