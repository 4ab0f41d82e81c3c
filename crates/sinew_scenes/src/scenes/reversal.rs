//! Balls that fly forward, are reversed in time, and return to where they started.

use bevy::math::DVec3;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Drag, SinewClock};

use crate::look::Look;
use crate::props::{FLOOR, curve, floor, mesh, post};
use crate::rounds::{Rounds, into_round, quarters};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "reversal",
    heading: Heading::Integration,
    title: "Time reversed",
    about: "turned back in time, the golden balls arrive at their posts; the red one has drag, and does not",
    eye: Vec3::new(0.0, 1.9, 5.6),
    target: Vec3::new(0.0, 1.5, 0.0),
    seconds: 4.0,
    moment: 0.5,
    lesson: Some(Lesson {
        try_this: "change when the balls turn back, how fast they are thrown and how strong gravity is: gold always comes back",
        watch: "each golden ball returns along its line to its post; the red one has lost speed to drag and misses its post",
        formula: "s = |v τ + ½ g τ²|, τ = t before the turn and 2T − t after it",
        sliders: &[
            SceneSlider { label: "Turn after", unit: "s", range: [0.5, 1.0], default: 0.75 },
            SceneSlider { label: "Speed", unit: "m/s", range: [4.0, 6.0], default: 5.0 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [5.0, 9.81], default: 9.81 },
        ],
        number: "Post to the farthest golden ball",
        unit: "m",
        after: 1.4,
        measure: |world| {
            let mut balls = world.query::<(&Thrown, &Particle)>();
            let far = |(thrown, ball): (&Thrown, &Particle)| {
                f64::from(ball.position.distance(thrown.from))
            };
            balls.iter(world).map(far).reduce(f64::max)
        },
        expect: |values, seconds| {
            let time = time_of(quarters(values[0]), seconds);
            let far = |i| {
                let fall = DVec3::NEG_Y * (0.5 * f64::from(values[2]) * time * time);
                (throw(i, values[1]).as_dvec3() * time + fall).length()
            };
            (0..COUNT).map(far).fold(0.0, f64::max)
        },
        tolerance: [2e-3, 0.0],
    }),
    spawn,
};

/// Number of golden balls, and their distance at the start, metres.
const COUNT: usize = 6;
const APART: f32 = 0.42;
/// Height of the posts over the floor and radius of a ball, metres.
const POST: f32 = 0.9;
const RADIUS: f32 = 0.08;
/// Reversing goes back by one substep at once, seconds: that of a tick of 1/60 s with the default of 10 substeps.
const SUBSTEP: f64 = 1.0 / 600.0;

/// A ball that is reversed without drag, and where it started, metres.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Thrown {
    from: Vec3,
}

/// A ball that is reversed at the end of each of its rounds.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct TurnsBack(Rounds);

/// Reverses the balls whose round has ended.
pub(crate) fn turn_back(clock: Res<SinewClock>, mut balls: Query<(&mut TurnsBack, &mut Particle)>) {
    for (mut turns, mut ball) in &mut balls {
        if turns.0.ended(&clock).is_some() {
            ball.reverse();
        }
    }
}

/// The time along its flight, seconds, of a ball that is reversed every `turn` seconds.
fn time_of(turn: f64, seconds: f64) -> f64 {
    let passed = into_round(seconds, 2.0 * turn);
    if passed <= turn + 1e-4 { passed } else { 2.0 * turn - passed - SUBSTEP }
}

/// Start of a ball, metres.
fn start(i: usize) -> Vec3 {
    let along = (i as f32 - 0.5 * (COUNT as f32 - 1.0)) * APART;
    Vec3::new(along, FLOOR + POST + RADIUS + 0.03, 0.0)
}

/// Initial velocity of a ball, m/s: each leans a little further to its side.
fn throw(i: usize, speed: f32) -> Vec3 {
    let lean = (i as f32 - 0.5 * (COUNT as f32 - 1.0)) * 0.085;
    let (sin, cos) = libm::sincosf(lean);
    Vec3::new(sin, cos, 0.0) * speed
}

fn spawn(world: &mut World) {
    let [turn, speed, gravity] = values(world);
    let turn = quarters(turn);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.0));
    floor(world, Vec2::new(5.6, 2.4), Look::color(0x39465c).roughness(0.7));
    let skin = mesh(world, ball(RADIUS));
    let stand = post(world, 0.045, POST);
    let dark = Look::color(0x596a80).roughness(0.5);
    let mut throw_one = |from: Vec3, velocity: Vec3, color: u32| {
        let under = Transform::from_translation(from.with_y(FLOOR + 0.5 * POST));
        world.spawn((InScene, stand.clone(), dark.clone(), under));
        let path = |k: i32| {
            let time = turn as f32 * k as f32 / 24.0;
            from + velocity * time + Vec3::NEG_Y * (0.5 * gravity * time * time)
        };
        let path: Vec<Vec3> = (0..=24).map(path).collect();
        curve(world, &path, 0.012, Look::color(0xd7dbe0));
        world
            .spawn((
                InScene,
                Particle::at(from).with_velocity(velocity),
                Radius(RADIUS),
                TurnsBack(Rounds::of(turn)),
                Interpolate,
                Transform::from_translation(from),
                skin.clone(),
                Look::color(color).roughness(0.3),
            ))
            .id()
    };
    let red = throw_one(start(COUNT), throw(COUNT, speed), 0xd1495b);
    let gold: Vec<Entity> =
        (0..COUNT).map(|i| throw_one(start(i), throw(i, speed), 0xe9b44c)).collect();
    world.entity_mut(red).insert(Drag(0.5));
    for (i, ball) in gold.into_iter().enumerate() {
        world.entity_mut(ball).insert(Thrown { from: start(i) });
    }
}
