//! Sphere, capsule and cylinder: nearest point and ray entry in closed form.

use glam::Vec3;

use super::Nearest;
use super::convex::{Convex, Entry, NearestOf};
use crate::lanes::{Number, Vector};

/// A sphere that is centred at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    pub(super) radius: f32,
}

impl Ball {
    /// The nearest surface point of one point, or of each of eight.
    #[inline(always)]
    pub(super) fn nearest_of<N: Number>(&self, p: Vector<N>) -> NearestOf<N> {
        let radius = N::splat(self.radius);
        let (normal, length) = direction(p, Vector::splat(Vec3::Y));
        NearestOf { point: normal * radius, normal, distance: length - radius }
    }
}

impl Convex for Ball {
    #[inline(always)]
    fn nearest(&self, p: Vec3) -> Nearest {
        self.nearest_of(Vector::<f32>::splat(p)).into()
    }

    fn enter(&self, from: Vec3, motion: Vec3, max: f32) -> Option<Entry> {
        let share = into_ball(from, motion, self.radius, max)?;
        let normal = self.nearest(from + motion * share).normal;
        Some(Entry { share, normal, offset: self.radius })
    }
}

/// Everything within a radius of a segment of the y axis that is centred at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Capsule {
    pub(super) radius: f32,
    /// Half of the length of that segment.
    pub(super) half_height: f32,
}

impl Capsule {
    /// The nearest surface point of one point, or of each of eight.
    #[inline(always)]
    pub(super) fn nearest_of<N: Number>(&self, p: Vector<N>) -> NearestOf<N> {
        let (radius, half_height) = (N::splat(self.radius), N::splat(self.half_height));
        let axis = Vector::new(N::zero(), p.y.min(half_height).max(-half_height), N::zero());
        let (normal, length) = direction(p - axis, Vector::splat(Vec3::X));
        NearestOf { point: axis + normal * radius, normal, distance: length - radius }
    }
}

impl Convex for Capsule {
    #[inline(always)]
    fn nearest(&self, p: Vec3) -> Nearest {
        self.nearest_of(Vector::<f32>::splat(p)).into()
    }

    fn enter(&self, from: Vec3, motion: Vec3, max: f32) -> Option<Entry> {
        let Self { radius, half_height } = *self;
        if self.nearest(from).distance < 0.0 {
            return None;
        }
        // The union of two balls and the cylinder between them: the first entry into one of them is the entry into the whole.
        let ends = [half_height, -half_height].map(|y| Vec3::Y * y);
        let caps = ends.map(|end| into_ball(from - end, motion, radius, max));
        let side = into_ball(from.with_y(0.0), motion.with_y(0.0), radius, max)
            .filter(|share| (from.y + motion.y * share).abs() <= half_height);
        let share = [caps[0], caps[1], side].into_iter().flatten().reduce(f32::min)?;
        let normal = self.nearest(from + motion * share).normal;
        Some(Entry { share, normal, offset: radius + half_height * normal.y.abs() })
    }
}

/// A cylinder along y that is centred at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cylinder {
    pub(super) radius: f32,
    pub(super) half_height: f32,
}

impl Cylinder {
    /// The nearest surface point of one point, or of each of eight.
    #[inline(always)]
    pub(super) fn nearest_of<N: Number>(&self, p: Vector<N>) -> NearestOf<N> {
        let (radius, half_height) = (N::splat(self.radius), N::splat(self.half_height));
        let zero = N::zero();
        let (outward, length) = direction(Vector::new(p.x, zero, p.z), Vector::splat(Vec3::X));
        let up = p.y.lt(zero).select(N::splat(-1.0), N::splat(1.0));
        let (beside, above) = (length - radius, up * p.y - half_height);
        let (side, end) = (outward * radius, up * half_height);
        // The nearer of the side and an end; beyond both, the rim.
        let is_side = above.le(beside);
        let mut nearest = NearestOf {
            point: Vector::new(
                is_side.select(side.x, p.x),
                is_side.select(p.y, end),
                is_side.select(side.z, p.z),
            ),
            normal: outward.or_else(is_side, Vector::new(zero, up, zero)),
            distance: is_side.select(beside, above),
        };
        let is_rim = zero.lt(beside).and(zero.lt(above));
        if is_rim.any() {
            let rim = Vector::new(side.x, end, side.z);
            let (normal, distance) = direction(p - rim, outward);
            nearest = NearestOf {
                point: rim.or_else(is_rim, nearest.point),
                normal: normal.or_else(is_rim, nearest.normal),
                distance: is_rim.select(distance, nearest.distance),
            };
        }
        nearest
    }
}

impl Convex for Cylinder {
    #[inline(always)]
    fn nearest(&self, p: Vec3) -> Nearest {
        self.nearest_of(Vector::<f32>::splat(p)).into()
    }

    fn enter(&self, from: Vec3, motion: Vec3, max: f32) -> Option<Entry> {
        let Self { radius, half_height } = *self;
        let (at, along) = (from.with_y(0.0), motion.with_y(0.0));
        let outside = at.length_squared() >= radius * radius;
        let mut entry: Option<Entry> = None;
        if outside {
            let share = into_ball(at, along, radius, max)?;
            let (normal, _) =
                direction(Vector::<f32>::splat(at + along * share), Vector::splat(Vec3::X));
            let normal = normal.into();
            entry = Some(Entry { share, normal, offset: radius });
        }
        if from.y.abs() >= half_height {
            let up = if from.y < 0.0 { -1.0 } else { 1.0 };
            let sinks = motion.y * up < 0.0;
            if !sinks {
                return None;
            }
            let share = (up * half_height - from.y) / motion.y;
            if entry.is_none_or(|entry| share > entry.share) {
                entry = Some(Entry { share, normal: Vec3::Y * up, offset: half_height });
            }
        }
        // At the latest of the entries the point must be within the others.
        let entry = entry.filter(|entry| entry.share <= max)?;
        let place = from + motion * entry.share;
        let within = if entry.normal.y == 0.0 {
            place.y.abs() <= half_height
        } else {
            place.with_y(0.0).length_squared() <= radius * radius
        };
        within.then_some(entry)
    }
}

/// Unit vector and length; `otherwise` where there is no direction.
#[inline(always)]
fn direction<N: Number>(v: Vector<N>, otherwise: Vector<N>) -> (Vector<N>, N) {
    let length = v.length();
    // Squares of smaller lengths have lost their precision.
    let none = length.le(N::splat(1e-18));
    (otherwise.or_else(none, v / length), none.select(N::zero(), length))
}

/// Where a segment from outside enters a ball that is centred at the origin. Computed from the point of closest approach, because from afar the discriminant of
/// the plain quadratic equation is dominated by rounding.
fn into_ball(from: Vec3, motion: Vec3, radius: f32, max: f32) -> Option<f32> {
    let (square, toward) = (motion.length_squared(), -from.dot(motion));
    let comes = toward > 0.0 && square > 0.0 && from.length_squared() >= radius * radius;
    if !comes {
        return None;
    }
    let middle = toward / square;
    let left = radius * radius - (from + motion * middle).length_squared();
    let share = (middle - (left / square).sqrt()).max(0.0);
    (left >= 0.0 && share <= max).then_some(share)
}
