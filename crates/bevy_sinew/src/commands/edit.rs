//! What can be asked of a body, and why it is not done.

use bevy::prelude::*;

/// One change to a body, a rigid part or a particle: [`BodyCommandsExt`](super::BodyCommandsExt) says what each does. It is an `EntityCommand`.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Clone, PartialEq)]
#[non_exhaustive]
pub enum BodyEdit {
    /// A force at the barycentre for the next tick, N.
    Force(Vec3),
    /// A force, N, at a point of the world, metres, for the next tick.
    ForceAt(Vec3, Vec3),
    /// A torque for the next tick, N·m.
    Torque(Vec3),
    /// An impulse at the barycentre, N·s.
    Impulse(Vec3),
    /// An impulse, N·s, at a point of the world, metres.
    ImpulseAt(Vec3, Vec3),
    /// An angular impulse about the barycentre, N·m·s.
    AngularImpulse(Vec3),
    /// The velocity of the barycentre, m/s.
    LinearVelocity(Vec3),
    /// The angular velocity about it, rad/s.
    AngularVelocity(Vec3),
    /// The velocity, m/s, and the angular velocity, rad/s, of one rigid body.
    Motion(Vec3, Vec3),
    /// Where its `Transform` is to be, metres; the scale does not count.
    Teleport(Transform),
    /// A displacement, metres.
    Displace(Vec3),
    /// A turn about the barycentre; of any length but zero.
    Turn(Quat),
    /// Backwards from here.
    Reverse,
}

impl BodyEdit {
    /// Whether all its numbers are finite, and rotations are some.
    pub fn is_valid(&self) -> bool {
        let rotates = |q: Quat| q.is_finite() && q.to_array().iter().any(|&part| part != 0.0);
        match self {
            Self::Force(a)
            | Self::Torque(a)
            | Self::Impulse(a)
            | Self::AngularImpulse(a)
            | Self::LinearVelocity(a)
            | Self::AngularVelocity(a)
            | Self::Displace(a) => a.is_finite(),
            Self::ForceAt(a, b) | Self::ImpulseAt(a, b) | Self::Motion(a, b) => {
                a.is_finite() && b.is_finite()
            }
            Self::Teleport(to) => to.translation.is_finite() && rotates(to.rotation),
            Self::Turn(by) => rotates(*by),
            Self::Reverse => true,
        }
    }
}
