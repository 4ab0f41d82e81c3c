//! Ragdolls that collapse, in different poses.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::readings::{is_in_flight, thrown};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};

pub(super) const SCENE: Scene = Scene {
    name: "ragdoll",
    heading: Heading::Bodies,
    title: "Ragdolls",
    about: "limp figures of 22 particles, 33 bones, 20 struts and 22 angle limits each collapse on the floor",
    eye: Vec3::new(0.9, 1.9, 6.4),
    target: Vec3::new(0.0, 0.9, -0.3),
    seconds: 5.0,
    moment: 0.5,
    lesson: Some(Lesson {
        try_this: "throw the yellow figure up faster, or with more spin, or under the gravity of another planet",
        watch: "bones, struts and joints pull in pairs that sum to zero: limbs fly about, and the barycentre falls like a stone until the figure lands",
        formula: "v = (v₀ + g/c) e^(−c t) − g/c, with e^(−c) = 1 − drag",
        sliders: &[
            SceneSlider { label: "Thrown up at", unit: "m/s", range: [0.0, 4.0], default: 1.5 },
            SceneSlider { label: "Spin", unit: "rad/s", range: [0.0, 6.0], default: 1.0 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [1.6, 9.81], default: 9.81 },
        ],
        number: "Upward velocity of the barycentre",
        unit: "m/s",
        after: 0.4,
        measure: |world| {
            let velocity: LinearVelocity = component_of(world, "yellow figure")?;
            is_in_flight(world, "yellow figure").then_some(f64::from(velocity.0.y))
        },
        expect: |values, seconds| {
            thrown(f64::from(values[0]), f64::from(values[2]), f64::from(DRAG), seconds)
        },
        tolerance: [0.02, 0.005],
    }),
    spawn,
};

/// Fraction of the velocity that air drag takes in a second.
const DRAG: f32 = 0.2;

fn spawn(world: &mut World) {
    let [speed, spin, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(DRAG));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let figures = [
        ("ragdoll", Vec3::new(0.0, 0.02, 0.0), 0.0, 0.0, 0xd9622b),
        ("ragdoll", Vec3::new(-1.6, 0.9, -0.6), 0.8, 0.5, 0x2f8f83),
        ("yellow figure", Vec3::new(1.6, 1.3, -0.8), -0.9, -1.1, 0xe0b040),
    ];
    for (name, place, yaw, roll, color) in figures {
        let rotation = Quat::from_rotation_y(yaw) * Quat::from_rotation_z(roll);
        let mut figure = world.spawn((
            InScene,
            Name::new(name),
            Ragdoll::default(),
            Look::color(color).roughness(0.55),
            Interpolate,
            Transform::from_translation(place).with_rotation(rotation),
        ));
        if name == "yellow figure" {
            figure.set_motion(Vec3::Y * speed, Vec3::new(0.6, 0.0, 0.8) * spin);
        }
    }
}
