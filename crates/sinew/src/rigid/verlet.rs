//! Verlet for rotation: the discrete equations of Moser and Veselov.
//!
//! Verlet's formula follows from Newton's law if the path is a chain of straight steps and the *sum* of `½ m |p' - p|²/h` along it is stationary. The same
//! works for rotations. In a step from `R` to `R' = R F` each mass moves in a straight line, which sums to `-tr(F J)/h` with `J = Σ m r rᵀ`. The conjugate
//! momentum (the derivative by a turn of `R`, in the body's frame) is `h [m] = F J - J Fᵀ`. Write `F` as the unit quaternion `(q, q₀)`, `F = 1 + 2 q₀ [q] + 2
//! [q]²`. Then, with `[q] J + J [q] = [I q]` for the inertia `I = tr(J) 1 - J`, and `[q]² J - J [q]² = q (Jq)ᵀ - (Jq) qᵀ = [Jq × q] = [q × I q]`,
//!
//! ```text
//! ½ h m = q₀ I q + q × I q                                                                              (1)
//! ```
//!
//! Stationarity means that the momentum at the end of a step is the one at the start of the next: `m' = Fᵀ m`, so `L = R m` is constant, exactly. (From the
//! other end of the step, `½ h m' = q₀ I q - q × I q`: the same formula backwards in time.) The map is symplectic and of order 2. With half a kick of the
//! torque before and after it, it is Verlet's formula, started with the velocity at the instant of the position.
//!
//! # Solving (1)
//!
//! Given `m`, with `ξ = q/q₀`, so `q₀² = 1/(1 + ξ²)`, (1) becomes `I ξ + ξ × I ξ = (1 + ξ²) ½ h m`, solved by Newton's method from `ξ = ½ h I⁻¹ m`. For a
//! sphere `|ξ| = tan ½θ` and `sin θ = h m/I`: there is no solution beyond one radian a step. Therefore a step in which the body turns by more than half a
//! radian is divided; `|L|` of a free body is constant, so the number of parts is nearly constant too, and the division does no harm.
//!
//! Moser, Veselov, *Discrete versions of some classical integrable systems*, 1991; `McLachlan`, Zanna, *The discrete Moser–Veselov
//! algorithm for the free rigid body, revisited*, 2005.

use glam::{DMat3, DQuat, DVec3};

use super::leapfrog;
use super::principal::{Principal, Spin};
use crate::pose::outer;

/// Largest turn in one part of a step, rad: half of where (1) has no solution.
const MAX_TURN: f64 = 0.5;
/// Most parts of one step.
const MAX_PARTS: f64 = 64.0;
/// Newton doubles the number of digits each time: from 1 to 16 takes 4 or 5 iterations. The bound is for cases that do not converge.
const ITERATIONS: u32 = 12;

/// The spin after `h` seconds under a torque (N·m, world).
pub(super) fn turn(spin: Spin, principal: &Principal, torque: DVec3, h: f64) -> Spin {
    let kick = torque * (0.5 * h);
    let kicked = |spin: Spin| Spin { momentum: spin.momentum + kick, ..spin }.projected(principal);
    kicked(free(kicked(spin), principal, h))
}

fn free(spin: Spin, principal: &Principal, h: f64) -> Spin {
    let parts = (spin.rate(principal).length() * h.abs() / MAX_TURN).ceil().max(1.0);
    if parts > MAX_PARTS {
        return leapfrog::free(spin, principal, h);
    }
    let part = h / parts;
    let mut next = spin;
    for _ in 0..parts as u32 {
        let inside = principal.axes.transpose() * next.body_momentum();
        let Some(xi) = solve(principal.moments, inside * (0.5 * part)) else {
            return leapfrog::free(spin, principal, h);
        };
        let xi = principal.axes * xi;
        next = next.turned(DQuat::from_xyzw(xi.x, xi.y, xi.z, 1.0));
    }
    next
}

/// `ξ` with `I ξ + ξ × I ξ = (1 + ξ²) a`, in principal axes.
fn solve(moments: DVec3, a: DVec3) -> Option<DVec3> {
    let inertia = DMat3::from_diagonal(moments);
    let mut xi = a / moments;
    for _ in 0..ITERATIONS {
        let i_xi = moments * xi;
        let residual = i_xi + xi.cross(i_xi) - a * (1.0 + xi.length_squared());
        // Its derivative by ξ: I + [ξ] I - [I ξ] - 2 a ξᵀ.
        let slope = inertia + cross(xi) * inertia - cross(i_xi) - outer(a, xi) * 2.0;
        let determinant = slope.determinant();
        if determinant == 0.0 || !determinant.is_finite() {
            return None;
        }
        let change = slope.inverse() * residual;
        xi -= change;
        // A change of 1e-10 leaves an error of its square, below the precision of `f64`.
        if change.length_squared() <= 1e-20 * xi.length_squared() {
            return xi.is_finite().then_some(xi);
        }
    }
    None
}

/// `[v]`, with `[v] x = v × x`.
fn cross(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}
