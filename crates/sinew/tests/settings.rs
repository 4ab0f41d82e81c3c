//! What bodies ask of the solver for themselves.

use sinew::glam::Vec3;
use sinew::recipes::{RopeSpec, rope};
use sinew::{BodySettings, Simulation};

#[test]
fn a_body_may_ask_for_more_than_its_world_and_its_neighbour_does_not_notice() {
    let scene = |picky: bool| {
        let mut world = Simulation::default();
        world.settings.max_sweeps = 1;
        // Tethers would leave nothing to sweep for.
        world.settings.long_range = false;
        for x in [0.0, 5.0] {
            let spec = RopeSpec { segments: 20, pin_start: true, ..Default::default() };
            let body = rope(&spec).unwrap().transformed(Default::default(), Vec3::X * x);
            let rows = body.build(&mut world).unwrap();
            rows.for_each(|i| world.particles.set_body(i, Some(u32::from(x > 0.0))));
        }
        let own =
            BodySettings { max_sweeps: Some(50), tolerance: Some(1e-6), ..Default::default() };
        *world.bodies = vec![Default::default(), if picky { own } else { Default::default() }];
        for _ in 0..60 {
            world.step(1.0 / 60.0).unwrap();
        }
        world
    };
    let (plain, picky) = (scene(false), scene(true));
    let report = |world: &Simulation, row| *world.island_report(row).unwrap();
    assert_eq!(report(&picky, 0), report(&plain, 0));
    assert!(report(&picky, 21).error < 0.1 * report(&plain, 21).error);
    for i in 0..21 {
        assert_eq!(picky.particles.position(i), plain.particles.position(i));
    }
}

#[test]
fn a_tolerance_as_a_speed_is_so_many_metres_in_a_substep() {
    let swung = |substeps: u32, own: BodySettings| {
        let mut world = Simulation::default();
        world.settings.substeps = substeps;
        world.settings.long_range = false;
        let spec = RopeSpec { segments: 20, pin_start: true, ..Default::default() };
        rope(&spec).unwrap().build(&mut world).unwrap();
        (0..world.particles.len()).for_each(|i| world.particles.set_body(i, Some(0)));
        *world.bodies = vec![BodySettings { max_sweeps: Some(100), ..own }];
        let mut sweeps = 0;
        for _ in 0..60 {
            world.step(1.0 / 60.0).unwrap();
            let report = world.island_report(0).unwrap();
            sweeps += report.sweeps;
        }
        let positions = (0..world.particles.len()).map(|i| world.particles.position(i));
        (sweeps / substeps, positions.collect::<Vec<_>>())
    };
    let as_speed = BodySettings { tolerance_speed: Some(0.06), ..Default::default() };
    let metres = |tolerance: f32| BodySettings { tolerance: Some(tolerance), ..Default::default() };
    for substeps in [2, 10, 40] {
        let h = (1.0 / 60.0) / substeps as f32;
        let (found, same) = (swung(substeps, as_speed), swung(substeps, metres(0.06 * h)));
        assert_eq!(found, same, "{substeps}");
        assert_ne!(found, swung(substeps, metres(0.12 * h)), "{substeps}");
        // Where both are told, metres count.
        let both = BodySettings { tolerance: Some(1e-5), ..as_speed };
        assert_eq!(swung(substeps, both), swung(substeps, metres(1e-5)), "{substeps}");
    }
    // Less than none, and what is no number, are none.
    for none in [-1.0, f32::NAN, f32::INFINITY] {
        let own = BodySettings { tolerance_speed: Some(none), ..Default::default() };
        assert_eq!(own.over(Default::default(), 0.01).tolerance, 0.0, "{none}");
    }
}
