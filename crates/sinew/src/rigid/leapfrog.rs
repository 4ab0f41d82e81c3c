//! Leapfrog for rotation: half a kick, a turn, half a kick.
//!
//! The kick is `L += ½ h τ`. The turn is that of a free body, which has a closed form only in elliptic functions; but its energy is a sum of parts whose
//! motions have one in sines. With the angular momentum in the body's frame, `m = Rᵀ L`, and principal moments `I`,
//!
//! ```text
//! H = ½ Σ mₐ²/Iₐ = ½ m²/Iⱼ  +  ½ mₖ² (1/Iₖ - 1/Iⱼ)  +  ½ mᵢ² (1/Iᵢ - 1/Iⱼ)
//!                  sphere      spin about axis k         what is left, about axis i
//! ```
//!
//! An energy `½ c mₐ²` turns the body about its axis `a` at the constant rate `c mₐ`; `½ c m²` turns it about `m` at the rate `c m`: `R ← R exp(h c mₐ eₐ)` and
//! `R ← R exp(h c m)`, with `L` unchanged. The first two parts together are a symmetric top; they commute, so that applying one after the other is its exact
//! motion. The third is a perturbation, applied half before and half after (Strang splitting), which makes the whole symmetric in time, symplectic and of order
//! 2. `i` and `j` are the axes with the nearest `1/I`, so that the perturbation is as small as possible, and zero for a symmetric top.
//!
//! Splitting of the free body: `McLachlan` 1993; Dullweber, Leimkuhler, `McLachlan`, *Symplectic splitting methods for rigid body molecular dynamics*, 1997,
//! who find the splitting around a symmetric top several times as accurate as that into three axes.

use glam::DVec3;

use super::principal::{Principal, Spin, by_vector};

/// The spin after `h` seconds under a torque (N·m, world).
pub(super) fn turn(spin: Spin, principal: &Principal, torque: DVec3, h: f64) -> Spin {
    let kick = torque * (0.5 * h);
    let kicked = |spin: Spin| Spin { momentum: spin.momentum + kick, ..spin }.projected(principal);
    kicked(free(kicked(spin), principal, h))
}

/// The spin of a free body after `h` seconds.
pub(super) fn free(spin: Spin, principal: &Principal, h: f64) -> Spin {
    let inverse = principal.moments.recip();
    let [i, j, k] = roles(inverse);
    let about = |spin: Spin, axis: usize, h: f64| {
        let e = principal.axes.col(axis);
        let rate = spin.body_momentum().dot(e) * (inverse[axis] - inverse[j]);
        spin.turned(by_vector(e * (rate * h)))
    };
    let spin = about(spin, i, 0.5 * h);
    let spin = spin.turned(by_vector(spin.body_momentum() * (inverse[j] * h)));
    about(about(spin, k, h), i, 0.5 * h)
}

/// Axes `i`, `j`, `k`: `i` and `j` are the two whose inverse moments are nearest.
fn roles(inverse: DVec3) -> [usize; 3] {
    let apart = |[i, j, _]: [usize; 3]| (inverse[i] - inverse[j]).abs();
    let mut best = [0, 1, 2];
    for other in [[1, 2, 0], [2, 0, 1]] {
        if apart(other) < apart(best) {
            best = other;
        }
    }
    best
}
