//! Soft bodies: an inflated ball, a slack one, and cubes and a ball of tetrahedra.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::readings::{entities_named, faceted_ball, volume_of};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};

pub(super) const SCENE: Scene = Scene {
    name: "soft",
    heading: Heading::Soft,
    title: "Soft bodies",
    about: "balls that keep their volume, the striped one inflated; cubes of tetrahedra, soft and stiff: all are squashed and recover",
    eye: Vec3::new(0.4, 2.2, 7.3),
    target: Vec3::new(0.0, 0.7, 0.0),
    seconds: 4.2,
    moment: 0.62,
    lesson: Some(Lesson {
        try_this: "inflate the striped ball, make it larger or let it fall from higher",
        watch: "the ground squashes it at constant volume: the higher the pressure, the tighter its skin and the higher it bounces",
        formula: "V = p V₀, kept as one constraint of all corners",
        sliders: &[
            SceneSlider { label: "Pressure", unit: "times", range: [1.0, 1.3], default: 1.15 },
            SceneSlider { label: "Radius", unit: "m", range: [0.35, 0.5], default: 0.45 },
            SceneSlider { label: "Fall", unit: "m", range: [0.5, 1.6], default: 1.4 },
        ],
        number: "Volume of the striped ball",
        unit: "l",
        after: 0.62,
        measure: |world| {
            let ball = *entities_named(world, "ball").first()?;
            Some(volume_of(world, ball)? * 1e3)
        },
        expect: |values, _| {
            f64::from(values[0]) * faceted_ball(f64::from(values[1]), SECTORS, STACKS) * 1e3
        },
        tolerance: [0.0, 0.01],
    }),
    spawn,
};

/// Facets of a ball around its axis and from pole to pole.
const SECTORS: u32 = 18;
const STACKS: u32 = 11;

fn spawn(world: &mut World) {
    let [pressure, radius, fall] = values(world);
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let [striped, violet] =
        [radius, 0.45].map(|radius| mesh(world, Sphere::new(radius).mesh().uv(SECTORS, STACKS)));
    let taut = Look::texture("textures/ball.png").roughness(0.35);
    let skin = SoftBody { damping: 0.05, bend: 0.05, ..SoftBody::from_mesh() };
    let balls = [
        (
            -2.75,
            radius + fall,
            SoftBody { pressure, stretch: 400.0, ..skin.clone() },
            striped,
            taut,
        ),
        (
            -1.15,
            1.9,
            SoftBody { stretch: 200.0, ..skin },
            violet,
            Look::color(0x8e6bb0).roughness(0.3),
        ),
    ];
    for (x, high, soft, skin, look) in balls {
        let place = Transform::from_xyz(x, high, 0.0).with_rotation(Quat::from_rotation_x(0.5));
        world.spawn((InScene, Name::new("ball"), soft, skin, look, Interpolate, place));
    }
    let cube = SoftBody { damping: 0.6, ..SoftBody::cuboid(Vec3::splat(0.7), UVec3::splat(4)) };
    let cubes = [
        (0.2, SoftBody { stiffness: 4.5e3, ..cube.clone() }, Vec3::ZERO, 0xd1495b),
        (1.45, SoftBody { stiffness: 1.5e4, ..cube }, Vec3::new(0.2, 0.3, 0.35), 0x66a182),
    ];
    for (x, soft, turn, color) in cubes {
        let rotation = Quat::from_euler(EulerRot::XYZ, turn.x, turn.y, turn.z);
        let place = Transform::from_xyz(x, 1.6, 0.0).with_rotation(rotation);
        let look = Look::color(color).roughness(0.25);
        world.spawn((InScene, Name::new("cube"), soft, look, Interpolate, place));
    }
    let drop = SoftBody { stiffness: 5e3, ..SoftBody::ball(0.4, 6) };
    let look = Look::color(0xe9b44c).roughness(0.25);
    let place = Transform::from_xyz(2.8, 1.5, 0.0);
    world.spawn((InScene, Name::new("drop"), drop, look, Interpolate, place));
}
