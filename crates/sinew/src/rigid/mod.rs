//! Explicit rigid bodies: orientation and angular velocity are state and are integrated, instead of following from particles (physics.md M1). They cost less
//! where nothing bends, and are the reference for compounds of particles; a compound becomes one and back at any time (`swap.rs`, physics.md M2).
//!
//! # The equations
//!
//! With the barycentre `p`, its velocity `v`, the rotation `R` from the body's frame to the world, the inertia `I` in the body's frame and the angular momentum
//! about the barycentre `L = R I Rᵀ ω`, a force `F` and a torque `τ` about the barycentre give
//!
//! ```text
//! ṗ = v        m v̇ = F        Ṙ = [ω] R        L̇ = τ
//! ```
//!
//! Without a torque `L` is constant in the world, but `ω` is not: it changes as `R I Rᵀ` turns, which is the cause of all wobble and flips. So the good
//! integrators keep `(R, L)` as state, and turn `R` such that the energy `½ ω·L` is preserved:
//!
//! | [`RigidIntegrator`] | order | energy | angular momentum | file |
//! |---|---|---|---|---|
//! | `Euler` | 1 | drifts | drifts | `euler.rs` |
//! | `Leapfrog` | 2 | bounded error, no drift | kept | `leapfrog.rs` |
//! | `Verlet` | 2 | bounded error, no drift | kept | `verlet.rs` |
//!
//! The barycentre is integrated by the method of the same name: Euler updates the velocity first, then the position; the other two follow a parabola exactly.
//!
//! # Precision
//!
//! A step is computed in `f64` and rounded to `f32`. Positions are relative to an `origin` in whole metres that follows the body, as those of the
//! [particles](crate::particles) are, so that a body at 5 km moves bit for bit as it does at zero. "Kept" above means up to that rounding, a random 1e-7 of the
//! value in each step.

mod compound;
mod euler;
mod leapfrog;
mod principal;
mod step;
mod swap;
#[cfg(test)]
mod swap_tests;
#[cfg(test)]
mod tests;
mod verlet;

pub use compound::Compound;
pub(crate) use compound::CompoundBodies;
pub use step::RigidIntegrator;

use glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};

use crate::pose::Pose;
use principal::Principal;

/// A rigid body: state, mass and inertia. All fields belong to the same instant and may be edited freely; [`fault`](Self::fault) checks them.
///
/// Every position that a method takes or returns is in metres from [`origin`](Self::origin), with the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidBody {
    /// What `position` is relative to, whole metres (a fraction is allowed, but then a scene moved by it is not moved exactly). Each step updates it as the
    /// body moves. Default zero.
    pub origin: Vec3,
    /// The barycentre, metres from `origin`. Default zero.
    pub position: Vec3,
    /// Rotation of the body's frame; normalised before use. Default the identity.
    pub rotation: Quat,
    /// Velocity of the barycentre, m/s. Default zero.
    pub velocity: Vec3,
    /// Angular velocity in the axes of the world, rad/s. Default zero.
    pub angular_velocity: Vec3,
    /// Mass, kg, positive and finite. Default 1.
    pub mass: f32,
    /// Inertia tensor about the barycentre in the axes of the body's frame, kg·m²: symmetric, not negative. Default that of a solid cube of 1 m and 1 kg. A
    /// principal moment below a millionth of the greatest counts as zero: about such an axis (all mass within 1/1000 of the length) the body cannot spin.
    pub inertia: Mat3,
    /// The barycentre in the body's frame, metres: the drawn model need not be centred on it. Default zero.
    pub centre: Vec3,
}

/// Why a rigid body, or an operation on it, is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RigidFault {
    /// Position, origin or centre is NaN or infinite.
    #[error("its position is not finite")]
    Position,
    /// The rotation is NaN, infinite or zero.
    #[error("its rotation is not a rotation")]
    Rotation,
    /// Velocity or angular velocity is NaN or infinite.
    #[error("its velocity is not finite")]
    Velocity,
    /// The mass is NaN, infinite, zero, negative, or so small that its inverse is not finite.
    #[error("its mass is not a positive number of kilograms")]
    Mass,
    /// The inertia is NaN, infinite, not symmetric, or has a negative moment.
    #[error("its inertia is not that of a body")]
    Inertia,
    /// A force, a torque or a step is NaN or infinite, or leads to values outside `f32`.
    #[error("the step does not lead to finite numbers")]
    Step,
    /// A swap with different numbers of rest positions and particles, or with particles of which none has a finite mass.
    #[error("its particles do not make a rigid body")]
    Particles,
}

impl Default for RigidBody {
    fn default() -> Self {
        Self::new(1.0, Mat3::from_diagonal(Vec3::splat(1.0 / 6.0)))
    }
}

impl RigidBody {
    /// A body at rest at the origin: mass in kg, inertia about the barycentre in its own frame in kg·m².
    pub fn new(mass: f32, inertia: Mat3) -> Self {
        Self {
            origin: Vec3::ZERO,
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            mass,
            inertia,
            centre: Vec3::ZERO,
        }
    }

    /// A solid box at rest, centred on the origin: edges along its axes in metres, mass in kg. `I = m/12 (b² + c²)`.
    pub fn solid_box(size: Vec3, mass: f32) -> Self {
        let s = size * size;
        let moments = Vec3::new(s.y + s.z, s.z + s.x, s.x + s.y) * (mass / 12.0);
        Self::new(mass, Mat3::from_diagonal(moments))
    }

    /// The first fault, in the order of [`RigidFault`]. Checked at every step.
    pub fn fault(&self) -> Option<RigidFault> {
        self.principal().err()
    }

