//! The same spring by four integrators, each in a world of its own, and the energy of each.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::sinew::{Integrator, ParticleSeed, Simulation, SolverSettings, Spring};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::into_round;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, coil, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "integrators",
    heading: Heading::Integration,
    title: "Four integrators",
    about: "one spring by explicit Euler (red), semi-implicit Euler (yellow), leapfrog (green) and Verlet (blue); the bars are their energies: red gains in every step",
    eye: Vec3::new(0.9, 1.7, 5.3),
    target: Vec3::new(0.15, 1.1, 0.0),
    seconds: 4.0,
    moment: 2.6,
    lesson: Some(Lesson {
        try_this: "take more steps a second: red gains less, but always gains; a stiffer spring or a lighter ball swings faster, and red gains more",
        watch: "the white line is the initial energy: yellow oscillates about it, green and blue stay on it, and their balls move side by side",
        formula: "E = E₀ (1 + ω²h²)^n for explicit Euler, with ω² = k/m",
        sliders: &[
            SceneSlider { label: "Steps", unit: "1/s", range: [60.0, 480.0], default: 120.0 },
            SceneSlider { label: "Stiffness", unit: "N/m", range: [10.0, 30.0], default: 25.0 },
            SceneSlider { label: "Mass", unit: "kg", range: [1.0, 3.0], default: 1.0 },
        ],
        number: "Energy of explicit Euler, relative to the start",
        unit: "",
        after: 2.5,
        measure: |world| {
            let energy: Energy = component_of(world, "explicit Euler")?;
            Some(energy.0)
        },
        expect: |values, seconds| {
            let [rate, stiffness, mass] = [values[0], values[1], values[2]].map(f64::from);
            let step = stiffness / mass / (rate * rate);
            libm::exp(steps(rate, seconds) as f64 * libm::log1p(step))
        },
        tolerance: [1e-3, 2e-3],
    }),
    spawn,
};

/// All start again after this time, seconds, before the red ball leaves the board.
const ROUND: f64 = 4.0;
/// Where the springs start along x, their rest length, and their initial elongation, metres.
const WALL: f32 = -2.2;
const REST: f32 = 1.5;
const PULL: f32 = 0.3;
/// Where the bars start along x, and length of a bar for the initial energy, metres.
const BARS: f32 = 0.75;
const BAR: f32 = 0.45;

/// Number of steps done by this time within its round, at `rate` steps a second.
fn steps(rate: f64, seconds: f64) -> u64 {
    (into_round(seconds, ROUND) * rate + 1e-3) as u64
}

/// A ball on a spring in a world of its own, because the integrator is a setting of a whole world.
#[derive(Component, Clone, Debug)]
pub(crate) struct Oscillator {
    start: Simulation,
    now: Simulation,
    /// Steps a second, and steps done in this round.
    rate: f64,
    steps: u64,
    spring: Entity,
    bar: Entity,
}

/// Kinetic and elastic energy relative to the start.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Energy(f64);

/// Takes the steps that are due, and updates the drawing.
pub(crate) fn step_oscillators(
    clock: Res<SinewClock>,
    mut oscillators: Query<(Entity, &mut Oscillator, &mut Energy)>,
    mut drawn: Query<&mut Transform>,
) {
    for (ball, mut oscillator, mut energy) in &mut oscillators {
        let due = steps(oscillator.rate, clock.seconds);
        if due == oscillator.steps {
            continue;
        }
        if due < oscillator.steps {
            oscillator.now = oscillator.start.clone();
            oscillator.steps = 0;
        }
        let step = (1.0 / oscillator.rate) as f32;
        while oscillator.steps < due && oscillator.now.step(step).is_ok() {
            oscillator.steps += 1;
        }
        let Oscillator { start, now, spring, bar, .. } = &mut *oscillator;
        energy.0 = now.ledger().energy() / start.ledger().energy();
        let x = now.particles.position(1).x;
        if let Ok(mut ball) = drawn.get_mut(ball) {
            ball.translation.x = x;
        }
        if let Ok(mut spring) = drawn.get_mut(*spring) {
            spring.scale.x = (x - WALL) / REST;
        }
        if let Ok(mut bar) = drawn.get_mut(*bar) {
            let length = BAR * energy.0 as f32;
            bar.translation.x = BARS + 0.5 * length;
            bar.scale.x = length;
        }
    }
}

