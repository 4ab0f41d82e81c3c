//! Colliders from meshes.

use bevy::prelude::*;

use super::{Collider, ColliderFault};
use crate::mesh::{positions, triangles};

impl Collider {
    /// A collider from the triangles of a mesh, as by [`Collider::mesh`]: a triangle list or strip, in the mesh's own coordinates, which are then scaled with
    /// the entity.
    ///
    /// # Errors
    /// A mesh without readable positions or triangles, and the errors of [`Collider::mesh`].
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, ColliderFault> {
        let positions = positions(mesh).ok_or(ColliderFault::UnreadableMesh)?;
        let triangles: Vec<_> = triangles(mesh, positions.len()).into_iter().flatten().collect();
        if triangles.is_empty() {
            return Err(ColliderFault::UnreadableMesh);
        }
        Self::mesh(positions, triangles)
    }

    /// The convex hull of a mesh, in the mesh's own coordinates.
    ///
    /// # Errors
    /// A mesh without readable positions, and the errors of [`Collider::hull`].
    pub fn hull_from_mesh(mesh: &Mesh) -> Result<Self, ColliderFault> {
        Self::hull(&positions(mesh).ok_or(ColliderFault::UnreadableMesh)?)
    }
}
