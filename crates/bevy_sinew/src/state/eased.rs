//! What is drawn between two ticks is no state: a transform that is being eased counts as it was when the tick ended.

use bevy::prelude::*;
#[cfg(feature = "interpolation")]
use bevy_transform_interpolation::{RotationEasingState, ScaleEasingState, TranslationEasingState};

/// Makes of a transform as it is drawn the one that the tick left.
#[cfg(feature = "interpolation")]
pub(super) fn settled(world: &World, entity: Entity, transform: &mut Transform) {
    let end = world.get::<TranslationEasingState>(entity).and_then(|eased| eased.end);
    transform.translation = end.unwrap_or(transform.translation);
    let end = world.get::<RotationEasingState>(entity).and_then(|eased| eased.end);
    transform.rotation = end.unwrap_or(transform.rotation);
    let end = world.get::<ScaleEasingState>(entity).and_then(|eased| eased.end);
    transform.scale = end.unwrap_or(transform.scale);
}

/// The same where nothing is eased.
#[cfg(not(feature = "interpolation"))]
pub(super) fn settled(_: &World, _: Entity, _: &mut Transform) {}

/// Forgets how an entity was eased: it is elsewhere now.
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
