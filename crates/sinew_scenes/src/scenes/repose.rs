//! Blocks with three coefficients of friction on one slope: the angle of repose, and the acceleration of a sliding block.

use bevy::prelude::*;
use bevy_sinew::Combine;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "repose",
    heading: Heading::Contacts,
    title: "The angle of repose",
    about: "three blocks on one slope: without friction, with some, and with more than tan θ, which stays where it is",
    eye: Vec3::new(1.2, 2.6, 5.6),
    target: Vec3::new(0.0, 0.8, 0.0),
    seconds: 3.0,
    moment: 1.0,
    lesson: Some(Lesson {
        try_this: "raise the friction of the block in the middle towards tan θ: it slides slower; change its mass: it slides as before",
        watch: "the red block has more friction than tan θ and holds; mass is on both sides of the formula and drops out",
        formula: "a = g (sin θ − μ cos θ); nothing slides while μ ≥ tan θ",
        sliders: &[
            SceneSlider { label: "Angle", unit: "°", range: [18.0, 32.0], default: 24.0 },
            SceneSlider { label: "Friction", unit: "", range: [0.0, 0.25], default: 0.2 },
            SceneSlider { label: "Mass", unit: "kg", range: [1.0, 50.0], default: 5.0 },
        ],
        number: "Acceleration of the middle block",
        unit: "m/s²",
        after: 0.8,
        measure: |world| {
            let seconds = world.resource::<bevy_sinew::SinewClock>().seconds;
            let velocity: LinearVelocity = component_of(world, "sliding block")?;
            (seconds > 0.0).then(|| f64::from(velocity.0.length()) / seconds)
        },
        expect: |values, _| {
            let (sin, cos) = libm::sincos(f64::from(values[0]).to_radians());
            9.81 * (sin - f64::from(values[1]) * cos)
        },
        tolerance: [0.03, 0.02],
    }),
    spawn,
};

/// Sizes of the board and of a block, metres.
const BOARD: Vec3 = Vec3::new(4.6, 0.12, 2.6);
const BLOCK: Vec3 = Vec3::new(0.5, 0.3, 0.5);

fn spawn(world: &mut World) {
    let [degrees, friction, mass] = values(world);
    // The formula ignores air resistance.
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground));
    let turn = Quat::from_rotation_z(-degrees.to_radians());
    let (sin, cos) = libm::sincosf(degrees.to_radians());
    // Its lower edge is a little above the ground.
    let middle = Vec3::Y * (0.5 * BOARD.x * sin + 0.5 * BOARD.y * cos + 0.02);
    let board = (Collider::cuboid(BOARD), mesh(world, rounded_box(BOARD, 0.02, 2)));
    let place = Transform::from_translation(middle).with_rotation(turn);
    let wood = Look::color(0x8a6a4b).roughness(0.9);
    world.spawn((InScene, Name::new("slope"), board, wood, SurfaceMaterial::new(1.0), place));
    let skin = mesh(world, rounded_box(BLOCK, 0.02, 3));
    // More than the slope requires, however steep it is.
    let holds = 1.2 * libm::tanf(degrees.to_radians());
    let blocks = [
        ("block on ice", 0.0, -0.85, 0xbfd8e2, 0.1),
        ("sliding block", friction, 0.0, 0xe9a23b, 0.6),
        ("holding block", holds, 0.85, 0xb5483a, 0.9),
    ];
    for (name, friction, z, color, rough) in blocks {
        // The slope has friction 1, so that the product is the friction of the block.
        let surface =
            SurfaceMaterial { friction_rule: Combine::Multiply, ..SurfaceMaterial::new(friction) };
        let at = Vec3::new(-0.36 * BOARD.x, 0.5 * (BOARD.y + BLOCK.y), z);
        world.spawn((
            InScene,
            Name::new(name),
            RigidBox::new(BLOCK).with_mass(mass),
            surface,
            skin.clone(),
            Look::color(color).roughness(rough),
            Interpolate,
            Transform::from_translation(middle + turn * at).with_rotation(turn),
        ));
    }
}
