//! What Bevy names differently from version to version: the one module of this crate that is another for Bevy 0.20, which takes it from
//! `tools/bevy-0.20/overlay`. This is the one for Bevy 0.19.

use bevy::ecs::lifecycle::Add;
use bevy::ecs::observer::On;

/// A component comes that the entity did not have.
pub(crate) type OnAdd<'w, 't, T> = On<'w, 't, Add, T>;
