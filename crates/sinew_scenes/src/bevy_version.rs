//! Names that differ between versions of Bevy. This is the module for Bevy 0.19; the build for Bevy 0.20 replaces it by the one in `tools/bevy-0.20/overlay`.

use bevy::ecs::lifecycle::Add;
use bevy::ecs::observer::On;

/// The event that a component was added to an entity that did not have it.
pub(crate) type OnAdd<'w, 't, T> = On<'w, 't, Add, T>;
