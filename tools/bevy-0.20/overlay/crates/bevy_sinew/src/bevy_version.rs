//! What Bevy names differently from version to version: the one module of this crate that differs. This is the one for Bevy 0.20, which
//! `tools/bevy-0.20/make` puts in the place of that for Bevy 0.19.

use bevy::ecs::lifecycle::Remove;
use bevy::ecs::observer::On;

/// A component of an entity goes.
pub(crate) type OnRemove<'w, 't, T> = On<'w, 't, Remove<T>>;

#[cfg(feature = "drag")]
pub(crate) use pointers::{OnPress, pointer};

#[cfg(feature = "drag")]
mod pointers {
    use bevy::ecs::observer::On;
    use bevy::picking::events::PointerPress;
    use bevy::picking::pointer::PointerId;

    /// A pointer is pressed over an entity.
    pub(crate) type OnPress<'w, 't> = On<'w, 't, PointerPress>;

    /// Which pointer it is.
    pub(crate) fn pointer(press: &OnPress) -> PointerId {
        press.pointer.id
    }
}
