//! What is kept of entities with Bevy's `Disabled`: which were toggled, and since when each is out of the simulation.

use bevy::ecs::change_detection::Tick;
use bevy::prelude::*;

/// The entities that were disabled or enabled since the last tick, in any order, some of them twice. Scratch.
#[derive(Resource, Default)]
pub(crate) struct Toggled(pub(crate) Vec<Entity>);

/// Marks what was disabled because the body that it belongs to is, and not by the game: it is enabled with that body. Part of the state.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub(crate) struct DisabledWithBody;

/// Marks what has left the simulation: the change tick at which the last tick began that it took part in. What changed since then has not been gathered. `None`
/// before the first tick. Scratch.
#[derive(Component, Clone, Copy, Debug)]
#[component(clone_behavior = Ignore)]
pub(crate) struct LeftAt(pub(crate) Option<Tick>);
