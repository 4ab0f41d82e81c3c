//! Three ways to move a stone: an impulse at once, a force over time, and teleporting it, which gives it no momentum.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Combine, ControlForce, SinewClock, WorldCenterOfMass};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::{Rounds, into_round, quarters};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "impulses",
    heading: Heading::Forces,
    title: "Impulse, force, teleport",
    about: "red gets its momentum at once, yellow by a force over time; blue is teleported and has none",
    eye: Vec3::new(0.2, 1.9, 5.3),
    target: Vec3::new(0.0, 0.2, 0.0),
    seconds: 4.0,
    moment: 1.4,
    lesson: Some(Lesson {
        try_this: "let the force last longer: yellow reaches the same speed, only later; a heavier stone is slower with the same momentum",
        watch: "red moves at once; yellow speeds up until it is as fast; blue is moved as fast as red, and stops as soon as it is released",
        formula: "Δp = J = F T, v = J/m; a teleport changes x and leaves p",
        sliders: &[
            SceneSlider { label: "Impulse", unit: "N·s", range: [1.0, 4.0], default: 2.5 },
            SceneSlider { label: "Force duration", unit: "s", range: [0.25, 1.0], default: 0.5 },
            SceneSlider { label: "Mass", unit: "kg", range: [1.5, 4.0], default: 2.0 },
        ],
        number: "Momentum of the yellow stone",
        unit: "kg·m/s",
        after: 1.25,
        measure: |world| {
            let velocity: LinearVelocity = component_of(world, "force")?;
            let weight: WorldCenterOfMass = component_of(world, "force")?;
            Some(f64::from(velocity.0.x) * f64::from(weight.mass))
        },
        expect: |values, seconds| {
            let lasts = quarters(values[1]);
            f64::from(values[0]) * (into_round(seconds, ROUND) / lasts).min(1.0)
        },
        tolerance: [5e-3, 5e-3],
    }),
    spawn,
};

/// All stones start again after this time, seconds.
const ROUND: f64 = 2.0;
/// Radius and height of a stone, and where the stones start along x, metres.
const RADIUS: f32 = 0.2;
const HIGH: f32 = 0.2;
const START: f32 = -2.4;

/// How a stone is moved.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) enum Push {
    /// An impulse, N·s.
    Impulse(f32),
    /// A force, N, and its duration, seconds.
    Force(f32, f64),
    /// Displacements at this speed, m/s, for this time, seconds.
    Teleport(f32, f64),
}

/// Moves the stones, and brings them back when a round ends.
pub(crate) fn push(
    clock: Res<SinewClock>,
    time: Res<Time>,
    mut commands: Commands,
    mut stones: Query<(Entity, &Push, &mut Rounds, &Transform, Option<&mut ControlForce>)>,
) {
    for (stone, push, mut rounds, at, force) in &mut stones {
        let anew = rounds.ended(&clock).is_some();
        let mut stone = commands.entity(stone);
        if anew {
            let start = at.translation.with_x(START);
            stone.teleport(Transform::from_translation(start));
            stone.set_motion(Vec3::ZERO, Vec3::ZERO);
        }
        let passed = if anew { 0.0 } else { into_round(clock.seconds, ROUND) + 1e-4 };
        match *push {
            Push::Impulse(impulse) if anew => _ = stone.apply_impulse(Vec3::X * impulse),
            Push::Impulse(_) => {}
            Push::Force(newton, lasts) => {
                if let Some(mut force) = force {
                    force.force = if passed < lasts { Vec3::X * newton } else { Vec3::ZERO };
                }
            }
            Push::Teleport(speed, lasts) if passed < lasts && clock.tick > 0 => {
                stone.displace(Vec3::X * (speed * time.delta_secs()));
            }
            Push::Teleport(..) => {}
        }
    }
}

fn spawn(world: &mut World) {
    let [impulse, lasts, mass] = values(world);
    let lasts = quarters(lasts);
    world.insert_resource(AirDrag(0.0));
    floor(world, Vec2::new(6.2, 2.7), Look::color(0xe3edf2).roughness(0.1));
    let curb = mesh(world, rounded_box(Vec3::new(6.2, 0.16, 0.12), 0.03, 2));
    for z in [-1.35, 1.35] {
        let at = Transform::from_xyz(0.0, FLOOR + 0.04, z);
        world.spawn((InScene, curb.clone(), Look::color(0x2f4858).roughness(0.5), at));
    }
    let mark = mesh(world, Cuboid::new(0.04, 0.006, 2.5));
    let at = Transform::from_xyz(START, FLOOR + 0.003, 0.0);
    world.spawn((InScene, mark, Look::color(0xd1495b), at));
    let [stone, handle] =
        [cylinder(RADIUS, HIGH), rounded_box(Vec3::new(0.22, 0.05, 0.06), 0.02, 3)]
            .map(|shape| mesh(world, shape));
    let neck = mesh(world, cylinder(0.025, 0.08));
    let force = impulse / lasts as f32;
    let speed = impulse / mass;
    let granite = Look::color(0x7d8288).roughness(0.6);
    let ice = SurfaceMaterial { friction_rule: Combine::Multiply, ..SurfaceMaterial::new(0.0) };
    for (name, push, z, color) in [
        ("impulse", Push::Impulse(impulse), -0.8, 0xd1495b),
        ("force", Push::Force(force, lasts), 0.0, 0xe9b44c),
        ("teleport", Push::Teleport(speed, lasts), 0.8, 0x3d7ea6),
    ] {
        let shape = RigidShape::Cylinder { radius: RADIUS, height: HIGH };
        let mut made = world.spawn((
            InScene,
            Name::new(name),
            RigidMesh::mass(mass).shaped(shape),
            ice,
            push,
            Rounds::of(ROUND),
            stone.clone(),
            granite.clone(),
            Interpolate,
            Transform::from_xyz(START, FLOOR + 0.5 * HIGH, z),
        ));
        match push {
            Push::Impulse(impulse) => _ = made.apply_impulse(Vec3::X * impulse),
            Push::Force(..) => _ = made.insert(ControlForce::default()),
            Push::Teleport(..) => {}
        }
        let body = made.id();
        let look = Look::color(color).roughness(0.3);
        for (part, up) in [(neck.clone(), 0.13), (handle.clone(), 0.18)] {
            world.spawn((ChildOf(body), part, look.clone(), Transform::from_xyz(0.0, up, 0.0)));
        }
    }
}
