//! What a particle is when it is added, and what can be wrong with it.

use glam::Vec3;

/// What a particle is when it is added. Everything has a default except the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleSeed {
    /// Where it is, metres.
    pub position: Vec3,
    /// What `position` leaves out because `f32` has no digits for it there, metres; default zero. Far from the origin it is what
    /// [`Particles::remainder`](super::Particles::remainder) gave, so that a particle goes on exactly from where it was.
    pub remainder: Vec3,
    /// Its velocity, m/s. Default zero.
    pub velocity: Vec3,
    /// Length in seconds of the step over which `velocity` is the mean: 0 (the default) says that the velocity is true now.
    pub lag: f32,
    /// Mass in kilograms, positive; default 1. Infinity pins the particle where it is.
    pub mass: f32,
    /// Radius in metres, used by contacts and buoyancy; default 0.
    pub radius: f32,
    /// Electric charge in coulombs; default 0.
    pub charge: f32,
    /// Share of the velocity that is lost per second, 0 to 1 (the lectures' drag factor); default 0.
    pub drag: f32,
    /// How strongly gravity pulls on it, as a multiple of the world's; default 1. Zero floats, a negative one rises.
    pub gravity_scale: f32,
}

impl ParticleSeed {
    /// A particle of 1 kg at rest at `position` (metres).
    pub fn at(position: Vec3) -> Self {
        Self {
            position,
            remainder: Vec3::ZERO,
            velocity: Vec3::ZERO,
            lag: 0.0,
            mass: 1.0,
            radius: 0.0,
            charge: 0.0,
            drag: 0.0,
            gravity_scale: 1.0,
        }
    }

    /// The same with a velocity, m/s, true at this instant.
    pub fn with_velocity(self, velocity: Vec3) -> Self {
        Self { velocity, lag: 0.0, ..self }
    }

    /// The same with another mass, kg.
    pub fn with_mass(self, mass: f32) -> Self {
        Self { mass, ..self }
    }

    /// The same with a radius, m.
    pub fn with_radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// The same with a charge, C.
    pub fn with_charge(self, charge: f32) -> Self {
        Self { charge, ..self }
    }

    /// The same with a drag, share of the velocity lost per second.
    pub fn with_drag(self, drag: f32) -> Self {
        Self { drag, ..self }
    }

    /// The same, pinned where it is (infinite mass).
    pub fn pinned(self) -> Self {
        Self { mass: f32::INFINITY, ..self }
    }

    /// Why this particle cannot be simulated, or `None` if it can. Checked at the door ([`Particles::push`](super::Particles::push),
    /// [`Particles::set`](super::Particles::set)), so that no phase needs to.
    pub fn fault(&self) -> Option<ParticleFault> {
        if !(self.position.is_finite() && self.remainder.is_finite()) {
            Some(ParticleFault::Position)
        } else if !(self.velocity.is_finite() && self.lag.is_finite() && self.lag >= 0.0) {
            Some(ParticleFault::Velocity)
        } else if self.mass.is_nan() || self.mass <= 0.0 || 1.0 / self.mass == f32::INFINITY {
            Some(ParticleFault::Mass)
        } else if !(self.radius.is_finite() && self.radius >= 0.0) {
            Some(ParticleFault::Radius)
        } else if !self.charge.is_finite() {
            Some(ParticleFault::Charge)
        } else if !(0.0..=1.0).contains(&self.drag) {
            Some(ParticleFault::Drag)
        } else if !self.gravity_scale.is_finite() {
            Some(ParticleFault::GravityScale)
        } else {
            None
        }
    }
}

/// What is wrong with a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParticleFault {
    /// NaN or infinite.
    #[error("its position is not finite")]
    Position,
    /// NaN or infinite, or with a negative lag.
    #[error("its velocity is not finite")]
    Velocity,
    /// NaN, zero or negative (or so small that its inverse overflows).
    #[error("its mass is not a positive number of kilograms")]
    Mass,
    /// NaN, infinite or negative.
    #[error("its radius is not a finite length")]
    Radius,
    /// NaN or infinite.
    #[error("its charge is not finite")]
    Charge,
    /// NaN or outside 0..=1.
    #[error("its drag is not a share between 0 and 1 per second")]
    Drag,
    /// NaN or infinite.
    #[error("the scale of gravity on it is not finite")]
    GravityScale,
    /// The game's force on it is NaN or infinite.
    #[error("the external force on it is not finite")]
    Force,
}
