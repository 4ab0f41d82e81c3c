//! Entities with Bevy's `Disabled` leave the simulation, and what belongs to them leaves with them, until they are enabled again.
//!
//! Queries skip a disabled entity, and nothing else: Bevy detects neither its absence nor its return as a change, and its particles are entities of their own.
//! Two observers note which entities were toggled, and the next tick brings the simulation up to date for all of them at once.

use bevy::ecs::change_detection::Tick;
use bevy::ecs::component::ComponentId;
use bevy::ecs::entity_disabling::Disabled;
use bevy::prelude::*;

use crate::attach::{AttachmentJoints, AttachmentOf, BodyAttachments, JointOf};
use crate::bevy_version::{OnAdd, OnRemove};
use crate::components::{
    BodyConstraints, BodyParticles, BodyParts, ColliderMotion, ConstraintOf, ContactCache,
    CreationOrder, DisabledWithBody, DrawnTransform, LeftAt, PartOf, Particle, ParticleOf,
    PlacedCollider, Sleep, Toggled, TopologyChanged, end_contacts,
};
use crate::state::{StateTypes, forget_eased};
use crate::world::SinewWorld;

/// Observer: notes an entity that was disabled.
pub(crate) fn note_disabled(added: OnAdd<Disabled>, mut toggled: ResMut<Toggled>) {
    toggled.0.push(added.entity);
}

/// Observer: notes an entity that was enabled.
pub(crate) fn note_enabled(removed: OnRemove<Disabled>, mut toggled: ResMut<Toggled>) {
    toggled.0.push(removed.entity);
}

/// Run condition: whether any entity was toggled since the last tick.
pub(crate) fn any_toggled(toggled: Res<Toggled>) -> bool {
    !toggled.0.is_empty()
}

/// Takes disabled entities out of the simulation, with what belongs to them, and brings enabled ones back.
pub(crate) fn follow_disabling(world: &mut World) {
    let state = world.resource_scope(|world, types: Mut<StateTypes>| types.of_components(world));
    loop {
        // What belongs to a toggled entity is toggled in turn.
        let mut toggled = core::mem::take(&mut world.resource_mut::<Toggled>().0);
        if toggled.is_empty() {
            return;
        }
        toggled.sort_by_cached_key(|&entity| (world.get::<CreationOrder>(entity).copied(), entity));
        toggled.dedup();
        for entity in toggled {
            let Ok(there) = world.get_entity(entity) else { continue };
            let was_out = there.contains::<LeftAt>();
            if there.contains::<Disabled>() {
                if !was_out {
                    leave(world, entity);
                }
                disable_related(world, entity);
            } else if was_out || there.contains::<DisabledWithBody>() {
                come_back(world, entity, &state);
            }
        }
    }
}

/// Takes an entity out: its contacts end, and nothing is kept of it that is not valid when it comes back.
fn leave(world: &mut World, entity: Entity) {
    mark_topology(world, entity);
    end_contacts(world.into(), entity);
    let began = world.resource::<SinewWorld>().tables.began;
    let Ok(mut entity) = world.get_entity_mut(entity) else { return };
    entity.insert(LeftAt(began));
    // It starts where it then is, and sweeps nothing along on the way there.
    if let Some(mut motion) = entity.get_mut::<ColliderMotion>() {
        motion.set_if_neq(ColliderMotion(None));
    }
    if let Some(mut cache) = entity.get_mut::<ContactCache>() {
        cache.set_if_neq(ContactCache::default());
    }
    // While it is disabled, nothing replaces the transform at which it was drawn by that at the end of the tick.
    if let Some(&drawn) = entity.get::<DrawnTransform>()
        && let Some(mut transform) = entity.get_mut::<Transform>()
    {
        let actual = drawn.actual(*transform);
        transform.set_if_neq(actual);
    }
    forget_eased(&mut entity);
}

/// Brings an entity back. What the game changed in the meantime counts as changed now.
fn come_back(world: &mut World, entity: Entity, state: &[bool]) {
    mark_topology(world, entity);
    let now = world.change_tick();
    let Ok(mut there) = world.get_entity_mut(entity) else { return };
    let since = there.get::<LeftAt>().and_then(|left| left.0);
    there.remove::<(LeftAt, DisabledWithBody)>();
    let newer = |tick: Tick| since.is_none_or(|since| tick.is_newer_than(since, now));
    let changed = |&id: &ComponentId| {
        let is_state = state.get(id.index()) == Some(&true);
        let ticks = there.get_change_ticks_by_id(id).filter(|_| is_state)?;
        newer(ticks.changed).then(|| (id, newer(ticks.added)))
    };
    let changed: Vec<_> = there.archetype().components().iter().filter_map(changed).collect();
    for (id, added) in changed {
        // A component that cannot be changed, such as a relationship, has been replaced.
        match there.get_mut_by_id(id) {
            Ok(mut component) if added => component.set_added(),
            Ok(mut component) => component.set_changed(),
            Err(_) => {}
        }
    }
    if let Some(mut sleep) = there.get_mut::<Sleep>() {
        sleep.wake();
    }
    for related in related(world, entity) {
        if let Ok(mut related) = world.get_entity_mut(related)
            && related.contains::<DisabledWithBody>()
        {
            related.remove::<Disabled>();
        }
    }
}

/// Disables what belongs to a disabled entity. If the entity itself is disabled because of one that is enabled, as after a snapshot was restored, it is enabled.
fn disable_related(world: &mut World, entity: Entity) {
    if world.get::<DisabledWithBody>(entity).is_some()
        && owner(world, entity).is_some_and(|owner| world.get::<Disabled>(owner).is_none())
    {
        world.entity_mut(entity).remove::<Disabled>();
        return;
    }
    for related in related(world, entity) {
        if let Ok(mut related) = world.get_entity_mut(related)
            && !related.contains::<Disabled>()
        {
            related.insert((Disabled, DisabledWithBody));
        }
    }
}

/// Rows are assigned again, and links compiled, if the entity may be a particle or a link.
fn mark_topology(world: &mut World, entity: Entity) {
    let Ok(there) = world.get_entity(entity) else { return };
    let is_collider = there.contains::<PlacedCollider>() && !there.contains::<Particle>();
    if there.contains::<CreationOrder>() && !is_collider {
        world.resource_mut::<TopologyChanged>().0 = true;
        // Incremental updates rely on the detection of removals.
        world.resource_mut::<SinewWorld>().tables.links.complete = false;
    }
}

/// What belongs to an entity: particles, constraints, parts, attachments and their joints.
fn related(world: &World, entity: Entity) -> Vec<Entity> {
    fn list<T: RelationshipTarget>(world: &World, entity: Entity) -> impl Iterator<Item = Entity> {
        world.get::<T>(entity).into_iter().flat_map(RelationshipTarget::iter)
    }
    list::<BodyParticles>(world, entity)
        .chain(list::<BodyConstraints>(world, entity))
        .chain(list::<BodyParts>(world, entity))
        .chain(list::<BodyAttachments>(world, entity))
        .chain(list::<AttachmentJoints>(world, entity))
        .collect()
}

/// What an entity belongs to.
fn owner(world: &World, entity: Entity) -> Option<Entity> {
    let there = world.get_entity(entity).ok()?;
    let of = there.get::<ParticleOf>().map(|of| of.0);
    of.or_else(|| there.get::<ConstraintOf>().map(|of| of.0))
        .or_else(|| there.get::<PartOf>().map(|of| of.0))
        .or_else(|| there.get::<AttachmentOf>().map(|of| of.0))
        .or_else(|| there.get::<JointOf>().map(|of| of.0))
}
