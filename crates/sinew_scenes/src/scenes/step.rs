//! One step of position based dynamics in slow motion: prediction, projection of each constraint in turn, and the velocity derived from the result.

use std::sync::{Arc, Mutex, PoisonError};

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::sinew::{
    Bound, Constraint, ConstraintKind, Equation, ParticleSeed, Points, Simulation, SolverSettings,
};

use crate::arrow::Arrow;
use crate::look::Look;
use crate::props::{FLOOR, floor, mesh};
use crate::rounds::into_round;
use crate::scene::{Heading, InScene, Lesson, Scene, SceneSlider, component_of, values};
use crate::shapes::{ball, cylinder, rounded_box};

pub(super) const SCENE: Scene = Scene {
    name: "step",
    heading: Heading::Constraints,
    title: "One step in slow motion",
    about: "blue: each ball is predicted as if it were alone; orange: the rods correct it in turn; green: the floor does; yellow: the velocity that results",
    eye: Vec3::new(0.2, 1.5, 4.1),
    target: Vec3::new(0.0, 1.13, 0.0),
    seconds: 7.0,
    moment: 2.2,
    lesson: Some(Lesson {
        try_this: "take one sweep: the last constraint holds, and the others are violated again; a heavy red ball moves less in each correction; a longer step predicts worse",
        watch: "white rings are where the balls were, blue ones the predictions; the pegs count the stages, sweep by sweep; the velocity is the displacement from the white ring over the step, whatever happened in between",
        formula: "q = p + h v + ½ h² g; d = C m₂/(m₁ + m₂), C = L (√(1 + ω²h²) − 1); v = (q' − p)/h",
        sliders: &[
            SceneSlider { label: "Step", unit: "s", range: [0.12, 0.17], default: 0.15 },
            SceneSlider { label: "Sweeps", unit: "", range: [1.0, 4.0], default: 2.0 },
            SceneSlider { label: "Red ball", unit: "kg", range: [0.5, 5.0], default: 2.0 },
            SceneSlider { label: "Spin", unit: "rad/s", range: [3.0, 5.0], default: 4.5 },
            SceneSlider { label: "Stage duration", unit: "s", range: [0.3, 2.0], default: 0.6 },
        ],
        number: "First correction of the red ball",
        unit: "mm",
        after: 1.0,
        measure: |world| {
            let first: FirstCorrection = component_of(world, "step")?;
            Some(f64::from(first.0) * 1e3)
        },
        expect: |values, _| {
            let [step, mass, spin] = [values[0], values[2], values[3]].map(f64::from);
            // The ends of a rod move along the tangents of their circle, so the predicted rod is too long.
            let turn = spin * step;
            let excess = f64::from(LENGTH) * (libm::sqrt(1.0 + turn * turn) - 1.0);
            excess / (mass + 1.0) * 1e3
        },
        tolerance: [0.01, 1e-4],
    }),
    spawn,
};

/// Length of a rod and radius of a ball, metres.
const LENGTH: f32 = 1.2;
const RADIUS: f32 = 0.06;
/// Initial position, metres, and velocity, m/s, of the centre of the triangle.
const MIDDLE: Vec3 = Vec3::new(-0.25, TABLE + 1.09, 0.0);
const VELOCITY: Vec3 = Vec3::new(2.4, -1.8, 0.0);
/// Height of the table that serves as the floor of the triangle, metres. The triangle is in front of it, so that penetration is visible.
const TABLE: f32 = 0.42;
/// The balls that each rod joins, in solving order.
const RODS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];
/// Size of a peg, metres.
const PEG: Vec3 = Vec3::new(0.12, 0.18, 0.1);
/// How far in front of the balls the arrows are drawn, metres.
const BEFORE: Vec3 = Vec3::new(0.0, 0.0, RADIUS + 0.03);

/// What a stage of the step does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Act {
    Begin,
    Predict,
    Rod,
    Floor,
    Derive,
}

/// Positions of all balls, metres.
type Places = [Vec3; 3];

/// A stage of the step: positions of the balls when it starts and when it ends, and an arrow for each.
#[derive(Clone, Copy, Debug)]
struct Stage {
    act: Act,
    /// The sweep over the constraints that it belongs to; 0 before the first.
    sweep: usize,
    ways: [Places; 2],
    arrows: [Option<[Vec3; 2]>; 3],
}

/// A constraint that records the positions of its particles whenever the solver evaluates it. The records show what the solver did, in order.
#[derive(Debug)]
struct Watched {
    number: usize,
    rows: Vec<usize>,
    /// Length of the rod, metres; `None`: the floor.
    rest: Option<f32>,
    seen: Seen,
}

