//! The order of creation: what decides the row of a particle and the place of a constraint, so that neither a query's order, nor a
//! map's, nor the bits of an entity ever change a result.

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

/// When an entity of the simulation was created: a running number, given once. Part of the state: save and restore it with the rest.
///
/// Cloning an entity gives the clone a number of its own; cloning the component keeps it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[reflect(Component, Default, Clone)]
#[component(clone_behavior = Ignore, on_add = number)]
pub struct CreationOrder(pub(crate) u64);

/// The last number given. Part of the state, so that what is created after a rollback gets the number that it had.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default)]
pub(crate) struct CreationCounter(pub(crate) u64);

/// Set when particles, springs or constraints came or went: the columns must be laid out afresh.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct TopologyChanged(pub(crate) bool);

/// Gives a new entity its number; one that was restored with a number keeps it, and later ones stay above it.
pub(crate) fn number(mut world: DeferredWorld, context: HookContext) {
    let restored = world.get::<CreationOrder>(context.entity).map_or(0, |order| order.0);
    let Some(mut counter) = world.get_resource_mut::<CreationCounter>() else {
        return;
    };
    if restored > 0 {
        counter.0 = counter.0.max(restored);
        return;
    }
    counter.0 += 1;
    let given = counter.0;
    if let Some(mut order) = world.get_mut::<CreationOrder>(context.entity) {
        order.0 = given;
    }
}

/// Hook of every component that takes part in the topology.
pub(crate) fn mark_topology(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut changed) = world.get_resource_mut::<TopologyChanged>() {
        changed.0 = true;
    }
}
