//! The same angular impulse on three bricks: particles at the corners, particles with the inertia of the solid brick, and an explicit rigid body.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BoxParticles, Representation, RigidIntegrator};

use crate::look::Look;
use crate::props::{floor, mesh};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "inertia",
    heading: Heading::Bodies,
    title: "Corners against equimomental particles",
    about: "one blow: with particles at its corners (orange) a brick spins a third as fast as the solid (blue, green)",
    eye: Vec3::new(0.0, 1.7, 6.3),
    target: Vec3::new(0.0, 1.3, 0.0),
    seconds: 4.0,
    moment: 1.2,
    lesson: Some(Lesson {
        try_this: "hit harder, make the bricks heavier or wider: orange always has three times the moment of inertia",
        watch: "the small balls mark the particles: particles further out are harder to turn; blue and green stay in step",
        formula: "ω = L/I, with I = m (a² + b²)/12 for the solid brick and m (a² + b²)/4 for its corners",
        sliders: &[
            SceneSlider { label: "Blow", unit: "N·m·s", range: [0.5, 3.0], default: 1.5 },
            SceneSlider { label: "Mass", unit: "kg", range: [1.0, 8.0], default: 4.0 },
            SceneSlider { label: "Width", unit: "m", range: [0.6, 1.4], default: 1.2 },
        ],
        number: "Spin of the blue brick",
        unit: "rad/s",
        after: 1.5,
        measure: |world| {
            let spin: AngularVelocity = component_of(world, "equimomental")?;
            Some(f64::from(spin.0.z))
        },
        expect: |values, _| {
            let [blow, mass, width] = [values[0], values[1], values[2]].map(f64::from);
            let high = f64::from(SIZE.y);
            12.0 * blow / (mass * (width * width + high * high))
        },
        tolerance: [0.0, 5e-3],
    }),
    spawn,
};

/// Size of a brick, metres; a slider sets its width.
const SIZE: Vec3 = Vec3::new(1.2, 0.7, 0.45);

fn spawn(world: &mut World) {
    let [blow, mass, width] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    floor(world, Vec2::new(6.4, 2.6), Look::color(0x34384a).roughness(0.6));
    let size = SIZE.with_x(width);
    let skin = mesh(world, rounded_box(size, 0.03, 3));
    let axle = mesh(world, cylinder(0.035, 1.3));
    let knob = mesh(world, ball(0.055));
    let along = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let steel = Look::color(0xb9bec6).metal();
    let bricks = [
        ("corners", -1.85, BoxParticles::Corners, Representation::Particles, 0xd9622b),
        ("equimomental", 0.0, BoxParticles::Equimomental, Representation::Particles, 0x3d7ea6),
        (
            "rigid body",
            1.85,
            BoxParticles::Equimomental,
            Representation::Rigid(RigidIntegrator::default()),
            0x66a182,
        ),
    ];
    for (name, x, particles, representation, color) in bricks {
        let at = Vec3::new(x, 1.3, 0.0);
        let brick = world
            .spawn((
                InScene,
                Name::new(name),
                RigidBox { particles, ..RigidBox::new(size).with_mass(mass) },
                representation,
                skin.clone(),
                Look::color(color).roughness(0.5),
                Interpolate,
                Transform::from_translation(at),
            ))
            .apply_angular_impulse(Vec3::Z * blow)
            .id();
        // Where the particles are, on the face towards the camera.
        let share = if particles == BoxParticles::Corners { 1.0 } else { 1.0 / 3.0_f32.sqrt() };
        for (right, up) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let out = 0.5 * share * Vec3::new(right * size.x, up * size.y, 0.0);
            let on = Transform::from_translation(out.with_z(0.5 * size.z));
            world.spawn((ChildOf(brick), knob.clone(), Look::color(0xf3e9d2), on));
        }
        // An axle behind it. It is only drawn and holds nothing.
        let behind = Transform::from_translation(at - Vec3::Z * 0.9).with_rotation(along);
        world.spawn((InScene, axle.clone(), steel.clone(), behind));
    }
    let wall = mesh(world, rounded_box(Vec3::new(6.4, 2.6, 0.1), 0.02, 2));
    let at = Transform::from_xyz(0.0, 1.3, -1.25);
    world.spawn((InScene, wall, Look::color(0x525873).roughness(0.9), at));
}
