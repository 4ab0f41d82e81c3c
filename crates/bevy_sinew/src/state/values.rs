//! The values of one state type: how they are copied out of a world and back.
//!
//! The operations that differ from type to type are functions in [`Options`]; everything else works on all types in the same way, without knowing them. Outside
//! of a world, the entities that a value refers to are indices of the snapshot's entities, so that the value is valid in any world.

use core::any::{TypeId, type_name};
use std::sync::Arc;

use bevy::ecs::component::Mutable;
use bevy::ecs::entity::{EntityHashMap, EntityMapper};
use bevy::ecs::relationship::{Relationship, RelationshipHookMode, RelationshipTarget};
use bevy::prelude::*;
use bevy::reflect::{FromReflect, PartialReflect, TypePath};

/// The role of a type in the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum StateRole {
    /// A component that makes its entity part of the simulation.
    Simulation,
    /// A component that is captured if its entity is part of the simulation, or is referred to by one that is.
    Carried,
    /// Like `Carried`, but valid in its own world only, such as a handle: it is not restored into another world.
    Local,
    /// A resource.
    Resource,
}

/// How the values of one type are handled.
pub(super) struct Options<C> {
    pub(super) role: StateRole,
    /// Whether a restore removes it from entities that did not have it.
    pub(super) pruned: bool,
    /// Whether it is hashed.
    pub(super) hashed: bool,
    /// Whether it is the list of a relationship.
    pub(super) lists: bool,
    /// Its name, and the conversion to and from reflection.
    pub(super) reflection: Option<Reflection<C>>,
    /// Restores a value.
    pub(super) put: fn(&mut World, Entity, C),
    /// Adjusts a value that was copied from the world.
    pub(super) on_capture: Option<fn(&World, Entity, &mut C)>,
    /// Clears what is not valid in another world.
    pub(super) on_foreign: Option<fn(&mut C)>,
    /// Disconnects an existing component from other entities, before anything is despawned.
    pub(super) disconnect: Option<fn(&mut World, Entity)>,
    /// The particles of a constraint.
    pub(super) particles: Option<fn(&C) -> &[Entity]>,
}

/// Access to a type by reflection.
pub(super) struct Reflection<C> {
    name: fn() -> String,
    view: fn(&C) -> &dyn PartialReflect,
    make: fn(&dyn PartialReflect) -> Option<C>,
}

impl<C> Clone for Reflection<C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<C> Copy for Reflection<C> {}

impl<C> Clone for Options<C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<C> Copy for Options<C> {}

impl<C: Component<Mutability = Mutable> + Clone> Options<C> {
    /// Options of a component that makes its entity part of the simulation, and is not reflected.
    pub(super) fn plain() -> Self {
        Self::with(assign::<C>)
    }

    /// The same for a reflected component.
    pub(super) fn reflected() -> Self
    where
        C: FromReflect + TypePath,
    {
        Self::plain().viewed()
    }
}

impl<C: Component + Clone> Options<C> {
    pub(super) fn with(put: fn(&mut World, Entity, C)) -> Self {
        Self {
            role: StateRole::Simulation,
            pruned: true,
            hashed: true,
            lists: false,
            reflection: None,
            put,
            on_capture: None,
            on_foreign: None,
            disconnect: None,
            particles: None,
        }
    }

    /// Returns the same options with access by reflection.
    pub(super) fn viewed(self) -> Self
    where
        C: FromReflect + TypePath,
    {
        let name = || {
            let of = C::crate_name().unwrap_or_default();
            format!("{of}::{}", C::short_type_path())
        };
        // A value of the type itself is cloned: reflection omits ignored fields.
        let make = |value: &dyn PartialReflect| {
            value.try_downcast_ref::<C>().cloned().or_else(|| C::from_reflect(value))
        };
        let reflection = Reflection { name, view: C::as_partial_reflect, make };
        Self { reflection: Some(reflection), ..self }
    }
}

/// Overwrites a component, or inserts it if it does not exist.
fn assign<C: Component<Mutability = Mutable>>(world: &mut World, entity: Entity, value: C) {
    let Ok(mut entity) = world.get_entity_mut(entity) else { return };
    if let Some(mut own) = entity.get_mut::<C>() {
        *own = value;
        return;
    }
    entity.insert(value);
}

