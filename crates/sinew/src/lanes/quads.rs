//! Eight lanes in two registers of four, by glam: SSE2 on x86-64, NEON on ARM, plain numbers elsewhere.

use core::ops::{Add, Div, Mul, Neg, Sub};

use glam::{Mat4, Vec4};

use super::doubles::Each;
use super::{LANES, Lanes, Number, PARITY_ORDER, Record};

/// Lanes 0 to 3, and 4 to 7.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quads(Vec4, Vec4);

macro_rules! each {
    ($($of:ident $operation:ident $sign:tt),*) => {$(
        impl $of for Quads {
            type Output = Self;
            #[inline(always)]
            fn $operation(self, other: Self) -> Self {
                Self(self.0 $sign other.0, self.1 $sign other.1)
            }
        }
    )*};
}

each!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Quads {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

/// The transpose of a 4 × 4 matrix.
#[inline(always)]
fn transposed(rows: [Vec4; 4]) -> [Vec4; 4] {
    let [a, b, c, d] = rows;
    let turned = Mat4::from_cols(a, b, c, d).transpose();
    [turned.x_axis, turned.y_axis, turned.z_axis, turned.w_axis]
}

impl Quads {
    #[inline(always)]
    fn columns(of: impl Fn(usize) -> Vec4) -> [Self; 4] {
        let [a, b, c, d] = transposed([of(0), of(1), of(2), of(3)]);
        let [e, f, g, h] = transposed([of(4), of(5), of(6), of(7)]);
        [Self(a, e), Self(b, f), Self(c, g), Self(d, h)]
    }

    #[inline(always)]
    fn eight_rows(columns: [Self; 4]) -> [Vec4; LANES] {
        let [x, y, z, w] = columns;
        let [a, b, c, d] = transposed([x.0, y.0, z.0, w.0]);
        let [e, f, g, h] = transposed([x.1, y.1, z.1, w.1]);
        [a, b, c, d, e, f, g, h]
    }

    /// Calls `put` with each of eight rows and its number.
    #[inline(always)]
    fn each_row(columns: [Self; 4], mut put: impl FnMut(usize, Vec4)) {
        for (i, &row) in Self::eight_rows(columns).iter().enumerate() {
            put(i, row);
        }
    }
}

/// Binary operations, four lanes at a time.
macro_rules! pairwise {
    ($($operation:ident)*) => {$(
        #[inline(always)]
        fn $operation(self, other: Self) -> Self {
            Self(four::$operation(self.0, other.0), four::$operation(self.1, other.1))
        }
    )*};
}

impl Number for Quads {
    const ALL: u32 = 0xFF;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(Vec4::splat(x), Vec4::splat(x))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    pairwise!(lt le same and or);

    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        Self(four::select(self.0, yes.0, no.0), four::select(self.1, yes.1, no.1))
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        four::bits(self.0) | four::bits(self.1) << 4
    }
}

impl Lanes for Quads {
    type Doubles = Each<f64>;

    #[inline(always)]
    fn load(from: &[f32; LANES]) -> Self {
        let [a, b, c, d, e, f, g, h] = *from;
        Self(Vec4::new(a, b, c, d), Vec4::new(e, f, g, h))
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        self.0.write_to_slice(&mut to[..4]);
        self.1.write_to_slice(&mut to[4..]);
    }

    #[inline(always)]
    fn widen(self) -> Each<f64> {
        let [a, b, c, d, e, f, g, h] = self.array();
        Each([a.into(), b.into(), c.into(), d.into(), e.into(), f.into(), g.into(), h.into()])
    }

    #[inline(always)]
    fn narrow(from: Each<f64>) -> Self {
        let [a, b, c, d, e, f, g, h] = from.0;
        Self::load(&[
            a as f32, b as f32, c as f32, d as f32, e as f32, f as f32, g as f32, h as f32,
        ])
    }

    #[inline(always)]
    fn rows(packed: &[Vec4], rows: &[u32; LANES]) -> [Self; 4] {
        Self::columns(|i| packed[rows[i] as usize])
    }

    #[inline(always)]
    fn put_rows(packed: &mut [Vec4], rows: &[u32; LANES], columns: [Self; 4]) {
        Self::each_row(columns, |i, value| packed[rows[i] as usize] = value);
    }

    #[inline(always)]
    fn records<const N: usize>(from: &[Record], rows: &[u32; LANES]) -> [[Self; 4]; N] {
        let mut fields = [[Self::zero(); 4]; N];
        for (number, field) in fields.iter_mut().enumerate() {
            *field = Self::columns(|i| from[rows[i] as usize].0[number]);
        }
        fields
    }

    #[inline(always)]
    fn put_records<const N: usize>(
        to: &mut [Record],
        rows: &[u32; LANES],
        columns: [[Self; 4]; N],
    ) {
        for (field, columns) in columns.iter().enumerate() {
            Self::each_row(*columns, |i, value| to[rows[i] as usize].0[field] = value);
        }
    }

    #[inline(always)]
    fn run_by_parity(packed: &[Vec4], first: usize) -> [Self; 4] {
        let packed = &packed[first..first + LANES];
        Self::columns(|i| packed[PARITY_ORDER[i]])
    }

    #[inline(always)]
    fn put_run_by_parity(packed: &mut [Vec4], first: usize, columns: [Self; 4]) {
        let packed = &mut packed[first..first + LANES];
        Self::each_row(columns, |i, value| packed[PARITY_ORDER[i]] = value);
    }

