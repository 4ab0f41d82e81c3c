//! What a particle is added with, and why it may be refused.

use glam::Vec3;

/// Properties and state of a particle to be added. Everything has a default except the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleSeed {
    /// Position, metres.
    pub position: Vec3,
    /// What `position` leaves out because `f32` has no digits for it there, metres; default zero. Far from the origin pass what
    /// [`Particles::remainder`](super::Particles::remainder) returned, so that a restored particle continues from exactly where it was.
    pub remainder: Vec3,
    /// Velocity, m/s. Default zero.
    pub velocity: Vec3,
    /// Length in seconds of the substep over which `velocity` is the mean; 0 (the default) for a velocity that is true now.
    pub lag: f32,
    /// Mass in kilograms, positive; default 1. Infinity pins the particle where it is.
    pub mass: f32,
    /// Radius in metres, used by contacts and buoyancy; default 0.
    pub radius: f32,
    /// Electric charge in coulombs; default 0.
    pub charge: f32,
    /// Fraction of the velocity lost per second, 0 to 1 (the lectures' drag factor); default 0.
    pub drag: f32,
    /// Multiple of the world's gravity that acts on it; default 1. With zero it floats, with a negative value it rises.
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

    /// Sets the velocity, m/s, true at this instant.
    pub fn with_velocity(self, velocity: Vec3) -> Self {
        Self { velocity, lag: 0.0, ..self }
    }

    /// Sets the mass, kg.
    pub fn with_mass(self, mass: f32) -> Self {
        Self { mass, ..self }
    }

    /// Sets the radius, m.
    pub fn with_radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// Sets the charge, C.
    pub fn with_charge(self, charge: f32) -> Self {
        Self { charge, ..self }
    }

    /// Sets the drag, the fraction of the velocity lost per second.
    pub fn with_drag(self, drag: f32) -> Self {
        Self { drag, ..self }
    }

    /// Pins it where it is (infinite mass).
    pub fn pinned(self) -> Self {
        Self { mass: f32::INFINITY, ..self }
    }

    /// Why this particle cannot be simulated, or `None` if it can. Checked by [`Particles::push`](super::Particles::push) and
    /// [`Particles::set`](super::Particles::set), so that no phase needs to.
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

/// Why a particle is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParticleFault {
    /// The position or the remainder is NaN or infinite.
    #[error("its position is not finite")]
    Position,
    /// The velocity or the lag is NaN or infinite, or the lag is negative.
    #[error("its velocity is not finite")]
    Velocity,
    /// The mass is NaN, zero or negative (or so small that its inverse overflows).
    #[error("its mass is not a positive number of kilograms")]
    Mass,
    /// The radius is NaN, infinite or negative.
    #[error("its radius is not a finite length")]
    Radius,
    /// The charge is NaN or infinite.
    #[error("its charge is not finite")]
    Charge,
    /// The drag is NaN or outside 0..=1.
    #[error("its drag is not a share between 0 and 1 per second")]
    Drag,
    /// The gravity scale is NaN or infinite.
    #[error("the scale of gravity on it is not finite")]
    GravityScale,
    /// The external force is NaN or infinite.
    #[error("the external force on it is not finite")]
    Force,
}
