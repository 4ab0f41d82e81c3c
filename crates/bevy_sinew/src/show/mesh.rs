//! Meshes that follow particles: vertices at the particles, and smooth normals.
//!
//! Both are computed for each particle and then copied to the vertices, since a particle on a texture seam has several. Where each particle has one vertex, as
//! on a grid, they are computed for each vertex by the solver's SIMD kernel. Everything is in the mesh's own frame, so that normals are perpendicular to its
//! faces even if the frame is scaled or mirrored.

use bevy::math::{Vec3A, Vec4};
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use sinew::InstructionSet;

use super::{Easing, Frame};
use crate::components::{Interpolate, MeshFollow};
use crate::frames::Frames;
use crate::mesh::triangles;
use crate::messages::{Refusal, Refused, refuse};
use crate::rows::{GONE, ResolvedRows};
use crate::schedule::SinewClock;
use crate::world::SinewWorld;

/// A particle as a corner of triangles, in the frame of the mesh.
#[derive(Clone, Copy, Default)]
pub(crate) struct Corner {
    /// Position.
    at: Vec3A,
    /// Sum of the area vectors of the triangles around it: the direction of the smooth normal, also across texture seams.
    normal: Vec3A,
}

/// Writes the vertices and normals of every mesh with a [`MeshFollow`], once a frame, if a tick passed or the body is interpolated.
pub(crate) fn deform_meshes(
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    easing: Easing,
    meshes: Option<ResMut<Assets<Mesh>>>,
    mut messages: MessageWriter<Refused>,
    mut bodies: Query<(
        Entity,
        Ref<MeshFollow>,
        &mut ResolvedRows<MeshFollow>,
        Ref<Mesh3d>,
        Has<Interpolate>,
    )>,
    frames: Frames,
    mut corners: Local<Vec<Corner>>,
    mut smooth: Local<Smooth>,
) {
    let Some(mut meshes) = meshes else { return };
    for (entity, follow, mut rows, handle, eased) in &mut bodies {
        let changed = follow.is_changed() || handle.is_changed();
        if !changed && !eased && easing.running() && rows.drawn == clock.tick {
            continue;
        }
        rows.drawn = clock.tick;
        let ease = easing.now(eased);
        rows.resolve(&world.tables.layout, follow.is_changed(), follow.vertices.iter().copied());
        let plain = rows.are_plain();
        let rows = rows.get();
        let Some(frame) = Frame::of(&frames, entity) else { continue };
        let Some(mut mesh) = meshes.get_mut(&handle.0) else { continue };
        if mesh.count_vertices() != rows.len() {
            if changed {
                refuse(&mut messages, entity, Refusal::VertexCount);
            }
            continue;
        }
        if plain {
            smooth.place(rows.iter().map(|&row| frame.place(&world, row, ease)));
            if smooth.write(&mut mesh, world.simulation.instructions) {
                continue;
            }
        }
        corners.resize(world.simulation.particles.len(), Corner::default());
        for &row in rows {
            if let Some(corner) = corners.get_mut(row as usize) {
                *corner = Corner { at: frame.place(&world, row, ease), normal: Vec3A::ZERO };
            }
        }
        sum_normals(&mesh, rows, &mut corners);
        write(&mut mesh, Mesh::ATTRIBUTE_POSITION, rows, &corners, |corner| corner.at);
        write(&mut mesh, Mesh::ATTRIBUTE_NORMAL, rows, &corners, |corner| {
            corner.normal.normalize_or(Vec3A::Z)
        });
    }
}

/// Vertices with one particle each, and their normals. Kept from frame to frame to reuse the memory.
#[derive(Default)]
pub(crate) struct Smooth {
    points: Vec<Vec4>,
    normals: Vec<Vec4>,
}

impl Smooth {
    fn place(&mut self, points: impl Iterator<Item = Vec3A>) {
        self.points.clear();
        self.points.extend(points.map(|at| at.extend(0.0)));
    }

    /// Writes both to a mesh. Returns `false`, and writes nothing, if its indices are not in the form that the kernel reads.
    fn write(&mut self, mesh: &mut Mesh, instructions: InstructionSet) -> bool {
        let Self { points, normals } = self;
        let PrimitiveTopology::TriangleList = mesh.primitive_topology() else { return false };
        let Ok(Indices::U32(list)) = mesh.try_indices() else { return false };
        sinew::pose::normals(points, list.as_chunks().0, Vec3::Z, normals, instructions);
        for (attribute, from) in
            [(Mesh::ATTRIBUTE_POSITION, points), (Mesh::ATTRIBUTE_NORMAL, normals)]
        {
            if let Ok(VertexAttributeValues::Float32x3(list)) = mesh.try_attribute_mut(attribute) {
                list.iter_mut().zip(from).for_each(|(to, from)| *to = from.truncate().to_array());
            }
        }
        true
    }
}

/// Adds the area vector of each triangle to its corners. The triangles are read from the mesh each time, since a game may change them.
fn sum_normals(mesh: &Mesh, rows: &[u32], corners: &mut [Corner]) {
    // A mesh may have indices out of range; such a triangle is skipped.
    let row = |vertex: u32| rows.get(vertex as usize).map_or(GONE as usize, |&row| row as usize);
    for triangle in triangles(mesh, rows.len()).into_iter().flatten() {
        let rows = triangle.map(row);
        if let [Some(a), Some(b), Some(c)] = rows.map(|row| corners.get(row).map(|it| it.at)) {
            let area = (b - a).cross(c - a);
            for row in rows {
                corners[row].normal += area;
            }
        }
    }
}

/// Writes an attribute of all vertices whose particles exist.
fn write(
    mesh: &mut Mesh,
    attribute: bevy::mesh::MeshVertexAttribute,
    rows: &[u32],
    corners: &[Corner],
    value: impl Fn(&Corner) -> Vec3A,
) {
    if let Ok(VertexAttributeValues::Float32x3(list)) = mesh.try_attribute_mut(attribute) {
        for (vertex, &row) in list.iter_mut().zip(rows) {
            if let Some(corner) = corners.get(row as usize) {
                *vertex = value(corner).to_array();
            }
        }
    }
}
