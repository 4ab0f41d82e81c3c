//! Gravity: a uniform field, and attraction by heavy points (physics.md F1).
//!
//! A point of gravitational parameter `GM` attracts with `a = -GM d/(r² + ε²)^{3/2}`, where `d` is the particle's position relative to the point. The softening
//! `ε` keeps it finite where a particle passes through; its potential is `-GM/√(r² + ε²)`. Both kinds are accelerations, independent of mass, and the [gravity
//! scale](crate::ParticleSeed::gravity_scale) of a particle multiplies both. Particles do not attract the point.

use glam::{DVec3, Vec3, Vec4};

use super::Forces;
use crate::lanes::{InstructionSet, LANES, LaneArray, Lanes, Number, Vector, kernel};
use crate::particles::Particles;

/// A point that attracts all particles, such as a planet, a magnet in a game or a black hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attractor {
    /// Its position, metres.
    pub position: Vec3,
    /// Gravitational parameter `GM`, m³/s²; negative repels. At a distance of 10 m, 981 m³/s² give the gravity of the Earth's surface.
    pub strength: f32,
    /// Softening length `ε`, metres, 0 or more: the attraction stops growing within it. Default 0.1; keep it larger than a particle's displacement in a
    /// substep.
    pub softening: f32,
}

impl Attractor {
    /// A point with the gravitational parameter `strength`, m³/s², softened over 0.1 m.
    pub fn new(position: Vec3, strength: f32) -> Self {
        Self { position, strength, softening: 0.1 }
    }

    /// Whether every number is finite and the softening is not negative. An invalid attractor does not attract.
    pub fn is_valid(&self) -> bool {
        self.position.is_finite()
            && self.strength.is_finite()
            && self.softening.is_finite()
            && self.softening >= 0.0
    }

    /// The acceleration of particles at `d` from the point, m/s². Zero at the point itself.
    #[inline(always)]
    fn pull<N: Number>(&self, d: Vector<N>) -> Vector<N> {
        let squared = d.length_squared() + N::splat(self.softening * self.softening);
        let pull = d * (N::splat(-self.strength) / (squared * squared.sqrt()));
        // Without softening there is no direction at the point itself.
        let largest = pull.x.abs() + pull.y.abs() + pull.z.abs();
        pull.or_else(largest.lt(N::splat(f32::INFINITY)), Vector::splat(Vec3::ZERO))
    }
}

/// Adds gravity, which needs no mass (`f = m g`, so `a = g`), and the external force of each particle.
pub(crate) fn apply(particles: &mut Particles, forces: &Forces, instructions: InstructionSet) {
    particles.accelerate_all(forces.gravity);
    for number in 0..particles.column_summary.nonuniform.len() {
        let i = particles.column_summary.nonuniform[number] as usize;
        let w = particles.position[i].w;
        if w > 0.0 {
            // In addition to the gravity applied to all.
            let pull = forces.gravity * (particles.gravity_scale[i] - 1.0);
            particles.push_acceleration(i, pull + particles.external[i] * w);
        }
    }
    for attractor in forces.attractors.iter().filter(|attractor| attractor.is_valid()) {
        particles.acceleration_dirty = true;
        attract(particles, attractor, instructions);
    }
}

kernel!(
    fn attract<L: Lanes>(particles: &mut Particles, attractor: &Attractor) {
        let Particles { position, origin, gravity_scale, acceleration, .. } = particles;
        let eights = position.chunks(LANES).zip(origin.chunks(LANES));
        let eights = eights.zip(gravity_scale.chunks(LANES)).zip(acceleration.chunks_mut(LANES));
        for (((position, origin), scale), acceleration) in eights {
            let mut places = [Vec4::ZERO; LANES];
            for (((place, p), o), scale) in places.iter_mut().zip(position).zip(origin).zip(scale) {
                let d = (*o - attractor.position) + p.truncate();
                *place = d.extend(if p.w > 0.0 { *scale } else { 0.0 });
            }
            let (d, scale) = Vector::<L>::of(L::run(&places, 0));
            L::put_run(&mut places, 0, (attractor.pull(d) * scale).with(L::zero()));
            for (acceleration, pull) in acceleration.iter_mut().zip(places) {
                *acceleration += pull;
            }
        }
    }
);

/// Magnitude of the gravity on each row in a step, m/s². Contacts take for resting what approaches no faster than it accelerates a row in some substeps.
#[derive(Debug, Default)]
pub(crate) struct RowGravity {
    /// On every row that is not listed.
    uniform: f32,
    /// On each row, none on pinned ones; empty where it is the same on all others.
    rows: Vec<f32>,
}

