//! Marbles that fall into two coarse sheets: one collides by its particles, the other by its triangles.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyContacts, ContactShape};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::entities_named;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};

pub(super) const SCENE: Scene = Scene {
    name: "net",
    heading: Heading::Contacts,
    title: "Caught in coarse sheets",
    about: "the left sheet collides by its particles, and marbles fall between them; the right one by its triangles, and holds them all",
    eye: Vec3::new(0.7, 2.7, 4.3),
    target: Vec3::new(0.0, 1.05, 0.0),
    seconds: 4.0,
    moment: 2.2,
    lesson: Some(Lesson {
        try_this: "take smaller or heavier marbles, or pull harder at them",
        watch: "the cells of both sheets are wider than a marble: particles alone leave holes, triangles leave none",
        formula: "n = 36: no marble passes through a triangle",
        sliders: &[
            SceneSlider { label: "Size", unit: "times", range: [0.5, 1.4], default: 1.0 },
            SceneSlider {
                label: "Density", unit: "kg/m³", range: [200.0, 2500.0], default: 800.0
            },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [5.0, 15.0], default: 9.81 },
        ],
        number: "Marbles that the right sheet holds",
        unit: "",
        after: 1.5,
        measure: |world| {
            let marbles = entities_named(world, "right marble");
            let held = |marble: &&Entity| {
                world.get::<Particle>(**marble).is_some_and(|p| p.position.y > 0.35)
            };
            (!marbles.is_empty()).then(|| marbles.iter().filter(held).count() as f64)
        },
        expect: |_, _| f64::from(MARBLES),
        tolerance: [0.0, 0.0],
    }),
    spawn,
};

/// Side of a sheet, metres, and number of cells along it: 20 cm each, for marbles of 7 to 10 cm.
const SIDE: f32 = 1.6;
const CELLS: u32 = 8;

/// Marbles over each sheet.
const MARBLES: u32 = 36;

fn spawn(world: &mut World) {
    let [times, density, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.4));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    let by = [
        (-1.0, "left marble", ContactShape::Particles, 0xd9c9a8),
        (1.0, "right marble", ContactShape::Triangles, 0x9fc2d8),
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
            Cloth { radius: 0.01, density: 0.6, ..Cloth::grid(SIDE, SIDE, CELLS, CELLS) }
                .pinned(ClothPins::Corners),
            BodyContacts::default().shaped(shape),
            Look::color(color).double_sided().roughness(0.95),
            Interpolate,
            Transform::from_translation(middle).with_rotation(flat),
        ));
        marbles(world, name, middle, times, density);
    }
}

/// Three layers of marbles above the middle of a sheet, none directly above another. Nearer to the rim, large ones would be pushed over it.
fn marbles(world: &mut World, name: &'static str, middle: Vec3, times: f32, density: f32) {
    let colors = [0xd1495b, 0x66a182, 0xe9b44c, 0x8e6bb0, 0x2f8f83];
    let sizes = [0.035, 0.042, 0.05].map(|radius| {
        let radius = times * radius;
        let skin = mesh(world, Sphere::new(radius).mesh().uv(20, 12));
        (radius, skin)
    });
    for n in 0..MARBLES {
        let (layer, place) = (n / 12, n % 12);
        let [i, j] = [place % 4, place / 4].map(|i| i as f32);
        let shift = 0.07 * layer as f32;
        let across =
            Vec3::new(0.2 * (i - 1.5) + shift - 0.07, 0.0, 0.22 * (j - 1.0) - shift + 0.07);
        let at = middle + across + Vec3::Y * (0.5 + 0.35 * layer as f32 + 0.03 * i);
        let (radius, skin) = &sizes[n as usize % 3];
        world.spawn((
            InScene,
            Name::new(name),
            Particle::at(at),
            // The default density is that of wood; glass has 2500 kg/m³.
            Mass(density * 4.18879 * radius * radius * radius),
            Radius(*radius),
            skin.clone(),
            Look::color(colors[n as usize % colors.len()]).roughness(0.25),
            Transform::from_translation(at),
        ));
    }
}
