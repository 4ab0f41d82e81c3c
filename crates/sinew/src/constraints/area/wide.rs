//! Eight areas side by side.

use super::Area;
use crate::constraints::angle::any_normal_wide;
use crate::constraints::wide::{Wide, eight, numbers};
use crate::constraints::{Constraint, ConstraintKind};
use crate::lanes::{LANES, Lanes, Vector};

/// The numbers of eight [`Area`]s.
#[derive(Clone, Debug)]
pub(crate) struct Areas {
    rest: [f32; LANES],
}

impl Wide<3> for Areas {
    fn of(constraints: [&Constraint; LANES]) -> Option<Self> {
        let areas: [&Area; LANES] = eight(constraints, |c| match &c.kind {
            ConstraintKind::Area(equation) => Some(equation),
            _ => None,
        })?;
        Some(Self { rest: numbers(areas, |area| area.rest) })
    }

    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 3]) -> (L, [Vector<L>; 3]) {
        let (now, mut gradients) = area_wide(points);
        let rest = L::load(&self.rest);
        let value = now - rest;
        let mut square = L::zero();
        for gradient in &gradients {
            square = square + gradient.length_squared();
        }
        let (one, reach) = (L::splat(1.0), now.max(rest).sqrt());
        let factor = value.abs() / ((square * L::splat(3.0)).sqrt() * reach);
        let far = one.lt(factor).and(factor.le(L::splat(f32::MAX)));
        if far.any() {
            steeper(far.select(factor, one), &mut gradients);
        }
        (value, gradients)
    }
}

/// As the scalar `area`.
#[inline(always)]
pub(in crate::constraints) fn area_wide<L: Lanes>(points: &[Vector<L>; 3]) -> (L, [Vector<L>; 3]) {
    let [a, b, c] = *points;
    let (u, v) = (b - a, c - a);
    let cross = u.cross(v);
    let size = cross.x.abs().max(cross.y.abs()).max(cross.z.abs());
    let cross = Vector::new(cross.x / size, cross.y / size, cross.z / size);
    let length = cross.length();
    let mut normal = cross * (L::splat(1.0) / length);
    let mut twice = size * length;
    let flat = size.same(L::zero());
    if flat.any() {
        let longer = u.or_else(v.length_squared().lt(u.length_squared()), v);
        normal = any_normal_wide(longer).or_else(flat, normal);
        twice = flat.select(L::zero(), twice);
    }
    let half = L::splat(0.5);
    let (by_b, by_c) = (v.cross(normal) * half, normal.cross(u) * half);
    (half * twice, [-(by_b + by_c), by_b, by_c])
}

/// Makes gradients so many times steeper.
#[inline(always)]
pub(in crate::constraints) fn steeper<L: Lanes, const N: usize>(
    factor: L,
    gradients: &mut [Vector<L>; N],
) {
    for gradient in gradients {
        *gradient = *gradient * factor;
    }
}
