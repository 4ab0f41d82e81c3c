//! Balls of different density, dropped into water.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::look::Look;
use crate::props::{curve, mesh};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::ball;

pub(super) const SCENE: Scene = Scene {
    name: "buoys",
    heading: Heading::Forces,
    title: "Floating balls",
    about: "from cork to stone: each ball floats as deep as its density requires, and one sinks",
    eye: Vec3::new(0.4, 1.8, 5.6),
    target: Vec3::new(0.0, 0.55, 0.0),
    seconds: 6.0,
    moment: 1.4,
    lesson: Some(Lesson {
        try_this: "make the red ball or the water denser: it comes to rest where it displaces its own weight of water",
        watch: "the ball bobs until its lowest point is at the red mark; half as dense as water, it floats with its centre at the surface",
        formula: "x² (3 − x) / 4 = ρ_ball / ρ_water, with x = depth / radius",
        sliders: &[
            SceneSlider { label: "Density", unit: "kg/m³", range: [150.0, 780.0], default: 500.0 },
            SceneSlider { label: "Radius", unit: "m", range: [0.12, 0.26], default: 0.22 },
            SceneSlider { label: "Water", unit: "kg/m³", range: [800.0, 1200.0], default: 1000.0 },
        ],
        number: "Depth of the red ball",
        unit: "mm",
        after: 5.0,
        measure: |world| {
            let ball: Particle = component_of(world, "red ball")?;
            let [_, radius, _] = values(world);
            Some(f64::from(LEVEL - (ball.position.y - radius)) * 1e3)
        },
        expect: |values, _| depth(values[0], values[1], values[2]) * 1e3,
        tolerance: [2.0, 0.01],
    }),
    spawn,
};

/// Height of the water, metres.
const LEVEL: f32 = 0.6;

/// Depth to which a ball sinks, metres: the root of the cubic, by bisection; the left side grows with the depth.
fn depth(density: f32, radius: f32, water: f32) -> f64 {
    let share = f64::from(density) / f64::from(water);
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..60 {
        let x = 0.5 * (low + high);
        if 0.25 * x * x * (3.0 - x) < share {
            low = x;
        } else {
            high = x;
        }
    }
    low * f64::from(radius)
}

fn spawn(world: &mut World) {
    let [red, red_radius, water] = values(world);
    // Strong air drag as well: it damps what is out of the water.
    world.insert_resource(AirDrag(0.5));
    world.spawn((InScene, Ground));
    // More drag than water has, so that the balls come to rest in a few seconds.
    let fluid = Fluid { drag: 0.95, density: water, ..default() };
    world.spawn((InScene, fluid, Transform::from_xyz(0.0, LEVEL, 0.0)));
    // Only the rear half of the water is drawn, cut through the middle of the balls, so that their depth is visible.
    let wide = 1.2;
    let back = mesh(world, Cuboid::new(5.4, LEVEL, wide));
    let blue = Look::color(0x2f86b5).roughness(0.08).opacity(0.62);
    world.spawn((InScene, back, blue, Transform::from_xyz(0.0, LEVEL * 0.5, -wide * 0.5)));
    for (i, density) in [100.0, 250.0, red, 750.0, 950.0, 1600.0].into_iter().enumerate() {
        let x = -2.1 + 0.84 * i as f32;
        // The red ball starts near its rest position, so that it settles soon.
        let soon = LEVEL + red_radius - 0.8 * depth(red, red_radius, water) as f32;
        let (radius, high) =
            if i == 2 { (red_radius, soon) } else { (0.22, 1.1 + 0.22 * i as f32) };
        let volume = 4.0 / 3.0 * core::f32::consts::PI * radius * radius * radius;
        let skin = mesh(world, ball(radius));
        let place = Vec3::new(x, high, 0.0);
        let look = if i == 2 {
            Look::color(0xd1495b).roughness(0.3)
        } else if density > 1000.0 {
            Look::color(0x6b6f76).roughness(0.9)
        } else {
            Look::texture("textures/ball.png").roughness(0.35)
        };
        world.spawn((
            InScene,
            Name::new(if i == 2 { "red ball" } else { "ball" }),
            Particle::at(place),
            Mass(density * volume),
            Radius(radius),
            Transform::from_translation(place),
            skin,
            look,
        ));
    }
    // The height at which the bottom of the red ball comes to rest by the formula.
    let foot = LEVEL - depth(red, red_radius, water) as f32;
    let mark = [-0.3, 0.3].map(|side| Vec3::new(-0.42 + side, foot, 0.01));
    curve(world, &mark, 0.008, Look::color(0xd0342c));
}
