//! What a person sees: meshes that follow particles, and lines for whoever debugs. Nothing here is read back by the simulation.

#[cfg(feature = "interpolation")]
pub(crate) mod ease;
#[cfg(feature = "gizmos")]
pub(crate) mod gizmos;
pub(crate) mod mesh;
pub(crate) mod tube;
#[cfg(feature = "gizmos")]
mod wires;

#[cfg(feature = "gizmos")]
pub use gizmos::{SinewGizmoConfigGroup, SinewGizmoPlugin};

use bevy::math::{Mat3A, Vec3A};
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;

use crate::world::SinewWorld;

/// The way from the world into an entity's own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Where the frame begins, metres. What is drawn is measured from there first, so that it has all its digits five kilometres out too.
    origin: Vec3,
    linear: Mat3A,
}

impl Frame {
    /// That of an entity, computed afresh; `None` if it has no inverse.
    pub(crate) fn of(transforms: &TransformHelper, entity: Entity) -> Option<Self> {
        let transform = transforms.compute_global_transform(entity).ok()?.affine();
        let (origin, linear) = (transform.translation.into(), transform.matrix3.inverse());
        let sound = Vec3::is_finite(origin) && linear.is_finite();
        sound.then_some(Self { origin, linear })
    }

    /// Where a row is drawn, in the frame: at the end of the last tick, or `ease` of the way there from its beginning.
    #[inline]
    pub(crate) fn place(&self, world: &SinewWorld, row: u32, ease: Option<f32>) -> Vec3A {
        let i = row as usize;
        let now = world.simulation.particles.relative_to(i, self.origin);
        let drawn = match ease {
            Some(share) => {
                let before = world.simulation.step_start(i) - self.origin;
                before + (now - before) * share
            }
            None => now,
        };
        self.linear * Vec3A::from(drawn)
    }
}
