//! The registered constraint types besides distances and springs: those of this crate, and those of a game, which are registered in the same way.

use core::any::TypeId;

use bevy::ecs::component::ComponentId;
use bevy::ecs::lifecycle::RemovedComponentMessages;
use bevy::prelude::*;
use sinew::Simulation;

use super::change_detection::ChangeDetector;
use super::entry::{LinkEntry, recompile_tail, unchanged_prefix, update_incrementally};
use crate::attach::AnchorConstraint;
use crate::components::{CreationOrder, ParticleConstraint, for_each_constraint};
use crate::messages::Refusal;
use crate::state::add_constraint;
use crate::world::{LinkKey, SinewWorld, Tables};

/// Indices of the kinds that have lists of their own; registered kinds follow.
pub(super) const DISTANCES: usize = 0;
pub(super) const SPRINGS: usize = 1;
const FIRST: usize = 2;

/// Registers custom constraints in an [`App`].
pub trait RegisterParticleConstraint {
    /// Registers the component `T` as a constraint, which is enforced from the next tick on. [`CreationOrder`] becomes a required component of it.
    ///
    /// It may be called before or after the plugins are added, but should be called before the first `T` is spawned: existing ones are numbered when the
    /// simulation first processes them, in the order of their entities. A second call for the same type does nothing.
    fn register_particle_constraint<T: ParticleConstraint>(&mut self) -> &mut Self;
}

impl RegisterParticleConstraint for App {
    fn register_particle_constraint<T: ParticleConstraint>(&mut self) -> &mut Self {
        let world = self.world_mut();
        add_constraint::<T>(world);
        // It fails if `T` already requires it, which is fine, or if some `T` exist, which `TypedConstraint::number` handles.
        let _ = world.try_register_required_components::<T, CreationOrder>();
        let kind = Box::new(TypedConstraint::<T>::new(world));
        let kinds = &mut world.get_resource_or_init::<Kinds>().kinds;
        if kinds.iter().all(|known| known.of() != kind.of()) {
            kinds.push(kind);
        }
        self
    }
}

/// Registers some constraint types.
macro_rules! solved {
    ($app:ident: $($constraint:ty,)*) => {
        $app$(.register_particle_constraint::<$constraint>())*
    };
}

/// Registers the constraint types of this crate.
pub(crate) fn register_ours(app: &mut App) {
    for_each_constraint!(solved!(app:)).register_particle_constraint::<AnchorConstraint>();
}

/// The registered types, in the order of registration, and the entries that were collected from them in this tick.
#[derive(Resource, Default)]
pub(crate) struct Kinds {
    /// Changes of distances, which have a list of their own.
    pub(super) distances: ChangeDetector,
    kinds: Vec<Box<dyn ConstraintType>>,
    collected: Collected,
}

/// The entries of the registered types.
pub(super) enum Collected {
    /// All of them, valid or not.
    All(Vec<LinkEntry<sinew::Constraint>>),
    /// The contents of the solver's list from this index on.
    From(usize, Vec<sinew::Constraint>),
}

/// Empty.
impl Default for Collected {
    fn default() -> Self {
        Self::All(Vec::new())
    }
}

impl Kinds {
    /// Updates the list incrementally if there are few changes. Otherwise marks the tables as stale; if they are, collects what is to be compiled.
    pub(super) fn collect(&mut self, world: &mut World, sinew: &mut SinewWorld) {
        let SinewWorld { simulation, tables } = sinew;
        let mut any = false;
        for kind in &mut self.kinds {
            kind.number(world);
            kind.refresh(world);
            any |= kind.detector().is_any();
            tables.links_stale |= !kind.detector().is_few();
        }
        tables.links_stale |= any && !tables.links.complete;
        for (number, kind) in (FIRST..).zip(&mut self.kinds) {
            if !tables.links_stale && kind.detector().is_any() {
                let mut entries = Vec::new();
                kind.collect_changed(world, tables, number, &mut entries);
                let keys = &mut tables.links.constraints;
                tables.links_stale =
                    !update_incrementally(simulation, keys, entries, (number, kind.detector()));
                tables.links.version += 1;
            }
        }
        if tables.links_stale {
            let changed = self.collect_from(world, (simulation, tables));
            self.collected = changed.unwrap_or_else(|| {
                let mut all = Vec::new();
                for (number, kind) in (FIRST..).zip(&mut self.kinds) {
                    kind.collect(world, tables, number, None, &mut all);
                }
                Collected::All(all)
            });
        }
    }

