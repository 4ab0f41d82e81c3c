//! The phases run in their documented order, as often as there are substeps in a tick, and the systems of a game fit in between.

use core::time::Duration;

use bevy::ecs::schedule::ScheduleConfigs;
use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    Charge, Electric, ParticleRow, PhaseStep, PhaseSteps, PhaseSystems, SinewClock, SinewSnapshot,
    SinewSystems, SinewTick, SubstepSchedule, TickTime,
};

use crate::support::{TICK, app_with, bare_app, position, tick};

/// What ran, in order.
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
        // Added backwards, so that the order of adding cannot be what puts them right.
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
    // In the schedule that runs the tick, the whole tick is one system that is in all of its sets.
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

/// Acceleration and position of the watched particle's row at each point of the substep.
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
    // One particle on which everything acts: in wind (as part of a sheet), half in water, charged, and tied to a hook.
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

/// With and without measuring: a cape in a wind, which takes its substeps one by one anyway, and a rope without wind, which takes them all at once.
#[test]
fn measuring_the_phases_changes_nothing_else() {
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
    let ((usual, hash), (measured, same)) = (run(false), run(true));
    assert_eq!(hash, same);
    assert_eq!(usual.phases, [Duration::ZERO; 6]);
    assert!(measured.phases.iter().all(|phase| !phase.is_zero()), "{measured:?}");
    assert!(measured.phases.iter().sum::<Duration>() <= measured.substeps, "{measured:?}");
    assert!(!usual.gather.is_zero() && !usual.substeps.is_zero() && !usual.scatter.is_zero());
}

/// An app with a rope that swings, a crate that rests on the ground, and a cloth in the wind.
fn busy() -> App {
    let mut app = bare_app();
    app.world_mut().spawn(Ground);
    app.world_mut().spawn(Rope::between(Vec3::Y * 2.0, Vec3::new(1.0, 2.0, 0.0)));
    app.world_mut().spawn((RigidBox::new(Vec3::ONE), Transform::from_xyz(3.0, 0.5, 0.0)));
    app.world_mut().spawn((Cloth::grid(1.0, 1.0, 6, 6), Transform::from_xyz(0.0, 2.0, 3.0)));
    app.world_mut().spawn(Wind::default());
    app.insert_resource(SolverConfig { substeps: 3, ..default() });
    tick(&mut app, 10);
    app
}

fn hash(app: &App) -> u64 {
    SinewSnapshot::capture(app.world()).hash()
}

fn half_step(app: &mut App) -> Option<PhaseStep> {
    let world = app.world_mut();
    world.resource_scope(|world, mut phases: Mut<PhaseSteps>| {
        phases.step(&mut world.resource_mut::<SinewControl>());
    });
    tick(app, 1);
    app.world().resource::<PhaseSteps>().shown()
}

/// Positions and accelerations of all particles in the columns.
fn columns(app: &App) -> (Vec<Vec3>, Vec<Vec3>) {
    let particles = app.world().resource::<SinewWorld>().particles();
    let rows = 0..particles.len();
    (
        rows.clone().map(|i| particles.position(i)).collect(),
        rows.map(|i| particles.acceleration(i)).collect(),
    )
}

#[test]
fn half_steps_show_each_phase_of_a_tick_and_end_in_the_same_bits() {
    let [mut whole, mut halves] = [busy(), busy()];
    for app in [&mut whole, &mut halves] {
        app.world_mut().resource_mut::<SinewControl>().pause();
    }
    let before = columns(&halves).0;
    whole.world_mut().resource_mut::<SinewControl>().step();
    // And a paused frame, in which the velocities of bodies are read off anew, to other last digits.
    tick(&mut whole, 2);
    let after = hash(&whole);
    let mut seen = Vec::new();
    for number in 0..18 {
        let shown = half_step(&mut halves).unwrap_or_else(|| panic!("half-step {number}"));
        assert_eq!((shown.substep, shown.substeps), (number / 6 + 1, 3));
        assert_eq!(shown.phase, PHASES[number as usize % 6].0);
        let next = (number < 17).then(|| PHASES[(number as usize + 1) % 6].0);
        assert_eq!(shown.next, next);
        // Frames that pass meanwhile change nothing.
        let now = columns(&halves);
        tick(&mut halves, 2);
        assert_eq!(columns(&halves), now);
        assert_eq!(hash(&halves), after, "a save in between is one of the tick's end");
        seen.push(now);
    }
    assert!(seen[..4].iter().all(|(places, _)| *places == before), "only Integrate moves");
    assert_ne!(seen[4].0, before);
    assert_ne!(seen[0].1, seen[1].1, "the wind pushes");
    assert_ne!(seen[4].0, seen[5].0, "constraints correct");
    assert_eq!(half_step(&mut halves), None, "the end");
    assert_eq!((hash(&halves), columns(&halves).0), (after, columns(&whole).0));
    // Both go on alike, the second again by half-steps.
    whole.world_mut().resource_mut::<SinewControl>().step();
    tick(&mut whole, 2);
    (0..19).for_each(|_| _ = half_step(&mut halves));
    assert_eq!(hash(&halves), hash(&whole));
    assert_eq!(halves.world().resource::<SinewClock>().tick, 12);
}

