//! Going back and simulating again gives the same bits, by whichever way it is requested.

use bevy::prelude::*;
use bevy_egui::egui;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyParticles, RegisterState, SinewClock, SinewSnapshot};

use super::*;
use crate::tests::{app, click, click_text, draw_with, find_text};
use crate::{PanelSide, SinewPanelPlugin};

/// A scene of several kinds: a stack that rests on friction, a rope, a cloth in the wind of `app`. Every tick is recorded, always.
fn busy() -> App {
    let mut app = app(SinewPanelPlugin::embedded());
    let mut config = app.world_mut().resource_mut::<RecordingConfig>();
    (config.when, config.max_microseconds) = (RecordWhen::Always, u32::MAX);
    let world = app.world_mut();
    world.spawn((Ground, SurfaceMaterial::new(0.6)));
    for i in 0..3 {
        let at = Transform::from_xyz(2.0, 0.2 + 0.41 * i as f32, 0.1 * i as f32);
        world.spawn((RigidBox::new(Vec3::splat(0.4)), at));
    }
    world.spawn(Rope::between(Vec3::new(-1.0, 2.0, 0.0), Vec3::new(0.0, 2.0, 0.0)));
    world.spawn((Cloth::grid(1.0, 1.0, 6, 6), Transform::from_xyz(-3.0, 2.0, 0.0)));
    app.update();
    app
}

fn tick(app: &App) -> u64 {
    app.world().resource::<SinewClock>().tick
}

fn recording(app: &App) -> &Recording {
    app.world().resource::<Recording>()
}

fn hash(app: &App) -> u64 {
    SinewSnapshot::capture(app.world()).hash()
}

/// Runs, and returns the hash of the state after each tick.
fn hashes(app: &mut App, ticks: usize) -> Vec<u64> {
    let after = |app: &mut App| {
        app.update();
        hash(app)
    };
    (0..ticks).map(|_| after(app)).collect()
}

/// Goes to a tick. Pauses first, so that no tick is simulated on the way.
fn go_to(app: &mut App, tick: u64) {
    app.world_mut().resource_mut::<SinewControl>().pause();
    app.world_mut().resource_mut::<Recording>().go_to(tick);
    app.update();
}

#[test]
fn going_on_from_a_recorded_tick_gives_the_bits_of_the_first_pass() {
    let mut app = busy();
    hashes(&mut app, 30);
    let from = tick(&app);
    let first = hashes(&mut app, 60);
    // From several ticks, forward as well as back, and after a pause there.
    for (back, rest) in [(60, 0), (40, 3), (1, 1), (59, 7)] {
        go_to(&mut app, from + 60 - back);
        assert_eq!(tick(&app), from + 60 - back);
        (0..rest).for_each(|_| app.update());
        assert_eq!(tick(&app), from + 60 - back, "it stands still");
        app.world_mut().resource_mut::<SinewControl>().unpause();
        let again = hashes(&mut app, back as usize);
        assert_eq!(again, first[60 - back as usize..], "from {back} ticks back");
        assert_eq!(recording(&app).replay(), Replay::Same(back));
    }
    assert_eq!(recording(&app).ticks().next_back().map(|at| at.tick), Some(from + 60));
}

#[test]
fn it_goes_back_at_any_speed_and_leaves_the_speed_alone() {
    for speed in [0.25, 2.0, 3.5] {
        let mut app = busy();
        app.world_mut().resource_mut::<SinewControl>().relative_speed = speed;
        hashes(&mut app, 40);
        let ticks: Vec<u64> = recording(&app).ticks().map(|at| at.tick).collect();
        let last = *ticks.last().unwrap();
        let end = recording(&app).snapshot(last).unwrap().hash();
        go_to(&mut app, ticks[ticks.len() / 2]);
        assert_eq!(tick(&app), ticks[ticks.len() / 2]);
        let control = *app.world().resource::<SinewControl>();
        assert_eq!(control, SinewControl { paused: true, single_steps: 0, relative_speed: speed });
        // On by single steps, including the ticks that were not recorded.
        while tick(&app) < last {
            app.world_mut().resource_mut::<SinewControl>().step();
            app.update();
        }
        assert!(matches!(recording(&app).replay(), Replay::Same(n) if n > 1), "at {speed}");
        assert_eq!(recording(&app).ticks().map(|at| at.tick).collect::<Vec<_>>(), ticks);
        assert_eq!(capture(app.world_mut()).hash(), end, "at {speed}");
    }
}

