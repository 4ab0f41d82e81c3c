//! The whole state at one instant, copied out of its world.

use std::collections::BTreeSet;

use bevy::ecs::archetype::{Archetype, ArchetypeEntity};
use bevy::ecs::component::ComponentId;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::entity_disabling::{DefaultQueryFilters, Disabled};
use bevy::ecs::world::WorldId;
use bevy::prelude::*;

use super::types::StateTypes;
use super::values::{Column, Names, StateRole, Values};
use super::{hash, size};
use crate::components::CreationOrder;

/// The whole state of the simulation at one instant: every component and resource in [`StateTypes`]. Cheap to clone.
///
/// It has the entities that are part of the simulation, and those that they refer to or are attached to, such as a moving platform: of these only the
/// transform, the name and the parent. A restored simulation continues bit for bit: in place ([`restore`](Self::restore)), any number of times, or in another
/// app with the same plugins and the same registered constraints. What is drawn (meshes, materials) and messages are not part of it;
/// cloth, soft bodies and ropes get the meshes of their recipes again where the app has meshes.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::SinewSnapshot;
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins));
/// # app.finish();
/// app.world_mut().spawn((RigidBox::default(), Transform::from_xyz(0.0, 3.0, 0.0)));
/// app.update();
/// let before = SinewSnapshot::capture(app.world());
/// app.update();
/// before.restore(app.world_mut())?;
/// assert_eq!(SinewSnapshot::capture(app.world()).hash(), before.hash());
/// # Ok::<(), bevy_sinew::RestoreFault>(())
/// ```
#[derive(Clone, Default)]
pub struct SinewSnapshot {
    /// The world of the entities; `None` for a snapshot from a file.
    pub(super) world: Option<WorldId>,
    /// The entities by index: those that are part of the simulation, in the order of creation; then those that they refer to.
    pub(super) entities: Vec<Entity>,
    /// The order of creation of each entity, 0 if it has none.
    pub(super) orders: Vec<u64>,
    /// The values of each type.
    pub(super) columns: Vec<Column>,
}

impl core::fmt::Debug for SinewSnapshot {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let mut debug = f.debug_struct("SinewSnapshot");
        debug.field("entities", &self.entities.len());
        debug.field("hash", &format_args!("{:#018x}", self.hash())).finish()
    }
}

impl SinewSnapshot {
    /// Copies the state out of a world, which is not changed. Empty if the plugin is missing.
    ///
    /// Call it at any time except in the middle of a tick: between two schedules, or in an exclusive system before or after the tick.
    pub fn capture(world: &World) -> Self {
        let Some(types) = world.get_resource::<StateTypes>() else { return Self::default() };
        let places = Places::new(world, types);
        let mut members = places.members(world);
        members.sort_unstable();
        let mut orders: Vec<u64> =
            members.iter().map(|&(order, _)| order.wrapping_add(1)).collect();
        let mut entities: Vec<Entity> = members.into_iter().map(|(_, entity)| entity).collect();

        let numbers = numbered(&entities);
        let mut taken: Vec<(Vec<u32>, Box<dyn Values>)> = Vec::new();
        let mut names = Names::Note(Vec::new());
        for (kind, holders) in types.kinds.iter().zip(places.holders(world, &numbers)) {
            let resource = || {
                let id = world.components().get_id(kind.id())?;
                Some((0, world.resource_entities().get(id)?))
            };
            let holders = match kind.role() {
                StateRole::Resource => resource().into_iter().collect(),
                _ => holders,
            };
            let (numbers, holders): (Vec<u32>, Vec<Entity>) = holders.into_iter().unzip();
            let mut values = kind.take(world, &holders);
            values.map(&mut names);
            taken.push((numbers, values));
        }
        // Referenced entities are included with their carried components.
        let Names::Note(named) = names else { return Self::default() };
        let others = others(world, named, &numbers);
        entities.extend(&others);
        orders.resize(entities.len(), 0);
        let numbers = numbered(&entities);
        for (kind, (own, values)) in types.kinds.iter().zip(&mut taken) {
            if !matches!(kind.role(), StateRole::Carried | StateRole::Local) {
                continue;
            }
            let Some(id) = world.components().get_id(kind.id()) else { continue };
            let has = |&&entity: &&Entity| {
                world.get_entity(entity).is_ok_and(|entity| entity.contains_id(id))
            };
            let more: Vec<Entity> = others.iter().filter(has).copied().collect();
            if more.is_empty() {
                continue;
            }
            own.extend(more.iter().map(|entity| numbers[entity]));
            let all: Vec<Entity> = own.iter().map(|&number| entities[number as usize]).collect();
            *values = kind.take(world, &all);
        }
        let columns = types.kinds.iter().zip(taken).map(|(kind, (own, mut values))| {
            values.map(&mut Names::Number(&numbers));
            Column { kind: kind.clone(), numbers: own.into(), values: values.into() }
        });
        let columns = columns.filter(|column| column.values.len() > 0).collect();
        Self { world: Some(world.id()), entities, orders, columns }
    }

