//! The result of a recipe: particles, the constraints between them, and the data to draw them. Plain data, so that a game may add to it, move it or check it
//! before it is built.

use glam::{Mat3, Quat, Vec3};

use crate::collide::Shape;
use crate::constraints::{Constraint, ConstraintFault, Distance, DistanceFault};
use crate::particles::{ParticleFault, ParticleSeed};
use crate::settings::BodySettings;

/// Particles and the constraints between them, in the body's own coordinates (metres). Indices count from 0 within the blueprint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blueprint {
    /// The particles; a pinned particle has infinite mass.
    pub particles: Vec<ParticleSeed>,
    /// For each [pinned](Self::pin) particle, its index and the mass that it has when it is released, kg; sorted by index.
    pub free_masses: Vec<(u32, f32)>,
    /// Distances to keep between pairs of particles.
    pub distances: Vec<Distance>,
    /// All other constraints; their rows are particle indices of this blueprint.
    pub constraints: Vec<Constraint>,
    /// Triangles of particles, counter-clockwise from outside, on which wind acts.
    pub triangles: Vec<[u32; 3]>,
    /// For a mesh that follows the particles: the particle that each vertex follows. Empty if there is no mesh.
    pub vertices: Vec<u32>,
    /// Rigid parts whose pose is read back; empty for a body such as cloth.
    pub parts: Vec<Part>,
    /// Solver settings of the body. Boxes use [`GradientAt::StepStart`](crate::constraints::GradientAt::StepStart), which keeps their spin.
    pub settings: BodySettings,
}

/// A rigid part of a body: the particles that carry it, and their positions in the part's own frame.
///
/// Its transform is the rotation and translation that best maps `rest` onto the particles (physics.md E1). A part of two particles is a rod: its direction is
/// determined, but not its rotation about itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Its name, such as `"torso"` or `"left forearm"`.
    pub name: &'static str,
    /// Indices of its particles in the blueprint.
    pub particles: Vec<u32>,
    /// Their positions in the part's own frame, metres; as many as `particles`.
    pub rest: Vec<Vec3>,
    /// Size of the part along its own axes, metres, for drawing it centred on the origin of its frame. A capsule has the diameter `size.x` and the total length
    /// `size.y`, caps included.
    pub size: Vec3,
    /// Collision shape, in its own frame; `None` for a part that collides by its particles alone.
    pub shape: Option<Shape>,
}

/// What is wrong with a blueprint. Indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BlueprintFault {
    /// A particle cannot be simulated.
    #[error("its particle {index} cannot be simulated: {fault}")]
    Particle {
        /// Index of the particle.
        index: usize,
        /// The reason.
        fault: ParticleFault,
    },
    /// A distance cannot be kept.
    #[error("its distance {index} cannot be kept: {fault}")]
    Distance {
        /// Index of the distance.
        index: usize,
        /// The reason.
        fault: DistanceFault,
    },
    /// A constraint cannot be enforced.
    #[error("its constraint {index} cannot be enforced: {fault}")]
    Constraint {
        /// Index of the constraint.
        index: usize,
        /// The reason.
        fault: ConstraintFault,
    },
    /// A triangle has a corner that is no particle, or the same particle twice.
    #[error("its triangle {0} does not have three particles for corners")]
    Triangle(usize),
    /// A vertex follows a particle that does not exist.
    #[error("its vertex {0} follows a particle that does not exist")]
    Vertex(usize),
    /// A part has a particle that does not exist, does not have one rest position for each particle, or has a number that is not finite.
    #[error("its part {0} does not match the particles")]
    Part(usize),
    /// [`Blueprint::pin`] was called with a particle that does not exist.
    #[error("it has no particle {0}")]
    NoSuchParticle(u32),
}

