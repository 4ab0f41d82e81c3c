//! A ball thrown against a curtain.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh, post};
use crate::{Heading, InScene, Look};

pub(super) const SCENE: Scene = Scene {
    name: "curtain",
    heading: Heading::Contacts,
    title: "A ball against a curtain",
    about: "a soft ball flies into a hanging cloth, is slowed down and drops",
    eye: Vec3::new(3.4, 1.9, 4.2),
    target: Vec3::new(-0.1, 1.1, 0.0),
    seconds: 4.0,
    moment: 0.62,
    lesson: None,
    spawn,
};

fn spawn(world: &mut World) {
    world.insert_resource(SolverConfig { substeps: 16, ..default() });
    world.insert_resource(AirDrag(0.3));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let rod = post(world, 0.025, 2.4);
    let brass = Look::color(0xb08d57).metal();
    let across = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    world.spawn((InScene, rod, brass, Transform::from_xyz(0.0, 2.3, 0.0).with_rotation(across)));
    world.spawn((
        InScene,
        Name::new("curtain"),
        Cloth { radius: 0.026, density: 0.3, ..Cloth::grid(2.2, 2.1, 44, 42) }
            .pinned(ClothPins::TopEdge),
        Look::color(0x8c3b4a).double_sided().roughness(0.95),
        Interpolate,
        Transform::from_xyz(0.0, 1.24, 0.0),
    ));
    // A ball of leather, pumped up; its particles are as far apart as they are wide.
    let skin = mesh(world, Sphere::new(0.24).mesh().uv(18, 11));
    let ball = SoftBody {
        radius: 0.03,
        pressure: 1.1,
        stretch: 300.0,
        bend: 0.05,
        damping: 0.1,
        ..SoftBody::from_mesh()
    }
    .with_mass(0.5);
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
    world.commands().entity(ball).set_linear_velocity(Vec3::new(0.0, 1.6, -6.0));
}
