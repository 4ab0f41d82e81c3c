//! Springs: a force that grows with the stretch (physics.md F3).

use glam::{Vec3, Vec4};

use crate::lanes::{InstructionSet, LANES, Lanes, Vector, kernel};
use crate::particles::Particles;

/// A damped spring between two particles. It acts as a force, where a [`Distance`](crate::constraints::Distance) corrects positions.
///
/// Explicit integration is stable up to `ω h < 2` with `ω = √(k/μ)`, `μ = 1/(w_a + w_b)`. For stiffer connections use a compliant distance, which is stable at
/// any stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Row of the first particle.
    pub a: u32,
    /// Row of the second particle; must differ from `a`.
    pub b: u32,
    /// Length at which it exerts no force, metres.
    pub rest: f32,
    /// Stiffness k, N/m.
    pub stiffness: f32,
    /// Damping b, N·s/m, along the spring alone. Critical damping is `2√(k μ)`.
    pub damping: f32,
}

/// What is wrong with a spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpringFault {
    /// `a` and `b` are the same particle.
    #[error("both its ends are the same particle")]
    SameParticle,
    /// One of the ends is not a row of the simulation.
    #[error("one of its particles does not exist")]
    MissingParticle,
    /// NaN, infinite or negative rest length, stiffness or damping.
    #[error("its rest length, stiffness or damping is not a finite number, 0 or more")]
    Number,
}

impl Spring {
    /// Why this spring cannot act among `particles` rows, or `None` if it can.
    pub fn fault(&self, particles: usize) -> Option<SpringFault> {
        let numbers = [self.rest, self.stiffness, self.damping];
        if self.a == self.b {
            Some(SpringFault::SameParticle)
        } else if self.a.max(self.b) as usize >= particles {
            Some(SpringFault::MissingParticle)
        } else if numbers.iter().any(|x| !(x.is_finite() && *x >= 0.0)) {
            Some(SpringFault::Number)
        } else {
            None
        }
    }

    /// The force that pulls its ends together, `k (‖d‖ - L) + b (v·n)`, newtons; negative where it pushes. Zero if the spring is at fault, or its ends
    /// coincide.
    pub fn tension(&self, particles: &Particles) -> f32 {
        if self.fault(particles.len()).is_some() {
            return 0.0;
        }
        let (a, b) = (self.a as usize, self.b as usize);
        let d = particles.separation(a, b);
        let Some(n) = d.try_normalize() else { return 0.0 };
        let v = particles.velocity(a) - particles.velocity(b);
        self.stiffness * (d.length() - self.rest) + self.damping * v.dot(n)
    }

    /// Potential energy `½ k (‖d‖ - L)²`, joules; zero if the spring is at fault.
    pub fn energy(&self, particles: &Particles) -> f32 {
        if self.fault(particles.len()).is_some() {
            return 0.0;
        }
        let d = particles.separation(self.a as usize, self.b as usize);
        let stretch = d.length() - self.rest;
        0.5 * self.stiffness * stretch * stretch
    }
}

/// Adds `f_a = -(k (‖d‖ - L) + b (v·n)) n` to `a` and its opposite to `b`: the same vector with two signs, so momentum is conserved exactly. Coincident ends
/// have no direction and get no force.
pub(crate) fn apply(particles: &mut Particles, springs: &[Spring], instructions: InstructionSet) {
    if !springs.is_empty() {
        particles.acceleration_dirty = true;
        pull(particles, springs, instructions);
    }
}

