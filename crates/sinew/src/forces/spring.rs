//! Springs: the lectures' soft connection, a force that grows with the stretch (physics.md F3).

use glam::Vec3;

use crate::particles::Particles;

/// A damped spring between two particles: a force during the sum of forces, where a
/// [`Distance`](crate::constraints::Distance) is a correction of positions.
///
/// Explicit integration holds up to `ω h < 2` with `ω = √(k/μ)`, `μ = 1/(w_a + w_b)`: a stiffer connection wants a compliant
/// distance, which is stable at any stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Row of the first particle.
    pub a: u32,
    /// Row of the second particle, another one than `a`.
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

    /// Potential energy `½ k (‖d‖ - L)²`, joules; none if the spring is at fault.
    pub fn energy(&self, particles: &Particles) -> f32 {
        if self.fault(particles.len()).is_some() {
            return 0.0;
        }
        let d = particles.separation(self.a as usize, self.b as usize);
        let stretch = d.length() - self.rest;
        0.5 * self.stiffness * stretch * stretch
    }
}

/// Adds `f_a = -(k (‖d‖ - L) + b (v·n)) n` and its opposite: the same vector with two signs, so that momentum is conserved exactly.
/// Ends that coincide have no direction and feel no force.
pub(crate) fn apply(particles: &mut Particles, springs: &[Spring]) {
    for spring in springs {
        // Whoever fills the list by hand may have named a row that is not there.
        if spring.fault(particles.len()).is_some() {
            continue;
        }
        let (a, b) = (spring.a as usize, spring.b as usize);
        let d = particles.separation(a, b);
        let length = d.length();
        let n = if length > 0.0 { d / length } else { Vec3::ZERO };
        let closing = (particles.velocity(a) - particles.velocity(b)).dot(n);
        let pull = spring.stiffness * (length - spring.rest) + spring.damping * closing;
        particles.add_force(a, n * -pull);
        particles.add_force(b, n * pull);
    }
}
