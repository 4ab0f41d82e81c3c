//! Meshes that scenes are drawn with.

use core::f32::consts::TAU;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::BodyPart;

/// A ball of the given radius, metres, with the texture wrapped around its y axis.
pub fn ball(radius: f32) -> Mesh {
    Sphere::new(radius).mesh().uv(32, 18)
}

/// A capsule along y with the given radius and total length, metres, caps included.
pub fn capsule(radius: f32, length: f32) -> Mesh {
    Capsule3d::new(radius, (length - 2.0 * radius).max(0.0))
        .mesh()
        .longitudes(20)
        .latitudes(10)
        .build()
}

/// A cylinder along y, metres.
pub fn cylinder(radius: f32, height: f32) -> Mesh {
    Cylinder::new(radius, height).mesh().resolution(24).build()
}

/// A coil spring along x from the origin: radius of its turns, radius of its wire and length, metres, and the number of turns.
pub fn coil(radius: f32, wire: f32, length: f32, turns: u32) -> Mesh {
    const STOPS: u32 = 14;
    const SIDES: u32 = 6;
    let pitch = length / (turns.max(1) as f32 * TAU);
    let (mut positions, mut normals, mut uvs, mut indices) = (vec![], vec![], vec![], vec![]);
    for i in 0..=turns * STOPS {
        let angle = i as f32 / STOPS as f32 * TAU;
        let (sin, cos) = libm::sincosf(angle);
        let out = Vec3::new(0.0, cos, sin);
        let along = Vec3::new(pitch, -radius * sin, radius * cos).normalize_or(Vec3::X);
        let (side, middle) = (along.cross(out), Vec3::X * (pitch * angle) + out * radius);
        for k in 0..=SIDES {
            let share = k as f32 / SIDES as f32;
            let (sin, cos) = libm::sincosf(share * TAU);
            let normal = out * cos + side * sin;
            positions.push((middle + normal * wire).to_array());
            normals.push(normal.to_array());
            uvs.push([share, angle / TAU]);
        }
    }
    let ring = SIDES + 1;
    for a in (0..turns * STOPS).flat_map(|i| (0..SIDES).map(move |k| i * ring + k)) {
        indices.extend([a, a + 1, a + ring, a + 1, a + ring + 1, a + ring]);
    }
    triangles(positions, normals, uvs, indices)
}

/// A box about the origin with rounded edges, metres: `detail` facets across each rounding. Every face carries the whole texture.
///
/// Each face is a grid whose points are moved to the nearest point of the inner box (the box less the radius), plus the radius in the outward direction.
pub fn rounded_box(size: Vec3, radius: f32, detail: u32) -> Mesh {
    let half = size * 0.5;
    let radius = radius.clamp(0.0, half.min_element());
    let inner = half - radius;
    let (mut positions, mut normals, mut uvs, mut indices) = (vec![], vec![], vec![], vec![]);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let out = axes[axis] * sign;
        // Right and up as seen from outside, so that textures are not mirrored.
        let up = if axis == 1 { Vec3::NEG_Z * sign } else { Vec3::Y };
        let right = up.cross(out);
        let (half_right, half_up) = (half.dot(right.abs()), half.dot(up.abs()));
        let stops_right = stops(half_right, radius, detail);
        let stops_up = stops(half_up, radius, detail);
        let first = positions.len() as u32;
        for y in &stops_up {
            for x in &stops_right {
                let raw = out * half.dot(out.abs()) + right * *x + up * *y;
                let core = raw.clamp(-inner, inner);
                let normal = (raw - core).normalize_or(out);
                positions.push((core + normal * radius).to_array());
                normals.push(normal.to_array());
                uvs.push([0.5 + 0.5 * x / half_right, 0.5 - 0.5 * y / half_up]);
            }
        }
        let row = stops_right.len() as u32;
        for y in 0..stops_up.len() as u32 - 1 {
            for x in 0..row - 1 {
                let a = first + y * row + x;
                indices.extend([a, a + 1, a + row + 1, a, a + row + 1, a + row]);
            }
        }
    }
    triangles(positions, normals, uvs, indices)
}

fn triangles(
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    indices: Vec<u32>,
) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(indices))
}

/// Coordinates of the grid lines of a face, from -half to half: fine in the rounded margins, none in between.
fn stops(half: f32, radius: f32, detail: u32) -> Vec<f32> {
    let detail = detail.max(1);
    // Equal angles along the arc: the grid line of an angle is at its tangent.
    let margin = |k: u32| {
        let angle = core::f32::consts::FRAC_PI_4 * k as f32 / detail as f32;
        libm::tanf(angle) * radius
    };
    let low = (0..=detail).rev().map(|k| -(half - radius) - margin(k));
    let high = (0..=detail).map(|k| half - radius + margin(k));
    let mut stops: Vec<f32> = low.chain(high).collect();
    stops.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    stops
}

/// The mesh of a part of a ragdoll, chosen by its name.
pub(crate) fn part_mesh(part: &BodyPart, name: &Name) -> Mesh {
    let size = part.size;
    match name.as_str() {
        "torso" | "pelvis" => rounded_box(size, size.min_element() * 0.42, 5),
        "head" => rounded_box(size, size.min_element() * 0.5, 6),
        _ => capsule(size.x * 0.5, size.y),
    }
}
