//! Joints with limits: flaps, elbows, and a tail.

use core::f32::consts::PI;

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Articulated, TubeMesh};
use bevy_sinew::{BodyParts, BodySolver, Bone, BoneJoint, GradientAt};

use crate::look::Look;
use crate::props::post;
use crate::readings::nth_component_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};

pub(super) const SCENE: Scene = Scene {
    name: "hinges",
    heading: Heading::Constraints,
    title: "Hinges, elbows, cones",
    about: "each flap stops at its red mark; the orange elbow never bends backward, the grey one does; each bone of the tail stays within 20° of the previous one",
    eye: Vec3::new(1.45, 2.1, 6.9),
    target: Vec3::new(0.1, 1.4, 0.0),
    seconds: 6.0,
    moment: 1.9,
    lesson: Some(Lesson {
        try_this: "move the stop of the first flap (the red mark) or the cones of the tail, and increase gravity",
        watch: "a limit is an inequality: it is inactive while a flap is above its mark, and stops the flap there, whatever gravity is",
        formula: "−φ_stop ≤ φ ≤ 0; the flap rests at φ = −φ_stop",
        sliders: &[
            SceneSlider { label: "Stop", unit: "°", range: [15.0, 80.0], default: 52.0 },
            SceneSlider { label: "Cone", unit: "°", range: [10.0, 30.0], default: 20.0 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [3.7, 20.0], default: 9.81 },
        ],
        number: "Angle of the first flap",
        unit: "°",
        after: 3.0,
        measure: |world| {
            let parts: BodyParts = nth_component_of(world, "signal", 0)?;
            let flap = world.get::<Transform>(parts.iter().nth(1)?)?.rotation * Vec3::NEG_Y;
            Some(libm::atan2(f64::from(-flap.y), f64::from(flap.x)).to_degrees())
        },
        expect: |values, _| f64::from(values[0]),
        tolerance: [0.5, 0.0],
    }),
    spawn,
};

/// How far the second and the third flap fall from the horizontal, radians.
const FLAPS: [f32; 2] = [1.8, 2.3];

fn spawn(world: &mut World) {
    let [stop, cone, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.1));
    world.spawn((InScene, Ground));
    for (i, far) in [stop.to_radians(), FLAPS[0], FLAPS[1]].into_iter().enumerate() {
        flap(world, Vec3::new(-3.1 + 1.05 * i as f32, 2.0, 0.0), far);
    }
    for (z, backward, color) in [(0.5, false, 0xd9622b), (-0.5, true, 0x9aa1ab)] {
        arm(world, Vec3::new(0.4, 2.1, z), backward, color);
    }
    tail(world, Vec3::new(1.7, 2.3, 0.0), cone.to_radians());
    rack(world);
}

/// The rack that everything hangs on: a bar on two posts, and a crossbar for the two arms.
fn rack(world: &mut World) {
    let (top, radius) = (2.43, 0.07);
    let along = Quat::from_rotation_z(0.5 * PI);
    let bars = [
        (Vec3::new(-0.95, top, 0.0), along, 4.9),
        (Vec3::new(0.4, top, 0.0), Quat::from_rotation_x(0.5 * PI), 1.26),
        (Vec3::new(-3.4, 0.5 * top, 0.0), Quat::IDENTITY, top),
        (Vec3::new(1.15, 0.5 * top, 0.0), Quat::IDENTITY, top),
    ];
    for (middle, turn, length) in bars {
        let bar = post(world, radius, length);
        let place = Transform::from_translation(middle).with_rotation(turn);
        world.spawn((InScene, bar, Look::color(0x4a4f57).roughness(0.6), place));
    }
}

fn body(world: &mut World, name: &'static str, at: Vec3, bones: Vec<Bone>, look: Look) {
    let place = Transform::from_translation(at);
    // So that they keep swinging, with as many sweeps as the recipe of articulated bodies sets.
    let (gradient_at, max_sweeps) = (Some(GradientAt::StepStart), Some(12));
    let solver = BodySolver { gradient_at, max_sweeps, ..default() };
    let bones = Articulated::new(bones);
    world.spawn((InScene, Name::new(name), bones, solver, look.roughness(0.5), Interpolate, place));
}

/// A pinned bone that carries the others.
fn held(head: Vec3, tail: Vec3, width: f32) -> Bone {
    Bone { width, pinned: true, ..Bone::new("held", head, tail) }
}

/// A flap that starts horizontal at its post and falls until it is `far` radians down.
fn flap(world: &mut World, at: Vec3, far: f32) {
    let hinge = BoneJoint::Hinge { axis: Vec3::Z, min: -far, max: 0.0 };
    let arm = Bone { width: 0.16, ..Bone::new("flap", Vec3::ZERO, Vec3::X * 0.7) }.on(0, hinge);
    let post = held(Vec3::ZERO, Vec3::Y * 0.3, 0.2);
    body(world, "signal", at, vec![post, arm], Look::color(0x3d7ea6));
    let (sin, cos) = libm::sincosf(-far);
    let mark = [0.1, 0.85].map(|out| {
        let place = at + Vec3::new(cos * out, sin * out, 0.12);
        world.spawn((InScene, Particle::at(place), Pinned::HERE)).id()
    });
    let mark = TubeMesh { particles: mark.to_vec(), radius: 0.022, sides: 8 };
    world.spawn((InScene, mark, Look::color(0xd1495b)));
}

/// A horizontal arm, hinged at its shoulder and its elbow; `backward` leaves the elbow without limits.
fn arm(world: &mut World, at: Vec3, backward: bool, color: u32) {
    let (elbow, hand) = (Vec3::X * 0.65, Vec3::X * 1.25);
    let free = BoneJoint::Hinge { axis: Vec3::Z, min: -PI, max: PI };
    // From straight, it bends by up to 150° upwards.
    let closes = BoneJoint::Hinge { axis: Vec3::Z, min: 0.0, max: 2.6 };
    let bones = vec![
        held(Vec3::ZERO, Vec3::Y * 0.25, 0.26),
        Bone { width: 0.2, ..Bone::new("upper arm", Vec3::ZERO, elbow).on(0, free) },
        Bone { width: 0.15, ..Bone::new("forearm", elbow, hand) }
            .on(1, if backward { free } else { closes }),
    ];
    body(world, if backward { "free arm" } else { "arm" }, at, bones, Look::color(color));
}

/// A tail of bones, each within a cone of this angle, radians, about the direction of the one before it, and the first about the direction of its root.
fn tail(world: &mut World, at: Vec3, cone: f32) {
    let long = 0.27;
    let joint = BoneJoint::Ball { cone, twist: 0.2 };
    let mut bones = vec![held(Vec3::X * -0.25, Vec3::ZERO, 0.26)];
    for i in 0..8 {
        let [head, tail] = [i, i + 1].map(|n| Vec3::X * (long * n as f32));
        let width = 0.22 - 0.016 * i as f32;
        bones.push(Bone { width, mass: 0.3, ..Bone::new("bone", head, tail).on(i, joint) });
    }
    body(world, "tail", at, bones, Look::color(0x66a182));
}
