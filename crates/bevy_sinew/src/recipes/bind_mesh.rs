//! Meshes that bodies deform: a copy of the mesh that a body was made from, or a mesh generated from its particles.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use sinew::recipes::Blueprint;

use super::bind::attach;

/// The mesh that the plugin gave to a body, and the one that this is a copy of, if it is not generated. A rebuild starts from the latter.
#[derive(Component, Clone)]
pub(crate) struct MadeFrom {
    pub(crate) source: Option<Handle<Mesh>>,
    pub(crate) own: Handle<Mesh>,
}

/// The mesh that the plugin gave to a body, if that is still its `Mesh3d`.
fn made(world: &World, body: Entity) -> Option<&MadeFrom> {
    let current = &world.get::<Mesh3d>(body)?.0;
    world.get::<MadeFrom>(body).filter(|made| made.own == *current)
}

/// The mesh to make a body from: its `Mesh3d`, or the original if that is a copy.
pub(crate) fn source_mesh(world: &World, body: Entity) -> Option<&Handle<Mesh>> {
    match made(world, body) {
        Some(made) => made.source.as_ref(),
        None => world.get::<Mesh3d>(body).map(|mesh| &mesh.0),
    }
}

/// Replaces the mesh of a body by a copy, which can be deformed.
pub(super) fn own_copy(world: &mut World, body: Entity) {
    let Some(source) = source_mesh(world, body).cloned() else { return };
    let Some(meshes) = world.get_resource::<Assets<Mesh>>() else { return };
    let Some(copy) = meshes.get(&source).cloned() else { return };
    put_mesh(world, body, copy, Some(source));
}

/// Gives a body a mesh to deform: generated, or a copy of `source`.
pub(super) fn put_mesh(world: &mut World, body: Entity, mesh: Mesh, source: Option<Handle<Mesh>>) {
    let Some(mut meshes) = world.get_resource_mut::<Assets<Mesh>>() else { return };
    let own = meshes.add(mesh);
    attach(world, body, (MadeFrom { source, own: own.clone() }, Mesh3d(own)));
}

/// Takes back the mesh that the plugin gave to a body, which has the original again, if any. A mesh of the game stays.
pub(super) fn take_mesh(world: &mut World, body: Entity) {
    let given = made(world, body).cloned();
    let Ok(mut entity) = world.get_entity_mut(body) else { return };
    entity.remove::<MadeFrom>();
    match given {
        Some(MadeFrom { source: Some(source), .. }) => drop(entity.insert(Mesh3d(source))),
        Some(MadeFrom { source: None, .. }) => drop(entity.remove::<Mesh3d>()),
        None => {}
    }
}

/// The surface of a body as a mesh, with a vertex for each entry of [`Blueprint::vertices`], which are sorted and contain all corners of its triangles. The
/// simulation writes positions and normals. Without texture coordinates they are zero.
pub(super) fn skin_of(blueprint: &Blueprint, uvs: Option<Vec<[f32; 2]>>) -> Mesh {
    let vertices = blueprint.vertices.len();
    let uvs = uvs.unwrap_or_else(|| vec![[0.0; 2]; vertices]);
    let number = |i: &u32| blueprint.vertices.partition_point(|v| v < i) as u32;
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; vertices])
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0_f32, 1.0, 0.0]; vertices])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(
            blueprint.triangles.iter().flatten().map(number).collect(),
        ))
}
