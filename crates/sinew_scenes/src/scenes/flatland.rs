//! A 2D world: particles that are pushed out of its plane stay in it.

use bevy::prelude::*;
use bevy_sinew::Flatland;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "flatland",
    heading: Heading::Bodies,
    title: "Flatland",
    about: "a 2D world: squares fall, slide and tumble, a rope swings; all of them were pushed towards the camera, and none leaves the plane",
    eye: Vec3::new(1.5, 2.6, 7.8),
    target: Vec3::new(0.05, 1.25, 0.0),
    seconds: 5.0,
    moment: 0.75,
    lesson: Some(Lesson {
        try_this: "push everything harder towards the camera, or make the slope steeper or rougher",
        watch: "a plane for all particles is one constraint each: a particle pushed out of it is put back and loses that velocity, so that bodies turn about z alone",
        formula: "z = 0, v_z = 0, ω_x = ω_y = 0",
        sliders: &[
            SceneSlider { label: "Push", unit: "m/s", range: [0.0, 6.0], default: 2.0 },
            SceneSlider { label: "Slope", unit: "°", range: [18.0, 32.0], default: 25.8 },
            SceneSlider { label: "Friction", unit: "", range: [0.0, 0.4], default: 0.2 },
        ],
        number: "Farthest from the plane",
        unit: "mm",
        after: 1.5,
        measure: |world| {
            let mut particles = world.query::<&Particle>();
            let far = particles.iter(world).map(|p| f64::from(p.position.z.abs()));
            Some(far.reduce(f64::max)? * 1e3)
        },
        expect: |_, _| 0.0,
        tolerance: [0.01, 0.0],
    }),
    spawn,
};

fn spawn(world: &mut World) {
    let [push, slope, friction] = values(world);
    world.spawn((InScene, Flatland));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.4)));
    let tilted = Quat::from_rotation_z(-slope.to_radians());
    let rough = SurfaceMaterial::new(friction);
    world.spawn((InScene, Ground, rough, Transform::from_rotation(tilted)));
    // The slope ends at the origin, where the flat ground begins.
    let (length, thickness) = (4.6, 0.12);
    let plank = mesh(world, Cuboid::new(length, thickness, 0.6));
    let wood = Look::color(0x8a6a4b).roughness(0.9);
    let centre = tilted * Vec3::new(-0.5 * length, -0.5 * thickness, 0.0);
    world.spawn((InScene, plank, wood, Transform::from_translation(centre).with_rotation(tilted)));
    let squares = [
        (Vec3::new(-2.7, 2.6, 0.0), 0.7, 0.2, 0xe07a5f),
        (Vec3::new(1.7, 1.5, 0.0), 0.55, 0.6, 0xe9b44c),
        (Vec3::new(3.0, 2.1, 0.0), 0.8, 1.1, 0x3d7ea6),
    ];
    for (place, edge, turn, color) in squares {
        let size = Vec3::new(edge, edge, 0.14);
        let skin = mesh(world, rounded_box(size, 0.03, 3));
        world
            .spawn((
                InScene,
                Name::new("square"),
                RigidBox { flat: true, ..RigidBox::new(size).with_mass(4.0 * edge * edge) },
                skin,
                Look::color(color).roughness(0.5),
                Interpolate,
                Transform::from_translation(place).with_rotation(Quat::from_rotation_z(turn)),
            ))
            .set_motion(Vec3::Z * push, Vec3::X);
    }
    let from = Vec3::new(0.5, 3.4, 0.0);
    world
        .spawn((
            InScene,
            Name::new("rope"),
            Rope {
                segments: 28,
                radius: 0.04,
                mass: 0.5,
                ..Rope::between(from, from + Vec3::X * 1.4)
            },
            Look::color(0x66a182),
            Interpolate,
        ))
        .set_linear_velocity(Vec3::Z * push);
}
