//! A blanket, ragdolls and crates that fall on hills: a terrain as a heightfield.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::readings::{nth_component_of, points_of};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "hills",
    heading: Heading::Contacts,
    title: "Over hills",
    about: "a blanket, ragdolls and crates fall on a terrain, which is a heightfield; they lie in its hollows and roll down its slopes",
    eye: Vec3::new(2.9, 2.3, 4.8),
    target: Vec3::new(0.15, 0.35, 0.0),
    seconds: 5.0,
    moment: 2.6,
    lesson: Some(Lesson {
        try_this: "make the hills higher or flatter, smoother or rougher",
        watch: "the blanket follows every hollow; in a step each of its particles meets only the triangle below, so a terrain costs little more than a plane",
        formula: "h(x, z) ≥ r for every particle, with its height h above the terrain and its radius r",
        sliders: &[
            SceneSlider { label: "Height", unit: "m", range: [0.05, 0.4], default: 0.3 },
            SceneSlider { label: "Friction", unit: "", range: [0.2, 1.0], default: 0.6 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [5.0, 15.0], default: 9.81 },
        ],
        number: "Particles of the blanket below the terrain",
        unit: "",
        after: 1.5,
        measure: |world| {
            let terrain: Collider = nth_component_of(world, "hills", 0)?;
            let shape = terrain.shape().ok()?;
            let points = points_of(world, "blanket");
            let below = points.iter().filter(|&&point| shape.nearest(point).distance < 0.0);
            Some(below.count() as f64)
        },
        expect: |_, _| 0.0,
        tolerance: [0.0, 0.0],
    }),
    spawn,
};

/// Vertices along a side of the terrain, and its width, metres.
const SIDE: usize = 49;
const WIDE: f32 = 12.0;

fn spawn(world: &mut World) {
    let [height, friction, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.2));
    let surface = SurfaceMaterial::new(friction);
    let heights = heights(height);
    // They are far from the limits of a collider.
    let Ok(hills) = Collider::height_field(SIDE, SIDE, &heights, Vec3::new(WIDE, 1.0, WIDE)) else {
        return;
    };
    let drawn = mesh(world, terrain(&heights));
    let grass = Look::color(0x7d8f5a).roughness(0.95);
    world.spawn((InScene, Name::new("hills"), hills, surface, drawn, grass, Transform::default()));
    let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
    world.spawn((
        InScene,
        Name::new("blanket"),
        Cloth { radius: 0.012, density: 0.4, ..Cloth::grid(2.2, 2.2, 36, 36) },
        surface,
        Look::color(0xd8743c).double_sided().roughness(0.95),
        Interpolate,
        Transform::from_xyz(-0.4, 1.1, 0.5).with_rotation(flat),
    ));
    for (n, color) in [0x2f8f83, 0xe0b040].into_iter().enumerate() {
        let along = n as f32;
        let turn = Quat::from_rotation_y(1.9 * along) * Quat::from_rotation_z(-0.8);
        world.spawn((
            InScene,
            Name::new("ragdoll"),
            Ragdoll::default(),
            surface,
            Look::color(color).roughness(0.55),
            Interpolate,
            Transform::from_xyz(1.0 - 2.6 * along, 1.9, -1.2 - 0.3 * along).with_rotation(turn),
        ));
    }
    let size = Vec3::splat(0.28);
    let block = mesh(world, rounded_box(size, 0.015, 2));
    for n in 0..6_u32 {
        let along = n as f32;
        let at =
            Vec3::new(1.3 + 0.4 * (n % 3) as f32, 1.1 + 0.4 * along, 0.9 - 0.4 * (n / 3) as f32);
        world.spawn((
            InScene,
            Name::new("crate"),
            RigidBox::new(size).with_mass(8.0),
            block.clone(),
            surface,
            Look::color(0xb08a5a).roughness(0.8),
            Interpolate,
            Transform::from_translation(at).with_rotation(Quat::from_rotation_y(along)),
        ));
    }
}

/// Heights of the terrain, row by row, metres.
fn heights(most: f32) -> Vec<f32> {
    let at = |i: usize| WIDE * (i as f32 / (SIDE - 1) as f32 - 0.5);
    let height = |i: usize| {
        let (x, z) = (at(i % SIDE), at(i / SIDE));
        most * (1.0
            + 0.7 * ops::sin(1.9 * x + 0.5) * ops::cos(1.6 * z)
            + 0.3 * ops::sin(x - 0.8 * z))
    };
    (0..SIDE * SIDE).map(height).collect()
}

/// The triangles of the heightfield.
fn terrain(heights: &[f32]) -> Mesh {
    let at = |i: usize| WIDE * (i as f32 / (SIDE - 1) as f32 - 0.5);
    let positions: Vec<[f32; 3]> =
        heights.iter().enumerate().map(|(i, &y)| [at(i % SIDE), y, at(i / SIDE)]).collect();
    let cells = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE);
    let triangles = cells.flat_map(|i| {
        let [a, b, c, d] = [i, i + SIDE, i + 1, i + SIDE + 1].map(|i| i as u32);
        [a, b, c, b, d, c]
    });
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(triangles.collect()))
        .with_computed_smooth_normals()
}
