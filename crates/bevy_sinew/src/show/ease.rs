//! Interpolation of transforms between ticks: entities with [`Interpolate`] are opted into `bevy_transform_interpolation`, whenever the component or the
//! transform is added.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::prelude::*;
use bevy_transform_interpolation::prelude::TransformInterpolation;
use bevy_transform_interpolation::{RotationEasingState, ScaleEasingState, TranslationEasingState};

use crate::bevy_version::OnRemove;
use crate::carry::{Jump, Jumps, RigidMotion};
use crate::components::{
    BodyParticles, BodyParts, DrawnTransform, Interpolate, PartOf, Particle, ParticleRow, RigidPose,
};
use crate::frames::{Frames, compose, to_local};
use crate::schedule::{FixedTick, SinewClock};
use crate::world::SinewWorld;

/// The transforms between which an entity is drawn where the simulation has a speed of its own. The interpolation crate interpolates from one end of a fixed
/// tick to the other, while a fixed tick may play less or more than one tick of the simulation. The simulation does not depend on it.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct PlayedTransform {
    /// At the start of the last tick.
    tick_start: Transform,
    /// At the end of the last tick: if it is another one now, the game has moved the entity.
    tick_end: Transform,
    /// At the end of the previous fixed tick.
    previous: Transform,
    /// At the end of this fixed tick.
    current: Transform,
}

impl PlayedTransform {
    /// An entity that stays where it is.
    pub(crate) fn at(now: Transform) -> Self {
        Self { tick_start: now, tick_end: now, previous: now, current: now }
    }

    /// Moves the places where it was, so that it is drawn as if it came from there. (`previous` is replaced by `current` before anything is drawn.)
    fn jump(&mut self, moved: impl Fn(Transform) -> Transform) {
        self.current = moved(self.current);
        self.carry(moved);
    }

    /// Moves the ends of the last tick, so that it is drawn on the way from where it was drawn.
    fn carry(&mut self, moved: impl Fn(Transform) -> Transform) {
        (self.tick_start, self.tick_end) = (moved(self.tick_start), moved(self.tick_end));
    }
}

/// Stores the transforms at the start and at the end of a tick, after it.
pub(crate) fn note_tick(
    fixed_tick: Res<FixedTick>,
    mut eased: Query<(&Transform, &mut PlayedTransform)>,
) {
    for (transform, mut played) in &mut eased {
        if fixed_tick.remaining > 0 {
            played.tick_start = played.tick_end;
        }
        played.tick_end = *transform;
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
        commands.entity(entity).try_insert(PlayedTransform::at(now));
    }
}

/// Moves the start of the interpolation along with bodies that the game has moved since the last tick: they are drawn in the new place at once. A body's own
/// transform is there already; those of its parts are written at the end of the tick. What a parent carries is drawn on the way.
pub(crate) fn follow_jumps(
    mut jumps: ResMut<Jumps>,
    mut world: ResMut<SinewWorld>,
    fixed_tick: Res<FixedTick>,
    bodies: Query<(Option<&BodyParticles>, Option<&BodyParts>)>,
    rows: Query<&ParticleRow>,
    frames: Frames,
    mut eased: Query<(
        &Transform,
        Has<ChildOf>,
        &mut TranslationEasingState,
        &mut RotationEasingState,
        &mut PlayedTransform,
    )>,
    mut followed: Local<Vec<Entity>>,
) {
    followed.clear();
    for Jump { body, motion, mut carried } in jumps.0.drain(..) {
        if let Ok((&now, parented, mut translation, mut rotation, mut played)) = eased.get_mut(body)
        {
            let own = RigidMotion::between(&played.tick_end, &now);
            if let Some(own) = own.filter(|own| !own.is_identity()) {
                followed.push(body);
                played.jump(|frame| own.applied_to(frame));
                // Without the round-off of the motion.
                played.tick_end = now;
                restart(&mut translation, &mut rotation, now);
                carried = false;
            } else {
                // It stays in the frame of its parent, which has moved.
                carried = parented && !followed.contains(&body);
            }
        }
        let (members, parts) = bodies.get(body).unwrap_or_default();
        for part in parts.into_iter().flat_map(BodyParts::iter) {
            let Ok((_, parented, mut translation, mut rotation, mut played)) = eased.get_mut(part)
            else {
                continue;
            };
            // Nothing expresses the motion in the frame of a parent that shears the part.
            let Ok(above) = frames.above(part) else { continue };
            let moved = |frame: Transform| {
                let Some(place) = compose(&above, &frame).filter(|_| parented) else {
                    return motion.applied_to(frame);
                };
                to_local(&above, &motion.applied_to(place)).with_scale(frame.scale)
            };
            if carried {
                played.carry(moved);
                continue;
            }
            played.jump(moved);
            restart(&mut translation, &mut rotation, played.tick_end);
        }
        if fixed_tick.time_scaled {
            for member in members.into_iter().flat_map(BodyParticles::iter) {
                let row = rows.get(member).ok().and_then(|row| row.get());
                row.into_iter().for_each(|row| world.move_played(row, &motion, carried));
            }
        }
    }
}

/// Interpolates from another place on. A state without a start is not interpolated, and stays so.
fn restart(
    translation: &mut TranslationEasingState,
    rotation: &mut RotationEasingState,
    from: Transform,
) {
    translation.start = translation.start.map(|_| from.translation);
    rotation.start = rotation.start.map(|_| from.rotation);
}

/// The same for single particles, which the game moves by writing to them. One that has a parent is interpolated, as the parent may have moved instead.
pub(crate) fn start_at_particles(
    mut eased: Query<
        (&Particle, &mut TranslationEasingState, &mut PlayedTransform),
        (With<Interpolate>, With<Transform>, Without<ChildOf>),
    >,
) {
    for (particle, mut state, mut played) in &mut eased {
        let way = particle.position - played.tick_end.translation;
        if way == Vec3::ZERO || !particle.position.is_finite() {
            continue;
        }
        played.jump(|frame| frame.with_translation(frame.translation + way));
        played.tick_end.translation = particle.position;
        state.start = state.start.map(|_| particle.position);
    }
}

/// Run condition: whether the game has moved a body since the last tick.
pub(crate) fn any_jump(jumps: Res<Jumps>) -> bool {
    !jumps.0.is_empty()
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
    parts: Query<&BodyParts, Allow<Disabled>>,
    eased: Query<(), (With<Interpolate>, Allow<Disabled>)>,
    owners: Query<&PartOf, Allow<Disabled>>,
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
