//! Eight tetrahedra side by side.

use super::Tetrahedron;
use crate::constraints::area::steeper;
use crate::constraints::wide::{Wide, eight, is_size, numbers};
use crate::constraints::{Constraint, ConstraintKind};
use crate::lanes::{LANES, Lanes, Vector};

/// The numbers of eight [`Tetrahedron`]s.
#[derive(Clone, Debug)]
pub(crate) struct Tetrahedra {
    rest: [f32; LANES],
}

impl Wide<4> for Tetrahedra {
    fn of(constraints: [&Constraint; LANES]) -> Option<Self> {
        let all: [&Tetrahedron; LANES] = eight(constraints, |c| match &c.kind {
            ConstraintKind::Tetrahedron(equation) => Some(equation),
            _ => None,
        })?;
        Some(Self { rest: numbers(all, |tetrahedron| tetrahedron.rest) })
    }

    /// See `volume`. The reach of a step is a third root; whether a gradient has to be steeper is asked without it, by the third power of the step,
    /// and lanes that have collapsed are sent through the scalar formula.
    #[inline(always)]
    fn evaluate<L: Lanes>(&self, points: &[Vector<L>; 4]) -> (L, [Vector<L>; 4]) {
        let [a, b, c, d] = *points;
        let (u, v, w) = (b - a, c - a, d - a);
        let sixth = L::splat(1.0 / 6.0);
        let (by_b, by_c, by_d) = (v.cross(w) * sixth, w.cross(u) * sixth, u.cross(v) * sixth);
        let mut gradients = [-(by_b + by_c + by_d), by_b, by_c, by_d];
        let (now, rest) = (by_d.dot(w), L::load(&self.rest));
        let value = now - rest;
        let size = now.abs().max(rest.abs());
        let mut square = L::zero();
        for gradient in &gradients {
            square = square + gradient.length_squared();
        }
        // The root of the mean square of a step, times two: four particles.
        let step = value.abs() / (square * L::splat(4.0)).sqrt();
        let far = is_size(step).and(size.lt(step * step * step));
        if far.any() {
            let factor = L::load(&steepened(step.array(), size.array()));
            steeper(far.select(factor, L::splat(1.0)), &mut gradients);
        }
        (value, gradients)
    }
}

/// By how much gradients have to be steeper, so that steps of `step` metres become as long as what has the volume `size`, m³: at least 1.
#[cold]
fn steepened(step: [f32; LANES], size: [f32; LANES]) -> [f32; LANES] {
    core::array::from_fn(|lane| {
        let factor = step[lane] / libm::cbrtf(size[lane]);
        if factor > 1.0 && factor.is_finite() { factor } else { 1.0 }
    })
}
