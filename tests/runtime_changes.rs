//! Particles, springs, constraints and bodies are added, changed and removed while time runs: without a restart, and without a leak.

use bevy::prelude::*;
use bevy_sinew::SinewClock;
use bevy_sinew::prelude::*;

use crate::support::{app, assert_finite, heard, particles_of, position, tick};

/// A hook and a bob one metre below it.
fn pendulum(app: &mut App) -> (Entity, Entity) {
    let hook = app.world_mut().spawn((Particle::at(Vec3::ZERO), Pinned::HERE)).id();
    let bob = app.world_mut().spawn(Particle::at(Vec3::NEG_Y)).id();
    (hook, bob)
}

#[test]
fn a_constraint_acts_from_the_tick_after_it_was_added_until_it_is_despawned() {
    let mut app = app();
    let (hook, bob) = pendulum(&mut app);
    let rod = app.world_mut().spawn(DistanceConstraint::new(hook, bob, 1.0)).id();
    tick(&mut app, 30);
    assert!((position(&app, bob).y + 1.0).abs() < 1e-4, "held");
    app.world_mut().get_mut::<DistanceConstraint>(rod).unwrap().rest = 0.5;
    tick(&mut app, 30);
    assert!((position(&app, bob).length() - 0.5).abs() < 1e-3, "changed: {}", position(&app, bob));
    app.world_mut().despawn(rod);
    let before = position(&app, bob).y;
    tick(&mut app, 60);
    assert!(position(&app, bob).y < before - 3.0, "and let go: {}", position(&app, bob));
    assert_eq!(app.world().resource::<SinewWorld>().simulation().distances().len(), 0);
    assert_eq!(heard(&app), []);
}

#[test]
fn a_spring_pulls_while_it_is_there() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let (hook, bob) = pendulum(&mut app);
    tick(&mut app, 10);
    assert_eq!(position(&app, bob), Vec3::NEG_Y);
    let spring = app.world_mut().spawn(Spring::new(hook, bob, 0.5, 10.0)).id();
    tick(&mut app, 10);
    let pulled = position(&app, bob).y;
    assert!(pulled > -0.99, "{pulled}");
    app.world_mut().get_mut::<Spring>(spring).unwrap().stiffness = 0.0;
    let speed = app.world().get::<Particle>(bob).unwrap().velocity.y;
    app.world_mut().despawn(spring);
    tick(&mut app, 1);
    let later = app.world().get::<Particle>(bob).unwrap().velocity.y;
    assert!((speed - later).abs() < 0.01 * speed, "it coasts: {speed} {later}");
}

#[test]
fn a_particle_is_pinned_moved_and_released_while_time_runs() {
    let mut app = app();
    let stone = app.world_mut().spawn(Particle::at(Vec3::ZERO)).id();
    app.world_mut().entity_mut(stone).insert(Pinned::HERE);
    tick(&mut app, 10);
    assert_eq!(position(&app, stone), Vec3::ZERO);
    app.world_mut().entity_mut(stone).insert(Pinned::at(Vec3::X));
    tick(&mut app, 1);
    assert!(position(&app, stone).abs_diff_eq(Vec3::X, 1e-6));
    tick(&mut app, 10);
    assert!(position(&app, stone).abs_diff_eq(Vec3::X, 1e-6));
    app.world_mut().entity_mut(stone).remove::<Pinned>();
    tick(&mut app, 30);
    assert!(position(&app, stone).y < -1.0);
}

/// A transform that swings to and fro, like a hand that the game moves.
#[derive(Component)]
struct Hand;

#[test]
fn a_pin_follows_an_entity_and_its_parents_exactly() {
    let mut app = app();
    let arm = app.world_mut().spawn((Hand, Transform::default())).id();
    let hand = app.world_mut().spawn((Transform::from_xyz(0.0, 0.0, 2.0), ChildOf(arm))).id();
    let offset = Vec3::new(0.1, 0.2, 0.3);
    let end =
        app.world_mut().spawn((Particle::at(Vec3::ZERO), PinnedTo { entity: hand, offset })).id();
    let swing = |mut hands: Query<&mut Transform, With<Hand>>, clock: Res<SinewClock>| {
        for mut transform in &mut hands {
            let t = clock.tick as f32 * 0.05;
            *transform = Transform::from_xyz(t, 0.0, 0.0).with_rotation(Quat::from_rotation_y(t));
        }
    };
    app.add_systems(FixedUpdate, swing);
    for _ in 0..60 {
        tick(&mut app, 1);
        let arm = *app.world().get::<Transform>(arm).unwrap();
        let expected = arm * (Transform::from_xyz(0.0, 0.0, 2.0) * offset);
        let error = position(&app, end).distance(expected);
        assert!(error < 1e-5, "{error}");
    }
    app.world_mut().entity_mut(end).remove::<PinnedTo>();
    let last = position(&app, end);
    tick(&mut app, 30);
    let flown = position(&app, end) - last;
    assert!(flown.y < -1.0 && flown.x.abs() > 0.5, "let go, it keeps its speed and falls: {flown}");
}

