//! Ragdolls that collapse, each in its own way.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::Scene;
use crate::{Heading, InScene, Look};

pub(super) const SCENE: Scene = Scene {
    name: "ragdoll",
    heading: Heading::Bodies,
    title: "Ragdolls",
    about: "22 particles, 33 bones, 20 struts and 22 limits of angles each; nobody holds them up",
    eye: Vec3::new(0.9, 1.9, 6.4),
    target: Vec3::new(0.0, 0.9, -0.3),
    seconds: 5.0,
    moment: 0.5,
    lesson: None,
    spawn,
};

fn spawn(world: &mut World) {
    world.insert_resource(AirDrag(0.2));
    world.insert_resource(SolverConfig { substeps: 20, max_sweeps: 8, ..default() });
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let figures = [
        (Vec3::new(0.0, 0.02, 0.0), 0.0, 0.0, 0xd9622b),
        (Vec3::new(-1.6, 0.9, -0.6), 0.8, 0.5, 0x2f8f83),
        (Vec3::new(1.6, 1.3, -0.8), -0.9, -1.1, 0xe0b040),
    ];
    for (place, yaw, roll, color) in figures {
        let rotation = Quat::from_rotation_y(yaw) * Quat::from_rotation_z(roll);
        world.spawn((
            InScene,
            Name::new("ragdoll"),
            Ragdoll::default(),
            Look::color(color).roughness(0.55),
            Interpolate,
            Transform::from_translation(place).with_rotation(rotation),
        ));
    }
}
