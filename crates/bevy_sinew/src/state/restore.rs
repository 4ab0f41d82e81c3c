//! Restoring a snapshot: entities that were added since are despawned, those that were despawned are spawned again, and all get the values of the snapshot.

use std::collections::BTreeSet;

use bevy::ecs::component::ComponentId;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::message::Messages;
use bevy::prelude::*;

use super::eased;
use super::snapshot::{Places, SinewSnapshot, members};
use super::types::StateTypes;
use super::values::{StateKind, StateRole};
use crate::breaking::Broke;
use crate::components::{ContactEnded, ContactStarted, Toggled, TopologyChanged};
use crate::recipes::BodyBuilt;
use crate::schedule::PhaseSteps;

/// Why a snapshot cannot be restored. Nothing has changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RestoreFault {
    /// The app has no [`SinewPlugin`](crate::SinewPlugin).
    #[error("the world has no SinewPlugin")]
    NoPlugin,
    /// The snapshot has values of a type that is not registered as state in this app, for instance a custom constraint.
    #[error("{0} is not registered as state in this world")]
    Unregistered(String),
}

impl SinewSnapshot {
    /// Restores the simulation of a world to the state of the snapshot. Returns the current entity for each entity of the snapshot.
    ///
    /// In the world in which it was captured, entities that still exist keep their ids; those that have been despawned since are spawned again with another id;
    /// and entities of the simulation that have been spawned since are despawned. In any other world all entities are spawned, and those that the simulation
    /// had there are despawned. Components that are not state stay on entities that stay. Unread messages of contacts, breaks and builds are dropped, since
    /// they report events that have been undone. Hooks and observers of inserted and removed components run as usual.
    ///
    /// # Errors
    /// A world without the plugin, or one in which a type of the snapshot is not registered. Nothing has changed then.
    pub fn restore(&self, world: &mut World) -> Result<EntityHashMap<Entity>, RestoreFault> {
        self.restore_onto(world, &EntityHashMap::default())
    }

    /// Restores a snapshot, where some despawned entities are `known` to exist again with other ids.
    pub(crate) fn restore_onto(
        &self,
        world: &mut World,
        known: &EntityHashMap<Entity>,
    ) -> Result<EntityHashMap<Entity>, RestoreFault> {
        self.check(world)?;
        // A phase that is shown belongs to a tick that is undone.
        if let Some(mut phases) = world.get_resource_mut::<PhaseSteps>() {
            phases.end();
        }
        world.resource_scope(|world, types: Mut<StateTypes>| Ok(self.put(world, &types, known)))
    }

    /// Whether every type of the snapshot is registered.
    fn check(&self, world: &World) -> Result<(), RestoreFault> {
        let types = world.get_resource::<StateTypes>().ok_or(RestoreFault::NoPlugin)?;
        let lacks = self.columns.iter().find(|column| types.find(column.kind.id()).is_none());
        lacks.map_or(Ok(()), |column| Err(RestoreFault::Unregistered(column.kind.name().into())))
    }

