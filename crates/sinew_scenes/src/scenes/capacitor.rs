//! A charged pendulum between the plates of a capacitor: its string comes to rest along the sum of weight and electric force.

use bevy::prelude::*;
use bevy_sinew::TubeMesh;
use bevy_sinew::prelude::*;
use bevy_sinew::{Charge, ConstraintOf, ElectricField, ParticleBody, ParticleOf, Region};

use crate::arrow::Arrow;
use crate::look::Look;
use crate::props::{mesh, post};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "capacitor",
    heading: Heading::Forces,
    title: "A pendulum in a capacitor",
    about: "a charged ball between two plates: its string comes to rest along the red line, the sum (red) of its weight (yellow) and the electric force (blue)",
    eye: Vec3::new(0.8, 1.7, 4.2),
    target: Vec3::new(0.0, 1.1, 0.0),
    seconds: 5.0,
    moment: 3.5,
    lesson: Some(Lesson {
        try_this: "turn up the field or the charge: the string leans further; turn up the mass: it leans less",
        watch: "forces add up: the red arrow is the sum of the other two, and the string rests along it, where the red line is; the grey ball without charge hangs straight down",
        formula: "tan φ = q E / (m g)",
        sliders: &[
            SceneSlider { label: "Field", unit: "kN/C", range: [20.0, 200.0], default: 150.0 },
            SceneSlider { label: "Charge", unit: "µC", range: [0.5, 2.0], default: 1.5 },
            SceneSlider { label: "Mass", unit: "g", range: [40.0, 200.0], default: 50.0 },
        ],
        number: "Angle of the string",
        unit: "°",
        after: 5.0,
        measure: |world| {
            let bob: Particle = component_of(world, "charged ball")?;
            let hook = hook();
            let (across, down) = (bob.position.x - hook.x, hook.y - bob.position.y);
            Some(libm::atan2(f64::from(across), f64::from(down)).to_degrees())
        },
        expect: |values, _| lean(values[0], values[1], values[2]).to_degrees(),
        tolerance: [0.1, 0.01],
    }),
    spawn,
};

/// Height of the hook, length of the string and half the distance of the plates, metres.
const HANG: f32 = 1.9;
const LENGTH: f32 = 0.95;
const GAP: f32 = 0.95;
/// Radius of the balls, metres.
const RADIUS: f32 = 0.07;
/// Length of the arrow for the total force, metres.
const SUM: f32 = 0.55;
/// Offset of the uncharged ball along z, metres.
const BEHIND: f32 = -0.3;

/// Arrows for the forces on a ball: its weight, the electric force, and their sum.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct ForceArrows {
    /// The electric force, N.
    electric: Vec3,
    arrows: [Arrow; 3],
}

/// Draws the forces, scaled so that the arrow of the sum has a fixed length.
pub(crate) fn draw_forces(
    gravity: Res<Gravity>,
    balls: Query<(&ForceArrows, &Particle, &Mass)>,
    mut drawn: Query<&mut Transform>,
) {
    for (forces, ball, mass) in &balls {
        let weight = gravity.0 * mass.0;
        let sum = weight + forces.electric;
        let scale = SUM / sum.length().max(1e-6);
        let from = ball.position + Vec3::Z * (RADIUS + 0.02);
        for (arrow, force) in forces.arrows.iter().zip([weight, forces.electric, sum]) {
            arrow.point(&mut drawn, Some([from, from + force * scale]));
        }
    }
}

fn hook() -> Vec3 {
    Vec3::Y * HANG
}

/// Angle of the string from the vertical, radians, from kN/C, µC and g.
fn lean(field: f32, charge: f32, mass: f32) -> f64 {
    // kN/C · µC is mN, and g · m/s² is mN.
    libm::atan2(f64::from(field) * f64::from(charge), f64::from(mass) * 9.81)
}

fn spawn(world: &mut World) {
    let [field, charge, mass] = values(world);
    // Strong drag, so that it comes to rest in a few seconds.
    world.insert_resource(AirDrag(0.95));
    world.spawn((InScene, Ground));
    world.spawn((
        InScene,
        Name::new("field"),
        ElectricField::new(Vec3::X * field * 1e3),
        Region::boxed(Vec3::new(2.0 * GAP, 1.8, 1.4)),
        Transform::from_xyz(0.0, 1.2, 0.0),
    ));
    let size = Vec3::new(0.05, 1.5, 1.2);
    let plate = (Collider::cuboid(size), mesh(world, rounded_box(size, 0.015, 2)));
    for (side, color) in [(-1.0, 0xd1495b), (1.0, 0x2e86ab)] {
        let at = Transform::from_xyz(side * (GAP + 0.1), 1.05, 0.0);
        world.spawn((InScene, plate.clone(), Look::color(color).roughness(0.3), at));
        let foot = post(world, 0.04, 0.3);
        let at = Transform::from_xyz(side * (GAP + 0.1), 0.15, 0.0);
        world.spawn((InScene, foot, Look::color(0x6c757d).metal(), at));
    }
    // The beam is above everything that swings.
    let lying = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let beam = post(world, 0.03, 1.0);
    let metal = Look::color(0x6c757d).metal();
    let at = Transform::from_xyz(0.0, HANG + 0.03, BEHIND).with_rotation(lying);
    world.spawn((InScene, beam, metal.clone(), at));
    let leg = post(world, 0.04, HANG + 0.06);
    world.spawn((InScene, leg, metal, Transform::from_xyz(0.0, 0.5 * HANG + 0.03, -0.8)));
    // The rest position of the string by the formula.
    let angle = lean(field, charge, mass) as f32;
    let (sin, cos) = libm::sincosf(angle);
    let along = Vec3::new(sin, -cos, 0.0);
    let line = mesh(world, Cuboid::new(0.01, LENGTH + 0.25, 0.01));
    let at = hook() + along * (0.5 * (LENGTH + 0.25)) - Vec3::Z * (RADIUS + 0.01);
    let at = Transform::from_translation(at).with_rotation(Quat::from_rotation_z(angle));
    world.spawn((InScene, line, Look::color(0xd0342c), at));
    let skin = mesh(world, ball(RADIUS));
    let balls = [
        ("charged ball", Vec3::ZERO, charge * 1e-6, 0xd1495b),
        ("ball without charge", Vec3::Z * BEHIND, 0.0, 0x9aa4ad),
    ];
    for (name, beside, charge, color) in balls {
        let top = hook() + beside;
        let look = Look::color(color).roughness(0.3);
        let body = world.spawn((InScene, ParticleBody, look.clone(), Interpolate)).id();
        let end = world.spawn((Particle::at(top), Pinned::HERE, ParticleOf(body))).id();
        let bob = world
            .spawn((
                Name::new(name),
                Particle::at(top - Vec3::Y * LENGTH),
                Mass(mass * 1e-3),
                Charge(charge),
                Radius(RADIUS),
                ParticleOf(body),
                Transform::default(),
                skin.clone(),
                look,
            ))
            .id();
        world.spawn((DistanceConstraint::new(end, bob, LENGTH), ConstraintOf(body)));
        if charge > 0.0 {
            let arrows = [0xe9b44c, 0x2e86ab, 0xd0342c]
                .map(|color| Arrow::spawn(world, 0.012, Look::color(color).roughness(0.5)));
            // kN/C times C.
            let electric = Vec3::X * (field * 1e3 * charge);
            world.entity_mut(bob).insert(ForceArrows { electric, arrows });
        }
        let string = TubeMesh { particles: vec![end, bob], radius: 0.008, sides: 6 };
        world.entity_mut(body).insert(string);
    }
}
