//! Coarse ropes that fall across a thin rail and across each other. One half of the scene collides by particles, the other by segments.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyContacts, BodyParticles, TubeMesh};
use bevy_sinew::{ConstraintOf, ContactShape, ParticleBody, ParticleOf};

use crate::look::Look;
use crate::props::{mesh, post};
use crate::readings::entities_named;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{ball, cylinder};

pub(super) const SCENE: Scene = Scene {
    name: "rails",
    heading: Heading::Contacts,
    title: "Over rails and ropes",
    about: "on the left ropes collide by their particles, and rail and line pass between them; on the right by their segments, and they hang",
    eye: Vec3::new(1.0, 1.95, 4.5),
    target: Vec3::new(0.05, 0.98, 0.0),
    seconds: 5.0,
    moment: 3.2,
    lesson: Some(Lesson {
        try_this: "make the rails thinner or thicker, the ropes heavier, or the gravity stronger",
        watch: "on the right a rope is a row of capsules: wherever the rail touches it, also between two particles, it hangs at the sum of both radii",
        formula: "d = r_rail + r_rope, from line to line",
        sliders: &[
            SceneSlider { label: "Rail radius", unit: "mm", range: [10.0, 30.0], default: 18.0 },
            SceneSlider {
                label: "Mass per particle",
                unit: "g",
                range: [5.0, 60.0],
                default: 20.0,
            },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [3.7, 15.0], default: 9.81 },
        ],
        number: "Rail to the nearest rope",
        unit: "mm",
        after: 1.5,
        measure: |world| {
            let mut nearest: Option<f64> = None;
            for rope in entities_named(world, "rope") {
                let Some(particles) = world.get::<BodyParticles>(rope) else { continue };
                let at = |p: Entity| world.get::<Particle>(p).map(|p| p.position);
                let points: Vec<Vec3> = particles.iter().filter_map(at).collect();
                for pair in points.windows(2).filter(|pair| pair[0].x > 0.0) {
                    let apart = f64::from(off_the_rail(pair[0], pair[1]));
                    nearest = Some(nearest.map_or(apart, |nearest| nearest.min(apart)));
                }
            }
            Some(nearest? * 1e3)
        },
        expect: |values, _| f64::from(values[0]) + f64::from(ROPE_RADIUS) * 1e3,
        tolerance: [1.0, 0.0],
    }),
    spawn,
};

/// Half the width and half the depth of a frame, and heights of its rail and its line, metres.
const WIDE: f32 = 0.85;
const DEEP: f32 = 0.55;
const RAIL: f32 = 1.75;
const LINE: f32 = 1.3;
/// Length of a segment, and radius of the ropes, metres: six radii from one particle to the next.
const PIECE: f32 = 0.11;
const ROPE_RADIUS: f32 = 0.018;
/// Radius of a weight, and its distance from the end of its rope, metres: large enough that the two do not touch.
const BALL: f32 = 0.06;
const TIE: f32 = BALL + 2.0 * ROPE_RADIUS;

/// Distance of a rope segment from the axis of the rails, metres.
fn off_the_rail(a: Vec3, b: Vec3) -> f32 {
    // The axis is along x.
    let (a, b) = (Vec2::new(a.y - RAIL, a.z + DEEP), Vec2::new(b.y - RAIL, b.z + DEEP));
    let along = b - a;
    let share = (-a.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
    (a + along * share).length()
}

fn spawn(world: &mut World) {
    let [_, _, gravity] = values(world);
    world.insert_resource(Gravity(Vec3::NEG_Y * gravity));
    world.insert_resource(AirDrag(0.2));
    world.spawn((InScene, Ground, SurfaceMaterial::new(0.5)));
    for (x, shape) in [(-1.15, ContactShape::Particles), (1.15, ContactShape::Segments)] {
        let contacts = BodyContacts::default().shaped(shape);
        frame(world, x);
        over_the_rail(world, x, contacts);
        over_a_line(world, x, contacts);
    }
}

/// Posts, and a rail between the two rear ones.
fn frame(world: &mut World, x: f32) {
    let wood = Look::color(0x8a6a4b).roughness(0.9);
    for (side, z, height) in
        [(-WIDE, -DEEP, RAIL), (WIDE, -DEEP, RAIL), (-WIDE, DEEP, LINE), (WIDE, DEEP, LINE)]
    {
        let post = post(world, 0.03, height + 0.04);
        let foot = Vec3::new(x + side, 0.5 * height + 0.02, z);
        world.spawn((InScene, post, wood.clone(), Transform::from_translation(foot)));
    }
    let [thick, ..]: [f32; 3] = values(world);
    let thick = thick * 1e-3;
    let rod = mesh(world, cylinder(thick, 2.0 * WIDE));
    let along = Transform::from_xyz(x, RAIL, -DEEP)
        .with_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_2));
    let steel = Look::color(0xb9bec4).metal();
    world.spawn((
        InScene,
        Name::new("rail"),
        Collider::capsule(thick, 2.0 * WIDE),
        rod,
        steel,
        along,
    ));
}

