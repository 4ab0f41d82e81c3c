//! Crates that fall, land on an edge, tumble and come to rest.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "crate",
    heading: Heading::Bodies,
    title: "Falling crates",
    about: "8 particles and 28 distances each: nobody integrates a rotation, and yet they turn",
    eye: Vec3::new(3.6, 3.4, 7.6),
    target: Vec3::new(0.0, 1.5, -0.4),
    seconds: 5.0,
    moment: 1.0,
    lesson: None,
    spawn,
};

fn spawn(world: &mut World) {
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.45)));
    let crates = [
        (Vec3::new(0.0, 3.4, 0.0), Vec3::splat(1.0), Vec3::new(0.5, 0.3, 0.7)),
        (Vec3::new(-2.2, 2.2, 0.9), Vec3::new(0.8, 0.8, 0.8), Vec3::new(0.9, 1.0, 0.1)),
        (Vec3::new(2.2, 3.6, -0.2), Vec3::new(0.7, 1.1, 0.7), Vec3::new(0.2, 0.4, 1.2)),
        (Vec3::new(-0.6, 4.6, -3.4), Vec3::new(1.1, 0.6, 0.8), Vec3::new(1.1, 0.2, 0.5)),
    ];
    for (place, size, turn) in crates {
        let skin = mesh(world, rounded_box(size, 0.025, 2));
        world.spawn((
            InScene,
            Name::new("crate"),
            RigidBox::new(size).with_mass(12.0 * size.element_product()),
            skin,
            Look::texture("textures/crate.png").roughness(0.8),
            Interpolate,
            Transform::from_translation(place).with_rotation(Quat::from_euler(
                EulerRot::XYZ,
                turn.x,
                turn.y,
                turn.z,
            )),
        ));
    }
}