/// The world of one ball; `None` if one of its numbers is invalid.
fn oscillator(integrator: Integrator, stiffness: f32, mass: f32) -> Option<Simulation> {
    let mut world = Simulation::default();
    world.settings = SolverSettings { integrator, substeps: 1, ..default() };
    world.forces.gravity = Vec3::ZERO;
    let a = world.particles.push(ParticleSeed::at(Vec3::X * WALL).pinned()).ok()?;
    let end = Vec3::X * (WALL + REST + PULL);
    let b = world.particles.push(ParticleSeed::at(end).with_mass(mass)).ok()?;
    world.forces.springs.push(Spring { a, b, rest: REST, stiffness, damping: 0.0 });
    Some(world)
}

fn spawn(world: &mut World) {
    let [rate, stiffness, mass] = values(world);
    floor(world, Vec2::new(6.4, 2.2), Look::color(0x4a3f35).roughness(0.8));
    let size = Vec3::new(5.0, 2.15, 0.06);
    let board = mesh(world, rounded_box(size, 0.02, 2));
    let slate = Look::color(0x2b3a42).roughness(0.9);
    let at = Transform::from_xyz(0.1, FLOOR + 0.5 * size.y, -0.25);
    world.spawn((InScene, board, slate, at));
    let chalk = Look::color(0xf1efe6).roughness(0.9);
    let line = mesh(world, Cuboid::new(0.014, 1.9, 0.01));
    let at = Transform::from_xyz(BARS + BAR, FLOOR + 1.08, -0.2);
    world.spawn((InScene, line, chalk.clone(), at));
    let [skin, bar] = [ball(0.13), Cuboid::new(1.0, 0.16, 0.03).into()].map(|m| mesh(world, m));
    let wire = mesh(world, coil(0.07, 0.012, REST, 16));
    let hook = mesh(world, rounded_box(Vec3::new(0.06, 0.3, 0.3), 0.02, 2));
    let rail = mesh(world, cylinder(0.012, 2.7));
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    let steel = Look::color(0xb9bec6).metal();
    let kinds = [
        ("explicit Euler", Integrator::ExplicitEuler, 0xd1495b),
        ("semi-implicit Euler", Integrator::SemiImplicitEuler, 0xe9b44c),
        ("leapfrog", Integrator::Leapfrog, 0x66a182),
        ("Verlet", Integrator::Verlet, 0x4f8fc0),
    ];
    for (n, (name, integrator, color)) in kinds.into_iter().enumerate() {
        let Some(start) = oscillator(integrator, stiffness, mass) else { continue };
        let high = FLOOR + 1.81 - 0.49 * n as f32;
        let place = |x: f32| Transform::from_xyz(x, high, 0.0);
        let look = Look::color(color).roughness(0.35);
        world.spawn((InScene, hook.clone(), steel.clone(), place(WALL - 0.03)));
        let lies = place(WALL + 1.35).with_rotation(lying);
        world.spawn((InScene, rail.clone(), steel.clone(), lies));
        let stretched = place(WALL).with_scale(Vec3::new(1.0 + PULL / REST, 1.0, 1.0));
        let spring = world.spawn((InScene, wire.clone(), steel.clone(), stretched)).id();
        let full = Transform::from_xyz(BARS + 0.5 * BAR, high, -0.2);
        let full = full.with_scale(Vec3::new(BAR, 1.0, 1.0));
        let bar = world.spawn((InScene, bar.clone(), look.clone(), full)).id();
        let (now, rate) = (start.clone(), f64::from(rate));
        let oscillator = Oscillator { start, now, rate, steps: 0, spring, bar };
        let ball = (skin.clone(), look, place(WALL + REST + PULL));
        world.spawn((InScene, Name::new(name), oscillator, Energy(1.0), ball));
    }
}
