//! Sphere, capsule and cylinder against points and ways, in closed form.

use glam::Vec3;

use super::Nearest;
use super::convex::{Convex, Entry};

/// A sphere about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    pub(super) radius: f32,
}

impl Convex for Ball {
    #[inline(always)]
    fn nearest(&self, p: Vec3) -> Nearest {
        let (normal, length) = direction(p, Vec3::Y);
        Nearest { point: normal * self.radius, normal, distance: length - self.radius }
    }

    fn enter(&self, from: Vec3, way: Vec3, most: f32) -> Option<Entry> {
        let share = into_ball(from, way, self.radius, most)?;
        let (normal, _) = direction(from + way * share, Vec3::Y);
        Some(Entry { share, normal, offset: self.radius })
    }
}

/// All that is within the radius of a piece of the y axis about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Capsule {
    pub(super) radius: f32,
    /// Half the length of that piece.
    pub(super) half_height: f32,
}

impl Convex for Capsule {
    #[inline(always)]
    fn nearest(&self, p: Vec3) -> Nearest {
        let axis = Vec3::Y * p.y.min(self.half_height).max(-self.half_height);
        let (normal, length) = direction(p - axis, Vec3::X);
        let point = axis + normal * self.radius;
        Nearest { point, normal, distance: length - self.radius }
    }

    fn enter(&self, from: Vec3, way: Vec3, most: f32) -> Option<Entry> {
        let Self { radius, half_height } = *self;
        if self.nearest(from).distance < 0.0 {
            return None;
        }
        // It is the two balls and the cylinder between them; the first of them that the way enters is where it enters the whole.
        let ends = [half_height, -half_height].map(|y| Vec3::Y * y);
        let caps = ends.map(|end| into_ball(from - end, way, radius, most));
        let side = into_ball(from.with_y(0.0), way.with_y(0.0), radius, most)
            .filter(|share| (from.y + way.y * share).abs() <= half_height);
        let share = [caps[0], caps[1], side].into_iter().flatten().reduce(f32::min)?;
        let normal = self.nearest(from + way * share).normal;
        Some(Entry { share, normal, offset: radius + half_height * normal.y.abs() })
    }
}

/// A cylinder along y about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cylinder {
    pub(super) radius: f32,
    pub(super) half_height: f32,
}

impl Convex for Cylinder {
    #[inline(always)]
    fn nearest(&self, p: Vec3) -> Nearest {
        let Self { radius, half_height } = *self;
        let (outward, length) = direction(p.with_y(0.0), Vec3::X);
        let up = if p.y < 0.0 { -1.0 } else { 1.0 };
        let (beside, above) = (length - radius, up * p.y - half_height);
        if beside > 0.0 && above > 0.0 {
            let point = outward * radius + Vec3::Y * (up * half_height);
            let (normal, distance) = direction(p - point, outward);
            return Nearest { point, normal, distance };
        }
        if beside >= above {
            let point = (outward * radius).with_y(p.y);
            return Nearest { point, normal: outward, distance: beside };
        }
        Nearest { point: p.with_y(up * half_height), normal: Vec3::Y * up, distance: above }
    }

    fn enter(&self, from: Vec3, way: Vec3, most: f32) -> Option<Entry> {
        let Self { radius, half_height } = *self;
        let (at, along) = (from.with_y(0.0), way.with_y(0.0));
        let outside = at.length_squared() >= radius * radius;
        let mut entry: Option<Entry> = None;
        if outside {
            let share = into_ball(at, along, radius, most)?;
            let (normal, _) = direction(at + along * share, Vec3::X);
            entry = Some(Entry { share, normal, offset: radius });
        }
        if from.y.abs() >= half_height {
            let up = if from.y < 0.0 { -1.0 } else { 1.0 };
            let sinks = way.y * up < 0.0;
            if !sinks {
                return None;
            }
            let share = (up * half_height - from.y) / way.y;
            if entry.is_none_or(|entry| share > entry.share) {
                entry = Some(Entry { share, normal: Vec3::Y * up, offset: half_height });
            }
        }
        // Where it entered last it must still be within the other two.
        let entry = entry.filter(|entry| entry.share <= most)?;
        let place = from + way * entry.share;
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
fn direction(v: Vec3, otherwise: Vec3) -> (Vec3, f32) {
    let length = v.length();
    // Squares of less have no digits left.
    if length <= 1e-18 { (otherwise, 0.0) } else { (v / length, length) }
}

/// Where a way from outside enters a ball about the origin. Taken from the place where it passes nearest to the origin, because
/// from afar the discriminant of the plain quadratic equation is all rounding.
fn into_ball(from: Vec3, way: Vec3, radius: f32, most: f32) -> Option<f32> {
    let (square, toward) = (way.length_squared(), -from.dot(way));
    let comes = toward > 0.0 && square > 0.0 && from.length_squared() >= radius * radius;
    if !comes {
        return None;
    }
    let middle = toward / square;
    let left = radius * radius - (from + way * middle).length_squared();
    let share = (middle - (left / square).sqrt()).max(0.0);
    (left >= 0.0 && share <= most).then_some(share)
}
