//! A banner with irregular triangles: cloth from a mesh, as exported by a modelling program.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{curve, post};
use crate::readings::points_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};

pub(super) const SCENE: Scene = Scene {
    name: "banner",
    heading: Heading::Soft,
    title: "Cloth from any mesh",
    about: "an irregular glTF mesh whose seam is welded hangs in a steady wind, along the sum of its weight and the wind's push: the red line",
    eye: Vec3::new(1.3, 1.9, 4.4),
    target: Vec3::new(0.0, 1.5, 0.0),
    seconds: 6.0,
    moment: 3.0,
    lesson: Some(Lesson {
        try_this: "turn up the wind, or take heavier cloth: the banner leans until wind and weight add up to its own direction",
        watch: "the texture seam is welded, so the banner hangs as one sheet, along the red line; the wind pressure on it falls with the cosine of its angle",
        formula: "sin φ / cos² φ = p / (σ g)",
        sliders: &[
            SceneSlider { label: "Pressure", unit: "Pa", range: [0.5, 5.0], default: 3.0 },
            SceneSlider { label: "Density", unit: "kg/m²", range: [0.2, 0.8], default: 0.3 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [3.7, 9.81], default: 9.81 },
        ],
        number: "Angle of the banner",
        unit: "°",
        after: 4.0,
        measure: |world| {
            let points = points_of(world, "banner");
            let down: f64 = points.iter().map(|p| f64::from(TOP - p.y)).sum();
            let away: f64 = points.iter().map(|p| f64::from(-p.z)).sum();
            (!points.is_empty()).then(|| libm::atan2(away, down).to_degrees())
        },
        expect: |values, _| lean(values[0], values[1], values[2]).to_degrees(),
        tolerance: [0.5, 0.02],
    }),
    spawn,
};

/// Height of the upper edge, metres.
const TOP: f32 = 2.6;

/// The angle from the vertical, radians, at which a sheet of `density` kg/m² hangs in a wind of `pressure` pascal. Its weight is σ g per area and the wind
/// presses with p cos φ, so it hangs along the sum of both where tan φ = p cos φ / (σ g).
fn lean(pressure: f32, density: f32, gravity: f32) -> f64 {
    let ratio = f64::from(pressure) / (f64::from(density) * f64::from(gravity));
    // With s = sin φ: ratio s² + s − ratio = 0.
    libm::asin((libm::sqrt(1.0 + 4.0 * ratio * ratio) - 1.0) / (2.0 * ratio))
}

fn spawn(world: &mut World) {
    let [pressure, density, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.spawn((InScene, Wind { pressure: Vec3::NEG_Z * pressure, gusts: 0.0, ..default() }));
    // Strong drag, so that it comes to rest in a few seconds.
    world.insert_resource(AirDrag(0.95));
    world.spawn((InScene, Ground));
    let banner = world.resource::<AssetServer>().load("props/banner.glb#Mesh0/Primitive0");
    world.spawn((
        InScene,
        Name::new("banner"),
        Cloth { density, ..Cloth::from_mesh() }.pinned(ClothPins::TopEdge),
        Mesh3d(banner),
        Look::texture("props/banner.glb#Texture0").double_sided().roughness(0.85),
        Interpolate,
        Transform::from_xyz(0.0, TOP, 0.0),
    ));
    let rod = post(world, 0.025, 1.5);
    let wood = Look::color(0x8a6a4b);
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    world.spawn((InScene, rod, wood, Transform::from_xyz(0.0, 2.62, 0.0).with_rotation(lying)));
    // The direction by the formula, drawn beside the banner.
    let (sin, cos) = libm::sincosf(lean(pressure, density, gravity) as f32);
    let from = Vec3::new(0.72, TOP, 0.0);
    let line = [from, from + 1.5 * Vec3::new(0.0, -cos, -sin)];
    curve(world, &line, 0.008, Look::color(0xd0342c));
}
