//! A rigid set of particles, by shape matching (physics.md B2'): one constraint in the place of a rod for every pair, exact in one projection.

mod turn;

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3, Vec3};

use super::correction::GradientAt;
use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::towards::{Weights, towards};
use crate::pose::rotation;

/// All particles keep the places that they have in a rigid shape, which may be anywhere and turned in any way, but never mirrored.
///
/// Along [`GradientAt::Current`] they go to the nearest such places, the least `Σ m‖d‖²`. That bleeds spin. Along [`GradientAt::StepStart`] they go
/// where they keep the angular momentum that they come with, and the spin and the energy are kept as Verlet does; where that is not to be had (the
/// shape turned by about 1 rad or more in a substep, or something else bent it that much) they go to the nearest.
///
/// Particles that are pinned do not move; the shape turns about a single one, and about the line through two. More of them decide as far as they are
/// where the shape has them. Any number of particles will do, on a line, in a plane or in one place as well. The error that the solver sees is the
/// root mean square of the displacements, weighted by mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Rigid {
    /// Where each of the particles sits in the shape's own frame, metres. Shared by bodies of the same shape.
    pub rest: Arc<[Vec3]>,
    /// How hard it is: [`Softness::frequency`] gives a shape that wobbles.
    pub softness: Softness,
}

impl Rigid {
    /// A hard one of the shape that these positions have, metres; in the order of the constraint's rows.
    pub fn of(positions: impl Into<Arc<[Vec3]>>) -> Self {
        Self { rest: positions.into(), softness: Softness::Hard }
    }

    /// Why it cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        if particles == 0 || self.rest.len() != particles {
            Some(ConstraintFault::Count)
        } else if self.rest.iter().any(|r| !r.is_finite()) {
            Some(ConstraintFault::Number)
        } else {
            None
        }
    }
}

/// A shape turned by `R` and moved to the barycentre `q̄` asks of each particle `dᵢ = R (rᵢ - r̄) + q̄ - qᵢ`. Whatever `R` is, that keeps momentum,
/// `Σ m d = 0`. The nearest way, least `Σ m‖d‖²`, is the rotation nearest to `Σ m (q - q̄)(r - r̄)ᵀ` (derived in [`pose`](crate::pose)); it keeps the
/// angular momentum about where the particles are *now*, `Σ m (q - q̄) × d = 0`, which is not the one that Verlet keeps: `turn.rs` has the other.
impl Equation for Rigid {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let Some(weights) = Weights::of(points) else { return 0.0 };
        let fit = Fit::of(points, &self.rest, weights);
        let q = fit.rotation(points, &self.rest, weights);
        let turned = DMat3::from_quat(q);
        let moved = fit.now - turned * fit.rest;
        towards(points, gradients, |i| {
            (turned * self.rest[i].as_dvec3() + moved - points.at(i).as_dvec3()).as_vec3()
        })
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_internal(&self) -> bool {
        true
    }

    fn is_length(&self) -> bool {
        true
    }
}

/// How the particles go with the rest shape.
struct Fit {
    /// Centre of the particles, metres from the origin.
    now: DVec3,
    /// Centre of the rest shape, metres.
    rest: DVec3,
    /// `Σ m (q - q̄)(r - r̄)ᵀ`, kg·m².
    moments: DMat3,
}

impl Fit {
    fn of(points: &Points, rest: &[Vec3], weights: Weights) -> Self {
        let now = weights.centre(points);
        let mut middle = DVec3::ZERO;
        for (i, r) in rest.iter().enumerate() {
            middle += r.as_dvec3() * weights.in_centre(points, i);
        }
        let mut moments = DMat3::ZERO;
        for (i, r) in rest.iter().enumerate() {
            let q = (points.at(i).as_dvec3() - now) * weights.at(points, i);
            moments += outer(q, r.as_dvec3() - middle);
        }
        Self { now, rest: middle, moments }
    }

    fn rotation(&self, points: &Points, rest: &[Vec3], weights: Weights) -> DQuat {
        let nearest = rotation::nearest(self.moments, self.initial_rotation(points, rest));
        if points.gradient_at() == GradientAt::Current {
            return nearest;
        }
        let mut start = DVec3::ZERO;
        for i in 0..points.len() {
            start += points.start(i).as_dvec3() * weights.in_centre(points, i);
        }
        let (mut moments, mut momentum) = (DMat3::ZERO, DVec3::ZERO);
        for (i, r) in rest.iter().enumerate() {
            let p = (points.start(i).as_dvec3() - start) * weights.at(points, i);
            moments += outer(p, r.as_dvec3() - self.rest);
            momentum += p.cross(points.at(i).as_dvec3() - self.now);
        }
        turn::keeping(momentum, moments, nearest).unwrap_or(nearest)
    }

    /// A rotation near the nearest one, so that two steps find that: the one that carries two of the rest positions, far out and far from being in
    /// line, to where their particles are. It depends on the positions alone; so does what is done where many rotations are as good.
    fn initial_rotation(&self, points: &Points, rest: &[Vec3]) -> DQuat {
        let (mut far, mut reach) = (0, 0.0);
        for (i, r) in rest.iter().enumerate() {
            let square = (r.as_dvec3() - self.rest).length_squared();
            if square > reach {
                (far, reach) = (i, square);
            }
        }
        let along = rest[far].as_dvec3() - self.rest;
        let (mut side, mut area) = (0, 0.0);
        for (i, r) in rest.iter().enumerate() {
            let square = along.cross(r.as_dvec3() - self.rest).length_squared();
            if square > area {
                (side, area) = (i, square);
            }
        }
        let here = |i: usize| points.at(i).as_dvec3() - self.now;
        let frames =
            (frame(along, rest[side].as_dvec3() - self.rest), frame(here(far), here(side)));
        let (Some(from), Some(to)) = frames else { return DQuat::IDENTITY };
        DQuat::from_mat3(&(to * from.transpose()))
    }
}

/// A right-handed frame with its first axis along `a` and `b` in the plane of the first two; `None` if they are in line.
fn frame(a: DVec3, b: DVec3) -> Option<DMat3> {
    let (x, z) = (a.try_normalize()?, a.cross(b).try_normalize()?);
    Some(DMat3::from_cols(x, z.cross(x), z))
}

/// `a bᵀ`.
#[inline]
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
mod spin_tests;
#[cfg(test)]
mod tests;
