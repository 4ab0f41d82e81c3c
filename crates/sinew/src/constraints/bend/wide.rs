//! Eight bends side by side.

use glam::Vec3;

use super::{Bend, FLAT};
use crate::constraints::wide::{Wide, eight, numbers};
use crate::constraints::{Constraint, ConstraintKind};
use crate::lanes::{LANES, Lanes, Vector};

/// The numbers of eight [`Bend`]s.
#[derive(Clone, Debug)]
pub(crate) struct Bends {
    weights: [[f32; LANES]; 4],
    rest: [f32; LANES],
}

impl Wide<4> for Bends {
    const IS_LENGTH: bool = true;

    fn of(constraints: [&Constraint; LANES]) -> Option<Self> {
        let bends: [&Bend; LANES] = eight(constraints, |c| match &c.kind {
            ConstraintKind::Bend(equation) => Some(equation),
            _ => None,
        })?;
        let weights = [0, 1, 2, 3].map(|i| numbers(bends, |bend| bend.weights[i]));
        Some(Self { weights, rest: numbers(bends, |bend| bend.rest) })
    }

    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 4]) -> (L, [Vector<L>; 4]) {
        let [e0, e1, a, b] = *points;
        let (edge, to_a, to_b) = (e1 - e0, a - e0, b - e0);
        let [w0, w1, wa, wb] = &self.weights;
        let (w0, w1, wa, wb) = (L::load(w0), L::load(w1), L::load(wa), L::load(wb));
        let gap = edge * w1 + to_a * wa + to_b * wb;
        let (length, across) = (gap.length(), to_b - to_a);
        let rest = L::load(&self.rest);
        let nothing = length.same(L::zero());
        // Of a gap of nothing the direction is of any meaning only where there is to be one.
        let mut normal = gap * nothing.select(L::zero(), L::splat(1.0) / length);
        let small = length.le(L::splat(FLAT) * across.length());
        let flat = L::zero().lt(rest).and(nothing.or(small));
        if flat.any() {
            let up = edge.cross(across);
            let size = up.length();
            let up =
                Vector::splat(Vec3::Z).or_else(size.same(L::zero()), up * (L::splat(1.0) / size));
            normal = up.or_else(flat, normal);
        }
        (length - rest, [normal * w0, normal * w1, normal * wa, normal * wb])
    }
}
