//! Eight cones side by side.

use super::Cone;
use crate::constraints::angle::{Turns, between_wide};
use crate::constraints::wide::{CLEAR, Wide, eight, is_below, numbers};
use crate::constraints::{Constraint, ConstraintKind};
use crate::lanes::{LANES, Lanes, Vector};

/// The numbers of eight [`Cone`]s of four or five particles.
#[derive(Clone, Debug)]
pub(crate) struct Cones {
    axis: [[f32; LANES]; 3],
    max: [f32; LANES],
    /// A cosine that is safely above that of `max`.
    clear: [f32; LANES],
    /// 1 where the segment begins at the frame's own `o`: four particles, which stand in the form of five, `o` twice.
    own: [f32; LANES],
}

impl Wide<5> for Cones {
    const IS_LIMIT: bool = true;

    fn of(constraints: [&Constraint; LANES]) -> Option<Self> {
        let cones: [&Cone; LANES] = eight(constraints, |c| match &c.kind {
            ConstraintKind::Cone(equation) => Some(equation),
            _ => None,
        })?;
        Some(Self {
            axis: [0, 1, 2].map(|i| numbers(cones, |cone| cone.axis[i])),
            max: numbers(cones, |cone| cone.max),
            clear: numbers(cones, |cone| libm::cosf(cone.max) + CLEAR),
            own: numbers(constraints, |c| f32::from(u8::from(c.rows.len() == 4))),
        })
    }

    fn rows(constraint: &Constraint) -> [u32; 5] {
        match *constraint.rows.as_slice() {
            [o, x, y, d] => [o, x, y, o, d],
            _ => core::array::from_fn(|i| constraint.rows[i]),
        }
    }

    #[inline(always)]
    fn is_kept<L: Lanes>(&self, points: &[Vector<L>; 5]) -> L {
        let [o, x, y, c, d] = *points;
        let (axis, out) = (self.axis(x - o, y - o), d - c);
        let square = axis.length_squared() * out.length_squared();
        is_below(axis.dot(out), square, L::load(&self.clear))
    }

    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 5]) -> (L, [Vector<L>; 5]) {
        let [o, x, y, c, d] = *points;
        let (u, v) = (x - o, y - o);
        let [along_u, along_v, up] = &self.axis;
        let (along_u, along_v, up) = (L::load(along_u), L::load(along_v), L::load(up));
        let axis = self.axis(u, v);
        let Turns { angle, by_u: turn, by_v: by_d } = between_wide(axis, d - c);
        let max = L::load(&self.max);
        let value = max.lt(angle).and(angle - max);

        let by_x = turn * along_u + v.cross(turn) * up;
        let by_y = turn * along_v + turn.cross(u) * up;
        let by_o = -(by_x + by_y);
        let own = L::zero().lt(L::load(&self.own));
        let nothing = Vector::new(L::zero(), L::zero(), L::zero());
        let by_o = (by_o - by_d).or_else(own, by_o);
        (value, [by_o, by_x, by_y, nothing.or_else(own, -by_d), by_d])
    }
}

impl Cones {
    #[inline(always)]
    fn axis<L: Lanes>(&self, u: Vector<L>, v: Vector<L>) -> Vector<L> {
        let [along_u, along_v, up] = &self.axis;
        u * L::load(along_u) + v * L::load(along_v) + u.cross(v) * L::load(up)
    }
}
