//! A box against points and ways, in closed form.

use glam::Vec3;

use super::Nearest;
use super::convex::{Convex, Entry};

/// A box about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cuboid {
    pub(super) half_size: Vec3,
}

impl Convex for Cuboid {
    #[inline(always)]
    fn nearest(&self, p: Vec3) -> Nearest {
        let half = self.half_size;
        let point = p.min(half).max(-half);
        let away = p - point;
        let square = away.length_squared();
        // Less than this is rounding of a place on the surface.
        if square > 1e-30 {
            let distance = square.sqrt();
            return Nearest { point, normal: away / distance, distance };
        }
        // Inside: out through the face with the least in the way.
        let gap = half - p.abs();
        let axis = if gap.x <= gap.y && gap.x <= gap.z {
            0
        } else if gap.y <= gap.z {
            1
        } else {
            2
        };
        let sign = if p[axis] < 0.0 { -1.0 } else { 1.0 };
        let (mut point, mut normal) = (p, Vec3::ZERO);
        point[axis] = sign * half[axis];
        normal[axis] = sign;
        Nearest { point, normal, distance: -gap[axis] }
    }

    fn enter(&self, from: Vec3, way: Vec3, most: f32) -> Option<Entry> {
        let mut entry: Option<Entry> = None;
        let mut exit = most;
        for axis in 0..3 {
            let (at, along, half) = (from[axis], way[axis], self.half_size[axis]);
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
