//! A ball thrown against a curtain.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::{entities_named, faceted_ball, volume_of};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};

pub(super) const SCENE: Scene = Scene {
    name: "curtain",
    heading: Heading::Contacts,
    title: "A ball against a curtain",
    about: "a soft ball flies into a hanging cloth, is slowed down and drops",
    eye: Vec3::new(3.4, 1.9, 4.2),
    target: Vec3::new(-0.1, 1.1, 0.0),
    seconds: 4.0,
    moment: 0.62,
    lesson: Some(Lesson {
        try_this: "throw the ball harder, use a heavier one, or inflate it more",
        watch: "the cloth dents the ball and is swept along by it; the ball bulges elsewhere, because its volume stays the same",
        formula: "V = p V₀, at every moment of the blow",
        sliders: &[
            SceneSlider { label: "Speed", unit: "m/s", range: [4.5, 9.0], default: 6.0 },
            SceneSlider { label: "Mass of the ball", unit: "kg", range: [0.3, 1.5], default: 0.5 },
            SceneSlider { label: "Pressure", unit: "times", range: [1.0, 1.25], default: 1.1 },
        ],
        number: "Volume of the ball",
        unit: "l",
        after: 0.36,
        measure: |world| {
            let ball = *entities_named(world, "ball").first()?;
            Some(volume_of(world, ball)? * 1e3)
        },
        expect: |values, _| {
            f64::from(values[2]) * faceted_ball(f64::from(RADIUS), SECTORS, STACKS) * 1e3
        },
        tolerance: [0.0, 0.005],
    }),
    spawn,
};

/// Radius of the ball, metres, and its facets around its axis and from pole to pole.
const RADIUS: f32 = 0.24;
const SECTORS: u32 = 18;
const STACKS: u32 = 11;

/// Height of the rod, metres. The hem is 5 cm above the ground; from 20 cm on, the ball would slip through below it.
const TOP: f32 = 2.16;

fn spawn(world: &mut World) {
    let [speed, mass, pressure] = values(world);
    world.insert_resource(AirDrag(0.3));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let rod = post(world, 0.025, 2.4);
    let brass = Look::color(0xb08d57).metal();
    let across = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    world.spawn((InScene, rod, brass, Transform::from_xyz(0.0, TOP, 0.0).with_rotation(across)));
    world.spawn((
        InScene,
        Name::new("curtain"),
        Cloth { radius: 0.026, density: 0.3, ..Cloth::grid(2.2, 2.1, 44, 42) }
            .pinned(ClothPins::TopEdge),
        Look::color(0x8c3b4a).double_sided().roughness(0.95),
        Interpolate,
        Transform::from_xyz(0.0, TOP - 1.06, 0.0),
    ));
    // An inflated leather ball. Its particles are as far apart as they are wide.
    let skin = mesh(world, Sphere::new(RADIUS).mesh().uv(SECTORS, STACKS));
    let ball = SoftBody {
        radius: 0.03,
        pressure,
        stretch: 300.0,
        bend: 0.05,
        damping: 0.1,
        ..SoftBody::from_mesh()
    }
    .with_mass(mass);
    let ball = world
        .spawn((
            InScene,
            Name::new("ball"),
            ball,
            skin,
            Look::texture("textures/ball.png").roughness(0.35),
            Interpolate,
            Transform::from_xyz(0.15, 1.1, 1.7),
        ))
        .id();
    world.commands().entity(ball).set_linear_velocity(Vec3::new(0.0, 1.6, -speed));
}
