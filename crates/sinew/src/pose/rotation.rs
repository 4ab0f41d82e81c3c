//! The rotation nearest to a 3×3 matrix: it maximises `tr(Rᵀ M)` over all rotations.
//!
//! # One formula for everything
//!
//! Take any rotation `R`, for instance that of the last frame, and let `S = Rᵀ M`. Every other rotation is `R` followed, in its own frame, by a turn of `θ`
//! about some unit axis `n`: `R (1 + sinθ [n] + (1 - cosθ) [n]²)` (Rodrigues). With `[n]² = n nᵀ - 1` and
//!
//! ```text
//! g = (S₂₁ - S₁₂, S₀₂ - S₂₀, S₁₀ - S₀₁)        K = tr(S) 1 - ½ (S + Sᵀ)
//! ```
//!
//! its score, `tr(Rᵀ M)`, is exactly, for every angle,
//!
//! ```text
//! f(θ, n) = tr(S) + sinθ n·g - (1 - cosθ) nᵀK n                                                    (1)
//! ```
//!
//! - **Optimality of `R`.** If `g = 0` and `K ⪰ 0`, no term of (1) can gain: `R` is the global optimum. If `g` is only small and `K` positive definite, `f ≥
//!   tr(S)` requires `tan(θ/2) ≤ n·g / nᵀK n ≤ ‖g‖ / λ_min(K)`, which bounds the distance to the optimum.
//! - **Newton step.** To second order (1) is `tr(S) + θ n·g - ½ θ² nᵀK n`: Newton's step is `ω = K⁻¹ g`. Along its axis (1) is greatest at `tanθ = n·g / nᵀK n
//!   = ‖ω‖`: so the best turn about the Newton axis is by `atan ‖ω‖`, and a quaternion needs no trigonometry for that: `(ω, 1 + √(1 + ω²))`, normalised. It
//!   never decreases the score while `K` is positive definite, it is exact in one step if `M` has equal singular values (a cube) or the axis is principal, and
//!   otherwise it leaves an error of order `θ³ κ/4` with the condition number `κ` of `K`.
//! - **Without a start.** With `q = (n sin ½θ, cos ½θ)`, (1) is the quadratic form `f = qᵀ N q`,
//!
//!   ```text
//!   N = | tr(S)   gᵀ           |   in the order w, x, y, z
//!       | g       tr(S) 1 - 2K |
//!   ```
//!
//!   so the best `q` is the eigenvector of the greatest eigenvalue. Where that one is multiple (a line: 2, mirrored cube: 3, a point: 4), every unit vector of
//!   its eigenspace is equally good, and the one nearest to no turn, `w = 1`, is the projection of that onto the space. For a line that is the shortest arc,
//!   without twist, because no rotation that aligns the line can turn by less than the angle between its directions.
//!
//! Müller, Bender, Chentanez, Macklin, *A Robust Method to Extract the Rotational Part of Deformations*, 2016, is the warm
//! start, with `|tr S|` in the place of `K`. The quaternion's eigenproblem is Davenport's (1968) and Horn's, *Closed-form
//! Solution of Absolute Orientation Using Unit Quaternions*, 1987; here it is written in the frame of the last rotation.

use super::symmetric;
use glam::{DMat3, DQuat, DVec3};

/// After this many steps the eigenproblem is cheaper. Two are normal: one that moves, one that confirms convergence.
const STEPS: u32 = 8;
/// Newton has converged when the error that a step of this angle leaves, `θ³ κ/4`, is below `CONVERGED / κ`. The second `κ` is for optimality: it keeps `‖g‖ /
/// λ_min(K)` of (1) small as well.
const CONVERGED: f64 = 1e-8;
/// Eigenvalues within this of the greatest one, relative to `‖M‖`, count as equal to it.
const EQUAL_WITHIN: f64 = 2e-9;
/// Squared length below which a projection is only round-off.
const ROUND_OFF: f64 = 1e-24;

/// The rotation nearest to `m` (of any scale), and among equally near ones the nearest to `previous`, a unit quaternion.
pub(crate) fn nearest(m: DMat3, previous: DQuat) -> DQuat {
    let q = newton(m, previous).map_or_else(|| davenport(m, previous), |(q, _)| q);
    if q.dot(previous) < 0.0 { -q } else { q }
}

/// `tr(S)`, `g` and `K` at a rotation.
fn expand(m: DMat3, at: DQuat) -> (f64, DVec3, [[f64; 3]; 3]) {
    let s = DMat3::from_quat(at).transpose() * m;
    let (x, y, z) = (s.x_axis, s.y_axis, s.z_axis);
    let g = DVec3::new(y.z - z.y, z.x - x.z, x.y - y.x);
    let (xy, xz, yz) = (-0.5 * (x.y + y.x), -0.5 * (x.z + z.x), -0.5 * (y.z + z.y));
    let k = [[y.y + z.z, xy, xz], [xy, x.x + z.z, yz], [xz, yz, x.x + y.y]];
    (x.x + y.y + z.z, g, k)
}

/// The global optimum and the number of steps, if Newton's method converges from `start` and the optimality test holds.
pub(super) fn newton(m: DMat3, start: DQuat) -> Option<(DQuat, u32)> {
    let mut q = start;
    for step in 1..=STEPS {
        let (_, g, k) = expand(m, q);
        let (w, kappa) = symmetric::solve(&k, g)?;
        let square = w.length_squared();
        q = (q * DQuat::from_xyzw(w.x, w.y, w.z, 1.0 + (1.0 + square).sqrt())).normalize();
        let left = square * kappa;
        if left * left * left * kappa < CONVERGED * CONVERGED {
            return Some((q, step));
        }
    }
    None
}

/// The global optimum, and among equals the nearest to `previous`, for any `m`.
pub(super) fn davenport(m: DMat3, previous: DQuat) -> DQuat {
    let squares = m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared();
    if squares == 0.0 {
        return previous;
    }
    let (t, g, k) = expand(m * (1.0 / squares.sqrt()), previous);
    let n = [
        [t, g.x, g.y, g.z],
        [g.x, t - 2.0 * k[0][0], -2.0 * k[0][1], -2.0 * k[0][2]],
        [g.y, -2.0 * k[0][1], t - 2.0 * k[1][1], -2.0 * k[1][2]],
        [g.z, -2.0 * k[0][2], -2.0 * k[1][2], t - 2.0 * k[2][2]],
    ];
    let (values, vectors) = symmetric::eigen(n);
    let top = values.iter().fold(values[0], |top, &value| top.max(value));
    // Projects the unit vector of an axis onto the eigenspace of `top`; the squared length of the projection is its own component.
    let project = |axis: usize| {
        let mut sum = [0.0; 4];
        for (value, v) in values.iter().zip(&vectors) {
            if top - value <= EQUAL_WITHIN {
                for (to, from) in sum.iter_mut().zip(v) {
                    *to += v[axis] * from;
                }
            }
        }
        (sum, sum[axis])
    };
    let mut best = project(0);
    if best.1 < ROUND_OFF {
        // The whole eigenspace is a half turn away: take the axis with the longest projection.
        for axis in 1..4 {
            let other = project(axis);
            if other.1 > best.1 {
                best = other;
            }
        }
    }
    let [w, x, y, z] = best.0;
    (previous * DQuat::from_xyzw(x, y, z, w)).normalize()
}
