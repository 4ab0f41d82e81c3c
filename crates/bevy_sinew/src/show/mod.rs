//! What a person sees: meshes that follow particles, and lines for whoever debugs. Nothing here is read back by the simulation.

#[cfg(feature = "gizmos")]
pub(crate) mod gizmos;
pub(crate) mod mesh;
pub(crate) mod tube;

#[cfg(feature = "gizmos")]
pub use gizmos::{SinewGizmoConfigGroup, SinewGizmoPlugin};

use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;

use crate::world::SinewWorld;

/// Where a row is drawn, metres: at the end of the last tick, or `ease` of the way there from its beginning.
pub(crate) fn drawn_position(world: &SinewWorld, row: u32, ease: Option<f32>) -> Vec3 {
    let i = row as usize;
    let now = world.simulation.particles.position(i);
    match ease {
        Some(share) => {
            let before = world.simulation.step_start(i);
            before + (now - before) * share
        }
        None => now,
    }
}

/// The matrix from the world into an entity's own frame, computed afresh; `None` if it has no inverse.
pub(crate) fn into_frame(transforms: &TransformHelper, entity: Entity) -> Option<Mat4> {
    let inverse = transforms.compute_global_transform(entity).ok()?.to_matrix().inverse();
    inverse.is_finite().then_some(inverse)
}