impl Blueprint {
    /// Returns the first fault, in the order of the fields. The result of a recipe is valid; call this after changes by hand.
    pub fn validate(&self) -> Result<(), BlueprintFault> {
        let count = self.particles.len();
        let exists = |particle: &u32| (*particle as usize) < count;
        for (index, particle) in self.particles.iter().enumerate() {
            if let Some(fault) = particle.fault() {
                return Err(BlueprintFault::Particle { index, fault });
            }
        }
        for (index, distance) in self.distances.iter().enumerate() {
            if let Some(fault) = distance.fault(count) {
                return Err(BlueprintFault::Distance { index, fault });
            }
        }
        for (index, constraint) in self.constraints.iter().enumerate() {
            if let Some(fault) = constraint.fault(count) {
                return Err(BlueprintFault::Constraint { index, fault });
            }
        }
        for (index, t @ [a, b, c]) in self.triangles.iter().enumerate() {
            if a == b || b == c || c == a || !t.iter().all(exists) {
                return Err(BlueprintFault::Triangle(index));
            }
        }
        if let Some(index) = self.vertices.iter().position(|v| !exists(v)) {
            return Err(BlueprintFault::Vertex(index));
        }
        let sound = |part: &Part| {
            part.particles.len() == part.rest.len()
                && part.particles.iter().all(exists)
                && part.rest.iter().all(|r| r.is_finite())
                && part.size.is_finite()
        };
        match self.parts.iter().position(|part| !sound(part)) {
            Some(index) => Err(BlueprintFault::Part(index)),
            None => Ok(()),
        }
    }

    /// Sum of the finite masses, kg; pinned particles, whose mass is infinite, are left out.
    pub fn total_mass(&self) -> f32 {
        let finite = self.particles.iter().filter(|p| p.mass.is_finite());
        finite.map(|p| f64::from(p.mass)).sum::<f64>() as f32
    }

    /// Pins a particle by giving it infinite mass, and records its former mass in [`free_masses`](Self::free_masses). Fails if the particle does not exist.
    pub fn pin(&mut self, particle: u32) -> Result<(), BlueprintFault> {
        match self.particles.get_mut(particle as usize) {
            Some(seed) => {
                let place = self.free_masses.partition_point(|&(other, _)| other < particle);
                if seed.mass.is_finite() {
                    self.free_masses.insert(place, (particle, seed.mass));
                }
                *seed = seed.pinned();
                Ok(())
            }
            None => Err(BlueprintFault::NoSuchParticle(particle)),
        }
    }

    /// Mass of a pinned particle when it is released, kg; `None` if it was not pinned by [`pin`](Self::pin).
    pub fn free_mass(&self, particle: u32) -> Option<f32> {
        let place = self.free_masses.binary_search_by_key(&particle, |&(other, _)| other);
        place.ok().map(|place| self.free_masses[place].1)
    }

    /// The same body rotated about its origin and then moved by `translation` (metres). Positions and velocities are rotated, positions are moved; lengths,
    /// masses and the parts' own frames do not change.
    ///
    /// `rotation` need not be normalised; one that cannot be (zero, NaN) counts as the identity. With a translation that is not finite the result does not pass
    /// [`validate`](Self::validate).
    pub fn transformed(&self, rotation: Quat, translation: Vec3) -> Self {
        let turn = rotation_matrix(rotation);
        let mut placed = self.clone();
        for particle in &mut placed.particles {
            particle.position = turn * particle.position + translation;
            particle.velocity = turn * particle.velocity;
        }
        placed
    }

    /// Particles at these positions, metres, that share a mass, kg, evenly and are all connected by rods.
    pub(super) fn fully_connected(places: &[Vec3], mass: f32, radius: f32, drag: f32) -> Self {
        let count = places.len() as u32;
        let seed = |&place: &Vec3| {
            let seed = ParticleSeed::at(place).with_mass(mass / count as f32);
            seed.with_radius(radius).with_drag(drag)
        };
        let mut body = Self { particles: places.iter().map(seed).collect(), ..Self::default() };
        for a in 0..count {
            (a + 1..count).for_each(|b| body.rod(a, b));
        }
        body
    }

    /// Adds a hard rod between two existing particles, with their distance as rest length.
    pub(super) fn rod(&mut self, a: u32, b: u32) {
        let ends = [a, b].map(|i| self.particles[i as usize].position);
        self.distances.push(Distance::new(a, b, rest_length(ends[0], ends[1])));
    }
}

/// The distance of two points, computed in f64 and rounded once; used as a rest length.
pub(super) fn rest_length(a: Vec3, b: Vec3) -> f32 {
    (a.as_dvec3() - b.as_dvec3()).length() as f32
}

/// Normalised here, term by term, because the order of terms in glam differs between processors.
fn rotation_matrix(q: Quat) -> Mat3 {
    let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    if length.is_finite() && length > 0.0 {
        let unit = Quat::from_xyzw(q.x / length, q.y / length, q.z / length, q.w / length);
        Mat3::from_quat(unit)
    } else {
        Mat3::IDENTITY
    }
}

/// Checks that every recipe's tests share.
#[cfg(test)]
pub(super) mod checks {
    use super::Blueprint;
    use crate::constraints::checks::evaluate;
    use crate::constraints::{Bound, Constraint, ConstraintKind};
    use crate::simulation::Simulation;
    use glam::Vec3;
    use std::collections::BTreeSet;

