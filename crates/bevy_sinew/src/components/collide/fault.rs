//! Errors of colliders.

use sinew::ShapeFault;

/// Why a collider is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ColliderFault {
    /// Its shape is invalid, by itself or with the scale of its transform.
    #[error(transparent)]
    Shape(#[from] ShapeFault),
    /// Its transform, or that of a parent, is not finite or has no rotation.
    #[error("its transform is not finite or has no rotation")]
    Transform,
    /// Its [`SurfaceMaterial`](super::SurfaceMaterial) has a number that is not finite or out of range.
    #[error("a number of its material is not finite or out of range")]
    Material,
    /// The mesh that it is to be made from has no readable positions, or no triangles.
    #[error("its mesh has no positions and triangles that the CPU can read")]
    UnreadableMesh,
}
