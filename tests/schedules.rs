//! No two systems of Sinew access the same data in an order that is left to chance: an ambiguity is an error.

use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{PhaseSystems, SinewClock, SinewTick, SubstepSchedule};

use crate::support::{app, bare_app, tick};

/// Builds a schedule of an app anew, with ambiguities as errors.
fn assert_unambiguous(app: &mut App, label: impl ScheduleLabel + Clone) {
    let name = format!("{label:?}");
    app.edit_schedule(label.clone(), |schedule| {
        schedule.set_build_settings(ScheduleBuildSettings {
            ambiguity_detection: LogLevel::Error,
            hierarchy_detection: LogLevel::Error,
            ..default()
        });
    });
    let built = app.world_mut().schedule_scope(label, |world, schedule| {
        assert!(schedule.systems_len() > 0 || name.contains("Update"), "{name} has systems");
        schedule
            .initialize(world)
            .map(|_| ())
            .map_err(|error| error.to_string(schedule.graph(), world))
    });
    assert_eq!(built, Ok(()), "{name}");
}

#[test]
fn the_tick_leaves_no_order_to_chance() {
    for label in [SinewTick.intern(), FixedPostUpdate.intern()] {
        assert_unambiguous(&mut app(), label);
        assert_unambiguous(&mut bare_app(), label);
    }
}

#[test]
fn the_substep_leaves_no_order_to_chance() {
    assert_unambiguous(&mut app(), SubstepSchedule);
}

#[test]
fn the_drawing_leaves_no_order_to_chance() {
    for label in [PostUpdate.intern(), Update.intern(), First.intern(), Last.intern()] {
        assert_unambiguous(&mut app(), label);
    }
}

fn thrust(mut world: ResMut<SinewWorld>) {
    for i in 0..world.particles().len() {
        world.particles_mut().add_force(i, Vec3::X);
    }
}

#[test]
fn a_force_added_as_the_documentation_shows_is_not_ambiguous() {
    let mut app = app();
    app.add_systems(SubstepSchedule, thrust.in_set(PhaseSystems::AccumulateForces));
    assert_unambiguous(&mut app, SubstepSchedule);
}

#[test]
fn two_races_in_a_row_would_be_caught() {
    let mut app = app();
    app.add_systems(
        SubstepSchedule,
        (thrust.in_set(PhaseSystems::Wind), thrust.in_set(PhaseSystems::Wind)),
    );
    app.edit_schedule(SubstepSchedule, |schedule| {
        schedule.set_build_settings(ScheduleBuildSettings {
            ambiguity_detection: LogLevel::Error,
            ..default()
        });
    });
    let built = app
        .world_mut()
        .schedule_scope(SubstepSchedule, |world, schedule| schedule.initialize(world).is_err());
    assert!(built, "the detector fires");
}

#[test]
fn the_plugin_runs_in_a_schedule_of_the_games_choice() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, bevy_sinew::SinewPlugin::in_schedule(Update)));
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(crate::support::TICK));
    app.finish();
    let stone = app.world_mut().spawn(Particle::at(Vec3::ZERO)).id();
    for _ in 0..10 {
        app.update();
    }
    let clock = *app.world().resource::<SinewClock>();
    let expected = -0.5 * 9.81 * clock.seconds * clock.seconds;
    let fallen = f64::from(app.world().get::<Particle>(stone).unwrap().position.y);
    assert!(
        clock.seconds > 0.1 && (fallen - expected).abs() < 0.02 * -expected,
        "{fallen} {expected}"
    );
}

#[test]
fn minimal_plugins_are_enough() {
    let mut app = bare_app();
    app.world_mut().spawn(Ground);
    let body =
        app.world_mut().spawn((RigidBox::default(), Transform::from_xyz(0.0, 2.0, 0.0))).id();
    app.world_mut().spawn((Cloth::default(), Transform::from_xyz(3.0, 2.0, 0.0)));
    app.world_mut().spawn((Rope::default(), Transform::from_xyz(6.0, 2.0, 0.0)));
    tick(&mut app, 240);
    let rest = app.world().get::<Transform>(body).unwrap().translation.y;
    assert!((rest - 0.5).abs() < 0.01, "the box lies on the ground: {rest}");
}
