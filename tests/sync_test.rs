//! Rollback without a netcode library: what a sync-test session of GGRS does, by snapshots alone. Every frame is rolled back by so many frames and
//! simulated again from there, with a checksum of each state against the first one of that frame. (`rollback` is the same game through `bevy_ggrs`.)

use std::collections::VecDeque;

use bevy::ecs::schedule::ScheduleLabel;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyConstraints, RegisterState, SinewClock, SinewPlugin, SinewSnapshot, SinewSystems,
    StateTypes,
};

use crate::support::TICK;

/// A frame of the game.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Frame;

/// State of the game, which it counts in every frame.
#[derive(Resource, Reflect, Clone, Debug, Default)]
pub(crate) struct Counted(pub(crate) u32);

/// What was spawned in play, and when.
#[derive(Component, Reflect, Clone, Debug)]
pub(crate) struct Thrown(u64);

/// Spawns what there is at the start of the game.
pub(crate) fn stage(app: &mut App) {
    app.init_resource::<Counted>().register_state::<Thrown>();
    let world = app.world_mut();
    world.spawn((Ground, SurfaceMaterial::new(0.5)));
    world.spawn((Wind { pressure: Vec3::X * 3.0, gusts: 0.7, ..default() }, Name::new("wind")));
    let cloth = Cloth::grid(1.0, 1.0, 7, 7).pinned(ClothPins::TopEdge);
    world.spawn((cloth, Transform::from_xyz(0.0, 1.5, 0.0)));
    world.spawn((Rope { segments: 6, ..default() }, Transform::from_xyz(1.5, 2.0, 0.0)));
}

/// Bodies and particles come, fall onto each other, fall asleep and go; threads break.
pub(crate) fn play(
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

/// How many constraints hold the cloth together.
pub(crate) fn ties(app: &mut App) -> usize {
    let mut cloths = app.world_mut().query_filtered::<&BodyConstraints, With<Cloth>>();
    cloths.single(app.world()).unwrap().len()
}

/// What was thrown and is still there.
pub(crate) fn in_play(app: &mut App) -> usize {
    let world = app.world_mut();
    world.query::<&Thrown>().iter(world).count()
}

fn game() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SinewPlugin::in_schedule(Frame)));
    app.add_systems(Frame, play.before(SinewSystems::Build));
    app.finish();
    app.cleanup();
    stage(&mut app);
    app
}

/// One frame of the simulation, and the state that it begins with: kept, and its checksum.
fn advance(world: &mut World, frames: &mut VecDeque<SinewSnapshot>) -> u64 {
    let snapshot = SinewSnapshot::capture(world);
    let sum = snapshot.hash();
    frames.push_back(snapshot);
    world.resource_mut::<Time>().advance_by(TICK);
    world.run_schedule(Frame);
    world.clear_trackers();
    sum
}

/// Plays so many frames, each rolled back by a distance as soon as there are so many. How often the states of one frame differed.
fn sync_test(app: &mut App, count: usize, distance: usize) -> usize {
    let world = app.world_mut();
    let (mut frames, mut sums) = (VecDeque::new(), VecDeque::new());
    let mut differ = 0;
    for _ in 0..count {
        sums.push_back(advance(world, &mut frames));
        if frames.len() < distance {
            continue;
        }
        // Back to where the first of them begins, and forward again.
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
fn state_that_is_not_registered_is_found_and_once_it_is_registered_all_is_well() {
    for registered in [false, true] {
        let mut app = game();
        if registered {
            app.register_state_resource::<Counted>();
        }
        assert_eq!(app.world().resource::<StateTypes>().contains::<Counted>(), registered);
        // What it counts has a bearing on what is simulated.
        let blow = |counted: Res<Counted>, mut gravity: ResMut<Gravity>| {
            gravity.0.x = counted.0 as f32 * 1e-3;
        };
        app.add_systems(Frame, blow.after(play).before(SinewSystems::Build));
        let differ = sync_test(&mut app, 60, 3);
        assert_eq!(differ == 0, registered, "{differ}");
    }
}
