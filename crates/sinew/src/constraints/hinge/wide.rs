//! Eight signed angles side by side.

use core::f32::consts::TAU;

use super::Hinge;
use crate::constraints::wide::{CLEAR, Wide, beyond, eight, is_below, is_size, numbers};
use crate::constraints::{Constraint, ConstraintKind};
use crate::lanes::{LANES, Lanes, Vector, atan2};

/// The numbers of eight [`Hinge`]s.
#[derive(Clone, Debug)]
pub(crate) struct Hinges {
    /// The middle of each range, as an angle of -π to π, radians.
    middle: [f32; LANES],
    /// Half its width, radians.
    half: [f32; LANES],
    /// Cosine and sine of the middle; and a cosine that is safely above that of half the width.
    towards: [[f32; LANES]; 2],
    clear: [f32; LANES],
    /// Whether one of them has a range, and not one angle.
    is_limit: bool,
}

impl Wide<4> for Hinges {
    const IS_LIMIT: bool = true;

    fn of(constraints: [&Constraint; LANES]) -> Option<Self> {
        let hinges: [&Hinge; LANES] = eight(constraints, |c| match &c.kind {
            ConstraintKind::Hinge(equation) => Some(equation),
            _ => None,
        })?;
        let middle = |hinge: &Hinge| super::around(0.5 * (hinge.min + hinge.max));
        let half = |hinge: &Hinge| 0.5 * (hinge.max - hinge.min);
        Some(Self {
            middle: numbers(hinges, middle),
            half: numbers(hinges, half),
            towards: [libm::cosf, libm::sinf].map(|of| numbers(hinges, |hinge| of(middle(hinge)))),
            clear: numbers(hinges, |hinge| libm::cosf(half(hinge)) + CLEAR),
            is_limit: hinges.iter().any(|hinge| half(hinge) > 0.0),
        })
    }

    /// By the cosine of how far it is from the middle. Lines through the edge that are nearly along it are left to `evaluate`: the angle between
    /// those is round-off.
    #[inline(always)]
    fn is_kept<L: Lanes>(&self, points: &[Vector<L>; 4]) -> L {
        if !self.is_limit {
            return L::zero();
        }
        let [a, h0, h1, c] = *points;
        let (edge, to_a, to_c) = (h1 - h0, a - h0, c - h0);
        let (n, m) = (edge.cross(to_a), edge.cross(to_c));
        let square = edge.length_squared();
        let (n_square, m_square) = (n.length_squared(), m.length_squared());
        let least = L::splat(1e-4) * square;
        let apart = (least * to_a.length_squared())
            .lt(n_square)
            .and((least * to_c.length_squared()).lt(m_square));
        let [cosine, sine] = &self.towards;
        let along = edge.dot(n.cross(m)) / square.sqrt();
        let near = n.dot(m) * L::load(cosine) + along * L::load(sine);
        apart.and(is_below(near, n_square * m_square, L::load(&self.clear)))
    }

    /// See `dihedral`. The middle of the range has been brought to -π..π beforehand, so that one turn at most is to be taken off.
    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 4]) -> (L, [Vector<L>; 4]) {
        let [a, h0, h1, c] = *points;
        let edge = h1 - h0;
        let length = edge.length();
        let inverse = L::splat(1.0) / length;
        let axis = edge * inverse;
        let (to_a, to_c) = (a - h0, c - h0);
        let (n, m) = (axis.cross(to_a), axis.cross(to_c));
        let (n_square, m_square) = (n.length_squared(), m.length_squared());
        let round_off = L::splat(1e-12);
        let has_angle = is_size(length)
            .and((round_off * to_a.length_squared()).lt(n_square))
            .and((round_off * to_c.length_squared()).lt(m_square));
        let angle = atan2(axis.dot(n.cross(m)), n.dot(m));
        let from_middle = angle - L::load(&self.middle);
        let (half_turn, turn) = (L::splat(0.5 * TAU), L::splat(TAU));
        let above = half_turn.le(from_middle).and(turn);
        let below = from_middle.le(-half_turn).and(turn);
        let half = L::load(&self.half);
        let value = has_angle.and(beyond(from_middle - above + below, -half, half));

        let by_a = n * (L::splat(-1.0) / n_square);
        let by_c = m * (L::splat(1.0) / m_square);
        let (s, t) = (to_a.dot(axis) * inverse, to_c.dot(axis) * inverse);
        let one = L::splat(1.0);
        let by_h0 = by_a * (s - one) + by_c * (t - one);
        (value, [by_a, by_h0, by_a * -s - by_c * t, by_c])
    }
}
