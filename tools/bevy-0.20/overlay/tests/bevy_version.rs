//! What Bevy names differently from version to version: the one module of these suites that differs. This is the one for Bevy 0.20, which
//! `tools/bevy-0.20/make` puts in the place of that for Bevy 0.19.

use bevy::ecs::lifecycle::{Add, Insert};
use bevy::ecs::observer::On;

/// A component comes that the entity did not have.
pub(crate) type OnAdd<'w, 't, T> = On<'w, 't, Add<T>>;

/// A component comes, or another value of it.
pub(crate) type OnInsert<'w, 't, T> = On<'w, 't, Insert<T>>;
