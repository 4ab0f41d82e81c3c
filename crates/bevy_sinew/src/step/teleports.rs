//! Bodies whose `Transform` somebody else changed take their particles along.

use bevy::prelude::*;

use super::carry::Carry;
use crate::components::{BodyParticles, ExtractedTransform, Particle, Sleep};

/// Moves the particles of bodies whose `Transform` somebody else changed: the change is a teleport of the whole body.
///
/// Velocities turn with the body and otherwise stay, so that a portal carries a flying box through.
pub(crate) fn follow_teleports(
    mut bodies: Query<
        (&Transform, &mut ExtractedTransform, &BodyParticles, Option<&mut Sleep>),
        Changed<Transform>,
    >,
    mut particles: Query<&mut Particle>,
) {
    for (transform, mut known, members, sleep) in &mut bodies {
        let Some(old) = known.0 else { continue };
        if old == *transform {
            continue;
        }
        let Some(carry) = Carry::between(&old, transform) else { continue };
        let mut moved = particles.iter_many_mut(members.iter());
        while let Some(mut particle) = moved.fetch_next() {
            carry.take(&mut particle);
        }
        known.0 = Some(*transform);
        if let Some(mut sleep) = sleep {
            sleep.wake();
        }
    }
}
