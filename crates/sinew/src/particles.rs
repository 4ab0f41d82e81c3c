//! The particles as columns: one array per quantity, so that a phase touches only what it needs.
//!
//! Memory layout of one particle, hot columns first:
//!
//! ```text
//! position      [x y z w]   16 B   metres; w = inverse mass, 1/kg: what a constraint reads and writes
//! start         [x y z -]   16 B   position at the start of the substep
//! velocity      [x y z l]   16 B   mean velocity of the last substep, m/s; l = its length, s (see below)
//! acceleration  [x y z -]   16 B   sum of the forces so far this substep, times the inverse mass, m/s²
//! external      [x y z]     12 B   the game's own force on the particle, N
//! radius, charge, damping   12 B   m, C, 1/s
//! medium                     4 B   damping that a fluid adds this substep, 1/s
//! ```
//!
//! # Why the previous position is kept as a velocity
//!
//! Verlet's state is `(p, p_old)`. This crate keeps the same state as `(p, v, l)` with `v = (p - p_old) / l`, where `l`
//! is the length of the substep that led from `p_old` to `p`. Nothing is lost, and three things are gained:
//!
//! - **Round-off.** In `f32` the difference of two positions 5 m from the origin is good to 5e-7 m, which is 7 % of what
//!   gravity adds in a substep of 1/1200 s. The velocity keeps its own 24 bits wherever the particle is.
//! - **The start.** A particle that is given a velocity has `l = 0`: its velocity is true *now*, not half a step ago. The
//!   time-corrected formula of [`integrate`](crate::integrate) then starts it on the exact parabola.
//! - **Step changes.** `l` travels with the particle, so the step may change at any tick, for any particle.

use glam::{Vec3, Vec4};

/// What a particle is when it is added. Everything has a default except the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleSeed {
    /// Where it is, metres.
    pub position: Vec3,
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
}

