//! Arrays of eight: the reference with which every other implementation must agree to the bit. For tests only.
//!
//! Operations are not inlined: written out eight times each in every kernel they would take up most of the time that compiling the crate takes, and the
//! reference need not be fast.

use glam::Vec4;

use super::doubles::Each;
use super::single::mask;
use super::{LANES, Lanes, Number, PAIR_ORDER, PARITY_ORDER, Record};

/// Eight numbers, one after the other.
pub(super) type Array = Each<f32>;

impl Array {
    #[inline(always)]
    fn mask(self, other: Self, of: impl Fn(f32, f32) -> bool) -> Self {
        self.zip(other, |a, b| mask(of(a, b)))
    }

    #[inline(always)]
    fn columns(of: impl Fn(usize) -> Vec4) -> [Self; 4] {
        let rows: [Vec4; LANES] = core::array::from_fn(of);
        core::array::from_fn(|column| Self(rows.map(|row| row[column])))
    }

    #[inline(always)]
    fn row([x, y, z, w]: [Self; 4], lane: usize) -> Vec4 {
        Vec4::new(x.0[lane], y.0[lane], z.0[lane], w.0[lane])
    }
}

impl Number for Array {
    const ALL: u32 = 0xFF;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(never)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(never)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(never)]
    fn lt(self, other: Self) -> Self {
        self.mask(other, |a, b| a < b)
    }

    #[inline(never)]
    fn le(self, other: Self) -> Self {
        self.mask(other, |a, b| a <= b)
    }

    #[inline(never)]
    fn same(self, other: Self) -> Self {
        self.mask(other, |a, b| a == b)
    }

    #[inline(never)]
    fn and(self, other: Self) -> Self {
        self.zip(other, |a, b| f32::from_bits(a.to_bits() & b.to_bits()))
    }

    #[inline(never)]
    fn or(self, other: Self) -> Self {
        self.zip(other, |a, b| f32::from_bits(a.to_bits() | b.to_bits()))
    }

    #[inline(never)]
    fn select(self, yes: Self, no: Self) -> Self {
        Self(core::array::from_fn(|i| if self.0[i].to_bits() == 0 { no.0[i] } else { yes.0[i] }))
    }

    #[inline(never)]
    fn bits(self) -> u32 {
        (0..LANES).map(|i| u32::from(self.0[i].to_bits() != 0) << i).sum()
    }
}

impl Lanes for Array {
    type Doubles = Each<f64>;

    #[inline(always)]
    fn load(from: &[f32; LANES]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        *to = self.0;
    }

    #[inline(never)]
    fn widen(self) -> Each<f64> {
        Each(self.0.map(f64::from))
    }

    #[inline(never)]
    fn narrow(from: Each<f64>) -> Self {
        Self(from.0.map(|x| x as f32))
    }

    #[inline(never)]
    fn rows(packed: &[Vec4], rows: &[u32; LANES]) -> [Self; 4] {
        Self::columns(|i| packed[rows[i] as usize])
    }

    #[inline(never)]
    fn put_rows(packed: &mut [Vec4], rows: &[u32; LANES], columns: [Self; 4]) {
        for (lane, &row) in rows.iter().enumerate() {
            packed[row as usize] = Self::row(columns, lane);
        }
    }

    #[inline(never)]
    fn records<const N: usize>(from: &[Record], rows: &[u32; LANES]) -> [[Self; 4]; N] {
        core::array::from_fn(|field| Self::columns(|i| from[rows[i] as usize].0[field]))
    }

    #[inline(never)]
    fn put_records<const N: usize>(
        to: &mut [Record],
        rows: &[u32; LANES],
        columns: [[Self; 4]; N],
    ) {
        for (field, columns) in columns.into_iter().enumerate() {
            for (lane, &row) in rows.iter().enumerate() {
                to[row as usize].0[field] = Self::row(columns, lane);
            }
        }
    }

    #[inline(never)]
    fn run_by_parity(packed: &[Vec4], first: usize) -> [Self; 4] {
        Self::columns(|i| packed[first + PARITY_ORDER[i]])
    }

    #[inline(never)]
    fn put_run_by_parity(packed: &mut [Vec4], first: usize, columns: [Self; 4]) {
        for lane in 0..LANES {
            packed[first + PARITY_ORDER[lane]] = Self::row(columns, lane);
        }
    }

    #[inline(never)]
    fn load_halves(low: &[f32; LANES / 2], high: &[f32; LANES / 2]) -> Self {
        Self(core::array::from_fn(|i| if i < LANES / 2 { low[i] } else { high[i - LANES / 2] }))
    }

    #[inline(never)]
    fn store_halves(self, low: &mut [f32; LANES / 2], high: &mut [f32; LANES / 2]) {
        low.copy_from_slice(&self.0[..LANES / 2]);
        high.copy_from_slice(&self.0[LANES / 2..]);
    }

    #[inline(never)]
    fn run(packed: &[Vec4], first: usize) -> [Self; 4] {
        Self::columns(|i| packed[first + i])
    }

    #[inline(never)]
    fn put_run(packed: &mut [Vec4], first: usize, columns: [Self; 4]) {
        for lane in 0..LANES {
            packed[first + lane] = Self::row(columns, lane);
        }
    }

    #[inline(never)]
    fn deinterleave(self, next: Self) -> (Self, Self) {
        let all = [self.0, next.0].concat();
        let each = |second: usize| core::array::from_fn(|lane| all[2 * PAIR_ORDER[lane] + second]);
        (Self(each(0)), Self(each(1)))
    }

    #[inline(never)]
    fn interleave(self, seconds: Self) -> (Self, Self) {
        let mut all = [[0.0; LANES]; 2];
        for (lane, &pair) in PAIR_ORDER.iter().enumerate() {
            all.as_flattened_mut()[2 * pair] = self.0[lane];
            all.as_flattened_mut()[2 * pair + 1] = seconds.0[lane];
        }
        (Self(all[0]), Self(all[1]))
    }

    #[inline(never)]
    fn two(packed: &[Vec4], first: usize) -> Self {
        let [a, b] = [packed[first].to_array(), packed[first + 1].to_array()];
        Self([a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]])
    }

    #[inline(never)]
    fn put_two(self, packed: &mut [Vec4], first: usize) {
        packed[first] = Vec4::from_slice(&self.0[..4]);
        packed[first + 1] = Vec4::from_slice(&self.0[4..]);
    }

    #[inline(never)]
    fn fourths(self) -> Self {
        Self(core::array::from_fn(|i| self.0[i | 3]))
    }

    #[inline(never)]
    fn with_fourths(self, other: Self) -> Self {
        Self(core::array::from_fn(|i| if i % 4 == 3 { other.0[i] } else { self.0[i] }))
    }
}
