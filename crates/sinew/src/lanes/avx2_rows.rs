//! Loading rows of particles into registers of eight and storing them: bounds checks and transposition.
#![allow(unsafe_code)]

use core::arch::x86_64::*;

use glam::Vec4;

use super::{FIELDS, LANES};

/// Offsets of records, in units of `Vec4`.
#[inline(always)]
pub(super) fn places(rows: &[u32; LANES]) -> [usize; LANES] {
    let [a, b, c, d, e, f, g, h] = *core::hint::black_box(rows);
    let place = |row: u32| row as usize * FIELDS;
    [place(a), place(b), place(c), place(d), place(e), place(f), place(g), place(h)]
}

/// Row `a` in the lower half of a register, row `b` in the upper one.
///
/// # Safety
/// Both rows exist, and the machine has AVX2.
#[inline(always)]
pub(super) unsafe fn halves(packed: *const Vec4, a: usize, b: usize) -> __m256 {
    // SAFETY: as promised; a `Vec4` is four floats.
    unsafe { _mm256_loadu2_m128(packed.add(b).cast(), packed.add(a).cast()) }
}

/// Stores the lower half of a register to row `a` and the upper half to row `b`.
///
/// # Safety
/// Both rows exist, and the machine has AVX2.
#[inline(always)]
pub(super) unsafe fn put_halves(packed: *mut Vec4, a: usize, b: usize, value: __m256) {
    // SAFETY: as promised; a `Vec4` is four floats.
    unsafe { _mm256_storeu2_m128(packed.add(b).cast(), packed.add(a).cast(), value) }
}

/// Transposes a 4 × 4 matrix in each half of the registers: rows 0 to 3 and 4 to 7 become columns, or the reverse.
#[inline(always)]
pub(super) fn transposed([a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
    // SAFETY: see `Eight` in `avx2`.
    unsafe {
        let (low, high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        let (low2, high2) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        [
            _mm256_shuffle_ps::<0x44>(low, low2),
            _mm256_shuffle_ps::<0xEE>(low, low2),
            _mm256_shuffle_ps::<0x44>(high, high2),
            _mm256_shuffle_ps::<0xEE>(high, high2),
        ]
    }
}

/// Panics unless all rows are less than `len`: one check for eight loads.
#[inline(always)]
pub(super) fn check(rows: &[u32; LANES], len: usize) {
    assert!(len <= u32::MAX as usize, "too many rows");
    // The maximum of a row and `len` is the row itself exactly where the row does not exist.
    // SAFETY: see `Eight` in `avx2`; eight `u32` are a register.
    let outside = unsafe {
        let rows = _mm256_loadu_si256(rows.as_ptr().cast());
        let none = _mm256_cmpeq_epi32(_mm256_max_epu32(rows, _mm256_set1_epi32(len as i32)), rows);
        _mm256_movemask_ps(_mm256_castsi256_ps(none))
    };
    assert!(outside == 0, "a row that does not exist");
}
