//! Interpolated transforms are not state: a transform that is being interpolated is captured as it was at the end of the tick.

use bevy::prelude::*;

use crate::components::DrawnTransform;
#[cfg(feature = "interpolation")]
use crate::show::ease::PlayedTransform;
#[cfg(feature = "interpolation")]
use bevy_transform_interpolation::{RotationEasingState, ScaleEasingState, TranslationEasingState};

/// Replaces an interpolated transform by the one at the end of the tick. One that the game has changed since stays.
pub(super) fn tick_end(world: &World, entity: Entity, transform: &mut Transform) {
    if let Some(drawn) = world.get::<DrawnTransform>(entity) {
        *transform = drawn.actual(*transform);
    }
}

/// Resets the interpolation of an entity that was moved.
pub(crate) fn forget(entity: &mut EntityWorldMut) {
    if let Some(mut drawn) = entity.get_mut::<DrawnTransform>() {
        *drawn = DrawnTransform::default();
    }
    #[cfg(feature = "interpolation")]
    {
        if let Some(&now) = entity.get::<Transform>()
            && let Some(mut played) = entity.get_mut::<PlayedTransform>()
        {
            *played = PlayedTransform::at(now);
        }
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
}