/// Ropes of several lengths that fall across the rail.
fn over_the_rail(world: &mut World, x: f32, contacts: BodyContacts) {
    let colors = [0xd1495b, 0xe9b44c, 0x66a182, 0x2f8f83, 0x8e6bb0];
    for (n, color) in colors.into_iter().enumerate() {
        // An odd number of segments, so that the rail touches the middle of one.
        let (i, pieces) = (n as f32 - 2.0, 9 + 2 * (n * 2 % 3));
        let middle = Vec3::new(x + 0.27 * i, RAIL + 0.08 + 0.03 * n as f32, -DEEP);
        let along = Vec3::new(0.1 * i, 0.0, 1.0).normalize();
        let from = middle - along * (0.5 * PIECE * pieces as f32);
        rope(world, (from, along), pieces, contacts, color);
    }
}

/// A slack line between the front posts, and ropes across it with a weight at each end.
fn over_a_line(world: &mut World, x: f32, contacts: BodyContacts) {
    let ends = [-WIDE, WIDE].map(|side| Vec3::new(x + side, LINE, DEEP));
    let line = Rope { segments: 17, mass: 0.4, radius: ROPE_RADIUS, slack: 0.1, ..default() };
    let line = Rope { from: ends[0], to: ends[1], pin_end: true, ..line };
    let hemp = Look::color(0xc9a66b).roughness(0.9);
    world.spawn((InScene, Name::new("line"), line, contacts, hemp, Interpolate));
    let iron = mesh(world, ball(BALL));
    for (place, color) in [(-0.3, 0xb8434e), (0.32, 0x3f6f9f)] {
        let middle = Vec3::new(x + place, LINE + 0.2 + 0.2 * place, DEEP);
        let from = middle - Vec3::Z * (2.5 * PIECE);
        let particles = rope(world, (from, Vec3::Z), 5, contacts, color);
        for (end, way) in [(particles[0], -1.0), (particles[5], 1.0)] {
            let at = middle + Vec3::Z * (way * (2.5 * PIECE + TIE));
            weight(world, (end, at), iron.clone());
        }
    }
}

/// A coarse rope from a point along a direction; returns its particles.
fn rope(
    world: &mut World,
    (from, along): (Vec3, Vec3),
    pieces: usize,
    contacts: BodyContacts,
    color: u32,
) -> Vec<Entity> {
    let [_, mass, _] = values(world);
    let name = Name::new("rope");
    let look = Look::color(color).roughness(0.9);
    let body = world.spawn((InScene, name, ParticleBody, contacts, look, Interpolate)).id();
    let particle = |i: usize| {
        let at = from + along * (PIECE * i as f32);
        (Particle::at(at), Mass(mass * 1e-3), Radius(ROPE_RADIUS), ParticleOf(body))
    };
    let particles: Vec<Entity> = (0..=pieces).map(|i| world.spawn(particle(i)).id()).collect();
    for pair in particles.windows(2) {
        world.spawn((DistanceConstraint::new(pair[0], pair[1], PIECE), ConstraintOf(body)));
    }
    let tube = TubeMesh { particles: particles.clone(), radius: ROPE_RADIUS, ..default() };
    world.entity_mut(body).insert(tube);
    particles
}

/// A ball tied to the end of a rope.
fn weight(world: &mut World, (end, at): (Entity, Vec3), skin: Mesh3d) {
    let weight = (
        InScene,
        Name::new("weight"),
        Particle::at(at),
        Mass(0.4),
        Radius(BALL),
        skin,
        Look::color(0x555b61).metal(),
        Transform::from_translation(at),
    );
    let ball = world.spawn(weight).id();
    world.spawn((InScene, DistanceConstraint::new(end, ball, TIE)));
}
