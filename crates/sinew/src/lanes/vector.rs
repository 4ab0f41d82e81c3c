//! Vectors of three numbers each: one, or eight side by side.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use glam::Vec3;

use super::Number;

/// A vector of numbers, or eight of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vector<N> {
    pub(crate) x: N,
    pub(crate) y: N,
    pub(crate) z: N,
}

impl<N: Number> Vector<N> {
    /// Of three lanes.
    #[inline(always)]
    pub(crate) fn new(x: N, y: N, z: N) -> Self {
        Self { x, y, z }
    }

    /// The same vector eight times.
    #[inline(always)]
    pub(crate) fn splat(v: Vec3) -> Self {
        Self::new(N::splat(v.x), N::splat(v.y), N::splat(v.z))
    }

    /// The positions of packed particles, and what is in their fourth lanes.
    #[inline(always)]
    pub(crate) fn of([x, y, z, w]: [N; 4]) -> (Self, N) {
        (Self { x, y, z }, w)
    }

    /// Packed particles again.
    #[inline(always)]
    pub(crate) fn with(self, w: N) -> [N; 4] {
        [self.x, self.y, self.z, w]
    }

    /// `x x' + y y' + z z'`, summed from the left.
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> N {
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
    pub(crate) fn length_squared(self) -> N {
        self.dot(self)
    }

    #[inline(always)]
    pub(crate) fn length(self) -> N {
        self.dot(self).sqrt()
    }

    /// Where a mask is set this one, elsewhere the other.
    #[inline(always)]
    pub(crate) fn or_else(self, mask: N, other: Self) -> Self {
        Self {
            x: mask.select(self.x, other.x),
            y: mask.select(self.y, other.y),
            z: mask.select(self.z, other.z),
        }
    }
}

impl From<Vector<f32>> for Vec3 {
    #[inline(always)]
    fn from(v: Vector<f32>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

macro_rules! each {
    ($($of:ident $operation:ident $sign:tt),*) => {$(
        impl<N: Number> $of for Vector<N> {
            type Output = Self;
            #[inline(always)]
            fn $operation(self, other: Self) -> Self {
                Self { x: self.x $sign other.x, y: self.y $sign other.y, z: self.z $sign other.z }
            }
        }
    )*};
}

each!(Add add +, Sub sub -);

impl<N: Number> Mul<N> for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: N) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl<N: Number> Div<N> for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, by: N) -> Self {
        Self { x: self.x / by, y: self.y / by, z: self.z / by }
    }
}

impl<N: Number> Neg for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<N: Number> AddAssign for Vector<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<N: Number> SubAssign for Vector<N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