/// A snapshot of a thousand boxes takes three times as long as their tick: a panel that took one in each tick made frames four times as long.
#[test]
fn what_takes_longer_than_it_may_is_recorded_every_few_ticks() {
    let mut app = busy();
    app.world_mut().resource_mut::<RecordingConfig>().max_microseconds = 1;
    let kept = recording(&app).len();
    hashes(&mut app, 50);
    let few = recording(&app).len() - kept;
    assert!((1..10).contains(&few), "{few} of 50");
    // Single steps are each recorded, from the last recorded tick to the present one.
    while recording(&app).ticks().next_back().map(|at| at.tick) == Some(tick(&app)) {
        app.update();
    }
    let (here, end) = (tick(&app), capture(app.world_mut()).hash());
    let before = recording(&app).ticks().next_back().unwrap();
    app.world_mut().resource_mut::<Recording>().go_back();
    app.update();
    assert_eq!(tick(&app), before.tick);
    let kept = recording(&app).len();
    while tick(&app) < here {
        app.world_mut().resource_mut::<SinewControl>().step();
        app.update();
    }
    assert_eq!(recording(&app).len() - kept, (here - before.tick) as usize);
    assert_eq!(capture(app.world_mut()).hash(), end, "the same bits, recorded or not");
}

#[test]
fn what_came_and_went_meanwhile_is_undone_and_happens_again() {
    let mut app = busy();
    let mut bodies = app.world_mut().query_filtered::<Entity, With<RigidBox>>();
    let bodies: Vec<Entity> = bodies.iter(app.world()).collect();
    app.insert_resource(Moved::default());
    app.add_observer(|on: On<WentBack>, mut moved: ResMut<Moved>| {
        moved.0.extend(on.entities.iter().map(|(&old, &new)| (old, new)));
    });
    hashes(&mut app, 10);
    let (before, there) = (tick(&app), hash(&app));
    app.world_mut().despawn(bodies[1]);
    app.world_mut().spawn((RigidBox::new(Vec3::splat(0.3)), Transform::from_xyz(2.0, 3.0, 0.0)));
    let first = hashes(&mut app, 40);
    let end = tick(&app);

    // Back to before both: the despawned body exists again under another id, and the spawned one does not.
    go_to(&mut app, before);
    let here = capture(app.world_mut()).hash();
    assert_eq!(here, recording(&app).snapshot(before).unwrap().hash());
    let moved = &app.world().resource::<Moved>().0;
    let (_, new) = *moved.iter().find(|(old, _)| *old == bodies[1]).expect("it has a new id");
    let particles = app.world().get::<BodyParticles>(new).expect("it has its particles again");
    assert_eq!(particles.len(), 8);

    // Back and forward once more: the body that was spawned again is not spawned a third time.
    go_to(&mut app, before - 1);
    go_to(&mut app, before);
    assert!(app.world().get_entity(new).is_ok(), "it stays the entity that it is");

    // Forward to after both, and on.
    go_to(&mut app, end - 20);
    assert!(app.world().get_entity(new).is_err());
    app.world_mut().resource_mut::<SinewControl>().unpause();
    assert_eq!(hashes(&mut app, 20), first[20..]);
    assert_ne!(first[0], there);
}

#[derive(Resource, Default)]
struct Moved(Vec<(Entity, Entity)>);

#[test]
fn the_later_ticks_go_with_the_first_that_differs() {
    let mut app = busy();
    hashes(&mut app, 40);
    let last = tick(&app);
    go_to(&mut app, last - 20);
    let last_of = |app: &App| recording(app).ticks().next_back().map(|at| at.tick);
    assert_eq!(last_of(&app), Some(last), "looking drops nothing");
    // Five ticks as recorded, then with less gravity.
    app.world_mut().resource_mut::<SinewControl>().unpause();
    hashes(&mut app, 5);
    assert_eq!((recording(&app).replay(), last_of(&app)), (Replay::Same(5), Some(last)));
    app.world_mut().resource_mut::<Gravity>().0 *= 0.5;
    app.update();
    assert_eq!(recording(&app).replay(), Replay::Differs(last - 14));
    assert_eq!(last_of(&app), Some(last - 14));
    // The settings go back with the rest.
    go_to(&mut app, last - 15);
    assert_eq!(app.world().resource::<Gravity>(), &Gravity::default());
    let bytes: usize = recording(&app).snapshots.iter().map(|one| one.bytes).sum();
    assert_eq!(recording(&app).bytes(), bytes);
}

#[test]
fn it_is_bounded_by_count_and_by_bytes() {
    let mut app = busy();
    app.world_mut().resource_mut::<RecordingConfig>().max_ticks = 10;
    hashes(&mut app, 30);
    let last = tick(&app);
    let held: Vec<u64> = recording(&app).ticks().map(|at| at.tick).collect();
    assert_eq!(held, (last - 9..=last).collect::<Vec<_>>());
    let one = recording(&app).bytes() / 10;
    // Some 150 particles and 500 constraints of some hundred bytes each.
    assert!((20_000..400_000).contains(&one), "{one}");
    app.world_mut().resource_mut::<RecordingConfig>().max_bytes = 4 * one + one / 2;
    hashes(&mut app, 2);
    assert_eq!(recording(&app).len(), 4);
    assert_eq!(recording(&app).problem(), None);
    app.world_mut().resource_mut::<RecordingConfig>().max_bytes = one / 2;
    hashes(&mut app, 1);
    assert_eq!((recording(&app).len(), recording(&app).bytes()), (0, 0));
    assert!(recording(&app).problem().is_some_and(|said| said.contains("a snapshot takes")));
    app.world_mut().resource_mut::<Recording>().go_to(last);
    app.update();
    assert!(!app.world().resource::<SinewControl>().paused, "there is nowhere to go");
}

