//! A crate falls into a sheet that is pinned at its four corners and catches it.

use bevy::prelude::*;
use bevy_sinew::RigidPose;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::points_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "catch",
    heading: Heading::Contacts,
    title: "Caught in a sheet",
    about: "a crate lands in a cloth pinned at four corners: each pulls on the other",
    eye: Vec3::new(2.6, 2.6, 4.4),
    target: Vec3::new(0.0, 1.0, 0.0),
    seconds: 5.0,
    moment: 1.0,
    lesson: Some(Lesson {
        try_this: "drop a heavier crate, or from higher up; then make the sheet softer",
        watch: "the sheet yields until it carries the crate; crate and sheet push each other equally in every contact, and a touching particle's centre is its radius away from the crate",
        formula: "d(p, crate) ≥ r, and equal where they touch",
        sliders: &[
            SceneSlider { label: "Mass", unit: "kg", range: [1.0, 8.0], default: 4.0 },
            SceneSlider { label: "Drop", unit: "m", range: [0.2, 1.2], default: 0.7 },
            SceneSlider { label: "Softness", unit: "mm/N", range: [0.1, 0.4], default: 0.2 },
        ],
        number: "Crate to nearest particle centre",
        unit: "mm",
        after: 3.0,
        measure: |world| {
            let (middle, turn) = crate_now(world)?;
            let into = |p: &Vec3| turn.transpose() * (*p - middle);
            let off = |p: &Vec3| f64::from(off_a_box(into(p), 0.5 * EDGE));
            Some(points_of(world, "sheet").iter().map(off).reduce(f64::min)? * 1e3)
        },
        expect: |_, _| f64::from(PARTICLE_RADIUS) * 1e3,
        tolerance: [1.5, 0.0],
    }),
    spawn,
};

/// Height and side of the sheet, and edge of the crate, metres.
const SHEET: f32 = 1.4;
const SIDE: f32 = 2.0;
const EDGE: f32 = 0.5;
/// Radius of a particle of the sheet, metres.
const PARTICLE_RADIUS: f32 = 0.03;

/// Signed distance of a point from a cube about the origin with this half edge, metres; negative inside.
fn off_a_box(at: Vec3, half: f32) -> f32 {
    let past = at.abs() - half;
    past.max(Vec3::ZERO).length() + past.max_element().min(0.0)
}

/// Centre and rotation of the crate, from its particles, as the sheet's particles are read too. Its transform is interpolated between two ticks and lags by up
/// to 50 mm while the crate bounces at 3 m/s.
fn crate_now(world: &mut World) -> Option<(Vec3, Mat3)> {
    let RigidPose { particles, rest } = component_of(world, "crate")?;
    let at = |&one: &Entity| world.get::<Particle>(one).map(|one| one.position);
    let points: Vec<Vec3> = particles.iter().filter_map(at).collect();
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    let mut moments = Mat3::ZERO;
    for (&point, rest) in points.iter().zip(&rest) {
        let arm = point - middle;
        moments += Mat3::from_cols(arm * rest.x, arm * rest.y, arm * rest.z);
    }
    // The second moments of a cube are equal along all axes.
    let square = rest.iter().map(|rest| rest.length_squared()).sum::<f32>() / 3.0;
    (points.len() == rest.len() && square > 0.0).then(|| (middle, moments * (1.0 / square)))
}

fn spawn(world: &mut World) {
    let [mass, drop, softness] = values(world);
    world.insert_resource(AirDrag(0.95));
    world.spawn((InScene, Ground));
    for x in [-1.0, 1.0] {
        for z in [-1.0, 1.0] {
            let post = post(world, 0.03, SHEET);
            let wood = Look::color(0x8a6a4b);
            world.spawn((InScene, post, wood, Transform::from_xyz(x, 0.5 * SHEET, z)));
        }
    }
    let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
    world.spawn((
        InScene,
        Name::new("sheet"),
        // Compliant, like a knitted fabric: inextensible cloth, spread taut, would act as a trampoline.
        Cloth {
            radius: PARTICLE_RADIUS,
            density: 0.8,
            stretch_compliance: softness * 1e-3,
            ..Cloth::grid(SIDE, SIDE, 40, 40)
        }
        .pinned(ClothPins::Corners),
        Look::color(0xe4dccb).double_sided().roughness(0.95),
        Interpolate,
        Transform::from_xyz(0.0, SHEET, 0.0).with_rotation(flat),
    ));
    let size = Vec3::splat(EDGE);
    let skin = mesh(world, rounded_box(size, 0.015, 2));
    world.spawn((
        InScene,
        Name::new("crate"),
        RigidBox::new(size).with_mass(mass),
        skin,
        Look::texture("textures/crate.png").roughness(0.8),
        Interpolate,
        Transform::from_xyz(0.1, SHEET + 0.6 * EDGE + drop, -0.05).with_rotation(Quat::from_euler(
            EulerRot::XYZ,
            0.2,
            0.4,
            0.15,
        )),
    ));
}