/// Inserts a component if it does not exist; an existing one is kept.
pub(super) fn supply<C: Component>(world: &mut World, entity: Entity, value: C) {
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.insert_if_new(value);
    }
}

/// Inserts a relationship without its hook, since the list is restored separately.
pub(super) fn join<R: Relationship>(world: &mut World, entity: Entity, value: R) {
    let Ok(mut entity) = world.get_entity_mut(entity) else { return };
    if entity.get::<R>().map(R::get) != Some(value.get()) {
        entity.insert_with_relationship_hook_mode(value, RelationshipHookMode::Skip);
    }
}

/// Inserts a relationship, whose list is updated by its hook.
pub(super) fn join_listed<R: Relationship>(world: &mut World, entity: Entity, value: R) {
    let Ok(mut entity) = world.get_entity_mut(entity) else { return };
    if entity.get::<R>().map(R::get) != Some(value.get()) {
        entity.insert(value);
    }
}

/// Empties the list of a relationship, so that no entity is despawned with it.
pub(super) fn empty<T: RelationshipTarget<Collection = Vec<Entity>>>(
    world: &mut World,
    entity: Entity,
) {
    if let Some(mut list) = world.get_mut::<T>(entity) {
        list.collection_mut_risky().clear();
    }
}

pub(super) fn put_resource<R: Resource>(world: &mut World, _: Entity, value: R) {
    world.insert_resource(value);
}

/// How the entities that a value refers to are mapped.
pub(super) enum Names<'a> {
    /// They are recorded.
    Note(Vec<Entity>),
    /// They are replaced by indices; an entity without one becomes the placeholder.
    Number(&'a EntityHashMap<u32>),
    /// Indices are replaced by these entities; an invalid index becomes the placeholder.
    Read(&'a [Entity]),
}

impl Names<'_> {
    fn noted(&self) -> Option<usize> {
        if let Self::Note(noted) = self { Some(noted.len()) } else { None }
    }
}

impl EntityMapper for Names<'_> {
    fn get_mapped(&mut self, source: Entity) -> Entity {
        let mapped = match self {
            Self::Note(noted) => {
                noted.push(source);
                Some(source)
            }
            Self::Number(numbers) => {
                numbers.get(&source).and_then(|&number| Entity::from_raw_u32(number))
            }
            Self::Read(entities) => entities.get(source.index_u32() as usize).copied(),
        };
        mapped.unwrap_or(Entity::PLACEHOLDER)
    }

    fn set_mapped(&mut self, _: Entity, _: Entity) {}
}

/// One state type, without its Rust type.
pub(super) trait StateKind: Send + Sync {
    fn id(&self) -> TypeId;

    fn name(&self) -> &str;

    fn role(&self) -> StateRole;

    fn is_pruned(&self) -> bool;

    fn is_hashed(&self) -> bool;

    fn is_reflected(&self) -> bool;

    /// Whether it is the list of a relationship.
    fn lists(&self) -> bool;

    /// The same kind in another role.
    fn with_role(&self, role: StateRole) -> Arc<dyn StateKind>;

    /// Clones the values of those entities that have one; of a resource, the one of the world.
    fn take(&self, world: &World, entities: &[Entity]) -> Box<dyn Values>;

    /// An empty list, to which values can be [pushed](Values::push).
    #[cfg_attr(not(feature = "serialize"), expect(dead_code))]
    fn none(&self) -> Box<dyn Values>;

    fn disconnect(&self, world: &mut World, entity: Entity);
}

/// Values of one type, in the order of their entities.
pub(super) trait Values: Send + Sync {
    fn len(&self) -> usize;

    /// Records or replaces the entities that they refer to.
    fn map(&mut self, entities: &mut Names);

    /// Restores them onto as many entities. `names` has the entity of each index.
    fn put(&self, world: &mut World, onto: &[Entity], names: &[Entity], foreign: bool);

    /// The memory of the values without the heap, bytes, and whether any of them may have heap memory.
    fn bytes(&self) -> (usize, bool);

    /// A value by reflection; `None` if its type is not reflected.
    fn view(&self, place: usize) -> Option<&dyn PartialReflect>;

