//! Pendulums of different lengths that start together, drift out of phase and come together again.

use bevy::prelude::*;
use bevy_sinew::TubeMesh;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodySolver, ConstraintOf, GradientAt, ParticleBody, ParticleOf};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "pendulums",
    heading: Heading::Constraints,
    title: "Pendulum wave",
    about: "15 rods whose periods differ by one swing in 24 seconds, side by side",
    eye: Vec3::new(2.6, 1.7, 2.2),
    target: Vec3::new(0.0, 1.35, 0.0),
    seconds: 8.0,
    moment: 4.6,
    lesson: Some(Lesson {
        try_this: "let them swing wider: all periods grow by the same factor, and the wave stays in step; make them heavier: nothing changes",
        watch: "the pendulums form a straight line, then waves, then two rows that pass through each other; for small swings they align again after 24 s",
        formula: "θ'' = −(g/L) sin θ: sin ½θ = k sn(K − t √(g/L), k), with k = sin ½θ₀",
        sliders: &[
            SceneSlider { label: "Angle", unit: "°", range: [5.0, 60.0], default: 28.65 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [3.7, 15.0], default: 9.81 },
            SceneSlider { label: "Mass", unit: "kg", range: [0.1, 10.0], default: 1.0 },
        ],
        number: "Angle of the longest pendulum",
        unit: "°",
        after: 2.0,
        measure: |world| {
            let bob: Particle = component_of(world, "longest")?;
            let down = f64::from(HEIGHT - bob.position.y);
            Some(libm::atan2(f64::from(bob.position.x), down).to_degrees())
        },
        expect: |values, seconds| {
            let [widest, gravity] = [values[0], values[1]].map(f64::from);
            let rate = libm::sqrt(gravity / f64::from(length(0)));
            swing(widest.to_radians(), rate * seconds).to_degrees()
        },
        tolerance: [0.1, 0.02],
    }),
    spawn,
};

/// Number of pendulums.
const COUNT: usize = 15;

/// Height of the bar, metres.
const HEIGHT: f32 = 1.75;

/// Length of a pendulum, metres. T = 2π√(L/g) on Earth: 16 swings in 24 s for the longest, and one more for each next.
fn length(i: usize) -> f32 {
    let period = 24.0 / (16 + i) as f32;
    9.81 * (period / core::f32::consts::TAU) * (period / core::f32::consts::TAU)
}

/// The angle of a pendulum released from rest at `widest`, both in radians, at a time in units of √(L/g). The arithmetic-geometric mean gives the elliptic
/// integral K, and its steps in reverse give the elliptic sine.
pub(super) fn swing(widest: f64, time: f64) -> f64 {
    let (k, mut a, mut b) = (libm::sin(0.5 * widest), 1.0, libm::cos(0.5 * widest));
    let mut ratios = [0.0; 6];
    for ratio in &mut ratios {
        let next = 0.5 * (a + b);
        *ratio = 0.5 * (a - b) / next;
        (a, b) = (next, libm::sqrt(a * b));
    }
    let quarter = core::f64::consts::FRAC_PI_2 / a;
    let mut amplitude = f64::from(1_u32 << ratios.len()) * a * (quarter - time);
    for ratio in ratios.into_iter().rev() {
        amplitude = 0.5 * (amplitude + libm::asin(ratio * libm::sin(amplitude)));
    }
    2.0 * libm::asin(k * libm::sin(amplitude))
}

fn spawn(world: &mut World) {
    let [degrees, gravity, mass] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground));
    let height = HEIGHT;
    let bar = post(world, 0.025, 2.5);
    let lying = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let metal = Look::color(0x6c757d).metal();
    world.spawn((InScene, bar, metal, Transform::from_xyz(0.0, height, 0.0).with_rotation(lying)));
    let skin = mesh(world, ball(0.07));
    for i in 0..COUNT {
        let length = length(i);
        let z = (i as f32 - (COUNT - 1) as f32 * 0.5) * 0.165;
        let (sin, cos) = libm::sincosf(degrees.to_radians());
        let pivot = Vec3::new(0.0, height, z);
        // So that it swings on without losing energy.
        let solver = BodySolver { gradient_at: Some(GradientAt::StepStart), ..default() };
        let look = Look::color(0xd8dee9);
        let rod = world.spawn((InScene, ParticleBody, solver, look, Interpolate)).id();
        let hook = world.spawn((Particle::at(pivot), Pinned::HERE, ParticleOf(rod))).id();
        let hue = 8.0 + 40.0 * i as f32 / COUNT as f32;
        let look = Look { color: Color::hsl(hue, 0.75, 0.55), roughness: 0.3, ..default() };
        let bob = world
            .spawn((
                Name::new(if i == 0 { "longest" } else { "pendulum" }),
                Mass(mass),
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
