//! A ball, a cylinder and a frictionless block on one slope: rolling bodies are slower, depending on their moment of inertia.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Combine, SinewClock};

use crate::look::Look;
use crate::props::mesh;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "race",
    heading: Heading::Contacts,
    title: "A race downhill",
    about: "down one slope a frictionless block accelerates by g sin θ, a ball by 5/7 and a cylinder by 2/3 of that, whatever their mass: rotation takes energy",
    eye: Vec3::new(1.5, 3.2, 8.2),
    target: Vec3::new(0.2, 0.75, 0.0),
    seconds: 5.0,
    moment: 1.25,
    lesson: Some(Lesson {
        try_this: "change the angle, the density or the radius: only the angle changes the speeds",
        watch: "the frictionless block leads, the ball follows, the cylinder is last: the farther the mass is from the axis, the slower",
        formula: "a = g sin θ / (1 + I/mr²): 1, 5/7 and 2/3 of g sin θ for block, ball, cylinder",
        sliders: &[
            SceneSlider { label: "Angle", unit: "°", range: [6.0, 16.0], default: 11.5 },
            SceneSlider {
                label: "Density", unit: "kg/m³", range: [100.0, 2000.0], default: 600.0
            },
            SceneSlider { label: "Radius", unit: "m", range: [0.15, 0.35], default: 0.3 },
        ],
        number: "Acceleration of the cylinder",
        unit: "m/s²",
        after: 1.0,
        measure: |world| {
            let seconds = world.resource::<SinewClock>().seconds;
            let velocity: LinearVelocity = component_of(world, "cylinder")?;
            (seconds > 0.0).then(|| f64::from(velocity.0.length()) / seconds)
        },
        expect: |values, _| 2.0 / 3.0 * 9.81 * libm::sin(f64::from(values[0]).to_radians()),
        tolerance: [0.02, 0.02],
    }),
    spawn,
};

/// Size of the slope's board, metres.
const BOARD: Vec3 = Vec3::new(7.0, 0.12, 3.6);

fn spawn(world: &mut World) {
    let [degrees, density, radius] = values(world);
    // The formula ignores air resistance.
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground));
    let turn = Quat::from_rotation_z(-degrees.to_radians());
    // High enough that the lower edge clears the ground at the steepest angle.
    let middle = Vec3::Y * (0.2 + 0.5 * BOARD.x * libm::sinf(degrees.to_radians()));
    let board = (Collider::cuboid(BOARD), mesh(world, rounded_box(BOARD, 0.02, 2)));
    let place = Transform::from_translation(middle).with_rotation(turn);
    let wood = Look::color(0x8a6a4b).roughness(0.9);
    world.spawn((InScene, Name::new("slope"), board, wood, SurfaceMaterial::new(0.5), place));
    for side in [-1.0, 1.0] {
        let size = Vec3::new(0.12, 0.3, BOARD.z);
        let top = place.transform_point(Vec3::new(side * 0.46 * BOARD.x, -0.5 * BOARD.y, 0.0));
        let size = size.with_y(top.y);
        let post = (Collider::cuboid(size), mesh(world, rounded_box(size, 0.02, 2)));
        let at = Transform::from_translation(top.with_y(0.5 * top.y));
        world.spawn((InScene, post, Look::color(0x6d5138).roughness(0.9), at));
    }
    let start = |z: f32, up: f32| middle + turn * Vec3::new(-0.42 * BOARD.x, 0.5 * BOARD.y + up, z);
    let sphere = RigidShape::Sphere { radius };
    let drum = RigidShape::Cylinder { radius, height: 0.6 };
    let lies = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let racers = [
        ("ball", sphere, ball(radius), Quat::IDENTITY, 0.0, 0xc0604d),
        ("cylinder", drum, cylinder(radius, 0.6), lies, 1.15, 0x4f7cac),
    ];
    for (name, shape, skin, turned, z, color) in racers {
        let skin = mesh(world, skin);
        world.spawn((
            InScene,
            Name::new(name),
            RigidMesh::density(density).shaped(shape),
            SurfaceMaterial::new(0.5),
            skin,
            Look::color(color).roughness(0.35),
            Interpolate,
            Transform::from_translation(start(z, radius)).with_rotation(turned),
        ));
    }
    // With this combination rule the friction of a contact is the product, so that it is 0.
    let ice = SurfaceMaterial { friction_rule: Combine::Multiply, ..SurfaceMaterial::new(0.0) };
    let size = Vec3::new(0.6, 0.4, 0.6);
    let skin = mesh(world, rounded_box(size, 0.03, 3));
    world.spawn((
        InScene,
        Name::new("block on ice"),
        RigidBox::new(size).with_mass(50.0),
        ice,
        skin,
        Look::color(0xbfd8e2).roughness(0.1),
        Interpolate,
        Transform::from_translation(start(-1.15, 0.5 * size.y)).with_rotation(turn),
    ));
}