    /// A hash of the state: of every value of every component and resource, bit by bit. Two worlds in the same state have the same hash, whatever their entity
    /// ids; different states have different hashes, except by chance.
    ///
    /// Handles, reports, and types that are neither reflected nor constraints are left out, and so are entities without a [`CreationOrder`].
    pub fn hash(&self) -> u64 {
        hash::of(&self.orders, &self.columns)
    }

    /// An estimate of the memory that it takes, bytes, within some per cent. Clones share that memory.
    pub fn memory_bytes(&self) -> usize {
        let ids = size_of_val(&*self.entities) + size_of_val(&*self.orders);
        ids + self.columns.iter().map(size::of).sum::<usize>()
    }

    /// Replaces entity ids by those that the [`restore`](Self::restore) of another snapshot assigned; entities that are not in the map keep theirs. For a game
    /// that keeps several snapshots of one world: an entity that was despawned is then spawned again only once, and the next snapshot is restored onto it.
    pub fn rename(&mut self, moved: &EntityHashMap<Entity>) {
        for entity in &mut self.entities {
            *entity = moved.get(entity).copied().unwrap_or(*entity);
        }
    }

    /// The entities of the snapshot, by their ids in its world. In a snapshot from a file, the ids are indices.
    pub fn entities(&self) -> &[Entity] {
        &self.entities
    }
}

/// Which components of a world are state, and which archetypes have them.
pub(super) struct Places {
    /// The state type of each component of the world.
    pub(super) kind_of: Vec<Option<u32>>,
    /// Whether each state type makes its entity part of the simulation.
    marks: Vec<bool>,
    /// The components that disable entities for good: all but `Disabled`.
    hidden: Vec<ComponentId>,
}

impl Places {
    pub(super) fn new(world: &World, types: &StateTypes) -> Self {
        let mut kind_of = vec![None; world.components().len()];
        for (number, kind) in (0..).zip(&types.kinds) {
            let id = world.components().get_id(kind.id());
            if let Some(id) = id.filter(|_| kind.role() != StateRole::Resource) {
                kind_of[id.index()] = Some(number);
            }
        }
        let marks = types.kinds.iter().map(|kind| kind.role() == StateRole::Simulation).collect();
        let filters = world.get_resource::<DefaultQueryFilters>();
        let hidden = filters.into_iter().flat_map(DefaultQueryFilters::disabling_ids);
        // A disabled entity may be enabled again.
        let disabled = world.components().component_id::<Disabled>();
        let hidden = hidden.filter(|&id| Some(id) != disabled).collect();
        Self { kind_of, marks, hidden }
    }

    /// The state types of an archetype; empty if its entities do not take part.
    fn kinds<'a>(&'a self, archetype: &'a Archetype) -> impl Iterator<Item = usize> + 'a {
        let seen = !archetype.is_empty() && !self.hidden.iter().any(|&id| archetype.contains(id));
        let all = archetype.components().iter().filter(move |_| seen);
        all.filter_map(|id| {
            self.kind_of.get(id.index()).copied().flatten().map(|kind| kind as usize)
        })
    }

    fn is_member(&self, archetype: &Archetype) -> bool {
        self.kinds(archetype).any(|kind| self.marks[kind])
    }

    /// The entities that are part of the simulation, with their order of creation minus one: entities without one come last.
    fn members(&self, world: &World) -> Vec<(u64, Entity)> {
        let archetypes = world.archetypes().iter().filter(|archetype| self.is_member(archetype));
        let entities = archetypes.flat_map(Archetype::entities);
        let entities = entities.map(|entity| {
            let order = world.get::<CreationOrder>(entity.id()).map_or(0, |order| order.0);
            (order.wrapping_sub(1), entity.id())
        });
        entities.collect()
    }

    /// The entities with a component of each state type, by index.
    fn holders(&self, world: &World, numbers: &EntityHashMap<u32>) -> Vec<Vec<(u32, Entity)>> {
        let mut holders = vec![Vec::new(); self.marks.len()];
        for archetype in world.archetypes().iter().filter(|archetype| self.is_member(archetype)) {
            for kind in self.kinds(archetype) {
                let all = archetype.entities().iter().map(ArchetypeEntity::id);
                holders[kind].extend(all.map(|entity| (numbers[&entity], entity)));
            }
        }
        holders.iter_mut().for_each(|list: &mut Vec<_>| list.sort_unstable());
        holders
    }
}

/// The entities that are part of the simulation, in the order of creation.
pub(super) fn members(world: &World, types: &StateTypes) -> Vec<Entity> {
    let mut members = Places::new(world, types).members(world);
    members.sort_unstable();
    members.into_iter().map(|(_, entity)| entity).collect()
}

fn numbered(entities: &[Entity]) -> EntityHashMap<u32> {
    entities.iter().zip(0..).map(|(&entity, number)| (entity, number)).collect()
}

/// The entities that are referred to but are not part of the simulation, and their parents; each once, by id.
fn others(world: &World, mut named: Vec<Entity>, known: &EntityHashMap<u32>) -> Vec<Entity> {
    let mut others = BTreeSet::new();
    while let Some(entity) = named.pop() {
        if known.contains_key(&entity) || world.get_entity(entity).is_err() {
            continue;
        }
        if others.insert(entity) {
            named.extend(world.get::<ChildOf>(entity).map(ChildOf::parent));
        }
    }
    others.into_iter().collect()
}
