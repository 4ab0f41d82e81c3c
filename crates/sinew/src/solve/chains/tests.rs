//! Chains hold any load, conserve what a sweep conserves, and stay stable where they are infeasible.

use glam::Vec3;

use super::segments::{SegmentScratch, rests_of};
use super::{Link, project_one};
use crate::constraints::{Distance, Pin};
use crate::lanes::InstructionSet;
use crate::particles::ParticleSeed;
use crate::recipes::{BoxSpec, RopeSpec, box_3d, rope};
use crate::simulation::Simulation;
use crate::test_random::Random;

const DT: f32 = 1.0 / 60.0;

/// Length of a piece, metres, and its mass, kg.
const PIECE: f32 = 0.05;
const MASS: f32 = 0.01;

fn push(world: &mut Simulation, at: Vec3, mass: f32) -> u32 {
    world.particles.push(ParticleSeed::at(at).with_mass(mass)).unwrap()
}

/// A rope of this many pieces in the direction `along`, pinned at its first particle, with a weight at its end.
fn loaded(world: &mut Simulation, pieces: u32, along: Vec3, weight: f32) -> [u32; 2] {
    let first = world.particles.len() as u32;
    for i in 0..=pieces {
        let seed = ParticleSeed::at(along * (PIECE * i as f32));
        let seed = seed.with_mass(if i == pieces { weight } else { MASS });
        world.particles.push(if i == 0 { seed.pinned() } else { seed }).unwrap();
    }
    for i in first..first + pieces {
        world.distances_mut().push(Distance::new(i, i + 1, PIECE));
    }
    [first, first + pieces]
}

/// The largest relative error of the distances, without those of zero length.
fn strain(world: &Simulation) -> f32 {
    let strains = world.distances().iter().filter(|d| d.rest > 0.0).map(|d| {
        let apart = world.particles.separation(d.a as usize, d.b as usize).length();
        (apart / d.rest - 1.0).abs()
    });
    strains.fold(0.0, f32::max)
}

/// The largest strain in this many ticks, and the mean number of sweeps per tick.
fn run(world: &mut Simulation, ticks: u32) -> (f32, f32) {
    let (mut worst, mut sweeps) = (0.0_f32, 0);
    for _ in 0..ticks {
        sweeps += world.step(DT).unwrap().sweeps;
        worst = worst.max(strain(world));
    }
    (worst, sweeps as f32 / ticks as f32)
}

#[test]
fn a_swinging_rope_does_not_stretch_however_heavy_its_load_is() {
    // A little below the level: at the level, which it comes back up to, it would be slack for a moment, and be jerked.
    let along = Vec3::new(0.995, -0.0998, 0.0).normalize();
    for pieces in [2, 5, 20, 60] {
        for weight in [0.01, 0.1, 1.0, 10.0] {
            let mut world = Simulation::default();
            loaded(&mut world, pieces, along, weight);
            let (worst, sweeps) = run(&mut world, 240);
            println!("{pieces} pieces, {weight} kg: {worst:.2e} in {sweeps:.1} sweeps a tick");
            assert!(
                worst < 0.003 && sweeps < 15.0,
                "{pieces} pieces, {weight} kg: {worst} {sweeps}"
            );
        }
    }
}

#[test]
fn side_by_side_it_has_the_bits_that_it_has_alone() {
    let alone = |weight: f32| {
        let mut world = Simulation::default();
        loaded(&mut world, 12, Vec3::new(0.8, 0.0, 0.6), weight);
        run(&mut world, 60);
        (0..13).map(|i| world.particles.position(i)).collect::<Vec<_>>()
    };
    let mut world = Simulation::default();
    let weights: [f32; 11] = core::array::from_fn(|n| 0.02 * (n + 1) as f32);
    for weight in weights {
        loaded(&mut world, 12, Vec3::new(0.8, 0.0, 0.6), weight);
    }
    run(&mut world, 60);
    for (n, weight) in weights.into_iter().enumerate() {
        let own: Vec<_> = (13 * n..13 * (n + 1)).map(|i| world.particles.position(i)).collect();
        assert_eq!(own, alone(weight), "rope {n}");
    }
}

#[test]
fn what_is_tied_to_its_end_by_a_distance_of_no_length_is_of_the_chain() {
    let mut world = Simulation::default();
    let [_, end] = loaded(&mut world, 16, Vec3::X, MASS);
    let at = world.particles.position(end as usize);
    let ring = push(&mut world, at, 0.1);
    let foot = push(&mut world, at + Vec3::X * 0.5, 2.0);
    world.distances_mut().push(Distance::new(ring, foot, 0.5));
    world.distances_mut().push(Distance::new(end, ring, 0.0));
    let (worst, sweeps) = run(&mut world, 240);
    let gap = world.particles.separation(end as usize, ring as usize).length();
    assert!(worst < 1e-3 && sweeps < 11.0 && gap < 1e-5, "{worst} {sweeps} {gap}");
}

