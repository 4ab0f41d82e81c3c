//! A 2D box of 4 particles and 6 distances that falls in a plane.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{curve, mesh};
use crate::readings::is_in_flight;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "square",
    heading: Heading::Bodies,
    title: "A 2D box of four particles",
    about: "4 particles and 6 distances in a plane: pushed at a corner, or landing on one, it starts to turn by itself",
    eye: Vec3::new(0.8, 2.3, 6.6),
    target: Vec3::new(0.0, 1.6, 0.0),
    seconds: 5.0,
    moment: 0.5,
    lesson: Some(Lesson {
        try_this: "push the blue square harder at its corner, where the red stick is, or make it lighter or smaller",
        watch: "no particle stores a rotation: one corner is pushed, six distances pass that on to the others, and the square turns as if it had a moment of inertia",
        formula: "ω = x J / I, with I = Σ m r² = m a² / 2, until it lands",
        sliders: &[
            SceneSlider { label: "Impulse", unit: "N s", range: [0.0, 6.0], default: 3.0 },
            SceneSlider { label: "Mass", unit: "kg", range: [1.0, 5.0], default: 2.0 },
            SceneSlider { label: "Edge", unit: "m", range: [0.6, 1.2], default: 1.0 },
        ],
        number: "Angular velocity",
        unit: "rad/s",
        after: 0.5,
        measure: |world| {
            let spin: AngularVelocity = component_of(world, "blue square")?;
            is_in_flight(world, "blue square").then_some(f64::from(spin.0.z))
        },
        expect: |values, _| {
            let [impulse, mass, edge] = [values[0], values[1], values[2]].map(f64::from);
            f64::from(pushed(values[2]).x) * impulse / (0.5 * mass * edge * edge)
        },
        tolerance: [0.005, 0.005],
    }),
    spawn,
};

/// Rotation of the blue square, radians.
const TURN: f32 = 0.62;
/// Height of its centre, metres.
const HIGH: f32 = 3.3;

/// Offset from the centre of the blue square to the corner that is pushed, metres.
fn pushed(edge: f32) -> Vec3 {
    Quat::from_rotation_z(TURN) * Vec3::new(0.5 * edge, -0.5 * edge, 0.0)
}

fn spawn(world: &mut World) {
    let [impulse, mass, edge] = values(world);
    // The formula ignores air resistance.
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let squares = [
        ("square", -2.5, 2.6, 0.35, 2.0, 1.0, 0xe07a5f),
        ("blue square", 0.0, HIGH, TURN, mass, edge, 0x3d7ea6),
        ("square", 2.5, 2.2, 1.2, 2.0, 1.0, 0xe9b44c),
    ];
    for (name, x, y, turn, mass, edge, color) in squares {
        let size = Vec3::new(edge, edge, 0.16);
        let skin = mesh(world, rounded_box(size, 0.03, 3));
        let mut falls = world.spawn((
            InScene,
            Name::new(name),
            RigidBox { flat: true, ..RigidBox::new(size).with_mass(mass) },
            skin,
            Look::color(color).roughness(0.5),
            Interpolate,
            Transform::from_xyz(x, y, 0.0).with_rotation(Quat::from_rotation_z(turn)),
        ));
        if name == "blue square" {
            let push = ExternalImpulse::new(Vec3::Y * impulse);
            falls.insert(push.at(Vec3::Y * HIGH + pushed(edge)));
        }
    }
    // Where and how hard it is pushed: 15 cm for each newton second.
    let corner = Vec3::new(0.0, HIGH, 0.1) + pushed(edge);
    let stick = [corner - Vec3::Y * (0.15 * impulse).max(0.01), corner];
    curve(world, &stick, 0.015, Look::color(0xd0342c));
}
