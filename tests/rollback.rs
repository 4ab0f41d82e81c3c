//! Rollback netcode through `bevy_ggrs`: a thousand frames, each of them rolled back and simulated again, give the same state; and state that was not
//! registered is detected.

use core::time::Duration;

use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_ggrs::ggrs::{PlayerType, SessionBuilder};
use bevy_ggrs::{
    GgrsConfig, GgrsPlugin, GgrsSchedule, LocalInputs, ReadInputs, RollbackFrameCount, Session,
    SyncTestMismatch,
};
use bevy_sinew::Gravity;
use bevy_sinew::{RegisterState, SinewPlugin, SinewRollbackPlugin, StateTypes};

use crate::rollback_game::{Counted, in_play, play, stage, ties};

type Config = GgrsConfig<u8>;

/// How often the states of one frame differed.
#[derive(Resource, Default)]
struct Mismatches(usize);

/// A session that rolls every frame back by `distance` frames, as soon as there are so many.
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
    .add_observer(|_: On<SyncTestMismatch>, mut found: ResMut<Mismatches>| found.0 += 1)
    .add_systems(ReadInputs, |mut commands: Commands| {
        commands.insert_resource(LocalInputs::<Config>(HashMap::from_iter([(0, 0)])));
    })
    .add_systems(GgrsSchedule, play.before(bevy_sinew::SinewSystems::Build));
    app.finish();
    app.cleanup();
    stage(&mut app);
    app
}

/// Runs `frames` frames. Returns how often states differed, and the number of the last frame.
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
        assert!(in_play(&mut app) > 8, "{distance}: nothing is in play");
        let mut whole = session(2);
        run(&mut whole, 5);
        assert!(ties(&mut app) < ties(&mut whole) - 20, "{distance}: nothing broke");
    }
}

#[test]
fn unregistered_state_is_detected_and_registered_state_is_rolled_back() {
    for registered in [false, true] {
        let mut app = session(3);
        if registered {
            app.register_state_resource::<Counted>();
        }
        assert_eq!(app.world().resource::<StateTypes>().contains::<Counted>(), registered);
        // The counter influences the simulation.
        let blow = |counted: Res<Counted>, mut gravity: ResMut<Gravity>| {
            gravity.0.x = counted.0 as f32 * 1e-3;
        };
        let blow = blow.after(play).before(bevy_sinew::SinewSystems::Build);
        app.add_systems(GgrsSchedule, blow);
        let (mismatches, _) = run(&mut app, 60);
        assert_eq!(mismatches == 0, registered, "{mismatches}");
    }
}
