//! Verlet integration, frame by frame: the next position from the current and the previous one, without a velocity.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::sinew::{Integrator, ParticleSeed, Simulation, SolverSettings};

use crate::arrow::Arrow;
use crate::look::Look;
use crate::props::{FLOOR, curve, floor, mesh};
use crate::rounds::into_round;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "verlet",
    heading: Heading::Integration,
    title: "Verlet, frame by frame",
    about: "the yellow arrow leads from the grey ball, one step ago, to the gold one, now; the same arrow again, plus a h² downwards, leads to blue, the next position",
    eye: Vec3::new(0.25, 1.35, 4.1),
    target: Vec3::new(0.0, 0.93, 0.0),
    seconds: 8.0,
    moment: 2.6,
    lesson: Some(Lesson {
        try_this: "take longer steps: the red arrow grows by their square, and the blue balls stay on the parabola; reduce gravity: it gets shorter in proportion",
        watch: "no velocity is stored: it is the displacement from the previous ball; each spacing is the last one plus the red arrow",
        formula: "p_next = p_now + (p_now − p_old) + a h²",
        sliders: &[
            SceneSlider { label: "Step", unit: "s", range: [0.06, 0.2], default: 0.125 },
            SceneSlider { label: "Gravity", unit: "m/s²", range: [4.0, 12.0], default: 9.81 },
            SceneSlider { label: "Frame duration", unit: "s", range: [0.3, 2.0], default: 0.9 },
        ],
        number: "Difference of two spacings",
        unit: "mm",
        after: 2.0,
        measure: |world| {
            let seconds = world.resource::<SinewClock>().seconds;
            let mut films = world.query::<&Film>();
            let [old, now, next] = films.iter(world).next()?.frame(seconds).0;
            Some(f64::from(((next - now) - (now - old)).length()) * 1e3)
        },
        expect: |values, _| {
            let [step, gravity] = [values[0], values[1]].map(f64::from);
            gravity * step * step * 1e3
        },
        tolerance: [0.01, 1e-4],
    }),
    spawn,
};

/// Time of flight, seconds; start, metres; and horizontal range, metres.
const FLIGHT: f32 = 1.0;
const START: Vec3 = Vec3::new(-1.45, FLOOR + 0.2, 0.0);
const RANGE: f32 = 2.9;
/// Radius of the balls, and how far in front of them the arrows are, metres.
const RADIUS: f32 = 0.07;
const BEFORE: Vec3 = Vec3::new(0.0, 0.0, RADIUS + 0.03);

/// The positions of a ball, step by step, and the entities that draw three of them.
#[derive(Component, Clone, Debug)]
pub(crate) struct Film {
    places: Vec<Vec3>,
    /// Time for which a frame is shown, seconds.
    lasts: f64,
    /// The ball at the previous, the current and the next step.
    balls: [Entity; 3],
    /// The last displacement, the same again, the contribution of the acceleration, and the next displacement.
    arrows: [Arrow; 4],
    /// A mark for each position, hidden until the ball has been there.
    trail: Vec<Entity>,
}

impl Film {
    /// The three positions of the current frame, its progress from 0 to 1, and its number.
    fn frame(&self, seconds: f64) -> ([Vec3; 3], f32, usize) {
        let frames = self.places.len() - 2;
        let passed = into_round(seconds, self.lasts * frames as f64) / self.lasts;
        let number = (passed as usize).min(frames - 1);
        let share = passed - number as f64;
        ([0, 1, 2].map(|i| self.places[number + i]), share as f32, number)
    }
}

