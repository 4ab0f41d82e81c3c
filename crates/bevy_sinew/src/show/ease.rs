//! Easing of transforms between ticks: whoever has [`Interpolate`] is opted into `bevy_transform_interpolation`, whenever that or what is eased comes.

use bevy::prelude::*;
use bevy_transform_interpolation::prelude::TransformInterpolation;

use crate::components::{Interpolate, Particle, RigidPose};
use crate::recipes::{BodyParts, PartOf};

/// What has a transform that the simulation writes.
type Written = (With<Transform>, Or<(With<RigidPose>, With<Particle>)>);

/// Opts transforms in: those of bodies, of their parts, and of particles.
pub(crate) fn opt_in(
    mut commands: Commands,
    own: Query<Entity, (With<Interpolate>, Written, Without<TransformInterpolation>)>,
    new: Query<Entity, (With<Interpolate>, Or<(Added<Interpolate>, Changed<BodyParts>)>)>,
    parts: Query<&BodyParts>,
) {
    for entity in &own {
        commands.entity(entity).insert(TransformInterpolation);
    }
    for body in &new {
        for part in parts.get(body).into_iter().flat_map(BodyParts::iter) {
            commands.entity(part).insert(TransformInterpolation);
        }
    }
}

/// Opts them out where [`Interpolate`] was taken away. (An observer, for a tick may be too late to be told of what went.)
pub(crate) fn opt_out(
    removed: On<Remove, Interpolate>,
    mut commands: Commands,
    parts: Query<&BodyParts>,
    eased: Query<(), With<Interpolate>>,
    owners: Query<&PartOf>,
) {
    let entity = removed.entity;
    // A part of a body that is eased goes on.
    if owners.get(entity).is_ok_and(|of| eased.contains(of.0)) {
        return;
    }
    for eased in parts.get(entity).into_iter().flat_map(BodyParts::iter).chain([entity]) {
        // With all that it brought along, or that would go on easing.
        if let Ok(mut eased) = commands.get_entity(eased) {
            eased.queue_silenced(|mut eased: EntityWorldMut| {
                eased.remove_with_requires::<TransformInterpolation>();
            });
        }
    }
}
