//! Carrying particles along with a frame that somebody moves: the same whether a `Transform` was changed or a command asked for it.
//!
//! Velocities turn with the frame and otherwise stay, so that a portal carries a flying, spinning box through: if they kept their direction,
//! those of its particles would no longer be those of a rigid spin. In `f64`, so that no shape loses a digit on the way, however far it is.

use bevy::math::{DQuat, DVec3};
use bevy::prelude::*;

use crate::components::Particle;

/// A rigid motion of the whole world, for some particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carry {
    from: DVec3,
    to: DVec3,
    /// `None` keeps every bit of the shape and of the velocities.
    turn: Option<DQuat>,
}

impl Carry {
    /// What leads from one place of a frame to another; scales do not count. `None` if one of them is no place: not finite, or no rotation.
    pub(crate) fn between(from: &Transform, to: &Transform) -> Option<Self> {
        let (a, b) = (unit(from.rotation)?, unit(to.rotation)?);
        if !(from.translation.is_finite() && to.translation.is_finite()) {
            return None;
        }
        let turn = (from.rotation != to.rotation).then(|| b * a.conjugate());
        Some(Self { from: from.translation.as_dvec3(), to: to.translation.as_dvec3(), turn })
    }

    /// A turn about a point, metres; `None` if it is none.
    pub(crate) fn about(point: DVec3, turn: Quat) -> Option<Self> {
        let turn = unit(turn)?;
        point.is_finite().then_some(Self { from: point, to: point, turn: Some(turn) })
    }

    /// Whether it leads nowhere.
    pub(crate) fn is_none(&self) -> bool {
        self.from == self.to && self.turn.is_none()
    }

    /// Takes a particle along.
    pub(crate) fn take(&self, particle: &mut Particle) {
        let arm = particle.exact() - self.from;
        match self.turn {
            None => particle.place(self.to + arm),
            Some(turn) => {
                particle.place(self.to + turn * arm);
                particle.velocity = (turn * particle.velocity.as_dvec3()).as_vec3();
            }
        }
    }

    /// Takes a frame along; its scale stays.
    pub(crate) fn take_frame(&self, frame: &mut Transform) {
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

/// A quaternion brought to unit length, or `None` if it has no direction. Nothing here asserts: a broken one is to be refused, not to end the game.
fn unit(q: Quat) -> Option<DQuat> {
    let q = DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into());
    let length = q.length();
    (length.is_finite() && length > 0.0).then(|| q * (1.0 / length))
}
