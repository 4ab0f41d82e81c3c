//! Several rows as one thing: what a push on all of them together does to each (physics.md F2, I7). Forces and impulses share it.
//!
//! # How a push is spread
//!
//! A force `F` at the barycentre accelerates every particle alike, by `F/M`. A torque `τ` turns them as a rigid body would start to:
//!
//! ```text
//! f_i = m_i α × r_i        r_i = p_i - p̄        α = I⁻¹ τ        I = Σ m (r² 1 - r rᵀ)
//! ```
//!
//! No net force comes of it, `Σ f = α × Σ m r = 0`, and exactly the torque, `Σ r × f = Σ m r × (α × r) = I α = τ`. Of all forces with that
//! torque these are the ones that change the energy of a body at rest least, so nothing else is excited. A force at the point `x` is the
//! force at the barycentre and the torque `(x - p̄) × F`. On a line `I` has no inverse and the pseudo-inverse leaves out what would turn particles
//! about themselves. The same holds with impulses for forces and velocities for accelerations.

use glam::{DVec3, Vec3};

use super::Particles;
use crate::pose::pseudo_solve;

/// Mass, barycentre and inertia of rows that can move, in `f64` and relative to one of them, so that no distance from the origin costs digits.
pub(crate) struct TotalMass {
    /// The row that `centre` is relative to.
    anchor: usize,
    /// Total mass, kg.
    mass: f64,
    /// The barycentre, metres from the anchor.
    centre: DVec3,
    /// About the barycentre, kg·m².
    inertia: [[f64; 3]; 3],
}

impl TotalMass {
    /// The rows that are there and not pinned, by their mass. `None` if there are none, or if they are not all finite.
    pub(crate) fn of(particles: &Particles, rows: &[u32]) -> Option<Self> {
        Self::weighing(particles, rows, |i| mass(particles, i))
    }

    /// The same by weights of the caller's; rows that weigh nothing do not count.
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
        let (mut mass, mut first) = (0.0, DVec3::ZERO);
        for (i, m) in counted() {
            mass += m;
            first += aside(particles, i, anchor) * m;
        }
        let centre = first / mass;
        let mut inertia = [[0.0; 3]; 3];
        for (i, m) in counted() {
            let r = aside(particles, i, anchor) - centre;
            let (rr, components) = (r.length_squared(), r.to_array());
            for (row, a) in inertia.iter_mut().zip(components) {
                for (entry, b) in row.iter_mut().zip(components) {
                    *entry -= m * a * b;
                }
            }
            (0..3).for_each(|axis| inertia[axis][axis] += m * rr);
        }
        let finite = mass.is_finite() && inertia.iter().flatten().all(|x| x.is_finite());
        finite.then_some(Self { anchor, mass, centre, inertia })
    }

    /// Row `i` from the barycentre, metres.
    pub(crate) fn arm(&self, particles: &Particles, i: usize) -> DVec3 {
        aside(particles, i, self.anchor) - self.centre
    }

    /// A point of the world from the barycentre, metres.
    pub(crate) fn arm_of(&self, particles: &Particles, point: Vec3) -> DVec3 {
        let anchor = local(particles, self.anchor)
            + (particles.origin[self.anchor].as_dvec3() - point.as_dvec3());
        -(anchor + self.centre)
    }

    /// How the rows answer to a force (N) at the barycentre and a torque (N·m): with the acceleration of the barycentre (m/s²) and an angular one
    /// (rad/s²). Or to an impulse and an angular impulse, with a velocity and an angular velocity.
    pub(crate) fn answer(&self, force: DVec3, torque: DVec3) -> PushShares {
        let turn = if torque == DVec3::ZERO { torque } else { pseudo_solve(self.inertia, torque) };
        PushShares { shift: force / self.mass, turn }
    }
}

/// What each row has of a push on all.
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

/// Mass of a row that can move, kg; zero for one that is pinned.
fn mass(particles: &Particles, i: usize) -> f64 {
    match particles.position[i].w {
        w if w > 0.0 => 1.0 / f64::from(w),
        _ => 0.0,
    }
}

/// `p_i - p_anchor`, metres, to the last bit wherever both are.
fn aside(particles: &Particles, i: usize, anchor: usize) -> DVec3 {
    local(particles, i) - local(particles, anchor)
        + (particles.origin[i].as_dvec3() - particles.origin[anchor].as_dvec3())
}

/// Where row `i` is, metres from its origin.
fn local(particles: &Particles, i: usize) -> DVec3 {
    particles.position[i].truncate().as_dvec3()
}