    fn put(
        &self,
        world: &mut World,
        types: &StateTypes,
        known: &EntityHashMap<Entity>,
    ) -> EntityHashMap<Entity> {
        let foreign = self.world != Some(world.id());
        let there = |world: &World, entity: Entity| world.get_entity(entity).is_ok();
        let kept = self.entities.iter().map(|&entity| {
            let own = (!foreign).then_some(entity).filter(|&own| there(world, own));
            own.or(known.get(&entity).copied().filter(|&known| there(world, known)))
        });
        let kept: Vec<Option<Entity>> = kept.collect();

        // No entity may be despawned along with others, or send events.
        let now = members(world, types);
        for kind in &types.kinds {
            now.iter().for_each(|&entity| kind.disconnect(world, entity));
        }
        let stay: BTreeSet<Entity> = kept.iter().flatten().copied().collect();
        for &entity in now.iter().filter(|entity| !stay.contains(*entity)) {
            world.try_despawn(entity).ok();
        }

        // A kept entity may have been despawned along with another one.
        let entities: Vec<Entity> = kept
            .into_iter()
            .map(|kept| match kept.filter(|&kept| there(world, kept)) {
                Some(kept) => kept,
                None => world.spawn_empty().id(),
            })
            .collect();
        self.put_columns(world, types, &entities, foreign);
        entities.iter().for_each(|&entity| {
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                eased::forget(&mut entity);
            }
        });
        if let Some(mut changed) = world.get_resource_mut::<TopologyChanged>() {
            changed.0 = true;
        }
        // The snapshot may have been captured before what belongs to them was disabled.
        let is_disabled = |entity: &&Entity| world.get::<Disabled>(**entity).is_some();
        let disabled: Vec<Entity> = entities.iter().filter(is_disabled).copied().collect();
        if let Some(mut toggled) = world.get_resource_mut::<Toggled>() {
            toggled.0.extend(disabled);
        }
        drop_messages::<ContactStarted>(world);
        drop_messages::<ContactEnded>(world);
        drop_messages::<BodyBuilt>(world);
        drop_messages::<Broke>(world);
        world.flush();
        self.entities.iter().copied().zip(entities).collect()
    }

    /// Restores all values, and removes components that did not exist.
    fn put_columns(
        &self,
        world: &mut World,
        types: &StateTypes,
        entities: &[Entity],
        foreign: bool,
    ) {
        let mut had = Had::new(entities.len(), types.kinds.len());
        let put = |world: &mut World, late: bool| {
            for column in &self.columns {
                let kind = &column.kind;
                let is_list = kind.lists();
                let local = foreign && kind.role() == StateRole::Local;
                if local || is_list != late {
                    continue;
                }
                let onto: Vec<Entity> = match kind.role() {
                    StateRole::Resource => vec![Entity::PLACEHOLDER],
                    _ => column.numbers.iter().map(|&number| entities[number as usize]).collect(),
                };
                column.values.put(world, &onto, entities, foreign);
            }
        };
        for column in &self.columns {
            if let Some(kind) = types.find(column.kind.id()) {
                column.numbers.iter().for_each(|&number| had.note(number as usize, kind));
            }
        }
        put(world, false);
        // Entities that leave a relationship are removed from its list while the lists are empty, before these are restored.
        had.prune(world, types, entities, false);
        put(world, true);
        had.prune(world, types, entities, true);
        for kind in types.kinds.iter().filter(|kind| kind.role() == StateRole::Resource) {
            if !self.columns.iter().any(|column| column.kind.id() == kind.id()) {
                remove_resource(world, &**kind);
            }
        }
    }
}

/// Which entity had which kinds of components: one bit each.
struct Had {
    stride: usize,
    bits: Vec<u64>,
}

impl Had {
    fn new(entities: usize, kinds: usize) -> Self {
        let stride = kinds.div_ceil(64);
        Self { stride, bits: vec![0; stride * entities] }
    }

    fn note(&mut self, entity: usize, kind: usize) {
        if let Some(bits) = self.bits.get_mut(entity * self.stride + kind / 64) {
            *bits |= 1 << (kind % 64);
        }
    }

    fn has(&self, entity: usize, kind: usize) -> bool {
        self.bits[entity * self.stride + kind / 64] & 1 << (kind % 64) != 0
    }

    /// Removes the components that the entities did not have: relationship lists, or all others.
    fn prune(&self, world: &mut World, types: &StateTypes, entities: &[Entity], lists: bool) {
        let places = Places::new(world, types);
        let goes = |place: usize, id: &ComponentId| {
            let number = places.kind_of.get(id.index()).copied().flatten();
            number.map(|number| number as usize).is_some_and(|number| {
                let kind = &types.kinds[number];
                kind.is_pruned() && kind.lists() == lists && !self.has(place, number)
            })
        };
        for (place, &entity) in entities.iter().enumerate() {
            let Ok(there) = world.get_entity(entity) else { continue };
            let all = there.archetype().components().iter().copied();
            let gone: Vec<ComponentId> = all.filter(|id| goes(place, id)).collect();
            for id in gone {
                // A hook of an earlier component may have despawned the entity.
                if let Ok(mut entity) = world.get_entity_mut(entity) {
                    entity.remove_by_id(id);
                }
            }
        }
    }
}

fn remove_resource(world: &mut World, kind: &dyn StateKind) {
    if let Some(id) = world.components().get_id(kind.id()) {
        world.remove_resource_by_id(id);
    }
}

fn drop_messages<M: Message>(world: &mut World) {
    if let Some(mut messages) = world.get_resource_mut::<Messages<M>>() {
        messages.clear();
    }
}