#[test]
fn chains_that_meet_hold_together_and_a_ring_stays_one() {
    // Three ropes from pins to one heavy knot.
    let mut world = Simulation::default();
    let knot = push(&mut world, Vec3::ZERO, 1.0);
    for turn in 0..3 {
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * turn as f32 / 3.0);
        let out = Vec3::new(cos, 0.5, sin).normalize();
        let mut last = knot;
        for i in 1..=10 {
            let next = push(&mut world, out * (PIECE * i as f32), MASS);
            world.distances_mut().push(Distance::new(last, next, PIECE));
            last = next;
        }
        let seed = world.particles.seed(last as usize).pinned();
        world.particles.set(last as usize, seed).unwrap();
    }
    let (worst, _) = run(&mut world, 240);
    assert!(worst < 0.01, "three that meet: {worst}");
    let mut world = Simulation::default();
    let beads: Vec<u32> = (0..24)
        .map(|i| {
            let (sin, cos) = libm::sincosf(core::f32::consts::TAU * i as f32 / 24.0);
            push(&mut world, Vec3::new(cos, sin, 0.0) * 0.19, MASS)
        })
        .collect();
    let side = world.particles.separation(0, 1).length();
    for i in 0..24 {
        world.distances_mut().push(Distance::new(beads[i], beads[(i + 1) % 24], side));
    }
    let seed = world.particles.seed(6).pinned();
    world.particles.set(6, seed).unwrap();
    let (worst, _) = run(&mut world, 240);
    assert!(worst < 0.01, "a ring: {worst}");
}

#[test]
fn a_free_chain_keeps_its_momentum_and_what_it_turns_with() {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    for i in 0..20 {
        push(&mut world, Vec3::new(PIECE * i as f32, 0.0, 0.0), MASS * (1 + i % 3 * 10) as f32);
    }
    for i in 0..19 {
        world.distances_mut().push(Distance::new(i, i + 1, PIECE));
    }
    let mut before = None;
    for tick in 0..240 {
        if tick == 0 {
            world.particles.set_velocity(19, Vec3::new(0.0, 3.0, 1.0));
            world.particles.set_velocity(4, Vec3::new(-1.0, 0.0, 2.0));
        }
        world.step(DT).unwrap();
        let ledger = world.ledger();
        let now = (ledger.momentum, ledger.angular_momentum);
        let (p, l) = *before.get_or_insert(now);
        let tolerance = 1e-4;
        assert!((now.0 - p).length() < tolerance * p.length(), "{tick}: {} {p}", now.0);
        assert!((now.1 - l).length() < tolerance * l.length().max(1e-3), "{tick}: {} {l}", now.1);
    }
    assert!(strain(&world) < 1e-4, "{}", strain(&world));
}

/// A rope of 20 pieces between two pins a metre apart, longer than that by `slack`, optionally with a weight at its eighth piece.
fn line(slack: f32, weight: Option<f32>) -> Simulation {
    let mut world = Simulation::default();
    let ends = RopeSpec { to: Vec3::X, pin_start: true, pin_end: true, ..RopeSpec::default() };
    rope(&RopeSpec { slack, ..ends }).unwrap().build(&mut world).unwrap();
    if let Some(weight) = weight {
        let seed = world.particles.seed(8).with_mass(weight);
        world.particles.set(8, seed).unwrap();
    }
    world
}

#[test]
fn a_line_between_two_pins_hangs_still_also_where_it_is_too_short_for_its_load() {
    for slack in [0.0, 0.001, 0.2] {
        for weight in [None, Some(1.0), Some(20.0)] {
            let mut world = line(slack, weight);
            run(&mut world, 300);
            let (mut worst, mut fast) = (0.0_f32, 0.0_f32);
            for _ in 0..300 {
                worst = worst.max(run(&mut world, 1).0);
                let speeds = (0..21).map(|i| world.velocity_now(i).length());
                fast = speeds.fold(fast, f32::max);
            }
            // With slack it keeps swinging.
            let most = if slack > 0.1 { 0.1 } else { 0.005 };
            assert!(worst < 0.006 && fast < most, "{slack} {weight:?}: {worst} {fast}");
        }
    }
}

#[test]
fn one_that_is_pulled_apart_stays_between_its_pins() {
    let mut world = line(0.0, None);
    for tick in 0..240 {
        let out = if tick < 60 { tick as f32 / 60.0 } else { 0.0 };
        let target = Vec3::X * (1.0 + out);
        world.boundaries.pins = vec![Pin { particle: 20, target }];
        world.step(DT).unwrap();
        let far = (0..21).map(|i| world.particles.position(i)).fold(0.0_f32, |far, p| {
            far.max(p.y.abs()).max(p.z.abs()).max(-p.x).max(p.x - target.x)
        });
        // Released at once, it whirls, but not beyond its own length.
        let most = if tick < 60 { 0.05 } else { 1.0 };
        assert!(far < most, "tick {tick}: {far}");
    }
    assert!(strain(&world) < 0.005, "{}", strain(&world));
}

