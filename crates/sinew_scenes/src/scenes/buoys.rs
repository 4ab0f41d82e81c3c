//! Balls of different density, dropped into water.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, ball};

pub(super) const SCENE: Scene = Scene {
    name: "buoys",
    heading: Heading::Forces,
    title: "Floating balls",
    about: "from cork to stone: each floats as deep as its density says, and one sinks",
    eye: Vec3::new(0.4, 2.0, 6.6),
    target: Vec3::new(0.0, 0.55, 0.0),
    seconds: 6.0,
    moment: 1.4,
    lesson: None,
    spawn,
};

/// Height of the water, metres.
const LEVEL: f32 = 0.6;

fn spawn(world: &mut World) {
    world.spawn((InScene, Ground));
    world.spawn((InScene, Fluid { drag: 0.85, ..default() }, Transform::from_xyz(0.0, LEVEL, 0.0)));
    // The water is a slab seen from the front, cut open, so that one sees how deep the balls sit.
    let depth = 1.2;
    let back = mesh(world, Cuboid::new(5.4, LEVEL, depth));
    let blue = Look::color(0x4d9bc1).roughness(0.15);
    world.spawn((InScene, back, blue, Transform::from_xyz(0.0, LEVEL * 0.5, -depth * 0.5)));
    let radius = 0.22;
    let skin = mesh(world, ball(radius));
    let volume = 4.0 / 3.0 * core::f32::consts::PI * radius * radius * radius;
    for (i, share) in [0.1_f32, 0.25, 0.5, 0.75, 0.95, 1.6].into_iter().enumerate() {
        let place = Vec3::new(-2.1 + 0.84 * i as f32, 1.1 + 0.22 * i as f32, 0.0);
        let look = if share > 1.0 {
            Look::color(0x6b6f76).roughness(0.9)
        } else {
            Look::texture("textures/ball.png").roughness(0.35)
        };
        world.spawn((
            InScene,
            Particle::at(place),
            Mass(1000.0 * share * volume),
            Radius(radius),
            Transform::from_translation(place),
            skin.clone(),
            look,
        ));
    }
}
