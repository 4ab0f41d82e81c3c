//! The whole state is in components and in `SinewClock`: cloned and restored, everything happens again, bit for bit.

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{CreationOrder, SinewClock, SinewSnapshot};

use crate::snapshot::{clear, hashes, roll_back_in_every_tick};
use crate::support::{app, busy_scene, hash, heard, particles_of, tick};

/// Asserts that two histories are equal, and otherwise names the first tick that differs.
fn assert_same(left: &[u64], right: &[u64]) {
    assert_eq!(left.len(), right.len());
    let parted = left.iter().zip(right).position(|(a, b)| a != b);
    assert_eq!(parted, None, "the first tick that differs");
}

#[test]
fn two_runs_are_equal_bit_for_bit_and_not_because_nothing_happens() {
    let run = || {
        let mut app = app();
        busy_scene(&mut app);
        hashes(&mut app, 200)
    };
    let first = run();
    assert_same(&first, &run());
    let distinct: std::collections::BTreeSet<_> = first.iter().collect();
    assert_eq!(distinct.len(), 200, "every tick moves something");
}

#[test]
fn components_cloned_at_tick_100_and_restored_at_200_lead_to_the_same_tick_200() {
    let mut app = app();
    busy_scene(&mut app);
    tick(&mut app, 100);
    let saved = SinewSnapshot::capture(app.world());
    let there = hash(&mut app);
    let first = hashes(&mut app, 100);
    saved.restore(app.world_mut()).unwrap();
    assert_eq!(hash(&mut app), there, "it is put back");
    assert_same(&hashes(&mut app, 100), &first);
    assert_eq!(app.world().resource::<SinewClock>().tick, 200);
    assert_eq!(heard(&app), []);
}

#[test]
fn the_comparison_detects_a_single_bit() {
    let mut app = app();
    let bodies = busy_scene(&mut app);
    tick(&mut app, 100);
    let saved = SinewSnapshot::capture(app.world());
    let first = hashes(&mut app, 20);
    saved.restore(app.world_mut()).unwrap();
    let nudged = particles_of(&app, bodies[0])[3];
    let mut particle = app.world_mut().get_mut::<Particle>(nudged).unwrap();
    particle.position.x = particle.position.x.next_up();
    assert_ne!(hashes(&mut app, 20)[19], first[19]);
}

#[test]
fn restoring_under_new_ids_undoes_spawns_and_despawns() {
    let mut app = app();
    let bodies = busy_scene(&mut app);
    tick(&mut app, 100);
    let saved = SinewSnapshot::capture(app.world());
    let first = hashes(&mut app, 100);

    // Sixty ticks of another history.
    clear(app.world_mut());
    let map = saved.restore(app.world_mut()).unwrap();
    tick(&mut app, 10);
    app.world_mut().despawn(map[&bodies[1]]);
    app.world_mut().spawn((Cloth::default(), Transform::from_xyz(-3.0, 3.0, -3.0)));
    tick(&mut app, 50);

    clear(app.world_mut());
    saved.restore(app.world_mut()).unwrap();
    assert_same(&hashes(&mut app, 100), &first);
    assert_eq!(heard(&app), []);
}

#[test]
fn a_fresh_app_with_the_restored_components_goes_on_bit_for_bit() {
    let mut old = app();
    busy_scene(&mut old);
    tick(&mut old, 100);
    let saved = SinewSnapshot::capture(old.world());
    let expected = hashes(&mut old, 100);

    let mut new = app();
    // Other things were here before: ids and the order of archetypes differ.
    new.world_mut().spawn_batch((0..50).map(|i| (Name::new(format!("{i}")), Mass(1.0))));
    saved.restore(new.world_mut()).unwrap();
    assert_same(&hashes(&mut new, 100), &expected);
}

#[test]
fn restoring_a_body_does_not_build_it_again() {
    let mut app = app();
    let bodies = busy_scene(&mut app);
    tick(&mut app, 30);
    let before: Vec<_> = bodies.iter().map(|&body| particles_of(&app, body)).collect();
    let saved = SinewSnapshot::capture(app.world());
    saved.restore(app.world_mut()).unwrap();
    tick(&mut app, 1);
    let after: Vec<_> = bodies.iter().map(|&body| particles_of(&app, body)).collect();
    assert_eq!(before, after, "the same particles, not new ones");
}

#[test]
fn a_rollback_every_tick_changes_nothing() {
    let mut app = app();
    busy_scene(&mut app);
    roll_back_in_every_tick(&mut app, 60);
}

#[test]
fn the_order_of_creation_survives_being_restored() {
    let mut app = app();
    let bodies = busy_scene(&mut app);
    tick(&mut app, 1);
    let order = |app: &App, entity: Entity| *app.world().get::<CreationOrder>(entity).unwrap();
    let first = particles_of(&app, bodies[2]);
    let orders: Vec<_> = first.iter().map(|&p| order(&app, p)).collect();
    assert!(orders.is_sorted() && orders[0] < orders[1], "given one after the other");
    let saved = SinewSnapshot::capture(app.world());
    clear(app.world_mut());
    let map: EntityHashMap<Entity> = saved.restore(app.world_mut()).unwrap();
    let again: Vec<_> = first.iter().map(|p| order(&app, map[p])).collect();
    assert_eq!(orders, again);
    // Whatever is created from now on comes after all of them.
    let late = app.world_mut().spawn(Particle::at(Vec3::ZERO)).id();
    assert!(again.iter().all(|&old| old < order(&app, late)));
}
