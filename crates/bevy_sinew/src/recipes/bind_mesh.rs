//! Meshes that bodies deform: a copy of the mesh that a body was made from, or a mesh generated from its particles.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use sinew::recipes::Blueprint;

use super::bind::attach;

/// The mesh that a body was made from, and the copy that it deforms. A rebuild starts from the former.
#[derive(Component, Clone)]
pub(crate) struct MadeFrom {
    pub(crate) source: Handle<Mesh>,
    pub(crate) own: Handle<Mesh>,
}

/// The mesh to make a body from: its `Mesh3d`, or the original if that is the copy.
pub(crate) fn source_mesh(world: &World, body: Entity) -> Option<&Handle<Mesh>> {
    let current_mesh = &world.get::<Mesh3d>(body)?.0;
    let made = world.get::<MadeFrom>(body).filter(|made| made.own == *current_mesh);
    Some(made.map_or(current_mesh, |made| &made.source))
}

/// Replaces the mesh of a body by a copy, which can be deformed.
pub(super) fn own_copy(world: &mut World, body: Entity) {
    let Some(source) = source_mesh(world, body).cloned() else { return };
    let Some(mut meshes) = world.get_resource_mut::<Assets<Mesh>>() else { return };
    let Some(copy) = meshes.get(&source).cloned() else { return };
    let own = meshes.add(copy);
    attach(world, body, (MadeFrom { source, own: own.clone() }, Mesh3d(own)));
}

/// The surface of a body as a mesh, with a vertex for each entry of [`Blueprint::vertices`], which are sorted and contain all corners of its triangles. The
/// simulation writes positions and normals.
pub(super) fn skin_of(blueprint: &Blueprint) -> Mesh {
    let vertices = blueprint.vertices.len();
    let number = |i: &u32| blueprint.vertices.partition_point(|v| v < i) as u32;
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; vertices])
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0_f32, 1.0, 0.0]; vertices])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0_f32; 2]; vertices])
        .with_inserted_indices(Indices::U32(
            blueprint.triangles.iter().flatten().map(number).collect(),
        ))
}
