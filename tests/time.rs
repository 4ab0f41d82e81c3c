//! The simulation's own time: its speed, its pause, and what is drawn meanwhile.

use core::time::Duration;
use std::collections::BTreeMap;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::SinewClock;
use bevy_sinew::prelude::*;

use crate::support::{TICK, app, busy_scene, hash, hash_of, mesh_of, tick};

fn set_speed(app: &mut App, speed: f32) {
    app.world_mut().resource_mut::<SinewControl>().relative_speed = speed;
}

fn ticks(app: &App) -> u64 {
    app.world().resource::<SinewClock>().tick
}

/// The hash after each tick of the simulation, by its number.
fn hashes(speed: f32, until: u64) -> BTreeMap<u64, u64> {
    let mut app = app();
    busy_scene(&mut app);
    set_speed(&mut app, speed);
    let mut found = BTreeMap::new();
    while ticks(&app) < until {
        tick(&mut app, 1);
        let now = hash(&mut app);
        let before = found.insert(ticks(&app), now);
        assert!(
            before.is_none_or(|before| before == now),
            "a fixed tick without a tick changes nothing"
        );
    }
    found
}

#[test]
fn every_speed_simulates_the_same_bits() {
    let reference = hashes(1.0, 60);
    assert_eq!(reference.len(), 60);
    for speed in [0.5, 0.3, 1.5, 2.0, 7.0] {
        let found = hashes(speed, 60);
        assert!(found.len() > 8, "{speed}");
        for (tick, hash) in found.iter().filter(|(tick, _)| **tick <= 60) {
            assert_eq!(*hash, reference[tick], "tick {tick} at {speed}");
        }
    }
}

#[test]
fn the_speed_counts_ticks_and_leaves_the_clocks_of_the_game_alone() {
    let cases = [
        (1.0, 64),
        (0.5, 32),
        (0.25, 16),
        (2.0, 128),
        (1.5, 96),
        (0.0, 0),
        (-3.0, 0),
        (f32::NAN, 0),
        (f32::INFINITY, 16 * 64),
    ];
    for (speed, expected) in cases {
        let mut app = app();
        app.world_mut().spawn(Particle::default());
        tick(&mut app, 1);
        set_speed(&mut app, speed);
        let elapsed = |app: &App| app.world().resource::<Time<Virtual>>().elapsed();
        let (began, before) = (elapsed(&app), ticks(&app));
        tick(&mut app, 64);
        assert_eq!(ticks(&app) - before, expected, "{speed}");
        assert_eq!(elapsed(&app) - began, TICK * 64, "{speed}");
        assert_eq!(app.world().resource::<Time<Virtual>>().relative_speed(), 1.0);
        let step = app.world().resource::<SinewClock>().seconds / ticks(&app) as f64;
        assert!((step - TICK.as_secs_f64()).abs() < 1e-6, "a tick is as long as ever: {step}");
    }
}

#[test]
fn a_stall_at_twice_the_speed_takes_no_more_than_twice_the_ticks() {
    let mut app = app();
    app.world_mut().spawn(Particle::default());
    set_speed(&mut app, 2.0);
    tick(&mut app, 2);
    let before = ticks(&app);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs(10)));
    app.update();
    let taken = ticks(&app) - before;
    assert!((28..=32).contains(&taken), "0.25 s at most, twice: {taken}");
}

#[test]
fn a_pause_and_single_steps_work_at_any_speed() {
    for speed in [0.25, 0.7, 1.0, 2.0] {
        let mut app = app();
        app.world_mut().spawn(Particle::default());
        set_speed(&mut app, speed);
        tick(&mut app, 9);
        app.world_mut().resource_mut::<SinewControl>().pause();
        let before = ticks(&app);
        tick(&mut app, 5);
        assert_eq!(ticks(&app), before, "{speed}");
        app.world_mut().resource_mut::<SinewControl>().step();
        app.world_mut().resource_mut::<SinewControl>().step();
        tick(&mut app, 9);
        assert_eq!(ticks(&app), before + 2, "{speed}");
        app.world_mut().resource_mut::<SinewControl>().unpause();
        tick(&mut app, 1);
        assert_eq!(ticks(&app), before + 2 + (speed.ceil() as u64), "{speed}: it goes on at once");
    }
}

