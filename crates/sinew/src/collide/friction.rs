//! Coulomb's law of friction (physics.md F8), in positions and in velocities.
//!
//! In positions, within a substep, it holds what sticks: [`friction`]. A contact whose two sides both move takes speed off what slides at the end of the
//! substep instead: `μ N h/m` with `N = m δ/h²` of an overlap `δ`, that is `μ δ/h`. Either way at most all of the sliding: [`friction_share`].

use glam::Vec3;

use super::recovery::recovered_way;
use crate::lanes::Number;
use crate::particles::Places;

/// Moves a row by the normal correction, of which that of an overlap from before is `recover` metres at the most, and by the friction that goes with it;
/// returns how far, metres.
#[inline]
pub(super) fn push(
    places: &mut Places,
    row: u32,
    normal_part: Vec3,
    (coefficient, recover): (f32, f32),
) -> f32 {
    let i = places.at(row);
    let moved = (places.position[i] - places.start[i]).truncate();
    let normal_part = recovered_way(normal_part, moved, recover);
    let depth = normal_part.length();
    // Of what is too little to be squared nothing comes.
    if depth * depth == 0.0 {
        return 0.0;
    }
    let moved = moved + normal_part;
    let slid = moved - normal_part * (moved.dot(normal_part) / (depth * depth));
    places.displace(row, normal_part + friction(slid, depth, coefficient));
    depth
}

/// The tangential correction of Coulomb's law in positions: `Δt = -t · min(μ Δn/‖t‖, 1)`.
///
/// `t` is the sliding of this substep and `Δn` the normal correction. A normal force N acts for a substep h on the mass m as
/// the displacement `Δn = N h²/m`; friction of at most μN moves it back by at most `μ Δn`, and never past standing still.
#[inline]
pub(super) fn friction(slid: Vec3, normal_correction: f32, coefficient: f32) -> Vec3 {
    slid * -friction_share(slid.length(), coefficient * normal_correction)
}

/// The share of a sliding of `length` that friction takes which is good for `most` of it, 0 to 1, both in the same unit.
#[inline(always)]
pub(super) fn friction_share<N: Number>(length: N, most: N) -> N {
    most.lt(length).select(most / length, N::splat(1.0))
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
