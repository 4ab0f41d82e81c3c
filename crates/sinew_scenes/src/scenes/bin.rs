//! Two hundred cubes of jelly in a bin.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "bin",
    heading: Heading::Soft,
    title: "A bin of jelly",
    about: "200 soft cubes, each of tetrahedra, that press against each other and against the walls",
    eye: Vec3::new(3.0, 4.2, 5.4),
    target: Vec3::new(0.0, 0.8, 0.0),
    seconds: 5.0,
    moment: 3.0,
    lesson: None,
    spawn,
};

/// Edge of a cube, metres.
const EDGE: f32 = 0.26;

/// Inside of the bin from wall to wall, metres.
const ROOM: f32 = 2.9;

fn spawn(world: &mut World) {
    world.insert_resource(SolverConfig { substeps: 8, max_sweeps: 2, ..default() });
    world.insert_resource(AirDrag(0.2));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    let (high, thick) = (1.8, 0.06);
    let reach = 0.5 * (ROOM + thick);
    for (x, z) in [(reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach)] {
        let along = ROOM + 2.0 * thick;
        let size =
            if z == 0.0 { Vec3::new(thick, high, along) } else { Vec3::new(along, high, thick) };
        let wall = mesh(world, rounded_box(size, 0.01, 2));
        let tin = Look::color(0x6d7780).metal();
        let place = Transform::from_xyz(x, 0.5 * high, z);
        world.spawn((InScene, Collider::cuboid(size), wall, tin, place));
    }
    let colors = [0xd1495b, 0x66a182, 0xe9b44c, 0x8e6bb0, 0x2f8f83];
    for n in 0..200_u32 {
        let (layer, place) = (n / 16, n % 16);
        let [x, z] = [place % 4, place / 4].map(|i| (i as f32 - 1.5) * 0.37);
        let drift = 0.05 * (layer % 3) as f32 - 0.05;
        let at = Vec3::new(x + drift, 0.35 + 0.36 * layer as f32, z - drift);
        let turn = Quat::from_euler(EulerRot::XYZ, 0.3 * n as f32, 0.5 * n as f32, 0.2 * n as f32);
        let cube = SoftBody {
            stiffness: 8e3,
            damping: 0.6,
            // Half of the way between two particles: the skin has no holes.
            radius: EDGE / 4.0,
            ..SoftBody::cuboid(Vec3::splat(EDGE), UVec3::splat(2))
        };
        world.spawn((
            InScene,
            Name::new("jelly"),
            cube,
            Look::color(colors[n as usize % colors.len()]).roughness(0.3),
            Interpolate,
            Transform::from_translation(at).with_rotation(turn),
        ));
    }
}
