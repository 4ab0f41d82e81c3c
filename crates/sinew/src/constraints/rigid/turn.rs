//! The turn of a rigid shape that keeps its angular momentum: the discrete rigid body of Moser and Veselov, in the shape of a constraint.
//!
//! Verlet carries particles from `p` to `q`; the mean velocity is `(q - p)/h`, and the angular momentum of the step `Σ m p × q / h`, the same as
//! that of the step before: `p = 2p' - p''` without forces, so `p × (2p - p'') = p'' × p`. A constraint must not change it. All about the
//! barycentres, let the particles end at `x = R r`, a rotation of the rest shape. Wanted is the `R` with
//!
//! ```text
//! Σ m p × R r = Σ m p × q = L
//! ```
//!
//! three equations for three unknowns. (They are the rods' equations along the start of the step, SHAKE, solved for all pairs at once: a force
//! between two particles along the line on which they were has no moment about where they were.) As a map from one step to the next this is
//! symplectic and reversible, so the energy swings within a band of order h² and does not drift (Moser, Veselov, *Discrete versions of some
//! classical integrable systems*, 1991; Hairer, Lubich, Wanner, *Geometric Numerical Integration*, VII.5).
//!
//! # Newton's step
//!
//! A further small turn θ takes `x` to `x + θ × x`, and `p × (θ × x) = θ (p·x) - x (p·θ)`, so with `B = Σ m x pᵀ`
//!
//! ```text
//! A θ = L - Σ m p × x        A = tr(B) 1 - B
//! ```
//!
//! `B = R (Σ m p rᵀ)ᵀ`, and `Σ m p × x` is its antisymmetric part: nothing in a step depends on the number of particles. At rest `A` is the inertia
//! tensor. After a turn by φ about one axis it has lost the factor cos φ there: `L` is to be met by a sine, and nothing does beyond a quarter turn.

use glam::{DMat3, DQuat, DVec3};

/// Quadratic from the nearest rotation, which is off by about φ³/2: two or three steps up to 0.3 rad. Beyond six it does not converge.
const STEPS: u32 = 6;
/// Newton is done with a step of this size, rad: what it leaves is of the order of its square.
const DONE: f64 = 1e-7;
/// A share of the inertia that is added all around. On a line nothing keeps the shape from turning about that: this does, and slows the convergence
/// in that direction by a factor that is seen only if the shape is thinner than 1 in 1e5.
const RIDGE: f64 = 1e-10;
/// The farthest from the nearest rotation, rad. Free flight by the sine s of a turn is seen by the nearest one as an arc tangent: asin s - atan s
/// is this much at a turn of 1 rad. What is farther off was bent there by something else than a turn.
const FARTHEST: f64 = 0.3;

/// The rotation that gives the angular momentum `momentum`, `Σ m p × q`, to the shape with `moments`, `Σ m p rᵀ`; sought from `nearest`. `None` if
/// there is none near that.
pub(super) fn keeping(momentum: DVec3, moments: DMat3, nearest: DQuat) -> Option<DQuat> {
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
        // Written so that a NaN declines.
        if !(trace > 0.0 && square < FARTHEST * FARTHEST) {
            return None;
        }
        let half = theta * 0.5;
        q = (DQuat::from_xyzw(half.x, half.y, half.z, 1.0) * q).normalize();
        if square < DONE * DONE {
            // Of unit quaternions apart by φ, the dot product is cos φ/2.
            let near = 1.0 - q.dot(nearest).abs() <= FARTHEST * FARTHEST / 8.0;
            return near.then_some(q);
        }
    }
    None
}

/// `A⁻¹ b` by Cramer's rule, if `A` turns nothing inside out.
fn solve(a: DMat3, b: DVec3) -> Option<DVec3> {
    let across = a.y_axis.cross(a.z_axis);
    let determinant = a.x_axis.dot(across);
    let solved =
        DVec3::new(b.dot(across), a.x_axis.dot(b.cross(a.z_axis)), a.x_axis.dot(a.y_axis.cross(b)));
    (determinant > 0.0).then(|| solved * (1.0 / determinant))
}
