//! A mesh in glTF's form: vertices are shared where position, normal and texture coordinate all agree.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

/// One triangle mesh.
#[derive(Default)]
pub(super) struct Mesh {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A corner of a triangle before vertices are assigned.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) position: Vec3,
    pub(super) uv: Vec2,
}

impl Mesh {
    /// Builds a mesh from unconnected triangles. Faces are smoothed where they meet at an angle whose cosine is above `crease`, and have a hard edge elsewhere.
    pub(super) fn from_triangles(loose: &[[Corner; 3]], crease: f32) -> Self {
        let facing: Vec<Vec3> = loose.iter().map(area_normal).collect();
        let mut around: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
        for (face, corners) in loose.iter().enumerate() {
            for corner in corners {
                around.entry(bits(corner.position)).or_default().push(face);
            }
        }

        let mut mesh = Self::default();
        let mut known = HashMap::new();
        for (face, corners) in loose.iter().enumerate() {
            let own = facing[face].normalize();
            let triangle = corners.map(|corner| {
                let smoothed = around[&bits(corner.position)]
                    .iter()
                    .filter(|&&other| facing[other].normalize().dot(own) > crease)
                    .map(|&other| facing[other])
                    .sum::<Vec3>()
                    .normalize();
                let key =
                    (bits(corner.position), bits(smoothed), corner.uv.to_array().map(f32::to_bits));
                *known.entry(key).or_insert_with(|| mesh.push(corner.position, smoothed, corner.uv))
            });
            mesh.triangles.push(triangle);
        }
        mesh
    }

    /// Adds a vertex and returns its index.
    pub(super) fn push(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        (self.positions.len() - 1) as u32
    }
}

/// Centre of volume of the solid bounded by closed `triangles`.
pub(super) fn centroid(triangles: &[[Corner; 3]]) -> Vec3 {
    let (mut volume, mut moment) = (0.0, Vec3::ZERO);
    for [a, b, c] in triangles.iter().map(|corners| corners.map(|corner| corner.position)) {
        let wedge = a.dot(b.cross(c)) / 6.0;
        volume += wedge;
        moment += (a + b + c) / 4.0 * wedge;
    }
    moment / volume
}

fn area_normal([a, b, c]: &[Corner; 3]) -> Vec3 {
    (b.position - a.position).cross(c.position - a.position)
}

fn bits(vector: Vec3) -> [u32; 3] {
    vector.to_array().map(f32::to_bits)
}
