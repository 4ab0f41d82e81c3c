//! Interpolated transforms are not state: a transform that is being interpolated is captured as it was at the end of the tick.

use bevy::prelude::*;
#[cfg(feature = "interpolation")]
use bevy_transform_interpolation::{RotationEasingState, ScaleEasingState, TranslationEasingState};

/// Replaces an interpolated transform by the one at the end of the tick.
#[cfg(feature = "interpolation")]
pub(super) fn tick_end(world: &World, entity: Entity, transform: &mut Transform) {
    let end = world.get::<TranslationEasingState>(entity).and_then(|eased| eased.end);
    transform.translation = end.unwrap_or(transform.translation);
    let end = world.get::<RotationEasingState>(entity).and_then(|eased| eased.end);
    transform.rotation = end.unwrap_or(transform.rotation);
    let end = world.get::<ScaleEasingState>(entity).and_then(|eased| eased.end);
    transform.scale = end.unwrap_or(transform.scale);
}

/// Without interpolation, nothing changes.
#[cfg(not(feature = "interpolation"))]
pub(super) fn tick_end(_: &World, _: Entity, _: &mut Transform) {}

/// Resets the interpolation of an entity that was moved.
pub(super) fn forget(entity: &mut EntityWorldMut) {
    #[cfg(feature = "interpolation")]
    {
        if let Some(mut eased) = entity.get_mut::<TranslationEasingState>() {
            *eased = TranslationEasingState::default();
        }
        if let Some(mut eased) = entity.get_mut::<RotationEasingState>() {
            *eased = RotationEasingState::default();
        }
        if let Some(mut eased) = entity.get_mut::<ScaleEasingState>() {
            *eased = ScaleEasingState::default();
        }
    }
    #[cfg(not(feature = "interpolation"))]
    let _ = entity;
}
