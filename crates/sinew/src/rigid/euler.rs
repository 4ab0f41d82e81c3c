//! Euler's method for rotation, as in the lectures.
//!
//! From `L̇ = τ` and `L = J ω` with `J = R I Rᵀ`, whose rate of change is `J̇ = [ω] J - J [ω]`, Euler's equation follows in the axes of the world; and a
//! rotation by `ω h` is, to first order, the quaternion `1 + ½ h ω`:
//!
//! ```text
//! ω ← ω + h J⁻¹ (τ - ω × J ω)        q ← q + ½ h ω q, made unit
//! ```
//!
//! The gyroscopic term `ω × J ω` is what makes a thrown book flip. Taken from the old `ω` it is accurate only to first order, so `L` changes by terms in `h²
//! ω²` even without a torque; and the turn is by `2 atan(½ h ω)` instead of `h ω`.

use glam::{DQuat, DVec3};

use super::principal::{Principal, Spin};

/// The spin after `h` seconds under a torque (N·m, world).
pub(super) fn turn(spin: Spin, principal: &Principal, torque: DVec3, h: f64) -> Spin {
    let old = spin.rate(principal);
    let driving = torque - old.cross(spin.momentum);
    let change = principal.rate(spin.rotation.conjugate() * driving);
    let new = old + spin.rotation * change * h;
    let half = new * (0.5 * h);
    let step = DQuat::from_xyzw(half.x, half.y, half.z, 0.0) * spin.rotation;
    let rotation = (spin.rotation + step).normalize();
    Spin { rotation, momentum: rotation * principal.momentum(rotation.conjugate() * new) }
}
