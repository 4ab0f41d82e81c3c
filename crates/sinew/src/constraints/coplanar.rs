//! Particles in one plane (physics.md C6): fits the least-squares plane and projects all particles onto it.

use glam::{DVec3, Vec3};

use super::equation::{Equation, Points};
use super::fault::ConstraintFault;
use super::softness::Softness;
use super::towards::{Weights, towards};
use crate::pose::symmetric;

/// Keeps four or more particles in one plane, which may be anywhere.
///
/// The particles move to the plane that minimises the displacement `Σ m‖d‖²`. Pinned particles do not move and determine the plane, as far as they are coplanar
/// themselves. Where several planes are equally near (particles on a line, in one place, at the corners of a regular tetrahedron), one of them is chosen,
/// always the same for the same positions. The error reported to the solver is the mass-weighted root mean square of the distances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coplanar {
    /// How stiff the constraint is.
    pub softness: Softness,
}

impl Coplanar {
    /// Why the constraint cannot bind `particles` particles, or `None` if it can.
    pub(crate) fn fault(&self, particles: usize) -> Option<ConstraintFault> {
        // Three particles are always coplanar.
        (particles < 4).then_some(ConstraintFault::Count)
    }
}

/// Projection onto a plane with the unit normal `n` through `c` moves particle `i` by `-n (n·(qᵢ - c))`. The total cost is `Σ m (n·(q - c))²`. For a given
/// normal it is least for `c = q̄`, the barycentre; with `r = q - q̄` the cost is then
///
/// ```text
/// Σ m (n·r)² = nᵀ S n        S = Σ m r rᵀ
/// ```
///
/// which is least for the eigenvector of the least eigenvalue of `S`. So this is the true minimiser. It keeps momentum, `Σ m n (n·r) = 0`, and angular
/// momentum, `Σ m r × n (n·r) = (S n) × n = 0`.
impl Equation for Coplanar {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let Some(Spread { centre, values, axes }) = Spread::of(points) else { return 0.0 };
        let least = (1..3).fold(0, |least, i| if values[i] < values[least] { i } else { least });
        let normal = axes[least];
        towards(points, gradients, |i| {
            (normal * -normal.dot(points.at(i).as_dvec3() - centre)).as_vec3()
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

/// Second moments of the particles about their centre.
pub(super) struct Spread {
    /// Centre, metres from the origin.
    pub(super) centre: DVec3,
    /// `Σ m (e·r)²` along each of the axes, kg·m².
    pub(super) values: [f64; 3],
    /// The unit eigenvectors of `Σ m r rᵀ`.
    pub(super) axes: [DVec3; 3],
}

impl Spread {
    /// `None` if no particle is free.
    pub(super) fn of(points: &Points) -> Option<Self> {
        let weights = Weights::of(points)?;
        let centre = weights.centre(points);
        let mut s = [[0.0; 3]; 3];
        for i in 0..points.len() {
            let r = points.at(i).as_dvec3() - centre;
            let along = (r * weights.at(points, i)).to_array();
            for (row, m) in s.iter_mut().zip(along) {
                for (sum, x) in row.iter_mut().zip(r.to_array()) {
                    *sum += m * x;
                }
            }
        }
        let (values, axes) = symmetric::eigen(s);
        Some(Self { centre, values, axes: axes.map(DVec3::from_array) })
    }
}

#[cfg(test)]
mod tests {
    use super::super::checks::{self, Random, points_of};
    use super::*;

    /// Seven particles in a bowl shape, and their masses.
    fn bowl() -> (Vec<Vec3>, Vec<f32>) {
        let mut random = Random::new(3);
        let places = random.positions(7);
        let flatter = places.iter().map(|p| Vec3::new(p.x, p.y, 0.3 * p.z + 0.2 * p.x + 2.0));
        (flatter.collect(), random.masses(7))
    }

    /// Largest distance from the plane of the first three, metres.
    fn off(places: &[Vec3]) -> f32 {
        let normal = (places[1] - places[0]).cross(places[2] - places[0]).normalize();
        places.iter().map(|p| normal.dot(*p - places[0]).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn one_projection_makes_them_coplanar_and_keeps_both_momenta() {
        let (places, masses) = bowl();
        let equation = Coplanar::default();
        checks::assert_gradients(&equation, &places);
        checks::assert_momentum_kept(&equation, &places, &masses);
        let mut particles = points_of(&places, &masses);
        let error = particles.project(&equation);
        assert!(off(&places) > 0.1 && error > 0.05, "{} {error}", off(&places));
        assert!(off(&particles.positions()) < 1e-6, "{}", off(&particles.positions()));
        assert!(particles.error(&equation) < 1e-6);
    }

    #[test]
    fn every_other_plane_costs_more() {
        let (places, masses) = bowl();
        let mut particles = points_of(&places, &masses);
        particles.project(&Coplanar::default());
        let least = particles.cost(&places);
        let found = particles.positions();
        let normal = (found[1] - found[0]).cross(found[2] - found[0]).normalize();
        let mut random = Random::new(5);
        for _ in 0..200 {
            // Through a nearby point, and slightly tilted.
            let tilted = (normal + random.vector() * 0.05).normalize().as_dvec3();
            let through = (found[0] + random.vector() * 0.02).as_dvec3();
            let cost: f64 = places
                .iter()
                .zip(&masses)
                .map(|(p, m)| {
                    let height = tilted.dot(p.as_dvec3() - through);
                    f64::from(*m) * height * height
                })
                .sum();
            assert!(cost > least * (1.0 + 1e-6), "{cost} {least}");
        }
    }

    #[test]
    fn pinned_particles_decide_and_do_not_move() {
        let (places, mut masses) = bowl();
        for pinned in [vec![4], vec![0, 3], vec![1, 2, 6]] {
            let mut masses = std::mem::replace(&mut masses, bowl().1);
            for &i in &pinned {
                masses[i] = f32::INFINITY;
            }
            let mut particles = points_of(&places, &masses);
            for _ in 0..3 {
                particles.project(&Coplanar::default());
            }
            let found = particles.positions();
            assert!(off(&found) < 2e-6, "{pinned:?}: {}", off(&found));
            assert!(pinned.iter().all(|&i| found[i] == places[i]));
        }
    }

    #[test]
    fn degenerate_sets_stay_finite_and_three_particles_are_refused() {
        checks::assert_survives(&Coplanar::default(), &bowl().0);
        let tetrahedron = [Vec3::ONE, Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0)];
        let tetrahedron = [tetrahedron.as_slice(), &[Vec3::new(-1.0, -1.0, 1.0)]].concat();
        let mut particles = points_of(&tetrahedron, &[]);
        particles.project(&Coplanar::default());
        assert!(particles.error(&Coplanar::default()) < 1e-6, "any of three planes, but one");
        assert_eq!(Coplanar::default().fault(3), Some(ConstraintFault::Count));
        assert_eq!(Coplanar::default().fault(4), None);
    }
}
