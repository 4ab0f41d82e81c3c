//! The changes that commands make to a body.

use bevy::prelude::*;

/// One change to a body, a rigid part or a particle, as data. It is an `EntityCommand`; [`BodyCommandsExt`](super::BodyCommandsExt) documents each variant.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Clone, PartialEq)]
#[non_exhaustive]
pub enum BodyEdit {
    /// Applies a force at the centre of mass for the next tick, N.
    Force(Vec3),
    /// Applies a force, N, at a point of the world, metres, for the next tick.
    ForceAt(Vec3, Vec3),
    /// Applies a torque for the next tick, N·m.
    Torque(Vec3),
    /// Applies an impulse at the centre of mass, N·s.
    Impulse(Vec3),
    /// Applies an impulse, N·s, at a point of the world, metres.
    ImpulseAt(Vec3, Vec3),
    /// Applies an angular impulse about the centre of mass, N·m·s.
    AngularImpulse(Vec3),
    /// Sets the velocity of the centre of mass, m/s.
    LinearVelocity(Vec3),
    /// Sets the angular velocity about the centre of mass, rad/s.
    AngularVelocity(Vec3),
    /// Sets the velocity, m/s, and the angular velocity, rad/s, of one rigid motion.
    Motion(Vec3, Vec3),
    /// Moves the body so that its `Transform` is this one, metres; the scale is ignored.
    Teleport(Transform),
    /// Moves the body by a displacement, metres.
    Displace(Vec3),
    /// Rotates the body about its centre of mass. The quaternion may have any length but zero.
    Turn(Quat),
    /// Reverses the motion.
    Reverse,
}

impl BodyEdit {
    /// The edits that carry out velocities that the game wrote: the linear and the angular one, where they differ from those that the simulation `left`. A body
    /// without extracted velocities starts with those that it was spawned with, unless both are zero: its particles may have velocities of their own.
    pub(crate) fn of_written(
        (linear, angular): (Vec3, Vec3),
        left: Option<(Vec3, Vec3)>,
    ) -> [Option<Self>; 2] {
        match left {
            None if (linear, angular) == (Vec3::ZERO, Vec3::ZERO) => [None, None],
            None => [Some(Self::Motion(linear, angular)), None],
            Some((velocity, spin)) => {
                let moved = (velocity != linear).then_some(Self::LinearVelocity(linear));
                let spun = (spin != angular).then_some(Self::AngularVelocity(angular));
                [moved, spun]
            }
        }
    }

    /// Whether all numbers are finite and all rotations have a length.
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
