//! Temporal blocking: a large cloth that goes through a step in columns, on one thread or pipelined over several, has the bits of phase-by-phase stepping.

use core::sync::atomic::{AtomicUsize, Ordering};
use std::sync::Arc;

use crate::threads::Threads;
use sinew::glam::Vec3;
use sinew::recipes::{ClothMaterial, ClothSpec, cloth_grid};
use sinew::{Simulation, Workers};

/// Only rods, held by two pins. Such a cloth is solved as a wavefront, larger than the sliding window; the result has the bits of phase-by-phase stepping, also
/// after a step at once, with a step of another length, and with drag.
#[test]
fn a_wavefront_through_a_cloth_has_the_bits_of_its_phases_one_by_one() {
    for (side, substeps, sweeps) in [(131, 5, 1), (40, 1, 1), (40, 3, 1), (40, 3, 3)] {
        let mut world = sheet(side);
        world.settings.substeps = substeps;
        world.settings.max_sweeps = sweeps;
        world.settings.tolerance = 2e-3;
        world.forces.drag = 0.3;
        for i in 0..world.particles.len() {
            world.particles.set_velocity(i, Vec3::new(0.1, 0.0, 0.2 * (i % 7) as f32));
        }
        let mut phases = world.clone();
        for dt in [1.0 / 60.0, 1.0 / 50.0, 1.0 / 60.0, 1.0 / 60.0] {
            step_both(&mut world, &mut phases, dt);
        }
    }
}

/// Steps one world at once, and its copy phase by phase, and compares them.
fn step_both(world: &mut Simulation, phases: &mut Simulation, dt: f32) {
    world.step(dt).unwrap();
    let substeps = phases.begin_step(dt).unwrap();
    assert!(phases.is_undisturbed());
    for _ in 0..substeps {
        phases.begin_substep();
        phases.accumulate_forces();
        phases.integrate();
        phases.solve_constraints();
    }
    phases.end_step();
    for i in 0..world.particles.len() {
        let of = |world: &Simulation| (world.particles.seed(i), world.velocity_now(i));
        assert_eq!(of(world), of(phases), "{} particles, particle {i}", world.particles.len());
    }
    assert_eq!(world.report(), phases.report());
}

/// The same for a cloth that takes microsteps and ends the step with relaxation, but has no spans because it is narrow, or because long ranges are off. As a
/// wavefront it was not relaxed: of 10 × 10 cells, particles were 3 cm away after half a second, and with long ranges off strains were 16 % instead of 6 %.
#[test]
fn a_cloth_that_is_relaxed_at_the_end_of_a_step_has_the_bits_of_its_phases_one_by_one() {
    for (side, long_range) in [(11, true), (21, false)] {
        let mut world = sheet(side);
        world.settings.long_range = long_range;
        for i in 0..world.particles.len() {
            world.particles.set_velocity(i, Vec3::new(0.1, 0.0, 0.2 * (i % 7) as f32));
        }
        let mut phases = world.clone();
        for _ in 0..10 {
            step_both(&mut world, &mut phases, 1.0 / 60.0);
        }
    }
}

/// A cloth of seventy thousand rods in a pipelined wavefront, where each thread takes it through some of the substeps: the same bits as on one thread, and only
/// one parallel call a step.
#[test]
fn a_pipelined_wavefront_through_a_large_cloth_has_the_bits_of_one_thread() {
    for (substeps, threads) in [(6, 2), (6, 3), (5, 2), (1, 3), (4, 8)] {
        let mut one = sheet(131);
        one.settings.substeps = substeps;
        one.settings.max_sweeps = 1;
        one.forces.drag = 0.3;
        let (mut many, meetings) = (one.clone(), Arc::new(AtomicUsize::new(0)));
        many.workers = Some(Arc::new(Counting(Threads(threads), meetings.clone())));
        for tick in 0..4 {
            one.step(1.0 / 60.0).unwrap();
            many.step(1.0 / 60.0).unwrap();
            for i in 0..one.particles.len() {
                let of = |world: &Simulation| (world.particles.seed(i), world.velocity_now(i));
                assert_eq!(of(&one), of(&many), "{threads} threads, tick {tick}, particle {i}");
            }
            assert_eq!(one.report(), many.report());
        }
        assert!(
            meetings.load(Ordering::Relaxed) <= 4,
            "{substeps} substeps: {meetings:?} meetings"
        );
    }
}

/// The same where sweeps depend on each other: one cloth that a single thread solves faster, and one for which the threads synchronise after each stage.
#[test]
fn threads_that_share_the_sweeps_of_a_large_cloth_have_the_bits_of_one_thread() {
    for (side, sweeps) in [(127, 3), (190, 3), (190, 4)] {
        let mut one = sheet(side);
        one.settings.substeps = 2;
        // Four sweeps make two microsteps, which have spans.
        one.settings.max_sweeps = sweeps;
        let (mut many, meetings) = (one.clone(), Arc::new(AtomicUsize::new(0)));
        many.workers = Some(Arc::new(Counting(Threads(3), meetings.clone())));
        for _ in 0..4 {
            one.step(1.0 / 60.0).unwrap();
            many.step(1.0 / 60.0).unwrap();
            for i in 0..one.particles.len() {
                assert_eq!(one.particles.seed(i), many.particles.seed(i), "particle {i}");
            }
            assert_eq!(one.report(), many.report());
        }
        let met = meetings.load(Ordering::Relaxed);
        assert_eq!(met > 0, side == 190, "{met} meetings");
    }
}

/// A square cloth of `side` particles along a side, 0.1 m apart, pinned at its corners.
fn sheet(side: u32) -> Simulation {
    let mut world = Simulation::default();
    let material = ClothMaterial { bend_compliance: None, ..Default::default() };
    let (cells, width) = (side - 1, 0.1 * side as f32);
    let spec = ClothSpec {
        columns: cells,
        rows: cells,
        width,
        height: width,
        material,
        ..Default::default()
    };
    let mut cloth = cloth_grid(&spec).unwrap();
    for corner in spec.corners() {
        cloth.pin(corner).unwrap();
    }
    cloth.build(&mut world).unwrap();
    world
}

/// Threads, and a count of the parallel calls.
#[derive(Debug)]
struct Counting(Threads, Arc<AtomicUsize>);

impl Workers for Counting {
    fn run(&self, work: &(dyn Fn() + Sync)) {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.run(work);
    }

    fn threads(&self) -> usize {
        self.0.threads()
    }
}
