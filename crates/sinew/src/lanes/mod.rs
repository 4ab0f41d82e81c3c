//! Eight numbers side by side: the few operations that the wide kernels are written in, for whatever instructions the machine has.
//!
//! A kernel is written once, over the trait [`Lanes`], and compiled for each [`InstructionSet`]; which one runs is chosen when the program runs. All
//! give the same bits: there is nothing here but `+ - × ÷ √`, comparisons and selections, which IEEE 754 defines to the last bit. No fused
//! multiply-add, no reciprocal estimates, and `min` and `max` are made of a comparison and a selection, because instructions differ about NaN and ±0.
//!
//! | file | what it is |
//! |---|---|
//! | `quads` | two registers of four, by glam: SSE2 on x86-64, NEON on ARM, plain numbers elsewhere |
//! | `avx2`, `avx2_rows` | one register of eight; how particles get into it |
//! | `angle` | the arc tangent, in lanes |
//! | `doubles`, `avx2_doubles` | eight numbers of double precision, for sums |
//! | `columns` | particles as columns of x, y, z and w |
//! | `vector` | vectors of three lanes each |
//! | `single` | one number: formulas that are written over [`Number`] take it where one is asked for alone |
//! | `scalar` | tests: arrays of eight, the truth that the others must agree with |
//! | `twins` | tests: each operation of each set against the scalar one |
//!
//! # Kernels, and what calls them
//!
//! A kernel is the loop over eights and no more: a function over [`Lanes`] that `kernel!` makes one with the instruction set as its last argument. What
//! decides which kernels run, and in which order, is compiled once, for no particular instructions, and calls them. So the code of a kernel exists once
//! for each set, not once for each of its callers. One that is generic over more than lanes, or that takes more than a function should, is a [`Work`].
//!
//! # Packed particles
//!
//! Particles lie in memory as `[x y z w]`, 16 bytes each. A kernel wants the x of eight particles in one register, the y in the next, and so on:
//! eight loads and a transposition. Three ways to name the eight, cheapest last: any rows ([`Lanes::rows`]), pairs of neighbours that two registers
//! are made of ([`Lanes::pairs`]), consecutive rows ([`Lanes::run`]).
//!
//! This folder is the only home of `unsafe` in Sinew: for the instructions of AVX2, which exist only where the machine has been asked, and for loads
//! whose bounds are checked eight at a time, or once for a stretch of eights.

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
pub(crate) use columns::{Columns, Eights, OnPairs, Pair};
pub(crate) use doubles::Doubles;
pub(crate) use vector::Vector;

/// How many lanes there are.
pub(crate) const LANES: usize = 8;

/// Eight numbers as they lie in memory.
pub(crate) type LaneArray = [f32; LANES];

/// Which of eight rows each lane holds where they are sorted by parity.
pub(crate) const PARITY: [usize; LANES] = [0, 2, 4, 6, 1, 3, 5, 7];

/// Which of eight pairs of neighbours each lane holds where sixteen numbers are [parted](Lanes::part): halves of a register are sorted each by itself.
pub(crate) const PARTED: [usize; LANES] = [0, 1, 4, 5, 2, 3, 6, 7];

/// Instructions that kernels are compiled for. Results are the same bits with each of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InstructionSet {
    /// One number at a time: what the others are tested against.
    #[cfg(test)]
    Scalar,
    /// Four at a time: SSE2 or NEON, and plain numbers on machines that have neither.
    Simd128,
    /// Eight at a time. A machine without AVX2 takes this for [`Simd128`](Self::Simd128).
    Avx2,
}

impl InstructionSet {
    /// The best that this machine has.
    pub fn best() -> Self {
        if has_avx2() { Self::Avx2 } else { Self::Simd128 }
    }
}

impl Default for InstructionSet {
    fn default() -> Self {
        Self::best()
    }
}

/// Something to be done in lanes, whatever they are made of.
pub(crate) trait Work: Sized {
    /// What comes of it.
    type Output;

    /// Does it. To be marked `#[inline(always)]`, and so must be what it calls: what is not inlined is not compiled for the lanes' instructions, and
    /// every operation becomes a call. A closure cannot be marked: one that has lanes in it may be called from one place alone. And no `array::map` and
    /// `array::from_fn`, but loops and patterns: what those do about a panic halfway is four functions more in each kernel, for each use and each set.
    fn run<L: Lanes>(self) -> Self::Output;

    /// Does it in eights, in a function of its own. It stands here because a compiler's units of code follow the types whose methods they are: as
    /// functions of this file all kernels would be one unit, of which one core generates the code while the others wait.
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

    /// Does it in quads, likewise.
    #[inline(never)]
    fn in_quads(self) -> Self::Output {
        self.run::<quads::Quads>()
    }

    /// Does it one by one, likewise.
    #[cfg(test)]
    #[inline(never)]
    fn in_scalars(self) -> Self::Output {
        self.run::<scalar::Array>()
    }
}

/// Does something with the given instructions.
#[inline]
pub(crate) fn with<W: Work>(instructions: InstructionSet, work: W) -> W::Output {
    match instructions {
        #[cfg(test)]
        InstructionSet::Scalar => work.in_scalars(),
        #[cfg(target_arch = "x86_64")]
        // SAFETY: just asked.
        #[allow(unsafe_code)]
        InstructionSet::Avx2 if has_avx2() => unsafe { work.in_avx2() },
        _ => work.in_quads(),
    }
}

/// Makes a kernel of a function over [`Lanes`]: a function with the same arguments and the [`InstructionSet`] after them, which does it with those. The rules
/// of [`Work::run`] hold for the body.
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

/// The lanes that have a bit in a mask, ascending: what `(0..LANES).filter(..)` says, without a call for each lane.
pub(crate) struct SetLanes(pub(crate) u32);

