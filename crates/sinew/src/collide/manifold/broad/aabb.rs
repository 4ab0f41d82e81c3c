//! An AABB in SIMD registers, for code that compares many of them.

use glam::{Vec3, Vec3A};

/// Least and greatest corner, metres, each in one register. An AABB with a NaN overlaps nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    pub(super) least: Vec3A,
    pub(super) most: Vec3A,
}

impl Aabb {
    /// Overlaps nothing, and neither does its union with any other box.
    pub(crate) const NOWHERE: Self = Self { least: Vec3A::NAN, most: Vec3A::NAN };

    #[inline(always)]
    pub(crate) fn new((least, most): (Vec3, Vec3)) -> Self {
        Self { least: least.into(), most: most.into() }
    }

    #[inline(always)]
    pub(crate) fn corners(&self) -> (Vec3, Vec3) {
        (self.least.into(), self.most.into())
    }

    /// The union of two boxes.
    #[inline(always)]
    pub(crate) fn and(&self, other: &Self) -> Self {
        // `min` and `max` ignore NaN.
        if self.least.is_nan() || other.least.is_nan() {
            return Self::NOWHERE;
        }
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    /// Whether two boxes overlap or touch.
    #[inline(always)]
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        (self.least.cmple(other.most) & other.least.cmple(self.most)).all()
    }
}
