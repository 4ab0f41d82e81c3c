//! Eight signed angles side by side.

use core::f32::consts::TAU;

use super::Hinge;
use crate::constraints::wide::{Wide, beyond, eight, is_size};
use crate::constraints::{Constraint, Law};
use crate::lanes::{LANES, Lanes, Vector, atan2};

/// The numbers of eight [`Hinge`]s.
#[derive(Clone, Debug)]
pub(crate) struct Hinges {
    /// The middle of each range, as an angle of -π to π, radians.
    middle: [f32; LANES],
    /// Half its width, radians.
    half: [f32; LANES],
}

impl Wide<4> for Hinges {
    fn of(constraints: [&Constraint; LANES]) -> Option<Self> {
        let hinges: [&Hinge; LANES] = eight(constraints, |c| match &c.law {
            Law::Hinge(law) => Some(law),
            _ => None,
        })?;
        let middle = |hinge: &Hinge| super::around(0.5 * (hinge.min + hinge.max));
        let half = |hinge: &Hinge| 0.5 * (hinge.max - hinge.min);
        Some(Self { middle: hinges.map(middle), half: hinges.map(half) })
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
