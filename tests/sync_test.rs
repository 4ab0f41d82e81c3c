//! Rollback without a netcode library: what a sync-test session of GGRS does, by snapshots alone. Every frame is rolled back by a number of frames and
//! simulated again from there, and the checksum of each state is compared with the first one of that frame. (`rollback` plays the same game through
//! `bevy_ggrs`; this is for builds without it, as with Bevy 0.20.)

use std::collections::VecDeque;

use bevy::ecs::schedule::ScheduleLabel;
use bevy::prelude::*;
use bevy_sinew::{
    Gravity, RegisterState, SinewClock, SinewPlugin, SinewSnapshot, SinewSystems, StateTypes,
};

use crate::rollback_game::{Counted, in_play, play, stage, ties};
use crate::support::TICK;

/// The schedule of a frame of the game.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Frame;

fn game() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SinewPlugin::in_schedule(Frame)));
    app.add_systems(Frame, play.before(SinewSystems::Build));
    app.finish();
    app.cleanup();
    stage(&mut app);
    app
}

/// Captures the state, simulates one frame, and returns the checksum of the captured state.
fn advance(world: &mut World, frames: &mut VecDeque<SinewSnapshot>) -> u64 {
    let snapshot = SinewSnapshot::capture(world);
    let sum = snapshot.hash();
    frames.push_back(snapshot);
    world.resource_mut::<Time>().advance_by(TICK);
    world.run_schedule(Frame);
    world.clear_trackers();
    sum
}

/// Plays `count` frames, each rolled back by `distance` frames as soon as there are so many. Returns how often the states of one frame differed.
fn sync_test(app: &mut App, count: usize, distance: usize) -> usize {
    let world = app.world_mut();
    let (mut frames, mut sums) = (VecDeque::new(), VecDeque::new());
    let mut differ = 0;
    for _ in 0..count {
        sums.push_back(advance(world, &mut frames));
        if frames.len() < distance {
            continue;
        }
        // Back to the start of the first of them, and forward again.
        let past = frames.pop_front().expect("there are some");
        frames.clear();
        past.restore(world).expect("it is of this very world");
        for sum in &sums {
            differ += usize::from(advance(world, &mut frames) != *sum);
        }
        frames.pop_front();
        sums.pop_front();
    }
    differ
}

#[test]
fn a_thousand_frames_rolled_back_by_two_and_by_seven_are_the_same_each_time() {
    for distance in [2, 7] {
        let mut app = game();
        assert_eq!(sync_test(&mut app, 1000, distance), 0, "{distance}");
        assert_eq!(app.world().resource::<SinewClock>().tick, 1000);
        assert!(in_play(&mut app) > 8, "{distance}: nothing is in play");
        let mut whole = game();
        sync_test(&mut whole, 5, 2);
        assert!(ties(&mut app) < ties(&mut whole) - 20, "{distance}: nothing broke");
    }
}

#[test]
fn unregistered_state_is_detected_and_registered_state_is_rolled_back() {
    for registered in [false, true] {
        let mut app = game();
        if registered {
            app.register_state_resource::<Counted>();
        }
        assert_eq!(app.world().resource::<StateTypes>().contains::<Counted>(), registered);
        // The counter influences the simulation.
        let blow = |counted: Res<Counted>, mut gravity: ResMut<Gravity>| {
            gravity.0.x = counted.0 as f32 * 1e-3;
        };
        app.add_systems(Frame, blow.after(play).before(SinewSystems::Build));
        let differ = sync_test(&mut app, 60, 3);
        assert_eq!(differ == 0, registered, "{differ}");
    }
}
