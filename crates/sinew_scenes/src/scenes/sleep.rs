//! A field of sleeping stacks, and a ball that is thrown at one after the other.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::scene::{Heading, InScene, Lesson, OnStage, Scene, SceneSlider, values};
use crate::shapes::{ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "sleep",
    heading: Heading::Contacts,
    title: "Sleeping bodies cost nothing",
    about: "blue boxes sleep, orange ones are awake, green ones have been woken and sleep again: the ball wakes only the stack that it hits",
    eye: Vec3::new(4.2, 4.2, 7.4),
    target: Vec3::new(0.1, 0.1, 0.4),
    seconds: 8.0,
    moment: 3.65,
    lesson: Some(Lesson {
        try_this: "stack higher, or add stacks: the cost of a tick depends on the awake ones",
        watch: "a hit wakes everything that lies on the box at once; half a second after it comes to rest it sleeps again",
        formula: "woken = boxes in a stack × hits",
        sliders: &[
            SceneSlider { label: "Boxes in a stack", unit: "", range: [1.0, 4.0], default: 3.0 },
            SceneSlider { label: "Stacks in a row", unit: "", range: [3.0, 7.0], default: 5.0 },
            SceneSlider { label: "Ball mass", unit: "kg", range: [0.5, 2.0], default: 1.5 },
        ],
        number: "Boxes that were woken",
        unit: "boxes",
        after: 3.1,
        measure: |world| {
            let mut boxes = world.query::<&Sleeper>();
            Some(boxes.iter(world).filter(|one| one.woken).count() as f64)
        },
        expect: |values, seconds| {
            let [high, row] = [values[0], values[1]].map(|value| f64::from(value.round()));
            let hits = ((seconds - FIRST_THROW - FLIGHT_TIME) / INTERVAL).floor() + 1.0;
            high * hits.clamp(0.0, row * row)
        },
        tolerance: [0.01, 0.0],
    }),
    spawn,
};

/// Edge of a box, metres; its mass, kg; and the distance between stacks, metres: boxes that fall off one do not reach the next.
const EDGE: f32 = 0.3;
const MASS: f32 = 2.0;
const SPACING: f32 = 1.8;
/// Time of the first throw, interval between throws, and time of flight, seconds.
const FIRST_THROW: f64 = 1.0;
const INTERVAL: f64 = 1.0;
const FLIGHT_TIME: f64 = 0.4;
/// Where the ball starts relative to its target, metres: from above and between the rows, so that it passes no other stack closely.
const FROM: Vec3 = Vec3::new(1.0, 0.5, 1.0);
/// Radius of the ball, metres.
const RADIUS: f32 = 0.16;

/// A box: whether it has slept, and whether it has been woken.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Sleeper {
    slept: bool,
    woken: bool,
}

impl Sleeper {
    fn look(self, asleep: bool) -> Look {
        let color = match (asleep, self.woken) {
            (true, false) => 0x4a6d8f,
            (true, true) => 0x4f9a80,
            (false, _) => 0xf08c3a,
        };
        Look::color(color).roughness(0.6)
    }
}

/// The ball: how often it was thrown, and whether it is back.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(crate) struct Thrown {
    times: u32,
    is_back: bool,
}

/// Time from a hit until the ball is taken back, seconds: before it rolls to another stack.
const RETURN_AFTER: f64 = 0.2;

