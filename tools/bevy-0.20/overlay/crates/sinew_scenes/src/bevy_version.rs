//! Names that differ between versions of Bevy. This is the module for Bevy 0.20; `tools/bevy-0.20/make` replaces the one for Bevy 0.19 by it.

use bevy::ecs::lifecycle::Add;
use bevy::ecs::observer::On;

/// The event that a component was added to an entity that did not have it.
pub(crate) type OnAdd<'w, 't, T> = On<'w, 't, Add<T>>;