    /// Collects the entries from the first one on that differs; `None` if all must be collected.
    fn collect_from(
        &mut self,
        world: &World,
        (simulation, tables): (&Simulation, &mut Tables),
    ) -> Option<Collected> {
        if !tables.links.complete || tables.set_aside > 0 {
            return None;
        }
        let changes = self.kinds.iter().map(|kind| kind.detector());
        let changed = changes.map(|detector| detector.added.len() + detector.gone.len()).sum();
        let unchanged = unchanged_prefix(
            simulation.constraints(),
            tables.layout.same_since(tables.links.layout),
            changed,
        )?;
        let mut keys = core::mem::take(&mut tables.links.constraints);
        let (mut added, mut gone, mut count) = (Vec::new(), Vec::new(), 0);
        for (number, kind) in (FIRST..).zip(&mut self.kinds) {
            kind.collect_changed(world, tables, number, &mut added);
            gone.extend_from_slice(&kind.detector().gone);
            count += kind.detector().count();
        }
        let kinds = &self.kinds;
        let recompiled =
            recompile_tail(&mut keys, (unchanged, count), (added, &gone), |tail, entries| {
                for (number, kind) in (FIRST..).zip(kinds) {
                    let own = tail.iter().filter(|key| key.kind == number);
                    let own: Vec<Entity> = own.map(|key| key.entity).collect();
                    kind.collect(world, tables, number, Some(&own), entries);
                }
            });
        tables.links.constraints = keys;
        recompiled.map(|(kept, list)| Collected::From(kept, list))
    }

    /// Records which constraints were removed.
    pub(super) fn note_gone(&mut self, removed: &RemovedComponentMessages) {
        self.kinds.iter_mut().for_each(|kind| kind.note_gone(removed));
    }

    /// Returns what was collected.
    pub(super) fn take(&mut self) -> Collected {
        core::mem::take(&mut self.collected)
    }
}

/// One registered type, without its Rust type.
trait ConstraintType: Send + Sync {
    fn of(&self) -> TypeId;

    /// Assigns numbers to components that have none.
    fn number(&mut self, world: &mut World);

    /// Detects changes since the calling system last ran.
    fn refresh(&mut self, world: &World);

    /// Records removals.
    fn note_gone(&mut self, removed: &RemovedComponentMessages);

    /// The detected changes.
    fn detector(&self) -> &ChangeDetector;

    /// Collects all entries, or those of some entities that have the component.
    fn collect(
        &self,
        world: &World,
        tables: &Tables,
        number: usize,
        some: Option<&[Entity]>,
        entries: &mut Vec<LinkEntry<sinew::Constraint>>,
    );

    /// Collects the entries that were added or changed.
    fn collect_changed(
        &self,
        world: &World,
        tables: &Tables,
        number: usize,
        entries: &mut Vec<LinkEntry<sinew::Constraint>>,
    ) {
        self.collect(world, tables, number, Some(&self.detector().added), entries);
    }
}

struct TypedConstraint<T: ParticleConstraint> {
    all: QueryState<(Entity, &'static CreationOrder, &'static T)>,
    present: QueryState<(Entity, Ref<'static, T>), With<CreationOrder>>,
    unnumbered: QueryState<Entity, (With<T>, Without<CreationOrder>)>,
    id: ComponentId,
    detector: ChangeDetector,
}

impl<T: ParticleConstraint> TypedConstraint<T> {
    fn new(world: &mut World) -> Self {
        Self {
            all: QueryState::new(world),
            present: QueryState::new(world),
            unnumbered: QueryState::new(world),
            id: world.register_component::<T>(),
            detector: ChangeDetector::default(),
        }
    }

    fn entry(
        tables: &Tables,
        number: usize,
        (entity, &order, component): (Entity, &CreationOrder, &T),
    ) -> LinkEntry<sinew::Constraint> {
        let key = LinkKey { order, entity, kind: number };
        LinkEntry::new(tables, key, component.particles(), |rows| match component.fault() {
            None => Ok(sinew::Constraint { rows, kind: component.kind() }),
            Some(fault) => Err(Refusal::Constraint(fault)),
        })
    }
}

impl<T: ParticleConstraint> ConstraintType for TypedConstraint<T> {
    fn of(&self) -> TypeId {
        TypeId::of::<T>()
    }

    fn number(&mut self, world: &mut World) {
        if self.unnumbered.query(world).is_empty() {
            return;
        }
        let mut unnumbered: Vec<Entity> = self.unnumbered.iter(world).collect();
        unnumbered.sort_unstable();
        for entity in unnumbered {
            // An observer of an earlier entity may have despawned it.
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                entity.insert(CreationOrder::default());
            }
        }
    }

    fn refresh(&mut self, world: &World) {
        let Self { all, present, id, detector, .. } = self;
        all.update_archetypes(world);
        detector.note_gone(world.removed_components().get(*id));
        detector.detect(&present.query(world));
    }

    fn note_gone(&mut self, removed: &RemovedComponentMessages) {
        self.detector.note_gone(removed.get(self.id));
    }

    fn detector(&self) -> &ChangeDetector {
        &self.detector
    }

    fn collect(
        &self,
        world: &World,
        tables: &Tables,
        number: usize,
        some: Option<&[Entity]>,
        entries: &mut Vec<LinkEntry<sinew::Constraint>>,
    ) {
        let entry = |one| Self::entry(tables, number, one);
        match some {
            Some(some) => {
                let those =
                    some.iter().filter_map(|&entity| self.all.get_manual(world, entity).ok());
                entries.extend(those.map(entry));
            }
            None => entries.extend(self.all.iter_manual(world).map(entry)),
        }
    }
}
