//! Sheets that sink through still air, each at the terminal speed of its weight, and one that a fan blows away.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{AirFlow, Region};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::nth_component_of;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};

pub(super) const SCENE: Scene = Scene {
    name: "feathers",
    heading: Heading::Forces,
    title: "Falling through air",
    about: "four times the weight falls twice as fast: √(2σg/ρC) for sheets of 0.1, 0.4 and 1.6 kg/m²; the fourth passes a fan",
    eye: Vec3::new(-2.6, 6.4, 7.4),
    target: Vec3::new(0.25, 1.6, 0.0),
    seconds: 4.0,
    moment: 0.9,
    lesson: Some(Lesson {
        try_this: "make the orange sheet, the second, four times as heavy: it sinks twice as fast; its size drops out",
        watch: "a sheet gains speed until drag carries its weight; then all of it sinks at one speed and stays flat",
        formula: "v = v_t tanh(g t / v_t), with v_t = √(2σg / ρC)",
        sliders: &[
            SceneSlider { label: "Density", unit: "kg/m²", range: [0.2, 0.8], default: 0.4 },
            SceneSlider { label: "Edge", unit: "m", range: [0.6, 1.0], default: 0.9 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [3.7, 9.81], default: 9.81 },
        ],
        number: "Speed of the orange sheet",
        unit: "m/s",
        after: 0.6,
        measure: |world| {
            let velocity: LinearVelocity = nth_component_of(world, "sheet", 1)?;
            Some(f64::from(-velocity.0.y))
        },
        expect: |values, seconds| {
            let [density, gravity] = [values[0], values[2]].map(f64::from);
            let terminal = libm::sqrt(2.0 * density * gravity / (1.225 * 1.28));
            terminal * libm::tanh(gravity * seconds / terminal)
        },
        tolerance: [0.0, 0.03],
    }),
    spawn,
};

/// Edge of a sheet, and height from which it falls, metres.
const EDGE: f32 = 0.9;
const TOP: f32 = 4.0;
/// Position of the fan, metres.
const FAN: Vec3 = Vec3::new(1.15, 2.4, 0.0);

fn spawn(world: &mut World) {
    let [density, edge, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    // The `AirFlow` below does all the braking, by area and speed, instead of a fraction of the velocity.
    world.insert_resource(AirDrag(0.0));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.8)));
    world.spawn((InScene, Name::new("still air"), AirFlow::default()));
    world.spawn((
        InScene,
        Name::new("fan"),
        AirFlow::steady(Vec3::X * 5.0),
        Region::boxed(Vec3::new(2.6, 0.9, 1.6)).with_fade(0.2),
        Transform::from_translation(FAN + Vec3::X * 1.3),
    ));
    let blade = mesh(world, Cuboid::new(0.02, 0.74, 0.09));
    let (ring, stand) = (mesh(world, Torus::new(0.38, 0.46)), post(world, 0.04, 2.0));
    let upright = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    let metal = Look::color(0x6c757d).metal();
    let here = Transform::from_translation(FAN).with_rotation(upright);
    world.spawn((InScene, ring, metal.clone(), here));
    for turn in [0.4, 1.97] {
        let across = Transform::from_translation(FAN).with_rotation(Quat::from_rotation_x(turn));
        world.spawn((InScene, blade.clone(), metal.clone(), across));
    }
    world.spawn((InScene, stand, metal, Transform::from_translation(FAN.with_y(1.0))));
    let sheets = [
        (-2.4, 0.1, EDGE, 0xe9b44c),
        (-1.2, density, edge, 0xe07a5f),
        (0.0, 1.6, EDGE, 0x8d4b62),
        (FAN.x + 0.75, 0.1, EDGE, 0x3d7ea6),
    ];
    for (x, density, edge, color) in sheets {
        world.spawn((
            InScene,
            Name::new("sheet"),
            Cloth { density, ..Cloth::grid(edge, edge, 12, 12) },
            Look::color(color).double_sided().roughness(0.8),
            Interpolate,
            Transform::from_xyz(x, TOP, 0.0)
                .with_rotation(Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2)),
        ));
    }
}