    #[inline(always)]
    fn load_halves(low: &[f32; LANES / 2], high: &[f32; LANES / 2]) -> Self {
        Self(Vec4::from_array(*low), Vec4::from_array(*high))
    }

    #[inline(always)]
    fn store_halves(self, low: &mut [f32; LANES / 2], high: &mut [f32; LANES / 2]) {
        (*low, *high) = (self.0.to_array(), self.1.to_array());
    }

    #[inline(always)]
    fn run(packed: &[Vec4], first: usize) -> [Self; 4] {
        let packed = &packed[first..first + LANES];
        Self::columns(|i| packed[i])
    }

    #[inline(always)]
    fn put_run(packed: &mut [Vec4], first: usize, columns: [Self; 4]) {
        packed[first..first + LANES].copy_from_slice(&Self::eight_rows(columns));
    }

    #[inline(always)]
    fn deinterleave(self, next: Self) -> (Self, Self) {
        let (a, b, c, d) = (self.0, self.1, next.0, next.1);
        let firsts = Self(Vec4::new(a.x, a.z, c.x, c.z), Vec4::new(b.x, b.z, d.x, d.z));
        (firsts, Self(Vec4::new(a.y, a.w, c.y, c.w), Vec4::new(b.y, b.w, d.y, d.w)))
    }

    #[inline(always)]
    fn interleave(self, seconds: Self) -> (Self, Self) {
        let (a, b, c, d) = (self.0, self.1, seconds.0, seconds.1);
        let these = Self(Vec4::new(a.x, c.x, a.y, c.y), Vec4::new(b.x, d.x, b.y, d.y));
        (these, Self(Vec4::new(a.z, c.z, a.w, c.w), Vec4::new(b.z, d.z, b.w, d.w)))
    }

    #[inline(always)]
    fn two(packed: &[Vec4], first: usize) -> Self {
        Self(packed[first], packed[first + 1])
    }

    #[inline(always)]
    fn put_two(self, packed: &mut [Vec4], first: usize) {
        packed[first] = self.0;
        packed[first + 1] = self.1;
    }

    #[inline(always)]
    fn fourths(self) -> Self {
        Self(Vec4::splat(self.0.w), Vec4::splat(self.1.w))
    }

    #[inline(always)]
    fn with_fourths(self, other: Self) -> Self {
        Self(self.0.with_w(other.0.w), self.1.with_w(other.1.w))
    }
}

/// Masks of four, which glam does not expose as numbers, by one SSE2 instruction each. With glam's operations a comparison and the selection by it take nine,
/// and these kernels were half of the work of compiling this crate.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod four {
    use core::arch::x86_64::{
        __m128, _mm_and_ps, _mm_andnot_ps, _mm_cmpeq_ps, _mm_cmple_ps, _mm_cmplt_ps,
        _mm_movemask_ps, _mm_or_ps,
    };

    use glam::Vec4;

    macro_rules! each {
        ($($name:ident $operation:ident),*) => {$(
            #[inline(always)]
            pub(super) fn $name(a: Vec4, b: Vec4) -> Vec4 {
                // SAFETY: every x86-64 has SSE2.
                unsafe { $operation(a.into(), b.into()) }.into()
            }
        )*};
    }

    each!(lt _mm_cmplt_ps, le _mm_cmple_ps, same _mm_cmpeq_ps, and _mm_and_ps, or _mm_or_ps);

    #[inline(always)]
    pub(super) fn select(mask: Vec4, yes: Vec4, no: Vec4) -> Vec4 {
        let mask: __m128 = mask.into();
        // SAFETY: every x86-64 has SSE2.
        unsafe { _mm_or_ps(_mm_and_ps(mask, yes.into()), _mm_andnot_ps(mask, no.into())) }.into()
    }

    #[inline(always)]
    pub(super) fn bits(mask: Vec4) -> u32 {
        // SAFETY: every x86-64 has SSE2.
        unsafe { _mm_movemask_ps(mask.into()) as u32 }
    }
}

/// The same by glam's operations, on other machines.
#[cfg(not(target_arch = "x86_64"))]
mod four {
    use glam::{BVec4A, Vec4};

    /// All ones where a comparison holds.
    #[inline(always)]
    fn mask(holds: BVec4A) -> Vec4 {
        Vec4::select(holds, Vec4::splat(f32::from_bits(u32::MAX)), Vec4::ZERO)
    }

    /// The comparison behind a mask. All ones are a NaN, zeros are not.
    #[inline(always)]
    fn holds(mask: Vec4) -> BVec4A {
        mask.cmpne(mask)
    }

    #[inline(always)]
    pub(super) fn lt(a: Vec4, b: Vec4) -> Vec4 {
        mask(a.cmplt(b))
    }

    #[inline(always)]
    pub(super) fn le(a: Vec4, b: Vec4) -> Vec4 {
        mask(a.cmple(b))
    }

    #[inline(always)]
    pub(super) fn same(a: Vec4, b: Vec4) -> Vec4 {
        mask(a.cmpeq(b))
    }

    #[inline(always)]
    pub(super) fn and(mask: Vec4, of: Vec4) -> Vec4 {
        select(mask, of, Vec4::ZERO)
    }

    #[inline(always)]
    pub(super) fn or(one: Vec4, other: Vec4) -> Vec4 {
        select(one, one, other)
    }

    #[inline(always)]
    pub(super) fn select(mask: Vec4, yes: Vec4, no: Vec4) -> Vec4 {
        Vec4::select(holds(mask), yes, no)
    }

    #[inline(always)]
    pub(super) fn bits(mask: Vec4) -> u32 {
        holds(mask).bitmask()
    }
}
