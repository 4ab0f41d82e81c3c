//! A sphere against anything without dents: one rule for all such shapes, which each only tell where they are nearest and where a way leads in.
//!
//! # The rule
//!
//! Let `c` be the point of the surface nearest to where the centre goes, and `n` the direction out of the surface there. The plane through `c` across
//! `n` has the whole shape behind it. If the centre came from in front of that plane, then no part of its way up to the plane was in the shape, so it
//! is on the side where it came from, and the nearest way out is the right one: along `n`, by the radius less the distance. That is nearly always so,
//! and costs no more than the nearest point.
//!
//! If it came from behind that plane, it may have gone through. Then the place where its way enters counts, with the direction `m` out of the surface
//! there: the plane there has the shape behind it, and the start in front. If the sphere ended inside and `n` is within 60° of `m`, it has only gone
//! round a bend, and goes out along `n`. Otherwise, as through a thin plate, it is put in front of the plane where it entered, which is where an
//! impact without friction at that place would have kept it.
//!
//! One that started inside (constraints may press a particle in a little, and a shape may be put over it) belongs to the side that is nearest to the
//! start.

use glam::Vec3;

use super::{Nearest, RayHit, ShapeTouch};
use crate::lanes::{Number, Vector};

/// A shape without dents.
pub(super) trait Convex {
    /// The point of the surface nearest to `p`; see [`Nearest`].
    fn nearest(&self, p: Vec3) -> Nearest;

    /// Where the way from `from` along `way` enters, at most `most` times as long. `None` if it begins inside.
    fn enter(&self, from: Vec3, way: Vec3, most: f32) -> Option<Entry>;

    /// What [`Shape::touch`](super::Shape::touch) says.
    #[inline(always)]
    fn touch(&self, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        self.touch_near(self.nearest(to), from, to, radius)
    }

    /// The same, given what is nearest to where the centre goes.
    #[inline(always)]
    fn touch_near(&self, near: Nearest, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        if near.normal.dot(from - near.point) >= 0.0 {
            return near.out(radius);
        }
        self.touch_from_behind(&near, from, to, radius)
    }

    /// The rare half of the rule.
    #[cold]
    fn touch_from_behind(
        &self,
        near: &Nearest,
        from: Vec3,
        to: Vec3,
        radius: f32,
    ) -> Option<ShapeTouch> {
        // Where something is not a number, every comparison fails, and it comes to this.
        if !(from.is_finite() && to.is_finite()) {
            return None;
        }
        let (normal, offset, passed) = match self.enter(from, to - from, 1.0) {
            Some(entry) => (entry.normal, entry.offset, near.distance > 0.0),
            None => {
                let home = self.nearest(from);
                if home.distance > 0.0 && near.distance > 0.0 {
                    return near.out(radius);
                }
                (home.normal, home.normal.dot(home.point), false)
            }
        };
        if !passed && near.normal.dot(normal) >= BEND {
            return near.out(radius);
        }
        ShapeTouch::new(normal, radius + offset - normal.dot(to))
    }

    /// What [`Shape::cast_ray`](super::Shape::cast_ray) says.
    fn cast(&self, origin: Vec3, direction: Vec3, max: f32) -> Option<RayHit> {
        let entry = self.enter(origin, direction, max)?;
        Some(RayHit { distance: entry.share, normal: entry.normal })
    }
}

/// Cosine of the angle between two places of a surface up to which one is still round the bend from the other: 60°.
pub(super) const BEND: f32 = 0.5;

/// Where a way enters a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// How many times the way's vector from its start.
    pub(super) share: f32,
    /// Unit vector out of the surface.
    pub(super) normal: Vec3,
    /// How far the shape reaches along the normal, metres from the origin.
    pub(super) offset: f32,
}

/// What is nearest to one point, or to each of eight: see [`Nearest`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestOf<N> {
    pub(crate) point: Vector<N>,
    pub(crate) normal: Vector<N>,
    pub(crate) distance: N,
}

impl<N: Number> NearestOf<N> {
    /// The usual half of the rule, of spheres that came from `from` to the points in question: how far each must go along the normal, metres, where it
    /// touches at all; and where it came from behind, which is for [`touch`](Convex::touch) to find out.
    #[inline(always)]
    pub(crate) fn touch(&self, from: Vector<N>, radius: N) -> Touches<N> {
        let depth = radius - self.distance;
        let in_front = N::zero().le(self.normal.dot(from - self.point));
        let touching = N::zero().lt(depth).and(depth.lt(N::splat(f32::INFINITY)));
        Touches { depth, touching: in_front.and(touching), in_front }
    }
}

/// Which of eight spheres touch something.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touches<N> {
    /// Metres.
    pub(crate) depth: N,
    /// A mask.
    pub(crate) touching: N,
    /// A mask: of others nothing is known yet.
    pub(crate) in_front: N,
}

impl From<NearestOf<f32>> for Nearest {
    #[inline(always)]
    fn from(NearestOf { point, normal, distance }: NearestOf<f32>) -> Self {
        Self { point: point.into(), normal: normal.into(), distance }
    }
}

impl Nearest {
    /// How a sphere with its centre at the point in question must go to be out.
    #[inline(always)]
    pub(super) fn out(&self, radius: f32) -> Option<ShapeTouch> {
        ShapeTouch::new(self.normal, radius - self.distance)
    }
}
