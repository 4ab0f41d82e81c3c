//! Round shapes: sphere against any shape with a nearest-point query, and capsule against capsule.

use glam::Vec3;

use super::super::shape::Shape;
use super::{Frame, Manifold, Point};

/// A sphere and any shape with a nearest-point query.
pub(super) fn sphere(radius: f32, b: &Shape, a_in_b: &Frame, reach: f32) -> Option<Manifold> {
    let nearest = b.nearest(a_in_b.translation);
    let (normal, distance) = (nearest.normal, nearest.distance - radius);
    let on_a = a_in_b.turn_back(normal * -radius);
    (distance <= reach).then(|| Manifold::single(normal, on_a, nearest.point, distance))
}

/// Capsules whose axes are closer to parallel than this (squared sine; 8°) touch in two points: with a single point they would roll about it.
const NEAR_PARALLEL: f32 = 0.02;

/// Two capsules, `[radius, half height]` each. Two points where they lie along each other.
pub(super) fn capsules(a: [f32; 2], b: [f32; 2], a_in_b: &Frame, reach: f32) -> Option<Manifold> {
    let [(radius_a, half_a), (radius_b, half_b)] = [(a[0], a[1]), (b[0], b[1])];
    let (t, axis) = (a_in_b.translation, a_in_b.rotation.y_axis);
    let (cosine, along) = (axis.y, t.dot(axis));
    let square = 1.0 - cosine * cosine;
    // The nearest place along the axis of `a` to a place along the axis of `b`, and vice versa.
    let on_a = |s: f32| limit(s * cosine - along, half_a);
    let on_b = |u: f32| limit(t.y + u * cosine, half_b);
    // The range of `b`'s axis that lies beside `a`'s axis.
    let aside = half_a * cosine.abs();
    let ends = [limit(t.y - aside, half_b), limit(t.y + aside, half_b)];
    let s = if square > 1e-6 {
        limit((t.y - cosine * along) / square, half_b)
    } else {
        0.5 * (ends[0] + ends[1])
    };
    let u = on_a(s);
    let s = on_b(u);
    let between = t + axis * u - Vec3::Y * s;
    let length = between.length();
    let normal =
        if length > 1e-6 * (radius_a + radius_b) { between / length } else { across(axis) };
    if length - radius_a - radius_b > reach {
        return None;
    }
    let contact = |u: f32, s: f32| {
        let surface_a = rim(axis, u, half_a, -normal) * radius_a;
        let surface_b = rim(Vec3::Y, s, half_b, normal) * radius_b;
        let (p, q) = (t + axis * u + surface_a, Vec3::Y * s + surface_b);
        Point { on_a: a_in_b.local(p), on_b: q, distance: (p - q).dot(normal) }
    };
    let mut manifold = Manifold::new(normal);
    if square < NEAR_PARALLEL {
        for s in ends {
            let u = on_a(s);
            let point = contact(u, on_b(u));
            if point.distance <= reach && ends[1] - ends[0] > 1e-3 * half_b {
                manifold.push(point);
            }
        }
    }
    if manifold.len == 0 {
        manifold.push(contact(u, s));
    }
    Some(manifold)
}

/// Clamps a place along an axis to its ends.
#[inline(always)]
pub(super) fn limit(place: f32, half: f32) -> f32 {
    place.max(-half).min(half)
}

/// Unit vector from the place `u` on a capsule's axis to the surface point that is farthest along `direction`: across the axis, except at the round ends.
#[inline(always)]
pub(super) fn rim(axis: Vec3, u: f32, half: f32, direction: Vec3) -> Vec3 {
    let along = direction.dot(axis);
    // With a tolerance, for ends that rounding has moved in a change of coordinates.
    if u.abs() >= 0.9999 * half && along * u >= 0.0 {
        return direction;
    }
    let side = direction - axis * along;
    let length = side.length();
    if length > 1e-6 { side / length } else { direction }
}

/// A unit direction across two intersecting axes, `axis` and y; across y if they are parallel.
fn across(axis: Vec3) -> Vec3 {
    let product = Vec3::new(axis.z, 0.0, -axis.x);
    let length = product.length();
    if length > 1e-3 { product / length } else { Vec3::X }
}
