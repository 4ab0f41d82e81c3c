//! A rigid set of particles, by shape matching (physics.md B2'): one constraint in place of a rod for every pair, exact in one projection.

mod turn;

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3, Vec3};

use super::correction::GradientAt;
use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::towards::{Weights, towards};
use crate::pose::{outer, rotation};

/// Keeps all particles at their places in a rigid shape, which may be moved and rotated in any way, but never mirrored.
///
/// With [`GradientAt::Current`] the particles move to the nearest such configuration, the least `Σ m‖d‖²`; rotation loses energy. With
/// [`GradientAt::StepStart`] they move to the configuration that keeps the angular momentum of the step, and spin and energy are kept as well as Verlet does.
/// Where there is no such configuration (the shape turned by about 1 rad or more in a substep, or was deformed that much), they move to the nearest.
///
/// Pinned particles do not move: the shape turns about a single one, and about the line through two. More than two are met as far as their positions fit the
/// shape. Any number of particles is allowed, also on a line, in a plane or in one place. The error reported to the solver is the mass-weighted root mean
/// square of the displacements.
#[derive(Clone, Debug, PartialEq)]
pub struct Rigid {
    /// Position of each particle in the shape's own frame, metres. Shared by bodies of the same shape.
    pub rest: Arc<[Vec3]>,
    /// How stiff the constraint is: [`Softness::frequency`] gives a shape that wobbles.
    pub softness: Softness,
}

impl Rigid {
    /// A hard constraint with the shape of these positions, metres, in the order of the constraint's rows.
    pub fn of(positions: impl Into<Arc<[Vec3]>>) -> Self {
        Self { rest: positions.into(), softness: Softness::Hard }
    }

    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
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

/// The shape rotated by `R` and moved to the barycentre `q̄` requires the displacement `dᵢ = R (rᵢ - r̄) + q̄ - qᵢ` of each particle. Whatever `R` is, that
/// keeps momentum, `Σ m d = 0`. The least displacement, `Σ m‖d‖²`, has the rotation nearest to `Σ m (q - q̄)(r - r̄)ᵀ` (derived in [`pose`](crate::pose)). It
/// keeps the angular momentum about the *current* positions, `Σ m (q - q̄) × d = 0`, which is not the one that Verlet keeps; `turn.rs` derives the other.
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

/// Centres and moments that match the particles to the rest shape.
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
        turn::conserving(momentum, moments, nearest).unwrap_or(nearest)
    }

    /// A rotation near the nearest one, so that two Newton steps find that: it maps two of the rest positions, far out and far from collinear, to the
    /// directions of their particles. It depends on the positions alone, so the result is deterministic also where several rotations are equally near.
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

/// A right-handed frame with its first axis along `a` and with `b` in the plane of the first two; `None` if they are collinear.
fn frame(a: DVec3, b: DVec3) -> Option<DMat3> {
    let (x, z) = (a.try_normalize()?, a.cross(b).try_normalize()?);
    Some(DMat3::from_cols(x, z.cross(x), z))
}

#[cfg(test)]
mod spin_tests;
#[cfg(test)]
mod tests;
