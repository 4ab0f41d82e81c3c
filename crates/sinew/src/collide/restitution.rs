//! The law of restitution, which all contacts apply after velocities are derived from positions. Written once, for one lane or eight.
//!
//! The position solve has no restitution: whatever is moved onto a surface leaves it with the speed of that correction. So contacts correct velocities at the
//! end of a substep of `h` seconds. With `u` the relative normal velocity before the contact acted (negative when approaching), `u'` the present one and `e` the
//! coefficient of restitution, the new one is
//!
//! ```text
//! -e u                     where u < -2gh and e > 0   (elastic)
//! clamp(u', 0, max(u, 0))  elsewhere                  (inelastic)
//! ```
//!
//! The [`threshold`] `2gh` is twice the speed that gravity adds in a substep: below it a contact is taken for a resting one, which would otherwise bounce for
//! ever. The inelastic case is for contacts between two moving sides: they neither approach any more nor separate faster than before, because the correction
//! of an overlap must not add velocity. Those between particles and triangles have one impulse of restitution and friction: [`contact_impulse`].
//!
//! Particles on colliders, particle pairs, triangles and body colliders all use these functions. What is particular to one of them (several points of a
//! manifold, effective masses) is in its own file.

use super::friction::friction_share;
use crate::lanes::{Number, Vector};

/// The approach speed up to which contacts are inelastic, m/s: `2gh`, for gravity in m/s² and a substep of `h` seconds.
#[inline(always)]
pub(super) fn threshold(gravity: f32, h: f32) -> f32 {
    2.0 * gravity * h
}

/// Mask of the contacts that are elastic at an approach `speed`, m/s.
#[inline(always)]
pub(super) fn is_elastic<N: Number>(coefficient: N, speed: N, threshold: f32) -> N {
    N::zero().lt(coefficient).and(N::splat(threshold).lt(speed))
}

/// The relative normal velocity after an elastic contact, m/s, from the one `before` it (negative when approaching).
#[inline(always)]
pub(super) fn rebound<N: Number>(coefficient: N, before: N) -> N {
    N::zero() - coefficient * before
}

/// The relative normal velocity after a contact between two moving sides, m/s, from the one `before` it and the one that the position solve gave, `now`.
#[inline(always)]
pub(super) fn separation_speed<N: Number>(coefficient: N, before: N, now: N, threshold: f32) -> N {
    let inelastic = now.min(before.max(N::zero())).max(N::zero());
    let elastic = is_elastic(coefficient, N::zero() - before, threshold);
    elastic.select(rebound(coefficient, before), inelastic)
}

/// The impulse of a contact between two moving sides on the first one, N·s, and its part along the normal `n`: restitution from the relative normal velocity
/// `before` it, and friction. `velocity` is the relative velocity that the position solve gave, and `inverse_mass` the inverse effective mass, 1/kg. Friction
/// takes at most `limit`, m/s, off the slip, and the coefficient `friction` times the speed that is added along the normal: the position solve of an impact
/// removes only the part of the approach by which the two overlapped when the substep ended.
#[inline(always)]
pub(super) fn contact_impulse<N: Number>(
    n: Vector<N>,
    velocity: Vector<N>,
    (coefficient, before, threshold): (N, N, f32),
    (friction, limit): (N, N),
    inverse_mass: N,
) -> (Vector<N>, N) {
    let now = n.dot(velocity);
    let gained = separation_speed(coefficient, before, now, threshold) - now;
    let slip = velocity - n * now;
    let limit = limit + friction * gained.max(N::zero());
    let share = friction_share(slip.length(), limit);
    let size = gained / inverse_mass;
    (n * size - slip * (share / inverse_mass), size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_contacts_bounce_and_others_are_clamped() {
        let g = threshold(8.0, 1.0 / 64.0);
        assert_eq!(g, 0.25);
        assert_eq!(
            separation_speed(0.5_f32, -2.0, 7.0, g),
            1.0,
            "elastic, whatever the position solve gave"
        );
        assert_eq!(separation_speed(0.5_f32, -0.1, 7.0, g), 0.0, "below the threshold");
        assert_eq!(separation_speed(0.0_f32, -2.0, 7.0, g), 0.0, "no restitution");
        assert_eq!(separation_speed(0.5_f32, 0.3, 7.0, g), 0.3, "not faster than before");
        assert_eq!(separation_speed(0.5_f32, 0.3, 0.1, g), 0.1, "never accelerated");
        assert_eq!(separation_speed(0.5_f32, 0.3, -0.4, g), 0.0, "stops approaching");
    }
}
