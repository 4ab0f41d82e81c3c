//! Colliders from meshes.

use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

use super::{Collider, ColliderFault};

impl Collider {
    /// The triangles of a mesh, as [`Collider::mesh`] has them: a triangle list or strip, in the mesh's own coordinates, to be scaled as the entity
    /// is.
    ///
    /// # Errors
    /// A mesh without readable positions or triangles, and what [`Collider::mesh`] refuses.
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, ColliderFault> {
        let positions = positions(mesh).ok_or(ColliderFault::UnreadableMesh)?;
        let triangles = triangles(mesh, positions.len()).filter(|triangles| !triangles.is_empty());
        Self::mesh(positions, triangles.ok_or(ColliderFault::UnreadableMesh)?)
    }

    /// The convex hull of a mesh, in the mesh's own coordinates.
    ///
    /// # Errors
    /// A mesh without readable positions, and what [`Collider::hull`] refuses.
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

/// The triangles of a list or a strip; `None` if it is neither. Without indices the vertices are used in their order.
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
            // Every second one of a strip is turned round; those that repeat a corner only lead on to the next.
            let turned = corners
                .map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] });
            Some(turned.filter(|[a, b, c]| a != b && b != c && c != a).collect())
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use bevy::asset::RenderAssetUsages;

    use super::*;

    fn mesh(topology: PrimitiveTopology, indices: Option<Indices>) -> Mesh {
        let positions =
            vec![[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
        let mut mesh = Mesh::new(topology, RenderAssetUsages::default());
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
        if let Some(indices) = indices {
            mesh.insert_indices(indices);
        }
        mesh
    }

    #[test]
    fn lists_and_strips_have_their_triangles_all_facing_one_way() {
        let list =
            mesh(PrimitiveTopology::TriangleList, Some(Indices::U16(vec![0, 2, 1, 1, 2, 3])));
        assert_eq!(triangles(&list, 4), Some(vec![[0, 2, 1], [1, 2, 3]]));
        let strip = mesh(PrimitiveTopology::TriangleStrip, Some(Indices::U32(vec![0, 2, 1, 3, 3])));
        assert_eq!(triangles(&strip, 4), Some(vec![[0, 2, 1], [1, 2, 3]]));
        let bare = mesh(PrimitiveTopology::TriangleStrip, None);
        assert_eq!(triangles(&bare, 4), Some(vec![[0, 1, 2], [2, 1, 3]]));
    }

    #[test]
    fn what_has_no_triangles_is_refused() {
        for unreadable in [
            mesh(PrimitiveTopology::LineList, None),
            mesh(PrimitiveTopology::TriangleList, Some(Indices::U16(vec![0, 1]))),
            Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default()),
        ] {
            assert_eq!(Collider::from_mesh(&unreadable), Err(ColliderFault::UnreadableMesh));
        }
        let missing = mesh(PrimitiveTopology::TriangleList, Some(Indices::U16(vec![0, 1, 9])));
        assert!(matches!(Collider::from_mesh(&missing), Err(ColliderFault::Shape(_))));
    }
}
