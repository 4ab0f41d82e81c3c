//! Cloth that falls over a ball and over a table.

use bevy::prelude::*;
use bevy_sinew::BodyContacts;
use bevy_sinew::prelude::*;

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "drape",
    heading: Heading::Soft,
    title: "Draped cloth",
    about: "64 × 64 cells each, over a ball and over a table's edges; folds lie on folds",
    eye: Vec3::new(0.2, 2.3, 4.6),
    target: Vec3::new(0.0, 0.65, 0.0),
    seconds: 5.0,
    moment: 2.6,
    lesson: None,
    spawn,
};

fn spawn(world: &mut World) {
    world.insert_resource(AirDrag(0.5));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let globe = mesh(world, ball(0.5));
    let place = Transform::from_xyz(-1.05, 0.75, 0.0);
    let stone = Look::color(0x8f9aa3).roughness(0.5);
    world.spawn((InScene, Collider::sphere(0.5), globe, stone, place));
    let size = Vec3::new(0.9, 0.9, 0.9);
    let top = mesh(world, rounded_box(size, 0.01, 2));
    let wood = Look::color(0x8a6a4b).roughness(0.7);
    let place = Transform::from_xyz(1.05, 0.45, 0.0);
    world.spawn((InScene, Collider::cuboid(size), top, wood, place));
    for (x, height, color) in [(-1.05, 1.45, 0xb8434e), (1.05, 1.0, 0x3f6f9f)] {
        let turn =
            Quat::from_rotation_y(0.4) * Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
        world.spawn((
            InScene,
            Name::new("cloth"),
            Cloth { radius: 0.011, ..Cloth::grid(1.7, 1.7, 64, 64) },
            BodyContacts::ALL,
            Look::color(color).double_sided().roughness(0.9),
            Interpolate,
            Transform::from_xyz(x, height, 0.0).with_rotation(turn),
        ));
    }
}
