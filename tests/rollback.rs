//! Rollback netcode through `bevy_ggrs`: a thousand frames, each of them rolled back and simulated again, give the same state; and what is forgotten is
//! found.

use core::time::Duration;

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_ggrs::ggrs::{PlayerType, SessionBuilder};
use bevy_ggrs::{
    GgrsConfig, GgrsPlugin, GgrsSchedule, LocalInputs, ReadInputs, RollbackFrameCount, Session,
    SyncTestMismatch,
};
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyConstraints, RegisterState, SinewClock, SinewPlugin, SinewRollbackPlugin, StateTypes,
};

type Config = GgrsConfig<u8>;

/// How often the states of one frame differed.
#[derive(Resource, Default)]
struct Mismatches(usize);

/// State of the game, which it counts in every frame.
#[derive(Resource, Reflect, Clone, Debug, Default)]
struct Counted(u32);

/// What was spawned in play, and when.
#[derive(Component, Reflect, Clone, Debug)]
struct Thrown(u64);

/// A session that rolls every frame back by so many, once they are there.
fn session(distance: usize) -> App {
    let mut app = App::new();
    let session = SessionBuilder::<Config>::new()
        .with_num_players(1)
        .unwrap()
        .with_max_prediction_window(distance + 1)
        .with_check_distance(distance)
        .add_player(PlayerType::Local, 0)
        .unwrap()
        .start_synctest_session()
        .unwrap();
    app.add_plugins((
        MinimalPlugins,
        GgrsPlugin::<Config>::default(),
        SinewPlugin::in_schedule(GgrsSchedule),
        SinewRollbackPlugin,
    ))
    .insert_resource(Session::SyncTest(session))
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_nanos(16_666_667)))
    .init_resource::<Mismatches>()
    .init_resource::<Counted>()
    .register_state::<Thrown>()
    .add_observer(|_: On<SyncTestMismatch>, mut found: ResMut<Mismatches>| found.0 += 1)
    .add_systems(ReadInputs, |mut commands: Commands| {
        commands.insert_resource(LocalInputs::<Config>(HashMap::from_iter([(0, 0)])));
    })
    .add_systems(GgrsSchedule, play.before(bevy_sinew::SinewSystems::Build));
    app.finish();
    app.cleanup();
    let world = app.world_mut();
    world.spawn((Collider::plane(), SurfaceMaterial::new(0.5)));
    world.spawn((Wind { pressure: Vec3::X * 3.0, gusts: 0.7, ..default() }, Name::new("wind")));
    let cloth = Cloth::grid(1.0, 1.0, 7, 7).pinned(ClothPins::TopEdge);
    world.spawn((cloth, Transform::from_xyz(0.0, 1.5, 0.0)));
    world.spawn((Rope { segments: 6, ..default() }, Transform::from_xyz(1.5, 2.0, 0.0)));
    app
}

/// Bodies and particles come, fall onto each other, fall asleep and go; threads break.
fn play(
    mut commands: Commands,
    clock: Res<SinewClock>,
    mut counted: ResMut<Counted>,
    thrown: Query<(Entity, &Thrown)>,
    cloths: Query<&BodyConstraints, With<Cloth>>,
) {
    counted.0 += 1;
    let tick = clock.tick;
    let side = (tick % 7) as f32 * 0.1 - 0.3;
    if tick % 31 == 5 {
        let body = (RigidBox::new(Vec3::splat(0.3)), Sleep::default(), Thrown(tick));
        commands.spawn((body, Transform::from_xyz(side, 2.0, 0.4)));
    }
    if tick % 17 == 3 {
        let ball = Particle::at(Vec3::new(side, 1.0, 1.5)).with_velocity(Vec3::NEG_Z * 6.0);
        commands.spawn((ball, Mass(0.05), Radius(0.05), Thrown(tick)));
    }
    if let (true, Some(ties)) = (tick % 23 == 11, cloths.iter().next())
        && let Some(tie) = ties.iter().nth(tick as usize % ties.len().max(1))
    {
        commands.entity(tie).despawn();
    }
    for (entity, Thrown(when)) in &thrown {
        if tick > when + 150 {
            commands.entity(entity).despawn();
        }
    }
}

/// Runs so many frames. How often states differed, and how many frames there were.
fn run(app: &mut App, frames: usize) -> (usize, i32) {
    (0..frames).for_each(|_| app.update());
    let frame = app.world().resource::<RollbackFrameCount>().0;
    (app.world().resource::<Mismatches>().0, frame)
}

#[test]
fn a_thousand_frames_rolled_back_by_two_and_by_seven_are_the_same_each_time() {
    for distance in [2, 7] {
        let mut app = session(distance);
        let (mismatches, frames) = run(&mut app, 1000);
        assert_eq!(mismatches, 0, "{distance}");
        assert!(frames >= 990, "{distance}: {frames}");
        let world = app.world_mut();
        let mut thrown = world.query::<&Thrown>();
        assert!(thrown.iter(world).count() > 8, "{distance}: nothing is in play");
        let mut whole = session(2);
        run(&mut whole, 5);
        assert!(ties(&mut app) < ties(&mut whole) - 20, "{distance}: nothing broke");
    }
}

/// How many constraints hold the cloth together.
fn ties(app: &mut App) -> usize {
    let mut cloths = app.world_mut().query_filtered::<&BodyConstraints, With<Cloth>>();
    cloths.single(app.world()).unwrap().len()
}

#[test]
fn state_that_is_not_registered_is_found_and_once_it_is_registered_all_is_well() {
    for registered in [false, true] {
        let mut app = session(3);
        if registered {
            app.register_state_resource::<Counted>();
        }
        assert_eq!(app.world().resource::<StateTypes>().contains::<Counted>(), registered);
        // What it counts has a bearing on what is simulated.
        let blow = |counted: Res<Counted>, mut gravity: ResMut<Gravity>| {
            gravity.0.x = counted.0 as f32 * 1e-3;
        };
        let blow = blow.after(play).before(bevy_sinew::SinewSystems::Build);
        app.add_systems(GgrsSchedule, blow);
        let (mismatches, _) = run(&mut app, 60);
        assert_eq!(mismatches == 0, registered, "{mismatches}");
    }
}
