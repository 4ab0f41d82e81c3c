//! Sensor gates that count balls, a plate whose layers let red balls through and stop blue ones, and boxes that flash when they are hit.

use std::collections::BTreeSet;

use bevy::color::Mix;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ContactImpulse, SinewClock};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::quarters;
use crate::scene::{Heading, InScene, Lesson, OnStage, Scene, SceneSlider, values};
use crate::shapes::{ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "events",
    heading: Heading::Contacts,
    title: "Sensors, layers, contact events",
    about: "two gates count the balls that pass; the plate between them is solid for blue and not for red; a box flashes as hard as it is hit",
    eye: Vec3::new(1.7, 2.3, 5.7),
    target: Vec3::new(0.0, 1.4, 0.1),
    seconds: 6.0,
    moment: 3.4,
    lesson: Some(Lesson {
        try_this: "let more of them be red, or let them come faster; from higher up they reach the lower gate later, by the square root of the height",
        watch: "a gate is a sensor: it lights up and stops nothing; the plate's layers collide with blue balls only",
        formula: "n(t) = red balls released by t − √(2 d/g)",
        sliders: &[
            SceneSlider { label: "A ball every", unit: "s", range: [0.25, 1.0], default: 0.25 },
            SceneSlider { label: "Red of four", unit: "", range: [0.0, 4.0], default: 2.0 },
            SceneSlider { label: "Drop height", unit: "m", range: [0.2, 1.0], default: 0.5 },
        ],
        number: "Balls through the lower gate",
        unit: "balls",
        after: 3.0,
        measure: |world| {
            let mut gates = world.query::<&Gate>();
            Some(gates.iter(world).find(|gate| gate.lower)?.passed.len() as f64)
        },
        expect: |values, seconds| {
            let [every, red, above] = [values[0], values[1], values[2]];
            let way = start(above) - RADIUS - (LOWER + 0.5 * GATE.y);
            let falls = libm::sqrt(2.0 * f64::from(way) / 9.81);
            let let_go = (0..).take_while(|&n| f64::from(n) * quarters(every) + falls <= seconds);
            let_go.filter(|&n| is_red(n, red)).count() as f64
        },
        tolerance: [0.01, 0.0],
    }),
    spawn,
};

/// Radius of a ball, metres, and its mass, kg.
const RADIUS: f32 = 0.09;
const MASS: f32 = 0.8;
/// Size of a gate, and heights of the upper gate, of the plate and of the lower gate, metres.
const GATE: Vec3 = Vec3::new(2.3, 0.05, 0.5);
const UPPER: f32 = 2.35;
const PLATE: f32 = 1.75;
const LOWER: f32 = 1.1;
/// Number of lanes and their distance, metres: far enough apart that no ball falls onto the one before it.
const LANES: u32 = 5;
const LANE: f32 = 0.45;
/// Where a ball starts along z, metres, and its initial speed backwards, m/s: it lands on the box and rolls off it.
const START_Z: f32 = 0.12;
const DRIFT: f32 = 0.25;
/// Time after which a ball is despawned, seconds.
const BALL_LIFETIME: f64 = 7.0;
/// Fraction of a flash that remains after a tick.
const FLASH_DECAY: f32 = 0.9;

/// Layers of red balls, of blue balls, and of the plate, which collides with blue balls only.
const RED: CollisionLayers = CollisionLayers::new(1 << 1, u32::MAX);
const BLUE: CollisionLayers = CollisionLayers::new(1 << 2, u32::MAX);
const FILTER: CollisionLayers = CollisionLayers::new(1 << 3, 1 << 2);

/// Height at which a ball starts, metres.
fn start(above: f32) -> f32 {
    UPPER + above + 0.2
}

/// Whether ball number `n` is red, if `of_four` in four are.
fn is_red(n: u32, of_four: f32) -> bool {
    let red = of_four.round().max(0.0) as u32;
    (n * red) % 4 < red
}

/// A sensor that counts.
#[derive(Component, Clone, Debug, Default)]
pub(crate) struct Gate {
    lower: bool,
    passed: BTreeSet<Entity>,
    /// The frame that flashes.
    frame: Option<Entity>,
}

/// Spawns balls; counts them.
#[derive(Component, Clone, Debug)]
pub(crate) struct Dispenser {
    next: u32,
    /// Mesh of the balls.
    mesh: Mesh3d,
}