kernel!(
    fn pull<L: Lanes>(particles: &mut Particles, springs: &[Spring]) {
        let len = particles.len();
        let Particles { position, origin, velocity, acceleration, .. } = particles;
        for eight in springs.chunks(LANES) {
            let mut separations = [Vec4::ZERO; LANES];
            let mut velocities = [Vec4::ZERO; LANES];
            let mut laws = [Vec4::ZERO; LANES];
            for (lane, spring) in eight.iter().enumerate() {
                // The list is public and not validated, so a row may be missing.
                let (a, b) = (spring.a as usize, spring.b as usize);
                if a == b || a >= len || b >= len {
                    continue;
                }
                separations[lane] = position[a] - position[b];
                // Particles that constraints connect share one origin.
                if origin[a] != origin[b] {
                    separations[lane] += (origin[a] - origin[b]).extend(0.0);
                }
                velocities[lane] = velocity[a] - velocity[b];
                laws[lane] = Vec4::new(spring.rest, spring.stiffness, spring.damping, 1.0);
            }
            let (d, _) = Vector::<L>::of(L::run(&separations, 0));
            let (v, _) = Vector::of(L::run(&velocities, 0));
            let [rest, stiffness, damping, there] = L::run(&laws, 0);
            // The other conditions of `Spring::fault`, for eight springs at once.
            let sound = there * in_range(rest) * in_range(stiffness) * in_range(damping);
            let length = d.length();
            let directed = L::zero().lt(length);
            let n = Vector::new(d.x / length, d.y / length, d.z / length);
            let n = n.or_else(directed, Vector::splat(Vec3::ZERO));
            let pull = stiffness * (length - rest) + damping * v.dot(n);
            let mut pulls = [Vec4::ZERO; LANES];
            L::put_run(&mut pulls, 0, (n * pull).with(sound));
            for (spring, pull) in eight.iter().zip(pulls) {
                if pull.w != 0.0 {
                    let (a, b, force) = (spring.a as usize, spring.b as usize, pull.with_w(0.0));
                    acceleration[a] -= force * position[a].w;
                    acceleration[b] += force * position[b].w;
                }
            }
        }
    }
);

/// One where a number is finite and 0 or more, zero elsewhere.
#[inline(always)]
fn in_range<L: Lanes>(x: L) -> L {
    L::zero().le(x).and(x.lt(L::splat(f32::INFINITY))).and(L::splat(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::ParticleSeed;
    use crate::test_random::Random;

    /// A few hundred random springs, some of them faulty, some of zero length, between particles with various origins.
    fn tangle() -> (Particles, Vec<Spring>) {
        let mut random = Random::new(3);
        let mut next = || random.fraction();
        let mut particles = Particles::default();
        for i in 0..60 {
            let place = Vec3::new(next(), next(), next()) * if i < 20 { 0.3 } else { 9.0 };
            let place = if i % 20 == 0 { Vec3::ONE } else { place };
            let seed = ParticleSeed::at(place).with_mass(0.1 + next());
            let seed = seed.with_velocity(Vec3::new(next(), next(), next()));
            particles.push(if i % 13 == 5 { seed.pinned() } else { seed }).unwrap();
        }
        let springs = (0..403).map(|i| Spring {
            a: (next() * 61.0) as u32,
            b: if i == 7 { 20 } else { (next() * 60.0) as u32 },
            rest: next(),
            stiffness: if i % 50 == 9 { f32::NAN } else { next() * 10.0 },
            damping: next(),
        });
        let mut springs: Vec<Spring> = springs.collect();
        springs[7].a = 0;
        (particles, springs)
    }

    #[test]
    fn springs_pull_as_the_law_says_one_after_the_other_with_any_instructions() {
        let (mut particles, springs) = tangle();
        let mut truth = vec![Vec3::ZERO; particles.len()];
        for spring in springs.iter().filter(|spring| spring.fault(60).is_none()) {
            let (a, b) = (spring.a as usize, spring.b as usize);
            let d = particles.separation(a, b);
            let n = if d.length() > 0.0 { d / d.length() } else { Vec3::ZERO };
            let closing = (particles.velocity(a) - particles.velocity(b)).dot(n);
            let pull = spring.stiffness * (d.length() - spring.rest) + spring.damping * closing;
            truth[a] -= n * pull * particles.inverse_mass(a);
            truth[b] += n * pull * particles.inverse_mass(b);
        }
        let mut pulled = |set| {
            particles.clear_sums(0.0);
            apply(&mut particles, &springs, set);
            particles.acceleration.clone()
        };
        let found = pulled(InstructionSet::Scalar);
        for (found, truth) in found.iter().zip(&truth) {
            assert!((found.truncate() - *truth).length() < 1e-4 * (1.0 + truth.length()));
            assert_eq!(found.w, 0.0);
        }
        assert!(found == pulled(InstructionSet::Simd128));
        assert!(found == pulled(InstructionSet::Avx2));
    }
}
