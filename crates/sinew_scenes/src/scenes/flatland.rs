//! A world of two dimensions: what is pushed out of it stays in it.

use bevy::prelude::*;
use bevy_sinew::Flatland;
use bevy_sinew::prelude::*;

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "flatland",
    heading: Heading::Bodies,
    title: "Flatland",
    about: "a world in 2D: squares fall, slide and tumble, a rope swings; all of them were pushed towards the camera, and none comes",
    eye: Vec3::new(1.5, 2.6, 8.4),
    target: Vec3::new(-0.1, 1.45, 0.0),
    seconds: 5.0,
    moment: 0.9,
    lesson: None,
    spawn,
};

/// How steep the slope is, radians: its tangent, 0.48, is more than the friction on it holds.
const SLOPE: f32 = 0.45;

fn spawn(world: &mut World) {
    world.spawn((InScene, Flatland));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.4)));
    let tilted = Quat::from_rotation_z(-SLOPE);
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.2), Transform::from_rotation(tilted)));
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
            .set_motion(Vec3::Z * 2.0, Vec3::X);
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
        .set_linear_velocity(Vec3::Z * 2.0);
}