/// The evaluations by the solver, in order.
type Seen = Arc<Mutex<Vec<Sight>>>;

/// An evaluation: the constraint, and the positions of its balls, metres.
#[derive(Clone, Debug)]
struct Sight {
    constraint: usize,
    places: Vec<(usize, Vec3)>,
}

impl Equation for Watched {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let place = |(i, &row): (usize, &usize)| (row, points.relative_to(i, Vec3::ZERO));
        let places = self.rows.iter().enumerate().map(place).collect();
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        seen.push(Sight { constraint: self.number, places });
        match self.rest {
            Some(rest) => {
                let apart = points.at(0) - points.at(1);
                let along = apart.normalize_or(Vec3::X);
                (gradients[0], gradients[1]) = (along, -along);
                apart.length() - rest
            }
            None => {
                gradients[0] = Vec3::Y;
                points.relative_to(0, Vec3::Y * (TABLE + RADIUS)).y
            }
        }
    }

    fn bound(&self) -> Bound {
        if self.rest.is_some() { Bound::Equal } else { Bound::AtLeast }
    }

    fn is_length(&self) -> bool {
        true
    }
}

/// Initial position, metres, and velocity, m/s, of a ball: a triangle that turns as it falls, one corner down.
fn start(i: usize, spin: f32) -> [Vec3; 2] {
    let (sin, cos) = libm::sincosf((10.0 + 120.0 * i as f32).to_radians());
    let out = Vec3::new(cos, sin, 0.0) * (LENGTH / libm::sqrtf(3.0));
    [MIDDLE + out, VELOCITY + (Vec3::Z * spin).cross(out)]
}

/// The stages of one substep of the solver, in a world of its own; `None` if one of its numbers is invalid.
fn take_step(step: f32, sweeps: u32, mass: f32, spin: f32) -> Option<Vec<Stage>> {
    let seen = Seen::default();
    let mut world = Simulation::default();
    // Plain position based dynamics: a fixed number of sweeps, and no corrections after them.
    world.settings = SolverSettings {
        substeps: 1,
        max_sweeps: sweeps,
        tolerance: 0.0,
        keep_spin: false,
        ..default()
    };
    for (i, mass) in [mass, 1.0, 1.0].into_iter().enumerate() {
        let [at, velocity] = start(i, spin);
        let seed = ParticleSeed::at(at).with_velocity(velocity).with_mass(mass);
        world.particles.push(seed).ok()?;
    }
    let rods = RODS.iter().map(|pair| (pair.to_vec(), Some(LENGTH)));
    let floors = (0..3).map(|i| (vec![i], None));
    for (number, (rows, rest)) in rods.chain(floors).enumerate() {
        let named: Vec<u32> = rows.iter().map(|&row| row as u32).collect();
        let watched = Watched { number, rows, rest, seen: seen.clone() };
        world.constraints_mut().push(Constraint::new(named, ConstraintKind::custom(watched)));
    }
    let places = |world: &Simulation| [0, 1, 2].map(|i| world.particles.position(i));
    let velocities = |world: &Simulation| [0, 1, 2].map(|i| world.particles.velocity(i));
    let arrows = |from: Places, to: Places| [0, 1, 2].map(|i| Some([from[i], to[i]]));
    let before = places(&world);
    let first = velocities(&world);
    // The phases of a substep, one by one. A game's own systems can run between them.
    world.begin_step(step).ok()?;
    world.begin_substep();
    world.accumulate_forces();
    world.integrate();
    let predicted = places(&world);
    seen.lock().unwrap_or_else(PoisonError::into_inner).clear();
    world.solve_constraints();
    let (after, last) = (places(&world), velocities(&world));
    let sights = core::mem::take(&mut *seen.lock().unwrap_or_else(PoisonError::into_inner));
    let ahead = [0, 1, 2].map(|i| before[i] + first[i] * step);
    let mut stages = vec![
        Stage { act: Act::Begin, sweep: 0, ways: [before; 2], arrows: arrows(before, ahead) },
        Stage {
            act: Act::Predict,
            sweep: 0,
            ways: [before, predicted],
            arrows: arrows(before, predicted),
        },
    ];
    stages.extend(corrections(predicted, after, &sights));
    let tails = [0, 1, 2].map(|i| after[i] - last[i] * step);
    stages.push(Stage {
        act: Act::Derive,
        sweep: 0,
        ways: [after; 2],
        arrows: arrows(tails, after),
    });
    Some(stages)
}

