//! Two coarse blankets that fall over picket fences, which are meshes: one collides by its particles, the other by its triangles.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::recipes::convex_hull;
use bevy_sinew::{BodyContacts, ContactShape};

use crate::look::Look;
use crate::props::mesh;
use crate::readings::{nth_component_of, points_of};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};

pub(super) const SCENE: Scene = Scene {
    name: "fence",
    heading: Heading::Contacts,
    title: "Over the fence",
    about: "each fence is one mesh; the left blanket collides by its particles, and falls through; the right one by its triangles, and hangs over it",
    eye: Vec3::new(0.9, 1.9, 4.0),
    target: Vec3::new(0.0, 0.55, 0.0),
    seconds: 5.0,
    moment: 3.0,
    lesson: Some(Lesson {
        try_this: "weave the blankets more finely or more coarsely, or let them fall harder",
        watch: "the pickets are narrower than the cells, so there are often no particles above them; a thread between two particles meets them all the same",
        formula: "n = 0: no edge of the mesh goes through a thread",
        sliders: &[
            SceneSlider { label: "Cells", unit: "", range: [5.0, 16.0], default: 8.0 },
            SceneSlider { label: "Thickness", unit: "mm", range: [5.0, 15.0], default: 10.0 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [5.0, 15.0], default: 9.81 },
        ],
        number: "Threads of the right blanket that go through the fence",
        unit: "",
        after: 1.5,
        measure: |world| {
            let fence: Collider = nth_component_of(world, "right fence", 0)?;
            let at: GlobalTransform = nth_component_of(world, "right fence", 0)?;
            let points = points_of(world, "right blanket");
            let columns = points.len().isqrt();
            if columns < 2 {
                return None;
            }
            let shape = fence.shape().ok()?;
            let inverse = at.affine().inverse();
            let is_through = |i: usize, j: usize| {
                let [start, end] = [i, j].map(|i| inverse.transform_point3(points[i]));
                let way = end - start;
                shape.cast_ray(start, way.normalize_or_zero(), way.length()).is_some()
            };
            let along = |i: usize| i % columns + 1 < columns && is_through(i, i + 1);
            let across = |i: usize| i + columns < points.len() && is_through(i, i + columns);
            let threads = (0..points.len()).map(|i| usize::from(along(i)) + usize::from(across(i)));
            Some(threads.sum::<usize>() as f64)
        },
        expect: |_, _| 0.0,
        tolerance: [0.0, 0.0],
    }),
    spawn,
};

/// Width of a blanket and of a fence, metres.
const WIDE: f32 = 1.5;
const LONG: f32 = 1.8;

/// Pickets of a fence, and their height, width and depth, metres.
const PICKETS: u32 = 11;
const PICKET: Vec3 = Vec3::new(0.05, 0.8, 0.02);

fn spawn(world: &mut World) {
    let [cells, thickness, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.4));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    let fence = fence();
    // It is far from the limits of a collider.
    let Ok(collider) = Collider::from_mesh(&fence) else { return };
    let fence = mesh(world, fence);
    let cells = cells.round() as u32;
    let by = [
        (-1.1, "left", ContactShape::Particles, 0xd8743c),
        (1.1, "right", ContactShape::Triangles, 0x2f8f83),
    ];
    for (x, name, shape, color) in by {
        world.spawn((
            InScene,
            Name::new(format!("{name} fence")),
            collider.clone(),
            fence.clone(),
            SurfaceMaterial::new(0.6),
            Look::color(0x7a5a43).roughness(0.8),
            Transform::from_xyz(x, 0.0, 0.0),
        ));
        let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
        world.spawn((
            InScene,
            Name::new(format!("{name} blanket")),
            Cloth {
                radius: 1e-3 * thickness,
                density: 0.4,
                ..Cloth::grid(WIDE, WIDE, cells, cells)
            },
            SurfaceMaterial::new(0.6),
            BodyContacts::default().shaped(shape),
            Look::color(color).double_sided().roughness(0.95),
            Interpolate,
            Transform::from_xyz(x, 1.25, 0.06).with_rotation(flat),
        ));
    }
}

/// Pointed pickets on two rails, as one mesh about the middle of its foot.
fn fence() -> Mesh {
    let block = |size: Vec3, at: Vec3| -> Vec<Vec3> {
        let signs = (0..8_u32).map(|i| {
            let sign = |bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
            Vec3::new(sign(0), sign(1), sign(2))
        });
        signs.map(|sign| at + sign * size).collect()
    };
    let picket = |i: u32| {
        let x = LONG * (i as f32 / (PICKETS - 1) as f32 - 0.5);
        let mut points = block(PICKET, Vec3::new(x, 0.5 * PICKET.y, 0.0));
        let tip = Vec3::new(x, PICKET.y + 0.5 * PICKET.x, 0.5 * PICKET.z);
        points.extend([tip, tip * Vec3::new(1.0, 1.0, -1.0)]);
        points
    };
    let rail = |height: f32| {
        let size = Vec3::new(LONG + 2.0 * PICKET.x, 0.04, 0.02);
        block(size, Vec3::new(0.0, height, -0.5 * (PICKET.z + size.z)))
    };
    let parts = (0..PICKETS).map(picket).chain([0.2, 0.62].map(rail));
    let mut positions = Vec::new();
    for part in parts {
        // None of them is flat.
        for face in convex_hull(&part).unwrap_or_default() {
            positions.extend(face.map(|corner| part[corner as usize].to_array()));
        }
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_computed_flat_normals()
}