impl ParticleSeed {
    /// A particle of 1 kg at rest at `position` (metres).
    pub fn at(position: Vec3) -> Self {
        Self {
            position,
            velocity: Vec3::ZERO,
            lag: 0.0,
            mass: 1.0,
            radius: 0.0,
            charge: 0.0,
            drag: 0.0,
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

    /// Why this particle cannot be simulated, or `None` if it can. Checked at the door ([`Particles::push`],
    /// [`Particles::set`]), so that no phase needs to.
    pub fn fault(&self) -> Option<ParticleFault> {
        if !self.position.is_finite() {
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
    /// The game's force on it is NaN or infinite.
    #[error("the external force on it is not finite")]
    Force,
}

/// All particles of a simulation, in columns. Rows are numbered from 0 in the order of [`push`](Self::push).
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// `[x y z w]`: position in metres and inverse mass in 1/kg. The kernels of the constraints work on this alone.
    pub(crate) position: Vec<Vec4>,
    pub(crate) start: Vec<Vec3>,
    /// `[x y z l]`: mean velocity of the last substep in m/s, and that substep's length in seconds.
    pub(crate) velocity: Vec<Vec4>,
    pub(crate) acceleration: Vec<Vec3>,
    pub(crate) external: Vec<Vec3>,
    pub(crate) radius: Vec<f32>,
    pub(crate) charge: Vec<f32>,
    pub(crate) damping: Vec<f32>,
    pub(crate) medium: Vec<f32>,
}

impl Particles {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Removes all particles and keeps the memory.
    pub fn clear(&mut self) {
        self.resize(0);
    }

    /// Adds a particle and returns its row.
    ///
    /// # Errors
    /// A seed with a [fault](ParticleSeed::fault) is refused and nothing changes.
    pub fn push(&mut self, seed: ParticleSeed) -> Result<u32, ParticleFault> {
        if let Some(fault) = seed.fault() {
            return Err(fault);
        }
        let row = self.len();
        self.resize(row + 1);
        self.write(row, &seed);
        Ok(row as u32)
    }

    /// Overwrites row `i` and clears its external force.
    ///
    /// # Errors
    /// A seed with a [fault](ParticleSeed::fault) is refused and nothing changes.
    ///
    /// # Panics
    /// If there is no row `i`.
    pub fn set(&mut self, i: usize, seed: ParticleSeed) -> Result<(), ParticleFault> {
        if let Some(fault) = seed.fault() {
            return Err(fault);
        }
        self.write(i, &seed);
        self.external[i] = Vec3::ZERO;
        Ok(())
    }

    /// Makes room for exactly `len` particles. New rows are particles at the origin with infinite mass, which nothing moves.
    pub fn resize(&mut self, len: usize) {
        self.position.resize(len, Vec4::ZERO);
        self.start.resize(len, Vec3::ZERO);
        self.velocity.resize(len, Vec4::ZERO);
        self.acceleration.resize(len, Vec3::ZERO);
        self.external.resize(len, Vec3::ZERO);
        self.radius.resize(len, 0.0);
        self.charge.resize(len, 0.0);
        self.damping.resize(len, 0.0);
        self.medium.resize(len, 0.0);
    }

    /// Position of particle `i`, metres.
    pub fn position(&self, i: usize) -> Vec3 {
        self.position[i].truncate()
    }

    /// Moves particle `i` to a point, in metres, without touching its velocity: a teleport, or (between the phases
    /// `integrate` and `solve_constraints`) a positional constraint of the caller's own.
    pub fn set_position(&mut self, i: usize, position: Vec3) {
        self.position[i] = position.extend(self.position[i].w);
    }

    /// Position of particle `i` at the start of the current substep, metres.
    pub fn start(&self, i: usize) -> Vec3 {
        self.start[i]
    }

    /// Mean velocity of particle `i` over the last substep, m/s. It is true half a substep ago:
    /// [`Simulation::velocity_now`](crate::Simulation::velocity_now) gives it at the instant of the position.
    pub fn velocity(&self, i: usize) -> Vec3 {
        self.velocity[i].truncate()
    }

    /// Length in seconds of the substep over which [`velocity`](Self::velocity) is the mean; 0 for a velocity that was set.
    pub fn lag(&self, i: usize) -> f32 {
        self.velocity[i].w
    }

    /// Sets the velocity of particle `i`, m/s, true at this instant.
    pub fn set_velocity(&mut self, i: usize, velocity: Vec3) {
        self.velocity[i] = velocity.extend(0.0);
    }

    /// Adds an impulse, N·s: the momentum of the particle changes by exactly that. Pinned particles do not notice.
    pub fn add_impulse(&mut self, i: usize, impulse: Vec3) {
        let change = impulse * self.position[i].w;
        self.velocity[i] += change.extend(0.0);
    }

    /// Inverse mass of particle `i`, 1/kg; 0 if it is pinned.
    pub fn inverse_mass(&self, i: usize) -> f32 {
        self.position[i].w
    }

    /// Mass of particle `i`, kg; infinite if it is pinned.
    pub fn mass(&self, i: usize) -> f32 {
        1.0 / self.position[i].w
    }

    /// Radius of particle `i`, metres.
    pub fn radius(&self, i: usize) -> f32 {
        self.radius[i]
    }

    /// Electric charge of particle `i`, coulombs.
    pub fn charge(&self, i: usize) -> f32 {
        self.charge[i]
    }

    /// Acceleration of particle `i` as summed up so far in this substep, m/s².
    pub fn acceleration(&self, i: usize) -> Vec3 {
        self.acceleration[i]
    }

    /// Adds a force, N, for this substep: for force laws of the caller's own, between `accumulate_forces` and `integrate`.
    /// Forces add up; pinned particles do not notice.
    pub fn add_force(&mut self, i: usize, force: Vec3) {
        self.acceleration[i] += force * self.position[i].w;
    }

    /// Adds an acceleration, m/s², for this substep: a force that is proportional to mass, as gravity is.
    pub fn add_acceleration(&mut self, i: usize, acceleration: Vec3) {
        self.acceleration[i] += acceleration;
    }

    /// Sets the external force on particle `i`, N, which acts in every substep until it is set again.
    pub fn set_external_force(&mut self, i: usize, force: Vec3) {
        self.external[i] = force;
    }

    /// Whether row `i` holds only finite numbers.
    pub fn is_finite(&self, i: usize) -> bool {
        self.position[i].is_finite() && self.velocity[i].is_finite()
    }

    /// Row `i` as it would be added again: the state that a caller must save to restore the particle.
    pub fn seed(&self, i: usize) -> ParticleSeed {
        ParticleSeed {
            position: self.position(i),
            velocity: self.velocity(i),
            lag: self.lag(i),
            mass: self.mass(i),
            radius: self.radius[i],
            charge: self.charge[i],
            drag: drag_of_rate(self.damping[i]),
        }
    }

    fn write(&mut self, i: usize, seed: &ParticleSeed) {
        self.position[i] = seed.position.extend(1.0 / seed.mass);
        self.start[i] = seed.position;
        self.velocity[i] = seed.velocity.extend(seed.lag);
        self.radius[i] = seed.radius;
        self.charge[i] = seed.charge;
        // Most particles have none, and a logarithm each tick would be the dearest part of a row.
        self.damping[i] = if seed.drag > 0.0 { rate_of_drag(seed.drag) } else { 0.0 };
    }
}

/// The damping rate λ in 1/s with `(1 - drag)^t = e^(-λ t)`: rates of several media add up, shares do not.
/// A drag of 1 gives infinity: all velocity is forgotten in every step (the lectures' statics).
pub fn rate_of_drag(drag: f32) -> f32 {
    -libm::log1pf(-drag)
}

/// The share of the velocity lost per second at the damping rate `rate` (1/s): the inverse of [`rate_of_drag`].
pub fn drag_of_rate(rate: f32) -> f32 {
    -libm::expm1f(-rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_faulty_seed_is_refused_and_changes_nothing() {
        let good = ParticleSeed::at(Vec3::X);
        let bad = [
            (ParticleSeed::at(Vec3::NAN), ParticleFault::Position),
            (good.with_velocity(Vec3::INFINITY), ParticleFault::Velocity),
            (good.with_mass(-1.0), ParticleFault::Mass),
            (good.with_mass(0.0), ParticleFault::Mass),
            (good.with_mass(f32::NAN), ParticleFault::Mass),
            (good.with_mass(1e-45), ParticleFault::Mass),
            (good.with_radius(-0.1), ParticleFault::Radius),
            (good.with_charge(f32::NAN), ParticleFault::Charge),
            (good.with_drag(1.5), ParticleFault::Drag),
        ];
        let mut particles = Particles::default();
        for (seed, fault) in bad {
            assert_eq!(particles.push(seed), Err(fault), "{seed:?}");
        }
        assert!(particles.is_empty());
        assert_eq!(particles.push(good), Ok(0));
        assert_eq!(particles.set(0, bad[0].0), Err(ParticleFault::Position));
        assert_eq!(particles.seed(0), good);
    }

    #[test]
    fn an_impulse_changes_momentum_by_exactly_itself() {
        let mut particles = Particles::default();
        particles.push(ParticleSeed::at(Vec3::ZERO).with_mass(4.0)).unwrap();
        particles.push(ParticleSeed::at(Vec3::ZERO).pinned()).unwrap();
        let impulse = Vec3::new(2.0, -1.0, 0.5);
        particles.add_impulse(0, impulse);
        particles.add_impulse(1, impulse);
        assert_eq!(particles.velocity(0) * 4.0, impulse);
        assert_eq!(particles.velocity(1), Vec3::ZERO);
    }

    #[test]
    fn drag_and_rate_are_inverse() {
        for drag in [0.0, 0.015, 0.5, 0.99, 1.0] {
            assert!((drag_of_rate(rate_of_drag(drag)) - drag).abs() < 1e-6);
        }
    }
}
