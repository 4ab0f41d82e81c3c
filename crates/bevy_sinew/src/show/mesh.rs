//! Meshes that follow particles: vertices where the particles are, and smooth normals to go with them.

use bevy::mesh::{Indices, VertexAttributeValues};
use bevy::prelude::*;
use bevy::transform::helper::TransformHelper;

use super::{drawn_position, into_frame};
use crate::components::{Interpolate, MeshFollow};
use crate::messages::{Refusal, Refused, refuse};
use crate::rows::{GONE, Rows};
use crate::schedule::{SinewClock, SinewControl};
use crate::world::SinewWorld;

/// Writes the vertices and normals of every mesh with a [`MeshFollow`], once a frame, if a tick passed or the body eases between ticks.
pub(crate) fn deform_meshes(
    world: Res<SinewWorld>,
    clock: Res<SinewClock>,
    control: Res<SinewControl>,
    time: Res<Time<Fixed>>,
    meshes: Option<ResMut<Assets<Mesh>>>,
    mut messages: MessageWriter<Refused>,
    mut bodies: Query<(
        Entity,
        Ref<MeshFollow>,
        &mut Rows<MeshFollow>,
        Ref<Mesh3d>,
        Has<Interpolate>,
    )>,
    transforms: TransformHelper,
    mut normals: Local<Vec<Vec3>>,
) {
    let Some(mut meshes) = meshes else { return };
    normals.resize(world.simulation.particles.len(), Vec3::ZERO);
    for (entity, follow, mut rows, handle, eased) in &mut bodies {
        let changed = follow.is_changed() || handle.is_changed();
        if !changed && !eased && control.running() && rows.drawn == clock.tick {
            continue;
        }
        rows.drawn = clock.tick;
        // A world that stands still is drawn where it stands.
        let ease = (eased && control.running()).then(|| time.overstep_fraction());
        let rows =
            rows.resolve(&world.tables, follow.is_changed(), follow.vertices.iter().copied());
        let Some(into) = into_frame(&transforms, entity) else { continue };
        let Some(mut mesh) = meshes.get_mut(&handle.0) else { continue };
        if mesh.count_vertices() != rows.len() {
            if changed {
                refuse(&mut messages, entity, Refusal::VertexCount);
            }
            continue;
        }
        sum_normals(&world, &mesh, rows, ease, &mut normals);
        if let Ok(VertexAttributeValues::Float32x3(positions)) =
            mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION)
        {
            for (vertex, &row) in positions.iter_mut().zip(rows) {
                if row != GONE {
                    let place = drawn_position(&world, row, ease);
                    *vertex = into.transform_point3(place).to_array();
                }
            }
        }
        let turn = normal_matrix(into);
        if let Ok(VertexAttributeValues::Float32x3(list)) =
            mesh.try_attribute_mut(Mesh::ATTRIBUTE_NORMAL)
        {
            for (vertex, &row) in list.iter_mut().zip(rows) {
                if row != GONE {
                    let normal = turn * normals[row as usize];
                    *vertex = normal.normalize_or(Vec3::Z).to_array();
                }
            }
        }
    }
}

/// What `into` does to area vectors, up to their length: the transposed inverse of its linear part, turned around where it mirrors.
///
/// For edges `e`, `f` and a matrix `A`, `Ae × Af = det(A) A⁻ᵀ (e × f)`; of the determinant only the sign outlives normalising.
fn normal_matrix(into: Mat4) -> Mat3 {
    let linear = Mat3::from_mat4(into);
    linear.inverse().transpose() * linear.determinant().signum()
}

/// Sums up, per particle, the area vectors of the triangles around it: its smooth normal, across the seams of the texture too.
fn sum_normals(
    world: &SinewWorld,
    mesh: &Mesh,
    rows: &[u32],
    ease: Option<f32>,
    normals: &mut [Vec3],
) {
    for &row in rows {
        if row != GONE {
            normals[row as usize] = Vec3::ZERO;
        }
    }
    let mut add = |corners: [usize; 3]| {
        // A mesh may name vertices that it does not have; such a triangle shows nowhere.
        let Some([a, b, c]) = pick(rows, corners) else { return };
        let [pa, pb, pc] = [a, b, c].map(|row| drawn_position(world, row, ease));
        let area = (pb - pa).cross(pc - pa);
        for row in [a, b, c] {
            normals[row as usize] += area;
        }
    };
    match mesh.try_indices() {
        Ok(Indices::U16(list)) => {
            list.as_chunks::<3>().0.iter().for_each(|t| add(t.map(usize::from)));
        }
        Ok(Indices::U32(list)) => {
            list.as_chunks::<3>().0.iter().for_each(|t| add(t.map(|i| i as usize)));
        }
        Err(_) => (0..rows.len() / 3).for_each(|t| add([3 * t, 3 * t + 1, 3 * t + 2])),
    }
}

/// The rows of three vertices, if all three exist.
fn pick(rows: &[u32], corners: [usize; 3]) -> Option<[u32; 3]> {
    let row = |i: usize| rows.get(i).copied().filter(|&row| row != GONE);
    let [a, b, c] = corners;
    Some([row(a)?, row(b)?, row(c)?])
}