/// Shows the frame that is due: first the last displacement, then the same again, then the contribution of the acceleration.
pub(crate) fn show_frame(
    clock: Res<SinewClock>,
    films: Query<&Film>,
    mut drawn: Query<&mut Transform>,
) {
    for film in &films {
        let ([old, now, next], share, number) = film.frame(clock.seconds);
        let ahead = now + (now - old);
        for (&ball, place) in film.balls.iter().zip([old, now, next]) {
            if let Ok(mut ball) = drawn.get_mut(ball) {
                ball.translation = place;
            }
        }
        let ways = [[old, now], [now, ahead], [ahead, next], [now, next]];
        for ((arrow, way), from) in film.arrows.iter().zip(ways).zip([0.0, 0.15, 0.4, 0.65]) {
            let seen = (share >= from).then(|| way.map(|end| end + BEFORE));
            arrow.point(&mut drawn, seen);
        }
        // The next ball grows to full size once its displacement is complete.
        if let Ok(mut ball) = drawn.get_mut(film.balls[2]) {
            ball.scale = Vec3::splat(if share < 0.65 { 0.3 } else { 1.0 });
        }
        for (i, &mark) in film.trail.iter().enumerate() {
            if let Ok(mut mark) = drawn.get_mut(mark) {
                mark.scale = Vec3::splat(if i < number { 1.0 } else { 1e-4 });
            }
        }
    }
}

/// The positions of a thrown ball, step by step, by the solver's Verlet integrator; `None` if one of the numbers is invalid.
fn positions(step: f32, throw: Vec3, gravity: f32) -> Option<Vec<Vec3>> {
    let mut world = Simulation::default();
    world.settings = SolverSettings { integrator: Integrator::Verlet, substeps: 1, ..default() };
    world.forces.gravity = Vec3::NEG_Y * gravity;
    world.particles.push(ParticleSeed::at(START).with_velocity(throw)).ok()?;
    let mut places = vec![START];
    for _ in 0..((FLIGHT / step + 1e-3) as usize).max(2) {
        world.step(step).ok()?;
        places.push(world.particles.position(0));
    }
    Some(places)
}

fn spawn(world: &mut World) {
    let [step, gravity, lasts] = values(world);
    // So that it returns to the height of its start at the end of the flight.
    let throw = Vec3::new(RANGE / FLIGHT, 0.5 * gravity * FLIGHT, 0.0);
    let Some(places) = positions(step, throw, gravity) else { return };
    floor(world, Vec2::new(4.0, 1.6), Look::color(0x6d5a72).roughness(0.9));
    let size = Vec3::new(3.8, 2.0, 0.06);
    let board = mesh(world, rounded_box(size, 0.02, 2));
    let at = Transform::from_xyz(0.0, FLOOR + 0.5 * size.y, -0.3);
    world.spawn((InScene, board, Look::color(0xe9e3d5).roughness(0.9), at));
    // The parabola on which the positions should lie.
    let path = |k: i32| {
        let time = FLIGHT * k as f32 / 32.0;
        let fall = Vec3::NEG_Y * (0.5 * gravity * time * time);
        START + throw * time + fall
    };
    let path: Vec<Vec3> = (0..=32).map(path).collect();
    curve(world, &path, 0.008, Look::color(0xb9b0a0));
    let foot = mesh(world, cylinder(0.05, 0.12));
    let at = Transform::from_translation(START.with_y(FLOOR + 0.06));
    world.spawn((InScene, foot, Look::color(0x4a4f55).roughness(0.5), at));
    let skin = mesh(world, ball(RADIUS));
    let balls = [0x8a8f98, 0xe0a526, 0x3d7ea6].map(|color| {
        let look = Look::color(color).roughness(0.3);
        let at = Transform::from_translation(START);
        world.spawn((InScene, skin.clone(), look, at)).id()
    });
    let arrows = [(0xe0a526, 0.013), (0xf0d48a, 0.013), (0xd1495b, 0.013), (0x3d7ea6, 0.009)]
        .map(|(color, radius)| Arrow::spawn(world, radius, Look::color(color).roughness(0.5)));
    let dot = mesh(world, ball(0.03));
    let trail = places
        .iter()
        .map(|&at| {
            let at = Transform::from_translation(at).with_scale(Vec3::splat(1e-4));
            world.spawn((InScene, dot.clone(), Look::color(0x8a8f98), at)).id()
        })
        .collect();
    let lasts = f64::from(lasts);
    world.spawn((InScene, Name::new("film"), Film { places, lasts, balls, arrows, trail }));
}
