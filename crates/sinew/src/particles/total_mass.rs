//! Total mass of several rows: what a force or impulse on all of them together does to each (physics.md F2, I7).
//!
//! # How a push is distributed
//!
//! A force `F` at the barycentre accelerates every particle equally, by `F/M`. A torque `τ` turns them as it would begin to turn a rigid body:
//!
//! ```text
//! f_i = m_i α × r_i        r_i = p_i - p̄        α = I⁻¹ τ        I = Σ m (r² 1 - r rᵀ)
//! ```
//!
//! There is no net force, `Σ f = α × Σ m r = 0`, and exactly the torque, `Σ r × f = Σ m r × (α × r) = I α = τ`. Of all forces with that torque these change the
//! energy of a body at rest least, so no other motion is excited. A force at the point `x` is the force at the barycentre and the torque `(x - p̄) × F`. On a
//! line `I` has no inverse, and the pseudo-inverse leaves out the component about the line, which would only turn particles about themselves. The same holds
//! with impulses for forces and velocities for accelerations.

use glam::{DVec3, Vec3};

use super::Particles;
use crate::pose::{PointMasses, pseudo_solve};

/// Mass, barycentre and inertia of rows that are not pinned, in `f64` and relative to one of them, so that no precision is lost far from the origin.
pub(crate) struct TotalMass {
    /// The row that positions are relative to.
    anchor: usize,
    all: PointMasses,
}

impl TotalMass {
    /// Sums the rows that exist and are not pinned, by their masses. `None` if there are none, or if one is not finite.
    pub(crate) fn of(particles: &Particles, rows: &[u32]) -> Option<Self> {
        Self::weighing(particles, rows, |i| mass(particles, i))
    }

    /// The same with weights of the caller's; rows of zero weight do not count.
    pub(super) fn weighing(
        particles: &Particles,
        rows: &[u32],
        weight: impl Fn(usize) -> f64,
    ) -> Option<Self> {
        let counted = || {
            let there = rows.iter().map(|&row| row as usize).filter(|&i| i < particles.len());
            there.map(|i| (i, weight(i))).filter(|&(_, m)| m > 0.0)
        };
        let (anchor, _) = counted().next()?;
        let all = PointMasses::of(counted().map(|(i, m)| (relative(particles, i, anchor), m)));
        let finite = all.mass.is_finite() && all.inertia.iter().flatten().all(|x| x.is_finite());
        finite.then_some(Self { anchor, all })
    }

    /// Vector from the barycentre to row `i`, metres.
    pub(crate) fn arm(&self, particles: &Particles, i: usize) -> DVec3 {
        relative(particles, i, self.anchor) - self.all.barycentre
    }

    /// Vector from the barycentre to a point of the world, metres.
    pub(crate) fn arm_of(&self, particles: &Particles, point: Vec3) -> DVec3 {
        let anchor = local(particles, self.anchor)
            + (particles.origin[self.anchor].as_dvec3() - point.as_dvec3());
        -(anchor + self.all.barycentre)
    }

    /// Response to a force (N) at the barycentre and a torque (N·m): acceleration of the barycentre (m/s²) and angular acceleration (rad/s²). Or to an impulse
    /// and an angular impulse: the changes of velocity and angular velocity.
    pub(crate) fn response(&self, force: DVec3, torque: DVec3) -> PushShares {
        let turn =
            if torque == DVec3::ZERO { torque } else { pseudo_solve(self.all.inertia, torque) };
        PushShares { shift: force / self.all.mass, turn }
    }
}

/// Change of velocity, or acceleration, of each row by a push on all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PushShares {
    shift: DVec3,
    turn: DVec3,
}

impl PushShares {
    /// The share of a row at `arm` from the barycentre.
    pub(crate) fn at(&self, arm: DVec3) -> Vec3 {
        (self.shift + self.turn.cross(arm)).as_vec3()
    }
}

/// Mass of a row, kg; zero if it is pinned.
fn mass(particles: &Particles, i: usize) -> f64 {
    match particles.position[i].w {
        w if w > 0.0 => 1.0 / f64::from(w),
        _ => 0.0,
    }
}

/// `p_i - p_anchor`, metres, exact wherever both are.
fn relative(particles: &Particles, i: usize, anchor: usize) -> DVec3 {
    local(particles, i) - local(particles, anchor)
        + (particles.origin[i].as_dvec3() - particles.origin[anchor].as_dvec3())
}

/// Position of row `i` relative to its origin, metres.
fn local(particles: &Particles, i: usize) -> DVec3 {
    particles.position[i].truncate().as_dvec3()
}
