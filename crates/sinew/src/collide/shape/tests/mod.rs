//! Guarantees of shapes: each closed form against `parry3d`, no tunnelling at any speed, refused input, scaling and bounds.

mod local_faces;
mod motion;
mod refusals;
mod sizes;
mod twins;

use glam::Vec3;

use super::Shape;
use crate::test_random::Random;

/// A torus: closed and not convex.
pub(super) fn torus(around: u32, across: u32) -> Shape {
    let turn = |i: u32, n: u32| std::f32::consts::TAU * (i % n) as f32 / n as f32;
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let (a, b) = (turn(i, around), turn(j, across));
            let out = 1.0 + 0.4 * libm::cosf(b);
            vertices.push(Vec3::new(out * libm::cosf(a), 0.4 * libm::sinf(b), out * libm::sinf(a)));
            let at = |i: u32, j: u32| i % around * across + j % across;
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    Shape::mesh(vertices, triangles).unwrap()
}

/// A sheet with waves, 2 m by 2 m.
pub(super) fn waves(count: u32) -> Shape {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..=count {
        for j in 0..=count {
            let at = |k: u32| 2.0 * k as f32 / count as f32 - 1.0;
            vertices.push(Vec3::new(
                at(i),
                0.2 * libm::sinf(4.0 * at(i)) * libm::cosf(3.0 * at(j)),
                at(j),
            ));
            if i < count && j < count {
                let (a, b) = (i * (count + 1) + j, (i + 1) * (count + 1) + j);
                triangles.extend([[a, a + 1, b], [a + 1, b + 1, b]]);
            }
        }
    }
    Shape::mesh(vertices, triangles).unwrap()
}

/// Hills, 4 m by 2 m.
pub(super) fn hills() -> Shape {
    let heights: Vec<f32> = (0..20 * 30)
        .map(|i| libm::sinf(0.7 * (i % 30) as f32) * libm::cosf(0.5 * (i / 30) as f32))
        .collect();
    Shape::height_field(30, 20, &heights, Vec3::new(4.0, 0.3, 2.0)).unwrap()
}

/// Points on an ellipsoid.
pub(super) fn egg(count: usize, half: Vec3) -> Vec<Vec3> {
    let mut random = Random::new(5);
    (0..count).map(|_| random.vector().normalize() * half).collect()
}

/// Convex shapes of each kind, thick and thin, with their names.
pub(super) fn convex() -> Vec<(&'static str, Shape)> {
    vec![
        ("sphere", Shape::sphere(0.7).unwrap()),
        ("capsule", Shape::capsule(0.3, 1.6).unwrap()),
        ("thin capsule", Shape::capsule(0.01, 2.0).unwrap()),
        ("box", Shape::cuboid(Vec3::new(1.0, 1.6, 0.6)).unwrap()),
        ("plate", Shape::cuboid(Vec3::new(2.0, 0.002, 2.0)).unwrap()),
        ("cylinder", Shape::cylinder(0.6, 1.0).unwrap()),
        ("disc", Shape::cylinder(1.0, 0.004).unwrap()),
        ("wire", Shape::cylinder(0.003, 2.0).unwrap()),
        ("hull", Shape::hull(&egg(40, Vec3::new(0.9, 0.6, 0.7))).unwrap()),
        ("flat hull", Shape::hull(&egg(40, Vec3::new(1.0, 0.01, 0.8))).unwrap()),
        ("tetrahedron", Shape::hull(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]).unwrap()),
    ]
}
