//! The gallery's own scenes keep what their captions promise.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use sinew_scenes::ScenesPlugin;

use crate::support::{app_with, assert_finite, tick};

/// Plays a scene for `ticks` ticks and returns the largest error of a rod in any of them, as a share of its length.
fn longest_error_of_rods(name: &str, ticks: u64) -> f32 {
    let mut app = playing(name);
    let mut worst = 0.0_f32;
    for _ in 0..ticks {
        tick(&mut app, 1);
        let world = app.world_mut();
        let mut rods = world.query::<&DistanceConstraint>();
        let mut particles = world.query::<&Particle>();
        for rod in rods.iter(world).filter(|rod| rod.bound == Bound::Equal && rod.rest > 0.0) {
            let [a, b] = [rod.a, rod.b].map(|end| particles.get(world, end).unwrap().position);
            worst = worst.max((a.distance(b) - rod.rest).abs() / rod.rest);
        }
    }
    assert_finite(&mut app);
    worst
}

fn playing(name: &str) -> App {
    let mut app = app_with(ScenesPlugin);
    sinew_scenes::load(app.world_mut(), sinew_scenes::find(name).unwrap());
    app
}

#[test]
fn crates_keep_their_28_distances_and_squares_their_6_within_half_a_percent() {
    for (name, bodies, each) in [("crate", 4, 28), ("square", 3, 6)] {
        let worst = longest_error_of_rods(name, 300);
        assert!(worst < 0.005, "{name}: {worst}");
        let mut app = playing(name);
        tick(&mut app, 2);
        let count = app.world_mut().query::<&DistanceConstraint>().iter(app.world()).count();
        assert_eq!(count, bodies * each);
    }
}

#[test]
fn the_bones_of_falling_ragdolls_keep_their_lengths_within_one_percent() {
    let worst = longest_error_of_rods("ragdoll", 300);
    assert!(worst < 0.01, "{worst}");
}

#[test]
fn crates_land_turned_and_come_to_rest() {
    let mut app = playing("crate");
    tick(&mut app, 2);
    let world = app.world_mut();
    let mut boxes = world.query_filtered::<&Transform, With<ParticleBox>>();
    let before: Vec<Transform> = boxes.iter(world).copied().collect();
    tick(&mut app, 900);
    let world = app.world_mut();
    for (old, new) in before.iter().zip(boxes.iter(world)) {
        assert!(old.rotation.angle_between(new.rotation) > 0.3, "it turned");
        assert!(new.translation.y < 0.7 && new.translation.y > 0.25, "it lies: {new:?}");
    }
    let mut motion = world.query_filtered::<&LinearVelocity, With<ParticleBox>>();
    for velocity in motion.iter(world) {
        assert!(velocity.0.length() < 0.01, "it rests: {}", velocity.0);
    }
}

#[test]
fn scenes_follow_each_other_in_one_app_without_a_trace() {
    let mut app = app_with(ScenesPlugin);
    let particles = |app: &mut App| app.world_mut().query::<&Particle>().iter(app.world()).count();
    for name in ["jelly", "crate", "pendulums", "square", "ragdoll", "crate"] {
        sinew_scenes::load(app.world_mut(), sinew_scenes::find(name).unwrap());
        tick(&mut app, 20);
        assert_finite(&mut app);
        assert_eq!(
            app.world().resource::<SinewClock>().tick,
            20,
            "{name} starts from the beginning"
        );
    }
    assert_eq!(particles(&mut app), 32, "only the crates are left");
}
