//! Crates poured into a heap, and a stacked tower.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "pile",
    heading: Heading::Contacts,
    title: "A pile of crates",
    about: "boxes of particles that collide by their shape: poured into a heap, and stacked into a tower",
    eye: Vec3::new(5.2, 3.6, 8.6),
    target: Vec3::new(0.1, 1.1, 0.0),
    seconds: 6.0,
    moment: 4.5,
    lesson: Some(Lesson {
        try_this: "build the tower higher, lay a heavier crate on its top, or take friction away",
        watch: "each contact carries the weight of everything above it without yielding: the tower stays as high as its crates",
        formula: "h = (n − ½) edge, whatever the weights",
        sliders: &[
            SceneSlider {
                label: "Crates in the tower",
                unit: "",
                range: [3.0, 10.0],
                default: 8.0,
            },
            SceneSlider { label: "Topmost", unit: "kg", range: [1.0, 50.0], default: 5.0 },
            SceneSlider { label: "Friction", unit: "", range: [0.3, 1.0], default: 0.6 },
        ],
        number: "Height of the topmost crate's centre",
        unit: "m",
        after: 1.5,
        measure: |world| {
            let top: Transform = component_of(world, "topmost crate")?;
            Some(f64::from(top.translation.y))
        },
        expect: |values, _| (f64::from(values[0]).round() - 0.5) * f64::from(EDGE),
        tolerance: [0.0, 0.002],
    }),
    spawn,
};

/// Edge of a crate, metres.
const EDGE: f32 = 0.5;

fn spawn(world: &mut World) {
    let [high, heavy, friction] = values(world);
    let count = high.round() as u32;
    let surface = SurfaceMaterial::new(friction);
    world.spawn((InScene, Ground, surface));
    let skin = mesh(world, rounded_box(Vec3::splat(EDGE), 0.015, 2));
    // Each layer is rotated and shifted, so that no crate falls straight onto the one below. What rolls off reaches the tower late, if at all.
    for n in 0..72_u32 {
        let (layer, place) = (n / 9, n % 9);
        let turn = 0.35 * layer as f32 + 0.2 * place as f32;
        let [x, z] = [place % 3, place / 3].map(|i| (i as f32 - 1.0) * 0.62);
        let drift = 0.11 * (layer % 3) as f32 - 0.11;
        let place = Vec3::new(x + drift - 1.5, 0.8 + 0.75 * layer as f32, z - drift);
        let rotation = Quat::from_euler(EulerRot::XYZ, 0.4 * turn, turn, 0.3 * turn);
        let place = Transform::from_translation(place).with_rotation(rotation);
        crate_at(world, "crate", 5.0, surface, &skin, place);
    }
    for n in 0..count {
        let yaw = if n % 2 == 0 { 0.06 } else { -0.09 };
        let place = Vec3::new(2.6, EDGE * (n as f32 + 0.5), -0.4);
        let rotation = Quat::from_rotation_y(yaw);
        let place = Transform::from_translation(place).with_rotation(rotation);
        let (name, mass) = if n + 1 == count { ("topmost crate", heavy) } else { ("crate", 5.0) };
        crate_at(world, name, mass, surface, &skin, place);
    }
}

fn crate_at(
    world: &mut World,
    name: &'static str,
    mass: f32,
    surface: SurfaceMaterial,
    skin: &Mesh3d,
    place: Transform,
) {
    world.spawn((
        InScene,
        Name::new(name),
        RigidBox::new(Vec3::splat(EDGE)).with_mass(mass),
        surface,
        skin.clone(),
        Look::texture("textures/crate.png").roughness(0.8),
        Interpolate,
        place,
    ));
}
