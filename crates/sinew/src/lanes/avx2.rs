//! Eight lanes in one AVX2 register.
#![allow(unsafe_code)]

use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Neg, Sub};

use glam::Vec4;

use super::avx2_doubles::Fours;
use super::avx2_rows::{check, halves, places, put_halves, transposed};
use super::{FIELDS, LANES, Lanes, Number, Record};

/// Lanes 0 to 7.
///
/// Only [`Work::in_avx2`](super::Work::in_avx2) instantiates kernels with this type, and it is only called where the machine has AVX2. Each `unsafe` below
/// relies on that.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eight(__m256);

/// Binary operations that are one instruction each.
macro_rules! lanewise {
    ($($operation:ident $instruction:path),* $(,)?) => {$(
        #[inline(always)]
        fn $operation(self, other: Self) -> Self {
            // SAFETY: see `Eight`.
            Self(unsafe { $instruction(self.0, other.0) })
        }
    )*};
}

macro_rules! each {
    ($($of:ident $operation:ident $instruction:ident),*) => {$(
        impl $of for Eight {
            type Output = Self;
            lanewise!($operation $instruction);
        }
    )*};
}

each!(Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);

impl Neg for Eight {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see `Eight`.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
}

impl Number for Eight {
    const ALL: u32 = 0xFF;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: see `Eight`.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: see `Eight`.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `Eight`.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    // `_mm256_min_ps` and `_mm256_max_ps` return the second operand for NaN and for two zeros, like the comparison and selection of the default methods.
    lanewise!(
        min _mm256_min_ps, max _mm256_max_ps, lt _mm256_cmp_ps::<_CMP_LT_OQ>, le _mm256_cmp_ps::<_CMP_LE_OQ>,
        same _mm256_cmp_ps::<_CMP_EQ_OQ>, and _mm256_and_ps, or _mm256_or_ps,
    );

    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        // SAFETY: see `Eight`.
        Self(unsafe { _mm256_blendv_ps(no.0, yes.0, self.0) })
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: see `Eight`.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
}

impl Lanes for Eight {
    type Doubles = Fours;

