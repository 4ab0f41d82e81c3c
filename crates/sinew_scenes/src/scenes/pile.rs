//! Crates poured into a heap, and a tower that stands.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "pile",
    heading: Heading::Contacts,
    title: "A pile of crates",
    about: "boxes of particles that collide by their shape: poured into a heap, and stacked into a tower",
    eye: Vec3::new(5.2, 3.6, 8.6),
    target: Vec3::new(0.3, 1.1, 0.0),
    seconds: 6.0,
    moment: 4.5,
    lesson: None,
    spawn,
};

/// Edge of a crate, metres.
const EDGE: f32 = 0.5;

fn spawn(world: &mut World) {
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let skin = mesh(world, rounded_box(Vec3::splat(EDGE), 0.015, 2));
    // Layer by layer, each turned a little further, so that none falls straight onto the one below.
    for n in 0..72_u32 {
        let (layer, place) = (n / 9, n % 9);
        let turn = 0.35 * layer as f32 + 0.2 * place as f32;
        let [x, z] = [place % 3, place / 3].map(|i| (i as f32 - 1.0) * 0.62);
        let drift = 0.11 * (layer % 3) as f32 - 0.11;
        let place = Vec3::new(x + drift - 1.0, 0.8 + 0.75 * layer as f32, z - drift);
        let rotation = Quat::from_euler(EulerRot::XYZ, 0.4 * turn, turn, 0.3 * turn);
        crate_at(world, &skin, Transform::from_translation(place).with_rotation(rotation));
    }
    for n in 0..8_u32 {
        let yaw = if n % 2 == 0 { 0.06 } else { -0.09 };
        let place = Vec3::new(2.6, EDGE * (n as f32 + 0.5), -0.4);
        let rotation = Quat::from_rotation_y(yaw);
        crate_at(world, &skin, Transform::from_translation(place).with_rotation(rotation));
    }
}

fn crate_at(world: &mut World, skin: &Mesh3d, place: Transform) {
    world.spawn((
        InScene,
        Name::new("crate"),
        RigidBox::new(Vec3::splat(EDGE)).with_mass(5.0),
        SurfaceMaterial::new(0.6),
        skin.clone(),
        Look::texture("textures/crate.png").roughness(0.8),
        Interpolate,
        place,
    ));
}
