//! The order of creation. It determines the row of a particle and the place of a constraint, so that results depend neither on the order of a query or a map,
//! nor on the bits of an entity.

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

/// When an entity of the simulation was created: a number from a counter, assigned once. Part of the state: save and restore it with the rest.
///
/// A cloned entity gets a number of its own; a cloned component keeps it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[reflect(Component, Default, Clone)]
#[component(clone_behavior = Ignore, on_add = number)]
pub struct CreationOrder(pub(crate) u64);

/// The last number that was assigned. Part of the state, so that an entity created after a rollback gets the same number again.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default)]
pub(crate) struct CreationCounter(pub(crate) u64);

/// Set when particles, springs or constraints were added or removed: rows must be assigned again.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct TopologyChanged(pub(crate) bool);

/// Fills a list anew, sorted: with `(CreationOrder, Entity)`, in the order of creation, which that of a query is not.
pub(crate) fn fill_sorted<T: Ord>(list: &mut Vec<T>, items: impl Iterator<Item = T>) {
    list.clear();
    list.extend(items);
    list.sort_unstable();
}

/// Hook: assigns a number to a new entity. A restored entity keeps its number, and later numbers stay above it.
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

/// Hook of the components whose addition or removal changes the topology.
pub(crate) fn mark_topology(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut changed) = world.get_resource_mut::<TopologyChanged>() {
        changed.0 = true;
    }
}
