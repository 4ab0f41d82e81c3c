//! Which types of constraints there are beside distances and springs: ours, and those that a game registers, by one door.

use core::any::TypeId;

use bevy::prelude::*;

use super::super::changes::census;
use super::entry::{Entry, Place};
use crate::components::{
    AngleConstraint, AreaConstraint, BendConstraint, CollinearConstraint, ConeConstraint,
    CoplanarConstraint, CreationOrder, HingeConstraint, LawConstraint, ParticleConstraint,
    PatchConstraint, RigidConstraint, TetrahedronConstraint, VolumeConstraint,
};
use crate::messages::Refusal;
use crate::world::Tables;

/// Numbers of the kinds that have lists of their own; registered ones follow.
pub(super) const DISTANCES: usize = 0;
pub(super) const SPRINGS: usize = 1;
const FIRST: usize = 2;

/// Adds a game's own constraints to an [`App`].
pub trait RegisterParticleConstraint {
    /// Has all components of type `T` enforced from the next tick on. They get a [`CreationOrder`] as a required component.
    ///
    /// It may be called before or after the plugins are added, but should be before the first `T` is spawned: ones that are there already are numbered
    /// when the simulation first sees them, one after the other by their entity. A second call for the same type does nothing.
    fn register_particle_constraint<T: ParticleConstraint>(&mut self) -> &mut Self;
}

impl RegisterParticleConstraint for App {
    fn register_particle_constraint<T: ParticleConstraint>(&mut self) -> &mut Self {
        let world = self.world_mut();
        // It fails where `T` requires it already, which is well, and where some `T` are there: `Of::number` sees to those.
        let _ = world.try_register_required_components::<T, CreationOrder>();
        let kind = Box::new(Of::<T>::new(world));
        let kinds = &mut world.get_resource_or_init::<Kinds>().kinds;
        if kinds.iter().all(|known| known.of() != kind.of()) {
            kinds.push(kind);
        }
        self
    }
}

/// Registers what comes with the plugin.
pub(crate) fn register_ours(app: &mut App) {
    app.register_particle_constraint::<AngleConstraint>()
        .register_particle_constraint::<HingeConstraint>()
        .register_particle_constraint::<ConeConstraint>()
        .register_particle_constraint::<AreaConstraint>()
        .register_particle_constraint::<PatchConstraint>()
        .register_particle_constraint::<TetrahedronConstraint>()
        .register_particle_constraint::<VolumeConstraint>()
        .register_particle_constraint::<BendConstraint>()
        .register_particle_constraint::<CoplanarConstraint>()
        .register_particle_constraint::<CollinearConstraint>()
        .register_particle_constraint::<RigidConstraint>()
        .register_particle_constraint::<LawConstraint>();
}

/// The types that were registered, in that order, and what was collected of them for this tick.
#[derive(Resource, Default)]
pub(crate) struct Kinds {
    kinds: Vec<Box<dyn Kind>>,
    entries: Vec<Entry<sinew::Constraint>>,
}

impl Kinds {
    /// Marks the tables stale if one came, went or changed, and collects all if they are.
    pub(super) fn collect(&mut self, world: &mut World, tables: &mut Tables) {
        for kind in &mut self.kinds {
            kind.number(world);
            tables.stale |= kind.notice(world);
        }
        if tables.stale {
            for (number, kind) in (FIRST..).zip(&mut self.kinds) {
                kind.collect(world, tables, number, &mut self.entries);
            }
        }
    }

    /// What was collected.
    pub(super) fn take(&mut self) -> Vec<Entry<sinew::Constraint>> {
        core::mem::take(&mut self.entries)
    }
}

/// One registered type, seen without knowing it.
trait Kind: Send + Sync {
    fn of(&self) -> TypeId;

    /// Numbers those that came without a number.
    fn number(&mut self, world: &mut World);

    /// Whether one came, went or changed since the system that asks last ran.
    fn notice(&mut self, world: &World) -> bool;

    fn collect(
        &mut self,
        world: &World,
        tables: &Tables,
        number: usize,
        entries: &mut Vec<Entry<sinew::Constraint>>,
    );
}

struct Of<T: ParticleConstraint> {
    all: QueryState<(Entity, &'static CreationOrder, &'static T)>,
    present: QueryState<Ref<'static, T>, With<CreationOrder>>,
    unnumbered: QueryState<Entity, (With<T>, Without<CreationOrder>)>,
    /// How many there were. No hook and no observer, which are the game's; and Bevy's list of what was removed is kept for two frames, when
    /// a tick may be farther away. What came is changed, so that fewer than before is all that is left to notice.
    count: usize,
}

impl<T: ParticleConstraint> Of<T> {
    fn new(world: &mut World) -> Self {
        let (all, present) = (QueryState::new(world), QueryState::new(world));
        Self { all, present, unnumbered: QueryState::new(world), count: 0 }
    }
}

impl<T: ParticleConstraint> Kind for Of<T> {
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
            // An observer of one before it may have despawned it.
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                entity.insert(CreationOrder::default());
            }
        }
    }

    fn notice(&mut self, world: &World) -> bool {
        let (now, changed) = census(&self.present.query(world));
        let went = core::mem::replace(&mut self.count, now) != now;
        went || changed
    }

    fn collect(
        &mut self,
        world: &World,
        tables: &Tables,
        number: usize,
        entries: &mut Vec<Entry<sinew::Constraint>>,
    ) {
        entries.extend(self.all.iter(world).map(|(entity, &order, component)| {
            let place = Place { order, entity, kind: number };
            Entry::new(tables, place, component.particles(), |rows| match component.fault() {
                None => Ok(sinew::Constraint { rows, law: component.law() }),
                Some(fault) => Err(Refusal::Constraint(fault)),
            })
        }));
    }
}
