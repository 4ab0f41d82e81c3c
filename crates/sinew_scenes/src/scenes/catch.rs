//! A crate that falls into a sheet, held at its four corners, which catches it.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh, post};
use crate::{Heading, InScene, Look, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "catch",
    heading: Heading::Contacts,
    title: "Caught in a sheet",
    about: "a crate lands in a cloth held at four corners: each pulls at the other",
    eye: Vec3::new(2.6, 2.6, 4.4),
    target: Vec3::new(0.0, 1.0, 0.0),
    seconds: 5.0,
    moment: 1.0,
    lesson: None,
    spawn,
};

fn spawn(world: &mut World) {
    world.insert_resource(SolverConfig { substeps: 20, ..default() });
    world.insert_resource(AirDrag(0.8));
    world.spawn((InScene, Ground));
    for x in [-1.0, 1.0] {
        for z in [-1.0, 1.0] {
            let post = post(world, 0.03, 1.4);
            let wood = Look::color(0x8a6a4b);
            world.spawn((InScene, post, wood, Transform::from_xyz(x, 0.7, z)));
        }
    }
    let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
    world.spawn((
        InScene,
        Name::new("sheet"),
        // Knitted, so that it gives: cloth that does not stretch, spread taut, is a trampoline.
        Cloth {
            radius: 0.03,
            density: 0.8,
            stretch_compliance: 2e-4,
            ..Cloth::grid(2.0, 2.0, 40, 40)
        }
        .pinned(ClothPins::Corners),
        Look::color(0xe4dccb).double_sided().roughness(0.95),
        Interpolate,
        Transform::from_xyz(0.0, 1.4, 0.0).with_rotation(flat),
    ));
    let size = Vec3::splat(0.5);
    let skin = mesh(world, rounded_box(size, 0.015, 2));
    world.spawn((
        InScene,
        Name::new("crate"),
        RigidBox::new(size).with_mass(4.0),
        skin,
        Look::texture("textures/crate.png").roughness(0.8),
        Interpolate,
        Transform::from_xyz(0.1, 2.4, -0.05).with_rotation(Quat::from_euler(
            EulerRot::XYZ,
            0.2,
            0.4,
            0.15,
        )),
    ));
}
