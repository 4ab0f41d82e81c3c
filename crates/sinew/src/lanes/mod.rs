//! Eight numbers side by side (SIMD): the few operations that the wide kernels are written in, for any instruction set.
//!
//! A kernel is written once, over the trait [`Lanes`], and compiled for each [`InstructionSet`]; which one runs is chosen at run time. All give the same bits:
//! the only operations are `+ - × ÷ √`, comparisons and selections, which IEEE 754 defines to the last bit. There is no fused multiply-add and no reciprocal
//! estimate, and `min` and `max` are defined by a comparison and a selection, because instructions differ for NaN and ±0.
//!
//! | file | what it is |
//! |---|---|
//! | `quads` | two registers of four, by glam: SSE2 on x86-64, NEON on ARM, plain numbers elsewhere |
//! | `avx2`, `avx2_rows` | one register of eight; loading particles into it |
//! | `angle` | the arc tangent, in lanes |
//! | `doubles`, `avx2_doubles` | eight double-precision numbers, for sums |
//! | `columns` | particles as columns of x, y, z and w |
//! | `vector` | vectors of three lanes each |
//! | `single` | `f32` as a [`Number`]: one lane, for formulas that are also needed for a single item |
//! | `scalar` | tests: arrays of eight, the reference for the others |
//! | `twins` | tests: each operation of each set against the scalar one |
//!
//! # Kernels and their callers
//!
//! A kernel is no more than the loop over batches of eight: a function over [`Lanes`], to which `kernel!` adds the instruction set as the last argument. The
//! code that decides which kernels run, and in which order, is compiled once, for no particular instruction set, and calls them. So the code of a kernel exists
//! once for each set rather than once for each caller. A kernel that is generic over more than lanes, or that needs too many arguments for a function, is a
//! [`Work`].
//!
//! # Packed particles
//!
//! Particles lie in memory as `[x y z w]`, 16 bytes each. A kernel needs the x of eight particles in one register, the y in the next, and so on: eight loads
//! and a transposition. There are three ways to address the eight, cheapest last: any rows ([`Lanes::rows`]), pairs of neighbours for two sets of registers
//! ([`Lanes::pairs`]), consecutive rows ([`Lanes::run`]).
//!
//! All `unsafe` of Sinew is in this folder: for AVX2 instructions, which may only run after the machine has been checked for them, and for loads with one
//! bounds check for eight, or for a run of eights.

mod angle;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx2_doubles;
#[cfg(target_arch = "x86_64")]
mod avx2_rows;
mod columns;
mod doubles;
mod quads;
#[cfg(test)]
mod scalar;
mod single;
#[cfg(test)]
mod twins;
mod vector;

use core::ops::{Add, Div, Mul, Neg, Sub};

use glam::{Vec3, Vec4};

pub(crate) use angle::atan2;
pub(crate) use columns::{Columns, ColumnsView, EightPairs, PairKernel};
pub(crate) use doubles::Doubles;
pub(crate) use vector::Vector;

/// Number of lanes.
pub(crate) const LANES: usize = 8;

/// Eight numbers in memory.
pub(crate) type LaneArray = [f32; LANES];

/// Which of eight rows each lane holds when they are sorted by parity.
pub(crate) const PARITY_ORDER: [usize; LANES] = [0, 2, 4, 6, 1, 3, 5, 7];

/// Which of eight pairs of neighbours each lane holds after sixteen numbers are [split](Lanes::deinterleave): each half of a register is sorted by itself.
pub(crate) const PAIR_ORDER: [usize; LANES] = [0, 1, 4, 5, 2, 3, 6, 7];

/// The instruction set that kernels are compiled for. Results are the same bits with each of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InstructionSet {
    /// One number at a time: the reference that the others are tested against.
    #[cfg(test)]
    Scalar,
    /// Four numbers at a time: SSE2 or NEON, and plain numbers on machines that have neither.
    Simd128,
    /// Eight numbers at a time. On a machine without AVX2 this is the same as [`Simd128`](Self::Simd128).
    Avx2,
}

