//! Interpolation of transforms between ticks: entities with [`Interpolate`] are opted into `bevy_transform_interpolation`, whenever the component or the
//! transform is added.

use bevy::prelude::*;
use bevy_transform_interpolation::prelude::TransformInterpolation;
use bevy_transform_interpolation::{RotationEasingState, ScaleEasingState, TranslationEasingState};

use crate::bevy_version::OnRemove;
use crate::components::{BodyParts, DrawnTransform, Interpolate, PartOf, Particle, RigidPose};
use crate::schedule::SinewClock;

/// The transforms between which an entity is drawn where the simulation has a speed of its own. The interpolation crate interpolates from one end of a fixed
/// tick to the other, while a fixed tick may play less or more than one tick of the simulation. The simulation does not depend on it.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct PlayedTransform {
    /// At the start of the last tick.
    tick_start: Transform,
    /// At the end of the previous fixed tick.
    previous: Transform,
    /// At the end of this fixed tick.
    current: Transform,
}

/// Stores the transforms at the start of the tick.
pub(crate) fn note_start(mut eased: Query<(&Transform, &mut PlayedTransform)>) {
    for (transform, mut played) in &mut eased {
        played.tick_start = *transform;
    }
}

/// Stores the transforms that a fixed tick has played.
pub(crate) fn record_played(
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
        played.previous = played.current;
        played.current = if share < 1.0 { between(&played.tick_start, now, share) } else { *now };
    }
    for (entity, &now) in &new {
        let played = PlayedTransform { tick_start: now, previous: now, current: now };
        commands.entity(entity).try_insert(played);
    }
}

/// Interpolates between the played transforms, instead of the ends of the fixed tick.
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
        let PlayedTransform { previous, current, .. } = played;
        // A transform that the game has changed since is not interpolated.
        if translation.start.is_some() && translation.end.is_some() {
            transform.translation = previous.translation.lerp(current.translation, share);
        }
        if rotation.start.is_some() && rotation.end.is_some() {
            transform.rotation = previous.rotation.slerp(current.rotation, share);
        }
    }
}

/// The components by which the interpolation crate interpolates a transform.
type Eased = (
    Option<&'static TranslationEasingState>,
    Option<&'static RotationEasingState>,
    Option<&'static ScaleEasingState>,
);

type IsEased =
    Or<(With<TranslationEasingState>, With<RotationEasingState>, With<ScaleEasingState>)>;

/// Stores where interpolated transforms are drawn, and what they were at the end of the tick, until the next tick begins.
pub(crate) fn note_drawn(
    mut commands: Commands,
    mut eased: Query<(Entity, &Transform, Eased, Option<&mut DrawnTransform>), IsEased>,
) {
    for (entity, &drawn, (translation, rotation, scale), noted) in &mut eased {
        let mut at_end = drawn;
        // A transform that the game has changed since is not interpolated.
        if let Some(TranslationEasingState { start: Some(_), end: Some(end) }) = translation {
            at_end.translation = *end;
        }
        if let Some(RotationEasingState { start: Some(_), end: Some(end) }) = rotation {
            at_end.rotation = *end;
        }
        if let Some(ScaleEasingState { start: Some(_), end: Some(end) }) = scale {
            at_end.scale = *end;
        }
        let now = DrawnTransform(Some((drawn, at_end)));
        match noted {
            Some(mut noted) => *noted = now,
            None => drop(commands.entity(entity).try_insert(now)),
        }
    }
}

/// Forgets what was drawn: within a tick, transforms are those of the simulation.
pub(crate) fn forget_drawn(mut eased: Query<&mut DrawnTransform>) {
    for mut drawn in &mut eased {
        drawn.0 = None;
    }
}

fn between(from: &Transform, to: &Transform, share: f32) -> Transform {
    Transform {
        translation: from.translation.lerp(to.translation, share),
        rotation: from.rotation.slerp(to.rotation, share),
        scale: to.scale,
    }
}

/// Entities whose transform the simulation writes.
type Written = (With<Transform>, Or<(With<RigidPose>, With<Particle>)>);

/// Opts in the transforms of bodies, of their parts, and of particles.
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

/// Opts them out when [`Interpolate`] is removed. (An observer, because a removal may no longer be readable at the next tick.)
pub(crate) fn opt_out(
    removed: OnRemove<Interpolate>,
    mut commands: Commands,
    parts: Query<&BodyParts>,
    eased: Query<(), With<Interpolate>>,
    owners: Query<&PartOf>,
) {
    let entity = removed.entity;
    // A part of an interpolated body stays interpolated.
    if owners.get(entity).is_ok_and(|of| eased.contains(of.0)) {
        return;
    }
    for eased in parts.get(entity).into_iter().flat_map(BodyParts::iter).chain([entity]) {
        // Including its required components, which would continue to interpolate.
        if let Ok(mut eased) = commands.get_entity(eased) {
            eased.queue_silenced(|mut eased: EntityWorldMut| {
                eased.remove_with_requires::<TransformInterpolation>();
                eased.remove::<(PlayedTransform, DrawnTransform)>();
            });
        }
    }
}
