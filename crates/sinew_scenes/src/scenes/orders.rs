//! Two rods that cannot both have their length, solved in three orders, and the error that each order leaves.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyReport, BodySolver, ConstraintOf, Order, ParticleBody, ParticleOf, TubeMesh};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "orders",
    heading: Heading::Constraints,
    title: "Contradictory constraints",
    about: "two rods too short to meet: with Gauss–Seidel (orange) or most violated first (green), one rod has all of the error; Jacobi (blue) splits it",
    eye: Vec3::new(0.7, 2.2, 3.3),
    target: Vec3::new(0.05, 0.62, 0.0),
    seconds: 2.0,
    moment: 1.0,
    lesson: Some(Lesson {
        try_this: "make one rod longer, or move the posts together until the rods meet: then all three agree, and no error is left",
        watch: "the thick sticks are the rods at rest length; the ball ends where the last correction put it, or at the mean of both; the bars behind are the remaining error",
        formula: "Jacobi leaves (D − L₁ − L₂)/2 to each rod, the other two D − L₁ − L₂ to one",
        sliders: &[
            SceneSlider { label: "Left rod", unit: "m", range: [0.4, 0.9], default: 0.75 },
            SceneSlider { label: "Right rod", unit: "m", range: [0.3, 0.7], default: 0.45 },
            SceneSlider { label: "Post distance", unit: "m", range: [1.7, 2.2], default: 2.0 },
        ],
        number: "Error that Jacobi leaves",
        unit: "mm",
        after: 0.5,
        measure: |world| {
            let report: BodyReport = component_of(world, "Jacobi")?;
            Some(f64::from(report.error) * 1e3)
        },
        expect: |values, _| {
            let [left, right, apart] = [values[0], values[1], values[2]].map(f64::from);
            0.5 * (apart - left - right) * 1e3
        },
        tolerance: [0.5, 0.0],
    }),
    spawn,
};

/// Height of the rods over the floor, metres.
const HIGH: f32 = 0.55;
/// Length of an error bar as a multiple of the error.
const BAR: f32 = 1.0;

/// A bar as long as the error of a body.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct ErrorBar {
    body: Entity,
    /// Where it starts along x, metres.
    from: f32,
}

/// Sets the lengths of the bars to the errors.
pub(crate) fn draw_errors(
    reports: Query<&BodyReport>,
    mut bars: Query<(&ErrorBar, &mut Transform)>,
) {
    for (bar, mut drawn) in &mut bars {
        let error = reports.get(bar.body).map_or(0.0, |report| report.error);
        drawn.scale.x = (BAR * error).max(1e-3);
        drawn.translation.x = bar.from + 0.5 * drawn.scale.x;
    }
}

fn spawn(world: &mut World) {
    let [left, right, apart] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    floor(world, Vec2::new(3.6, 2.8), Look::color(0xcdb891).roughness(0.9));
    let half = 0.5 * apart;
    let skin = mesh(world, ball(0.09));
    let high = FLOOR + HIGH;
    let stand = mesh(world, cylinder(0.035, HIGH + 0.08));
    let bar = mesh(world, Cuboid::new(1.0, 0.1, 0.06));
    let board = mesh(world, rounded_box(Vec3::new(1.3, 0.16, 0.03), 0.01, 2));
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    let steel = Look::color(0x70787f).metal();
    let orders = [
        ("one after the other", Order::GaussSeidel, -0.9, 0xd9622b),
        ("most violated first", Order::MostViolatedFirst, 0.0, 0x5f9e6e),
        ("Jacobi", Order::Jacobi, 0.9, 0x3d7ea6),
    ];
    for (name, order, z, color) in orders {
        let look = Look::color(color).roughness(0.35);
        let solver = BodySolver { order: Some(order), ..default() };
        let body = world
            .spawn((InScene, Name::new(name), ParticleBody, solver, BodyReport::default()))
            .id();
        let hooks = [-half, half].map(|x| {
            let at = Vec3::new(x, high, z);
            let under = Transform::from_xyz(x, FLOOR + 0.5 * (HIGH + 0.08), z);
            world.spawn((InScene, stand.clone(), steel.clone(), under));
            world.spawn((Particle::at(at), Pinned::HERE, ParticleOf(body))).id()
        });
        let middle = Vec3::new(0.0, high, z);
        let ball = world
            .spawn((
                Particle::at(middle),
                Radius(0.09),
                ParticleOf(body),
                Transform::from_translation(middle),
                skin.clone(),
                look.clone(),
            ))
            .id();
        for (hook, length, side) in [(hooks[0], left, -1.0), (hooks[1], right, 1.0)] {
            world.spawn((DistanceConstraint::new(hook, ball, length), ConstraintOf(body)));
            // The rod at its rest length.
            let stick = mesh(world, cylinder(0.028, length));
            let at = Vec3::new(side * (half - 0.5 * length), high, z);
            let at = Transform::from_translation(at).with_rotation(lying);
            world.spawn((InScene, stick, steel.clone(), at));
        }
        let line = TubeMesh { particles: vec![hooks[0], ball, hooks[1]], radius: 0.012, sides: 8 };
        world.entity_mut(body).insert((line, look.clone()));
        // Behind each lane, a board with its error bar.
        let at = Transform::from_xyz(0.0, FLOOR + 0.1, z - 0.25);
        world.spawn((InScene, board.clone(), Look::color(0xf1efe6), at));
        let from = -0.62;
        let at =
            Transform::from_xyz(from, FLOOR + 0.1, z - 0.23).with_scale(Vec3::new(1e-3, 1.0, 1.0));
        world.spawn((InScene, ErrorBar { body, from }, bar.clone(), look, at));
    }
}
