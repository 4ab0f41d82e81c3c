//! The lectures' box in 2D: 4 particles and 6 distances, falling in a plane.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "square",
    heading: Heading::Bodies,
    title: "The box of the lectures",
    about: "4 particles and 6 distances in a plane: falling and landing, it starts to turn by itself",
    eye: Vec3::new(0.8, 2.0, 7.4),
    target: Vec3::new(0.0, 1.45, 0.0),
    seconds: 5.0,
    moment: 1.0,
    lesson: None,
    spawn,
};

fn spawn(world: &mut World) {
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let squares =
        [(-2.5, 2.6, 0.35, 0xe07a5f), (0.0, 3.3, 0.62, 0x3d7ea6), (2.5, 2.2, 1.2, 0xe9b44c)];
    for (x, y, turn, color) in squares {
        let size = Vec3::new(1.0, 1.0, 0.16);
        let skin = mesh(world, rounded_box(size, 0.03, 3));
        world.spawn((
            InScene,
            Name::new("square"),
            RigidBox { flat: true, ..RigidBox::new(size).with_mass(2.0) },
            skin,
            Look::color(color).roughness(0.5),
            Interpolate,
            Transform::from_xyz(x, y, 0.0).with_rotation(Quat::from_rotation_z(turn)),
        ));
    }
}
