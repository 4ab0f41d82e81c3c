//! Colliders from meshes.

use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

use super::{Collider, ColliderFault};

impl Collider {
    /// A collider from the triangles of a mesh, as by [`Collider::mesh`]: a triangle list or strip, in the mesh's own coordinates, which are then scaled with
    /// the entity.
    ///
    /// # Errors
    /// A mesh without readable positions or triangles, and the errors of [`Collider::mesh`].
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, ColliderFault> {
        let positions = positions(mesh).ok_or(ColliderFault::UnreadableMesh)?;
        let triangles = triangles(mesh, positions.len()).filter(|triangles| !triangles.is_empty());
        Self::mesh(positions, triangles.ok_or(ColliderFault::UnreadableMesh)?)
    }

    /// The convex hull of a mesh, in the mesh's own coordinates.
    ///
    /// # Errors
    /// A mesh without readable positions, and the errors of [`Collider::hull`].
    pub fn hull_from_mesh(mesh: &Mesh) -> Result<Self, ColliderFault> {
        Self::hull(&positions(mesh).ok_or(ColliderFault::UnreadableMesh)?)
    }
}

fn positions(mesh: &Mesh) -> Option<Vec<Vec3>> {
    match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).ok()? {
        VertexAttributeValues::Float32x3(positions) => {
            Some(positions.iter().map(|&p| p.into()).collect())
        }
        _ => None,
    }
}

/// The triangles of a list or a strip; `None` for any other topology. Without indices, vertices are used in their order.
fn triangles(mesh: &Mesh, vertices: usize) -> Option<Vec<[u32; 3]>> {
    let indices: Vec<u32> = match mesh.try_indices() {
        Ok(Indices::U16(list)) => list.iter().map(|&i| u32::from(i)).collect(),
        Ok(Indices::U32(list)) => list.clone(),
        Err(_) => (0..vertices as u32).collect(),
    };
    match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => Some(indices.as_chunks::<3>().0.to_vec()),
        PrimitiveTopology::TriangleStrip => {
            let corners = indices.windows(3).enumerate();
            // Every second triangle of a strip has the opposite winding; triangles that repeat a corner only connect parts of the strip.
            let turned = corners
                .map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] });
            Some(turned.filter(|[a, b, c]| a != b && b != c && c != a).collect())
        }
        _ => None,
    }
}
