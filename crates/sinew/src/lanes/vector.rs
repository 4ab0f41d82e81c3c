//! Vectors of three lanes each: eight vectors side by side.

use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use glam::Vec3;

use super::Lanes;

/// Eight vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vector<L> {
    pub(crate) x: L,
    pub(crate) y: L,
    pub(crate) z: L,
}

impl<L: Lanes> Vector<L> {
    /// Of three lanes.
    #[inline(always)]
    pub(crate) fn new(x: L, y: L, z: L) -> Self {
        Self { x, y, z }
    }

    /// The same vector eight times.
    #[inline(always)]
    pub(crate) fn splat(v: Vec3) -> Self {
        Self::new(L::splat(v.x), L::splat(v.y), L::splat(v.z))
    }

    /// The positions of packed particles, and what is in their fourth lanes.
    #[inline(always)]
    pub(crate) fn of([x, y, z, w]: [L; 4]) -> (Self, L) {
        (Self { x, y, z }, w)
    }

    /// Packed particles again.
    #[inline(always)]
    pub(crate) fn with(self, w: L) -> [L; 4] {
        [self.x, self.y, self.z, w]
    }

    /// `x x' + y y' + z z'`, summed from the left.
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> L {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    #[inline(always)]
    pub(crate) fn length_squared(self) -> L {
        self.dot(self)
    }

    #[inline(always)]
    pub(crate) fn length(self) -> L {
        self.dot(self).sqrt()
    }

    /// Where a mask is set this one, elsewhere the other.
    #[inline(always)]
    pub(crate) fn or_else(self, mask: L, other: Self) -> Self {
        Self {
            x: mask.select(self.x, other.x),
            y: mask.select(self.y, other.y),
            z: mask.select(self.z, other.z),
        }
    }
}

macro_rules! each {
    ($($of:ident $operation:ident $sign:tt),*) => {$(
        impl<L: Lanes> $of for Vector<L> {
            type Output = Self;
            #[inline(always)]
            fn $operation(self, other: Self) -> Self {
                Self { x: self.x $sign other.x, y: self.y $sign other.y, z: self.z $sign other.z }
            }
        }
    )*};
}

each!(Add add +, Sub sub -);

impl<L: Lanes> Mul<L> for Vector<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: L) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl<L: Lanes> Neg for Vector<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<L: Lanes> AddAssign for Vector<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<L: Lanes> SubAssign for Vector<L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
