//! Forces: what accelerates particles. They all add up (physics.md F1–F7); each file holds one law, its derivation and its test.
//!
//! A force law reads positions and velocities at the start of a substep and adds to [`Particles::acceleration`]. Nothing else moves
//! because of a force; what must hold exactly is a [constraint](crate::constraints) instead.

mod buoyancy;
mod electric;
mod spring;
mod wind;

pub use buoyancy::Fluid;
pub use electric::Electric;
pub use spring::{Spring, SpringFault};
pub use wind::Wind;

pub(crate) use buoyancy::apply as apply_buoyancy;
pub(crate) use electric::{apply as apply_electric, energy as electric_energy};
pub(crate) use spring::apply as apply_springs;
pub(crate) use wind::{apply as apply_wind, sample as sample_wind};

use glam::Vec3;

use crate::particles::{Particles, rate_of_drag};

/// The force laws of a simulation and what they act on.
#[derive(Clone, Debug)]
pub struct Forces {
    /// Gravitational acceleration, m/s². Default `(0, -9.81, 0)`.
    pub gravity: Vec3,
    /// Damping of everything by the air, as the share of velocity lost per second (the lectures' drag), 0 to 1. Default 0.
    pub drag: f32,
    /// Springs between pairs of particles.
    pub springs: Vec<Spring>,
    /// Triangles of particles on which wind presses.
    pub surfaces: Vec<[u32; 3]>,
    /// Winds that blow everywhere.
    pub winds: Vec<Wind>,
    /// Fluids that loose particles float in.
    pub fluids: Vec<Fluid>,
    /// How charges attract and repel.
    pub electric: Electric,
}

impl Default for Forces {
    fn default() -> Self {
        Self {
            gravity: Vec3::new(0.0, -9.81, 0.0),
            drag: 0.0,
            springs: Vec::new(),
            surfaces: Vec::new(),
            winds: Vec::new(),
            fluids: Vec::new(),
            electric: Electric::default(),
        }
    }
}

/// Starts the sums of a substep afresh: no acceleration, and the damping of the air alone.
pub(crate) fn reset(particles: &mut Particles, forces: &Forces) {
    particles.acceleration.fill(Vec3::ZERO);
    let air = rate_of_drag(forces.drag.clamp(0.0, 1.0));
    particles.medium.fill(if air.is_nan() { 0.0 } else { air });
}

/// Adds gravity, which needs no mass (`f = m g`, so `a = g`), and the game's own forces.
pub(crate) fn apply_gravity_and_external(particles: &mut Particles, forces: &Forces) {
    for i in 0..particles.len() {
        let w = particles.position[i].w;
        if w > 0.0 {
            particles.acceleration[i] += forces.gravity + particles.external[i] * w;
        }
    }
}
