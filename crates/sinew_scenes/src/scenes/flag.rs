//! A flag on a pole: cloth on a grid, held along one edge, in a gusty wind.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh, post};
use crate::{Heading, InScene, Look, ball};

pub(super) const SCENE: Scene = Scene {
    name: "flag",
    heading: Heading::Forces,
    title: "A flag in the wind",
    about: "1 500 particles of cotton, held along one edge; a fresh breeze presses on every triangle",
    eye: Vec3::new(1.9, 2.5, 4.6),
    target: Vec3::new(0.75, 2.05, 0.0),
    seconds: 6.0,
    moment: 3.2,
    lesson: None,
    spawn,
};

/// Height and width of the flag, metres: the proportions of its picture.
const SIZE: Vec2 = Vec2::new(1.92, 1.2);

fn spawn(world: &mut World) {
    // 6 m/s of air is 22 Pa; the lectures' law knows no motion of the cloth, so the air's drag is what calms it.
    let pressure = Vec3::new(13.0, 0.0, 3.5);
    world.spawn((
        InScene,
        Name::new("breeze"),
        Wind { pressure, gusts: 0.55, gust_length: 1.1, gust_period: 0.9 },
    ));
    world.insert_resource(AirDrag(0.75));
    // A 2 m flag in cells of 4 cm is 48 pieces from the pole to its end: short substeps carry the pull that far.
    world.insert_resource(SolverConfig { substeps: 30, max_sweeps: 2, ..default() });
    world.spawn((InScene, Ground));
    world.spawn((
        InScene,
        Name::new("flag"),
        Cloth { density: 0.18, ..Cloth::grid(SIZE.x, SIZE.y, 48, 30) }.pinned(ClothPins::LeftEdge),
        Look::texture("textures/flag.png").double_sided().roughness(0.85),
        Interpolate,
        Transform::from_xyz(SIZE.x * 0.5 + 0.03, 2.25, 0.0),
    ));
    let (height, radius) = (2.95, 0.03);
    let pole = post(world, radius, height);
    let metal = Look::color(0xb9bec6).metal();
    world.spawn((InScene, pole, metal, Transform::from_xyz(0.0, height * 0.5, 0.0)));
    let knob = mesh(world, ball(radius * 2.0));
    let gold = Look::color(0xd9a441).metal();
    world.spawn((InScene, knob, gold, Transform::from_xyz(0.0, height, 0.0)));
}
