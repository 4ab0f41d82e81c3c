//! A sheet of water of up to a million particles and two million springs, with waves that agree with the formula.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ConstraintOf, ContactsDisabled, MeshFollow, ParticleBody, ParticleOf};

use crate::look::Look;
use crate::props::mesh;
use crate::scene::{Heading, InScene, Lesson, OnStage, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "million",
    heading: Heading::Together,
    title: "A million particles",
    about: "a lake of particles and twice as many springs: 65 thousand at first, a million at the end of the slider, which takes far more than 16 ms a frame",
    eye: Vec3::new(0.5, 3.1, 8.2),
    target: Vec3::new(0.0, 0.2, 0.5),
    seconds: 6.0,
    moment: 0.75,
    lesson: Some(Lesson {
        try_this: "move the first slider to a million and read the time of a tick in the report below; the waves are the same",
        watch: "the drop becomes a ring that reflects from the walls; throughout, its lowest mode oscillates as the formula predicts",
        formula: "a = a₀ cos ωt, ω = √(8k/m) sin(π/2N), c = d √(k/m)",
        sliders: &[
            SceneSlider {
                label: "Particles",
                unit: "thousand",
                range: [16.0, 1000.0],
                default: 65.0,
            },
            SceneSlider { label: "Wave speed", unit: "m/s", range: [1.0, 2.5], default: 2.0 },
            SceneSlider { label: "Drop", unit: "m", range: [0.2, 1.2], default: 1.0 },
        ],
        number: "Amplitude of the lowest mode",
        unit: "mm",
        after: 0.25,
        measure: |world| {
            let [particles, ..] = world.resource::<OnStage>().values[..] else { return None };
            slowest(world.resource::<SinewWorld>(), side(particles))
        },
        expect: |values, seconds| {
            let [particles, speed, drop] = [values[0], values[1], values[2]];
            let pieces = f64::from(side(particles) - 1);
            // Springs of σc² between masses of σd²: √(k/m) = c/d.
            let turn = f64::from(speed) * pieces / f64::from(LAKE)
                * libm::sqrt(8.0)
                * libm::sin(core::f64::consts::FRAC_PI_2 / pieces);
            first_amplitude(side(particles), drop) * libm::cos(turn * seconds) * 1e3
        },
        tolerance: [0.2, 0.01],
    }),
    spawn,
};

/// Length and width of the lake, metres; its water level, metres; and its mass per area, kg/m².
const LAKE: f32 = 6.0;
const LEVEL: f32 = 0.5;
const DENSITY: f32 = 1.0;
/// Positions of the drop and of a depression of the water, metres, and their heights as multiples of the drop's.
const DROPS: [(Vec2, f32); 2] = [(Vec2::new(-0.8, 0.4), 1.0), (Vec2::new(1.3, -0.9), -0.6)];
/// Standard deviation of both shapes, metres.
const WIDE: f32 = 0.2;

/// Number of particles along a side.
fn side(thousand: f32) -> u32 {
    libm::sqrtf(1e3 * thousand).round().max(3.0) as u32
}

/// Coordinate of particle `i` of a side, metres.
fn along(i: u32, side: u32) -> f32 {
    LAKE * (i as f32 / (side - 1) as f32 - 0.5)
}

/// The shape of the drop along one axis; the whole shape is the product over both axes.
fn bell(off: f32) -> f32 {
    libm::expf(-0.5 * (off / WIDE) * (off / WIDE))
}

/// The shape of both, relative to the height of the drop.
fn bells(x: f32, z: f32) -> f32 {
    DROPS.iter().map(|(at, part)| part * bell(x - at.x) * bell(z - at.y)).sum()
}

/// The lowest mode along one axis, at each particle.
fn wave(side: u32) -> Vec<f64> {
    let turn = core::f64::consts::PI / f64::from(side - 1);
    (0..side).map(|i| libm::sin(f64::from(i) * turn)).collect()
}

/// Initial amplitude of the lowest mode, metres.
fn first_amplitude(side: u32, drop: f32) -> f64 {
    let share = |centre: f32| -> f64 {
        let all = wave(side).into_iter().zip(0..);
        all.map(|(wave, i)| wave * f64::from(bell(along(i, side) - centre))).sum()
    };
    let pieces = f64::from(side - 1);
    let drops = DROPS.iter().map(|(at, part)| f64::from(*part) * share(at.x) * share(at.y));
    4.0 / (pieces * pieces) * f64::from(drop) * drops.sum::<f64>()
}

