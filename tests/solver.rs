//! Solver settings of a world and of a body, the report of a body, and worlds far from the origin.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyReport, BodySolver, GradientAt, Integrator};

use crate::support::{bare_app, tick};

/// Spins a box at 10 rad/s in free space with these settings. Returns the share of the spin that is left after two seconds.
fn spin_left(config: SolverConfig, own: BodySolver) -> f32 {
    let mut app = bare_app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0)).insert_resource(config);
    let body = app.world_mut().spawn((RigidBox::default(), own)).id();
    tick(&mut app, 1);
    app.world_mut().entity_mut(body).set_angular_velocity(Vec3::Y * 10.0);
    tick(&mut app, 120);
    app.world().get::<AngularVelocity>(body).unwrap().0.y / 10.0
}

#[test]
fn a_body_keeps_its_spin_unless_keep_spin_is_off_with_current_gradients() {
    let plain = SolverConfig { keep_spin: false, ..default() };
    let nearest = BodySolver { gradient_at: Some(GradientAt::Current), ..default() };
    let start = BodySolver { gradient_at: Some(GradientAt::StepStart), ..default() };
    assert!((spin_left(plain, start) - 1.0).abs() < 0.005);
    // ω₀/√(1 + 2ω₀² h t), h = 1/600.
    let bled = 1.0 / (1.0 + 2.0 * 100.0 / 600.0 * 2.0_f32).sqrt();
    let left = spin_left(plain, nearest);
    assert!((left / bled - 1.0).abs() < 0.02, "{left} of {bled}");
    assert!((spin_left(SolverConfig::default(), nearest) - 1.0).abs() < 0.005);
}

#[test]
fn a_body_with_more_sweeps_has_a_smaller_error_in_its_report() {
    let mut app = bare_app();
    // The test is about sweeps; as long-range chains ropes would need none.
    let config = SolverConfig { max_sweeps: 1, timed: true, long_range: false, ..default() };
    app.insert_resource(config);
    let picky = BodySolver { max_sweeps: Some(60), tolerance: Some(1e-6), ..default() };
    let rope = Rope { pin_start: true, to: Vec3::X, ..default() };
    let plain = app.world_mut().spawn((rope.clone(), BodyReport::default())).id();
    let aside = Transform::from_xyz(0.0, 0.0, 3.0);
    let own = app.world_mut().spawn((rope, BodyReport::default(), picky, aside)).id();
    tick(&mut app, 30);
    let report = |body| *app.world().get::<BodyReport>(body).unwrap();
    let (plain, own) = (report(plain), report(own));
    assert_eq!(plain.sweeps, 10, "one a substep");
    assert!(own.sweeps > 50 && own.error < 0.1 * plain.error, "{own:?} {plain:?}");
    assert!(own.seconds > 0.0 && plain.seconds > 0.0);
}

#[test]
fn the_integrator_is_the_worlds_and_explicit_euler_gains_energy_on_a_spring() {
    let swing = |integrator| {
        let mut app = bare_app();
        app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
        app.insert_resource(SolverConfig { substeps: 1, integrator, ..default() });
        let world = app.world_mut();
        let a = world.spawn((Particle::default(), Pinned::HERE)).id();
        let b = world.spawn(Particle::at(Vec3::X * 1.5)).id();
        world.spawn(Spring::new(a, b, 1.0, 20.0));
        tick(&mut app, 300);
        app.world_mut().resource_mut::<SinewWorld>().ledger().energy() / 2.5
    };
    for integrator in [Integrator::Verlet, Integrator::Leapfrog, Integrator::SemiImplicitEuler] {
        assert!((swing(integrator) - 1.0).abs() < 0.1, "{integrator:?}: {}", swing(integrator));
    }
    assert!(swing(Integrator::ExplicitEuler) > 3.0);
}

#[test]
fn statics_brings_a_slack_rope_to_its_catenary() {
    let mut app = bare_app();
    app.insert_resource(SolverConfig {
        statics: true,
        max_sweeps: 50,
        tolerance: 1e-6,
        ..default()
    });
    // 1.5 m of rope between two pins 1 m apart.
    let rope =
        Rope { to: Vec3::X, slack: 0.5, segments: 20, pin_start: true, pin_end: true, ..default() };
    let body = app.world_mut().spawn(rope).id();
    app.insert_resource(Gravity(Vec3::Y * -9.81 * 100.0));
    tick(&mut app, 600);
    let members = app.world().get::<bevy_sinew::BodyParticles>(body).unwrap();
    let lowest = members.iter().map(|p| app.world().get::<Particle>(p).unwrap().position.y);
    let sag = -lowest.fold(f32::INFINITY, f32::min);
    assert!((sag / 0.50345 - 1.0).abs() < 0.005, "{sag}");
}

#[test]
fn a_world_five_kilometres_away_has_the_same_bits_as_one_at_the_origin() {
    // The same start to the bit: rounded to a grid that f32 can represent at that distance.
    let turn = Quat::from_xyzw(0.1, 0.2, 0.3, 0.927_361_85);
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
        let place = turn * Vec3::new(side(0), side(1), side(2)) + Vec3::Y * 2.0;
        (place * 1024.0).round() / 1024.0
    };
    let scene = |offset: Vec3| {
        let mut app = bare_app();
        let world = app.world_mut();
        world.spawn((Ground, Transform::from_translation(offset)));
        let place = Transform::from_translation(offset + Vec3::Y * 2.0);
        let body = world.spawn((RigidBox::new(Vec3::ONE), place)).id();
        tick(&mut app, 1);
        let members = app.world().get::<bevy_sinew::BodyParticles>(body).unwrap();
        let members: Vec<_> = members.iter().collect();
        for (&member, i) in members.iter().zip(0..) {
            *app.world_mut().get_mut(member).unwrap() = Particle::at(offset + corner(i));
        }
        tick(&mut app, 600);
        let state = members.iter().map(|&member| *app.world().get::<Particle>(member).unwrap());
        let seen = state.map(|p| ((p.position - offset) + p.remainder, p.velocity));
        (seen.collect::<Vec<_>>(), app.world().get::<Transform>(body).unwrap().rotation)
    };
    let (home, far) = (scene(Vec3::ZERO), scene(Vec3::new(5000.0, 64.0, -4000.0)));
    for (a, b) in home.0.iter().zip(&far.0) {
        assert_eq!(a.1, b.1, "velocities");
        assert!(a.0.distance(b.0) < 1e-6, "{} and {}", a.0, b.0);
    }
    assert!(home.1.angle_between(far.1) < 1e-3);
}