#[test]
fn edits_of_position_velocity_mass_and_force_act_in_the_next_tick() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    let stone = app.world_mut().spawn((Particle::at(Vec3::ZERO), Mass(2.0))).id();
    tick(&mut app, 5);
    app.world_mut().get_mut::<Particle>(stone).unwrap().position = Vec3::Y * 3.0;
    tick(&mut app, 1);
    assert_eq!(position(&app, stone), Vec3::Y * 3.0, "a teleport gives no speed");
    let mass = Mass(2.0);
    app.world_mut().get_mut::<Particle>(stone).unwrap().add_impulse(Vec3::X * 4.0, mass);
    tick(&mut app, 60);
    assert!((position(&app, stone).x - 2.0).abs() < 1e-4, "4 N·s on 2 kg are 2 m/s");
    app.world_mut().entity_mut(stone).insert(ExternalForce(Vec3::Z * 4.0));
    tick(&mut app, 60);
    let z = position(&app, stone).z;
    // Half a substep early, as a leapfrog starts.
    assert!((z - 1.0 - 2.0 / 1200.0).abs() < 1e-4, "4 N on 2 kg are 2 m/s²: {z}");
    app.world_mut().entity_mut(stone).remove::<ExternalForce>();
    tick(&mut app, 1);
    let before = app.world().get::<Particle>(stone).unwrap().velocity.z;
    tick(&mut app, 10);
    assert_eq!(app.world().get::<Particle>(stone).unwrap().velocity.z, before);
}

#[test]
fn spawning_and_despawning_a_hundred_bodies_leaves_nothing_behind() {
    let mut app = app();
    let stays = app.world_mut().spawn(RigidBox::default()).id();
    tick(&mut app, 3);
    let count = |app: &mut App| {
        let world = app.world_mut();
        let entities = world.query::<Entity>().iter(world).count();
        let meshes = world.resource::<Assets<Mesh>>().len();
        let sinew = world.resource::<SinewWorld>();
        (entities, meshes, sinew.particles().len(), sinew.simulation().distances().len())
    };
    let baseline = count(&mut app);
    for round in 0..25 {
        let world = app.world_mut();
        let at = Transform::from_xyz(3.0 * round as f32, 0.0, 0.0);
        let sphere =
            world.resource_mut::<Assets<Mesh>>().add(Sphere::new(0.3).mesh().ico(2).unwrap());
        let bodies = [
            world.spawn((RigidBox::default(), at)).id(),
            world.spawn((Rope::default(), at)).id(),
            world.spawn((Cloth::grid(1.0, 1.0, 5, 5), at)).id(),
            world.spawn((Cloth::from_mesh(), Mesh3d(sphere), at)).id(),
            world.spawn((Ragdoll::default(), at)).id(),
        ];
        tick(&mut app, 2);
        assert!(count(&mut app).0 > baseline.0 + 100, "they were there");
        // Built again meanwhile, as when a slider is dragged.
        app.world_mut().get_mut::<Cloth>(bodies[3]).unwrap().density = 0.3 + round as f32 * 0.01;
        app.world_mut().get_mut::<Rope>(bodies[1]).unwrap().segments = 7;
        tick(&mut app, 2);
        for body in bodies {
            app.world_mut().despawn(body);
        }
        tick(&mut app, 3);
        assert_eq!(count(&mut app), baseline, "round {round}");
    }
    assert_eq!(particles_of(&app, stays).len(), 8);
    assert_eq!(heard(&app), []);
}

#[test]
fn a_pause_and_single_steps_change_no_bit_of_what_follows() {
    let run = |paused: bool| {
        let mut app = app();
        crate::support::busy_scene(&mut app);
        tick(&mut app, 20);
        if paused {
            let still = crate::support::hash(&mut app);
            app.world_mut().resource_mut::<SinewControl>().paused = true;
            tick(&mut app, 13);
            assert_eq!(crate::support::hash(&mut app), still);
            assert_eq!(app.world().resource::<SinewClock>().tick, 20);
            app.world_mut().resource_mut::<SinewControl>().single_steps = 3;
            tick(&mut app, 9);
            assert_eq!(app.world().resource::<SinewClock>().tick, 23, "three and no more");
            assert_eq!(app.world().resource::<SinewControl>().single_steps, 0);
            app.world_mut().resource_mut::<SinewControl>().paused = false;
            tick(&mut app, 17);
        } else {
            tick(&mut app, 20);
        }
        assert_eq!(app.world().resource::<SinewClock>().tick, 40);
        crate::support::hash(&mut app)
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn spawns_and_despawns_during_a_pause_take_effect_when_it_ends() {
    let mut app = app();
    let old = app.world_mut().spawn((Cloth::default(), Transform::from_xyz(3.0, 0.0, 0.0))).id();
    tick(&mut app, 5);
    app.world_mut().resource_mut::<SinewControl>().paused = true;
    let new = app.world_mut().spawn((RigidBox::default(), Transform::from_xyz(0.0, 1.0, 0.0))).id();
    tick(&mut app, 3);
    assert_eq!(particles_of(&app, new).len(), 8, "built although time stands still");
    app.world_mut().despawn(old);
    tick(&mut app, 3);
    app.world_mut().resource_mut::<SinewControl>().paused = false;
    tick(&mut app, 30);
    assert!(app.world().get::<Transform>(new).unwrap().translation.y < 0.0);
    assert_eq!(app.world().resource::<SinewWorld>().particles().len(), 8);
    assert_finite(&mut app);
}