impl Iterator for SetLanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros();
        // Of none, there is no bit to take away.
        self.0 &= self.0.wrapping_sub(1);
        (lane < u32::BITS).then_some(lane as usize)
    }
}

/// What is asked for together of one thing: as many quadruples as there are lanes, on lines of the cache of its own.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Record(pub(crate) [Vec4; FIELDS]);

/// How many quadruples a [`Record`] has.
pub(crate) const FIELDS: usize = 8;

/// What has `+ - × ÷`, of itself.
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

/// A number, or several side by side: what a formula is written over that is wanted of one thing as well as of eight. `f32` is the one.
pub(crate) trait Number: Arithmetic {
    /// The same number in each.
    fn splat(x: f32) -> Self;
    /// The correctly rounded square root.
    fn sqrt(self) -> Self;
    /// Without its sign.
    fn abs(self) -> Self;

    /// A mask of all ones where `self < other`, zeros elsewhere and for NaN. A mask is a number like any other, and only good for
    /// [`select`](Self::select), [`and`](Self::and), [`or`](Self::or), [`any`](Self::any) and [`bits`](Self::bits).
    fn lt(self, other: Self) -> Self;
    /// The same for `self <= other`.
    fn le(self, other: Self) -> Self;
    /// The same for `self == other`.
    fn same(self, other: Self) -> Self;
    /// Where both masks are set; or of a mask and numbers: the numbers where it is set, +0 elsewhere.
    fn and(self, other: Self) -> Self;
    /// Where one of two masks is set.
    fn or(self, other: Self) -> Self;
    /// Where a mask, `self`, is set the lanes of `yes`, elsewhere those of `no`.
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

    /// The lesser of the two, `other` where either is NaN or both are zero.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }

    /// The greater of the two, `other` where either is NaN or both are zero.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        other.lt(self).select(self, other)
    }
}

/// Eight `f32` side by side.
///
/// Loads and stores panic where a slice is too short, as indexing does.
pub(crate) trait Lanes: Number {
    /// Eight numbers of double precision on the same machine.
    type Doubles: Doubles;

    /// Eight numbers.
    fn load(from: &[f32; LANES]) -> Self;
    /// Into an array.
    fn store(self, to: &mut [f32; LANES]);
    /// The same numbers in double precision.
    fn widen(self) -> Self::Doubles;
    /// The nearest single ones.
    fn narrow(from: Self::Doubles) -> Self;

    /// `x y z w` of eight rows of packed particles.
    fn rows(packed: &[Vec4], rows: &[u32; LANES]) -> [Self; 4];
    /// Writes them back. Of rows that occur twice the last lane stays.
    fn put_rows(packed: &mut [Vec4], rows: &[u32; LANES], columns: [Self; 4]);
    /// The first fields of eight records, each as its `x y z w`: where they are is asked once for all fields.
    fn records<const N: usize>(from: &[Record], rows: &[u32; LANES]) -> [[Self; 4]; N];
    /// Writes the first fields back. Of records that occur twice the last lane stays.
    fn put_records<const N: usize>(to: &mut [Record], rows: &[u32; LANES], columns: [[Self; 4]; N]);
    /// `x y z w` of the eight rows from `first` on.
    fn run(packed: &[Vec4], first: usize) -> [Self; 4];
    /// Writes them back.
    fn put_run(packed: &mut [Vec4], first: usize, columns: [Self; 4]);
    /// The eight rows from `first` on, the even ones of the eight in lanes 0 to 3 and the odd ones in lanes 4 to 7: turned without sorting.
    fn run_by_parity(packed: &[Vec4], first: usize) -> [Self; 4];
    /// Writes them back.
    fn put_run_by_parity(packed: &mut [Vec4], first: usize, columns: [Self; 4]);
    /// Lanes 0 to 3, and 4 to 7.
    fn load_halves(low: &[f32; LANES / 2], high: &[f32; LANES / 2]) -> Self;
    /// Into two arrays.
    fn store_halves(self, low: &mut [f32; LANES / 2], high: &mut [f32; LANES / 2]);
    /// Sixteen numbers, these eight and the `next`, as eight pairs of neighbours in the order of [`PARTED`]: the first of each, and the second.
    fn part(self, next: Self) -> (Self, Self);
    /// The sixteen numbers of such pairs.
    fn join(self, seconds: Self) -> (Self, Self);
    /// Two rows as they lie: `x y z w x y z w`.
    fn two(packed: &[Vec4], first: usize) -> Self;
    /// Writes them back.
    fn put_two(self, packed: &mut [Vec4], first: usize);
    /// The fourth of each four, four times.
    fn fourths(self) -> Self;
    /// The same with the fourth of each four from `other`.
    fn with_fourths(self, other: Self) -> Self;

    /// The eight numbers.
    #[inline(always)]
    fn array(self) -> [f32; LANES] {
        let mut array = [0.0; LANES];
        self.store(&mut array);
        array
    }

    /// The mask that [`bits`](Number::bits) makes these bits of.
    #[inline(always)]
    fn mask(bits: u32) -> Self {
        let mut mask = [0.0; LANES];
        for (lane, set) in mask.iter_mut().enumerate() {
            *set = f32::from_bits(if bits >> lane & 1 == 0 { 0 } else { u32::MAX });
        }
        Self::load(&mask)
    }

    /// The largest of the eight, or `least` if that is larger; NaN does not count.
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

/// One vector into a lane of those that lie in memory.
#[inline(always)]
pub(crate) fn set(to: &mut [LaneArray; 3], lane: usize, from: Vec3) {
    // Written out: a loop over two arrays is one of calls, and this stands in the inner loops of packing.
    let [x, y, z] = to;
    (x[lane], y[lane], z[lane]) = (from.x, from.y, from.z);
}
