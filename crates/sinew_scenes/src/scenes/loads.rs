//! The same load on a rod, on a spring and on a compliant rod: the hard rod does not sag, the other two sag by weight over stiffness.

use bevy::prelude::*;
use bevy_sinew::TubeMesh;
use bevy_sinew::prelude::*;
use bevy_sinew::{ConstraintOf, ParticleBody, ParticleOf};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "loads",
    heading: Heading::Constraints,
    title: "Rod, spring, compliant rod",
    about: "one load on a hard rod, on a spring and on a compliant rod: the rod keeps its length, the other two sag by m g/k, to the red mark",
    eye: Vec3::new(0.5, 1.7, 4.4),
    target: Vec3::new(0.0, 1.2, 0.0),
    seconds: 5.0,
    moment: 3.0,
    lesson: Some(Lesson {
        try_this: "raise the mass: the spring and the compliant rod sag further, the rod does not",
        watch: "the balls come to rest on the red mark; a compliance α = 1/k acts as a spring of stiffness k and is stable at any step",
        formula: "sag = m g / k = m g α",
        sliders: &[
            SceneSlider { label: "Mass", unit: "kg", range: [0.5, 3.0], default: 2.0 },
            SceneSlider { label: "Stiffness", unit: "N/m", range: [100.0, 600.0], default: 100.0 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [1.6, 9.81], default: 9.81 },
        ],
        number: "Sag of the compliant rod",
        unit: "mm",
        after: 4.0,
        measure: |world| {
            let bob: Particle = component_of(world, "compliant rod")?;
            Some(f64::from(HANG - LENGTH - bob.position.y) * 1e3)
        },
        expect: |values, _| sag(values[0], values[1], values[2]) * 1e3,
        tolerance: [0.5, 0.01],
    }),
    spawn,
};

/// Height of the beam, and length of the rods and the spring, metres.
const HANG: f32 = 2.0;
const LENGTH: f32 = 0.8;
/// Radius of a load, metres.
const RADIUS: f32 = 0.13;

fn sag(mass: f32, stiffness: f32, gravity: f32) -> f64 {
    f64::from(mass) * f64::from(gravity) / f64::from(stiffness)
}

fn spawn(world: &mut World) {
    let [mass, stiffness, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    // Strong drag, so that everything comes to rest in a few seconds.
    world.insert_resource(AirDrag(0.99));
    world.spawn((InScene, Ground));
    let wood = Look::color(0x8a6a4b).roughness(0.9);
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    let beam = post(world, 0.05, 2.6);
    let over = Transform::from_xyz(0.0, HANG + 0.05, 0.0).with_rotation(lying);
    world.spawn((InScene, beam, wood.clone(), over));
    for x in [-1.25, 1.25] {
        let leg = post(world, 0.06, HANG + 0.1);
        world.spawn((InScene, leg, wood.clone(), Transform::from_xyz(x, 0.5 * HANG + 0.05, 0.0)));
    }
    // The heights at which the loads come to rest by the formula, drawn behind their centres.
    let rest = HANG - LENGTH - sag(mass, stiffness, gravity) as f32;
    for (height, from, to, color) in
        [(rest, -0.25, 1.05, 0xd0342c), (HANG - LENGTH, -1.05, 1.05, 0x5b6470)]
    {
        let mark = mesh(world, Cuboid::new(to - from, 0.012, 0.012));
        let at = Transform::from_xyz(0.5 * (from + to), height, -RADIUS - 0.02);
        world.spawn((InScene, mark, Look::color(color), at));
    }
    let skin = mesh(world, ball(RADIUS));
    let kinds = [
        ("rod", -0.75, 0x4f6d8f, 0.022),
        ("spring", 0.0, 0xe9a23b, 0.03),
        ("compliant rod", 0.75, 0x5f9e6e, 0.022),
    ];
    for (name, x, color, thick) in kinds {
        let hook = Vec3::new(x, HANG, 0.0);
        let look = Look::color(color).roughness(0.4);
        let body = world.spawn((InScene, ParticleBody, look.clone(), Interpolate)).id();
        let anchor = world.spawn((Particle::at(hook), Pinned::HERE, ParticleOf(body))).id();
        let bob = world
            .spawn((
                Name::new(name),
                Particle::at(hook - Vec3::Y * LENGTH),
                Mass(mass),
                Radius(RADIUS),
                ParticleOf(body),
                Transform::default(),
                skin.clone(),
                look,
            ))
            .id();
        let rod = DistanceConstraint::new(anchor, bob, LENGTH);
        match name {
            "rod" => world.spawn((rod, ConstraintOf(body))),
            "spring" => {
                world.spawn((Spring::new(anchor, bob, LENGTH, stiffness), ConstraintOf(body)))
            }
            _ => world.spawn((rod.with_compliance(1.0 / stiffness), ConstraintOf(body))),
        };
        let line = TubeMesh { particles: vec![anchor, bob], radius: thick, sides: 8 };
        world.entity_mut(body).insert(line);
    }
}
