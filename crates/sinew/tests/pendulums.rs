//! What hangs on one or two pins swings on: a ball on a rod, a weight on a rope, a swing, a bob that goes round. A projection to the nearest point took a share
//! `½ (ωh)²` of the speed in each substep, a fifth of the energy in ten seconds at the default substeps.

use core::ops::Range;

use sinew::glam::Vec3;
use sinew::recipes::{RopeSpec, rope};
use sinew::{Distance, Simulation};

const G: f32 = 9.81;

/// Adds a rope of `segments` from a pin, with a bob of 1 kg at its other end.
fn hang(world: &mut Simulation, from: Vec3, along: Vec3, segments: u32) -> Range<usize> {
    let spec = RopeSpec {
        from,
        to: from + along,
        segments,
        mass: 0.01,
        pin_start: true,
        ..Default::default()
    };
    let mut line = rope(&spec).unwrap();
    let last = line.particles.last_mut().unwrap();
    *last = last.with_mass(1.0);
    line.build(world).unwrap()
}

/// Energy above that of all hanging straight down from `length` metres above, J.
fn energy(world: &Simulation, length: f32) -> f32 {
    let of = |i: usize| {
        let (mass, height) = (world.particles.mass(i), world.particles.position(i).y + length);
        mass * (0.5 * world.velocity_now(i).length_squared() + G * height)
    };
    (0..world.particles.len()).filter(|&i| world.particles.inverse_mass(i) > 0.0).map(of).sum()
}

fn with_substeps(substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = substeps;
    world
}

/// A metre long, let go at 57°.
const ALONG: Vec3 = Vec3::new(0.841_471, -0.540_302, 0.0);

#[test]
fn what_swings_keeps_its_energy() {
    let rod = |world: &mut Simulation| {
        hang(world, Vec3::ZERO, ALONG, 1);
    };
    let weight = |world: &mut Simulation| {
        hang(world, Vec3::ZERO, ALONG, 20);
    };
    let swing = |world: &mut Simulation| {
        let left = hang(world, Vec3::ZERO, ALONG, 10);
        let right = hang(world, Vec3::Z * 0.5, ALONG, 10);
        let ends = [left, right].map(|rows| rows.end as u32 - 1);
        world.distances_mut().push(Distance::new(ends[0], ends[1], 0.5));
    };
    let scenes: [(&str, fn(&mut Simulation)); 3] =
        [("a rod", rod), ("a weight on a rope", weight), ("a swing", swing)];
    for (name, build) in scenes {
        for substeps in [4, 10, 40] {
            let mut world = with_substeps(substeps);
            build(&mut world);
            let before = energy(&world, 1.0);
            let mut most = before;
            for _ in 0..20 * 60 {
                world.step(1.0 / 60.0).unwrap();
                most = most.max(energy(&world, 1.0));
            }
            let left = energy(&world, 1.0) / before;
            println!("{name}, {substeps} substeps: {left}, at most {}", most / before);
            assert!((left - 1.0).abs() < 0.005, "{name}, {substeps}: {left}");
            assert!(most < 1.001 * before, "{name}, {substeps}: {}", most / before);
        }
    }
}

/// A bob on a rope of length `l` at an angle `θ` goes round at `ω² = g/(l cos θ)`.
#[test]
fn a_conical_pendulum_goes_round_at_its_angle() {
    for segments in [1, 20] {
        for substeps in [4, 10, 40] {
            let mut world = with_substeps(substeps);
            let rows = hang(&mut world, Vec3::ZERO, ALONG, segments);
            let rate = Vec3::Y * (G / -ALONG.y).sqrt();
            for i in rows.clone() {
                let at = world.particles.position(i);
                world.particles.set_velocity(i, rate.cross(at));
            }
            for _ in 0..20 * 60 {
                world.step(1.0 / 60.0).unwrap();
            }
            let bob = world.particles.position(rows.end - 1);
            let sine = bob.with_y(0.0).length() / bob.length();
            assert!((sine - ALONG.x).abs() < 1e-3, "{segments}, {substeps}: {sine}");
        }
    }
}

/// Without `keep_spin` the loop is the lectures', which loses energy.
#[test]
fn the_lectures_loop_loses_it() {
    let mut world = with_substeps(10);
    world.settings.keep_spin = false;
    hang(&mut world, Vec3::ZERO, ALONG, 1);
    let before = energy(&world, 1.0);
    for _ in 0..10 * 60 {
        world.step(1.0 / 60.0).unwrap();
    }
    let left = energy(&world, 1.0) / before;
    assert!((0.75..0.82).contains(&left), "{left}");
}

/// Bodies of one topology are solved eight side by side, each with its pins where they are: some at the first particle, one at the last, one at both, one free.
#[test]
fn it_does_not_depend_on_what_is_solved_beside_it() {
    let pinned = [&[0][..], &[0], &[20], &[0, 20], &[], &[7], &[0], &[0, 3], &[0, 1, 2]];
    let build = |world: &mut Simulation, number: usize| {
        // Relative to their own origins all begin alike.
        let from = Vec3::X * 4.0 * number as f32;
        let spec = RopeSpec { from, to: from + 0.9 * ALONG, slack: 0.1, ..Default::default() };
        let mut line = rope(&spec).unwrap();
        pinned[number].iter().for_each(|&i| line.pin(i).unwrap());
        line.build(world).unwrap()
    };
    let state = |world: &Simulation, rows: Range<usize>| -> Vec<[Vec3; 2]> {
        rows.map(|i| [world.particles.position(i), world.particles.velocity(i)]).collect()
    };
    let mut all = with_substeps(10);
    let rows: Vec<_> = (0..pinned.len()).map(|number| build(&mut all, number)).collect();
    (0..120).for_each(|_| {
        all.step(1.0 / 60.0).unwrap();
    });
    for (number, rows) in rows.into_iter().enumerate() {
        let mut alone = with_substeps(10);
        let own = build(&mut alone, number);
        (0..120).for_each(|_| {
            alone.step(1.0 / 60.0).unwrap();
        });
        assert!(
            state(&all, rows) == state(&alone, own),
            "{number}, pinned at {:?}",
            pinned[number]
        );
    }
}
