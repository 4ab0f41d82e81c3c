//! Two rods that share a ball, solved by Gauss–Seidel: each sweep over both leaves a fraction of the error that depends on the masses.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::sinew::{Distance, ParticleSeed, Simulation, SolverSettings};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::into_round;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "sweeps",
    heading: Heading::Constraints,
    title: "Sweep by sweep",
    about: "two rods share one ball: correcting one violates the other, and every sweep leaves a fraction of the error; the bars show what remains",
    eye: Vec3::new(0.2, 1.4, 4.2),
    target: Vec3::new(0.0, 0.93, 0.0),
    seconds: 6.5,
    moment: 3.2,
    lesson: Some(Lesson {
        try_this: "make the middle ball light and the outer ones heavy: the error hardly shrinks; a heavy ball between light ones needs two sweeps",
        watch: "the sticks are the rods at rest length: the second one is satisfied after each sweep, and the error remains at the first; the golden bar is the number",
        formula: "e = E γ (1 + β) (β γ)^(n−1), with β = γ = w₂/(w₁ + w₂) and w = 1/m",
        sliders: &[
            SceneSlider { label: "Sweeps", unit: "", range: [1.0, 10.0], default: 4.0 },
            SceneSlider { label: "Middle ball", unit: "kg", range: [0.25, 4.0], default: 0.5 },
            SceneSlider { label: "Outer balls", unit: "kg", range: [0.5, 4.0], default: 2.0 },
            SceneSlider { label: "Too long by", unit: "m", range: [0.1, 0.35], default: 0.3 },
        ],
        number: "Error left after the sweeps",
        unit: "mm",
        after: 1.0,
        measure: |world| {
            let left: RemainingError = component_of(world, "cascade")?;
            Some(f64::from(left.0) * 1e3)
        },
        expect: |values, _| {
            let [sweeps, middle, outer, excess] =
                [values[0], values[1], values[2], values[3]].map(f64::from);
            let share = outer / (middle + outer);
            let ended = sweeps.round() - 1.0;
            excess * share * (1.0 + share) * libm::pow(share * share, ended) * 1e3
        },
        tolerance: [0.01, 1e-3],
    }),
    spawn,
};

/// Length of a rod, metres.
const LENGTH: f32 = 0.8;
/// Height of the balls, metres.
const HIGH: f32 = FLOOR + 0.32;
/// Largest number of sweeps, and time for which each is shown, seconds.
const MAX_SWEEPS: usize = 12;
const FRAME_DURATION: f64 = 0.5;
/// Height of a bar for each metre of error.
const BAR: f32 = 2.2;
/// Position of the bars, metres.
const BARS: Vec3 = Vec3::new(0.0, FLOOR + 0.6, -0.3);

/// The error that the solver reports after as many sweeps as the slider sets, metres.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct RemainingError(f32);

/// Positions of the three balls after each number of sweeps, and the entities that draw them.
#[derive(Component, Clone, Debug)]
pub(crate) struct SweepFilm {
    places: Vec<[Vec3; 3]>,
    balls: [Entity; 3],
    /// The rods at their rest length, at the outer balls.
    sticks: [Entity; 2],
    /// One for each number of sweeps from 0 on, and its height, metres.
    bars: Vec<(Entity, f32)>,
}

/// Shows the sweep that is due.
pub(crate) fn show_sweep(
    clock: Res<SinewClock>,
    cascades: Query<&SweepFilm>,
    mut drawn: Query<&mut Transform>,
) {
    for cascade in &cascades {
        let passed =
            into_round(clock.seconds, FRAME_DURATION * (MAX_SWEEPS + 1) as f64) / FRAME_DURATION;
        let number = (passed as usize).min(MAX_SWEEPS);
        let places = cascade.places[number];
        let ends = [places[0] + Vec3::X * (0.5 * LENGTH), places[2] - Vec3::X * (0.5 * LENGTH)];
        let things = cascade.balls.iter().chain(&cascade.sticks);
        for (&thing, place) in things.zip(places.into_iter().chain(ends)) {
            if let Ok(mut thing) = drawn.get_mut(thing) {
                thing.translation = place;
            }
        }
        for (i, &(bar, height)) in cascade.bars.iter().enumerate() {
            if let Ok(mut bar) = drawn.get_mut(bar) {
                *bar = standing(i, if i <= number { height } else { 0.0 });
            }
        }
    }
}

