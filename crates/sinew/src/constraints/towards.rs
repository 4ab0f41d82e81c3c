//! Constraints that are given by the target position of each particle, expressed as the value and gradient that the solver requires; and the weight of pinned
//! particles in such a fit.

use glam::{DVec3, Vec3};

use super::equation::Points;

/// Value and gradients of the constraint "every free particle moves by its own `dᵢ`", metres; zero where that is not finite.
///
/// Some constraints have a closed form for the whole displacement (a plane, a line, a rigid shape, a change of scale). With `M = Σ mᵢ` over the free particles
/// let
///
/// ```text
/// C = √(Σ mᵢ‖dᵢ‖² / M)        ∇ᵢC = -mᵢ dᵢ / (M C)
/// ```
///
/// Then `Σ wⱼ‖∇ⱼC‖² = Σ mⱼ‖dⱼ‖² / (M C)² = 1/M`, and the solver's displacement for any equation, `-wᵢ ∇ᵢC · C / Σ wⱼ‖∇ⱼC‖²`, is
///
/// ```text
/// wᵢ · mᵢ dᵢ / (M C) · C · M = dᵢ
/// ```
///
/// so a hard constraint moves each particle by exactly `dᵢ`, and a soft one by the same share of it: `C`, the mass-weighted root mean square displacement, is
/// the length of a spring that carries the whole mass `M`. If the `dᵢ` are the least `Σ m‖d‖²` that lead to a fixed set, `C` is the distance to that set and
/// `∇C` its gradient. Otherwise `∇C` is not a true gradient, and need not be.
///
/// `M C ≥ √(M mᵢ) ‖dᵢ‖`, so no gradient is longer than 1, whatever the mass ratios.
pub(crate) fn towards(
    points: &Points,
    gradients: &mut [Vec3],
    mut displacement: impl FnMut(usize) -> Vec3,
) -> f32 {
    let (mut mass, mut sum) = (0.0_f64, 0.0_f64);
    for (i, kept) in gradients.iter_mut().enumerate() {
        let w = points.inverse_mass(i);
        if w > 0.0 {
            // Stored in place of the gradient, so that no displacement is computed twice.
            *kept = displacement(i);
            let m = 1.0 / f64::from(w);
            mass += m;
            sum += m * kept.as_dvec3().length_squared();
        }
    }
    let value = (sum / mass).sqrt();
    // Also handles no free particle, and NaN.
    if !(value > 0.0 && value.is_finite()) {
        gradients.fill(Vec3::ZERO);
        return 0.0;
    }
    for (i, gradient) in gradients.iter_mut().enumerate() {
        let w = points.inverse_mass(i);
        if w > 0.0 {
            let share = 1.0 / (f64::from(w) * mass);
            *gradient = (gradient.as_dvec3() * (-share / value)).as_vec3();
        }
    }
    value as f32
}

/// The weight of each particle in a fit: pinned particles determine it, and free ones follow.
///
/// The centre of the set is the barycentre if all particles are free, and otherwise the mean of the pinned ones. It is exactly that, because a fit about one
/// pinned particle must not shift it. In the moments about the centre a pinned particle has [`PINNED`] times the weight of all free ones together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    /// Weight of a pinned particle in the moments, kg.
    heavy: f64,
    /// One over the sum of the weights in the centre.
    share: f64,
    any_pinned: bool,
}

/// Weight of a pinned particle, as a multiple of the mass of all free ones. If several pinned particles cannot all be met, the fit is a compromise between
/// them; the free ones distort it by a thousandth, which the next sweep reduces to a millionth. A greater weight would leave too few digits for what the free
/// ones determine (the rotation about a hinge of two pins).
const PINNED: f64 = 1e3;

impl Weights {
    /// `None` if no particle is free.
    pub(crate) fn of(points: &Points) -> Option<Self> {
        let (mut free, mut pinned) = (0.0_f64, 0.0_f64);
        for i in 0..points.len() {
            match points.inverse_mass(i) {
                w if w > 0.0 => free += 1.0 / f64::from(w),
                _ => pinned += 1.0,
            }
        }
        let any_pinned = pinned > 0.0;
        let share = 1.0 / if any_pinned { pinned } else { free };
        (free > 0.0).then_some(Self { heavy: PINNED * free, share, any_pinned })
    }

