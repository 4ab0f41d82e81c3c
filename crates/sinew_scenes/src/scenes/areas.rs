//! Two flat patches that grow to the same area: one is scaled, the other is corrected along the gradient of its area.

use core::f32::consts::TAU;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::constraints::Patch;
use bevy_sinew::{
    ConstraintOf, MeshFollow, ParticleBody, ParticleOf, PatchConstraint, SizeCorrection,
};

use crate::look::Look;
use crate::props::{FLOOR, curve, floor, mesh, post};
use crate::readings::width_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "areas",
    heading: Heading::Soft,
    title: "Area by scaling and by gradient",
    about: "two flat ellipses grow to the same area: the orange one is scaled and keeps its shape; in the blue one, moved along the gradient, each part of the rim moves straight out",
    eye: Vec3::new(0.0, 1.35, 4.4),
    target: Vec3::new(0.0, 0.95, 0.0),
    seconds: 3.0,
    moment: 2.4,
    lesson: Some(Lesson {
        try_this: "make the ellipses thin, or their area large: orange has to move far to the sides, blue hardly at all",
        watch: "both reach the same area, and the gradient displaces the least; the posts are as far apart as the scaled ellipse becomes wide",
        formula: "scaled: width √(A/A₀); by gradient: each corner by d ∝ ∂A/∂x, the least Σ m d²",
        sliders: &[
            SceneSlider { label: "Area", unit: "times", range: [1.2, 2.5], default: 1.8 },
            SceneSlider { label: "Width", unit: "m", range: [0.8, 1.2], default: 1.1 },
            SceneSlider { label: "Height", unit: "m", range: [0.25, 0.6], default: 0.35 },
        ],
        number: "Width of the scaled ellipse",
        unit: "m",
        after: 2.5,
        measure: |world| width_of(world, "scaled"),
        expect: |values, _| f64::from(values[1]) * libm::sqrt(f64::from(values[0])),
        tolerance: [0.0, 0.01],
    }),
    spawn,
};

/// Particles on the rim.
const RIM_PARTICLES: u32 = 28;
/// Frequency of the soft constraint that makes them grow, Hz.
const HERTZ: f32 = 1.2;
/// Height of their centres, metres.
const HIGH: f32 = 0.95;

fn spawn(world: &mut World) {
    let [times, width, height] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    // Nearly static: strong drag, so that the patches do not oscillate after they have grown.
    world.insert_resource(AirDrag(0.999));
    floor(world, Vec2::new(5.0, 1.8), Look::color(0x4f6b62).roughness(0.9));
    let size = Vec3::new(4.6, 1.8, 0.06);
    let board = mesh(world, rounded_box(size, 0.02, 2));
    let at = Transform::from_xyz(0.0, FLOOR + 0.5 * size.y, -0.4);
    world.spawn((InScene, board, Look::color(0xe9e3d5).roughness(0.9), at));
    // The centre, and the rim about it, counter-clockwise as seen from the camera.
    let mut points = vec![Vec3::ZERO];
    points.extend((0..RIM_PARTICLES).map(|i| {
        let (sin, cos) = libm::sincosf(TAU * i as f32 / RIM_PARTICLES as f32);
        Vec3::new(0.5 * width * cos, 0.5 * height * sin, 0.0)
    }));
    let triangles: Vec<[u32; 3]> =
        (0..RIM_PARTICLES).map(|i| [0, 1 + i, 1 + (i + 1) % RIM_PARTICLES]).collect();
    let area = Patch::of(triangles.as_slice(), &points).rest;
    // Each rim particle is as heavy as the rim around it, so that the rim moves like a uniform line.
    let mass = |i: usize| match i {
        0 => 1.0,
        _ => {
            let around = RIM_PARTICLES as usize;
            let [before, after] = [(i + around - 2) % around, i % around].map(|k| points[1 + k]);
            before.distance(after)
        }
    };
    for (name, x, correction, color) in [
        ("scaled", -1.1, SizeCorrection::Scaling, 0xe07a3a),
        ("by gradient", 1.1, SizeCorrection::Gradient, 0x4f8fc0),
    ] {
        let middle = Vec3::new(x, HIGH, 0.0);
        let vertices = points.iter().map(|&point| (middle + point).to_array());
        let skin = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vertices.collect::<Vec<_>>())
            .with_inserted_indices(Indices::U32(triangles.concat()))
            .with_computed_smooth_normals();
        let skin = mesh(world, skin);
        let look = Look::color(color).roughness(0.5).double_sided();
        let body =
            world.spawn((InScene, Name::new(name), ParticleBody, skin, look, Interpolate)).id();
        let particles: Vec<Entity> = points
            .iter()
            .enumerate()
            .map(|(i, &point)| {
                let particle = (Particle::at(middle + point), Mass(mass(i)), ParticleOf(body));
                world.spawn(particle).id()
            })
            .collect();
        let full = PatchConstraint::new(particles.clone(), triangles.clone(), times * area)
            .with_correction(correction)
            .with_softness(Softness::frequency(HERTZ, 1.0));
        world.spawn((full, ConstraintOf(body)));
        world.entity_mut(body).insert(MeshFollow { vertices: particles });
        // The initial rim.
        let rim = (0..=RIM_PARTICLES)
            .map(|i| middle + points[1 + (i % RIM_PARTICLES) as usize] + Vec3::Z * 0.02);
        let rim: Vec<Vec3> = rim.collect();
        curve(world, &rim, 0.008, Look::color(0xf3f1ea));
        // Posts as far apart as the scaled patch becomes wide.
        let out = 0.5 * width * libm::sqrtf(times) + 0.02;
        for side in [-1.0, 1.0] {
            let stand = post(world, 0.015, 1.5);
            let at = Transform::from_xyz(x + side * out, FLOOR + 0.75, 0.0);
            world.spawn((InScene, stand, Look::color(0x4a4f55), at));
        }
    }
}
