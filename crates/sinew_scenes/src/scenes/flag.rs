//! A flag on a pole: grid cloth, pinned along one edge, in a gusty wind.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::{mean, strains_of};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "flag",
    heading: Heading::Forces,
    title: "A flag in the wind",
    about: "1 500 particles of cotton, pinned along one edge; a fresh breeze presses on every triangle",
    eye: Vec3::new(1.9, 2.5, 4.6),
    target: Vec3::new(0.75, 2.05, 0.0),
    seconds: 6.0,
    moment: 3.2,
    lesson: Some(Lesson {
        try_this: "turn up the wind and its gusts, or use heavier cotton: it flies higher or hangs lower, at the same length",
        watch: "cotton threads do not stretch: whatever pulls at the flag, its 48 cells from pole to end keep their length",
        formula: "p = ½ ρ v² on every triangle; |p_a − p_b| = L for every thread",
        sliders: &[
            SceneSlider { label: "Wind", unit: "m/s", range: [3.0, 6.0], default: 4.7 },
            SceneSlider { label: "Gusts", unit: "", range: [0.0, 0.8], default: 0.55 },
            SceneSlider { label: "Density", unit: "kg/m²", range: [0.12, 0.4], default: 0.18 },
        ],
        number: "Mean stretch of the threads",
        unit: "%",
        after: 1.5,
        measure: |world| Some(mean(&strains_of(world, "flag"))? * 100.0),
        expect: |_, _| 0.0,
        tolerance: [0.3, 0.0],
    }),
    spawn,
};

/// Width and height of the flag, metres: the proportions of its texture.
const SIZE: Vec2 = Vec2::new(1.92, 1.2);
/// Direction of the wind, and density of air, kg/m³.
const WIND_DIRECTION: Vec3 = Vec3::new(13.0, 0.0, 3.5);
const AIR: f32 = 1.225;

fn spawn(world: &mut World) {
    let [speed, gusts, density] = values(world);
    // This pressure does not depend on the velocity of the cloth, so air drag has to damp its motion.
    let pressure = WIND_DIRECTION * (0.5 * AIR * speed * speed / WIND_DIRECTION.length());
    world.spawn((
        InScene,
        Name::new("breeze"),
        Wind { pressure, gusts, gust_length: 1.1, gust_period: 0.9 },
    ));
    world.insert_resource(AirDrag(0.75));
    world.spawn((InScene, Ground));
    world.spawn((
        InScene,
        Name::new("flag"),
        Cloth { density, ..Cloth::grid(SIZE.x, SIZE.y, 48, 30) }.pinned(ClothPins::LeftEdge),
        Look::texture("textures/flag.png").double_sided().roughness(0.85),
        Interpolate,
        Transform::from_xyz(SIZE.x * 0.5 + 0.03, 2.25, 0.0),
    ));
    let (height, radius) = (2.95, 0.03);
    let pole = post(world, radius, height);
    let metal = Look::color(0xb9bec6).metal();
    world.spawn((InScene, pole, metal, Transform::from_xyz(0.0, height * 0.5, 0.0)));
    let knob = mesh(world, ball(radius * 2.0));
    let gold = Look::color(0xd9a441).metal();
    world.spawn((InScene, knob, gold, Transform::from_xyz(0.0, height, 0.0)));
}