    /// Weight of particle `i` in the moments about the centre, kg.
    #[inline]
    pub(crate) fn at(&self, points: &Points, i: usize) -> f64 {
        let w = points.inverse_mass(i);
        if w > 0.0 { 1.0 / f64::from(w) } else { self.heavy }
    }

    /// Weight of particle `i` in the centre; these sum to 1.
    #[inline]
    pub(crate) fn in_centre(&self, points: &Points, i: usize) -> f64 {
        let w = points.inverse_mass(i);
        match (self.any_pinned, w > 0.0) {
            (false, _) => self.share / f64::from(w),
            (true, true) => 0.0,
            (true, false) => self.share,
        }
    }

    /// The centre of the particles at their current positions, metres from the origin. It is a sum of differences from the first one, so that coincident
    /// particles have their centre exactly there.
    pub(crate) fn centre(&self, points: &Points) -> DVec3 {
        let first = points.at(0).as_dvec3();
        let from_first = |i| (points.at(i).as_dvec3() - first) * self.in_centre(points, i);
        first + (1..points.len()).map(from_first).sum::<DVec3>()
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::points_of;
    use super::super::{Equation, Softness};
    use super::*;

    /// Moves each particle by its own displacement.
    #[derive(Debug)]
    struct Displaced(Vec<Vec3>, Softness);

    impl Equation for Displaced {
        fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
            towards(points, gradients, |i| self.0[i])
        }

        fn softness(&self) -> Softness {
            self.1
        }

        fn is_length(&self) -> bool {
            true
        }
    }

    const STEPS: [Vec3; 3] = [Vec3::X, Vec3::new(0.0, -3.0, 1.0), Vec3::new(1e-3, 0.0, 0.0)];

    #[test]
    fn a_hard_constraint_moves_each_particle_by_its_displacement_and_a_pinned_one_not_at_all() {
        for masses in [[1.0, 1.0, 1.0], [1e-6, 1e6, 3.0], [2.0, f32::INFINITY, 1.0]] {
            let mut particles = points_of(&[Vec3::ZERO; 3], &masses);
            particles.project(&Displaced(STEPS.to_vec(), Softness::Hard));
            for (i, p) in particles.positions().iter().enumerate() {
                let wanted = if masses[i].is_finite() { STEPS[i] } else { Vec3::ZERO };
                assert!((*p - wanted).length() <= 1e-6 * wanted.length(), "{masses:?} {i} {p}");
            }
        }
    }

    #[test]
    fn a_soft_constraint_moves_all_by_the_same_share() {
        let mut particles = points_of(&[Vec3::ZERO; 3], &[1.0, 2.0, 4.0]);
        // ωh = 1, so half of the displacement: 1/(1 + 1/(ωh)²).
        let hertz = 60.0 / core::f32::consts::TAU;
        particles.project(&Displaced(STEPS.to_vec(), Softness::frequency(hertz, 0.0)));
        for (p, step) in particles.positions().iter().zip(STEPS) {
            assert!((*p - step * 0.5).length() < 1e-6, "{p}");
        }
    }

    #[test]
    fn no_way_to_go_or_one_that_is_no_number_is_nothing() {
        for step in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            let mut particles = points_of(&[Vec3::ZERO; 2], &[]);
            particles.project(&Displaced(vec![step; 2], Softness::Hard));
            assert_eq!(particles.positions(), [Vec3::ZERO; 2]);
        }
    }

    #[test]
    fn one_pinned_particle_is_the_centre_and_otherwise_the_barycentre_is() {
        let places = [Vec3::ZERO, Vec3::X, Vec3::Y * 4.0];
        let centre = |masses: &[f32]| {
            let particles = points_of(&places, masses);
            Weights::of(&particles.points()).map(|w| w.centre(&particles.points()))
        };
        assert_eq!(centre(&[2.0, 1.0, 1.0]), Some(DVec3::new(0.25, 1.0, 0.0)));
        assert_eq!(centre(&[2.0, f32::INFINITY, 1.0]), Some(DVec3::X));
        assert_eq!(centre(&[f32::INFINITY; 3]), None);
    }
}
