//! Three blocks sliding on a plane: without friction, with planar friction (a fraction of the velocity per second), and with Coulomb friction.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Combine, GroundDrag};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::rounded_box;

pub(super) const SCENE: Scene = Scene {
    name: "planar",
    heading: Heading::Contacts,
    title: "Planar friction",
    about: "each second blue loses a fraction of its speed, orange a fixed amount, grey nothing; marks show where they stop",
    eye: Vec3::new(0.2, 2.9, 5.4),
    target: Vec3::new(0.1, 0.25, 0.0),
    seconds: 4.0,
    moment: 1.3,
    lesson: Some(Lesson {
        try_this: "throw the blocks faster: twice the speed goes twice as far by planar friction, four times as far by Coulomb's",
        watch: "orange stops dead on its mark; blue slows down by a fraction, approaches its mark and never quite reaches it",
        formula: "v = v₀ (1 − d)^t by planar friction, v₀ − μ g t by Coulomb's",
        sliders: &[
            SceneSlider { label: "Speed", unit: "m/s", range: [1.0, 2.6], default: 2.2 },
            SceneSlider { label: "Loss per second", unit: "", range: [0.45, 0.9], default: 0.6 },
            SceneSlider { label: "Friction", unit: "", range: [0.08, 0.3], default: 0.1 },
        ],
        number: "Speed of the blue block",
        unit: "m/s",
        after: 1.5,
        measure: |world| {
            let velocity: LinearVelocity = component_of(world, "planar friction")?;
            Some(f64::from(velocity.0.x))
        },
        expect: |values, seconds| {
            f64::from(values[0]) * libm::pow(1.0 - f64::from(values[1]), seconds)
        },
        tolerance: [2e-3, 0.01],
    }),
    spawn,
};

/// Size of a block, metres, and where the blocks start along x.
const BLOCK: Vec3 = Vec3::new(0.4, 0.26, 0.4);
const START: f32 = -2.5;
/// Half the length of the board, metres.
const HALF: f32 = 3.0;

fn spawn(world: &mut World) {
    let [speed, lost, friction] = values(world);
    world.insert_resource(AirDrag(0.0));
    let board = floor(world, Vec2::new(2.0 * HALF, 2.6), Look::color(0xbcd3dc).roughness(0.15));
    // Friction 1: the combination rule is the product, so that a contact has the friction of the block.
    world.entity_mut(board).insert(SurfaceMaterial::new(1.0));
    let wood = Look::color(0x6d5138).roughness(0.8);
    let rail = mesh(world, rounded_box(Vec3::new(2.0 * HALF, 0.05, 0.05), 0.015, 2));
    for z in [-1.2, -0.4, 0.4, 1.2] {
        let at = Transform::from_xyz(0.0, FLOOR + 0.025, z);
        world.spawn((InScene, rail.clone(), wood.clone(), at));
    }
    // A stop for the block without friction.
    let size = Vec3::new(0.16, 0.4, 2.5);
    let stop = (Collider::cuboid(size), mesh(world, rounded_box(size, 0.02, 2)));
    let at = Transform::from_xyz(HALF - 0.08, FLOOR + 0.5 * size.y, 0.0);
    world.spawn((InScene, stop, wood, at));
    let skin = mesh(world, rounded_box(BLOCK, 0.03, 3));
    let mark = mesh(world, Cuboid::new(0.03, 0.006, 0.7));
    let planar = GroundDrag { along: lost, across: 0.0 };
    let coulomb = speed * speed / (2.0 * 9.81 * friction);
    let blocks = [
        ("no friction", -0.8, 0.0, GroundDrag::default(), 0x8d99ae, None),
        // The integral of v₀ (1 - d)ᵗ is v₀ / -ln(1 - d).
        ("planar friction", 0.0, 0.0, planar, 0x2e6f9e, Some(speed / -libm::logf(1.0 - lost))),
        ("Coulomb's friction", 0.8, friction, GroundDrag::default(), 0xd9622b, Some(coulomb)),
    ];
    for (name, z, friction, drag, color, way) in blocks {
        let rule = Combine::Multiply;
        let surface =
            SurfaceMaterial { drag, friction_rule: rule, ..SurfaceMaterial::new(friction) };
        let look = Look::color(color).roughness(0.4);
        if let Some(way) = way {
            // Where the front of the block stops.
            let at = Transform::from_xyz(START + way + 0.5 * BLOCK.x, FLOOR + 0.003, z);
            world.spawn((InScene, mark.clone(), look.clone(), at));
        }
        world.spawn((
            InScene,
            Name::new(name),
            RigidBox::new(BLOCK).with_mass(2.0),
            surface,
            LinearVelocity(Vec3::X * speed),
            skin.clone(),
            look,
            Interpolate,
            Transform::from_xyz(START, FLOOR + 0.5 * BLOCK.y, z),
        ));
    }
}
