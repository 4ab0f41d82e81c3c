//! Planets around a sun: an attractor gives elliptic orbits without any code for ellipses.

use bevy::prelude::*;
use bevy_sinew::Attractor;
use bevy_sinew::TubeMesh;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::mesh;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "orbits",
    heading: Heading::Integration,
    title: "Orbits",
    about: "each planet stays on its Kepler ellipse; the red one has the same period as the green one, but comes as close as a fifth of its farthest distance",
    eye: Vec3::new(0.0, 4.3, 4.3),
    target: Vec3::new(-0.1, 1.15, 0.15),
    seconds: 7.0,
    moment: 2.2,
    lesson: Some(Lesson {
        try_this: "make the red planet's ellipse longer or rounder, or the sun heavier: the period is 2π √(a³/GM), whatever the eccentricity",
        watch: "red is fast near the sun and slow far from it, and yet completes its orbit with green, whose circle is as wide as red's ellipse is long",
        formula: "r = a (1 − e cos E), with E − e sin E = t √(GM/a³)",
        sliders: &[
            SceneSlider { label: "GM", unit: "m³/s²", range: [2.0, 6.0], default: 4.0 },
            SceneSlider { label: "Half axis", unit: "m", range: [0.9, 1.4], default: 1.25 },
            SceneSlider { label: "Eccentricity", unit: "", range: [0.0, 0.8], default: 2.0 / 3.0 },
        ],
        number: "Sun to the red planet",
        unit: "m",
        after: 3.0,
        measure: |world| {
            let mut red = world.query_filtered::<&Particle, With<Red>>();
            red.iter(world).next().map(|red| f64::from(red.position.distance(SUN)))
        },
        expect: |values, seconds| {
            let [strength, axis, e] = [values[0], values[1], values[2]].map(f64::from);
            let mean = seconds * libm::sqrt(strength / (axis * axis * axis));
            axis * (1.0 - e * libm::cos(eccentric_anomaly(e, mean)))
        },
        tolerance: [2e-3, 5e-3],
    }),
    spawn,
};

/// Position of the sun, metres.
const SUN: Vec3 = Vec3::new(0.0, 1.3, 0.0);
/// Number of particles of a drawn orbit.
const BEADS: usize = 96;
/// Colour of the planet whose ellipse the sliders change.
const RED: u32 = 0xd1495b;

/// The planet whose ellipse the sliders change.
#[derive(Component, Clone, Copy, Debug)]
struct Red;

/// The root of Kepler's equation `E - e sin E = mean`, radians, by bisection; its left side grows with E.
fn eccentric_anomaly(eccentricity: f64, mean: f64) -> f64 {
    let (mut low, mut high) = (mean - 1.0, mean + 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if middle - eccentricity * libm::sin(middle) < mean {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

fn spawn(world: &mut World) {
    let [strength, red_axis, red_eccentricity] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    let skin = mesh(world, ball(0.16));
    let gold = Look::color(0xffc94d).roughness(0.4);
    world.spawn((
        InScene,
        Name::new("sun"),
        Attractor::new(strength).with_softening(0.0),
        skin,
        gold,
        Transform::from_translation(SUN),
    ));
    // Semi-major axis in metres, eccentricity, direction of the perihelion and tilt of the plane in radians, radius in metres, colour.
    let planets = [
        (0.45, 0.0, 0.0, 0.1, 0.045, 0x8d99ae),
        (0.8, 0.0, 2.0, -0.05, 0.07, 0x3d7ea6),
        (1.25, 0.0, 4.0, 0.08, 0.08, 0x66a182),
        (red_axis, red_eccentricity, 0.6, -0.25, 0.06, RED),
        (1.75, 0.1, 5.2, 0.03, 0.11, 0xd9a441),
    ];
    for (axis, eccentricity, turn, tilt, radius, color) in planets {
        let plane = Quat::from_rotation_z(tilt) * Quat::from_rotation_y(turn);
        let look = Look::color(color).roughness(0.4);
        let orbit = path(world, axis, eccentricity, plane);
        let thread = TubeMesh { particles: orbit, radius: 0.009, sides: 5 };
        world.spawn((InScene, thread, look.clone()));
        // It starts at the perihelion, nearest and fastest: v² = GM (1 + e) / (a (1 - e)).
        let place = SUN + plane * Vec3::X * (axis * (1.0 - eccentricity));
        let speed = (strength / axis * (1.0 + eccentricity) / (1.0 - eccentricity)).sqrt();
        let skin = mesh(world, ball(radius));
        let mut planet = world.spawn((
            InScene,
            Name::new("planet"),
            Particle::at(place).with_velocity(plane * Vec3::NEG_Z * speed),
            Transform::from_translation(place),
            skin,
            look,
        ));
        if color == RED {
            planet.insert(Red);
        }
    }
}

/// The ellipse with the sun in one focus, as pinned particles for a tube mesh.
fn path(world: &mut World, axis: f32, eccentricity: f32, plane: Quat) -> Vec<Entity> {
    let across = axis * (1.0 - eccentricity * eccentricity).sqrt();
    let bead = |i: usize| {
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * i as f32 / BEADS as f32);
        let place = SUN + plane * Vec3::new(axis * (cos - eccentricity), 0.0, -across * sin);
        world.spawn((InScene, Particle::at(place), Pinned::HERE)).id()
    };
    let mut beads: Vec<Entity> = (0..BEADS).map(bead).collect();
    beads.push(beads[0]);
    beads
}
