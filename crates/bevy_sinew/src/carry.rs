//! Moves particles with a frame, in the same way whether a game changed a `Transform` or issued a command.
//!
//! Velocities turn with the frame and otherwise stay, so that a portal carries a flying, spinning box through: if they kept their direction, they would no
//! longer be those of a rigid spin. Computed in `f64`, so that no shape loses precision, however far the motion is.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use crate::components::Particle;

/// A rigid motion of the world, applied to some particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidMotion {
    from: DVec3,
    to: DVec3,
    /// `None` keeps every bit of the shape and of the velocities.
    turn: Option<DQuat>,
}

impl RigidMotion {
    /// The motion from one placement of a frame to another, without scale. `None` if one of them is invalid: not finite, or without a rotation.
    pub(crate) fn between(from: &Transform, to: &Transform) -> Option<Self> {
        let (a, b) = (unit(from.rotation)?, unit(to.rotation)?);
        if !(from.translation.is_finite() && to.translation.is_finite()) {
            return None;
        }
        let turn = (from.rotation != to.rotation).then(|| b * a.conjugate());
        Some(Self { from: from.translation.as_dvec3(), to: to.translation.as_dvec3(), turn })
    }

    /// A rotation about a point, metres; `None` if either is invalid.
    pub(crate) fn about(point: DVec3, turn: Quat) -> Option<Self> {
        let turn = unit(turn)?;
        point.is_finite().then_some(Self { from: point, to: point, turn: Some(turn) })
    }

    /// Whether it moves nothing.
    pub(crate) fn is_identity(&self) -> bool {
        self.from == self.to && self.turn.is_none()
    }

    /// Applies the motion to a particle.
    pub(crate) fn apply(&self, particle: &mut Particle) {
        let arm = particle.exact() - self.from;
        match self.turn {
            None => particle.place(self.to + arm),
            Some(turn) => {
                particle.place(self.to + turn * arm);
                particle.velocity = (turn * particle.velocity.as_dvec3()).as_vec3();
            }
        }
    }

    /// The place to which the motion moves a point.
    #[cfg(feature = "interpolation")]
    pub(crate) fn of_point(&self, point: Vec3) -> Vec3 {
        let arm = point.as_dvec3() - self.from;
        (self.to + self.turn.map_or(arm, |turn| turn * arm)).as_vec3()
    }

    /// The frame to which the motion moves one.
    #[cfg(feature = "interpolation")]
    pub(crate) fn applied_to(&self, mut frame: Transform) -> Transform {
        self.apply_to_frame(&mut frame);
        frame
    }

    /// Applies the motion to a frame; its scale stays.
    pub(crate) fn apply_to_frame(&self, frame: &mut Transform) {
        let arm = frame.translation.as_dvec3() - self.from;
        match self.turn {
            None => frame.translation = (self.to + arm).as_vec3(),
            Some(turn) => {
                frame.translation = (self.to + turn * arm).as_vec3();
                if let Some(rotation) = unit(frame.rotation) {
                    frame.rotation = (turn * rotation).as_quat();
                }
            }
        }
    }
}

/// Normalises a quaternion; `None` if it has no direction. Unlike `Quat`'s own methods this does not assert: a broken rotation must be refused, not panic.
fn unit(q: Quat) -> Option<DQuat> {
    let q = DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into());
    let length = q.length();
    (length.is_finite() && length > 0.0).then(|| q * (1.0 / length))
}

/// The bodies and parts that the game moved since their last tick, in the order in which it happened: what is interpolated between two ticks jumps with them.
/// Scratch; exists only where something is interpolated.
#[derive(Resource, Default)]
pub(crate) struct Jumps(pub(crate) Vec<Jump>);

/// How the game moved a body, or a part of one.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "interpolation"), expect(dead_code, reason = "read by the interpolation"))]
pub(crate) struct Jump {
    pub(crate) body: Entity,
    /// The motion in the world.
    pub(crate) motion: RigidMotion,
    /// Whether the body was not moved itself, but is carried by a parent. Not known of an interpolated body, whose transform the simulation writes, too.
    pub(crate) carried: bool,
}