#[test]
fn nothing_is_recorded_while_nobody_looks_or_it_is_off() {
    let ctx = egui::Context::default();
    for (when, looked, ticks) in [
        (RecordWhen::Never, true, 0),
        (RecordWhen::Shown, false, 0),
        (RecordWhen::Shown, true, 20),
        (RecordWhen::Always, false, 20),
    ] {
        let mut app = busy();
        app.world_mut().resource_mut::<RecordingConfig>().when = when;
        app.world_mut().resource_mut::<Recording>().clear();
        for _ in 0..20 {
            if looked {
                draw_with(&mut app, &ctx, PanelSide::Right, Vec::new());
            }
            app.update();
        }
        assert_eq!(recording(&app).len(), ticks, "{when:?}, {looked}");
    }
}

#[test]
fn another_world_empties_it() {
    let mut app = busy();
    hashes(&mut app, 30);
    // A clock that was set back, as when another scene begins.
    app.insert_resource(SinewClock::default());
    hashes(&mut app, 3);
    assert_eq!(recording(&app).ticks().map(|at| at.tick).collect::<Vec<_>>(), [1, 2, 3]);
    // And one that jumps ahead.
    app.insert_resource(SinewClock { tick: 1000, seconds: 1000.0 / 64.0, ahead: 0.0 });
    hashes(&mut app, 1);
    assert_eq!(recording(&app).ticks().map(|at| at.tick).collect::<Vec<_>>(), [1001]);
}

#[derive(Component, Reflect, Clone, Default)]
struct Counted(u32);

#[derive(Component, Reflect, Clone, Default)]
struct Forgotten(u32);

#[test]
fn of_a_games_own_state_goes_back_what_is_registered() {
    let mut app = busy();
    app.register_state::<Counted>();
    let count = |mut all: Query<(&mut Counted, &mut Forgotten)>| {
        for (mut counted, mut forgotten) in &mut all {
            (counted.0, forgotten.0) = (counted.0 + 1, forgotten.0 + 1);
        }
    };
    app.add_systems(FixedUpdate, count);
    let body = (RigidBox::default(), Counted(0), Forgotten(0), Transform::from_xyz(0.0, 9.0, 5.0));
    let body = app.world_mut().spawn(body).id();
    hashes(&mut app, 20);
    let back = tick(&app) - 10;
    go_to(&mut app, back);
    let (counted, forgotten) =
        (app.world().get::<Counted>(body), app.world().get::<Forgotten>(body));
    // The unregistered component counted on in the frame that went back.
    assert_eq!((counted.unwrap().0, forgotten.unwrap().0), (10, 21));
}

#[test]
fn the_button_the_slider_and_the_key_go_back() {
    let mut app = busy();
    let ctx = egui::Context::default();
    hashes(&mut app, 50);
    let before = tick(&app);
    click_text(&mut app, &ctx, "⏮  Back");
    let control = *app.world().resource::<SinewControl>();
    // Frames pass during the click, and the simulation goes on in them.
    let at = tick(&app);
    assert!(control.paused && at >= before && at < before + 5, "{at}");
    click_text(&mut app, &ctx, "⏮  Back");
    assert_eq!(tick(&app), at - 1);
    click_text(&mut app, &ctx, "⏭  Step");
    assert_eq!(tick(&app), at);
    assert_eq!(recording(&app).replay(), Replay::Same(1));
    let (output, _) = draw_with(&mut app, &ctx, PanelSide::Right, Vec::new());
    assert!(find_text(&output, "ticks: identical").is_some());

    // The slider's rail begins to the right of its label.
    let label = find_text(&output, "Go to tick").expect("the slider is there");
    click(&mut app, &ctx, egui::pos2(label.x + 70.0, label.y));
    let there = tick(&app);
    assert!(there < before - 20, "{there} of {before}");
    let (output, _) = draw_with(&mut app, &ctx, PanelSide::Right, Vec::new());
    assert!(find_text(&output, "Other state of the game was not restored").is_some());
    assert!(find_text(&output, "F3 back").is_some());

    let mut keys = ButtonInput::<KeyCode>::default();
    keys.press(KeyCode::F3);
    app.insert_resource(keys);
    app.update();
    assert_eq!(tick(&app), there - 1);
}