/// Keeps the memory of the list in [`clone_from`](Clone::clone_from), which is called once a step.
impl Clone for RowGravity {
    fn clone(&self) -> Self {
        Self { uniform: self.uniform, rows: self.rows.clone() }
    }

    fn clone_from(&mut self, other: &Self) {
        self.uniform = other.uniform;
        self.rows.clone_from(&other.rows);
    }
}

impl RowGravity {
    /// Sets it for a step. To be called after the particles are [revalidated](Particles::revalidate).
    pub(crate) fn update(&mut self, particles: &Particles, forces: &Forces) {
        self.uniform = forces.gravity.length();
        self.rows.clear();
        let attractors = || forces.attractors.iter().filter(|attractor| attractor.is_valid());
        let nonuniform = &particles.column_summary.nonuniform;
        let scaled = nonuniform.iter().any(|&row| particles.gravity_scale[row as usize] != 1.0);
        if !scaled && attractors().next().is_none() {
            return;
        }
        self.rows.extend((0..particles.len()).map(|i| {
            if particles.position[i].w == 0.0 {
                return 0.0;
            }
            let pull = |attractor: &Attractor| {
                let d =
                    (particles.origin[i] - attractor.position) + particles.position[i].truncate();
                Vec3::from(attractor.pull(Vector::<f32>::splat(d)))
            };
            let all = attractors().fold(forces.gravity, |sum, attractor| sum + pull(attractor));
            all.length() * particles.gravity_scale[i].abs()
        }));
    }

    /// On a row.
    #[inline]
    pub(crate) fn of(&self, row: u32) -> f32 {
        self.rows.get(row as usize).copied().unwrap_or(self.uniform)
    }

    /// The greatest on some rows.
    #[inline]
    pub(crate) fn greatest(&self, rows: impl IntoIterator<Item = u32>) -> f32 {
        if self.rows.is_empty() {
            return self.uniform;
        }
        rows.into_iter().map(|row| self.of(row)).fold(0.0, f32::max)
    }

    /// The greater one of each of eight pairs.
    #[inline(always)]
    pub(crate) fn of_pairs(&self, a: &[u32; LANES], b: &[u32; LANES]) -> LaneArray {
        if self.rows.is_empty() {
            return [self.uniform; LANES];
        }
        core::array::from_fn(|lane| self.of(a[lane]).max(self.of(b[lane])))
    }
}

#[cfg(test)]
impl From<f32> for RowGravity {
    fn from(uniform: f32) -> Self {
        Self { uniform, rows: Vec::new() }
    }
}

