//! Boxes with buoyancy by their shape, in a pool with a current.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BoxParticles, Region};

use crate::look::Look;
use crate::props::mesh;
use crate::readings::nth_component_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "boats",
    heading: Heading::Forces,
    title: "Hulls in a current",
    about: "crates float a quarter, a half and three quarters deep, by their density; the raft stays level, the tall box turns over; all drift",
    eye: Vec3::new(0.4, 3.3, 8.4),
    target: Vec3::new(0.0, 0.95, 0.0),
    seconds: 8.0,
    moment: 4.2,
    lesson: Some(Lesson {
        try_this: "load the crate in the middle, build it higher, or let the water flow",
        watch: "a hull displaces its own weight of water: the fraction of it under water is the ratio of its density to the water's, in still water and in a current",
        formula: "draught = height ρ_crate / ρ_water",
        sliders: &[
            SceneSlider { label: "Density", unit: "kg/m³", range: [250.0, 750.0], default: 500.0 },
            SceneSlider { label: "Height", unit: "m", range: [0.4, 0.6], default: 0.5 },
            SceneSlider { label: "Current", unit: "m/s", range: [0.0, 0.3], default: 0.25 },
        ],
        number: "Draught of the middle crate",
        unit: "mm",
        after: 6.0,
        measure: |world| {
            let frame: Transform = nth_component_of(world, "crate", 1)?;
            let [_, height, _] = values(world);
            Some(f64::from(DEPTH - (frame.translation.y - 0.5 * height)) * 1e3)
        },
        expect: |values, _| f64::from(values[1] * values[0] / WATER) * 1e3,
        tolerance: [2.0, 0.01],
    }),
    spawn,
};

/// Depth of the pool, metres: the surface is this high above the ground.
const DEPTH: f32 = 1.2;
/// Half its length and half its width, metres.
const HALF: Vec2 = Vec2::new(4.7, 1.6);
/// Density of the water, kg/m³.
const WATER: f32 = 1000.0;

fn spawn(world: &mut World) {
    let [density, height, current] = values(world);
    world.spawn((InScene, Ground));
    world.spawn((
        InScene,
        Name::new("pool"),
        Fluid::flowing(Vec3::X * current),
        Region::boxed(2.0 * Vec3::new(HALF.x, DEPTH, HALF.y)),
        Transform::from_xyz(0.0, DEPTH, 0.0),
    ));
    // Only the rear half of the water is drawn, cut through the middle of the boats, so that their draught is visible.
    let slab = mesh(world, Cuboid::new(2.0 * HALF.x, DEPTH, HALF.y));
    let blue = Look::color(0x2f86b5).roughness(0.08).opacity(0.62);
    world.spawn((InScene, slab, blue, Transform::from_xyz(0.0, DEPTH * 0.5, -HALF.y * 0.5)));
    let crates = [(0.25, 0.5), (density / WATER, height), (0.75, 0.5)];
    for (i, (share, height)) in crates.into_iter().enumerate() {
        // Wide enough to float upright at any density s (relative to water): width² > 6 height² s (1 - s).
        let size = Vec3::new(0.8, height, 0.8);
        let crate_ = float(world, size, share, -1.5 + 1.1 * i as f32, 0.0);
        if i == 1 {
            // Starts near its rest position: a light hull displaces little water and bobs for long.
            let high = DEPTH + (0.5 - 0.95 * share) * height;
            let place = Transform::from_xyz(-0.4, high, 0.0);
            world.entity_mut(crate_).insert(place);
        }
        let skin = mesh(world, rounded_box(size, 0.02, 2));
        let wood = Look::texture("textures/crate.png").roughness(0.8);
        world.entity_mut(crate_).insert((Name::new("crate"), skin, wood));
    }
    let tall = Vec3::new(0.45, 1.5, 0.45);
    let tower = float(world, tall, 0.5, 2.2, -0.06);
    let skin = mesh(world, rounded_box(tall, 0.03, 2));
    world.entity_mut(tower).insert((Name::new("tall box"), skin, Look::color(0xd9622b)));
    raft(world);
}

/// A floating box of relative density `share`, its bottom a little above its draught.
fn float(world: &mut World, size: Vec3, share: f32, x: f32, turn: f32) -> Entity {
    let place = Vec3::new(x, DEPTH + 0.5 * size.y - 0.3 * share, 0.0);
    world
        .spawn((
            InScene,
            RigidBox { particles: BoxParticles::Equimomental, ..RigidBox::new(size) }
                .with_mass(WATER * share * size.element_product()),
            Floats::OWN,
            Interpolate,
            Transform::from_translation(place).with_rotation(Quat::from_rotation_z(turn)),
        ))
        .id()
}

/// A raft of six logs with a mast. For buoyancy it is one wide box.
fn raft(world: &mut World) {
    let size = Vec3::new(1.5, 0.22, 1.26);
    let raft = float(world, size, 0.45, -3.6, -0.2);
    world.entity_mut(raft).insert((Name::new("raft"), Visibility::default()));
    let log = mesh(world, cylinder(size.y * 0.5, size.x));
    let bark = Look::color(0x8a6a4b).roughness(0.9);
    let along = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    for i in 0..6 {
        let place = Transform::from_xyz(0.0, 0.0, (i as f32 - 2.5) * 0.21).with_rotation(along);
        world.spawn((ChildOf(raft), log.clone(), bark.clone(), place));
    }
    let (mast, sail) = (mesh(world, cylinder(0.03, 1.2)), mesh(world, Cuboid::new(0.02, 0.6, 0.8)));
    world.spawn((ChildOf(raft), mast, bark, Transform::from_xyz(0.0, 0.65, 0.0)));
    world.spawn((ChildOf(raft), sail, Look::color(0xefe6d2), Transform::from_xyz(0.04, 0.9, 0.0)));
}