    /// Pose of the body's frame: the transform to draw with, its translation in metres from `origin`.
    pub fn pose(&self) -> Pose {
        let shift = self.turn() * self.centre.as_dvec3();
        let translation = (self.position.as_dvec3() - shift).as_vec3();
        Pose { translation, rotation: self.turn().as_quat() }
    }

    /// A position in metres from `origin` in world coordinates: the nearest `f32` and the remainder, as a [particle's seed](crate::ParticleSeed::remainder)
    /// takes them.
    pub fn world(&self, place: Vec3) -> (Vec3, Vec3) {
        let exact = self.origin.as_dvec3() + place.as_dvec3();
        let near = exact.as_vec3();
        (near, (exact - near.as_dvec3()).as_vec3())
    }

    /// `m v`, kg·m/s.
    pub fn momentum(&self) -> DVec3 {
        self.velocity.as_dvec3() * f64::from(self.mass)
    }

    /// Angular momentum about the barycentre, `R I Rᵀ ω`, kg·m²/s, in the axes of the world.
    pub fn angular_momentum(&self) -> DVec3 {
        self.world_inertia() * self.angular_velocity.as_dvec3()
    }

    /// Angular momentum about the world's zero, kg·m²/s: that about the barycentre and `x × m v`.
    pub fn angular_momentum_about_zero(&self) -> DVec3 {
        let place = self.origin.as_dvec3() + self.position.as_dvec3();
        self.angular_momentum() + place.cross(self.momentum())
    }

    /// `½ m v² + ½ ω·L`, J.
    pub fn kinetic_energy(&self) -> f64 {
        let turning = self.angular_velocity.as_dvec3().dot(self.angular_momentum());
        0.5 * (self.velocity.as_dvec3().dot(self.momentum()) + turning)
    }

    /// Inertia about the barycentre in the axes of the world, `R I Rᵀ`, kg·m².
    pub fn world_inertia(&self) -> DMat3 {
        let turn = DMat3::from_quat(self.turn());
        turn * self.inertia.as_dmat3() * turn.transpose()
    }

    /// Velocity of the body's matter at `point`, m/s: `v + ω × (point - p)`.
    ///
    /// ```
    /// use sinew::RigidBody;
    /// use sinew::glam::{Mat3, Vec3};
    ///
    /// let mut wheel = RigidBody::new(1.0, Mat3::IDENTITY);
    /// wheel.position = Vec3::Y;
    /// wheel.velocity = Vec3::X;
    /// wheel.angular_velocity = Vec3::NEG_Z;
    /// // Its radius is 1, and it rolls: the point that touches the ground is at rest.
    /// assert_eq!(wheel.point_velocity(Vec3::ZERO), Vec3::ZERO);
    /// ```
    pub fn point_velocity(&self, point: Vec3) -> Vec3 {
        self.velocity + self.angular_velocity.cross(point - self.position)
    }

    /// Applies an impulse at the barycentre, N·s: the momentum changes by exactly that. A non-finite impulse, or one to a body with a fault, changes nothing;
    /// the same holds for the methods below.
    pub fn apply_impulse(&mut self, impulse: Vec3) {
        self.apply(impulse, DVec3::ZERO);
    }

    /// Applies an impulse, N·s, at `point`: `P += J`, `L += (point - p) × J`.
    pub fn apply_impulse_at(&mut self, impulse: Vec3, point: Vec3) {
        let arm = point.as_dvec3() - self.position.as_dvec3();
        self.apply(impulse, arm.cross(impulse.as_dvec3()));
    }

    /// Applies an angular impulse, N·m·s: the angular momentum changes by exactly that, except for components about axes without inertia.
    pub fn apply_angular_impulse(&mut self, impulse: Vec3) {
        self.apply(Vec3::ZERO, impulse.as_dvec3());
    }

    /// The torque about the barycentre, N·m, of a force in N at `point`, to be passed to [`step`](Self::step) with the force.
    pub fn torque_of(&self, force: Vec3, point: Vec3) -> Vec3 {
        (point - self.position).cross(force)
    }

    fn apply(&mut self, impulse: Vec3, turning: DVec3) {
        let Ok(principal) = self.principal() else { return };
        let turn = self.turn();
        let change = turn * principal.rate(turn.conjugate() * turning);
        let velocity = self.velocity + impulse / self.mass;
        let angular_velocity = (self.angular_velocity.as_dvec3() + change).as_vec3();
        if velocity.is_finite() && angular_velocity.is_finite() {
            (self.velocity, self.angular_velocity) = (velocity, angular_velocity);
        }
    }

    /// The rotation normalised; valid only for a body without a fault.
    fn turn(&self) -> DQuat {
        DQuat::from_array(self.rotation.to_array().map(f64::from)).normalize()
    }

    /// The principal axes, or the first fault.
    fn principal(&self) -> Result<Principal, RigidFault> {
        let places = [self.origin, self.position, self.centre];
        let length = self.rotation.to_array().map(f64::from).iter().map(|x| x * x).sum::<f64>();
        if !places.iter().all(|place| place.is_finite()) {
            Err(RigidFault::Position)
        } else if !(length.is_finite() && length > 0.0) {
            Err(RigidFault::Rotation)
        } else if !(self.velocity.is_finite() && self.angular_velocity.is_finite()) {
            Err(RigidFault::Velocity)
        } else if !(self.mass > 0.0 && self.mass.is_finite() && (1.0 / self.mass).is_finite()) {
            Err(RigidFault::Mass)
        } else {
            Principal::new(self.inertia.as_dmat3()).ok_or(RigidFault::Inertia)
        }
    }
}