/// The bar for a number of sweeps, `height` metres high.
fn standing(number: usize, height: f32) -> Transform {
    let height = height.max(2e-3);
    let along = (number as f32 - 0.5 * MAX_SWEEPS as f32) * 0.24;
    Transform::from_translation(BARS + Vec3::new(along, 0.5 * height, 0.0))
        .with_scale(Vec3::new(1.0, height, 1.0))
}

/// Positions of the balls after this many sweeps of the solver, and the error that it reports, metres; `None` if one of the numbers is invalid.
fn solve(sweeps: usize, middle: f32, outer: f32, excess: f32) -> Option<([Vec3; 3], f32)> {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    world.settings = SolverSettings {
        substeps: 1,
        max_sweeps: sweeps.max(1) as u32,
        tolerance: 0.0,
        // The two rods form a chain, which the direct solver would solve in one sweep.
        long_range: false,
        ..default()
    };
    for (i, mass) in [outer, middle, outer].into_iter().enumerate() {
        let at = Vec3::new((i as f32 - 1.0) * (LENGTH + excess), HIGH, 0.0);
        world.particles.push(ParticleSeed::at(at).with_mass(mass)).ok()?;
    }
    world.distances_mut().extend([Distance::new(0, 1, LENGTH), Distance::new(1, 2, LENGTH)]);
    if sweeps > 0 {
        world.step(1.0 / 60.0).ok()?;
    }
    let error = if sweeps > 0 { world.report().error } else { excess };
    Some(([0, 1, 2].map(|i| world.particles.position(i)), error))
}

fn spawn(world: &mut World) {
    let [sweeps, middle, outer, excess] = values(world);
    let wanted = sweeps.round() as usize;
    let solved = (0..=MAX_SWEEPS).map(|sweeps| solve(sweeps, middle, outer, excess));
    let Some(solved) = solved.collect::<Option<Vec<_>>>() else { return };
    floor(world, Vec2::new(4.2, 1.6), Look::color(0x54606e).roughness(0.9));
    let size = Vec3::new(3.6, 1.75, 0.06);
    let board = mesh(world, rounded_box(size, 0.02, 2));
    let at = Transform::from_xyz(0.0, FLOOR + 0.5 * size.y, BARS.z - 0.12);
    world.spawn((InScene, board, Look::color(0xe9e3d5).roughness(0.9), at));
    let shelf = mesh(world, rounded_box(Vec3::new(3.4, 0.03, 0.2), 0.01, 2));
    let at = Transform::from_translation(BARS - Vec3::Y * 0.015);
    world.spawn((InScene, shelf, Look::color(0x70787f).roughness(0.6), at));
    let steel = Look::color(0x70787f).metal();
    let stick = mesh(world, cylinder(0.03, LENGTH));
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    let sticks = [0xd9622b, 0x3d7ea6].map(|color| {
        let look = Look::color(color).roughness(0.4);
        let at = Transform::from_xyz(0.0, HIGH, 0.0).with_rotation(lying);
        world.spawn((InScene, stick.clone(), look, at)).id()
    });
    let balls = [outer, middle, outer].map(|mass| {
        let skin = mesh(world, ball(0.09 * libm::cbrtf(mass)));
        let at = Transform::from_xyz(0.0, HIGH, 0.0);
        world.spawn((InScene, skin, steel.clone(), at)).id()
    });
    let bar = mesh(world, Cuboid::new(0.15, 1.0, 0.12));
    let bars = solved.iter().enumerate().map(|(i, &(_, error))| {
        let look = Look::color(if i == wanted { 0xe0a526 } else { 0x8a94a6 }).roughness(0.5);
        let at = standing(i, 0.0);
        (world.spawn((InScene, bar.clone(), look, at)).id(), BAR * error)
    });
    let bars = bars.collect();
    let left = RemainingError(solved[wanted.min(MAX_SWEEPS)].1);
    let places = solved.into_iter().map(|(places, _)| places).collect();
    let cascade = SweepFilm { places, balls, sticks, bars };
    world.spawn((InScene, Name::new("cascade"), left, cascade));
}
