//! What Bevy names differently from version to version. This is the module for Bevy 0.19; for Bevy 0.20 `tools/bevy-0.20/overlay` replaces it, the only module
//! of these suites that differs.

use bevy::ecs::lifecycle::{Add, Insert};
use bevy::ecs::observer::On;

/// Triggered when a component is added that the entity did not have.
pub(crate) type OnAdd<'w, 't, T> = On<'w, 't, Add, T>;

/// Triggered when a component is added or replaced.
pub(crate) type OnInsert<'w, 't, T> = On<'w, 't, Insert, T>;