    /// Adds a value from reflection. Returns whether the conversion succeeded.
    #[cfg_attr(not(feature = "serialize"), expect(dead_code))]
    fn push(&mut self, value: &dyn PartialReflect) -> bool;

    /// The particles of a constraint, by index.
    fn particles(&self, place: usize) -> &[Entity];
}

/// The values of one type.
#[derive(Clone)]
pub(super) struct Column {
    pub(super) kind: Arc<dyn StateKind>,
    /// The index of the entity of each value, ascending. 0 for a resource.
    pub(super) numbers: Arc<[u32]>,
    pub(super) values: Arc<dyn Values>,
}

/// Makes a kind from its options.
pub(super) fn kind<C: Component + Clone>(options: Options<C>) -> Arc<dyn StateKind> {
    let name = options.reflection.map_or_else(|| type_name::<C>().into(), |of| (of.name)());
    Arc::new(TypedState { options, name })
}

struct TypedState<C> {
    options: Options<C>,
    name: String,
}

struct List<C> {
    options: Options<C>,
    values: Vec<C>,
}

impl<C: Component + Clone> StateKind for TypedState<C> {
    fn id(&self) -> TypeId {
        TypeId::of::<C>()
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> StateRole {
        self.options.role
    }

    fn is_pruned(&self) -> bool {
        self.options.pruned
    }

    fn is_hashed(&self) -> bool {
        self.options.hashed
    }

    fn is_reflected(&self) -> bool {
        self.options.reflection.is_some()
    }

    fn lists(&self) -> bool {
        self.options.lists
    }

    fn with_role(&self, role: StateRole) -> Arc<dyn StateKind> {
        kind(Options { role, ..self.options })
    }

    fn take(&self, world: &World, entities: &[Entity]) -> Box<dyn Values> {
        let mut values = Vec::with_capacity(entities.len());
        for &entity in entities {
            let Some(value) = world.get::<C>(entity) else { continue };
            let mut value = value.clone();
            if let Some(on_capture) = self.options.on_capture {
                on_capture(world, entity, &mut value);
            }
            values.push(value);
        }
        Box::new(List { options: self.options, values })
    }

    fn none(&self) -> Box<dyn Values> {
        Box::new(List { options: self.options, values: Vec::new() })
    }

    fn disconnect(&self, world: &mut World, entity: Entity) {
        if let Some(disconnect) = self.options.disconnect {
            disconnect(world, entity);
        }
    }
}

impl<C: Component + Clone> Values for List<C> {
    fn len(&self) -> usize {
        self.values.len()
    }

    fn map(&mut self, entities: &mut Names) {
        for value in &mut self.values {
            let before = entities.noted();
            <C as Component>::map_entities(value, entities);
            let particles = self.options.particles.map_or(0, |particles| particles(value).len());
            if entities.noted().zip(before).is_some_and(|(now, before)| now < before + particles) {
                warn_once!(
                    "sinew: {} has particles that are not marked #[entities]: it cannot be restored onto other entities",
                    type_name::<C>()
                );
            }
        }
    }

    fn put(&self, world: &mut World, onto: &[Entity], names: &[Entity], foreign: bool) {
        for (value, &entity) in self.values.iter().zip(onto) {
            let mut value = value.clone();
            <C as Component>::map_entities(&mut value, &mut Names::Read(names));
            if let (true, Some(on_foreign)) = (foreign, self.options.on_foreign) {
                on_foreign(&mut value);
            }
            (self.options.put)(world, entity, value);
        }
    }

    fn bytes(&self) -> (usize, bool) {
        (size_of_val(self.values.as_slice()), core::mem::needs_drop::<C>())
    }

    fn view(&self, place: usize) -> Option<&dyn PartialReflect> {
        Some((self.options.reflection?.view)(self.values.get(place)?))
    }

    fn push(&mut self, value: &dyn PartialReflect) -> bool {
        let made = self.options.reflection.and_then(|reflection| (reflection.make)(value));
        let is_made = made.is_some();
        self.values.extend(made);
        is_made
    }

    fn particles(&self, place: usize) -> &[Entity] {
        let particles = self.options.particles.zip(self.values.get(place));
        particles.map_or(&[], |(particles, value)| particles(value))
    }
}