impl InstructionSet {
    /// All of them, the reference first.
    #[cfg(test)]
    pub(crate) const ALL: [Self; 3] = [Self::Scalar, Self::Simd128, Self::Avx2];

    /// The fastest one that this machine has.
    pub fn best() -> Self {
        if has_avx2() { Self::Avx2 } else { Self::Simd128 }
    }
}

impl Default for InstructionSet {
    fn default() -> Self {
        Self::best()
    }
}

/// A computation in lanes, for any implementation of them.
pub(crate) trait Work: Sized {
    /// Its result.
    type Output;

    /// Runs it. Implementations must be `#[inline(always)]`, and so must everything that they call: what is not inlined is not compiled for the instruction
    /// set, and every operation in it becomes a call. A closure cannot be marked so; one that has lanes in it may be called from one place only. Use loops and
    /// patterns instead of `array::map` and `array::from_fn`: their handling of a panic midway adds four functions to each kernel, for each use and each set.
    fn run<L: Lanes>(self) -> Self::Output;

    /// Runs it with AVX2, in a function of its own. It is a method because codegen units follow the types of the methods in them: as functions of this file all
    /// kernels would be one unit, for which one core generates code while the others wait.
    ///
    /// # Safety
    /// The machine has AVX2.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    #[allow(unsafe_code)]
    unsafe fn in_avx2(self) -> Self::Output {
        self.run::<avx2::Eight>()
    }

    /// Runs it in quads, likewise.
    #[inline(never)]
    fn in_quads(self) -> Self::Output {
        self.run::<quads::Quads>()
    }

    /// Runs it one number at a time, likewise.
    #[cfg(test)]
    #[inline(never)]
    fn in_scalars(self) -> Self::Output {
        self.run::<scalar::Array>()
    }
}

/// Runs a computation with the given instruction set.
#[inline]
pub(crate) fn with<W: Work>(instructions: InstructionSet, work: W) -> W::Output {
    match instructions {
        #[cfg(test)]
        InstructionSet::Scalar => work.in_scalars(),
        #[cfg(target_arch = "x86_64")]
        // SAFETY: the guard has just checked that the machine has AVX2.
        #[allow(unsafe_code)]
        InstructionSet::Avx2 if has_avx2() => unsafe { work.in_avx2() },
        _ => work.in_quads(),
    }
}

