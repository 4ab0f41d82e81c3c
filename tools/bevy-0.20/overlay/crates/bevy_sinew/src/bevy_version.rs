//! Names that differ between Bevy versions. This is the only module of the crate that is replaced for Bevy 0.20. This is the one for Bevy 0.20;
//! `tools/bevy-0.20/make` puts it in the place of its twin for Bevy 0.19.

use bevy::ecs::lifecycle::{Add, Remove};
use bevy::ecs::observer::On;

/// The event of a component that is added to an entity.
pub(crate) type OnAdd<'w, 't, T> = On<'w, 't, Add<T>>;

/// The event of a component that is removed from an entity.
pub(crate) type OnRemove<'w, 't, T> = On<'w, 't, Remove<T>>;

#[cfg(feature = "drag")]
pub(crate) use pointers::{OnPress, pointer};

#[cfg(feature = "drag")]
mod pointers {
    use bevy::ecs::observer::On;
    use bevy::picking::events::PointerPress;
    use bevy::picking::pointer::PointerId;

    /// The event of a pointer that is pressed over an entity.
    pub(crate) type OnPress<'w, 't> = On<'w, 't, PointerPress>;

    /// Returns the pointer of a press.
    pub(crate) fn pointer(press: &OnPress) -> PointerId {
        press.pointer.id
    }
}
