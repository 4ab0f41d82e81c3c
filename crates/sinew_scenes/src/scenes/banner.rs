//! A banner cut like no grid: cloth from a mesh, as a modelling program would export it.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, post};
use crate::{Heading, InScene, Look};

pub(super) const SCENE: Scene = Scene {
    name: "banner",
    heading: Heading::Soft,
    title: "Cloth from any mesh",
    about: "an irregular glTF mesh with a seam in its texture; the seam is welded, so it does not tear",
    eye: Vec3::new(1.3, 1.9, 4.4),
    target: Vec3::new(0.0, 1.5, 0.0),
    seconds: 6.0,
    moment: 3.0,
    lesson: None,
    spawn,
};

fn spawn(world: &mut World) {
    let pressure = Vec3::new(2.0, 0.0, -7.0);
    world.spawn((InScene, Wind { pressure, gusts: 0.9, gust_length: 1.7, gust_period: 1.7 }));
    world.insert_resource(AirDrag(0.6));
    world.insert_resource(SolverConfig { substeps: 24, ..default() });
    world.spawn((InScene, Ground));
    let banner = world.resource::<AssetServer>().load("props/banner.glb#Mesh0/Primitive0");
    world.spawn((
        InScene,
        Name::new("banner"),
        Cloth { density: 0.3, ..Cloth::from_mesh() }.pinned(ClothPins::TopEdge),
        Mesh3d(banner),
        Look::texture("props/banner.glb#Texture0").double_sided().roughness(0.85),
        Interpolate,
        Transform::from_xyz(0.0, 2.6, 0.0),
    ));
    let rod = post(world, 0.025, 1.5);
    let wood = Look::color(0x8a6a4b);
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    world.spawn((InScene, rod, wood, Transform::from_xyz(0.0, 2.62, 0.0).with_rotation(lying)));
}
