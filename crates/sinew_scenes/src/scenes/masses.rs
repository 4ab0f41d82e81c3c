//! A rod that starts too long pulls two balls together: each moves by the other's share of the total mass.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ConstraintOf, ParticleBody, ParticleOf, TubeMesh};

use crate::arrow::Arrow;
use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "masses",
    heading: Heading::Constraints,
    title: "Equal and unequal masses",
    about: "pulled to the length of a rod, each ball moves by the other's share of the mass; a pinned one stays",
    eye: Vec3::new(0.1, 2.4, 4.3),
    target: Vec3::new(0.0, 0.25, 0.05),
    seconds: 3.0,
    moment: 0.4,
    lesson: Some(Lesson {
        try_this: "change the two masses of the pair in front: the barycentre, the white mark, stays where it is",
        watch: "the arrows are the remaining displacements, and the rings on the floor the rest positions by the formula; the sum of m d is zero in every correction",
        formula: "d_a = m_b/(m_a + m_b) (D − L), d_b = m_a/(m_a + m_b) (D − L)",
        sliders: &[
            SceneSlider { label: "Left mass", unit: "kg", range: [1.0, 8.0], default: 4.0 },
            SceneSlider { label: "Right mass", unit: "kg", range: [0.5, 4.0], default: 1.0 },
            SceneSlider { label: "Too long by", unit: "m", range: [0.5, 1.5], default: 1.2 },
        ],
        number: "Displacement of the left ball",
        unit: "mm",
        after: 2.0,
        measure: |world| {
            let ball: Particle = component_of(world, "left ball")?;
            let apart = f64::from(LENGTH) + f64::from(excess(world));
            Some((f64::from(ball.position.x) + 0.5 * apart) * 1e3)
        },
        expect: |values, seconds| {
            let [left, right, excess] = [values[0], values[1], values[2]].map(f64::from);
            // The part of the excess that a critically damped spring of this frequency has left.
            let turn = core::f64::consts::TAU * f64::from(HERTZ) * seconds;
            let left_over = (1.0 + turn) * libm::exp(-turn);
            right / (left + right) * excess * (1.0 - left_over) * 1e3
        },
        tolerance: [2.0, 0.01],
    }),
    spawn,
};

/// Length of a rod, metres, and its frequency as a soft constraint, Hz.
const LENGTH: f32 = 1.0;
const HERTZ: f32 = 0.7;

/// The rest of the displacement that the formula predicts for a ball, as an arrow.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Remaining {
    /// Rest position of the ball, metres.
    to: Vec3,
    /// Height of the arrow over the centre of the ball, metres.
    above: f32,
    arrow: Arrow,
}

/// Draws the remaining displacements.
pub(crate) fn draw_remaining(
    balls: Query<(&Remaining, &Particle)>,
    mut drawn: Query<&mut Transform>,
) {
    for (way, ball) in &balls {
        let left = [ball.position, way.to].map(|end| end + Vec3::Y * way.above);
        let worth = left[0].distance(left[1]) > 0.01;
        way.arrow.point(&mut drawn, worth.then_some(left));
    }
}

/// Initial excess length of the rods, metres.
fn excess(world: &World) -> f32 {
    let [_, _, excess] = values(world);
    excess
}

/// Radius of a ball of this mass, kg, in metres: all have the same density.
fn radius(mass: f32) -> f32 {
    0.1 * libm::cbrtf(mass)
}

fn spawn(world: &mut World) {
    let [left, right, excess] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    floor(world, Vec2::new(4.2, 2.7), Look::color(0x2f5d50).roughness(0.95));
    pair(world, ["left ball", "right ball"], 0.85, [left, right], excess, false);
    pair(world, ["equal left", "equal right"], 0.0, [1.0, 1.0], excess, false);
    pair(world, ["held", "free"], -0.8, [1.0, 1.0], excess, true);
}

/// Two balls in a lane, and marks where they come to rest.
fn pair(
    world: &mut World,
    names: [&'static str; 2],
    z: f32,
    masses: [f32; 2],
    excess: f32,
    pinned: bool,
) {
    let half = 0.5 * (LENGTH + excess);
    let share = if pinned { 0.0 } else { masses[1] / (masses[0] + masses[1]) };
    let high = FLOOR + 0.24;
    let rod = Look::color(0xd8dee9).metal();
    let body = world.spawn((InScene, ParticleBody, rod, Interpolate)).id();
    let places = [-half, half];
    let rests = [-half + share * excess, half - (1.0 - share) * excess];
    let colors = if pinned { [0x3a3f47, 0xe9b44c] } else { [0x3d7ea6, 0xe9b44c] };
    let balls = [0, 1].map(|i| {
        let (at, look) = (Vec3::new(places[i], high, z), Look::color(colors[i]).roughness(0.25));
        let size = radius(masses[i]);
        let ring = mesh(world, Torus::new(size, size + 0.03));
        let mark =
            Transform::from_xyz(rests[i], FLOOR + 0.01, z).with_scale(Vec3::new(1.0, 0.4, 1.0));
        world.spawn((InScene, ring, look.clone(), mark));
        let skin = mesh(world, ball(size));
        let particle = (Particle::at(at), Mass(masses[i]), Radius(size), ParticleOf(body));
        let drawn = (Transform::from_translation(at), skin, look);
        let arrow = Arrow::spawn(world, 0.016, Look::color(0xd9622b).roughness(0.5));
        let way = Remaining { to: at.with_x(rests[i]), above: size + 0.06, arrow };
        let mut ball = world.spawn((Name::new(names[i]), particle, drawn, way));
        if pinned && i == 0 {
            ball.insert(Pinned::HERE);
        }
        ball.id()
    });
    if pinned {
        let stand = mesh(world, cylinder(0.05, high - FLOOR));
        let at = Transform::from_xyz(places[0], FLOOR + 0.5 * (high - FLOOR), z);
        world.spawn((InScene, stand, Look::color(0x3a3f47), at));
    } else {
        let centre = (masses[0] * places[0] + masses[1] * places[1]) / (masses[0] + masses[1]);
        let post = mesh(world, rounded_box(Vec3::new(0.025, 0.12, 0.4), 0.01, 2));
        let at = Transform::from_xyz(centre, FLOOR + 0.06, z);
        world.spawn((InScene, post, Look::color(0xf3f1ea), at));
    }
    let softness = Softness::frequency(HERTZ, 1.0);
    let rod = DistanceConstraint::new(balls[0], balls[1], LENGTH).with_softness(softness);
    world.spawn((rod, ConstraintOf(body)));
    let line = TubeMesh { particles: balls.to_vec(), radius: 0.02, sides: 8 };
    world.entity_mut(body).insert(line);
}
