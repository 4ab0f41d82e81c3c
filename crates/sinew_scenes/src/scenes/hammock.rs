//! A sheet that hangs on four ropes, and bodies that fall into it.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Anchor, BodyParticles};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::nth_component_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "hammock",
    heading: Heading::Soft,
    title: "A hammock",
    about: "36 × 24 cells on four ropes tied to its corners; a crate and some balls fall into it",
    eye: Vec3::new(1.5, 2.3, 3.4),
    target: Vec3::new(0.0, 0.95, 0.0),
    seconds: 4.0,
    moment: 1.6,
    lesson: Some(Lesson {
        try_this: "make the crate heavier, or the ropes longer, and drag the bodies in it",
        watch: "the whole weight hangs on two or three threads at the end of each rope, and they are no longer than the others",
        formula: "|c − q| = L: a rope is taut, and as long as its segments",
        sliders: &[
            SceneSlider { label: "Mass of the crate", unit: "kg", range: [0.5, 3.0], default: 1.0 },
            SceneSlider { label: "Rope length", unit: "m", range: [0.72, 0.95], default: 0.8 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [5.0, 15.0], default: 9.81 },
        ],
        number: "Hook to the corner of the sheet",
        unit: "m",
        after: 2.0,
        measure: |world| {
            let cloth: BodyParticles = nth_component_of(world, "hammock", 0)?;
            let apart =
                |p: Entity| world.get::<Particle>(p).map(|p| f64::from(p.position.distance(HOOK)));
            // The corner is the particle of the sheet nearest to the hook.
            cloth.iter().filter_map(apart).reduce(f64::min)
        },
        expect: |values, _| f64::from(values[1]),
        tolerance: [0.0, 0.02],
    }),
    spawn,
};

/// Size of the sheet and its initial height, metres.
const SIZE: Vec2 = Vec2::new(1.8, 1.2);
const HEIGHT: f32 = 1.2;

/// One of the four hooks.
const HOOK: Vec3 = Vec3::new(1.35, 1.6, 0.85);

fn spawn(world: &mut World) {
    let [mass, length, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.4));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.6)));
    let flat = Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2);
    let sheet = world
        .spawn((
            InScene,
            Name::new("hammock"),
            Cloth { density: 0.5, ..Cloth::grid(SIZE.x, SIZE.y, 36, 24) },
            SurfaceMaterial::new(0.6),
            Look::color(0xc4713b).double_sided().roughness(0.95),
            Interpolate,
            Transform::from_xyz(0.0, HEIGHT, 0.0).with_rotation(flat),
        ))
        .id();
    for (i, k) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let sides = Vec3::new(i, 1.0, k);
        let hook = HOOK * sides;
        let height = hook.y + 0.08;
        let stake = post(world, 0.04, height);
        let wood = Look::color(0x8a6a4b);
        let foot = hook.with_y(0.5 * height) + 0.05 * Vec3::new(i, 0.0, k);
        world.spawn((InScene, stake, wood, Transform::from_translation(foot)));
        // In the frame of the sheet, which lies flat, rotated about x.
        let corner = Vec3::new(0.5 * SIZE.x * i, -0.5 * SIZE.y * k, 0.0);
        let place = Vec3::new(0.5 * SIZE.x * i, HEIGHT, 0.5 * SIZE.y * k);
        let gap = hook.distance(place);
        world.spawn((
            InScene,
            Name::new("rope"),
            Rope { segments: 14, ..Rope::between(hook, (sheet, Anchor::Point(corner))) }
                .with_slack((length / gap - 1.0).max(0.0)),
            Look::color(0xd8cbb0),
            Interpolate,
        ));
    }
    let size = Vec3::new(0.36, 0.26, 0.26);
    let skin = mesh(world, rounded_box(size, 0.02, 3));
    world.spawn((
        InScene,
        Name::new("crate"),
        RigidBox::new(size).with_mass(mass),
        skin,
        Look::color(0x9c6b3f).roughness(0.8),
        Interpolate,
        Transform::from_xyz(-0.2, 1.9, 0.1).with_rotation(Quat::from_rotation_z(0.3)),
    ));
    let colors = [0x3f6f9f, 0x66a182, 0xe9b44c, 0x8e6bb0, 0xd1495b, 0x2f8f83];
    let skin = mesh(world, ball(0.07));
    for (number, color) in (0..).zip(colors) {
        let turn = number as f32;
        let at =
            Vec3::new(0.25 + 0.2 * libm::cosf(turn), 1.7 + 0.16 * turn, 0.2 * libm::sinf(turn));
        world.spawn((
            InScene,
            Name::new("ball"),
            Particle::at(at),
            Mass(0.15),
            Radius(0.07),
            skin.clone(),
            Look::color(color).roughness(0.3),
            Transform::from_translation(at),
        ));
    }
}
