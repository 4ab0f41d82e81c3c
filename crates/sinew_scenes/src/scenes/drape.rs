//! Cloth that falls over a ball and over a table.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyContacts, BodyParticles};

use crate::look::Look;
use crate::props::mesh;
use crate::readings::nth_component_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "drape",
    heading: Heading::Soft,
    title: "Draped cloth",
    about: "44 × 44 cells each, over a ball and over a table's edges; folds lie on folds",
    eye: Vec3::new(0.2, 2.3, 4.6),
    target: Vec3::new(0.0, 0.65, 0.0),
    seconds: 5.0,
    moment: 2.6,
    lesson: Some(Lesson {
        try_this: "drape the red cloth over a smaller or a larger ball, heavier or smoother",
        watch: "each particle of the cloth is a small ball that stays outside the large one; where the cloth lies on it, their centres are both radii apart",
        formula: "|p − c| ≥ R + r, and equal where it lies",
        sliders: &[
            SceneSlider {
                label: "Radius of the ball",
                unit: "m",
                range: [0.35, 0.55],
                default: 0.5,
            },
            SceneSlider { label: "Density", unit: "kg/m²", range: [0.1, 0.6], default: 0.2 },
            SceneSlider { label: "Friction", unit: "", range: [0.2, 1.0], default: 0.5 },
        ],
        number: "Ball's centre to the cloth",
        unit: "mm",
        after: 0.8,
        measure: |world| {
            let cloth: BodyParticles = nth_component_of(world, "cloth", 0)?;
            let apart =
                |p: Entity| world.get::<Particle>(p).map(|p| f64::from(p.position.distance(BALL)));
            Some(cloth.iter().filter_map(apart).reduce(f64::min)? * 1e3)
        },
        expect: |values, _| f64::from(values[0] + PARTICLE_RADIUS) * 1e3,
        tolerance: [1.0, 0.0],
    }),
    spawn,
};

/// Centre of the ball, and radius of a particle of cloth, metres.
const BALL: Vec3 = Vec3::new(-1.05, 0.75, 0.0);
const PARTICLE_RADIUS: f32 = 0.0165;

fn spawn(world: &mut World) {
    let [radius, density, friction] = values(world);
    let surface = SurfaceMaterial::new(friction);
    world.insert_resource(AirDrag(0.5));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let globe = mesh(world, ball(radius));
    let place = Transform::from_translation(BALL);
    let stone = Look::color(0x8f9aa3).roughness(0.5);
    world.spawn((InScene, Collider::sphere(radius), surface, globe, stone, place));
    let size = Vec3::new(0.9, 0.9, 0.9);
    let top = mesh(world, rounded_box(size, 0.01, 2));
    let wood = Look::color(0x8a6a4b).roughness(0.7);
    let place = Transform::from_xyz(1.05, 0.45, 0.0);
    world.spawn((InScene, Collider::cuboid(size), surface, top, wood, place));
    for (x, height, color) in [(BALL.x, 1.45, 0xb8434e), (1.05, 1.0, 0x3f6f9f)] {
        let turn =
            Quat::from_rotation_y(0.4) * Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
        world.spawn((
            InScene,
            Name::new("cloth"),
            Cloth { radius: PARTICLE_RADIUS, density, ..Cloth::grid(1.7, 1.7, 44, 44) },
            surface,
            BodyContacts::ALL,
            Look::color(color).double_sided().roughness(0.9),
            Interpolate,
            Transform::from_xyz(x, height, 0.0).with_rotation(turn),
        ));
    }
}