/// Turns a function over [`Lanes`] into a kernel: a function with the same arguments, followed by the [`InstructionSet`] to run with. The rules of
/// [`Work::run`] hold for the body.
macro_rules! kernel {
    (
        $(#[$meta:meta])*
        $visible:vis fn $name:ident<$lanes:ident: $bound:ident $(, const $number:ident: $type:ty)*>(
            $($argument:ident: $of:ty),* $(,)?
        ) $body:block
    ) => {
        $crate::lanes::kernel!(
            $(#[$meta])*
            $visible fn $name<$lanes: $bound $(, const $number: $type)*>($($argument: $of),*) -> () $body
        );
    };
    (
        $(#[$meta:meta])*
        $visible:vis fn $name:ident<$lanes:ident: $bound:ident $(, const $number:ident: $type:ty)*>(
            $($argument:ident: $of:ty),* $(,)?
        ) -> $output:ty $body:block
    ) => {
        $(#[$meta])*
        #[inline]
        $visible fn $name<$(const $number: $type),*>(
            $($argument: $of,)*
            instructions: $crate::lanes::InstructionSet,
        ) -> $output {
            struct Arguments<T $(, const $number: $type)*>(T);

            impl<$(const $number: $type),*> $crate::lanes::Work
                for Arguments<($($of,)*) $(, $number)*>
            {
                type Output = $output;

                #[inline(always)]
                fn run<$lanes: $bound>(self) -> $output {
                    let Self(($($argument,)*)) = self;
                    $body
                }
            }

            $crate::lanes::with(instructions, Arguments::<_ $(, $number)*>(($($argument,)*)))
        }
    };
}
pub(crate) use kernel;

#[inline]
fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// The lanes that are set in a mask, ascending: the same as `(0..LANES).filter(..)`, but without a call for each lane.
pub(crate) struct SetLanes(pub(crate) u32);

impl Iterator for SetLanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros();
        // Wrapping, for an empty mask.
        self.0 &= self.0.wrapping_sub(1);
        (lane < u32::BITS).then_some(lane as usize)
    }
}

/// Advances eight rows by one. All are incremented together: numbers made one by one would stall when they are read as one register.
#[inline(always)]
pub(crate) fn advance(rows: &mut [u32; LANES]) {
    rows.iter_mut().for_each(|row| *row += 1);
}

/// Data of one item that are gathered together: as many `Vec4` as there are lanes, on cache lines of their own.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Record(pub(crate) [Vec4; FIELDS]);

/// Number of `Vec4` in a [`Record`].
pub(crate) const FIELDS: usize = 8;

/// A type with `+ - × ÷` on itself.
pub(crate) trait Arithmetic:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
}

impl<N> Arithmetic for N where
    N: Copy
        + Add<Output = N>
        + Sub<Output = N>
        + Mul<Output = N>
        + Div<Output = N>
        + Neg<Output = N>
{
}

/// A number, or several side by side. Formulas that are needed for a single item as well as for eight are written over this trait; `f32` is the single number.
pub(crate) trait Number: Arithmetic {
    /// The same number in each lane.
    fn splat(x: f32) -> Self;
    /// The correctly rounded square root.
    fn sqrt(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;

    /// A mask of all ones where `self < other`, zeros elsewhere and for NaN. A mask has the same type as numbers, but is only good for
    /// [`select`](Self::select), [`and`](Self::and), [`or`](Self::or), [`any`](Self::any) and [`bits`](Self::bits).
    fn lt(self, other: Self) -> Self;
    /// The same for `self <= other`.
    fn le(self, other: Self) -> Self;
    /// The same for `self == other`.
    fn same(self, other: Self) -> Self;
    /// The intersection of two masks; or of a mask and numbers, the numbers where it is set and +0 elsewhere.
    fn and(self, other: Self) -> Self;
    /// The union of two masks.
    fn or(self, other: Self) -> Self;
    /// The lanes of `yes` where the mask `self` is set, those of `no` elsewhere.
    fn select(self, yes: Self, no: Self) -> Self;
    /// The bits of a mask that is set everywhere.
    const ALL: u32;
    /// One bit for each lane of a mask, lane 0 lowest.
    fn bits(self) -> u32;

    /// Whether a mask is set anywhere.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }

    /// Whether a mask is set everywhere.
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == Self::ALL
    }

    /// Zeros.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// The smaller of the two; `other` where either is NaN or both are zero.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }

    /// The larger of the two; `other` where either is NaN or both are zero.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        other.lt(self).select(self, other)
    }
}

/// Eight `f32` side by side.
///
/// Loads and stores panic where a slice is too short, as indexing does.
pub(crate) trait Lanes: Number {
    /// Eight double-precision numbers of the same instruction set.
    type Doubles: Doubles;

    /// Loads eight numbers.
    fn load(from: &[f32; LANES]) -> Self;
    /// Stores into an array.
    fn store(self, to: &mut [f32; LANES]);
    /// The same numbers in double precision.
    fn widen(self) -> Self::Doubles;
    /// Rounded to single precision.
    fn narrow(from: Self::Doubles) -> Self;