/// Time at which a ball was spawned, seconds.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Dropped(f64);

/// A flash: its brightness, 0 to 1, and its dark and bright colour.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Flash {
    bright: f32,
    colors: [u32; 2],
}

impl Flash {
    fn look(&self) -> Look {
        // In steps, because each different look gets a material of its own.
        let share = (self.bright.clamp(0.0, 1.0) * 12.0).round() / 12.0;
        let [dark, bright] = self.colors.map(|color| Look::color(color).color);
        Look { color: dark.mix(&bright, share), ..Look::color(0).roughness(0.5) }
    }
}

/// Spawns a ball whenever one is due, and despawns those that are too old.
pub(crate) fn dispense(
    clock: Res<SinewClock>,
    stage: Option<Res<OnStage>>,
    mut commands: Commands,
    mut dispensers: Query<&mut Dispenser>,
    dropped: Query<(Entity, &Dropped)>,
) {
    let (Ok(mut dispenser), Some(stage)) = (dispensers.single_mut(), stage) else { return };
    let [every, red, above] = [stage.values[0], stage.values[1], stage.values[2]];
    let (n, now) = (dispenser.next, clock.seconds);
    for (entity, _) in dropped.iter().filter(|(_, dropped)| now - dropped.0 > BALL_LIFETIME) {
        commands.entity(entity).despawn();
    }
    if now + 1e-4 < f64::from(n) * quarters(every) {
        return;
    }
    dispenser.next += 1;
    let (layers, color) = if is_red(n, red) { (RED, 0xd1495b) } else { (BLUE, 0x3d7ea6) };
    let x = LANE * ((n % LANES) as f32 - 0.5 * (LANES - 1) as f32);
    let body = RigidMesh::mass(MASS).shaped(RigidShape::Sphere { radius: RADIUS });
    let at = Transform::from_xyz(x, start(above), START_Z);
    let look = Look::color(color).roughness(0.25);
    let mut made =
        commands.spawn((InScene, Name::new("ball"), Dropped(now), body, layers, look, at));
    let velocity = LinearVelocity(Vec3::NEG_Z * DRIFT);
    made.insert((SurfaceMaterial::new(0.3), velocity, Interpolate, dispenser.mesh.clone()));
}

/// Counts the balls that enter the gates, and lights up what was entered or hit.
pub(crate) fn count_and_flash(
    mut started: MessageReader<ContactStarted>,
    mut impulses: MessageReader<ContactImpulse>,
    balls: Query<(), With<Dropped>>,
    mut gates: Query<&mut Gate>,
    mut flashes: Query<(&mut Flash, &mut Look)>,
) {
    for (mut flash, _) in &mut flashes {
        flash.bright *= FLASH_DECAY;
    }
    for event in started.read().filter(|event| balls.contains(event.other)) {
        let Ok(mut gate) = gates.get_mut(event.entity) else { continue };
        gate.passed.insert(event.other);
        if let Some(frame) = gate.frame
            && let Ok((mut flash, _)) = flashes.get_mut(frame)
        {
            flash.bright = 1.0;
        }
    }
    // The momentum of a ball that falls onto a box from half a metre above the upper gate, N·s: full brightness.
    let full = MASS * libm::sqrtf(2.0 * 9.81 * start(0.5));
    for event in impulses.read().filter(|event| balls.contains(event.other)) {
        if let Ok((mut flash, _)) = flashes.get_mut(event.entity) {
            flash.bright = flash.bright.max(event.impulse / full);
        }
    }
    for (flash, mut look) in &mut flashes {
        look.set_if_neq(flash.look());
    }
}

