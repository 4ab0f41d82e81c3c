//! Copies the contact caches of the parts to the solver before a tick, and back after it.

use bevy::ecs::change_detection::Tick;
use bevy::ecs::system::SystemChangeTick;
use bevy::prelude::*;

use crate::components::ContactCache;
use crate::world::SinewWorld;

/// Copies the contact cache of each part to the solver, unless the solver's is the same.
pub(crate) fn gather_contact_cache(
    mut world: ResMut<SinewWorld>,
    caches: Query<&ContactCache>,
    kept: Query<Ref<ContactCache>>,
    ticks: SystemChangeTick,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    if let Some(then) = tables.cache_kept
        && is_as_kept(&kept, then, ticks.this_run())
    {
        return;
    }
    tables.cache_kept = None;
    simulation.contact_cache.clear();
    for (number, &part) in tables.parts.iter().enumerate() {
        if let (Some(body_collider), Ok(own)) =
            (simulation.body_colliders().get(number), caches.get(part))
        {
            let id = body_collider.id;
            simulation.contact_cache.add(id, &own.0);
        }
    }
}

/// Copies the contact cache of each part back.
pub(crate) fn keep_contact_cache(
    mut world: ResMut<SinewWorld>,
    mut caches: Query<&mut ContactCache>,
    ticks: SystemChangeTick,
) {
    let SinewWorld { simulation, tables } = &mut *world;
    if tables.rested && tables.cache_kept.is_some() {
        tables.cache_kept = Some((ticks.this_run(), caches.iter().len()));
        return;
    }
    let mut all = true;
    let each = simulation.contact_cache.each(simulation.body_colliders().iter().map(|one| one.id));
    let body_colliders = simulation.body_colliders();
    for ((now, body_collider), &part) in each.zip(body_colliders).zip(&tables.parts) {
        let Ok(mut own) = caches.get_mut(part) else {
            all = false;
            continue;
        };
        // For a body that slept through the tick it has not changed. For an awake body it changes in nearly every tick: a comparison costs more than the copy.
        let row = body_collider.rows.first().map(|&row| row as usize);
        let body = row.and_then(|row| simulation.particles.body(row)).map(|body| body as usize);
        let sleeps = |bodies: &[bool]| body.and_then(|body| bodies.get(body)) == Some(&true);
        let is_empty = own.0.is_empty() && now.is_empty();
        if is_empty || sleeps(&tables.asleep) {
            continue;
        }
        let falls_asleep =
            body.and_then(|body| simulation.sleep.get(body)).is_some_and(|own| own.asleep);
        if !falls_asleep || own.0 != now {
            own.0.clear();
            own.0.extend_from_slice(now);
        }
    }
    tables.cache_kept = all.then(|| (ticks.this_run(), caches.iter().len()));
}

/// Whether no cache has changed since it was kept, or was added or removed.
fn is_as_kept(kept: &Query<Ref<ContactCache>>, (then, before): (Tick, usize), now: Tick) -> bool {
    let Ok(tables) = kept.contiguous_iter() else { return false };
    let mut count = 0;
    for column in tables {
        let changed = column.changed_ticks_slice();
        count += changed.len();
        if changed.iter().any(|tick| tick.is_newer_than(then, now)) {
            return false;
        }
    }
    count == before
}
