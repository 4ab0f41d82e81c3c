//! Stacks of plates on three slopes, two of which are below the friction angle.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::nth_component_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "slopes",
    heading: Heading::Contacts,
    title: "Friction holds or slides",
    about: "stacks on slopes of 10°, 20° and 30°: with friction 0.5 everything less steep than 26.6° holds, without creeping by a tenth of a millimetre",
    eye: Vec3::new(0.9, 1.9, 6.4),
    target: Vec3::new(0.5, 0.7, 0.0),
    seconds: 5.0,
    moment: 1.1,
    lesson: Some(Lesson {
        try_this: "tilt the slope in the middle towards 26°, or take friction away from it: as long as tan θ is less than μ the stack stays where it is",
        watch: "a stack that holds does not creep, not by a tenth of a millimetre; mass is on both sides and cancels; the red stack is past the limit and slides",
        formula: "a = g (sin θ − μ cos θ), and 0 while tan θ ≤ μ",
        sliders: &[
            SceneSlider { label: "Angle", unit: "°", range: [5.0, 25.5], default: 20.0 },
            SceneSlider { label: "Friction", unit: "", range: [0.38, 0.9], default: 0.5 },
            SceneSlider { label: "Mass of a plate", unit: "kg", range: [0.5, 20.0], default: 2.0 },
        ],
        number: "Displacement of the lowest plate",
        unit: "mm",
        after: 2.0,
        measure: |world| {
            let [degrees, ..]: [f32; 3] = values(world);
            let plate: Transform = nth_component_of(world, "plate", PLATES as usize)?;
            let way = (plate.translation - MIDDLE).dot(tilted(degrees) * Vec3::X) - START;
            Some(f64::from(way) * 1e3)
        },
        expect: |_, _| 0.0,
        tolerance: [0.1, 0.0],
    }),
    spawn,
};

/// Sizes of a slope and of a plate, metres, and number of plates in a stack.
const SLOPE: Vec3 = Vec3::new(1.7, 0.12, 1.1);
const PLATE: Vec3 = Vec3::new(0.62, 0.12, 0.62);
const PLATES: u32 = 6;
/// Centre of the second slope, and where its stack starts along it, metres.
const MIDDLE: Vec3 = Vec3::new(0.0, 0.62, 0.0);
const START: f32 = -0.35;

/// Rotation of a slope, from its angle in degrees.
fn tilted(degrees: f32) -> Quat {
    Quat::from_rotation_z(-degrees.to_radians())
}

fn spawn(world: &mut World) {
    let [degrees, friction, mass] = values(world);
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    let board = mesh(world, rounded_box(SLOPE, 0.015, 2));
    let skin = mesh(world, rounded_box(PLATE, 0.012, 2));
    let slopes = [
        (-2.2, 10.0, 0.5, 2.0, 0x7a9e7e),
        (MIDDLE.x, degrees, friction, mass, 0xd9b26a),
        (2.2, 30.0, 0.5, 2.0, 0xc0604d),
    ];
    for (x, degrees, friction, mass, color) in slopes {
        let turned = tilted(degrees);
        let middle = MIDDLE.with_x(x);
        let place = Transform::from_translation(middle).with_rotation(turned);
        let slope = (Collider::cuboid(SLOPE), SurfaceMaterial::new(friction));
        let wood = Look::color(0x8a6a4b).roughness(0.9);
        world.spawn((InScene, Name::new("slope"), slope, board.clone(), wood, place));
        posts(world, place);
        for n in 0..PLATES {
            let up = 0.5 * (SLOPE.y + PLATE.y) + PLATE.y * n as f32;
            let at = middle + turned * Vec3::new(START, up, 0.0);
            world.spawn((
                InScene,
                Name::new("plate"),
                RigidBox::new(PLATE).with_mass(mass),
                SurfaceMaterial::new(friction),
                skin.clone(),
                Look::color(color).roughness(0.7),
                Interpolate,
                Transform::from_translation(at).with_rotation(turned),
            ));
        }
    }
}

/// Four posts beneath a board.
fn posts(world: &mut World, board: Transform) {
    for (i, j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let corner = Vec3::new(0.42 * i * SLOPE.x, -0.45 * SLOPE.y, 0.4 * j * SLOPE.z);
        let top = board.transform_point(corner);
        let post = post(world, 0.03, top.y);
        let middle = Transform::from_translation(top.with_y(0.5 * top.y));
        world.spawn((InScene, post, Look::color(0x6d5138).roughness(0.9), middle));
    }
}
