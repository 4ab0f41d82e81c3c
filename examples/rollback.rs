//! Rollback netcode: two players push their boxes over a connection with lag and loss, and both simulations agree bit for bit.
//!
//! `cargo run --example rollback` needs no window and exits by itself.

mod loopback;

use core::time::Duration;
use std::collections::BTreeMap;

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_ggrs::ggrs::{PlayerType, SessionBuilder};
use bevy_ggrs::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{RegisterState, RollbackHistory, SinewPlugin, SinewRollbackPlugin, SinewSystems};
use loopback::Net;

type Game = GgrsConfig<u8, usize>;

#[derive(Component, Reflect, Clone)]
struct Player(usize);

/// The whole game: in each frame every player pushes a box.
fn push(inputs: Res<PlayerInputs<Game>>, mut boxes: Query<(&Player, &mut ExternalImpulse)>) {
    for (player, mut push) in &mut boxes {
        push.impulse = Vec3::new(f32::from(inputs[player.0].0) - 1.5, 0.0, 0.3) * 0.1;
    }
}

fn player(me: usize, net: &Net) -> App {
    let session = SessionBuilder::<Game>::new().with_max_prediction_window(16);
    let session = session.add_player(PlayerType::Local, me).unwrap();
    let session = session.add_player(PlayerType::Remote(1 - me), 1 - me).unwrap();
    let session = session.start_p2p_session(net.end(me)).unwrap();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, GgrsPlugin::<Game>::default()))
        .add_plugins((SinewPlugin::in_schedule(GgrsSchedule), SinewRollbackPlugin))
        .insert_resource(Session::P2P(session))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs(1) / 60))
        .register_state::<Player>()
        .add_systems(GgrsSchedule, push.before(SinewSystems::Build))
        .add_systems(ReadInputs, move |mut commands: Commands, frame: Res<RollbackFrameCount>| {
            let input = (me, (frame.0 as usize / 15 + 2 * me) as u8 % 4);
            commands.insert_resource(LocalInputs::<Game>([input].into_iter().collect()));
        });
    let push = ExternalImpulse::default();
    app.world_mut().spawn(Collider::plane());
    for (i, x) in [-0.5, 0.5].into_iter().enumerate() {
        app.world_mut().spawn((
            RigidBox::default(),
            Player(i),
            push,
            Transform::from_xyz(x * 3.0, 1.0, 0.0),
        ));
    }
    app
}

fn main() {
    let net = Net::default();
    let mut players = [0, 1].map(|me| (player(me, &net), BTreeMap::new()));
    while players.iter().any(|(_, seen)| seen.keys().all(|&frame| frame < 300)) {
        if players.iter().all(|(app, _)| app.world().resource::<RollbackFrameCount>().0 > 0) {
            net.next_frame();
        }
        for (app, seen) in &mut players {
            app.update();
            // The last frame for which the inputs of both players are known: it is never rolled back.
            let sure = app.world().resource::<ConfirmedFrameCount>().0;
            let state = app.world().resource::<RollbackHistory>().at(sure);
            seen.extend(state.map(|state| (sure, state.hash())));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let [(_, one), (_, other)] = players;
    let both: Vec<_> = one.iter().filter_map(|(f, hash)| Some((hash, other.get(f)?))).collect();
    assert!(both.len() > 50 && both.iter().all(|(a, b)| a == b), "their states differ");
    println!("{} frames are identical bit for bit; the last: {:?}", both.len(), both.last());
}
