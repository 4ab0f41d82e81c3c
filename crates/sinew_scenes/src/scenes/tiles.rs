//! A crate, a barrel and a ball over a floor of tiles, each a collider of its own, and of slabs, which are bodies.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::readings::nth_component_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "tiles",
    heading: Heading::Contacts,
    title: "Over tiles",
    about: "a floor of 84 tiles and 28 loose slabs side by side: crates slide over the seams until friction stops them, a barrel and a ball roll on, as on one plane",
    eye: Vec3::new(0.1, 2.3, 4.6),
    target: Vec3::new(-0.55, 0.15, 0.1),
    seconds: 4.0,
    moment: 1.2,
    lesson: Some(Lesson {
        try_this: "throw them faster, take friction away, or give the crates another mass",
        watch: "nothing catches on a seam or is thrown up by it: each tile lies below the face that carries the crate, so it cannot be in its way",
        formula: "s = v² / 2μg, whatever the mass and the number of tiles",
        sliders: &[
            SceneSlider { label: "Speed", unit: "m/s", range: [1.0, 4.0], default: 3.0 },
            SceneSlider { label: "Friction", unit: "", range: [0.25, 0.8], default: 0.35 },
            SceneSlider { label: "Mass of a crate", unit: "kg", range: [0.5, 50.0], default: 5.0 },
        ],
        number: "Way of the first crate",
        unit: "m",
        after: 2.0,
        measure: |world| {
            let crate_: Transform = nth_component_of(world, "crate", 0)?;
            Some(f64::from(crate_.translation.x - START))
        },
        expect: |values, _| {
            let [speed, friction] = [values[0], values[1]].map(f64::from);
            speed * speed / (2.0 * 9.81 * friction)
        },
        tolerance: [0.002, 0.01],
    }),
    spawn,
};

/// Size of a tile, metres, and their number along x and z.
const TILE: Vec3 = Vec3::new(0.5, 0.1, 0.5);
const TILES: [u32; 2] = [14, 8];
/// Rows of tiles; the others are slabs, and their mass, kg.
const FIXED: u32 = 6;
const SLAB: f32 = 60.0;
/// Where everything starts along x, metres, and the side of a crate.
const START: f32 = -2.9;
const SIDE: f32 = 0.4;
/// Of the barrel, metres: it lies on two rows of tiles, but not by halves.
const LENGTH: f32 = 0.7;

fn spawn(world: &mut World) {
    let [speed, friction, mass] = values(world);
    // The formula ignores air resistance.
    world.insert_resource(AirDrag(0.0));
    let surface = SurfaceMaterial::new(friction);
    world.spawn((InScene, Ground, surface));
    let tile = mesh(world, rounded_box(TILE, 0.006, 2));
    let [columns, rows] = TILES;
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let middle = |n: u32, of: u32| (n as f32 + 0.5 - 0.5 * of as f32) * TILE.x;
        let at = Vec3::new(middle(i, columns), 0.5 * TILE.y, middle(j, rows));
        let [light, dark] = if j < FIXED { [0xb9b2a3, 0x8d8a84] } else { [0xbfa07a, 0x97795a] };
        let color = if (i + j) % 2 == 0 { light } else { dark };
        let looks = (tile.clone(), Look::color(color).roughness(0.8));
        let place = Transform::from_translation(at);
        if j < FIXED {
            let solid = (Name::new("tile"), Collider::cuboid(TILE));
            world.spawn((InScene, solid, surface, looks, place));
        } else {
            let solid = (Name::new("slab"), RigidBox::new(TILE).with_mass(SLAB));
            world.spawn((InScene, solid, surface, looks, place, Interpolate));
        }
    }
    let block = mesh(world, rounded_box(Vec3::splat(SIDE), 0.02, 2));
    for (z, turn) in [(1.3, 0.0), (0.55, 0.5)] {
        let at = Vec3::new(START, TILE.y + 0.5 * SIDE, z);
        world.spawn((
            InScene,
            Name::new("crate"),
            RigidBox::new(Vec3::splat(SIDE)).with_mass(mass),
            surface,
            block.clone(),
            Look::color(0xb08a5a).roughness(0.8),
            LinearVelocity(Vec3::X * speed),
            Interpolate,
            Transform::from_translation(at).with_rotation(Quat::from_rotation_y(turn)),
        ));
    }
    let radius = 0.5 * SIDE;
    let lies = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let barrel = RigidShape::Cylinder { radius, height: LENGTH };
    let rolling = [
        ("barrel", barrel, cylinder(radius, LENGTH), lies, -0.35, 0x4f7cac),
        ("ball", RigidShape::Sphere { radius }, ball(radius), Quat::IDENTITY, -1.3, 0xc0604d),
    ];
    for (name, shape, skin, turn, z, color) in rolling {
        let skin = mesh(world, skin);
        world.spawn((
            InScene,
            Name::new(name),
            RigidMesh::density(300.0).shaped(shape),
            surface,
            skin,
            Look::color(color).roughness(0.35),
            LinearVelocity(Vec3::X * speed),
            Interpolate,
            Transform::from_xyz(START, TILE.y + radius, z).with_rotation(turn),
        ));
    }
}
