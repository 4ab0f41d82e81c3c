//! The phases run in their documented order, substeps times in a tick, and the systems of a game fit in between.

use core::time::Duration;

use bevy::ecs::schedule::ScheduleConfigs;
use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    Charge, Electric, ParticleRow, PhaseSystems, SinewClock, SinewSnapshot, SinewSystems,
    SinewTick, SubstepSchedule, TickTime,
};

use crate::support::{TICK, bare_app, position, tick};

/// What happened, in order.
#[derive(Resource, Default)]
struct Log(Vec<&'static str>);

fn note(what: &'static str) -> ScheduleConfigs<ScheduleSystem> {
    (move |mut log: ResMut<Log>| log.0.push(what)).into_configs()
}

const PHASES: [(PhaseSystems, &str); 6] = [
    (PhaseSystems::AccumulateForces, "forces"),
    (PhaseSystems::Wind, "wind"),
    (PhaseSystems::Buoyancy, "buoyancy"),
    (PhaseSystems::Electric, "electric"),
    (PhaseSystems::Integrate, "integrate"),
    (PhaseSystems::SolveConstraints, "solve"),
];

#[test]
fn the_phases_run_in_their_order_as_often_as_there_are_substeps() {
    for substeps in [1, 3, 10] {
        let mut app = bare_app();
        app.init_resource::<Log>().insert_resource(SolverConfig { substeps, ..default() });
        // Added backwards, so that it is not the order of adding that puts them right.
        for (set, name) in PHASES.into_iter().rev() {
            app.add_systems(SubstepSchedule, note(name).in_set(set));
        }
        app.world_mut().spawn(Particle::default());
        tick(&mut app, 2);
        let once: Vec<&str> = PHASES.iter().map(|(_, name)| *name).collect();
        let expected = once.repeat(2 * substeps as usize);
        assert_eq!(app.world().resource::<Log>().0, expected, "{substeps} substeps");
    }
}

#[test]
fn a_tick_builds_gathers_steps_scatters_and_extracts_in_this_order() {
    let mut app = bare_app();
    app.init_resource::<Log>().insert_resource(SolverConfig { substeps: 2, ..default() });
    let sets = [
        (SinewSystems::Extract, "extract"),
        (SinewSystems::Scatter, "scatter"),
        (SinewSystems::Gather, "gather"),
        (SinewSystems::Build, "build"),
    ];
    for (set, name) in sets {
        app.add_systems(SinewTick, note(name).in_set(set));
    }
    app.add_systems(SubstepSchedule, note("substep").in_set(PhaseSystems::Integrate));
    // Where the tick is run, all of it is one system, in all of its sets.
    app.add_systems(FixedPostUpdate, note("before").before(SinewSystems::Build))
        .add_systems(FixedPostUpdate, note("after").after(SinewSystems::Extract));
    app.world_mut().spawn(Particle::default());
    tick(&mut app, 1);
    let expected =
        ["before", "build", "gather", "substep", "substep", "scatter", "extract", "after"];
    assert_eq!(app.world().resource::<Log>().0, expected);
}

#[test]
fn a_world_without_particles_takes_no_substeps_and_time_passes_all_the_same() {
    let mut app = bare_app();
    app.init_resource::<Log>();
    app.add_systems(SubstepSchedule, note("substep").in_set(PhaseSystems::Integrate));
    tick(&mut app, 7);
    assert!(app.world().resource::<Log>().0.is_empty());
    let empty = *app.world().resource::<SinewClock>();
    let mut app = bare_app();
    app.world_mut().spawn(Particle::default());
    tick(&mut app, 7);
    assert_eq!(empty, *app.world().resource::<SinewClock>(), "to the last bit");
    assert_eq!(empty.tick, 7);
}

/// What a particle's row shows at one point of the substep.
#[derive(Resource, Default)]
struct Seen(Vec<(&'static str, Vec3, Vec3)>);

fn look(at: &'static str) -> ScheduleConfigs<ScheduleSystem> {
    (move |world: Res<SinewWorld>,
           rows: Query<&ParticleRow, With<Watched>>,
           mut seen: ResMut<Seen>| {
        let row = rows.single().unwrap().get().unwrap();
        let particles = world.particles();
        seen.0.push((at, particles.acceleration(row), particles.position(row)));
    })
    .into_configs()
}

#[derive(Component)]
struct Watched;

#[test]
fn each_phase_does_its_own_work_in_its_own_set_and_no_other() {
    let mut app = bare_app();
    app.init_resource::<Seen>()
        .insert_resource(SolverConfig { substeps: 1, ..default() })
        .insert_resource(AirDrag(0.0))
        .insert_resource(Electric { constant: 1.0, softening: 0.0, ..default() });
    let world = app.world_mut();
    // One particle that feels everything: in wind (as part of a sheet), half in water, charged, and tied to a hook.
    let start = Vec3::new(0.0, 1.0, 0.0);
    let watched = world.spawn((Particle::at(start), Radius(0.1), Charge(1.0), Watched)).id();
    let pinned = |at: Vec3| (Particle::at(at), Pinned::HERE, Charge(1.0));
    let hook = world.spawn(pinned(start + Vec3::X)).id();
    let corner = world.spawn(pinned(start + Vec3::Y)).id();
    world.spawn(DistanceConstraint::new(watched, hook, 1.0));
    world.spawn(bevy_sinew::WindSurface { triangles: vec![[watched, hook, corner]] });
    world.spawn(Wind { pressure: Vec3::Z * 6.0, ..default() });
    world.spawn((Fluid::default(), Transform::from_xyz(0.0, 1.0, 0.0)));
    for ((before, _), (after, name)) in PHASES.iter().zip(&PHASES[1..]) {
        app.add_systems(SubstepSchedule, look(name).after(*before).before(*after));
    }
    app.add_systems(SubstepSchedule, look("end").after(PhaseSystems::SolveConstraints));
    tick(&mut app, 1);

    let seen = &app.world().resource::<Seen>().0;
    let [wind, buoyancy, electric, integrate, solve, end] = seen[..] else { panic!("{seen:?}") };
    assert_eq!(wind, ("wind", Vec3::Y * -9.81, start), "before wind there is gravity alone");
    // Half a square metre at 6 Pa, a third of it on each corner.
    assert!((buoyancy.1 - wind.1).abs_diff_eq(Vec3::Z, 1e-5), "{seen:?}");
    let up = electric.1 - buoyancy.1;
    assert!(up.y > 1.0 && up.x == 0.0 && up.z == 0.0, "water lifts: {seen:?}");
    let pushed = integrate.1 - electric.1;
    assert!(pushed.abs_diff_eq(Vec3::new(-1.0, -1.0, 0.0), 1e-5), "charges repel: {seen:?}");
    assert!(seen[..4].iter().all(|(_, _, place)| *place == start), "only now does it move");
    let far = solve.2.distance(Vec3::new(1.0, 1.0, 0.0));
    assert!((far - 1.0).abs() > 1e-4, "predicted freely: {far}");
    let far = end.2.distance(Vec3::new(1.0, 1.0, 0.0));
    assert!((far - 1.0).abs() < 1e-5, "and then held by its rod: {far}");
}

/// Whether it is asked for or not: a cape with a wind, which takes its substeps one by one anyway, and a rope without, which takes them at once.
#[test]
fn phases_are_measured_where_that_is_asked_for_and_nothing_else_changes() {
    let run = |by_phase: bool| {
        let mut app = bare_app();
        app.world_mut().resource_mut::<TickTime>().by_phase = by_phase;
        app.world_mut().spawn(Rope::between(Vec3::ZERO, Vec3::X));
        tick(&mut app, 3);
        app.world_mut().spawn((Cloth::grid(1.0, 1.0, 6, 6), Transform::from_xyz(0.0, 0.0, 3.0)));
        app.world_mut().spawn(Wind::default());
        tick(&mut app, 5);
        let took = *app.world().resource::<TickTime>();
        (took, SinewSnapshot::capture(app.world_mut()).hash())
    };
    let ((usual, hash), (asked, same)) = (run(false), run(true));
    assert_eq!(hash, same);
    assert_eq!(usual.phases, [Duration::ZERO; 6]);
    assert!(asked.phases.iter().all(|phase| !phase.is_zero()), "{asked:?}");
    assert!(asked.phases.iter().sum::<Duration>() <= asked.substeps, "{asked:?}");
    assert!(!usual.gather.is_zero() && !usual.substeps.is_zero() && !usual.scatter.is_zero());
}

#[derive(Component)]
struct Rocket;

fn thrust(mut world: ResMut<SinewWorld>, rockets: Query<&ParticleRow, With<Rocket>>) {
    for row in &rockets {
        if let Some(i) = row.get() {
            world.particles_mut().add_force(i, Vec3::Y * 20.0);
        }
    }
}

/// A rocket of 2 kg beside a stone: their heights after a second.
fn launched(place: ScheduleConfigs<ScheduleSystem>) -> (f32, f32) {
    let mut app = bare_app();
    app.insert_resource(AirDrag(0.0)).add_systems(SubstepSchedule, place);
    let world = app.world_mut();
    let stone = world.spawn((Particle::at(Vec3::X), Mass(2.0))).id();
    let rocket = world.spawn((Particle::at(Vec3::ZERO), Mass(2.0), Rocket)).id();
    tick(&mut app, 60);
    (position(&app, rocket).y, position(&app, stone).y)
}

#[test]
fn a_games_own_force_acts_in_a_set_and_between_any_two() {
    let seconds = 60.0 * TICK.as_secs_f32();
    let fallen = -0.5 * 9.81 * seconds * seconds;
    let risen = 0.5 * (20.0 / 2.0 - 9.81) * seconds * seconds;
    let places = [
        thrust.in_set(PhaseSystems::AccumulateForces),
        thrust.in_set(PhaseSystems::Wind),
        thrust.after(PhaseSystems::AccumulateForces).before(PhaseSystems::Wind),
        thrust.after(PhaseSystems::Buoyancy).before(PhaseSystems::Electric),
        thrust.after(PhaseSystems::Electric).before(PhaseSystems::Integrate),
    ];
    for (case, place) in places.into_iter().enumerate() {
        let (rocket, stone) = launched(place);
        assert!((rocket - risen).abs() < 1e-4, "case {case}: {rocket} instead of {risen}");
        assert!((stone - fallen).abs() < 1e-4, "case {case}: {stone} instead of {fallen}");
    }
}

#[test]
fn a_games_own_constraint_between_integrate_and_solve_is_obeyed() {
    let mut app = bare_app();
    let ceiling = |mut world: ResMut<SinewWorld>| {
        for i in 0..world.particles().len() {
            let mut place = world.particles().position(i);
            place.y = place.y.max(-0.5);
            world.particles_mut().set_position(i, place);
        }
    };
    app.add_systems(
        SubstepSchedule,
        ceiling.after(PhaseSystems::Integrate).before(PhaseSystems::SolveConstraints),
    );
    let stone = app.world_mut().spawn(Particle::at(Vec3::ZERO)).id();
    tick(&mut app, 120);
    let state = *app.world().get::<Particle>(stone).unwrap();
    assert_eq!(state.position.y, -0.5);
    assert!(state.velocity.y.abs() < 1e-3, "its velocity follows from where it ended: {state:?}");
}