/// The corrections of each constraint, derived from the recorded evaluations: a particle that has moved since its last evaluation was moved by the constraint
/// that was evaluated then. Corrections of less than a millimetre are left out.
fn corrections(predicted: Places, after: Places, sights: &[Sight]) -> Vec<Stage> {
    let mut stages: Vec<Stage> = Vec::new();
    let (mut known, mut last) = (predicted, [None; 3]);
    let mut note = |row: usize, place: Vec3, mover: Option<&mut Stage>| {
        if place.distance(known[row]) > 1e-3
            && let Some(stage) = mover
        {
            stage.arrows[row] = Some([known[row], place]);
        }
        known[row] = place;
    };
    // A sweep ends where a constraint is evaluated again.
    let (mut sweep, mut turns) = (0, Vec::new());
    for &Sight { constraint, ref places } in sights {
        if turns.is_empty() || turns.contains(&constraint) {
            turns.clear();
            sweep += 1;
        }
        turns.push(constraint);
        for &(row, place) in places {
            note(row, place, last[row].and_then(|number: usize| stages.get_mut(number)));
            last[row] = Some(stages.len());
        }
        let act = if constraint < RODS.len() { Act::Rod } else { Act::Floor };
        stages.push(Stage { act, sweep, ways: [predicted; 2], arrows: [None; 3] });
    }
    for (row, place) in after.into_iter().enumerate() {
        note(row, place, last[row].and_then(|number| stages.get_mut(number)));
    }
    stages.retain(|stage| stage.arrows.iter().any(Option::is_some));
    let mut now = predicted;
    for stage in &mut stages {
        let begin = now;
        for (place, arrow) in now.iter_mut().zip(stage.arrows) {
            *place = arrow.map_or(*place, |[_, to]| to);
        }
        stage.ways = [begin, now];
    }
    stages
}

/// Displacement of the red ball in the first correction, metres.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct FirstCorrection(f32);

/// A step that is played repeatedly, and the entities that draw it.
#[derive(Component, Clone, Debug)]
pub(crate) struct SlowStep {
    stages: Vec<Stage>,
    /// Time for which a stage is shown, seconds.
    lasts: f64,
    balls: [Entity; 3],
    rods: [Entity; 3],
    /// Predicted position of each ball.
    rings: [Entity; 3],
    /// An arrow for each ball, for each act.
    arrows: [(Act, [Arrow; 3]); 5],
    /// One for each stage.
    pegs: Vec<Entity>,
}

/// Shows the stage that is due.
pub(crate) fn show_step(
    clock: Res<SinewClock>,
    steps: Query<&SlowStep>,
    mut drawn: Query<&mut Transform>,
) {
    for step in &steps {
        let SlowStep { stages, lasts, balls, rods, rings, arrows, pegs } = step;
        let passed = into_round(clock.seconds, lasts * stages.len() as f64) / lasts;
        let number = (passed as usize).min(stages.len() - 1);
        let stage = &stages[number];
        // A stage pauses first, so that its arrows are seen, then moves the balls, and pauses again.
        let share = (2.0 * (passed - number as f64) - 0.6).clamp(0.0, 1.0) as f32;
        let share = share * share * (3.0 - 2.0 * share);
        let places = [0, 1, 2].map(|i| stage.ways[0][i].lerp(stage.ways[1][i], share));
        for (&ball, place) in balls.iter().zip(places) {
            if let Ok(mut ball) = drawn.get_mut(ball) {
                ball.translation = place;
            }
        }
        for (&rod, [a, b]) in rods.iter().zip(RODS) {
            if let Ok(mut rod) = drawn.get_mut(rod) {
                *rod = between(places[a], places[b]);
            }
        }
        for &ring in rings {
            if let Ok(mut ring) = drawn.get_mut(ring) {
                ring.scale = Vec3::splat(if number == 0 { 1e-4 } else { 1.0 });
            }
        }
        for (act, of_balls) in arrows {
            for (i, arrow) in of_balls.iter().enumerate() {
                let ends = stage.arrows[i].filter(|_| *act == stage.act);
                arrow.point(&mut drawn, ends.map(|ends| ends.map(|end| end + BEFORE)));
            }
        }
        for (i, &peg) in pegs.iter().enumerate() {
            if let Ok(mut peg) = drawn.get_mut(peg) {
                *peg = standing(peg.translation.x, if i == number { 1.0 } else { 0.45 });
            }
        }
    }
}

/// A peg in front of the table, at this fraction of its size.
fn standing(along: f32, scale: f32) -> Transform {
    Transform::from_xyz(along, FLOOR + 0.5 * PEG.y * scale, 0.5).with_scale(Vec3::splat(scale))
}

