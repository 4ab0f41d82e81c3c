//! Marbles and dice that fall into two coarse sheets: one collides by its particles, the other by its triangles.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyContacts, ContactShape};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::entities_named;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "net",
    heading: Heading::Contacts,
    title: "Caught in coarse sheets",
    about: "the left sheet collides by its particles, and marbles and dice fall between them; the right one by its triangles, and holds them all",
    eye: Vec3::new(0.7, 2.7, 4.3),
    target: Vec3::new(0.0, 1.05, 0.0),
    seconds: 4.0,
    moment: 2.2,
    lesson: Some(Lesson {
        try_this: "take smaller or heavier ones, or pull harder at them",
        watch: "the cells of both sheets are wider than a marble or a die: particles alone leave holes, triangles leave none",
        formula: "n = 36: nothing passes through a triangle",
        sliders: &[
            SceneSlider { label: "Size", unit: "times", range: [0.5, 1.4], default: 1.0 },
            SceneSlider {
                label: "Density", unit: "kg/m³", range: [200.0, 2500.0], default: 800.0
            },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [5.0, 15.0], default: 9.81 },
        ],
        number: "Marbles and dice that the right sheet holds",
        unit: "",
        after: 1.5,
        measure: |world| {
            let toys = entities_named(world, "right toy");
            let held = |toy: &&Entity| {
                world.get::<Transform>(**toy).is_some_and(|at| at.translation.y > 0.35)
            };
            (!toys.is_empty()).then(|| toys.iter().filter(held).count() as f64)
        },
        expect: |_, _| f64::from(TOYS),
        tolerance: [0.0, 0.0],
    }),
    spawn,
};

/// Compliance of a thread, m/N: it gives way by some centimetres, so that all rolls to the middle and nothing over the rim.
const COMPLIANCE: f32 = 2e-3;

/// Side of a sheet, metres, and number of cells along it: 20 cm each, for marbles of 7 to 10 cm.
const SIDE: f32 = 1.6;
const CELLS: u32 = 8;

/// Marbles and dice over each sheet, in turn.
const TOYS: u32 = 36;

fn spawn(world: &mut World) {
    let [times, density, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.4));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    let by = [
        (-1.0, "left toy", ContactShape::Particles, 0xd9c9a8),
        (1.0, "right toy", ContactShape::Triangles, 0x9fc2d8),
    ];
    for (x, name, shape, color) in by {
        let middle = Vec3::new(x, 1.2, 0.0);
        for (i, j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let post = post(world, 0.025, middle.y);
            let foot = middle + Vec3::new(i, 0.0, j) * (0.5 * SIDE) - Vec3::Y * (0.5 * middle.y);
            let wood = Look::color(0x8a6a4b);
            world.spawn((InScene, post, wood, Transform::from_translation(foot)));
        }
        let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
        world.spawn((
            InScene,
            Name::new("sheet"),
            Cloth {
                radius: 0.01,
                density: 0.6,
                stretch_compliance: COMPLIANCE,
                ..Cloth::grid(SIDE, SIDE, CELLS, CELLS)
            }
            .pinned(ClothPins::Corners),
            BodyContacts::default().shaped(shape),
            Look::color(color).double_sided().roughness(0.95),
            Interpolate,
            Transform::from_translation(middle).with_rotation(flat),
        ));
        toys(world, name, middle, times, density);
    }
}

/// Three layers of marbles and dice above the middle of a sheet, none directly above another. Nearer to the rim, large ones would be pushed over it.
fn toys(world: &mut World, name: &'static str, middle: Vec3, times: f32, density: f32) {
    let colors = [0xd1495b, 0x66a182, 0xe9b44c, 0x8e6bb0, 0x2f8f83];
    let sizes = [0.035, 0.042, 0.05].map(|radius| {
        let radius = times * radius;
        let skin = mesh(world, Sphere::new(radius).mesh().uv(20, 12));
        (radius, skin)
    });
    let dice = sizes.each_ref().map(|&(radius, _)| {
        let size = 1.5 * radius;
        (size, mesh(world, rounded_box(Vec3::splat(size), 0.1 * size, 2)))
    });
    for n in 0..TOYS {
        let (layer, place) = (n / 12, n % 12);
        let [i, j] = [place % 4, place / 4].map(|i| i as f32);
        let shift = 0.07 * layer as f32;
        let across =
            Vec3::new(0.16 * (i - 1.5) + shift - 0.07, 0.0, 0.17 * (j - 1.0) - shift + 0.07);
        let at = middle + across + Vec3::Y * (0.3 + 0.3 * layer as f32 + 0.03 * i);
        let color = colors[n as usize % colors.len()];
        if n % 2 == 1 {
            let (size, skin) = &dice[n as usize % 3];
            let turn = Quat::from_rotation_z(0.7 * n as f32) * Quat::from_rotation_x(0.4);
            world.spawn((
                InScene,
                Name::new(name),
                RigidBox::new(Vec3::splat(*size)).with_mass(density * size * size * size),
                skin.clone(),
                Look::color(color).roughness(0.5),
                Interpolate,
                Transform::from_translation(at).with_rotation(turn),
            ));
            continue;
        }
        let (radius, skin) = &sizes[n as usize % 3];
        world.spawn((
            InScene,
            Name::new(name),
            Particle::at(at),
            // The default density is that of wood; glass has 2500 kg/m³.
            Mass(density * 4.18879 * radius * radius * radius),
            Radius(*radius),
            skin.clone(),
            Look::color(color).roughness(0.25),
            Transform::from_translation(at),
        ));
    }
}
