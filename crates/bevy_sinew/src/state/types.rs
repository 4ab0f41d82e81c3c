//! The list of state types as a resource: those of this crate, and those that a game adds.

use core::any::TypeId;
use std::sync::Arc;

use bevy::ecs::component::Mutable;
use bevy::prelude::*;
use bevy::reflect::{FromReflect, GetTypeRegistration, TypePath};

use super::values::{Options, StateKind, StateRole, kind, put_resource};
use crate::components::ParticleConstraint;

/// Every type that is state: the contents of a [`SinewSnapshot`](super::SinewSnapshot). The types of this crate are in it from the start; a game's constraints
/// are added by [`register_particle_constraint`](crate::RegisterParticleConstraint), and any other types by [`RegisterState`].
#[derive(Resource, Default)]
pub struct StateTypes {
    pub(super) kinds: Vec<Arc<dyn StateKind>>,
}

/// One entry of [`StateTypes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct StateType<'a> {
    /// The crate and the short name, such as `bevy_sinew::Particle`: its name in files.
    pub name: &'a str,
    /// The id of the Rust type.
    pub id: TypeId,
    /// Its role in the state.
    pub role: StateRole,
    /// Whether its values can be written to a file: whether it is reflected.
    pub reflected: bool,
}

impl StateTypes {
    /// All entries, in the order of registration.
    pub fn iter(&self) -> impl Iterator<Item = StateType<'_>> {
        self.kinds.iter().map(|kind| {
            let (name, id) = (kind.name(), kind.id());
            StateType { name, id, role: kind.role(), reflected: kind.is_reflected() }
        })
    }

    /// Whether a type is state.
    pub fn contains<T: 'static>(&self) -> bool {
        self.find(TypeId::of::<T>()).is_some()
    }

    /// For each component of a world, by the index of its id, whether it is state.
    pub(crate) fn of_components(&self, world: &World) -> Vec<bool> {
        let mut state = vec![false; world.components().len()];
        for kind in self.kinds.iter().filter(|kind| kind.role() != StateRole::Resource) {
            if let Some(id) = world.components().get_id(kind.id()) {
                state[id.index()] = true;
            }
        }
        state
    }

    pub(super) fn find(&self, id: TypeId) -> Option<usize> {
        self.kinds.iter().position(|kind| kind.id() == id)
    }

    /// Adds a type. An entry that is not reflected is replaced by one that is.
    pub(super) fn add(&mut self, kind: Arc<dyn StateKind>) {
        match self.find(kind.id()) {
            None => self.kinds.push(kind),
            Some(place) if kind.is_reflected() && !self.kinds[place].is_reflected() => {
                let role = self.kinds[place].role();
                self.kinds[place] = if role == kind.role() { kind } else { kind.with_role(role) };
            }
            Some(_) => {}
        }
    }
}

/// Adds a game's components and resources to the state of the simulation, so that they are captured and restored with the rest.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::RegisterState;
/// /// Remaining hit points of a crate.
/// #[derive(Component, Reflect, Clone)]
/// struct Health(u32);
///
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins));
/// app.register_state::<Health>();
/// ```
pub trait RegisterState {
    /// Registers a component: it is captured and restored on the entities of the simulation, and written to files. Entities that it refers to are included if
    /// the fields are marked `#[entities]`. A second call for the same type does nothing.
    ///
    /// For a constraint that is registered with [`register_particle_constraint`](crate::RegisterParticleConstraint), it adds that the constraint can be written
    /// to files.
    fn register_state<C>(&mut self) -> &mut Self
    where
        C: Component<Mutability = Mutable> + Clone + FromReflect + TypePath + GetTypeRegistration;

    /// Registers a component that is not reflected: it is captured and restored, but not written to files.
    fn register_unsaved_state<C>(&mut self) -> &mut Self
    where
        C: Component<Mutability = Mutable> + Clone;

    /// Registers a resource: it is captured, restored and written to files. A resource that did not exist at the capture is removed by the restore.
    fn register_state_resource<R>(&mut self) -> &mut Self
    where
        R: Resource + Clone + FromReflect + TypePath + GetTypeRegistration;
}

impl RegisterState for App {
    fn register_state<C>(&mut self) -> &mut Self
    where
        C: Component<Mutability = Mutable> + Clone + FromReflect + TypePath + GetTypeRegistration,
    {
        self.register_type::<C>();
        let role = StateRole::Carried;
        add(self.world_mut(), kind(Options { role, ..Options::<C>::reflected() }));
        self
    }

    fn register_unsaved_state<C>(&mut self) -> &mut Self
    where
        C: Component<Mutability = Mutable> + Clone,
    {
        let plain = Options::<C>::plain();
        add(self.world_mut(), kind(Options { role: StateRole::Carried, hashed: false, ..plain }));
        self
    }

    fn register_state_resource<R>(&mut self) -> &mut Self
    where
        R: Resource + Clone + FromReflect + TypePath + GetTypeRegistration,
    {
        self.register_type::<R>();
        let (role, put) = (StateRole::Resource, put_resource::<R>);
        add(self.world_mut(), kind(Options { role, ..Options::with(put).viewed() }));
        self
    }
}

/// Adds a registered constraint type, which may be reflected or not.
pub(crate) fn add_constraint<T: ParticleConstraint>(world: &mut World) {
    let particles = Some(T::particles as fn(&T) -> &[Entity]);
    add(world, kind(Options { particles, ..Options::<T>::plain() }));
}

pub(super) fn add(world: &mut World, kind: Arc<dyn StateKind>) {
    world.get_resource_or_init::<StateTypes>().add(kind);
}