/// Current amplitude of the lowest mode, millimetres. Particles are in the order of their creation: row by row.
fn slowest(world: &SinewWorld, side: u32) -> Option<f64> {
    let particles = world.particles();
    if particles.len() != (side * side) as usize {
        return None;
    }
    let wave = wave(side);
    let mut sum = 0.0;
    for (row, down) in wave.iter().enumerate() {
        let first = row * side as usize;
        let heights = wave.iter().enumerate().map(|(column, across)| {
            across * f64::from(particles.position(first + column).y - LEVEL)
        });
        sum += down * heights.sum::<f64>();
    }
    let pieces = f64::from(side - 1);
    Some(4.0 / (pieces * pieces) * sum * 1e3)
}

fn spawn(world: &mut World) {
    let [thousand, speed, drop] = values(world);
    let side = side(thousand);
    let gap = LAKE / (side - 1) as f32;
    // A wave travels at most half a gap in a substep, so that Verlet is stable (its limit is 0.7). That can take more substeps than the default.
    let substeps = SolverConfig::default().substeps.max((speed / gap / 30.0).ceil() as u32);
    world.insert_resource(SolverConfig { substeps, ..default() });
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    let water = Look::color(0x1f6f9f).roughness(0.12).double_sided();
    let lake = (InScene, Name::new("lake"), ParticleBody, ContactsDisabled, water);
    let body = world.spawn(lake).id();
    let mass = DENSITY * gap * gap;
    let particles: Vec<Entity> = world
        .spawn_batch((0..side * side).map(move |i| {
            let [x, z] = [i % side, i / side].map(|i| along(i, side));
            let edge = [i % side, i / side].iter().any(|&i| i == 0 || i == side - 1);
            let high = if edge { 0.0 } else { drop * bells(x, z) };
            (Particle::at(Vec3::new(x, LEVEL + high, z)), Mass(mass), ParticleOf(body))
        }))
        .collect();
    let at = |x: u32, z: u32| particles[(x + z * side) as usize];
    for i in 0..side {
        for edge in [at(i, 0), at(i, side - 1), at(0, i), at(side - 1, i)] {
            world.entity_mut(edge).insert(Pinned::HERE);
        }
    }
    // Springs of rest length 0: their force is linear, as for water with small waves.
    let stiffness = DENSITY * speed * speed;
    let spring = |a: Entity, b: Entity| (Spring::new(a, b, 0.0, stiffness), ConstraintOf(body));
    let rows: Vec<_> = (1..side - 1)
        .flat_map(|z| (0..side - 1).map(move |x| (x, z)))
        .map(|(x, z)| spring(at(x, z), at(x + 1, z)))
        .collect();
    world.spawn_batch(rows);
    let columns: Vec<_> = (0..side - 1)
        .flat_map(|z| (1..side - 1).map(move |x| (x, z)))
        .map(|(x, z)| spring(at(x, z), at(x, z + 1)))
        .collect();
    world.spawn_batch(columns);
    let skin = mesh(world, sheet(side));
    world.entity_mut(body).insert((skin, MeshFollow { vertices: particles }));
    basin(world);
}

/// Squares between the particles. The simulation fills in positions and normals.
fn sheet(side: u32) -> Mesh {
    let vertices = (side * side) as usize;
    let mut indices = Vec::with_capacity(6 * vertices);
    for z in 0..side - 1 {
        for x in 0..side - 1 {
            let a = x + z * side;
            indices.extend([a, a + side, a + 1, a + 1, a + side, a + side + 1]);
        }
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; vertices])
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0_f32, 1.0, 0.0]; vertices])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0_f32; 2]; vertices])
        .with_inserted_indices(Indices::U32(indices))
}

/// Walls around the lake. They are only drawn.
fn basin(world: &mut World) {
    let stone = Look::color(0xb9b2a6).roughness(0.85);
    let (thick, high) = (0.22, LEVEL + 0.12);
    let reach = 0.5 * (LAKE + thick);
    for (x, z) in [(reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach)] {
        let along = LAKE + 2.0 * thick;
        let size =
            if z == 0.0 { Vec3::new(thick, high, along) } else { Vec3::new(along, high, thick) };
        let wall = mesh(world, rounded_box(size, 0.03, 3));
        world.spawn((InScene, wall, stone.clone(), Transform::from_xyz(x, 0.5 * high, z)));
    }
}
