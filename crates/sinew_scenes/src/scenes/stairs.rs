//! Ragdolls that fall down a flight of stairs.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::readings::{mean, strains_of};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "stairs",
    heading: Heading::Contacts,
    title: "Down the stairs",
    about: "ragdolls whose bones collide with the steps and with each other",
    eye: Vec3::new(4.4, 3.0, 6.4),
    target: Vec3::new(0.4, 1.0, 0.0),
    seconds: 5.0,
    moment: 1.5,
    lesson: Some(Lesson {
        try_this: "make the steps higher, smoother, or let the figures fall harder",
        watch: "whatever a figure hits on its way down, the blow travels through bones and joints, and no bone changes its length",
        formula: "|p_a − p_b| = L for every bone",
        sliders: &[
            SceneSlider { label: "Rise of a step", unit: "m", range: [0.16, 0.28], default: 0.24 },
            SceneSlider { label: "Friction", unit: "", range: [0.2, 1.0], default: 0.6 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [3.7, 15.0], default: 9.81 },
        ],
        number: "Mean error of the bones",
        unit: "%",
        after: 1.5,
        measure: |world| Some(mean(&strains_of(world, "ragdoll"))? * 100.0),
        expect: |_, _| 0.0,
        tolerance: [0.1, 0.0],
    }),
    spawn,
};

/// Number of steps, and their depth, metres.
const STEPS: u32 = 7;
const GOING: f32 = 0.42;

fn spawn(world: &mut World) {
    let [rise, friction, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    let surface = SurfaceMaterial::new(friction);
    world.insert_resource(AirDrag(0.2));
    world.spawn((InScene, Ground, surface));
    for n in 0..STEPS {
        let high = rise * (STEPS - n) as f32;
        let size = Vec3::new(GOING, high, 3.4);
        let place = Vec3::new(GOING * n as f32 - 1.6, 0.5 * high, 0.0);
        let step = mesh(world, rounded_box(size, 0.012, 2));
        let stone = Look::color(if n % 2 == 0 { 0x9a938a } else { 0xaaa39a }).roughness(0.8);
        let collider = (Collider::cuboid(size), surface);
        world.spawn((InScene, collider, step, stone, Transform::from_translation(place)));
    }
    for (n, color) in [0xd9622b, 0x2f8f83, 0xe0b040, 0x8e6bb0].into_iter().enumerate() {
        let along = n as f32;
        let place =
            Vec3::new(-1.5 + 0.5 * (n % 2) as f32, 2.1 + 1.2 * (n / 2) as f32, 1.1 - 0.75 * along);
        let rotation =
            Quat::from_rotation_y(0.5 * along) * Quat::from_rotation_z(-0.7 - 0.3 * along);
        world.spawn((
            InScene,
            Name::new("ragdoll"),
            Ragdoll::default(),
            Look::color(color).roughness(0.55),
            Interpolate,
            Transform::from_translation(place).with_rotation(rotation),
        ));
    }
}
