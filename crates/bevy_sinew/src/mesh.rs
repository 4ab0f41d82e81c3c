//! Reading meshes: their positions and triangles.

use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

/// The positions of the vertices; `None` if a mesh has none that the CPU can read.
pub(crate) fn positions(mesh: &Mesh) -> Option<Vec<Vec3>> {
    match mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).ok()? {
        VertexAttributeValues::Float32x3(positions) => {
            Some(positions.iter().map(|&p| p.into()).collect())
        }
        _ => None,
    }
}

/// The triangles of a list or a strip; `None` for any other topology. Without indices, vertices are used in their order. As when drawn, an incomplete triangle
/// is left out.
pub(crate) fn triangles(mesh: &Mesh, vertices: usize) -> Option<impl Iterator<Item = [u32; 3]>> {
    let indices = mesh.try_indices().ok();
    let count = indices.map_or(vertices, Indices::len);
    let (strip, triangles, step) = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => (false, count / 3, 3),
        PrimitiveTopology::TriangleStrip => (true, count.saturating_sub(2), 1),
        _ => return None,
    };
    let corner = move |i: usize| match indices {
        Some(Indices::U16(list)) => list[i].into(),
        Some(Indices::U32(list)) => list[i],
        None => i as u32,
    };
    let triangle = move |i: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| corner(step * i + k));
        // Every second triangle of a strip has the opposite winding.
        if strip && i % 2 == 1 { [b, a, c] } else { [a, b, c] }
    };
    // Triangles of a strip that repeat a corner only connect its parts.
    let has_area = move |[a, b, c]: &[u32; 3]| !strip || (a != b && b != c && c != a);
    Some((0..triangles).map(triangle).filter(has_area))
}
