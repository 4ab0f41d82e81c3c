//! The same brick as an explicit rigid body by three integrators for rotations, and the energy of each.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::sinew::{RigidBody, RigidIntegrator};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::into_round;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "spins",
    heading: Heading::Integration,
    title: "Three integrators for rotations",
    about: "one throw about the middle axis by Euler (red), leapfrog (green) and Verlet (blue); the columns are the energies: red does not conserve its own",
    eye: Vec3::new(0.3, 1.9, 6.5),
    target: Vec3::new(0.2, 1.0, 0.0),
    seconds: 12.0,
    moment: 10.0,
    lesson: Some(Lesson {
        try_this: "take more steps a second: red agrees with the others for longer; with a faster spin it diverges sooner",
        watch: "the white line is the initial energy; green and blue flip together, again and again, and red diverges from them",
        formula: "dω/dt = −J⁻¹ (ω × J ω); E = ½ Σ I ω²; both E and L are constant",
        sliders: &[
            SceneSlider { label: "Steps", unit: "1/s", range: [60.0, 480.0], default: 60.0 },
            SceneSlider { label: "Spin", unit: "rad/s", range: [3.0, 7.0], default: 6.0 },
            SceneSlider { label: "Tilt", unit: "%", range: [1.0, 10.0], default: 2.0 },
        ],
        number: "Energy of the blue brick",
        unit: "J",
        after: 6.0,
        measure: |world| {
            let brick: Brick = component_of(world, "Verlet")?;
            Some(brick.now.kinetic_energy())
        },
        expect: |values, _| {
            let [_, spin, off] = [values[0], values[1], values[2]].map(f64::from);
            let square = |x: f32| f64::from(x) * f64::from(x);
            let (a, b, c) = (square(SIZE.x), square(SIZE.y), square(SIZE.z));
            let share = 0.01 * off;
            0.5 * f64::from(MASS) / 12.0 * spin * spin * (c + a + share * share * (b + c))
        },
        tolerance: [0.0, 0.01],
    }),
    spawn,
};

/// All bricks start again after this time, seconds.
const ROUND: f64 = 12.0;
/// Edges of a brick, metres (y is the middle axis), and its mass, kg.
const SIZE: Vec3 = Vec3::new(0.35, 0.7, 1.05);
const MASS: f32 = 10.0;
/// Height of the bricks, and height of a column for the initial energy, metres.
const HIGH: f32 = 1.25;
const COLUMN: f32 = 0.8;

/// A brick, at the start and now, and the column that shows its energy.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Brick {
    start: RigidBody,
    now: RigidBody,
    integrator: RigidIntegrator,
    /// Steps a second, and steps done in this round.
    rate: f64,
    steps: u64,
    column: Entity,
}

/// Takes the steps that are due, and updates the drawing.
pub(crate) fn step_bricks(
    clock: Res<SinewClock>,
    mut bricks: Query<(Entity, &mut Brick)>,
    mut drawn: Query<&mut Transform>,
) {
    for (entity, mut brick) in &mut bricks {
        let due = (into_round(clock.seconds, ROUND) * brick.rate + 1e-3) as u64;
        if due < brick.steps {
            (brick.now, brick.steps) = (brick.start, 0);
        }
        let (step, integrator) = ((1.0 / brick.rate) as f32, brick.integrator);
        while brick.steps < due {
            // A step whose result is not finite returns an error and leaves the brick as it was.
            brick.now.step(Vec3::ZERO, Vec3::ZERO, step, integrator).ok();
            brick.steps += 1;
        }
        if let Ok(mut drawn) = drawn.get_mut(entity) {
            drawn.rotation = brick.now.rotation;
        }
        let share = brick.now.kinetic_energy() / brick.start.kinetic_energy();
        if let Ok(mut column) = drawn.get_mut(brick.column) {
            // Unbounded growth is cut off at the edge of the picture.
            column.scale.y = (COLUMN * share as f32).clamp(1e-3, 2.3);
            column.translation.y = FLOOR + 0.5 * column.scale.y;
        }
    }
}

fn spawn(world: &mut World) {
    let [rate, spin, off] = values(world);
    floor(world, Vec2::new(6.0, 2.4), Look::color(0x33404d).roughness(0.8));
    let mut start = RigidBody::solid_box(SIZE, MASS);
    start.angular_velocity = Vec3::new(0.01 * off, 1.0, 0.0) * spin;
    let skin = mesh(world, rounded_box(SIZE, 0.04, 3));
    let [stick, knob] = [cylinder(0.025, 0.2), ball(0.07)].map(|shape| mesh(world, shape));
    let [bar, line] = [Vec3::new(0.12, 1.0, 0.12), Vec3::new(0.3, 0.015, 0.15)]
        .map(|size| mesh(world, Cuboid::from_size(size)));
    let (steel, white) = (Look::color(0xb9bec6).metal(), Look::color(0xf1efe6).roughness(0.9));
    for (name, integrator, x, color) in [
        ("Euler", RigidIntegrator::Euler, -1.8, 0xd1495b),
        ("leapfrog", RigidIntegrator::Leapfrog, 0.0, 0x66a182),
        ("Verlet", RigidIntegrator::Verlet, 1.8, 0x4f8fc0),
    ] {
        let look = Look::color(color).roughness(0.4);
        let beside = x + 0.78;
        let at = Transform::from_xyz(beside, FLOOR + 0.5 * COLUMN, 0.0);
        let at = at.with_scale(Vec3::new(1.0, COLUMN, 1.0));
        let column = world.spawn((InScene, bar.clone(), look.clone(), at)).id();
        let at = Transform::from_xyz(beside, FLOOR + COLUMN, 0.03);
        world.spawn((InScene, line.clone(), white.clone(), at));
        let brick =
            Brick { start, now: start, integrator, rate: f64::from(rate), steps: 0, column };
        let at = Transform::from_xyz(x, HIGH, 0.0);
        let brick = world.spawn((InScene, Name::new(name), brick, skin.clone(), look, at)).id();
        // A knob marks the end that was up at first.
        let above = |y: f32| Transform::from_xyz(0.0, SIZE.y * 0.5 + y, 0.0);
        world.spawn((ChildOf(brick), stick.clone(), steel.clone(), above(0.1)));
        world.spawn((ChildOf(brick), knob.clone(), white.clone(), above(0.22)));
    }
}