/// Throws the ball when a throw is due, each time at another stack, and takes it back.
pub(crate) fn throw(
    clock: Res<SinewClock>,
    stage: Option<Res<OnStage>>,
    mut commands: Commands,
    mut balls: Query<(Entity, &mut Thrown)>,
) {
    let (Ok((ball, mut thrown)), Some(stage)) = (balls.single_mut(), stage) else { return };
    let n = thrown.times;
    let (high, row) = (stage.values[0].round(), stage.values[1].round() as u32);
    let lies = clock.seconds + 1e-4
        >= FIRST_THROW + (f64::from(n) - 1.0) * INTERVAL + FLIGHT_TIME + RETURN_AFTER;
    if n > 0 && lies && !thrown.is_back {
        thrown.is_back = true;
        let mut ball = commands.entity(ball);
        ball.teleport(Transform::from_translation(ball_rest_position(row)))
            .set_motion(Vec3::ZERO, Vec3::ZERO);
    }
    if n >= row * row || clock.seconds + 1e-4 < FIRST_THROW + f64::from(n) * INTERVAL {
        return;
    }
    *thrown = Thrown { times: n + 1, is_back: false };
    // A stride that is coprime to the number of stacks, so that it visits all of them, and long enough that no two consecutive targets are neighbours.
    let step = (row * row * 13 / 34..).find(|&step| gcd(step, row * row) == 1).unwrap_or(1);
    let first = row * row / 2 + row / 2;
    let target = stack((first + n * step) % (row * row), row);
    let target = target + Vec3::Y * (FLOOR + EDGE * (high - 0.45));
    let (from, flies) = (target + FROM, FLIGHT_TIME as f32);
    let velocity = -FROM / flies + Vec3::Y * (0.5 * 9.81 * flies);
    let mut ball = commands.entity(ball);
    ball.teleport(Transform::from_translation(from)).set_motion(velocity, Vec3::ZERO);
}

/// Where the ball waits, metres: at a corner of the field.
fn ball_rest_position(row: u32) -> Vec3 {
    let corner = 0.5 * side(row) - 0.3;
    Vec3::new(corner, FLOOR + RADIUS, corner)
}

/// Length and width of the field, metres.
fn side(row: u32) -> f32 {
    row as f32 * SPACING + 0.9
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Position of a stack, metres.
fn stack(number: u32, row: u32) -> Vec3 {
    let middle = 0.5 * (row - 1) as f32;
    let [x, z] = [number % row, number / row].map(|i| (i as f32 - middle) * SPACING);
    Vec3::new(x, 0.0, z)
}

/// Records which boxes were woken, and colours the boxes by their state. Runs after the tick.
pub(crate) fn record_sleep(mut boxes: Query<(&Sleep, &mut Sleeper, &mut Look)>) {
    for (sleep, mut one, mut look) in &mut boxes {
        let now = Sleeper {
            slept: one.slept || sleep.asleep,
            woken: one.woken || one.slept && !sleep.asleep,
        };
        if now.slept != one.slept || now.woken != one.woken {
            *one = now;
        }
        look.set_if_neq(now.look(sleep.asleep));
    }
}

fn spawn(world: &mut World) {
    let [high, row, mass] = values(world);
    let (high, row) = (high.round() as u32, row.round() as u32);
    world.insert_resource(AirDrag(0.0));
    let ground = floor(world, Vec2::splat(side(row)), Look::color(0x59636b).roughness(0.95));
    world.entity_mut(ground).insert(SurfaceMaterial::new(0.7));
    let skin = mesh(world, rounded_box(Vec3::splat(EDGE), 0.02, 2));
    for n in 0..row * row {
        let turn = Quat::from_rotation_y(0.35 * (n % 5) as f32);
        for layer in 0..high {
            let at = stack(n, row) + Vec3::Y * (FLOOR + EDGE * (layer as f32 + 0.5));
            let one = Sleeper::default();
            world.spawn((
                InScene,
                Name::new("box"),
                RigidBox::new(Vec3::splat(EDGE)).with_mass(MASS),
                (Sleep::default(), SurfaceMaterial::new(0.6)),
                (one, one.look(false), skin.clone(), Interpolate),
                Transform::from_translation(at).with_rotation(turn),
            ));
        }
    }
    let skin = mesh(world, ball(RADIUS));
    world.spawn((
        InScene,
        Name::new("ball"),
        Thrown::default(),
        RigidMesh::mass(mass).shaped(RigidShape::Sphere { radius: RADIUS }),
        SurfaceMaterial::new(0.9),
        (skin, Look::color(0xd1495b).roughness(0.3), Interpolate),
        Transform::from_translation(ball_rest_position(row)),
    ));
}
