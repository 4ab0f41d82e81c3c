//! Stacks of plates on three slopes, of which two are less steep than friction holds.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh, post};
use crate::{Heading, InScene, Look, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "slopes",
    heading: Heading::Contacts,
    title: "Held and slid",
    about: "stacks on slopes of 10°, 20° and 30°: with a friction of 0.5 what is less steep than 26.6° stays for ever, and does not creep by a tenth of a millimetre",
    eye: Vec3::new(0.9, 2.2, 7.2),
    target: Vec3::new(0.5, 0.7, 0.0),
    seconds: 5.0,
    moment: 1.1,
    lesson: None,
    spawn,
};

/// Of a slope, and of a plate, metres.
const SLOPE: Vec3 = Vec3::new(1.7, 0.12, 1.1);
const PLATE: Vec3 = Vec3::new(0.62, 0.12, 0.62);
const PLATES: u32 = 6;

fn spawn(world: &mut World) {
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    let board = mesh(world, rounded_box(SLOPE, 0.015, 2));
    let skin = mesh(world, rounded_box(PLATE, 0.012, 2));
    let slopes = [(-2.2, 10.0_f32, 0x7a9e7e), (0.0, 20.0, 0xd9b26a), (2.2, 30.0, 0xc0604d)];
    for (x, degrees, color) in slopes {
        let turned = Quat::from_rotation_z(-degrees.to_radians());
        let middle = Vec3::new(x, 0.62, 0.0);
        let place = Transform::from_translation(middle).with_rotation(turned);
        let slope = (Collider::cuboid(SLOPE), SurfaceMaterial::new(0.5));
        let wood = Look::color(0x8a6a4b).roughness(0.9);
        world.spawn((InScene, Name::new("slope"), slope, board.clone(), wood, place));
        posts(world, place);
        for n in 0..PLATES {
            let up = 0.5 * (SLOPE.y + PLATE.y) + PLATE.y * n as f32;
            let at = middle + turned * Vec3::new(-0.35, up, 0.0);
            world.spawn((
                InScene,
                Name::new("plate"),
                RigidBox::new(PLATE).with_mass(2.0),
                SurfaceMaterial::new(0.5),
                skin.clone(),
                Look::color(color).roughness(0.7),
                Interpolate,
                Transform::from_translation(at).with_rotation(turned),
            ));
        }
    }
}

/// Four posts beneath a board.
fn posts(world: &mut World, board: Transform) {
    for (i, j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let corner = Vec3::new(0.42 * i * SLOPE.x, -0.45 * SLOPE.y, 0.4 * j * SLOPE.z);
        let top = board.transform_point(corner);
        let post = post(world, 0.03, top.y);
        let middle = Transform::from_translation(top.with_y(0.5 * top.y));
        world.spawn((InScene, post, Look::color(0x6d5138).roughness(0.9), middle));
    }
}
