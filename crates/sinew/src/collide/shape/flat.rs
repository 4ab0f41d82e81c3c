//! A box: nearest point and ray entry in closed form.

use glam::Vec3;

use super::Nearest;
use super::convex::{Convex, Entry, NearestOf};
use crate::lanes::{Number, Vector};

/// A box that is centred at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cuboid {
    pub(super) half_size: Vec3,
}

impl Cuboid {
    /// The nearest surface point of one point, or of each of eight.
    #[inline(always)]
    pub(super) fn nearest_of<N: Number>(&self, p: Vector<N>) -> NearestOf<N> {
        let half = Vector::<N>::splat(self.half_size);
        let clamped = |x: N, half: N| x.min(half).max(-half);
        let point = Vector::new(clamped(p.x, half.x), clamped(p.y, half.y), clamped(p.z, half.z));
        let away = p - point;
        let square = away.length_squared();
        let distance = square.sqrt();
        let outside = NearestOf { point, normal: away / distance, distance };
        // Below this the point is on the surface, to rounding.
        let is_outside = N::splat(1e-30).lt(square);
        if is_outside.all() {
            return outside;
        }
        let inside = self.nearest_within(p);
        NearestOf {
            point: outside.point.or_else(is_outside, inside.point),
            normal: outside.normal.or_else(is_outside, inside.normal),
            distance: is_outside.select(outside.distance, inside.distance),
        }
    }

    /// The nearest surface point of a point inside: through the nearest face.
    #[inline(always)]
    fn nearest_within<N: Number>(&self, p: Vector<N>) -> NearestOf<N> {
        let (half, zero) = (Vector::<N>::splat(self.half_size), N::zero());
        let gap = Vector::new(half.x - p.x.abs(), half.y - p.y.abs(), half.z - p.z.abs());
        let is_x = gap.x.le(gap.y).and(gap.x.le(gap.z));
        let is_y = gap.y.le(gap.z);
        let sign = |x: N| x.lt(zero).select(N::splat(-1.0), N::splat(1.0));
        let (x, y, z) = (sign(p.x), sign(p.y), sign(p.z));
        let pick = |of_x: N, of_y: N, of_z: N| is_x.select(of_x, is_y.select(of_y, of_z));
        NearestOf {
            point: Vector::new(
                pick(x * half.x, p.x, p.x),
                pick(p.y, y * half.y, p.y),
                pick(p.z, p.z, z * half.z),
            ),
            normal: Vector::new(pick(x, zero, zero), pick(zero, y, zero), pick(zero, zero, z)),
            distance: -pick(gap.x, gap.y, gap.z),
        }
    }
}

impl Convex for Cuboid {
    #[inline(always)]
    fn nearest(&self, p: Vec3) -> Nearest {
        self.nearest_of(Vector::<f32>::splat(p)).into()
    }

    fn enter(&self, from: Vec3, motion: Vec3, max: f32) -> Option<Entry> {
        let mut entry: Option<Entry> = None;
        let mut exit = max;
        for axis in 0..3 {
            let (at, along, half) = (from[axis], motion[axis], self.half_size[axis]);
            if at.abs() >= half {
                let sign = if at < 0.0 { -1.0 } else { 1.0 };
                let inward = along * sign < 0.0;
                if !inward {
                    return None;
                }
                let share = (sign * half - at) / along;
                if entry.is_none_or(|entry| share > entry.share) {
                    let mut normal = Vec3::ZERO;
                    normal[axis] = sign;
                    entry = Some(Entry { share, normal, offset: half });
                }
            }
            if along != 0.0 {
                let far = if along < 0.0 { -half } else { half };
                exit = exit.min((far - at) / along);
            }
        }
        entry.filter(|entry| entry.share <= exit)
    }
}
