//! Vectors of three numbers each: a single vector, or eight side by side.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use glam::{DVec3, Vec3};

use super::{Arithmetic, Doubles, LANES, Lanes, Number};

/// A vector of numbers, or eight of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vector<N> {
    pub(crate) x: N,
    pub(crate) y: N,
    pub(crate) z: N,
}

impl<N: Arithmetic> Vector<N> {
    /// From three numbers.
    #[inline(always)]
    pub(crate) fn new(x: N, y: N, z: N) -> Self {
        Self { x, y, z }
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

    /// The product component by component.
    #[inline(always)]
    pub(crate) fn times(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }
}

impl<N: Number> Vector<N> {
    /// The same vector in each lane.
    #[inline(always)]
    pub(crate) fn splat(v: Vec3) -> Self {
        Self::new(N::splat(v.x), N::splat(v.y), N::splat(v.z))
    }

    /// The zero vector in each lane.
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self::new(N::zero(), N::zero(), N::zero())
    }

    /// The positions of packed particles, and their `w`.
    #[inline(always)]
    pub(crate) fn of([x, y, z, w]: [N; 4]) -> (Self, N) {
        (Self { x, y, z }, w)
    }

    /// Packed particles again.
    #[inline(always)]
    pub(crate) fn with(self, w: N) -> [N; 4] {
        [self.x, self.y, self.z, w]
    }

    #[inline(always)]
    pub(crate) fn length(self) -> N {
        self.dot(self).sqrt()
    }

    /// The smaller of the two, component by component: see [`Number::min`].
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self { x: self.x.min(other.x), y: self.y.min(other.y), z: self.z.min(other.z) }
    }

    /// The larger of the two, component by component: see [`Number::max`].
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    /// This one where a mask is set, the other elsewhere.
    #[inline(always)]
    pub(crate) fn or_else(self, mask: N, other: Self) -> Self {
        Self {
            x: mask.select(self.x, other.x),
            y: mask.select(self.y, other.y),
            z: mask.select(self.z, other.z),
        }
    }
}

impl<L: Lanes> Vector<L> {
    /// In double precision.
    #[inline(always)]
    pub(crate) fn widen(self) -> Vector<L::Doubles> {
        Vector { x: self.x.widen(), y: self.y.widen(), z: self.z.widen() }
    }

    /// Rounded to single precision.
    #[inline(always)]
    pub(crate) fn narrow(v: Vector<L::Doubles>) -> Self {
        Self { x: L::narrow(v.x), y: L::narrow(v.y), z: L::narrow(v.z) }
    }
}

impl<D: Doubles> Vector<D> {
    /// The same vector in each lane.
    #[inline(always)]
    pub(crate) fn double(v: DVec3) -> Self {
        Self { x: D::splat(v.x), y: D::splat(v.y), z: D::splat(v.z) }
    }

    #[inline(always)]
    pub(crate) fn arrays(self) -> [[f64; LANES]; 3] {
        [self.x.array(), self.y.array(), self.z.array()]
    }

    /// One bit for each lane with three finite components.
    #[inline(always)]
    pub(crate) fn finite(self) -> u32 {
        self.x.finite() & self.y.finite() & self.z.finite()
    }
}

impl From<DVec3> for Vector<f64> {
    #[inline(always)]
    fn from(v: DVec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vector<f64>> for DVec3 {
    #[inline(always)]
    fn from(v: Vector<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl From<Vec3> for Vector<f32> {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Self::new(v.x, v.y, v.z)
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
        impl<N: Arithmetic> $of for Vector<N> {
            type Output = Self;
            #[inline(always)]
            fn $operation(self, other: Self) -> Self {
                Self { x: self.x $sign other.x, y: self.y $sign other.y, z: self.z $sign other.z }
            }
        }
    )*};
}

each!(Add add +, Sub sub -);

impl<N: Arithmetic> Mul<N> for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: N) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl<N: Arithmetic> Div<N> for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, by: N) -> Self {
        Self { x: self.x / by, y: self.y / by, z: self.z / by }
    }
}

impl<N: Arithmetic> Neg for Vector<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<N: Arithmetic> AddAssign for Vector<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<N: Arithmetic> SubAssign for Vector<N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
