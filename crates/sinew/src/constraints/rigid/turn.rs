//! The rotation of a rigid shape that keeps its angular momentum: the discrete rigid body of Moser and Veselov, as a constraint.
//!
//! Verlet moves particles from `p` to `q`. The mean velocity is `(q - p)/h` and the angular momentum of the step `Σ m p × q / h`, the same as that of the step
//! before: without forces `p = 2p' - p''`, so `p × (2p - p'') = p'' × p`. A constraint must not change it. With all positions relative to the barycentres, let
//! the particles end at `x = R r`, a rotation of the rest shape. Required is the `R` with
//!
//! ```text
//! Σ m p × R r = Σ m p × q = L
//! ```
//!
//! three equations for three unknowns. (They are the rods' equations of SHAKE solved for all pairs at once: a force between two particles along their line at
//! the start has no moment about their positions at the start.) As a map from one step to the next this is symplectic and reversible, so the energy oscillates
//! within a band of order h² and does not drift (Moser, Veselov, *Discrete versions of some classical integrable systems*, 1991; Hairer, Lubich, Wanner,
//! *Geometric Numerical Integration*, VII.5).
//!
//! # Newton's step
//!
//! A further small rotation θ takes `x` to `x + θ × x`, and `p × (θ × x) = θ (p·x) - x (p·θ)`, so with `B = Σ m x pᵀ`
//!
//! ```text
//! A θ = L - Σ m p × x        A = tr(B) 1 - B
//! ```
//!
//! `B = R (Σ m p rᵀ)ᵀ`, and `Σ m p × x` is its antisymmetric part, so the cost of a step does not depend on the number of particles. Without rotation `A` is
//! the inertia tensor. After a rotation by φ about one axis it has lost the factor cos φ there: `L` goes as a sine, and beyond a quarter turn there is no
//! solution.

use glam::{DMat3, DQuat, DVec3};

/// Maximum number of Newton steps. They start at the nearest rotation, which is off by about φ³/2, and converge quadratically: two or three steps up to 0.3
/// rad. What takes more than six does not converge.
const STEPS: u32 = 6;
/// Newton stops at a step of this size, rad: the remaining error is of the order of its square.
const DONE: f64 = 1e-7;
/// Regularisation: the share of the trace that is added to the diagonal. Collinear particles do not resist rotation about their line; this term makes the
/// system solvable, and slows the convergence in that direction by a factor that is noticeable only if the shape is thinner than 1 in 1e5.
const RIDGE: f64 = 1e-10;
/// Greatest accepted angle from the nearest rotation, rad. In free flight, a rotation whose sine is s appears to the nearest rotation as an arc tangent, and
/// asin s - atan s is this much at 1 rad. A greater difference comes from deformation.
const FARTHEST: f64 = 0.3;

/// The rotation that gives the shape with `moments`, `Σ m p rᵀ`, the angular momentum `momentum`, `Σ m p × q`; iterated from `nearest`. `None` if there is none
/// near it.
pub(super) fn conserving(momentum: DVec3, moments: DMat3, nearest: DQuat) -> Option<DQuat> {
    let from_rest = moments.transpose();
    let mut q = nearest;
    for _ in 0..STEPS {
        let b = DMat3::from_quat(q) * from_rest;
        let trace = b.x_axis.x + b.y_axis.y + b.z_axis.z;
        let now =
            DVec3::new(b.y_axis.z - b.z_axis.y, b.z_axis.x - b.x_axis.z, b.x_axis.y - b.y_axis.x);
        let a = DMat3::from_diagonal(DVec3::splat(trace * (1.0 + RIDGE))) - b;
        let theta = solve(a, momentum - now)?;
        let square = theta.length_squared();
        // Written so that a NaN gives `None`.
        if !(trace > 0.0 && square < FARTHEST * FARTHEST) {
            return None;
        }
        let half = theta * 0.5;
        q = (DQuat::from_xyzw(half.x, half.y, half.z, 1.0) * q).normalize();
        if square < DONE * DONE {
            // For unit quaternions apart by φ, the dot product is cos φ/2.
            let near = 1.0 - q.dot(nearest).abs() <= FARTHEST * FARTHEST / 8.0;
            return near.then_some(q);
        }
    }
    None
}

/// `A⁻¹ b` by Cramer's rule; `None` unless the determinant is positive.
fn solve(a: DMat3, b: DVec3) -> Option<DVec3> {
    let across = a.y_axis.cross(a.z_axis);
    let determinant = a.x_axis.dot(across);
    let solved =
        DVec3::new(b.dot(across), a.x_axis.dot(b.cross(a.z_axis)), a.x_axis.dot(a.y_axis.cross(b)));
    (determinant > 0.0).then(|| solved * (1.0 / determinant))
}
