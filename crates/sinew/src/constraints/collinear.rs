//! Particles on one line (physics.md C6): fits the least-squares line and projects all particles onto it.

use glam::Vec3;

use super::coplanar::Spread;
use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::towards::towards;

/// Keeps three or more particles on one line, which may be anywhere. It does not keep their order or their distances.
///
/// The particles move to the line that minimises the displacement `Σ m‖d‖²`. Pinned particles do not move and determine the line, as far as they are collinear
/// themselves. Where several lines are equally near (particles in one place, at the corners of a square or a cube), one of them is chosen, always the same for
/// the same positions. The error reported to the solver is the mass-weighted root mean square of the distances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Collinear {
    /// How stiff the constraint is.
    pub softness: Softness,
}

impl Collinear {
    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        // Two particles are always collinear.
        (particles < 3).then_some(ConstraintFault::Count)
    }
}

/// Projection onto the line along the unit vector `e` through the barycentre moves particle `i` by `e (e·r) - r`, with `r = q - q̄`. The total cost is
/// `Σ m (r² - (e·r)²) = tr S - eᵀ S e`, with `S` as for [`Coplanar`](super::Coplanar). It is least for the eigenvector of the greatest eigenvalue. Momentum is
/// kept, `Σ m r = 0`, and so is angular momentum, `Σ m r × e (e·r) = (S e) × e = 0`.
impl Equation for Collinear {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let Some(Spread { centre, values, axes }) = Spread::of(points) else { return 0.0 };
        let most = (1..3).fold(0, |most, i| if values[i] > values[most] { i } else { most });
        let along = axes[most];
        towards(points, gradients, |i| {
            let r = points.at(i).as_dvec3() - centre;
            (along * along.dot(r) - r).as_vec3()
        })
    }

    fn softness(&self) -> Softness {
        self.softness
    }

    fn is_internal(&self) -> bool {
        true
    }

    fn is_length(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::{self, Random, points_of};
    use super::*;

    /// Five beads near a line, and their masses.
    fn beads() -> (Vec<Vec3>, Vec<f32>) {
        let mut random = Random::new(11);
        let along = Vec3::new(1.0, -0.5, 2.0);
        let places = (0..5).map(|i| along * (0.3 * i as f32) + random.vector() * 0.2);
        (places.collect(), random.masses(5))
    }

    /// Largest distance from the line through the first and the last, metres.
    fn off(places: &[Vec3]) -> f32 {
        let along = (places[4] - places[0]).normalize();
        places.iter().map(|p| (*p - places[0]).reject_from(along).length()).fold(0.0, f32::max)
    }

    #[test]
    fn one_projection_makes_them_collinear_and_keeps_both_momenta() {
        let (places, masses) = beads();
        let equation = Collinear::default();
        checks::assert_gradients(&equation, &places);
        checks::assert_momentum_kept(&equation, &places, &masses);
        let mut particles = points_of(&places, &masses);
        let error = particles.project(&equation);
        assert!(off(&places) > 0.1 && error > 0.05, "{} {error}", off(&places));
        assert!(off(&particles.positions()) < 1e-6, "{}", off(&particles.positions()));
        assert!(particles.error(&equation) < 1e-6);
    }

    #[test]
    fn every_other_line_costs_more() {
        let (places, masses) = beads();
        let mut particles = points_of(&places, &masses);
        particles.project(&Collinear::default());
        let least = particles.cost(&places);
        let found = particles.positions();
        let along = (found[4] - found[0]).normalize();
        let mut random = Random::new(5);
        for _ in 0..200 {
            // Through a nearby point, and slightly tilted.
            let tilted = (along + random.vector() * 0.05).normalize().as_dvec3();
            let through = (found[0] + random.vector() * 0.02).as_dvec3();
            let cost: f64 = places
                .iter()
                .zip(&masses)
                .map(|(p, m)| {
                    let r = p.as_dvec3() - through;
                    f64::from(*m) * (r - tilted * tilted.dot(r)).length_squared()
                })
                .sum();
            assert!(cost > least * (1.0 + 1e-6), "{cost} {least}");
        }
    }

    #[test]
    fn pinned_particles_decide_and_do_not_move() {
        let (places, _) = beads();
        for pinned in [vec![2], vec![0, 3]] {
            let mut masses = beads().1;
            for &i in &pinned {
                masses[i] = f32::INFINITY;
            }
            let mut particles = points_of(&places, &masses);
            for _ in 0..3 {
                particles.project(&Collinear::default());
            }
            let found = particles.positions();
            assert!(off(&found) < 2e-6, "{pinned:?}: {}", off(&found));
            assert!(pinned.iter().all(|&i| found[i] == places[i]));
        }
    }

    #[test]
    fn degenerate_sets_stay_finite_and_two_particles_are_refused() {
        checks::assert_survives(&Collinear::default(), &beads().0);
        let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let mut particles = points_of(&square, &[]);
        particles.project(&Collinear::default());
        assert!(
            particles.error(&Collinear::default()) < 1e-6,
            "any line through its middle, but one"
        );
        assert_eq!(Collinear::default().fault(2), Some(ConstraintFault::Count));
        assert_eq!(Collinear::default().fault(3), None);
    }
}