/// Asserts that a body that moves at 3 m/s down is drawn with even steps from frame to frame, to 2 %.
fn glide(speed: f32, height: impl Fn(&App) -> f32, mut app: App) {
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    set_speed(&mut app, speed);
    tick(&mut app, 12);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TICK / 4));
    for _ in 0..8 {
        app.update();
    }
    let heights: Vec<f32> = (0..60)
        .map(|_| {
            app.update();
            height(&app)
        })
        .collect();
    let expected = -3.0 * speed * TICK.as_secs_f32() / 4.0;
    for (frame, pair) in heights.windows(2).enumerate() {
        let share = (pair[1] - pair[0]) / expected;
        assert!((share - 1.0).abs() < 0.02, "speed {speed}, frame {frame}: {share}");
    }
}

#[test]
fn an_interpolated_transform_glides_at_any_speed() {
    for speed in [0.1, 0.25, 0.7, 1.0, 1.5, 2.0] {
        let mut app = app();
        let body = (RigidBox::default(), LinearVelocity(Vec3::Y * -3.0), Interpolate);
        let body = app.world_mut().spawn(body).id();
        glide(speed, |app| app.world().get::<Transform>(body).unwrap().translation.y, app);
    }
}

#[test]
fn an_interpolated_mesh_glides_at_any_speed() {
    for speed in [0.1, 0.25, 0.7, 1.0, 1.5, 2.0] {
        let mut app = app();
        let cloth = (Cloth::grid(1.0, 1.0, 3, 3), LinearVelocity(Vec3::Y * -3.0), Interpolate);
        let cloth = app.world_mut().spawn(cloth).id();
        let middle = |app: &App| {
            // Its vertices are in its own frame.
            let (frame, vertices) =
                (*app.world().get::<Transform>(cloth).unwrap(), mesh_of(app, cloth));
            vertices.iter().map(|&v| (frame * v).y).sum::<f32>() / vertices.len() as f32
        };
        glide(speed, middle, app);
    }
}

#[derive(Component)]
struct Lift(f32);

/// Regression: a lift that moved in the first of two ticks, and stood still in the second, threw off what it carried.
#[test]
fn a_lift_carries_a_crate_at_any_speed() {
    for speed in [0.5, 1.0, 2.0, 3.0] {
        let mut app = app();
        let raise = |time: Res<Time>, mut lifts: Query<(&mut Transform, &Lift)>| {
            for (mut place, lift) in &mut lifts {
                place.translation.y += lift.0 * time.delta_secs();
            }
        };
        app.add_systems(FixedUpdate, raise);
        let world = app.world_mut();
        let lift = (Collider::cuboid(Vec3::new(2.0, 0.2, 2.0)), Lift(0.5 * speed));
        world.spawn((lift, Transform::from_xyz(0.0, -0.1, 0.0)));
        let hook = (Transform::from_xyz(3.0, 0.0, 0.0), Lift(0.5 * speed));
        let hook = world.spawn(hook).id();
        let pin = PinnedTo { entity: hook, offset: Vec3::ZERO };
        let held = world.spawn((Particle::at(Vec3::X * 3.0), pin)).id();
        let crate_ =
            world.spawn((RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(0.0, 0.2, 0.0)));
        let body = crate_.id();
        set_speed(&mut app, speed);
        for _ in 0..90 {
            tick(&mut app, 1);
            let world = app.world_mut();
            let mut lifts = world.query_filtered::<&Transform, (With<Lift>, With<Collider>)>();
            let top = lifts.single(world).unwrap().translation.y + 0.1;
            let gap = world.get::<Transform>(body).unwrap().translation.y - 0.2 - top;
            // In slow motion the lift also moves in fixed ticks in which nothing is simulated.
            let late = if speed < 1.0 { 0.5 / 60.0 } else { 0.0 };
            assert!(gap.abs() < 0.005 + late, "{speed}: {gap}");
            let off = world.get::<Particle>(held).unwrap().position.y - (top - 0.0);
            assert!(off.abs() < 1e-4 + late, "{speed}: {off}");
        }
    }
}

/// At the speed 0 a single step never counted as taken: after one call of `step`, ten fixed ticks ran ten ticks instead of one.
#[test]
fn a_single_step_at_the_speed_zero_is_one_tick() {
    for speed in [0.0, -1.0, f32::NAN] {
        let mut app = app();
        let body = app.world_mut().spawn(RigidBox::default()).id();
        tick(&mut app, 3);
        set_speed(&mut app, speed);
        tick(&mut app, 3);
        let before = (ticks(&app), hash_of(&app, &[body]));
        for steps in 1..=3 {
            app.world_mut().resource_mut::<SinewControl>().step();
            tick(&mut app, 10);
            assert_eq!(ticks(&app) - before.0, steps, "{speed}");
        }
        assert_ne!(hash_of(&app, &[body]), before.1, "{speed}");
        assert!(!app.world().resource::<SinewControl>().running(), "{speed}");
    }
}
