//! Two hundred cubes of jelly in a bin.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::readings::points_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "bin",
    heading: Heading::Soft,
    title: "A bin of jelly",
    about: "200 soft cubes, each of tetrahedra, that press against each other and against the walls",
    eye: Vec3::new(3.0, 4.2, 5.4),
    target: Vec3::new(0.0, 0.8, 0.0),
    seconds: 5.0,
    moment: 3.0,
    lesson: Some(Lesson {
        try_this: "make the jelly stiffer, denser or rougher",
        watch: "each cube yields where it is pressed and bulges elsewhere; walls and ground push as hard as needed, and no particle gets through",
        formula: "|x| ≤ width/2, |z| ≤ width/2, y ≥ 0 for the centre of every particle",
        sliders: &[
            SceneSlider { label: "Stiffness", unit: "kPa", range: [5.0, 20.0], default: 8.0 },
            SceneSlider { label: "Density", unit: "kg/m³", range: [50.0, 150.0], default: 100.0 },
            SceneSlider { label: "Friction", unit: "", range: [0.2, 0.9], default: 0.5 },
        ],
        number: "Deepest particle centre in wall or ground",
        unit: "mm",
        after: 0.75,
        measure: |world| {
            let points = points_of(world, "jelly");
            let deep = |p: &Vec3| {
                let out = p.x.abs().max(p.z.abs());
                // Depth in the wall, from its inner or outer side; above the rim there is no wall.
                let wall = (out - 0.5 * ROOM).min(0.5 * ROOM + THICK - out);
                let wall = if p.y < HIGH { wall } else { 0.0 };
                f64::from(wall.max(-p.y).max(0.0))
            };
            Some(points.iter().map(deep).reduce(f64::max)? * 1e3)
        },
        expect: |_, _| 0.0,
        tolerance: [0.1, 0.0],
    }),
    spawn,
};

/// Edge of a cube, metres.
const EDGE: f32 = 0.26;

/// Inner width of the bin, metres.
const ROOM: f32 = 2.9;
/// Height and thickness of the walls, and radius of a particle, metres: half the distance of neighbouring particles, so that the surface has no holes.
const HIGH: f32 = 1.8;
const THICK: f32 = 0.06;
const RADIUS: f32 = EDGE / 4.0;
/// Largest rotation of a cube about each axis, rad, and distance from cube to cube, metres. A cube rotated that far extends to 1.33 times half its edge, plus
/// the radius of its particles: 0.24 m. Cubes that overlap when they are spawned are pressed to seven eighths of their volume until they are apart.
const TURN: f32 = 0.15;
const PITCH: f32 = 0.475;

fn spawn(world: &mut World) {
    let [stiffness, density, friction] = values(world);
    let surface = SurfaceMaterial::new(friction);
    world.insert_resource(AirDrag(0.2));
    world.spawn((InScene, Ground, surface));
    let reach = 0.5 * (ROOM + THICK);
    for (x, z) in [(reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach)] {
        let along = ROOM + 2.0 * THICK;
        let size =
            if z == 0.0 { Vec3::new(THICK, HIGH, along) } else { Vec3::new(along, HIGH, THICK) };
        let wall = mesh(world, rounded_box(size, 0.01, 2));
        let tin = Look::color(0x6d7780).metal();
        let place = Transform::from_xyz(x, 0.5 * HIGH, z);
        world.spawn((InScene, Collider::cuboid(size), surface, wall, tin, place));
    }
    let colors = [0xd1495b, 0x66a182, 0xe9b44c, 0x8e6bb0, 0x2f8f83];
    for n in 0..200_u32 {
        let (layer, place) = (n / 36, n % 36);
        let [x, z] = [place % 6, place / 6].map(|i| (i as f32 - 2.5) * PITCH);
        let at = Vec3::new(x, (layer as f32 + 0.55) * PITCH, z);
        // Varied poses, up to the angle for which the pitch leaves room.
        let angle = |stride: u32| TURN * ((n * stride % 13) as f32 / 6.0 - 1.0);
        let turn = Quat::from_euler(EulerRot::XYZ, angle(3), angle(5), angle(7));
        let cube = SoftBody {
            stiffness: stiffness * 1e3,
            damping: 0.6,
            radius: RADIUS,
            ..SoftBody::cuboid(Vec3::splat(EDGE), UVec3::splat(2)).with_density(density)
        };
        world.spawn((
            InScene,
            Name::new("jelly"),
            cube,
            surface,
            Look::color(colors[n as usize % colors.len()]).roughness(0.3),
            Interpolate,
            Transform::from_translation(at).with_rotation(turn),
        ));
    }
}
