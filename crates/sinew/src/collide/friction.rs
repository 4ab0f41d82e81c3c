//! Coulomb friction (physics.md F8), as a position correction and in velocities.
//!
//! The position solve removes slip that is within the friction limit: [`friction`]. A contact whose two sides both move takes velocity off a slip at the end
//! of the substep instead: `μ N h/m` with `N = m δ/h²` of an overlap `δ`, that is `μ δ/h`. Either way at most all of the slip: [`friction_share`].

use glam::Vec3;

use super::recovery::limit_correction;
use crate::lanes::Number;
use crate::particles::Places;

/// Moves a row by the normal correction and by the friction that belongs to it. Of an overlap from before this substep, at most `recover` metres are corrected.
/// Returns the normal correction applied, metres.
#[inline]
pub(super) fn push(
    places: &mut Places,
    row: u32,
    normal_part: Vec3,
    (coefficient, recover): (f32, f32),
) -> f32 {
    let i = places.at(row);
    let moved = (places.position[i] - places.start[i]).truncate();
    let normal_part = limit_correction(normal_part, moved, recover);
    let depth = normal_part.length();
    // The square underflows to zero: dividing by it would be NaN.
    if depth * depth == 0.0 {
        return 0.0;
    }
    let moved = moved + normal_part;
    let slid = moved - normal_part * (moved.dot(normal_part) / (depth * depth));
    places.displace(row, normal_part + friction(slid, depth, coefficient));
    depth
}

/// The tangential correction of Coulomb's law as a displacement: `Δt = -t · min(μ Δn/‖t‖, 1)`.
///
/// `t` is the tangential slip of this substep and `Δn` the normal correction. A normal force N acting on the mass m for a substep h is the displacement `Δn = N
/// h²/m`; friction of at most μN corrects the slip by at most `μ Δn`, and never beyond zero slip.
#[inline]
pub(super) fn friction(slid: Vec3, normal_correction: f32, coefficient: f32) -> Vec3 {
    slid * -friction_share(slid.length(), coefficient * normal_correction)
}

/// The share of a slip of length `slip` that friction removes if its limit is `limit`, 0 to 1. Both in the same unit, metres or m/s.
#[inline(always)]
pub(super) fn friction_share<N: Number>(slip: N, limit: N) -> N {
    limit.lt(slip).select(limit / slip, N::splat(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_takes_at_most_mu_times_the_normal_correction() {
        let slid = Vec3::new(0.3, 0.0, 0.4);
        assert!(friction(slid, 0.1, 0.5).abs_diff_eq(slid * -0.1, 1e-7));
        assert_eq!(friction(slid, 10.0, 0.5), -slid);
        assert_eq!(friction(Vec3::ZERO, 0.0, 0.5), Vec3::ZERO);
    }

    #[test]
    fn friction_takes_at_most_all_of_a_sliding() {
        assert_eq!(friction_share(4.0_f32, 1.0), 0.25);
        assert_eq!(friction_share(1.0_f32, 4.0), 1.0);
        assert_eq!(friction_share(0.0_f32, 0.0), 1.0);
    }

    #[test]
    fn a_depth_whose_square_is_nothing_moves_nothing_and_is_no_nan() {
        let mut particles = crate::particles::Particles::default();
        let seed = crate::particles::ParticleSeed::at(Vec3::ZERO).with_velocity(Vec3::X);
        particles.push(seed).unwrap();
        let depth = push(&mut Places::all(&mut particles), 0, Vec3::Y * 1e-30, (0.5, 1.0));
        assert_eq!((depth, particles.position(0)), (0.0, Vec3::ZERO));
    }
}
