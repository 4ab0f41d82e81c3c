//! Eight angles side by side, and what cones need of them.

use glam::Vec3;

use super::Angle;
use crate::constraints::wide::{Wide, beyond, eight, is_size, numbers};
use crate::constraints::{Constraint, ConstraintKind};
use crate::lanes::{LANES, Lanes, Vector, atan2};

/// The numbers of eight [`Angle`]s.
#[derive(Clone, Debug)]
pub(crate) struct Angles {
    min: [f32; LANES],
    max: [f32; LANES],
}

impl Wide<3> for Angles {
    fn of(constraints: [&Constraint; LANES]) -> Option<Self> {
        let angles: [&Angle; LANES] = eight(constraints, |c| match &c.kind {
            ConstraintKind::Angle(equation) => Some(equation),
            _ => None,
        })?;
        Some(Self {
            min: numbers(angles, |angle| angle.min),
            max: numbers(angles, |angle| angle.max),
        })
    }

    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 3]) -> (L, [Vector<L>; 3]) {
        let [a, b, c] = *points;
        let Turns { angle, by_u, by_v } = between_wide(a - b, c - b);
        let value = beyond(angle, L::load(&self.min), L::load(&self.max));
        (value, [by_u, -(by_u + by_v), by_v])
    }
}

/// Eight angles between two vectors, 0 to π, NaN where there is none, and how they change with each of them, rad/m.
pub(in crate::constraints) struct Turns<L> {
    pub(in crate::constraints) angle: L,
    pub(in crate::constraints) by_u: Vector<L>,
    pub(in crate::constraints) by_v: Vector<L>,
}

/// As the scalar `between`.
#[inline(always)]
pub(in crate::constraints) fn between_wide<L: Lanes>(u: Vector<L>, v: Vector<L>) -> Turns<L> {
    let (u_length, v_length) = (u.length(), v.length());
    let has_angle = is_size(u_length).and(is_size(v_length));
    let one = L::splat(1.0);
    let (by_u_length, by_v_length) = (one / u_length, one / v_length);
    let (u, v) = (u * by_u_length, v * by_v_length);
    let across = u.cross(v);
    let sine = across.length();
    let mut normal = across * (one / sine);
    let straight = sine.same(L::zero());
    if straight.any() {
        normal = any_normal_wide(u).or_else(straight, normal);
    }
    Turns {
        angle: has_angle.select(atan2(sine, u.dot(v)), L::splat(f32::NAN)),
        by_u: u.cross(normal) * by_u_length,
        by_v: normal.cross(v) * by_v_length,
    }
}

/// As the scalar `any_normal`.
#[inline(always)]
pub(in crate::constraints) fn any_normal_wide<L: Lanes>(u: Vector<L>) -> Vector<L> {
    let (x, y, z) = (u.x.abs(), u.y.abs(), u.z.abs());
    let (by_x, by_y, zero) = (x.le(y).and(x.le(z)), y.le(z), L::zero());
    let across = Vector::new(
        by_x.select(zero, by_y.select(-u.z, u.y)),
        by_x.select(u.z, by_y.select(zero, -u.x)),
        by_x.select(-u.y, by_y.select(u.x, zero)),
    );
    let inverse = L::splat(1.0) / across.length();
    (across * inverse).or_else(is_size(inverse), Vector::splat(Vec3::X))
}
