//! Two registers of four, by glam, which makes SSE2 of them on x86-64, NEON on ARM and plain numbers elsewhere.

use core::ops::{Add, Div, Mul, Neg, Sub};

use glam::{BVec4A, Mat4, Vec4};

use super::doubles::Each;
use super::{LANES, Lanes, PARITY, Record};

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

/// All ones where a comparison holds.
#[inline(always)]
fn mask(holds: BVec4A) -> Vec4 {
    Vec4::select(holds, Vec4::splat(f32::from_bits(u32::MAX)), Vec4::ZERO)
}

/// The comparison of which that is the mask. All ones are a NaN, zeros are not.
#[inline(always)]
fn holds(mask: Vec4) -> BVec4A {
    mask.cmpne(mask)
}

/// Four rows of four numbers as four columns.
#[inline(always)]
fn transposed(rows: [Vec4; 4]) -> [Vec4; 4] {
    let [a, b, c, d] = rows;
    let turned = Mat4::from_cols(a, b, c, d).transpose();
    [turned.x_axis, turned.y_axis, turned.z_axis, turned.w_axis]
}

impl Quads {
    #[inline(always)]
    fn columns(of: impl Fn(usize) -> Vec4) -> [Self; 4] {
        let low = transposed([of(0), of(1), of(2), of(3)]);
        let high = transposed([of(4), of(5), of(6), of(7)]);
        core::array::from_fn(|i| Self(low[i], high[i]))
    }

    #[inline(always)]
    fn eight_rows(columns: [Self; 4]) -> [Vec4; LANES] {
        let [a, b, c, d] = transposed(columns.map(|column| column.0));
        let [e, f, g, h] = transposed(columns.map(|column| column.1));
        [a, b, c, d, e, f, g, h]
    }
}

impl Lanes for Quads {
    type Doubles = Each;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(Vec4::splat(x), Vec4::splat(x))
    }

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
    fn widen(self) -> Each {
        Each(self.array().map(f64::from))
    }

    #[inline(always)]
    fn narrow(from: Each) -> Self {
        Self::load(&from.0.map(|x| x as f32))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Self {
        Self(mask(self.0.cmplt(other.0)), mask(self.1.cmplt(other.1)))
    }

    #[inline(always)]
    fn le(self, other: Self) -> Self {
        Self(mask(self.0.cmple(other.0)), mask(self.1.cmple(other.1)))
    }

    #[inline(always)]
    fn same(self, other: Self) -> Self {
        Self(mask(self.0.cmpeq(other.0)), mask(self.1.cmpeq(other.1)))
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self.select(other, Self::zero())
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self.select(self, other)
    }

    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        let four = |mask, yes, no| Vec4::select(holds(mask), yes, no);
        Self(four(self.0, yes.0, no.0), four(self.1, yes.1, no.1))
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        holds(self.0).bitmask() | holds(self.1).bitmask() << 4
    }

    #[inline(always)]
    fn rows(packed: &[Vec4], rows: &[u32; LANES]) -> [Self; 4] {
        Self::columns(|i| packed[rows[i] as usize])
    }

    #[inline(always)]
    fn put_rows(packed: &mut [Vec4], rows: &[u32; LANES], columns: [Self; 4]) {
        for (value, &row) in Self::eight_rows(columns).into_iter().zip(rows) {
            packed[row as usize] = value;
        }
    }

    #[inline(always)]
    fn records<const N: usize>(from: &[Record], rows: &[u32; LANES]) -> [[Self; 4]; N] {
        core::array::from_fn(|field| Self::columns(|i| from[rows[i] as usize].0[field]))
    }

    #[inline(always)]
    fn put_records<const N: usize>(
        to: &mut [Record],
        rows: &[u32; LANES],
        columns: [[Self; 4]; N],
    ) {
        for (field, columns) in columns.into_iter().enumerate() {
            for (value, &row) in Self::eight_rows(columns).into_iter().zip(rows) {
                to[row as usize].0[field] = value;
            }
        }
    }

    #[inline(always)]
    fn run_by_parity(packed: &[Vec4], first: usize) -> [Self; 4] {
        let packed = &packed[first..first + LANES];
        Self::columns(|i| packed[PARITY[i]])
    }

    #[inline(always)]
    fn put_run_by_parity(packed: &mut [Vec4], first: usize, columns: [Self; 4]) {
        let packed = &mut packed[first..first + LANES];
        for (row, &place) in Self::eight_rows(columns).into_iter().zip(&PARITY) {
            packed[place] = row;
        }
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
