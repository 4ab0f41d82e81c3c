//! Balls that bounce without loss of energy: a break.

use bevy::prelude::*;
use bevy_sinew::Combine;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::readings::entities_named;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "billiards",
    heading: Heading::Contacts,
    title: "The break",
    about: "one ball hits fifteen that touch: all contacts of the blow are solved as one problem, so that with restitution 1 no energy is lost or gained",
    eye: Vec3::new(0.0, 5.6, 4.6),
    target: Vec3::new(0.2, 0.3, 0.1),
    seconds: 6.0,
    moment: 1.15,
    lesson: Some(Lesson {
        try_this: "hit harder, or further off the middle: the balls fly elsewhere, and together have the energy of the cue ball",
        watch: "fifteen touching balls share one blow: as many unknowns as contacts, solved together; solved one by one, they would lose or gain energy",
        formula: "Σ ½ m v² = ½ m v₀²",
        sliders: &[
            SceneSlider { label: "Speed", unit: "m/s", range: [2.0, 8.0], default: 5.0 },
            SceneSlider { label: "Off the middle", unit: "m", range: [-0.15, 0.15], default: 0.03 },
            SceneSlider { label: "Mass of a ball", unit: "kg", range: [0.1, 1.0], default: 0.2 },
        ],
        number: "Energy of all balls",
        unit: "J",
        after: 2.0,
        measure: |world| {
            let [_, _, mass] = values(world);
            let balls = entities_named(world, "ball");
            let square = |ball: &Entity| {
                world.get::<LinearVelocity>(*ball).map(|v| v.0.as_dvec3().length_squared())
            };
            let squares: f64 = balls.iter().filter_map(square).sum();
            (!balls.is_empty()).then_some(0.5 * f64::from(mass) * squares)
        },
        expect: |values, _| {
            0.5 * f64::from(values[2]) * f64::from(values[0]) * f64::from(values[0])
        },
        tolerance: [0.0, 0.005],
    }),
    spawn,
};

const RADIUS: f32 = 0.16;
/// Length and width of the cloth, metres, and its height.
const TABLE_SIZE: Vec2 = Vec2::new(5.6, 2.9);
const TABLE_HEIGHT: f32 = 0.4;

fn spawn(world: &mut World) {
    let [speed, off, mass] = values(world);
    // The formula ignores air resistance.
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground));
    let smooth = SurfaceMaterial {
        restitution: 1.0,
        friction_rule: Combine::Multiply,
        ..SurfaceMaterial::new(0.0)
    };
    let slab = Vec3::new(TABLE_SIZE.x, TABLE_HEIGHT, TABLE_SIZE.y);
    let cloth = mesh(world, rounded_box(slab, 0.02, 2));
    let felt = (Collider::cuboid(slab), SurfaceMaterial::new(0.05));
    let green = Look::color(0x2f6b4a).roughness(0.95);
    let at = Transform::from_xyz(0.0, 0.5 * TABLE_HEIGHT, 0.0);
    world.spawn((InScene, Name::new("table"), felt, cloth, green, at));
    let wood = Look::color(0x5d3f29).roughness(0.6);
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let wide = 0.18;
        let size = if x == 0.0 {
            Vec3::new(TABLE_SIZE.x + 2.0 * wide, TABLE_HEIGHT + 0.24, wide)
        } else {
            Vec3::new(wide, TABLE_HEIGHT + 0.24, TABLE_SIZE.y)
        };
        let out = Vec3::new(x * (TABLE_SIZE.x + wide), size.y, z * (TABLE_SIZE.y + wide)) * 0.5;
        let skin = mesh(world, rounded_box(size, 0.03, 2));
        let cushion = (Collider::cuboid(size), smooth);
        let at = Transform::from_translation(out);
        world.spawn((InScene, Name::new("cushion"), cushion, skin, wood.clone(), at));
    }
    let skin = mesh(world, ball(RADIUS));
    let mut add = |x: f32, z: f32, color: u32, velocity: Vec3| {
        world.spawn((
            InScene,
            Name::new("ball"),
            RigidMesh::mass(mass).shaped(RigidShape::Sphere { radius: RADIUS }),
            smooth,
            LinearVelocity(velocity),
            skin.clone(),
            Look::color(color).roughness(0.15),
            Interpolate,
            Transform::from_xyz(x, TABLE_HEIGHT + RADIUS, z),
        ));
    };
    let colors = [0xd9b26a, 0x4f7cac, 0xc0604d, 0x6b4f8a, 0xd98a3d, 0x3d7a5a, 0x8a3344, 0x26262b];
    let mut number = 0;
    for row in 0..5 {
        for place in 0..=row {
            let x = 0.7 + row as f32 * RADIUS * 3.0_f32.sqrt();
            let z = (place as f32 - 0.5 * row as f32) * 2.0 * RADIUS;
            add(x, z, colors[number % colors.len()], Vec3::ZERO);
            number += 1;
        }
    }
    add(-2.2, off, 0xf0ece0, Vec3::X * speed);
}
