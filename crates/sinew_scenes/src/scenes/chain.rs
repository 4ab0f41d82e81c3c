//! A chain of rope loops, linked into each other, with a weight at its end.

use bevy::prelude::*;
use bevy_sinew::TubeMesh;
use bevy_sinew::prelude::*;
use bevy_sinew::{Bound, ConstraintOf, ParticleBody, ParticleOf, RigidPose};

use super::{Scene, mesh};
use crate::{Heading, InScene, Look, ball};

pub(super) const SCENE: Scene = Scene {
    name: "chain",
    heading: Heading::Contacts,
    title: "A chain of loops",
    about: "loops of rope hang in each other by contact alone; the lowest carries a ball of two kilograms",
    eye: Vec3::new(1.9, 2.0, 4.4),
    target: Vec3::new(0.0, 1.8, 0.0),
    seconds: 5.0,
    moment: 1.6,
    lesson: None,
    spawn,
};

/// Loops, and particles of each.
const LOOPS: usize = 6;
const BEADS: usize = 28;
/// Radius of a loop and of its rope, metres. Neighbours overlap: nothing slips between two of them.
const RING: f32 = 0.19;
const ROPE: f32 = 0.03;

fn spawn(world: &mut World) {
    world.insert_resource(SolverConfig { substeps: 20, max_sweeps: 8, ..default() });
    world.insert_resource(AirDrag(0.3));
    world.spawn((InScene, Ground));
    let colors = [0xc9a66b, 0xb8434e, 0x3f6f9f];
    for n in 0..LOOPS {
        // Each hangs in the one above, a quarter turned, with some slack.
        let centre = Vec3::Y * (3.4 - n as f32 * (2.0 * RING - 2.6 * ROPE));
        let look = Look::color(colors[n % colors.len()]).roughness(0.9);
        link(world, centre, n % 2 == 1, n == 0, n == LOOPS - 1, look);
    }
}

fn link(world: &mut World, centre: Vec3, turned: bool, held: bool, last: bool, look: Look) {
    let body = world.spawn((InScene, Name::new("loop"), ParticleBody, look, Interpolate)).id();
    let place = |i: usize| {
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * i as f32 / BEADS as f32);
        let across = if turned { Vec3::Z } else { Vec3::X };
        centre + (across * sin + Vec3::Y * cos) * RING
    };
    let beads: Vec<Entity> = (0..BEADS)
        .map(|i| {
            let particle = (Particle::at(place(i)), Mass(0.01), Radius(ROPE), ParticleOf(body));
            world.spawn(particle).id()
        })
        .collect();
    if held {
        world.entity_mut(beads[0]).insert(Pinned::HERE);
    }
    for i in 0..BEADS {
        // The next one, and the one after it at half of the straight way at least: a rope does not fold sharply.
        let (next, second) = (beads[(i + 1) % BEADS], beads[(i + 2) % BEADS]);
        let (gap, wide) = (place(i).distance(place(i + 1)), place(i).distance(place(i + 2)));
        world.spawn((DistanceConstraint::new(beads[i], next, gap), ConstraintOf(body)));
        let apart =
            DistanceConstraint::new(beads[i], second, 0.85 * wide).with_bound(Bound::AtLeast);
        world.spawn((apart, ConstraintOf(body)));
    }
    let mut particles = beads.clone();
    particles.extend([beads[0], beads[1]]);
    world.entity_mut(body).insert(TubeMesh { particles, radius: ROPE, sides: 10 });
    if last {
        weight(world, beads[BEADS / 2], place(BEADS / 2));
    }
}

/// A ball on a short string.
fn weight(world: &mut World, bead: Entity, from: Vec3) {
    let centre = from - Vec3::Y * 0.22;
    let iron = mesh(world, ball(0.13));
    let body = world
        .spawn((
            InScene,
            Name::new("weight"),
            ParticleBody,
            iron,
            Look::color(0x555b61).metal(),
            Interpolate,
            Transform::from_translation(centre),
        ))
        .id();
    let ball = world.spawn((Particle::at(centre), Mass(2.0), Radius(0.13), ParticleOf(body))).id();
    world.spawn((DistanceConstraint::new(bead, ball, 0.22), ConstraintOf(body)));
    world.entity_mut(body).insert(RigidPose { particles: vec![ball], rest: vec![Vec3::ZERO] });
}
