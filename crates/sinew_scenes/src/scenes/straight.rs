//! Beads kept on a line and corners kept in a plane, beside the same bodies without these constraints.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    CollinearConstraint, ConstraintOf, CoplanarConstraint, Drag, MeshFollow, ParticleBody,
    ParticleOf, TubeMesh,
};

use super::pendulums::swing;
use crate::look::Look;
use crate::props::{FLOOR, floor, mesh, post};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "straight",
    heading: Heading::Constraints,
    title: "Collinear and coplanar",
    about: "blue: beads kept on a line, corners kept in a plane; orange: without these constraints the line bends and the square folds",
    eye: Vec3::new(0.9, 1.9, 4.6),
    target: Vec3::new(0.05, 1.05, 0.0),
    seconds: 4.0,
    moment: 1.1,
    lesson: Some(Lesson {
        try_this: "change the two masses: the heavier the upper bead, the faster the straight pendulum swings",
        watch: "blue swings as one rod, with the period that its two masses give; orange bends and soon moves chaotically",
        formula: "ω² = g Σ m l / Σ m l²",
        sliders: &[
            SceneSlider { label: "Angle", unit: "°", range: [10.0, 60.0], default: 35.0 },
            SceneSlider { label: "Upper mass", unit: "kg", range: [0.3, 4.0], default: 1.0 },
            SceneSlider { label: "Lower mass", unit: "kg", range: [0.3, 4.0], default: 1.0 },
        ],
        number: "Angle of the straight pendulum",
        unit: "°",
        after: 1.5,
        measure: |world| {
            let bead: Particle = component_of(world, "straight lower bead")?;
            let (across, down) = (bead.position.x - STRAIGHT, TOP - bead.position.y);
            Some(libm::atan2(f64::from(across), f64::from(down)).to_degrees())
        },
        expect: |values, seconds| {
            let masses = [values[1], values[2]].map(f64::from);
            let moment = |power: i32| {
                let at = |i: usize| masses[i] * f64::from(BEADS[i]).powi(power);
                at(0) + at(1)
            };
            let rate = libm::sqrt(9.81 * moment(1) / moment(2));
            swing(f64::from(values[0]).to_radians(), rate * seconds).to_degrees()
        },
        tolerance: [0.5, 0.03],
    }),
    spawn,
};

/// Height of the hooks, and distances of the beads from them, metres.
const TOP: f32 = 1.8;
const BEADS: [f32; 2] = [0.5, 1.1];
/// Where the straight and the free pendulum hang along x, metres.
const STRAIGHT: f32 = -1.3;
const FREE: f32 = -0.1;
/// Position of the squares, and half a diagonal of one, metres.
const SQUARES: Vec3 = Vec3::new(1.35, 1.1, 0.0);
const HALF: f32 = 0.5;

fn spawn(world: &mut World) {
    let [degrees, upper, lower] = values(world);
    world.insert_resource(AirDrag(0.0));
    floor(world, Vec2::new(4.8, 2.6), Look::color(0x54606b).roughness(0.8));
    let wood = Look::color(0x8a6a4b).roughness(0.9);
    let lying = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2);
    let beam = post(world, 0.03, 2.2);
    let at = Transform::from_xyz(-0.7, TOP + 0.03, -0.25).with_rotation(lying);
    world.spawn((InScene, beam, wood.clone(), at));
    let leg = post(world, 0.035, TOP + 0.06 - FLOOR);
    for x in [-1.8, 0.4] {
        let at = Transform::from_xyz(x, FLOOR + 0.5 * (TOP + 0.06 - FLOOR), -0.25);
        world.spawn((InScene, leg.clone(), wood.clone(), at));
    }
    let turned = Quat::from_rotation_z(degrees.to_radians());
    for (straight, x, color) in [(true, STRAIGHT, 0x3d7ea6), (false, FREE, 0xd9622b)] {
        let hook = Vec3::new(x, TOP, 0.0);
        let look = Look::color(color).roughness(0.3);
        let body = world.spawn((InScene, ParticleBody, look.clone(), Interpolate)).id();
        let mut beads =
            vec![world.spawn((Particle::at(hook), Pinned::HERE, ParticleOf(body))).id()];
        let mut above = 0.0;
        for (i, mass) in [upper, lower].into_iter().enumerate() {
            let at = hook + turned * Vec3::NEG_Y * BEADS[i];
            let skin = mesh(world, ball(0.075 * libm::cbrtf(mass)));
            let drawn = (Transform::from_translation(at), skin, look.clone());
            let bead = world.spawn((Particle::at(at), Mass(mass), ParticleOf(body), drawn)).id();
            if straight && i == 1 {
                world.entity_mut(bead).insert(Name::new("straight lower bead"));
            }
            let rod = DistanceConstraint::new(beads[i], bead, BEADS[i] - above);
            world.spawn((rod, ConstraintOf(body)));
            above = BEADS[i];
            beads.push(bead);
        }
        if straight {
            world.spawn((CollinearConstraint::new(beads.clone()), ConstraintOf(body)));
        }
        let line = TubeMesh { particles: beads, radius: 0.014, sides: 8 };
        world.entity_mut(body).insert(line);
    }
    square(world, SQUARES.with_z(0.6), true, 0x3d7ea6);
    square(world, SQUARES.with_z(-0.6), false, 0xd9622b);
}

/// A horizontal square, pinned at two opposite corners. Its edges keep their lengths, but it can fold along the diagonal between these corners.
fn square(world: &mut World, middle: Vec3, flat: bool, color: u32) {
    let corners = [Vec3::NEG_X, Vec3::NEG_Z, Vec3::X, Vec3::Z].map(|out| middle + out * HALF);
    let look = Look::color(color).roughness(0.5).double_sided();
    let body = world.spawn((InScene, ParticleBody, look, Interpolate)).id();
    let stand = post(world, 0.03, middle.y - FLOOR);
    let particles = [0, 1, 2, 3].map(|i| {
        let mut corner = world.spawn((Particle::at(corners[i]), Drag(0.6), ParticleOf(body)));
        if i % 2 == 0 {
            corner.insert(Pinned::HERE);
        }
        corner.id()
    });
    for i in 0..4 {
        let edge =
            DistanceConstraint::new(particles[i], particles[(i + 1) % 4], HALF * 2.0_f32.sqrt());
        world.spawn((edge, ConstraintOf(body)));
    }
    if flat {
        world.spawn((CoplanarConstraint::new(particles), ConstraintOf(body)));
    }
    for corner in [corners[0] - Vec3::X * 0.03, corners[2] + Vec3::X * 0.03] {
        let under = Transform::from_translation(corner.with_y(FLOOR + 0.5 * (middle.y - FLOOR)));
        world.spawn((InScene, stand.clone(), Look::color(0xb9bec6).metal(), under));
    }
    let order = [0, 3, 2, 0, 2, 1];
    let skin = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            corners.map(|corner| corner.to_array()).to_vec(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; 4])
        .with_inserted_indices(Indices::U32(order.to_vec()));
    let skin = mesh(world, skin);
    world.entity_mut(body).insert((skin, MeshFollow { vertices: particles.to_vec() }));
}
