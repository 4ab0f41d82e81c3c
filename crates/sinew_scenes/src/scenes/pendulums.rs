//! Pendulums of different lengths that start together, drift apart and meet again.

use bevy::prelude::*;
use bevy_sinew::TubeMesh;
use bevy_sinew::prelude::*;
use bevy_sinew::{ConstraintOf, ParticleBody, ParticleOf};

use super::{Scene, mesh, post};
use crate::{Heading, InScene, Look, ball};

pub(super) const SCENE: Scene = Scene {
    name: "pendulums",
    heading: Heading::Constraints,
    title: "Pendulum wave",
    about: "15 rods whose periods differ by one swing in 24 seconds: the same formula, side by side",
    eye: Vec3::new(2.6, 1.7, 2.2),
    target: Vec3::new(0.0, 1.35, 0.0),
    seconds: 8.0,
    moment: 4.6,
    lesson: None,
    spawn,
};

/// How many there are.
const COUNT: usize = 15;

fn spawn(world: &mut World) {
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground));
    let height = 1.75;
    let bar = post(world, 0.025, 2.5);
    let lying = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let metal = Look::color(0x6c757d).metal();
    world.spawn((InScene, bar, metal, Transform::from_xyz(0.0, height, 0.0).with_rotation(lying)));
    let skin = mesh(world, ball(0.07));
    for i in 0..COUNT {
        // T = 2π√(L/g): 18 swings in 24 s for the longest, one more for each next one.
        let period = 24.0 / (16 + i) as f32;
        let length = 9.81 * (period / core::f32::consts::TAU) * (period / core::f32::consts::TAU);
        let z = (i as f32 - (COUNT - 1) as f32 * 0.5) * 0.165;
        let (sin, cos) = libm::sincosf(0.5);
        let pivot = Vec3::new(0.0, height, z);
        let rod = world.spawn((InScene, ParticleBody, Look::color(0xd8dee9), Interpolate)).id();
        let hook = world.spawn((Particle::at(pivot), Pinned::HERE, ParticleOf(rod))).id();
        let hue = 8.0 + 40.0 * i as f32 / COUNT as f32;
        let look = Look { color: Color::hsl(hue, 0.75, 0.55), roughness: 0.3, ..default() };
        let bob = world
            .spawn((
                Particle::at(pivot + Vec3::new(sin, -cos, 0.0) * length),
                Radius(0.07),
                ParticleOf(rod),
                Transform::default(),
                skin.clone(),
                look,
            ))
            .id();
        world.spawn((DistanceConstraint::new(hook, bob, length), ConstraintOf(rod)));
        let string = TubeMesh { particles: vec![hook, bob], radius: 0.006, sides: 6 };
        world.entity_mut(rod).insert(string);
    }
}
