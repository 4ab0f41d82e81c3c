//! Two flat ellipsoids that are inflated to the same volume: one is scaled, the other is corrected along the gradient of its volume.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::constraints::Volume;
use bevy_sinew::{
    ConstraintOf, MeshFollow, ParticleBody, ParticleOf, SizeCorrection, VolumeConstraint,
};

use crate::look::Look;
use crate::props::{floor, mesh, post};
use crate::readings::width_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};

pub(super) const SCENE: Scene = Scene {
    name: "volumes",
    heading: Heading::Soft,
    title: "Volume by scaling and by gradient",
    about: "two ellipsoids are inflated to the same volume: the orange one is scaled and grows in all directions; the blue one, by the gradient, grows where it is flat",
    eye: Vec3::new(0.0, 1.9, 4.4),
    target: Vec3::new(0.0, 0.85, 0.0),
    seconds: 3.0,
    moment: 2.4,
    lesson: Some(Lesson {
        try_this: "inflate them more, or make them flatter: orange keeps its shape, blue becomes round",
        watch: "both reach the same volume; the gradient displaces the least, which on a flat ellipsoid is up and down; the posts are as far apart as the scaled one becomes wide",
        formula: "scaled: width ∛(V/V₀); by gradient: each corner by d ∝ ∂V/∂x, the least Σ m d²",
        sliders: &[
            SceneSlider { label: "Volume", unit: "times", range: [1.2, 3.0], default: 2.0 },
            SceneSlider { label: "Width", unit: "m", range: [0.8, 1.2], default: 1.1 },
            SceneSlider { label: "Thickness", unit: "m", range: [0.15, 0.4], default: 0.22 },
        ],
        number: "Width of the scaled pancake",
        unit: "m",
        after: 2.5,
        measure: |world| width_of(world, "scaled"),
        expect: |values, _| f64::from(values[1]) * libm::cbrt(f64::from(values[0])),
        tolerance: [0.0, 0.01],
    }),
    spawn,
};

/// Number of rings of an ellipsoid between its poles, and of particles on a ring.
const RINGS: u32 = 7;
const AROUND: u32 = 16;
/// Frequency of the soft constraint that inflates them, Hz.
const HERTZ: f32 = 0.6;

/// The points of an ellipsoid of this width and thickness, metres, and its triangles, counter-clockwise seen from outside.
fn pancake(width: f32, thickness: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = (vec![Vec3::Y], Vec::new());
    for ring in 0..RINGS {
        let (out, up) =
            libm::sincosf(core::f32::consts::PI * (ring + 1) as f32 / (RINGS + 1) as f32);
        for i in 0..AROUND {
            let (sin, cos) = libm::sincosf(core::f32::consts::TAU * i as f32 / AROUND as f32);
            points.push(Vec3::new(out * cos, up, -out * sin));
        }
    }
    points.push(Vec3::NEG_Y);
    let at = |ring: u32, i: u32| 1 + ring * AROUND + i % AROUND;
    for i in 0..AROUND {
        triangles.push([0, at(0, i), at(0, i + 1)]);
        for ring in 0..RINGS - 1 {
            let (a, b) = (at(ring, i), at(ring, i + 1));
            let (c, d) = (at(ring + 1, i), at(ring + 1, i + 1));
            triangles.extend([[a, c, d], [a, d, b]]);
        }
        let bottom = 1 + RINGS * AROUND;
        triangles.push([at(RINGS - 1, i), bottom, at(RINGS - 1, i + 1)]);
    }
    let half = 0.5 * Vec3::new(width, thickness, width);
    (points.into_iter().map(|point| point * half).collect(), triangles)
}

fn spawn(world: &mut World) {
    let [times, width, thickness] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    floor(world, Vec2::new(4.6, 2.4), Look::color(0x7a5c74).roughness(0.9));
    let (points, triangles) = pancake(width, thickness);
    let volume = Volume::of(triangles.as_slice(), &points).rest;
    // Twice the vector area of the triangles around each point. Each particle is as heavy as the surface around it, so that a pole is pushed no farther than
    // its neighbours.
    let mut skin_of = vec![Vec3::ZERO; points.len()];
    for triangle in &triangles {
        let [a, b, c] = triangle.map(|i| points[i as usize]);
        triangle.iter().for_each(|&i| skin_of[i as usize] += (b - a).cross(c - a));
    }
    for (name, x, correction, color) in [
        ("scaled", -1.1, SizeCorrection::Scaling, 0xe07a3a),
        ("by gradient", 1.1, SizeCorrection::Gradient, 0x4f8fc0),
    ] {
        let middle = Vec3::new(x, 0.9, 0.0);
        let vertices = points.iter().map(|&point| (middle + point).to_array());
        let skin = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vertices.collect::<Vec<_>>())
            .with_inserted_indices(Indices::U32(triangles.concat()))
            .with_computed_smooth_normals();
        let skin = mesh(world, skin);
        let look = Look::color(color).roughness(0.35);
        let body =
            world.spawn((InScene, Name::new(name), ParticleBody, skin, look, Interpolate)).id();
        let particles: Vec<Entity> = points
            .iter()
            .zip(&skin_of)
            .map(|(&point, skin)| {
                let mass = Mass(skin.length());
                world.spawn((Particle::at(middle + point), mass, ParticleOf(body))).id()
            })
            .collect();
        let full = VolumeConstraint::new(particles.clone(), triangles.clone(), times * volume)
            .with_correction(correction)
            .with_softness(Softness::frequency(HERTZ, 1.0));
        world.spawn((full, ConstraintOf(body)));
        world.entity_mut(body).insert(MeshFollow { vertices: particles });
        // Posts as far apart as the scaled ellipsoid becomes wide.
        let out = 0.5 * width * libm::cbrtf(times) + 0.025;
        for side in [-1.0, 1.0] {
            let stand = post(world, 0.02, 1.5);
            let at = Transform::from_xyz(x + side * out, 0.75, 0.0);
            world.spawn((InScene, stand, Look::color(0xf3f1ea), at));
        }
    }
}