    #[inline(always)]
    fn load(from: &[f32; LANES]) -> Self {
        // SAFETY: see `Eight`; eight floats are a register.
        Self(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        // SAFETY: see `Eight`; a register is eight floats.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn widen(self) -> Fours {
        // SAFETY: see `Eight`.
        unsafe {
            let (low, high) = (_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            Fours(_mm256_cvtps_pd(low), _mm256_cvtps_pd(high))
        }
    }

    #[inline(always)]
    fn narrow(from: Fours) -> Self {
        // SAFETY: see `Eight`.
        Self(unsafe { _mm256_set_m128(_mm256_cvtpd_ps(from.1), _mm256_cvtpd_ps(from.0)) })
    }

    #[inline(always)]
    fn rows(packed: &[Vec4], rows: &[u32; LANES]) -> [Self; 4] {
        check(rows, packed.len());
        let from = packed.as_ptr();
        // Read from memory again: extracting each row from the register that was checked would take an instruction more.
        let [a, b, c, d, e, f, g, h] = *core::hint::black_box(rows);
        // SAFETY: all rows exist, as just checked; see `Eight`.
        let [a, b, c, d] = unsafe {
            transposed([
                halves(from, a as usize, e as usize),
                halves(from, b as usize, f as usize),
                halves(from, c as usize, g as usize),
                halves(from, d as usize, h as usize),
            ])
        };
        [Self(a), Self(b), Self(c), Self(d)]
    }

    #[inline(always)]
    fn put_rows(packed: &mut [Vec4], rows: &[u32; LANES], columns: [Self; 4]) {
        check(rows, packed.len());
        let to = packed.as_mut_ptr();
        let [a, b, c, d, e, f, g, h] = *core::hint::black_box(rows);
        let [x, y, z, w] = columns;
        let [p, q, r, s] = transposed([x.0, y.0, z.0, w.0]);
        // SAFETY: all rows exist, as just checked; see `Eight`.
        unsafe {
            put_halves(to, a as usize, e as usize, p);
            put_halves(to, b as usize, f as usize, q);
            put_halves(to, c as usize, g as usize, r);
            put_halves(to, d as usize, h as usize, s);
        }
    }

    #[inline(always)]
    fn records<const N: usize>(from: &[Record], rows: &[u32; LANES]) -> [[Self; 4]; N] {
        const { assert!(N <= FIELDS) };
        check(rows, from.len());
        let mut from = from.as_ptr().cast::<Vec4>();
        let [a, b, c, d, e, f, g, h] = places(rows);
        let mut fields = [[Self::zero(); 4]; N];
        for field in &mut fields {
            // SAFETY: all records exist, as just checked, and have such a field; see `Eight`.
            let [x, y, z, w] = unsafe {
                transposed([
                    halves(from, a, e),
                    halves(from, b, f),
                    halves(from, c, g),
                    halves(from, d, h),
                ])
            };
            *field = [Self(x), Self(y), Self(z), Self(w)];
            from = from.wrapping_add(1);
        }
        fields
    }

    #[inline(always)]
    fn put_records<const N: usize>(
        to: &mut [Record],
        rows: &[u32; LANES],
        columns: [[Self; 4]; N],
    ) {
        const { assert!(N <= FIELDS) };
        check(rows, to.len());
        let mut to = to.as_mut_ptr().cast::<Vec4>();
        let [a, b, c, d, e, f, g, h] = places(rows);
        for [x, y, z, w] in columns {
            let [p, q, r, s] = transposed([x.0, y.0, z.0, w.0]);
            // SAFETY: all records exist, as just checked, and have such a field; see `Eight`.
            unsafe {
                put_halves(to, a, e, p);
                put_halves(to, b, f, q);
                put_halves(to, c, g, r);
                put_halves(to, d, h, s);
            }
            to = to.wrapping_add(1);
        }
    }

    #[inline(always)]
    fn run_by_parity(packed: &[Vec4], first: usize) -> [Self; 4] {
        let from = packed[first..first + LANES].as_ptr();
        // SAFETY: the eight rows from `from` on exist, as just checked, two a register; see `Eight`.
        let [a, b, c, d] = unsafe {
            transposed([
                _mm256_loadu_ps(from.cast()),
                _mm256_loadu_ps(from.add(2).cast()),
                _mm256_loadu_ps(from.add(4).cast()),
                _mm256_loadu_ps(from.add(6).cast()),
            ])
        };
        [Self(a), Self(b), Self(c), Self(d)]
    }

    #[inline(always)]
    fn put_run_by_parity(packed: &mut [Vec4], first: usize, columns: [Self; 4]) {
        let to = packed[first..first + LANES].as_mut_ptr();
        let [a, b, c, d] = columns;
        let [a, b, c, d] = transposed([a.0, b.0, c.0, d.0]);
        // SAFETY: the eight rows from `to` on exist, as just checked, two a register; see `Eight`.
        unsafe {
            _mm256_storeu_ps(to.cast(), a);
            _mm256_storeu_ps(to.add(2).cast(), b);
            _mm256_storeu_ps(to.add(4).cast(), c);
            _mm256_storeu_ps(to.add(6).cast(), d);
        }
    }

    #[inline(always)]
    fn load_halves(low: &[f32; LANES / 2], high: &[f32; LANES / 2]) -> Self {
        // SAFETY: see `Eight`; twice four floats are a register.
        Self(unsafe { _mm256_loadu2_m128(high.as_ptr(), low.as_ptr()) })
    }

    #[inline(always)]
    fn store_halves(self, low: &mut [f32; LANES / 2], high: &mut [f32; LANES / 2]) {
        // SAFETY: see `Eight`; a register is twice four floats.
        unsafe { _mm256_storeu2_m128(high.as_mut_ptr(), low.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn run(packed: &[Vec4], first: usize) -> [Self; 4] {
        let from = packed[first..first + LANES].as_ptr();
        // SAFETY: the eight rows from `from` on exist, as just checked; see `Eight`.
        let [a, b, c, d] = unsafe {
            transposed([
                halves(from, 0, 4),
                halves(from, 1, 5),
                halves(from, 2, 6),
                halves(from, 3, 7),
            ])
        };
        [Self(a), Self(b), Self(c), Self(d)]
    }

    #[inline(always)]
    fn put_run(packed: &mut [Vec4], first: usize, columns: [Self; 4]) {
        let to = packed[first..first + LANES].as_mut_ptr();
        let [a, b, c, d] = columns;
        let [a, b, c, d] = transposed([a.0, b.0, c.0, d.0]);
        // SAFETY: the eight rows from `to` on exist, as just checked; see `Eight`.
        unsafe {
            put_halves(to, 0, 4, a);
            put_halves(to, 1, 5, b);
            put_halves(to, 2, 6, c);
            put_halves(to, 3, 7, d);
        }
    }

    #[inline(always)]
    fn deinterleave(self, next: Self) -> (Self, Self) {
        // SAFETY: see `Eight`.
        unsafe {
            let firsts = _mm256_shuffle_ps::<0b10_00_10_00>(self.0, next.0);
            (Self(firsts), Self(_mm256_shuffle_ps::<0b11_01_11_01>(self.0, next.0)))
        }
    }

    #[inline(always)]
    fn interleave(self, seconds: Self) -> (Self, Self) {
        // SAFETY: see `Eight`.
        unsafe {
            let these = _mm256_unpacklo_ps(self.0, seconds.0);
            (Self(these), Self(_mm256_unpackhi_ps(self.0, seconds.0)))
        }
    }

    #[inline(always)]
    fn two(packed: &[Vec4], first: usize) -> Self {
        let from = packed[first..first + 2].as_ptr();
        // SAFETY: both rows exist, as just checked, and are eight floats; see `Eight`.
        Self(unsafe { _mm256_loadu_ps(from.cast()) })
    }

    #[inline(always)]
    fn put_two(self, packed: &mut [Vec4], first: usize) {
        let to = packed[first..first + 2].as_mut_ptr();
        // SAFETY: both rows exist, as just checked, and are eight floats; see `Eight`.
        unsafe { _mm256_storeu_ps(to.cast(), self.0) }
    }

    #[inline(always)]
    fn fourths(self) -> Self {
        // SAFETY: see `Eight`.
        Self(unsafe { _mm256_shuffle_ps::<0xFF>(self.0, self.0) })
    }

    #[inline(always)]
    fn with_fourths(self, other: Self) -> Self {
        // SAFETY: see `Eight`.
        Self(unsafe { _mm256_blend_ps::<0x88>(self.0, other.0) })
    }

    #[inline(always)]
    fn pairs(packed: &[Vec4], first: usize) -> ([Self; 4], [Self; 4]) {
        let from = packed[first..first + 2 * LANES].as_ptr();
        // SAFETY: the sixteen rows from `from` on exist, as just checked; see `Eight`.
        unsafe {
            let two = |pair: usize| _mm256_loadu_ps(from.add(2 * pair).cast());
            // Each register holds the first particle of a pair in one half and the second in the other: transpose pairs 0 to 3 and 4 to 7, then sort the
            // halves.
            let low = transposed([two(0), two(1), two(2), two(3)]);
            let high = transposed([two(4), two(5), two(6), two(7)]);
            // No `array::from_fn`: its closure is not compiled for AVX2, so that each instruction in it would be a call.
            let ([a, b, c, d], [e, f, g, h]) = (low, high);
            let ones = [
                Self(_mm256_permute2f128_ps::<0x20>(a, e)),
                Self(_mm256_permute2f128_ps::<0x20>(b, f)),
                Self(_mm256_permute2f128_ps::<0x20>(c, g)),
                Self(_mm256_permute2f128_ps::<0x20>(d, h)),
            ];
            let others = [
                Self(_mm256_permute2f128_ps::<0x31>(a, e)),
                Self(_mm256_permute2f128_ps::<0x31>(b, f)),
                Self(_mm256_permute2f128_ps::<0x31>(c, g)),
                Self(_mm256_permute2f128_ps::<0x31>(d, h)),
            ];
            (ones, others)
        }
    }

    #[inline(always)]
    fn put_pairs(packed: &mut [Vec4], first: usize, ones: [Self; 4], others: [Self; 4]) {
        let to = packed[first..first + 2 * LANES].as_mut_ptr();
        // SAFETY: the sixteen rows from `to` on exist, as just checked; see `Eight`.
        unsafe {
            let ([a, b, c, d], [e, f, g, h]) = (ones, others);
            let low = [
                _mm256_permute2f128_ps::<0x20>(a.0, e.0),
                _mm256_permute2f128_ps::<0x20>(b.0, f.0),
                _mm256_permute2f128_ps::<0x20>(c.0, g.0),
                _mm256_permute2f128_ps::<0x20>(d.0, h.0),
            ];
            let high = [
                _mm256_permute2f128_ps::<0x31>(a.0, e.0),
                _mm256_permute2f128_ps::<0x31>(b.0, f.0),
                _mm256_permute2f128_ps::<0x31>(c.0, g.0),
                _mm256_permute2f128_ps::<0x31>(d.0, h.0),
            ];
            // Two loops, not a chained iterator: that is not unrolled, and the registers would go through memory.
            for (pair, value) in transposed(low).into_iter().enumerate() {
                _mm256_storeu_ps(to.add(2 * pair).cast(), value);
            }
            for (pair, value) in transposed(high).into_iter().enumerate() {
                _mm256_storeu_ps(to.add(8 + 2 * pair).cast(), value);
            }
        }
    }
}
