//! Sends contact events.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use sinew::Impact;

use crate::bevy_version::OnRemove;
use crate::components::{
    Collider, ContactEnded, ContactEvents, ContactImpulse, ContactStarted, ContactsDisabled,
    CreationOrder, Orphans, Particle, ParticleBody, Sensor, Sleep, Touching, fill_sorted,
};
use crate::recipes::Rescaled;
use crate::schedule::SinewClock;
use crate::world::SinewWorld;

/// A contact of an entity in this tick: the entity, the other one, the impact, and the sign of its normal.
type TouchingPair = (Entity, Entity, Impact, f32);

/// Notes entities that lost their parent. (An observer, because a removal may no longer be readable at the next tick.)
pub(crate) fn note_orphan(
    removed: OnRemove<ChildOf>,
    involved: Query<(), Or<(With<ParticleBody>, With<Collider>, With<Particle>)>>,
    mut orphans: ResMut<Orphans>,
) {
    if involved.contains(removed.entity) {
        orphans.0.push(removed.entity);
    }
}

/// Compares the current contacts of each entity with [`ContactEvents`] with its previous ones, and sends what began and ended.
pub(crate) fn write_contact_messages(
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    mut commands: Commands,
    mut started: MessageWriter<ContactStarted>,
    mut ended: MessageWriter<ContactEnded>,
    mut impulses: MessageWriter<ContactImpulse>,
    mut with_events: Query<(Entity, Option<&CreationOrder>, &mut Touching, &ContactEvents)>,
    resting: Resting,
    (moved, mut rescaled): (Query<Entity, Changed<ChildOf>>, RemovedComponents<Rescaled>),
    mut orphans: ResMut<Orphans>,
    mut anew: Local<Vec<Entity>>,
    mut contacts: Local<Vec<TouchingPair>>,
    mut order: Local<Vec<(Option<CreationOrder>, Entity)>>,
    mut lists: Local<Lists>,
) {
    // Without a step the report is that of an earlier one, whose bodies and colliders had other numbers.
    if !clock.is_behind(&world) {
        return;
    }
    fill_sorted(&mut anew, moved.iter().chain(rescaled.read()).chain(orphans.0.drain(..)));
    if with_events.is_empty() {
        return;
    }
    contacts.clear();
    for impact in &world.report().impacts {
        let participants =
            [impact.first, impact.second].map(|participant| world.entity_of(participant));
        let [Some(first), Some(second)] = participants else { continue };
        for (entity, other, sign) in [(first, second, 1.0), (second, first, -1.0)] {
            if with_events.contains(entity) {
                contacts.push((entity, other, *impact, sign));
            }
        }
    }
    // A stable sort: the contacts of one entity stay in the order of the report, which is that of creation, whatever the entity ids.
    contacts.sort_by_key(|&(entity, ..)| entity);
    fill_sorted(&mut order, with_events.iter().map(|(entity, order, ..)| (order.copied(), entity)));
    for &(_, entity) in &*order {
        let Ok((_, _, mut touching, events)) = with_events.get_mut(entity) else { continue };
        let from = contacts.partition_point(|one| one.0 < entity);
        let now = &contacts[from..from + contacts[from..].partition_point(|one| one.0 == entity)];
        let is_new = |entity: &Entity| !anew.is_empty() && anew.binary_search(entity).is_ok();
        let continues = |other: &Entity| !is_new(&entity) && !is_new(other);
        let every = if *events == ContactEvents::Every { now } else { Default::default() };
        let unchanged = now.iter().map(|one| one.1).eq(touching.0.iter().copied());
        if unchanged && touching.0.iter().all(continues) {
            report_impulses(every, &mut impulses, &mut commands);
            continue;
        }
        // Sorted, since a floor may touch a thousand bodies.
        let Lists { current, previous } = &mut *lists;
        fill_sorted(current, now.iter().map(|one| one.1));
        fill_sorted(previous, touching.0.iter().copied());
        // Two bodies that rest against each other asleep are not solved, but still touch.
        let is_current = |other: &Entity| current.binary_search(other).is_ok();
        let at_rest = |other: &Entity| !is_current(other) && resting.do_rest(entity, *other);
        let touches = |other: &Entity| continues(other) && (is_current(other) || at_rest(other));
        let began =
            |one: &&TouchingPair| !continues(&one.1) || previous.binary_search(&one.1).is_err();
        if touching.0.iter().all(touches) && !now.iter().any(|one| began(&one)) {
            report_impulses(every, &mut impulses, &mut commands);
            continue;
        }
        for &other in touching.0.iter().filter(|other| !touches(other)) {
            let event = ContactEnded { entity, other };
            ended.write(event);
            commands.trigger(event);
        }
        for &(_, other, impact, sign) in now.iter().filter(began) {
            let Impact { point, normal, impulse, sensor, .. } = impact;
            let event =
                ContactStarted { entity, other, point, normal: normal * sign, impulse, sensor };
            started.write(event);
            commands.trigger(event);
        }
        report_impulses(every, &mut impulses, &mut commands);
        let resting: Vec<Entity> =
            touching.0.iter().copied().filter(|other| continues(other) && at_rest(other)).collect();
        touching.0.clear();
        touching.0.extend(now.iter().map(|one| one.1).chain(resting));
    }
}

/// The current and the previous contacts of an entity, sorted. Scratch.
#[derive(Default)]
pub(crate) struct Lists {
    current: Vec<Entity>,
    previous: Vec<Entity>,
}

/// Finds out whether a pair is at rest.
#[derive(SystemParam)]
pub(crate) struct Resting<'w, 's> {
    sleepers: Query<'w, 's, &'static Sleep>,
    colliders: Query<'w, 's, (), (With<Collider>, Without<Sensor>, Without<ContactsDisabled>)>,
}

impl Resting<'_, '_> {
    /// Whether one of the two sleeps, and the other sleeps or is a static or kinematic collider, of which any change wakes the sleeper. What a sensor overlaps is
    /// reported in every tick, asleep or not.
    fn do_rest(&self, one: Entity, other: Entity) -> bool {
        let asleep = |entity| self.sleepers.get(entity).map(|sleep| sleep.asleep);
        match (asleep(one), asleep(other)) {
            (Ok(one), Ok(other)) => one && other,
            (Ok(true), Err(_)) => self.colliders.contains(other),
            (Err(_), Ok(true)) => self.colliders.contains(one),
            _ => false,
        }
    }
}

/// Sends each contact of an entity with [`ContactEvents::Every`].
fn report_impulses(
    list: &[TouchingPair],
    messages: &mut MessageWriter<ContactImpulse>,
    commands: &mut Commands,
) {
    for &(entity, other, impact, sign) in list {
        let Impact { point, normal, impulse, sensor, .. } = impact;
        let event = ContactImpulse { entity, other, point, normal: normal * sign, impulse, sensor };
        messages.write(event);
        commands.trigger(event);
    }
}
