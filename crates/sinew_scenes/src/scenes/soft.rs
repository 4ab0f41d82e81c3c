//! Soft bodies: a pumped-up ball, a slack one, and cubes and a ball of jelly that is soft all through.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh};
use crate::{Heading, InScene, Look};

pub(super) const SCENE: Scene = Scene {
    name: "soft",
    heading: Heading::Soft,
    title: "Soft bodies",
    about: "balls kept full by their volume, the striped one pumped up; cubes of tetrahedra, soft and stiff: all squash, and come back",
    eye: Vec3::new(0.4, 2.2, 7.3),
    target: Vec3::new(0.0, 0.7, 0.0),
    seconds: 4.2,
    moment: 0.62,
    lesson: None,
    spawn,
};

fn spawn(world: &mut World) {
    world.insert_resource(SolverConfig { substeps: 10, ..default() });
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let ball = mesh(world, Sphere::new(0.45).mesh().uv(18, 11));
    let taut = Look::texture("textures/ball.png").roughness(0.35);
    let skin = SoftBody { damping: 0.05, bend: 0.05, ..SoftBody::from_mesh() };
    let balls = [
        (-2.75, SoftBody { pressure: 1.15, stretch: 400.0, ..skin.clone() }, taut),
        (-1.15, SoftBody { stretch: 200.0, ..skin }, Look::color(0x8e6bb0).roughness(0.3)),
    ];
    for (x, soft, look) in balls {
        let place = Transform::from_xyz(x, 1.9, 0.0).with_rotation(Quat::from_rotation_x(0.5));
        world.spawn((InScene, Name::new("ball"), soft, ball.clone(), look, Interpolate, place));
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
