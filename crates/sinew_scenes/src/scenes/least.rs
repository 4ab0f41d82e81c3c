//! Of all displacements that satisfy a constraint, the solver chooses the one with the smallest sum of mass times squared displacement.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ConstraintOf, ParticleBody, ParticleOf, SinewClock, TubeMesh};

use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "least",
    heading: Heading::Constraints,
    title: "The least displacement",
    about: "five ways to bring two balls to the length of a rod; the bars are Σ m d²: gold, in front, is the solver's and the shortest",
    eye: Vec3::new(0.1, 3.0, 4.6),
    target: Vec3::new(0.05, 0.1, 0.08),
    seconds: 4.0,
    moment: 2.5,
    lesson: Some(Lesson {
        try_this: "make the masses equal: then the second way, half each, is also the solver's; make the left ball heavy: moving it alone costs most",
        watch: "every row satisfies the constraint in the end; they differ in how far each ball moves, and no bar is shorter than the golden one: the white line marks its end",
        formula: "least Σ m d² with C(p + d) = 0: d = −w ∇C C/Σ w |∇C|², for a rod m₁ m₂ C²/(m₁ + m₂)",
        sliders: &[
            SceneSlider { label: "Left mass", unit: "kg", range: [1.0, 8.0], default: 4.0 },
            SceneSlider { label: "Right mass", unit: "kg", range: [1.0, 4.0], default: 1.5 },
            SceneSlider { label: "Too long by", unit: "m", range: [0.5, 1.2], default: 1.0 },
        ],
        number: "Σ m d² of the solver",
        unit: "kg·m²",
        after: 2.0,
        measure: |world| {
            let cost: Cost = component_of(world, "solver")?;
            Some(cost.now)
        },
        expect: |values, seconds| {
            let [left, right, excess] = [values[0], values[1], values[2]].map(f64::from);
            // The part of the excess that a critically damped rod of this frequency has removed.
            let turn = core::f64::consts::TAU * f64::from(HERTZ) * seconds;
            let gone = excess * (1.0 - (1.0 + turn) * libm::exp(-turn));
            left * right / (left + right) * gone * gone
        },
        tolerance: [2e-3, 0.02],
    }),
    spawn,
};

/// Length of a rod, metres, and its frequency as a soft constraint, Hz: slow enough to watch.
const LENGTH: f32 = 0.9;
const HERTZ: f32 = 0.7;
/// Where the bars start along x, and length of the longest, metres.
const BARS: f32 = 0.7;
const LONGEST: f32 = 1.4;
/// Where the middles of the pairs are along x, metres.
const PAIRS: f32 = -0.75;

/// The sum of mass times squared displacement of two balls, and the bar that shows it.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Cost {
    balls: [Entity; 2],
    /// Initial positions, metres, and true masses, kg, whatever masses the solver uses.
    from: [Vec3; 2],
    masses: [f32; 2],
    /// Length of the bar, metres for each kg·m².
    scale: f32,
    /// Current value, kg·m².
    now: f64,
}

/// Updates the sums and the lengths of their bars.
pub(crate) fn draw_costs(
    clock: Res<SinewClock>,
    particles: Query<&Particle>,
    mut costs: Query<(&mut Cost, &mut Transform)>,
) {
    for (mut cost, mut drawn) in &mut costs {
        let part = |i: usize| {
            let at = particles.get(cost.balls[i]).map_or(cost.from[i], |ball| ball.position);
            f64::from(cost.masses[i]) * f64::from(at.distance_squared(cost.from[i]))
        };
        cost.now = if clock.tick > 0 { part(0) + part(1) } else { 0.0 };
        drawn.scale.x = (cost.scale * cost.now as f32).max(1e-3);
        drawn.translation.x = BARS + 0.5 * drawn.scale.x;
    }
}

fn spawn(world: &mut World) {
    let [left, right, excess] = values(world);
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    floor(world, Vec2::new(4.5, 2.9), Look::color(0x39465c).roughness(0.9));
    let own = right / (left + right);
    // Fraction of the total displacement that the left ball takes.
    let rows = [
        ("solver", own, 0xe9b44c),
        ("halves", 0.5, 0x5f9e6e),
        ("masses the wrong way round", 1.0 - own, 0x8f6fb0),
        ("right alone", 0.0, 0x3d7ea6),
        ("left alone", 1.0, 0xd1495b),
    ];
    let cost_of = |share: f32| {
        let [a, b] = [share * excess, (1.0 - share) * excess];
        left * a * a + right * b * b
    };
    let most = rows.iter().map(|&(_, share, _)| cost_of(share)).fold(0.0, f32::max);
    let half = 0.5 * (LENGTH + excess);
    let size = [left, right].map(|mass| 0.095 * libm::cbrtf(mass));
    let high = FLOOR + 0.24;
    let skins = size.map(|size| mesh(world, ball(size)));
    let rings = size.map(|size| mesh(world, Torus::new(size, size + 0.025)));
    let scale = LONGEST / most;
    let bar = mesh(world, rounded_box(Vec3::new(1.0, 0.14, 0.2), 0.005, 2));
    let line = mesh(world, Cuboid::new(0.02, 0.008, 2.6));
    let least = Transform::from_xyz(BARS + scale * cost_of(own), FLOOR + 0.004, 0.0);
    world.spawn((InScene, line, Look::color(0xf3f1ea), least));
    for (n, (name, share, color)) in rows.into_iter().enumerate() {
        let z = 1.06 - 0.53 * n as f32;
        let look = Look::color(color).roughness(0.35);
        let rod = Look::color(0xd8dee9).metal();
        let body = world.spawn((InScene, ParticleBody, rod, Interpolate)).id();
        let from = [-half, half].map(|x| Vec3::new(x + PAIRS, high, z));
        // The masses are chosen so that this share is the solver's own solution: with the true masses it would choose another.
        let weights = [share, 1.0 - share];
        let balls = [0, 1].map(|i| {
            let mark = Transform::from_translation(from[i].with_y(FLOOR + 0.01));
            let mark = mark.with_scale(Vec3::new(1.0, 0.4, 1.0));
            world.spawn((InScene, rings[i].clone(), Look::color(0x8a94a6), mark));
            let particle = (Particle::at(from[i]), Radius(size[i]), ParticleOf(body));
            let drawn = (Transform::from_translation(from[i]), skins[i].clone(), look.clone());
            let mut ball = world.spawn((particle, drawn));
            if weights[i] > 0.0 {
                ball.insert(Mass(left * right / (left + right) / weights[i]));
            } else {
                ball.insert(Pinned::HERE);
            }
            ball.id()
        });
        let softness = Softness::frequency(HERTZ, 1.0);
        let rod = DistanceConstraint::new(balls[0], balls[1], LENGTH).with_softness(softness);
        world.spawn((rod, ConstraintOf(body)));
        let line = TubeMesh { particles: balls.to_vec(), radius: 0.02, sides: 8 };
        world.entity_mut(body).insert(line);
        let cost = Cost { balls, from, masses: [left, right], scale, now: 0.0 };
        let at = Transform::from_xyz(BARS, FLOOR + 0.07, z).with_scale(Vec3::new(1e-3, 1.0, 1.0));
        world.spawn((InScene, Name::new(name), cost, bar.clone(), look, at));
    }
}
