//! Two cars: one is driven by a torque on its wheels, the other by a force on its body.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{AttachmentOf, ControlForce, SinewClock};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::into_round;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "car",
    heading: Heading::Forces,
    title: "Torque on wheels, force on body",
    about: "the red car is driven by its axles, the blue one is pushed by a force of torque over radius: both reach the same speed, because the road pushes the red one",
    eye: Vec3::new(0.4, 2.5, 5.6),
    target: Vec3::new(0.0, 0.35, 0.0),
    seconds: 5.0,
    moment: 1.2,
    lesson: Some(Lesson {
        try_this: "turn up the torque, load the car, or use larger wheels: the same torque makes less force at a larger wheel",
        watch: "both speed up for 1.25 s, brake for as long, and drive back; part of the torque goes into turning the wheels",
        formula: "a = (2τ/r) / (M + 2m + 2I/r²), with I = ½ m r² for each axle",
        sliders: &[
            SceneSlider { label: "Torque", unit: "N·m", range: [2.0, 8.0], default: 5.0 },
            SceneSlider { label: "Load", unit: "kg", range: [10.0, 40.0], default: 20.0 },
            SceneSlider { label: "Wheel radius", unit: "m", range: [0.18, 0.3], default: 0.22 },
        ],
        number: "Speed of the driven car",
        unit: "m/s",
        after: 1.0,
        measure: |world| {
            let velocity: LinearVelocity = component_of(world, "driven car")?;
            Some(f64::from(velocity.0.x))
        },
        expect: |values, seconds| {
            let [torque, load, radius] = [values[0], values[1], values[2]].map(f64::from);
            let axle = f64::from(AXLE);
            let inertia = 2.0 * 0.5 * axle;
            2.0 * torque / radius / (load + 2.0 * axle + inertia) * pushed_for(seconds)
        },
        tolerance: [0.01, 0.02],
    }),
    spawn,
};

/// Size of the body of a car, metres, and mass of an axle with its two wheels, kg.
const BODY: Vec3 = Vec3::new(1.5, 0.2, 0.5);
const AXLE: f32 = 3.0;
/// Width over the wheels, and distance of each axle from the middle, metres.
const WIDE: f32 = 0.8;
const BASE: f32 = 0.5;
/// Time for which the cars speed up, seconds. They brake for as long, and then drive back in the same way.
const PUSH: f64 = 1.25;

/// A control force that reverses periodically, so that the car comes back.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct ToAndFro {
    force: Vec3,
    torque: Vec3,
}

/// Reverses the control forces. The sign is a function of simulated time alone.
pub(crate) fn drive(clock: Res<SinewClock>, mut forces: Query<(&ToAndFro, &mut ControlForce)>) {
    let passed = into_round(clock.seconds, 4.0 * PUSH) + 1e-4;
    let sign = if (PUSH..3.0 * PUSH).contains(&passed) { -1.0 } else { 1.0 };
    for (drive, mut force) in &mut forces {
        force.force = drive.force * sign;
        force.torque = drive.torque * sign;
    }
}

/// The time for which the force has pushed forward, less the time for which it has pushed back, seconds.
fn pushed_for(seconds: f64) -> f64 {
    let passed = into_round(seconds, 4.0 * PUSH);
    if passed < PUSH {
        passed
    } else if passed < 3.0 * PUSH {
        2.0 * PUSH - passed
    } else {
        passed - 4.0 * PUSH
    }
}

fn spawn(world: &mut World) {
    let [torque, load, radius] = values(world);
    world.insert_resource(AirDrag(0.0));
    let road = floor(world, Vec2::new(9.0, 3.2), Look::color(0x4b4f54).roughness(0.95));
    world.entity_mut(road).insert(SurfaceMaterial::new(1.0));
    let stripe = mesh(world, Cuboid::new(0.5, 0.006, 0.06));
    for i in 0..9 {
        let at = Transform::from_xyz(i as f32 - 4.0, FLOOR + 0.003, 0.0);
        world.spawn((InScene, stripe.clone(), Look::color(0xefe9dc), at));
    }
    let forward = ControlForce::new(Vec3::X * (2.0 * torque / radius));
    // A wheel that rolls towards +x turns about -z; the reaction turns the body the other way.
    let wheel = ControlForce::torque(Vec3::NEG_Z * torque);
    let body = ControlForce::torque(Vec3::Z * (2.0 * torque));
    let none = ControlForce::default();
    car(world, "driven car", 0.75, 0xc0392b, radius, load, [body, wheel]);
    car(world, "pushed car", -0.75, 0x2e6f9e, radius, load, [forward, none]);
}

/// A car with a force on its body and one on each of its axles.
fn car(
    world: &mut World,
    name: &'static str,
    z: f32,
    color: u32,
    radius: f32,
    load: f32,
    [on_body, on_axle]: [ControlForce; 2],
) {
    let driven =
        |force: ControlForce| (ToAndFro { force: force.force, torque: force.torque }, force);
    let start = Vec3::new(-1.6, FLOOR + radius, z);
    let paint = Look::color(color).roughness(0.25);
    let shell = mesh(world, rounded_box(BODY, 0.08, 4));
    let body = world
        .spawn((
            InScene,
            Name::new(name),
            RigidBox::new(BODY).with_mass(load),
            driven(on_body),
            shell,
            paint.clone(),
            Interpolate,
            Transform::from_translation(start + Vec3::Y * 0.16),
        ))
        .id();
    let size = Vec3::new(0.75, 0.26, 0.44);
    let cabin = mesh(world, rounded_box(size, 0.1, 4));
    let on = Transform::from_xyz(-0.1, 0.5 * (BODY.y + size.y) - 0.05, 0.0);
    world.spawn((ChildOf(body), cabin, Look::color(0xdfe6ea).roughness(0.15), on));
    let (tyre, cap) =
        (mesh(world, cylinder(radius, 0.14)), mesh(world, cylinder(0.6 * radius, 0.15)));
    // Off centre, so that the rotation is visible.
    let bolt = mesh(world, cylinder(0.12 * radius, 0.17));
    let rod = mesh(world, cylinder(0.03, WIDE));
    let (rubber, steel) = (Look::color(0x22252a).roughness(0.9), Look::color(0xc8ccd2).metal());
    let along = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    for x in [-BASE, BASE] {
        let at = Transform::from_translation(start + Vec3::X * x).with_rotation(along);
        let axle = world
            .spawn((
                InScene,
                RigidMesh::mass(AXLE).shaped(RigidShape::Cylinder { radius, height: WIDE }),
                SurfaceMaterial::new(1.0),
                driven(on_axle),
                rod.clone(),
                steel.clone(),
                Interpolate,
                at,
            ))
            .id();
        for side in [-0.5, 0.5] {
            // Two points on the axle, each attached to the body, form a hinge.
            let end = Vec3::Y * (side * WIDE);
            let tie = AttachTo::new(body).part(Anchor::Point(end));
            world.spawn((tie, AttachmentOf(axle)));
            let place = |out: Vec3| Transform::from_translation(end * 0.82 + out);
            world.spawn((ChildOf(axle), tyre.clone(), rubber.clone(), place(Vec3::ZERO)));
            world.spawn((ChildOf(axle), cap.clone(), steel.clone(), place(Vec3::ZERO)));
            let out = Vec3::X * (0.42 * radius);
            world.spawn((ChildOf(axle), bolt.clone(), paint.clone(), place(out)));
        }
    }
}
