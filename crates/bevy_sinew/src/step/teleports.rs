//! Teleports: moves the particles of bodies that the game moved, by their own `Transform` or by that of a parent.

use bevy::prelude::*;

use crate::carry::{Jump, Jumps, RigidMotion};
use crate::components::{BodyParticles, ExtractedTransform, Particle, Sleep};
use crate::frames::Frames;

/// Moves the particles of bodies whose world transform differs from the one that the simulation left: a teleport of the whole body.
///
/// Velocities turn with the body and otherwise stay, so that a portal carries a flying box through. A body whose parent moves is thus moved by as much in every
/// tick, in addition to its own motion, and its velocity in the world is that of its own motion only.
pub(crate) fn follow_teleports(
    mut bodies: Query<(
        Entity,
        Ref<Transform>,
        Has<ChildOf>,
        &mut ExtractedTransform,
        &BodyParticles,
        Option<&mut Sleep>,
    )>,
    frames: Frames,
    mut particles: Query<&mut Particle>,
    mut jumps: Option<ResMut<Jumps>>,
) {
    for (entity, transform, parented, mut known, members, sleep) in &mut bodies {
        let Some(old) = known.0 else { continue };
        // A body that a parent shears stays where it is; the error is reported when it is built.
        let Ok(now) = (if parented { frames.of(entity) } else { Ok(*transform) }) else { continue };
        if old == now {
            continue;
        }
        let Some(motion) = RigidMotion::between(&old, &now) else { continue };
        known.0 = Some(now);
        if motion.is_identity() {
            continue;
        }
        if let Some(jumps) = &mut jumps {
            let carried = parented && !transform.is_changed();
            jumps.0.push(Jump { body: entity, motion, carried });
        }
        for member in members.iter() {
            if let Ok(mut particle) = particles.get_mut(member) {
                motion.apply(&mut particle);
            }
        }
        if let Some(mut sleep) = sleep {
            sleep.wake();
        }
    }
}