/// A stick of 1 m along y, stretched from one point to another.
fn between(from: Vec3, to: Vec3) -> Transform {
    let way = to - from;
    Transform::from_translation(0.5 * (from + to))
        .with_rotation(Quat::from_rotation_arc(Vec3::Y, way.normalize_or(Vec3::Y)))
        .with_scale(Vec3::new(1.0, way.length(), 1.0))
}

fn spawn(world: &mut World) {
    let [step, sweeps, mass, spin, lasts] = values(world);
    let Some(stages) = take_step(step, sweeps.round() as u32, mass, spin) else { return };
    floor(world, Vec2::new(4.2, 1.8), Look::color(0x57705c).roughness(0.9));
    let behind = -RADIUS - 0.02;
    for (size, z, color) in [
        (Vec3::new(3.5, 2.34, 0.06), behind - 0.5, 0x2b3a42),
        (Vec3::new(3.5, TABLE - FLOOR, 0.47), behind - 0.235, 0x8a7f72),
    ] {
        let shape = mesh(world, rounded_box(size, 0.01, 2));
        let at = Transform::from_xyz(0.0, FLOOR + 0.5 * size.y, z);
        world.spawn((InScene, shape, Look::color(color).roughness(0.9), at));
    }

    let white = Look::color(0xf3f1ea).roughness(0.6);
    let color = |act: Act| match act {
        Act::Begin | Act::Derive => 0xf2c14e,
        Act::Predict => 0x5aa9e6,
        Act::Rod => 0xf07f2e,
        Act::Floor => 0x7fc97f,
    };
    let ring = mesh(world, Torus::new(RADIUS + 0.005, RADIUS + 0.025));
    let facing = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let placed = |at: Vec3| Transform::from_translation(at).with_rotation(facing);
    let (before, predicted) = (stages[1].ways[0], stages[1].ways[1]);
    let blue = Look::color(color(Act::Predict)).roughness(0.4);
    let rings = predicted.map(|at| {
        let hidden = placed(at).with_scale(Vec3::splat(1e-4));
        world.spawn((InScene, ring.clone(), blue.clone(), hidden)).id()
    });
    for at in before {
        world.spawn((InScene, ring.clone(), white.clone(), placed(at)));
    }
    let stick = mesh(world, cylinder(0.018, 1.0));
    let rods = RODS.map(|[a, b]| {
        let metal = Look::color(0xd8dee9).metal();
        world.spawn((InScene, stick.clone(), metal, between(before[a], before[b]))).id()
    });
    let skin = mesh(world, ball(RADIUS));
    let balls = [0, 1, 2].map(|i| {
        let look = Look::color([0xd1495b, 0xdad7cd, 0xdad7cd][i]).roughness(0.3);
        let at = Transform::from_translation(before[i]);
        world.spawn((InScene, skin.clone(), look, at)).id()
    });
    let acts = [Act::Begin, Act::Predict, Act::Rod, Act::Floor, Act::Derive];
    let arrows = acts.map(|act| {
        let look = Look::color(color(act)).roughness(0.5);
        (act, [0, 1, 2].map(|_| Arrow::spawn(world, 0.014, look.clone())))
    });
    // A gap before each sweep and after the last.
    let peg = mesh(world, rounded_box(PEG, 0.02, 2));
    let gap = |i: usize| i > 0 && stages[i].sweep != stages[i - 1].sweep;
    let gaps = (0..stages.len()).filter(|&i| gap(i)).count();
    let wide = (stages.len() - 1) as f32 + 0.7 * gaps as f32;
    let apart = (3.0 / wide).min(0.2);
    let mut along = -0.5 * wide * apart;
    let mut pegs = Vec::new();
    for (i, stage) in stages.iter().enumerate() {
        along += if i == 0 {
            0.0
        } else if gap(i) {
            1.7 * apart
        } else {
            apart
        };
        let look = Look::color(color(stage.act)).roughness(0.4);
        pegs.push(world.spawn((InScene, peg.clone(), look, standing(along, 0.45))).id());
    }
    let first = stages.iter().find(|stage| matches!(stage.act, Act::Rod | Act::Floor));
    let first = first.and_then(|stage| stage.arrows[0]).map_or(0.0, |[from, to]| from.distance(to));
    let lasts = f64::from(lasts);
    let step = SlowStep { stages, lasts, balls, rods, rings, arrows, pegs };
    world.spawn((InScene, Name::new("step"), FirstCorrection(first), step));
}