fn spawn(world: &mut World) {
    let [_, _, above] = values(world);
    world.insert_resource(AirDrag(0.0));
    floor(world, Vec2::new(4.2, 3.4), Look::color(0x3d464d).roughness(0.95));
    let mesh_of_balls = mesh(world, ball(RADIUS));
    world.spawn((InScene, Dispenser { next: 0, mesh: mesh_of_balls }));
    gate(world, UPPER, false);
    gate(world, LOWER, true);
    let steel = Look::color(0xaab2ba).metal();
    let wide = 0.5 * GATE.x + 0.1;
    let high = start(above) + 0.15;
    let post = mesh(world, rounded_box(Vec3::new(0.07, high, 0.07), 0.02, 2));
    for x in [-wide, wide] {
        let at = Transform::from_xyz(x, 0.5 * high, -0.35);
        world.spawn((InScene, post.clone(), steel.clone(), at));
    }
    // The hopper that the balls seem to come from. It has no collider.
    let hopper = mesh(world, rounded_box(Vec3::new(2.0 * wide, 0.1, 0.34), 0.03, 3));
    let at = Transform::from_xyz(0.0, high, -0.2);
    world.spawn((InScene, hopper, steel.clone(), at));
    // The plate, tilted towards the front so that the balls it stops roll off there.
    let size = Vec3::new(GATE.x, 0.03, 0.95);
    let plate = (Collider::cuboid(size), FILTER, SurfaceMaterial::new(0.1));
    let skin = mesh(world, rounded_box(size, 0.01, 2));
    let tilt = Quat::from_rotation_x(0.24);
    let at = Transform::from_xyz(0.0, PLATE, 0.1).with_rotation(tilt);
    let glass = Look::color(0x9cc4d8).roughness(0.1);
    world.spawn((InScene, Name::new("plate"), plate, skin, glass, at));
    // A box below each lane, and walls that keep the balls together, blue ones in front.
    let size = Vec3::new(0.32, 0.3, 0.32);
    let skin = mesh(world, rounded_box(size, 0.03, 3));
    for lane in 0..LANES {
        let x = LANE * (lane as f32 - 0.5 * (LANES - 1) as f32);
        let flash = Flash { bright: 0.0, colors: [0x6b5540, 0xffd23f] };
        world.spawn((
            InScene,
            Name::new("box"),
            RigidBox::new(size).with_mass(12.0),
            ContactEvents::Every,
            (flash, flash.look(), skin.clone(), Interpolate),
            Transform::from_xyz(x, FLOOR + 0.5 * size.y, 0.0),
        ));
    }
    let stone = Look::color(0x6d7780).roughness(0.8);
    for (size, x, z) in [
        (Vec3::new(4.2, 0.3, 0.08), 0.0, 1.66),
        (Vec3::new(4.2, 0.3, 0.08), 0.0, -1.66),
        (Vec3::new(4.2, 0.2, 0.08), 0.0, 0.55),
        (Vec3::new(0.08, 0.3, 3.4), 2.06, 0.0),
        (Vec3::new(0.08, 0.3, 3.4), -2.06, 0.0),
    ] {
        let skin = mesh(world, rounded_box(size, 0.02, 2));
        let at = Transform::from_xyz(x, FLOOR + 0.5 * size.y, z);
        world.spawn((InScene, Collider::cuboid(size), skin, stone.clone(), at));
    }
}

/// A sensor, and a frame around it that flashes.
fn gate(world: &mut World, high: f32, lower: bool) {
    let flash = Flash { bright: 0.0, colors: [0x4a5560, 0x7dffb0] };
    let half = 0.5 * Vec2::new(GATE.x, GATE.z);
    let bar = |size: Vec3, x: f32, z: f32| {
        rounded_box(size, 0.012, 2).transformed_by(Transform::from_xyz(x, 0.0, z))
    };
    let mut frame = bar(Vec3::new(GATE.x + 0.1, 0.05, 0.05), 0.0, half.y);
    for (size, x, z) in [
        (Vec3::new(GATE.x + 0.1, 0.05, 0.05), 0.0, -half.y),
        (Vec3::new(0.05, 0.05, GATE.z), half.x, 0.0),
        (Vec3::new(0.05, 0.05, GATE.z), -half.x, 0.0),
    ] {
        // All bars have the same attributes, so merging cannot fail.
        frame.merge(&bar(size, x, z)).ok();
    }
    let frame = mesh(world, frame);
    let at = Transform::from_xyz(0.0, high, 0.0);
    let frame = world.spawn((InScene, flash, flash.look(), frame, at)).id();
    let gate = Gate { lower, frame: Some(frame), ..default() };
    let sensor = (Collider::cuboid(GATE), Sensor, ContactEvents::Changes);
    world.spawn((InScene, Name::new("gate"), gate, sensor, at));
}
