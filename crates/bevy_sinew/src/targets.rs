//! The particles of an entity that is a body, a rigid part or a particle itself, for what acts on any of these: control forces, statics.

use bevy::prelude::*;

use crate::components::{BodyParticles, Particle, ParticleBody, RigidPose};

/// The components that determine which particles an entity has: a body, a rigid part, or a particle.
pub(crate) type Targets<'w, 's> = Query<
    'w,
    's,
    (Option<&'static BodyParticles>, Option<&'static RigidPose>, Has<ParticleBody>, Has<Particle>),
>;

/// The particles of an entity; none if it has none, or they are not built yet.
pub(crate) fn particles_of(targets: &Targets, target: Entity) -> Vec<Entity> {
    match targets.get(target) {
        Ok((_, _, _, true)) => vec![target],
        Ok((Some(members), ..)) => members.iter().collect(),
        Ok((_, Some(posed), ..)) => posed.particles.clone(),
        _ => Vec::new(),
    }
}

/// Whether an entity without particles is a body that is not built yet, which is no error.
pub(crate) fn waits(targets: &Targets, target: Entity) -> bool {
    targets.get(target).is_ok_and(|(.., is_body, _)| is_body)
}
