//! Restitution of contacts, after velocities are derived from positions: the one law, for a lane or for eight.
//!
//! Positions have no elasticity: what is put on a surface leaves it with the speed that it lacked to get there. So contacts correct velocities at the end
//! of a substep of `h` seconds. With `u` the relative speed along the normal before the contact acted (negative when approaching), `u'` the present one
//! and `e` the coefficient of restitution, Newton's law asks for
//!
//! ```text
//! u' = -e u                        where u < -2gh and e > 0   (elastic)
//! u' = clamp(u', 0, max(u, 0))     elsewhere                  (inelastic)
//! ```
//!
//! [`threshold`] `2gh` is what gravity alone gives to a body at rest: without it a stack would bounce for ever. The inelastic case is for contacts whose
//! two sides both move: they neither approach any more, nor part faster than before, for a speed above that comes of recovering an overlap.
//!
//! Particles against colliders, particles and triangles against each other and body colliders all use these; what is particular to each (several points of one
//! manifold, effective masses) is beside them.

use crate::lanes::Number;

/// The speed of approach below which contacts are inelastic, m/s, in a substep of `h` seconds.
#[inline(always)]
pub(super) fn threshold(gravity: f32, h: f32) -> f32 {
    2.0 * gravity * h
}

/// Mask of the contacts that are elastic at a `speed` of approach, m/s.
#[inline(always)]
pub(super) fn is_elastic<N: Number>(coefficient: N, speed: N, threshold: f32) -> N {
    N::zero().lt(coefficient).and(N::splat(threshold).lt(speed))
}

/// The relative speed along the normal that an elastic contact leaves, m/s, of the one `before` it, which is negative when approaching.
#[inline(always)]
pub(super) fn rebound<N: Number>(coefficient: N, before: N) -> N {
    N::zero() - coefficient * before
}

/// The relative speed along the normal that a contact of two that both move leaves, m/s, of the one `before` it and the one that positions gave, `now`.
#[inline(always)]
pub(super) fn separation_speed<N: Number>(coefficient: N, before: N, now: N, threshold: f32) -> N {
    let inelastic = now.min(before.max(N::zero())).max(N::zero());
    let elastic = is_elastic(coefficient, N::zero() - before, threshold);
    elastic.select(rebound(coefficient, before), inelastic)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_fast_bounces_and_what_rests_is_held_between_nought_and_what_it_had() {
        let g = threshold(8.0, 1.0 / 64.0);
        assert_eq!(g, 0.25);
        assert_eq!(
            separation_speed(0.5_f32, -2.0, 7.0, g),
            1.0,
            "elastic, whatever positions gave"
        );
        assert_eq!(separation_speed(0.5_f32, -0.1, 7.0, g), 0.0, "below the threshold");
        assert_eq!(separation_speed(0.0_f32, -2.0, 7.0, g), 0.0, "no restitution");
        assert_eq!(separation_speed(0.5_f32, 0.3, 7.0, g), 0.3, "no faster than it parted before");
        assert_eq!(separation_speed(0.5_f32, 0.3, 0.1, g), 0.1, "nor is it sped up");
        assert_eq!(separation_speed(0.5_f32, 0.3, -0.4, g), 0.0, "and approaches no more");
    }
}