    /// Asserts that the blueprint is valid, no pair has two distances of the same bound, no rest length is 0, and all distances are kept to 1e-6 of their
    /// length.
    pub(crate) fn assert_at_rest(blueprint: &Blueprint) {
        assert_eq!(blueprint.validate(), Ok(()));
        let mut seen = BTreeSet::new();
        for d in &blueprint.distances {
            let pair = [d.a.min(d.b), d.a.max(d.b)];
            let way = match d.bound {
                Bound::Equal => 0,
                Bound::AtMost => 1,
                Bound::AtLeast => 2,
            };
            assert!(seen.insert((pair, way)), "{d:?} is there twice");
            assert!(d.rest > 0.0, "{d:?}");
            let [a, b] = [d.a, d.b].map(|i| blueprint.particles[i as usize].position);
            assert!(d.error(a, b) <= 1e-6 * d.rest, "{d:?}: {a} {b}");
        }
    }

    /// How far the worst limit of an angle is exceeded, degrees, and the index of its constraint. Errors of rigid pieces do not count.
    pub(crate) fn excess(world: &Simulation) -> (f32, usize) {
        let one = |c: &Constraint| {
            if matches!(c.kind, ConstraintKind::Rigid(_)) {
                return 0.0;
            }
            let places: Vec<Vec3> =
                c.rows.iter().map(|&i| world.particles.position(i as usize)).collect();
            evaluate(c.kind.equation(), &places).0.abs().to_degrees()
        };
        let all = world.constraints().iter().map(one).zip(0..);
        all.fold((0.0, 0), |worst, one| if one.0 > worst.0 { one } else { worst })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BoxSpec, box_3d};
    use super::*;

    fn cube() -> Blueprint {
        box_3d(&BoxSpec::default()).unwrap()
    }

    #[test]
    fn moving_and_turning_keeps_every_length_and_the_mass() {
        let body = cube();
        let turned =
            body.transformed(Quat::from_xyzw(1.0, -2.0, 0.5, 3.0), Vec3::new(3.0, 4.0, -5.0));
        for (d, rest) in turned.distances.iter().zip(&body.distances) {
            let [a, b] = [d.a, d.b].map(|i| turned.particles[i as usize].position);
            assert!((rest_length(a, b) - rest.rest).abs() < 2e-6);
        }
        assert_eq!(turned.total_mass(), body.total_mass());
        assert_eq!(turned.parts, body.parts);
        assert_ne!(turned.particles, body.particles);
    }

    #[test]
    fn a_rotation_that_is_none_turns_nothing() {
        for q in [Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)] {
            assert_eq!(cube().transformed(q, Vec3::ZERO), cube());
        }
    }

    #[test]
    fn a_pinned_particle_leaves_the_total_mass_and_a_missing_one_is_refused() {
        let mut body = cube();
        body.pin(3).unwrap();
        assert_eq!(body.particles[3].mass, f32::INFINITY);
        assert_eq!(body.total_mass(), 7.0 / 8.0);
        assert_eq!((body.free_mass(3), body.free_mass(4)), (Some(1.0 / 8.0), None));
        let before = body.clone();
        assert_eq!(body.pin(8), Err(BlueprintFault::NoSuchParticle(8)));
        assert_eq!(body, before);
    }

    #[test]
    fn each_fault_is_found_where_it_is() {
        let spoilt = |spoil: fn(&mut Blueprint)| {
            let mut body = cube();
            spoil(&mut body);
            body.validate().unwrap_err()
        };
        let fault = ParticleFault::Mass;
        let particle = BlueprintFault::Particle { index: 2, fault };
        assert_eq!(spoilt(|b| b.particles[2].mass = 0.0), particle);
        let fault = DistanceFault::MissingParticle;
        let distance = BlueprintFault::Distance { index: 5, fault };
        assert_eq!(spoilt(|b| b.distances[5].b = 9), distance);
        assert_eq!(spoilt(|b| b.triangles[1] = [1, 2, 1]), BlueprintFault::Triangle(1));
        assert_eq!(spoilt(|b| b.vertices = vec![7, 8]), BlueprintFault::Vertex(1));
        assert_eq!(spoilt(|b| b.parts[0].rest.truncate(7)), BlueprintFault::Part(0));
        assert_eq!(
            distance.to_string(),
            "its distance 5 cannot be kept: one of its particles does not exist"
        );
    }
}
