//! Contacts that began and ended, told to whoever asked.

use bevy::prelude::*;
use sinew::Impact;

use crate::components::{ContactEnded, ContactEvents, ContactStarted, CreationOrder, Touching};
use crate::world::SinewWorld;

/// What a tick told of one entity: who, whom, and how.
type Told = (Entity, Entity, Impact, f32);

/// Compares whom each one who asked touches with whom it touched.
pub(crate) fn tell_contacts(
    world: Res<SinewWorld>,
    mut commands: Commands,
    mut started: MessageWriter<ContactStarted>,
    mut ended: MessageWriter<ContactEnded>,
    mut asking: Query<(Entity, Option<&CreationOrder>, &mut Touching), With<ContactEvents>>,
    mut told: Local<Vec<Told>>,
    mut order: Local<Vec<(Option<CreationOrder>, Entity)>>,
) {
    if asking.is_empty() {
        return;
    }
    told.clear();
    for impact in &world.report().impacts {
        let parties = [impact.first, impact.second].map(|party| world.entity_of(party));
        let [Some(first), Some(second)] = parties else { continue };
        for (entity, other, sign) in [(first, second, 1.0), (second, first, -1.0)] {
            if asking.contains(entity) {
                told.push((entity, other, *impact, sign));
            }
        }
    }
    told.sort_unstable_by_key(|&(entity, other, ..)| (entity, other));
    order.clear();
    order.extend(asking.iter().map(|(entity, order, _)| (order.copied(), entity)));
    order.sort_unstable();
    for &(_, entity) in &*order {
        let Ok((_, _, mut touching)) = asking.get_mut(entity) else { continue };
        let from = told.partition_point(|one| one.0 < entity);
        let now = &told[from..from + told[from..].partition_point(|one| one.0 == entity)];
        if now.iter().map(|one| one.1).eq(touching.0.iter().copied()) {
            continue;
        }
        for &other in touching.0.iter().filter(|&&other| !now.iter().any(|one| one.1 == other)) {
            let event = ContactEnded { entity, other };
            ended.write(event);
            commands.trigger(event);
        }
        for &(_, other, impact, sign) in now.iter().filter(|one| !touching.0.contains(&one.1)) {
            let Impact { point, normal, impulse, sensor, .. } = impact;
            let event =
                ContactStarted { entity, other, point, normal: normal * sign, impulse, sensor };
            started.write(event);
            commands.trigger(event);
        }
        touching.0.clear();
        touching.0.extend(now.iter().map(|one| one.1));
    }
}
