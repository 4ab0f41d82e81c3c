//! Coulomb friction (physics.md F8), as a position correction and in velocities.
//!
//! The position solve removes slip that is within the friction limit: [`friction`]. A contact whose two sides both move takes velocity off a slip at the end
//! of the substep instead: `μ N h/m` with `N = m δ/h²` of an overlap `δ`, that is `μ δ/h`. Either way at most all of the slip: [`friction_share`].

use super::recovery::limit_correction;
use crate::lanes::{Number, Vector};

/// The displacement of spheres that have `moved` since the substep began, metres, by their normal corrections `out` and the friction that belongs to them; and the
/// normal correction applied, metres. Both are zero where the square of the correction underflows. Of an overlap from before this substep, at most `recover`
/// metres are corrected.
#[inline(always)]
pub(crate) fn contact_correction<N: Number>(
    out: Vector<N>,
    moved: Vector<N>,
    (coefficient, recover): (N, N),
) -> (Vector<N>, N) {
    let out = limit_correction(out, moved, recover);
    let depth = out.length();
    let square = depth * depth;
    // Dividing by zero would be NaN.
    let touching = N::zero().lt(square);
    let moved = moved + out;
    let slid = moved - out * (moved.dot(out) / square);
    let by = out + friction(slid, depth, coefficient);
    (by.or_else(touching, Vector::zero()), touching.and(depth))
}

/// The tangential correction of Coulomb's law as a displacement: `Δt = -t · min(μ Δn/‖t‖, 1)`.
///
/// `t` is the tangential slip of this substep and `Δn` the normal correction. A normal force N acting on the mass m for a substep h is the displacement `Δn = N
/// h²/m`; friction of at most μN corrects the slip by at most `μ Δn`, and never beyond zero slip.
#[inline(always)]
pub(super) fn friction<N: Number>(
    slid: Vector<N>,
    normal_correction: N,
    coefficient: N,
) -> Vector<N> {
    slid * -friction_share(slid.length(), coefficient * normal_correction)
}

/// The share of a slip of length `slip` that friction removes if its limit is `limit`, 0 to 1. Both in the same unit, metres or m/s.
#[inline(always)]
pub(super) fn friction_share<N: Number>(slip: N, limit: N) -> N {
    limit.lt(slip).select(limit / slip, N::splat(1.0))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn friction_takes_at_most_mu_times_the_normal_correction() {
        let slid = Vec3::new(0.3, 0.0, 0.4);
        let friction = |slid: Vec3, depth, coefficient| {
            Vec3::from(super::friction(Vector::from(slid), depth, coefficient))
        };
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
        let (out, moved) = (Vector::from(Vec3::Y * 1e-30), Vector::from(Vec3::X));
        let (by, depth) = contact_correction(out, moved, (0.5, 1.0));
        assert_eq!((Vec3::from(by), depth), (Vec3::ZERO, 0.0));
    }
}
