//! A sphere against any convex shape: one rule for all, for which a shape only provides its nearest point and the entry of a segment.
//!
//! # The rule
//!
//! Let `c` be the surface point nearest to the end of the centre's path, and `n` the outward normal there. The plane through `c` perpendicular to `n` has the
//! whole shape behind it. If the path starts in front of that plane, then no part of it in front of the plane was in the shape, so the sphere is on the side
//! that it came from, and the nearest way out is the right one: along `n`, by the radius minus the distance. This is nearly always the case, and costs no more
//! than the nearest point.
//!
//! If the path starts behind that plane, the sphere may have passed through the shape. Then the point where the path enters counts, with the outward normal `m`
//! there: the plane there has the shape behind it and the start in front. If the sphere ended inside and `n` is within 60° of `m`, it only went round a bend,
//! and leaves along `n`. Otherwise, as through a thin plate, it is placed in front of the plane where it entered, which is where a frictionless impact at that
//! point would have kept it.
//!
//! A sphere that started inside (constraints may push a particle in slightly, and a shape may be placed over it) belongs to the side that is nearest to the
//! start.

use glam::Vec3;

use super::{Nearest, RayHit, ShapeTouch};
use crate::lanes::{Number, Vector};

/// A convex shape.
pub(super) trait Convex {
    /// The surface point nearest to `p`; see [`Nearest`].
    fn nearest(&self, p: Vec3) -> Nearest;

    /// Where the segment from `from` along `motion` enters, at a multiple of `motion` of at most `max`. `None` if it starts inside.
    fn enter(&self, from: Vec3, motion: Vec3, max: f32) -> Option<Entry>;

    /// See [`Shape::touch`](super::Shape::touch).
    #[inline(always)]
    fn touch(&self, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        self.touch_near(self.nearest(to), from, to, radius)
    }

    /// As [`touch`](Self::touch), given the surface point nearest to the end of the path.
    #[inline(always)]
    fn touch_near(&self, near: Nearest, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        if near.normal.dot(from - near.point) >= 0.0 {
            return near.push_out(radius);
        }
        self.touch_from_behind(&near, from, to, radius)
    }

    /// The rare case of the rule: the path starts behind the plane.
    #[cold]
    fn touch_from_behind(
        &self,
        near: &Nearest,
        from: Vec3,
        to: Vec3,
        radius: f32,
    ) -> Option<ShapeTouch> {
        // With NaN every comparison fails, and control reaches this point.
        if !(from.is_finite() && to.is_finite()) {
            return None;
        }
        let (normal, offset, passed) = match self.enter(from, to - from, 1.0) {
            Some(entry) => (entry.normal, entry.offset, near.distance > 0.0),
            None => {
                let at_start = self.nearest(from);
                if at_start.distance > 0.0 && near.distance > 0.0 {
                    return near.push_out(radius);
                }
                (at_start.normal, at_start.normal.dot(at_start.point), false)
            }
        };
        if !passed && near.normal.dot(normal) >= BEND_COSINE {
            return near.push_out(radius);
        }
        ShapeTouch::new(normal, radius + offset - normal.dot(to))
    }

    /// See [`Shape::cast_ray`](super::Shape::cast_ray).
    fn cast(&self, origin: Vec3, direction: Vec3, max: f32) -> Option<RayHit> {
        let entry = self.enter(origin, direction, max)?;
        Some(RayHit { distance: entry.share, normal: entry.normal })
    }
}

/// Cosine of the greatest angle between the normals of two surface points at which a path still counts as going round a bend: 60°.
pub(super) const BEND_COSINE: f32 = 0.5;

/// Where a segment enters a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Position along the segment, as a multiple of its vector.
    pub(super) share: f32,
    /// Unit outward normal.
    pub(super) normal: Vec3,
    /// Extent of the shape along the normal, metres from the origin.
    pub(super) offset: f32,
}

/// The nearest surface point of one point, or of each of eight: see [`Nearest`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestOf<N> {
    pub(crate) point: Vector<N>,
    pub(crate) normal: Vector<N>,
    pub(crate) distance: N,
}

impl<N: Number> NearestOf<N> {
    /// The common case of the rule, for spheres that came from `from` to the query points: the depth of each along its normal, metres, and whether it touches;
    /// and whether it came from in front. Others must be tested by [`touch`](Convex::touch).
    #[inline(always)]
    pub(crate) fn touch(&self, from: Vector<N>, radius: N) -> Touches<N> {
        let depth = radius - self.distance;
        let in_front = N::zero().le(self.normal.dot(from - self.point));
        let touching = N::zero().lt(depth).and(depth.lt(N::splat(f32::INFINITY)));
        Touches { depth, touching: in_front.and(touching), in_front }
    }
}

/// Contacts of eight spheres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touches<N> {
    /// Penetration depth, metres.
    pub(crate) depth: N,
    /// Mask of the spheres that touch.
    pub(crate) touching: N,
    /// Mask of the spheres that came from in front; for the others the result is not valid.
    pub(crate) in_front: N,
}

impl From<NearestOf<f32>> for Nearest {
    #[inline(always)]
    fn from(NearestOf { point, normal, distance }: NearestOf<f32>) -> Self {
        Self { point: point.into(), normal: normal.into(), distance }
    }
}

impl Nearest {
    /// The correction of a sphere that is centred at the query point.
    #[inline(always)]
    pub(super) fn push_out(&self, radius: f32) -> Option<ShapeTouch> {
        ShapeTouch::new(self.normal, radius - self.distance)
    }
}
