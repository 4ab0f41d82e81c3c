//! One throw, three ways to compute it: bricks that spin about their middle axis, which no brick does for long.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodySolver, GradientAt, RigidIntegrator};
use bevy_sinew::{BoxParticles, Representation};

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "bricks",
    heading: Heading::Constraints,
    title: "Bricks in space (Dzhanibekov)",
    about: "orange, the lectures' loop, loses its spin; blue, corrected along the start of the step, flips every 3.9 s, and so does green, a rigid body",
    eye: Vec3::new(0.0, 4.7, 13.8),
    target: Vec3::new(0.0, 2.7, 0.0),
    seconds: 8.0,
    moment: 3.9,
    lesson: None,
    spawn,
};

/// Edges of a brick, metres: its middle axis is y, and stands upright.
const SIZE: Vec3 = Vec3::new(1.0, 2.0, 3.0);
/// How they are thrown, rad/s: about the middle axis, a hundredth of it off.
const SPIN: Vec3 = Vec3::new(0.06, 6.0, 0.0);

fn spawn(world: &mut World) {
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    // So that one sees what the corrections do by themselves.
    world.insert_resource(SolverConfig { keep_spin: false, ..default() });
    let ways = [
        (-4.0, 0xd9622b, GradientAt::Current, Representation::Particles),
        (0.0, 0x3d7ea6, GradientAt::StepStart, Representation::Particles),
        (4.0, 0x66a182, GradientAt::StepStart, Representation::Rigid(RigidIntegrator::default())),
    ];
    for (x, color, gradient_at, representation) in ways {
        let skin = mesh(world, rounded_box(SIZE, 0.06, 4));
        let brick = world
            .spawn((
                InScene,
                Name::new("brick"),
                // As hard to turn as a solid brick, which decides when it flips.
                RigidBox { particles: BoxParticles::Equimomental, ..RigidBox::new(SIZE) },
                BodySolver { gradient_at: Some(gradient_at), ..default() },
                representation,
                skin,
                Look::color(color).roughness(0.5),
                Interpolate,
                Transform::from_xyz(x, 2.8, 0.0),
            ))
            .set_angular_velocity(SPIN)
            .id();
        // A knob says which end was up.
        let (stick, knob) = (mesh(world, cylinder(0.05, 0.5)), mesh(world, ball(0.16)));
        let (steel, red) = (Look::color(0xb9bec6).metal(), Look::color(0xd1495b).roughness(0.3));
        let above = |y: f32| Transform::from_xyz(0.0, SIZE.y * 0.5 + y, 0.0);
        world.spawn((ChildOf(brick), stick, steel, above(0.25)));
        world.spawn((ChildOf(brick), knob, red, above(0.55)));
    }
}