/// Potential energy of particle `i` of mass `m` (kg) in both fields, J: `-m g·x - m Σ GM/√(r² + ε²)`.
pub(crate) fn energy(particles: &Particles, forces: &Forces, i: usize, m: f64) -> f64 {
    let x = particles.origin[i].as_dvec3() + particles.position[i].truncate().as_dvec3();
    let well = |attractor: &Attractor| {
        let d: DVec3 = x - attractor.position.as_dvec3();
        let softening = f64::from(attractor.softening);
        let distance = (d.length_squared() + softening * softening).sqrt();
        if distance > 0.0 { f64::from(attractor.strength) / distance } else { 0.0 }
    };
    let valid = forces.attractors.iter().filter(|attractor| attractor.is_valid());
    let potential = forces.gravity.as_dvec3().dot(x) + valid.map(well).sum::<f64>();
    -m * f64::from(particles.gravity_scale[i]) * potential
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::ParticleSeed;
    use crate::simulation::Simulation;

    const GM: f32 = 200.0;

    /// A particle at 5 m from a point far from the origin, launched sideways at the given share of the speed of a circular orbit.
    fn orbit(share: f32, centre: Vec3) -> Simulation {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::ZERO;
        world.settings.substeps = 8;
        world.forces.attractors.push(Attractor { position: centre, strength: GM, softening: 0.0 });
        let speed = (GM / 5.0_f32).sqrt() * share;
        let seed = ParticleSeed::at(centre + Vec3::X * 5.0).with_velocity(Vec3::Z * speed);
        world.particles.push(seed.with_mass(3.0)).unwrap();
        world
    }

    #[test]
    fn a_circular_orbit_has_keplers_period() {
        for centre in [Vec3::ZERO, Vec3::new(8000.0, 0.0, 0.0)] {
            let mut world = orbit(1.0, centre);
            // Ten orbits, each ending where z becomes positive again.
            let (mut turns, mut t, mut last) = (0, 0.0_f64, 0.0_f32);
            while turns < 10 && t < 60.0 {
                world.step(1.0 / 60.0).unwrap();
                t += 1.0 / 60.0;
                let now = world.particles.relative_to(0, centre).z;
                if last < 0.0 && now >= 0.0 {
                    turns += 1;
                    if turns == 10 {
                        t -= f64::from(now / (now - last)) / 60.0;
                    }
                }
                last = now;
            }
            let exact = core::f64::consts::TAU * (125.0 / f64::from(GM)).sqrt();
            let period = t / 10.0;
            assert!((period / exact - 1.0).abs() < 1e-4, "{period} s of {exact}");
        }
    }

    #[test]
    fn an_eccentric_orbit_keeps_its_energy_and_its_angular_momentum() {
        let mut world = orbit(0.6, Vec3::ZERO);
        let start = world.ledger();
        assert!(start.gravitational < 0.0 && start.energy() < 0.0, "it is bound: {start:?}");
        for _ in 0..60 * 60 {
            world.step(1.0 / 60.0).unwrap();
            let now = world.ledger();
            let drift = (now.energy() - start.energy()).abs() / start.energy().abs();
            assert!(drift < 2e-3, "{drift}");
            assert!(
                (now.angular_momentum - start.angular_momentum).length()
                    < 1e-3 * start.angular_momentum.length()
            );
        }
    }

    #[test]
    fn a_gravity_scale_scales_attractors_too_and_none_pulls_at_its_own_place() {
        let mut particles = Particles::default();
        for (at, scale) in [(Vec3::X, 1.0), (Vec3::X, 0.5), (Vec3::ZERO, 1.0)] {
            let seed = ParticleSeed { gravity_scale: scale, ..ParticleSeed::at(at) };
            particles.push(seed).unwrap();
        }
        let attractor = Attractor { position: Vec3::ZERO, strength: 2.0, softening: 0.0 };
        let broken = Attractor { softening: -1.0, ..attractor };
        let forces = Forces {
            gravity: Vec3::ZERO,
            attractors: vec![attractor, broken, Attractor::new(Vec3::NAN, 1.0)],
            ..Forces::default()
        };
        apply(&mut particles, &forces, InstructionSet::best());
        let found = [0, 1, 2].map(|i| particles.acceleration(i));
        assert_eq!(found, [Vec3::X * -2.0, -Vec3::X, Vec3::ZERO]);
        assert_eq!(energy(&particles, &forces, 1, 4.0), -4.0);
        assert!(energy(&particles, &forces, 2, 4.0).is_finite());
    }

    #[test]
    fn an_attractor_pulls_with_the_same_bits_whatever_the_instructions() {
        let mut particles = Particles::default();
        for i in 0..29 {
            let at = Vec3::new(i as f32 * 0.77, (i % 5) as f32 * 3.1, (i % 7) as f32 * -2.3);
            let seed = ParticleSeed { gravity_scale: 0.5 + (i % 3) as f32, ..ParticleSeed::at(at) };
            particles.push(if i % 6 == 5 { seed.pinned() } else { seed }).unwrap();
        }
        particles.set_position(3, Vec3::NAN);
        let attractor = Attractor { position: Vec3::ZERO, strength: 7.0, softening: 0.0 };
        let forces = Forces { attractors: vec![attractor], ..Forces::default() };
        let mut pulled = |set| {
            particles.clear_sums(0.0);
            apply(&mut particles, &forces, set);
            particles.acceleration.clone()
        };
        let found = pulled(InstructionSet::Scalar);
        assert!(found == pulled(InstructionSet::Simd128) && found == pulled(InstructionSet::Avx2));
        assert!(found.iter().all(|a| a.is_finite() && a.w == 0.0));
        for i in (0..29).filter(|&i| i != 3) {
            let d = particles.position(i);
            let scale = if i % 6 == 5 { 0.0 } else { 0.5 + (i % 3) as f32 };
            let pull = d * (-7.0 * scale / (d.length_squared() * d.length()).max(1e-30));
            let rest = forces.gravity * scale;
            let expected = if i == 0 { rest } else { rest + pull };
            assert!(
                (particles.acceleration(i) - expected).length() < 1e-5 * (1.0 + expected.length()),
                "{i}"
            );
        }
    }
}