    /// `x y z w` of eight rows of packed particles.
    fn rows(packed: &[Vec4], rows: &[u32; LANES]) -> [Self; 4];
    /// Writes them back. If a row occurs twice, the last lane wins.
    fn put_rows(packed: &mut [Vec4], rows: &[u32; LANES], columns: [Self; 4]);
    /// The first `N` fields of eight records, each as its `x y z w`. Addresses are computed once for all fields.
    fn records<const N: usize>(from: &[Record], rows: &[u32; LANES]) -> [[Self; 4]; N];
    /// Writes the first `N` fields back. If a record occurs twice, the last lane wins.
    fn put_records<const N: usize>(to: &mut [Record], rows: &[u32; LANES], columns: [[Self; 4]; N]);
    /// `x y z w` of the eight rows from `first` on.
    fn run(packed: &[Vec4], first: usize) -> [Self; 4];
    /// Writes them back.
    fn put_run(packed: &mut [Vec4], first: usize, columns: [Self; 4]);
    /// The eight rows from `first` on, the even ones of the eight in lanes 0 to 3 and the odd ones in lanes 4 to 7. That is the order in which a transposition
    /// needs no permutation.
    fn run_by_parity(packed: &[Vec4], first: usize) -> [Self; 4];
    /// Writes them back.
    fn put_run_by_parity(packed: &mut [Vec4], first: usize, columns: [Self; 4]);
    /// Loads lanes 0 to 3, and 4 to 7.
    fn load_halves(low: &[f32; LANES / 2], high: &[f32; LANES / 2]) -> Self;
    /// Stores into two arrays.
    fn store_halves(self, low: &mut [f32; LANES / 2], high: &mut [f32; LANES / 2]);
    /// Splits sixteen numbers, these eight and the `next`, as eight pairs of neighbours in the order of [`PAIR_ORDER`]: the first of each, and the second.
    fn deinterleave(self, next: Self) -> (Self, Self);
    /// Interleaves such firsts and seconds again to sixteen numbers.
    fn interleave(self, seconds: Self) -> (Self, Self);
    /// Two rows as they lie in memory: `x y z w x y z w`.
    fn two(packed: &[Vec4], first: usize) -> Self;
    /// Writes them back.
    fn put_two(self, packed: &mut [Vec4], first: usize);
    /// The fourth number of each half in all four lanes of that half.
    fn fourths(self) -> Self;
    /// The same with the fourth number of each half from `other`.
    fn with_fourths(self, other: Self) -> Self;

    /// The eight numbers.
    #[inline(always)]
    fn array(self) -> [f32; LANES] {
        let mut array = [0.0; LANES];
        self.store(&mut array);
        array
    }

    /// The mask with the given [`bits`](Number::bits).
    #[inline(always)]
    fn mask(bits: u32) -> Self {
        let mut mask = [0.0; LANES];
        for (lane, set) in mask.iter_mut().enumerate() {
            *set = single::mask(bits >> lane & 1 != 0);
        }
        Self::load(&mask)
    }

    /// The largest of the eight, or `least` if that is larger; NaN is ignored.
    #[inline(always)]
    fn largest(self, least: f32) -> f32 {
        self.array().iter().fold(least, |most, &x| if x > most { x } else { most })
    }

    /// Sixteen rows from `first` on, as eight pairs of neighbours: `x y z w` of the first of each, and of the second of each.
    #[inline(always)]
    fn pairs(packed: &[Vec4], first: usize) -> ([Self; 4], [Self; 4]) {
        let (one, other) = pair_rows(first);
        (Self::rows(packed, &one), Self::rows(packed, &other))
    }

    /// Writes them back.
    #[inline(always)]
    fn put_pairs(packed: &mut [Vec4], first: usize, ones: [Self; 4], others: [Self; 4]) {
        let (one, other) = pair_rows(first);
        Self::put_rows(packed, &one, ones);
        Self::put_rows(packed, &other, others);
    }
}

#[inline(always)]
fn pair_rows(first: usize) -> ([u32; LANES], [u32; LANES]) {
    let mut pairs = ([0; LANES], [0; LANES]);
    for k in 0..LANES {
        (pairs.0[k], pairs.1[k]) = ((first + 2 * k) as u32, (first + 2 * k + 1) as u32);
    }
    pairs
}

/// The vector in one lane in memory.
#[inline(always)]
pub(crate) fn get([x, y, z]: &[LaneArray; 3], lane: usize) -> Vec3 {
    Vec3::new(x[lane], y[lane], z[lane])
}

/// Writes a vector into one lane in memory.
#[inline(always)]
pub(crate) fn set(to: &mut [LaneArray; 3], lane: usize, from: Vec3) {
    // Written out: a loop over two arrays is compiled to calls, and this is in the inner loops of packing.
    let [x, y, z] = to;
    (x[lane], y[lane], z[lane]) = (from.x, from.y, from.z);
}
