//! Easing of transforms between ticks: whoever has [`Interpolate`] is opted into `bevy_transform_interpolation`, whenever that or what is eased comes.

use bevy::prelude::*;
use bevy_transform_interpolation::prelude::TransformInterpolation;
use bevy_transform_interpolation::{RotationEasingState, TranslationEasingState};

use crate::bevy_version::OnRemove;
use crate::components::{BodyParts, Interpolate, PartOf, Particle, RigidPose};
use crate::schedule::SinewClock;

/// Where something that is eased is drawn, at a speed of the simulation's own. The easing of transforms goes from one end of a fixed tick to the other,
/// while that may play less of a tick or more. Nothing of the simulation depends on it.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct PlayedTransform {
    /// Where the last tick began.
    before: Transform,
    /// What the last fixed tick ended with.
    from: Transform,
    /// What this one ended with.
    to: Transform,
}

/// Notes where the tick begins.
pub(crate) fn note_start(mut eased: Query<(&Transform, &mut PlayedTransform)>) {
    for (transform, mut played) in &mut eased {
        played.before = *transform;
    }
}

/// Notes what a fixed tick has played.
pub(crate) fn play(
    mut commands: Commands,
    clock: Res<SinewClock>,
    mut eased: Query<(&Transform, &mut PlayedTransform), With<TransformInterpolation>>,
    new: Query<
        (Entity, &Transform),
        (With<TransformInterpolation>, Written, Without<PlayedTransform>),
    >,
) {
    let share = 1.0 - clock.ahead as f32;
    for (now, mut played) in &mut eased {
        played.from = played.to;
        played.to = if share < 1.0 { between(&played.before, now, share) } else { *now };
    }
    for (entity, &now) in &new {
        let played = PlayedTransform { before: now, from: now, to: now };
        commands.entity(entity).try_insert(played);
    }
}

/// Draws what is eased where the speed has it: in place of between the ends of the fixed tick.
pub(crate) fn ease_played(
    time: Res<Time<Fixed>>,
    mut eased: Query<(
        &mut Transform,
        &PlayedTransform,
        &TranslationEasingState,
        &RotationEasingState,
    )>,
) {
    let share = time.overstep_fraction();
    for (mut transform, played, translation, rotation) in &mut eased {
        let PlayedTransform { from, to, .. } = played;
        // What a game has moved since is where the game has put it.
        if translation.start.is_some() && translation.end.is_some() {
            transform.translation = from.translation.lerp(to.translation, share);
        }
        if rotation.start.is_some() && rotation.end.is_some() {
            transform.rotation = from.rotation.slerp(to.rotation, share);
        }
    }
}

fn between(from: &Transform, to: &Transform, share: f32) -> Transform {
    Transform {
        translation: from.translation.lerp(to.translation, share),
        rotation: from.rotation.slerp(to.rotation, share),
        scale: to.scale,
    }
}

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
    removed: OnRemove<Interpolate>,
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
                eased.remove::<PlayedTransform>();
            });
        }
    }
}