#[test]
fn two_weights_jerk_a_light_rope_straight_and_nothing_is_flung() {
    for weight in [0.005, 0.05, 0.5, 5.0, 50.0, 1000.0] {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::ZERO;
        let spec = RopeSpec { to: Vec3::X, slack: 0.1, ..RopeSpec::default() };
        rope(&spec).unwrap().build(&mut world).unwrap();
        for (end, speed) in [(0, -2.0), (20, 3.0)] {
            world.particles.set(end, world.particles.seed(end).with_mass(weight)).unwrap();
            world.particles.set_velocity(end, Vec3::X * speed);
        }
        let (mut worst, mut fast) = (0.0_f32, 0.0_f32);
        for _ in 0..300 {
            worst = worst.max(run(&mut world, 1).0);
            fast = (0..21).map(|i| world.velocity_now(i).length()).fold(fast, f32::max);
        }
        println!("{weight} kg: {worst:.2e}, {fast} m/s");
        assert!(fast < 30.0 && (weight > 1.0 || worst < 0.003), "{weight}: {worst} {fast}");
    }
}

#[test]
fn the_load_of_each_rod_is_what_hangs_on_it_and_of_a_knot_too() {
    let mut world = Simulation::default();
    let [_, end] = loaded(&mut world, 8, Vec3::NEG_Y, MASS);
    let at = world.particles.position(end as usize);
    let ring = push(&mut world, at, 0.5);
    world.distances_mut().push(Distance::new(end, ring, 0.0));
    world.measure_loads(0..9, 0..0);
    for _ in 0..120 {
        world.step(DT).unwrap();
    }
    for rod in 0..9 {
        let below = (8 - rod) as f32 * MASS + 0.5;
        let wanted = below * 9.81;
        let found = world.distance_load(rod).unwrap();
        assert!((found - wanted).abs() < 0.01 * wanted, "rod {rod}: {found} N for {wanted}");
    }
}

#[test]
fn a_box_on_a_rope_stretches_it_little_though_boxes_have_more_rods_than_particles() {
    let swung = |long_range: bool| {
        let mut world = Simulation::default();
        world.settings.long_range = long_range;
        let [_, end] = loaded(&mut world, 20, Vec3::X, MASS);
        let at = world.particles.position(end as usize);
        let first = world.particles.len() as u32;
        let body = box_3d(&BoxSpec { mass: 5.0, ..BoxSpec::default() }).unwrap();
        let corner = body.particles[0].position;
        body.transformed(glam::Quat::IDENTITY, at - corner).build(&mut world).unwrap();
        world.distances_mut().push(Distance::new(end, first, 0.0));
        run(&mut world, 240)
    };
    let ((worst, sweeps), (without, _)) = (swung(true), swung(false));
    println!("{worst:.2e} in {sweeps:.1} sweeps a tick, {without:.2e} without");
    assert!(worst < 0.02 && worst < 0.2 * without, "{worst} {without}");
}

#[test]
fn cut_into_segments_a_chain_is_solved_as_one_rod_after_the_other() {
    let mut numbers = Random::new(1);
    let mut random = || numbers.fraction();
    for (rods, pins) in
        [(65, [true, false]), (100, [false, false]), (163, [true, true]), (999, [true, false])]
    {
        let mut position = Vec::new();
        let mut at = Vec3::ZERO;
        for i in 0..=rods {
            let pinned = i == 0 && pins[0] || i == rods && pins[1];
            let w = if pinned { 0.0 } else { 50.0 * (0.1 + random()) };
            position.push(at.extend(w));
            at += (Vec3::new(0.3, random() - 0.5, random() - 0.5)).normalize()
                * PIECE
                * (1.0 + 0.02 * (random() - 0.5));
        }
        let links: Vec<_> = (0..=rods as u32)
            .map(|i| Link { rows: [i; 2], rods: [i; 2], rest: if i > 0 { PIECE } else { 0.0 } })
            .collect();
        let mut one = position.clone();
        let found = project_one(&links, (&mut one, 0), &mut Vec::new(), &mut |_, _, _| {});
        let rests: Vec<_> = rests_of(&links).collect();
        let mut results = Vec::new();
        for instructions in InstructionSet::ALL {
            let mut cut = position.clone();
            let mut scratch = SegmentScratch::default();
            let worst = scratch.project((&links, &rests), (&mut cut, 0), instructions);
            assert_eq!(worst, found);
            results.push(cut);
        }
        assert!(results.iter().all(|cut| *cut == results[0]));
        let far = one.iter().zip(&position).map(|(a, b)| (a - b).length()).fold(0.0, f32::max);
        let off = one.iter().zip(&results[0]).map(|(a, b)| (a - b).length()).fold(0.0, f32::max);
        println!("{rods} {pins:?}: {off:.2e} of {far:.2e}");
        assert!(off < 1e-3 * far, "{rods} {pins:?}: {off} of {far}");
    }
}
