//! Charges in a box: opposite ones attract, like ones repel.

use bevy::prelude::*;
use bevy_sinew::TubeMesh;
use bevy_sinew::prelude::*;
use bevy_sinew::{Charge, Electric};

use crate::look::Look;
use crate::props::mesh;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "charges",
    heading: Heading::Forces,
    title: "Electric charges",
    about: "48 charges in a box without gravity: red ones and blue ones attract, like ones repel",
    eye: Vec3::new(2.9, 2.5, 3.7),
    target: Vec3::new(0.0, 1.15, 0.0),
    seconds: 6.0,
    moment: 2.5,
    lesson: Some(Lesson {
        try_this: "give them more charge or less mass: they come together sooner; less air drag lets them fly about for longer",
        watch: "red and blue come as close as their radii allow, and no closer, however strong the attraction; two reds stay apart",
        formula: "F = K q² r / (r² + ε²)^(3/2) as long as r > r_red + r_blue",
        sliders: &[
            SceneSlider { label: "Charge", unit: "µC", range: [1.0, 4.0], default: 2.0 },
            SceneSlider { label: "Mass", unit: "g", range: [10.0, 50.0], default: 20.0 },
            SceneSlider { label: "Air drag", unit: "per s", range: [0.2, 0.8], default: 0.35 },
        ],
        number: "Nearest red and blue centres",
        unit: "mm",
        after: 2.0,
        measure: |world| {
            let mut charges = world.query::<(&Particle, &Charge)>();
            let all: Vec<(Vec3, f32)> =
                charges.iter(world).map(|(p, q)| (p.position, q.0)).collect();
            let pairs =
                all.iter().enumerate().flat_map(|(i, a)| all[i + 1..].iter().map(move |b| (a, b)));
            let apart =
                pairs.filter(|(a, b)| a.1 * b.1 < 0.0).map(|(a, b)| f64::from(a.0.distance(b.0)));
            Some(apart.reduce(f64::min)? * 1e3)
        },
        expect: |_, _| f64::from(RADII[0] + RADII[1]) * 1e3,
        tolerance: [1.0, 0.0],
    }),
    spawn,
};

/// Half the edge of the box, metres.
const HALF: f32 = 1.1;
/// Radii of a red and of a blue ball, metres.
const RADII: [f32; 2] = [0.075, 0.055];

fn spawn(world: &mut World) {
    let [charge, mass, drag] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(drag));
    world.insert_resource(Electric { softening: 0.12, ..default() });
    let centre = Vec3::Y * (HALF + 0.05);
    world.spawn((
        InScene,
        BoundingBox { size: Vec3::splat(2.0 * HALF) },
        SurfaceMaterial::new(0.1),
        Transform::from_translation(centre),
    ));
    frame(world, centre);
    let looks = [0xd1495b, 0x2e86ab].map(|color| Look::color(color).roughness(0.25));
    let skins = RADII.map(|radius| mesh(world, ball(radius)));
    let mut random = 20_u32;
    let mut next = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
    };
    for i in 0..48 {
        let place = centre + Vec3::new(next(), next(), next()) * (HALF * 0.9);
        let kind = i % 2;
        // ±2 µC at 1 m repel with 36 mN, which moves 20 g at 1.8 m/s².
        let charge = if kind == 0 { charge * 1e-6 } else { charge * -1e-6 };
        world.spawn((
            InScene,
            Particle::at(place),
            Mass(mass * 1e-3),
            Radius(RADII[kind]),
            Charge(charge),
            Transform::from_translation(place),
            skins[kind].clone(),
            looks[kind].clone(),
        ));
    }
}

/// Draws the edges of the bounding box that confines the charges: tubes between pinned particles.
fn frame(world: &mut World, centre: Vec3) {
    let corners: Vec<Entity> = (0..8)
        .map(|i| {
            let side = |bit: usize| if i >> bit & 1 == 1 { HALF } else { -HALF };
            let place = centre + Vec3::new(side(0), side(1), side(2));
            world.spawn((InScene, Particle::at(place), Pinned::HERE)).id()
        })
        .collect();
    for i in 0..8_usize {
        for bit in 0..3 {
            let j = i | 1 << bit;
            if j != i {
                let particles = vec![corners[i], corners[j]];
                world.spawn((
                    InScene,
                    TubeMesh { particles, radius: 0.012, sides: 6 },
                    Look::color(0x8d99ae),
                ));
            }
        }
    }
}