#[test]
fn steps_restores_and_spawns_between_half_steps_start_from_a_whole_tick() {
    let mut app = busy();
    app.world_mut().resource_mut::<SinewControl>().pause();
    tick(&mut app, 1);
    let start = SinewSnapshot::capture(app.world());
    app.world_mut().resource_mut::<SinewControl>().single_steps = 2;
    tick(&mut app, 2);
    let second = hash(&app);
    let shown = |app: &App| app.world().resource::<PhaseSteps>().shown();

    start.restore(app.world_mut()).unwrap();
    tick(&mut app, 1);
    let rested = hash(&app);
    assert_eq!(
        rested,
        start.hash(),
        "velocities too are those of the snapshot, though no step has read them off"
    );
    tick(&mut app, 3);
    assert_eq!(hash(&app), rested, "for as long as time stands still");
    (0..7).for_each(|_| _ = half_step(&mut app));
    assert!(shown(&app).is_some());
    // A whole step goes on from the end of the tick, and so does the simulation when it is unpaused.
    app.world_mut().resource_mut::<SinewControl>().step();
    tick(&mut app, 1);
    assert_eq!((shown(&app), hash(&app)), (None, second));
    start.restore(app.world_mut()).unwrap();
    tick(&mut app, 1);
    (0..7).for_each(|_| _ = half_step(&mut app));
    app.world_mut().resource_mut::<SinewControl>().unpause();
    tick(&mut app, 1);
    assert_eq!(shown(&app), None);
    app.world_mut().resource_mut::<SinewControl>().pause();

    // A restored snapshot ends the showing, and so does a new body.
    (0..7).for_each(|_| _ = half_step(&mut app));
    start.restore(app.world_mut()).unwrap();
    tick(&mut app, 1);
    assert_eq!((shown(&app), hash(&app)), (None, rested));
    (0..7).for_each(|_| _ = half_step(&mut app));
    app.world_mut().spawn(Particle::default());
    tick(&mut app, 2);
    assert_eq!(shown(&app), None);
    // A world that is not paused takes no half-steps.
    app.world_mut().resource_mut::<SinewControl>().unpause();
    assert_eq!(half_step(&mut app), None);
}

#[test]
fn global_transforms_are_those_of_the_phase_that_is_shown() {
    let mut app = app_with(());
    let body = (RigidBox::new(Vec3::ONE), Transform::from_xyz(0.0, 5.0, 0.0));
    let body = app.world_mut().spawn(body).id();
    let hat = app.world_mut().spawn((Transform::from_xyz(0.0, 1.0, 0.0), ChildOf(body))).id();
    tick(&mut app, 10);
    app.world_mut().resource_mut::<SinewControl>().pause();
    tick(&mut app, 2);
    let seen =
        |app: &App, entity| app.world().get::<GlobalTransform>(entity).unwrap().translation().y;
    let own = |app: &App| app.world().get::<Transform>(body).unwrap().translation.y;
    let before = own(&app);
    assert_eq!(seen(&app, body), before);
    let phase = half_step(&mut app).map(|shown| shown.phase);
    assert_eq!(phase, Some(PhaseSystems::AccumulateForces));
    let after = own(&app);
    assert!(after < before - 0.01, "the component is of the tick's end");
    assert!((seen(&app, body) - before).abs() < 1e-5, "and what is seen is not");
    assert!((seen(&app, hat) - before - 1.0).abs() < 1e-4, "nor what hangs on it");
    (0..4).for_each(|_| _ = half_step(&mut app));
    let fallen = seen(&app, body);
    assert!(fallen < before - 1e-3 && fallen > after + 1e-3, "{before} {fallen} {after}");
    app.world_mut().resource_mut::<PhaseSteps>().end();
    tick(&mut app, 1);
    assert_eq!((seen(&app, body), seen(&app, hat)), (after, after + 1.0));
}

#[test]
fn a_games_system_between_phases_runs_once_per_substep_under_half_steps() {
    let mut app = busy();
    app.init_resource::<Log>()
        .add_systems(SubstepSchedule, note("wind").in_set(PhaseSystems::Wind));
    app.world_mut().resource_mut::<SinewControl>().pause();
    (0..19).for_each(|_| _ = half_step(&mut app));
    assert_eq!(app.world().resource::<Log>().0.len(), 3, "once a substep");
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

/// Heights of a rocket of 2 kg and of a stone beside it after a second.
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

/// Regression: in a world that took its substeps at once a system that was added later never ran, because the schedule counted its systems only when it ran,
/// and ran only if it had counted any.
#[test]
fn a_games_own_system_that_is_added_later_runs() {
    for falls in [true, false] {
        let mut app = bare_app();
        let world = app.world_mut();
        let ball = world.spawn((Rocket, Particle::at(Vec3::Y), Radius(0.1))).id();
        if !falls {
            let ground = Transform::from_xyz(0.0, 0.4, 0.0);
            world.spawn((Collider::cuboid(Vec3::ONE), ground));
            world.entity_mut(ball).insert(Sleep::default());
        }
        tick(&mut app, 90);
        let before = app.world().get::<Particle>(ball).unwrap().velocity.y;
        app.add_systems(SubstepSchedule, thrust.in_set(PhaseSystems::AccumulateForces));
        tick(&mut app, 3);
        let after = app.world().get::<Particle>(ball).unwrap().velocity.y;
        assert!(after > before + 0.3, "{falls}: {before} to {after} m/s");
    }
}

#[test]
fn a_games_own_projection_between_integrate_and_solve_holds() {
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
