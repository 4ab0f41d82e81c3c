//! Solver settings of single bodies.

use sinew::glam::Vec3;
use sinew::recipes::{BoxLayout, BoxSpec, RopeSpec, box_3d, rope};
use sinew::{BodySettings, Bound, Distance, GradientAt, Representation, Simulation};

#[test]
fn a_body_may_have_more_sweeps_than_its_world_and_its_neighbour_is_not_affected() {
    let scene = |picky: bool| {
        let mut world = Simulation::default();
        world.settings.max_sweeps = 1;
        // Tethers would leave no error to sweep.
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

/// Nearest-point corrections lose spin. The solver restores it to bodies with `keep_spin`, the default, together with the bodies that constraints connect to
/// them.
#[test]
fn a_body_may_turn_off_keep_spin_and_then_loses_spin() {
    let spinning = |asked: [Option<bool>; 2], tied: bool| {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::ZERO;
        for (number, keep_spin) in asked.into_iter().enumerate() {
            let at = Vec3::X * (5.0 * number as f32);
            let spec = BoxSpec { layout: BoxLayout::Corners, ..Default::default() };
            let body = box_3d(&spec).unwrap().transformed(Default::default(), at);
            for i in body.build(&mut world).unwrap() {
                let arm = world.particles.position(i) - at;
                world.particles.set_velocity(i, Vec3::new(0.0, 9.0, 3.0).cross(arm));
            }
            let own = &mut world.bodies[number];
            own.gradient_at = Some(GradientAt::Current);
            (own.keep_spin, own.representation) = (keep_spin, Representation::Particles);
        }
        if tied {
            let gap = world.particles.position(0).distance(world.particles.position(8));
            world.distances_mut().push(Distance::new(0, 8, 2.0 * gap).with_bound(Bound::AtMost));
        }
        let spin = |world: &Simulation, first: usize| {
            let rows = first..first + 8;
            let centre = rows.clone().map(|i| world.particles.position(i)).sum::<Vec3>() / 8.0;
            let of = |i| (world.particles.position(i) - centre).cross(world.particles.velocity(i));
            rows.map(of).sum::<Vec3>().length()
        };
        let (before, all) = (spin(&world, 0), world.ledger().angular_momentum);
        for _ in 0..120 {
            world.step(1.0 / 60.0).unwrap();
        }
        let now = world.ledger().angular_momentum;
        let [one, other] = [0, 8].map(|first| spin(&world, first) / before);
        [one, other, ((now - all).length() / all.length()) as f32]
    };
    let [lost, kept, _] = spinning([Some(false), None], false);
    assert!(lost < 0.95 && (kept - 1.0).abs() < 1e-4, "{lost}, {kept}");
    let [.., drift] = spinning([Some(false), Some(true)], true);
    assert!(drift < 1e-4, "together, {drift}");
    let [.., drift] = spinning([Some(false); 2], true);
    assert!(drift > 0.05, "and where neither keeps it, {drift}");
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
        // If both are set, the tolerance in metres is used.
        let both = BodySettings { tolerance: Some(1e-5), ..as_speed };
        assert_eq!(swung(substeps, both), swung(substeps, metres(1e-5)), "{substeps}");
    }
    // Negative and non-finite values count as zero.
    for none in [-1.0, f32::NAN, f32::INFINITY] {
        let own = BodySettings { tolerance_speed: Some(none), ..Default::default() };
        assert_eq!(own.over(Default::default(), 0.01).tolerance, 0.0, "{none}");
    }
}
