//! The claims of physics.md on places far from the origin: a scene 5 km away behaves as it does near the origin.

use sinew::glam::Vec3;
use sinew::recipes::{BoxSpec, box_3d};
use sinew::{GradientAt, ParticleSeed, Plane, Simulation};

use crate::Row;
use crate::case::cases;
use crate::measure::{TICK, largest, steps};
use crate::solver::pendulum;

cases! {
    "Far" a_body_at_rest_five_kilometres_out_stays_at_rest;
    "Far" a_body_falls_there_as_near_the_origin;
    "Far" a_pendulum_swings_there_as_near_the_origin;
    "Far" gravity_acts_on_a_body_that_hardly_moves;
}

/// 5 km from the origin, metres. Not whole metres, so that coordinates are rounded differently.
const AWAY: Vec3 = Vec3::new(4999.7, 1234.56, -4321.1);

/// Displacement of each corner of a cube in 10 s, metres; dropped from `drop` metres above the ground.
fn dropped(offset: Vec3, drop: f32, ground: bool) -> Vec<Vec3> {
    let mut world = Simulation::default();
    if ground {
        world.boundaries.planes.push(Plane::ground(offset.y));
    }
    let cube = box_3d(&BoxSpec::default()).expect("a sound box");
    let place = offset + Vec3::Y * (0.5 + drop);
    let rows = cube.transformed(Default::default(), place).build(&mut world).expect("room");
    let before: Vec<Vec3> = rows.clone().map(|i| world.particles.relative_to(i, offset)).collect();
    steps(&mut world, TICK, 600);
    rows.map(|i| world.particles.relative_to(i, offset) - before[i]).collect()
}

/// Largest distance between a corner's displacement far out and the same near the origin, metres.
fn astray(drop: f32, ground: bool) -> f64 {
    let (home, away) = (dropped(Vec3::ZERO, drop, ground), dropped(AWAY, drop, ground));
    largest(home.iter().zip(&away).map(|(a, b)| f64::from(a.distance(*b))))
}

/// 1 mm is the required accuracy; it equals four roundings of a coordinate at that distance, since the cube's position itself is rounded.
fn a_body_at_rest_five_kilometres_out_stays_at_rest() -> Vec<Row> {
    let crept = largest(dropped(AWAY, 0.0, true).iter().map(|d| f64::from(d.length())));
    vec![
        Row::absolute(
            "corner of a cube on the ground, after 10 s, moved by",
            "m",
            0.0,
            crept,
            1e-3,
        ),
        Row::absolute("the same, compared with the origin", "m", 0.0, astray(0.0, true), 1e-3),
    ]
}

fn a_body_falls_there_as_near_the_origin() -> Vec<Row> {
    vec![
        Row::absolute(
            "corner of a cube after a fall of 10 s, compared with the origin",
            "m",
            0.0,
            astray(600.0, false),
            1e-3,
        ),
        Row::absolute(
            "dropped from 2 m, after 10 s, compared with the origin",
            "m",
            0.0,
            astray(2.0, true),
            1e-3,
        ),
    ]
}

fn a_pendulum_swings_there_as_near_the_origin() -> Vec<Row> {
    // Positions on a grid that f32 represents at that distance, so that both start identically.
    let offset = Vec3::new(5000.0, -3000.0, 4000.0);
    let end = |offset: Vec3| {
        let mut world = pendulum(1.0, GradientAt::StepStart);
        for i in 0..2 {
            let seed = world.particles.seed(i);
            let local = (seed.position * 1024.0).round() / 1024.0;
            let moved = ParticleSeed { position: local + offset, ..seed };
            world.particles.set(i, moved).expect("a sound particle");
        }
        steps(&mut world, TICK, 600);
        world.particles.relative_to(1, offset)
    };
    let apart = f64::from(end(Vec3::ZERO).distance(end(offset)));
    vec![Row::absolute(
        "bob of a pendulum after 10 s, moved by whole metres, compared with the origin",
        "m",
        0.0,
        apart,
        0.0,
    )]
}

/// `p - p_old` in world coordinates would lose gravity beyond 128 m at 20 substeps: it moves a particle by 6.8e-6 m in a substep, where neighbouring `f32` are
/// 1.5e-5 m apart.
fn gravity_acts_on_a_body_that_hardly_moves() -> Vec<Row> {
    let mut world = Simulation::default();
    world.settings.substeps = 20;
    world.particles.push(ParticleSeed::at(AWAY)).expect("a sound particle");
    steps(&mut world, TICK, 1);
    let fallen = f64::from(world.particles.relative_to(0, AWAY).y);
    let t = f64::from(TICK);
    // Positions near that point are stored relative to it, to 6e-8 m.
    vec![Row::absolute(
        "fall of a particle in the first 1/60 s, 5 km out",
        "m",
        -0.5 * 9.81 * t * t,
        fallen,
        1e-6,
    )]
}
