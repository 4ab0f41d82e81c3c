//! Tubes around chains of particles: what a rope looks like.

use core::f32::consts::TAU;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;

use super::{Easing, Frame};
use crate::components::{Interpolate, TubeMesh};
use crate::rows::{GONE, Rows};
use crate::schedule::SinewClock;
use crate::world::SinewWorld;

/// Gives each [`TubeMesh`] a mesh of its own, and keeps it around its particles.
pub(crate) fn draw_tubes(
    mut commands: Commands,
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    easing: Easing,
    meshes: Option<ResMut<Assets<Mesh>>>,
    mut tubes: Query<(
        Entity,
        Ref<TubeMesh>,
        &mut Rows<TubeMesh>,
        Option<&Mesh3d>,
        Has<Interpolate>,
    )>,
    transforms: TransformHelper,
    mut middle: Local<Vec<Vec3>>,
    mut skin: Local<Skin>,
) {
    let Some(mut meshes) = meshes else { return };
    for (entity, tube, mut rows, handle, eased) in &mut tubes {
        let drawn = handle.is_some() && !tube.is_changed() && rows.drawn == clock.tick;
        if drawn && !eased && easing.running() {
            continue;
        }
        rows.drawn = clock.tick;
        let ease = easing.now(eased);
        let rows =
            rows.resolve(&world.tables.layout, tube.is_changed(), tube.particles.iter().copied());
        let Some(frame) = Frame::of(&transforms, entity) else { continue };
        middle.clear();
        let there = rows.iter().filter(|&&row| row != GONE);
        middle.extend(there.map(|&row| Vec3::from(frame.place(&world, row, ease))));
        let sides = tube.sides.clamp(3, 64) as usize;
        skin.wrap(&middle, tube.radius, sides);
        if let Some(handle) = handle {
            if let Some(mut mesh) = meshes.get_mut(&handle.0) {
                skin.write(&mut mesh);
            }
            continue;
        }
        let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        skin.write(&mut mesh);
        commands.entity(entity).try_insert(Mesh3d(meshes.add(mesh)));
    }
}

/// The skin of a tube, in rings of `sides + 1` vertices (the first stands again at the end, for the texture's seam). Kept from
/// frame to frame for its memory alone.
#[derive(Default)]
pub(crate) struct Skin {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
    /// Sine and cosine of the angle of each vertex of a ring.
    turns: Vec<(f32, f32)>,
}

impl Skin {
    /// A tube of `radius` metres around a chain of points, closed by flat caps of its own rings. A triangle without a size for fewer
    /// than two points, as in the frame in which a rope is spawned: for a mesh without vertices Bevy 0.19's renderer allocates nothing, and then reports an
    /// error where it copies the vertices all the same ("use after free").
    ///
    /// The rings are carried along without twist: each ring's direction is the last one's, turned by the shortest arc between the two
    /// pieces of the chain that it stands between (parallel transport).
    fn wrap(&mut self, middle: &[Vec3], radius: f32, sides: usize) {
        let Self { positions, normals, uvs, indices, turns } = self;
        positions.clear();
        normals.clear();
        uvs.clear();
        indices.clear();
        if middle.len() < 2 {
            let at = middle.first().copied().unwrap_or_default();
            positions.extend([at.to_array(); 3]);
            normals.extend([[0.0, 1.0, 0.0]; 3]);
            uvs.extend([[0.0; 2]; 3]);
            indices.extend([0, 1, 2]);
            return;
        }
        let share = |k: usize| k as f32 / sides as f32;
        turns.clear();
        turns.extend((0..=sides).map(|k| libm::sincosf(share(k) * TAU)));
        let last = middle.len() - 1;
        let direction = |i: usize| {
            let (before, after) = (middle[i.saturating_sub(1)], middle[(i + 1).min(last)]);
            (after - before).try_normalize()
        };
        let mut along = direction(0).unwrap_or(Vec3::Y);
        let mut across = along.any_orthonormal_vector();
        let mut run = 0.0;
        for (i, point) in middle.iter().enumerate() {
            let next = direction(i).unwrap_or(along);
            across = (Quat::from_rotation_arc(along, next) * across).normalize_or(across);
            along = next;
            if i > 0 {
                run += middle[i - 1].distance(*point);
            }
            let side = along.cross(across);
            for (k, &(sin, cos)) in turns.iter().enumerate() {
                let out = across * cos + side * sin;
                positions.push((*point + out * radius).to_array());
                normals.push(out.to_array());
                // One turn of the texture is as long as it is around, so that a rope's strands keep their slant.
                uvs.push([share(k), run / (TAU * radius.max(1e-6))]);
            }
        }
        let ring = sides as u32 + 1;
        for i in 0..last as u32 {
            for k in 0..sides as u32 {
                let (a, b) = (i * ring + k, i * ring + k + 1);
                indices.extend([a, b, a + ring, b, b + ring, a + ring]);
            }
        }
        for (first, flip) in [(0, true), (last as u32 * ring, false)] {
            for k in 1..sides as u32 - 1 {
                let (b, c) = if flip { (k + 1, k) } else { (k, k + 1) };
                indices.extend([first, first + b, first + c]);
            }
        }
    }

    /// Copies it into a mesh, into the memory that the mesh has where it can.
    fn write(&self, mesh: &mut Mesh) {
        let Self { positions, normals, uvs, indices, .. } = self;
        for (attribute, new) in
            [(Mesh::ATTRIBUTE_POSITION, positions), (Mesh::ATTRIBUTE_NORMAL, normals)]
        {
            match mesh.try_attribute_mut(attribute) {
                Ok(VertexAttributeValues::Float32x3(list)) => list.clone_from(new),
                _ => mesh.insert_attribute(attribute, new.clone()),
            }
        }
        match mesh.try_attribute_mut(Mesh::ATTRIBUTE_UV_0) {
            Ok(VertexAttributeValues::Float32x2(list)) => list.clone_from(uvs),
            _ => mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs.clone()),
        }
        match mesh.try_indices_mut() {
            Ok(Indices::U32(list)) => list.clone_from(indices),
            _ => mesh.insert_indices(Indices::U32(indices.clone())),
        }
    }
}
