//! Move and slide through the ECS: a game's own character on grounds, against walls and bodies, and after something was despawned.

use core::time::Duration;

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ContactsDisabled, MoveAndSlideConfig, MoveAndSlideOutput, QueryFilter};

use crate::support::{TICK, app, heard, tick};

/// A character: its intended velocity, m/s, its fall speed, m/s, and the last result.
#[derive(Component, Default)]
struct Character {
    wish: Vec3,
    fall: f32,
    last: MoveAndSlideOutput,
}

fn go(
    query: SinewQuery,
    time: Res<Time>,
    mut characters: Query<(Entity, &mut Character, &mut Transform, &Collider)>,
) {
    for (entity, mut character, mut at, shape) in &mut characters {
        let fall = character.fall - 9.81 * time.delta_secs();
        let filter = QueryFilter { except: Some(entity), ..default() };
        let (config, velocity) = (MoveAndSlideConfig::default(), character.wish + Vec3::Y * fall);
        let from = at.to_isometry();
        let out = query.move_and_slide(shape, from, velocity, time.delta(), &config, &filter);
        at.set_if_neq(Transform { translation: out.position, ..*at });
        (character.fall, character.last) = (out.projected_velocity.y, out);
    }
}

fn game() -> App {
    let mut app = app();
    app.add_systems(FixedUpdate, go);
    app
}

fn shapes() -> [Collider; 3] {
    [Collider::capsule(0.3, 1.2), Collider::sphere(0.9), Collider::cuboid(Vec3::new(0.6, 1.8, 0.6))]
}

fn spawn(app: &mut App, shape: Collider, at: Vec3, wish: Vec3) -> Entity {
    let character = Character { wish, ..default() };
    app.world_mut().spawn((character, shape, Transform::from_translation(at))).id()
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<Transform>(entity).unwrap().translation
}

fn last(app: &App, entity: Entity) -> &MoveAndSlideOutput {
    &app.world().get::<Character>(entity).unwrap().last
}

#[test]
fn a_character_stands_on_a_ground_in_a_room_and_on_a_slope_and_does_not_creep() {
    for shape in shapes() {
        for slope in [0.0, 0.2, 0.7] {
            let mut app = game();
            let turned = Transform::from_rotation(Quat::from_rotation_z(slope));
            let ground = app.world_mut().spawn((Ground, turned)).id();
            let room = BoundingBox { size: Vec3::new(30.0, 30.0, 4.0) };
            let room = app.world_mut().spawn(room).id();
            let one = spawn(&mut app, shape.clone(), Vec3::new(0.0, 2.0, 0.0), Vec3::ZERO);
            tick(&mut app, 60);
            let at = place(&app, one);
            assert_eq!(last(&app, one).ground.unwrap().entity, ground, "{shape:?} {slope}");
            tick(&mut app, 600);
            assert_eq!(place(&app, one), at, "{shape:?} {slope}");
            // Into the wall of the bounding box.
            app.world_mut().get_mut::<Character>(one).unwrap().wish = Vec3::Z * 3.0;
            tick(&mut app, 120);
            let out = last(&app, one).clone();
            assert!(out.hits.iter().any(|hit| hit.entity == room), "{shape:?} {slope} {out:?}");
            let before = place(&app, one);
            tick(&mut app, 60);
            assert!(place(&app, one).abs_diff_eq(before, 1e-5), "{shape:?} {slope}");
            assert_eq!(heard(&app), []);
        }
    }
}

#[test]
fn a_character_is_stopped_by_a_resting_crate_and_pushed_by_a_thrown_one() {
    for shape in shapes() {
        for mass in [1.0, 500.0] {
            let mut app = game();
            app.world_mut().spawn(Ground);
            let body = RigidBox::new(Vec3::splat(1.0)).with_mass(mass);
            let lies =
                app.world_mut().spawn((body.clone(), Transform::from_xyz(3.0, 0.5, 0.0))).id();
            let one = spawn(&mut app, shape.clone(), Vec3::new(0.0, 0.95, 0.0), Vec3::X * 2.0);
            tick(&mut app, 180);
            let out = last(&app, one).clone();
            assert!(out.hits.iter().any(|hit| hit.entity == lies), "{shape:?} {mass} {out:?}");
            assert!(place(&app, lies).abs_diff_eq(Vec3::new(3.0, 0.5, 0.0), 0.01), "it weighs not");
            let before = place(&app, one);
            assert!(before.x < 2.5, "{shape:?} {mass} {before}");
            app.world_mut().get_mut::<Character>(one).unwrap().wish = Vec3::ZERO;
            let thrown = (body, SurfaceMaterial::new(0.0), Transform::from_xyz(-4.0, 0.5, 0.0));
            let thrown = app.world_mut().spawn((thrown, LinearVelocity(Vec3::X * 5.0))).id();
            tick(&mut app, 120);
            let (at, it) = (place(&app, one), place(&app, thrown));
            assert!(at.is_finite() && (at.x - it.x).abs() + (at.z - it.z).abs() > 0.7, "{at} {it}");
            assert_eq!(heard(&app), []);
        }
    }
}

#[test]
fn moved_and_despawned_colliders_take_effect_in_the_next_tick() {
    let mut app = game();
    app.world_mut().spawn(Ground);
    let block = Collider::cuboid(Vec3::new(4.0, 1.0, 4.0));
    let block = app.world_mut().spawn((block, Transform::from_xyz(0.0, 0.5, 0.0))).id();
    let one = spawn(&mut app, Collider::capsule(0.3, 1.2), Vec3::Y * 2.0, Vec3::ZERO);
    tick(&mut app, 60);
    assert_eq!(last(&app, one).ground.unwrap().entity, block);
    // The block rises like a lift.
    for i in 1..=60 {
        app.world_mut().get_mut::<Transform>(block).unwrap().translation.y = 0.5 + i as f32 * 0.01;
        tick(&mut app, 1);
    }
    tick(&mut app, 2);
    assert!((place(&app, one).y - 2.51).abs() < 0.001, "{}", place(&app, one));
    app.world_mut().despawn(block);
    tick(&mut app, 120);
    assert!((place(&app, one).y - 0.91).abs() < 0.001, "{}", place(&app, one));
    assert!(app.world().get_entity(last(&app, one).ground.unwrap().entity).is_ok());
    assert_eq!(heard(&app), []);
}

#[test]
fn no_wall_is_passed_at_any_speed_and_broken_numbers_move_nothing() {
    let mut app = app();
    let wall = Collider::cuboid(Vec3::new(0.01, 50.0, 50.0));
    let wall = app.world_mut().spawn((wall, Transform::from_xyz(20.0, 0.0, 0.0))).id();
    let gone = (Collider::cuboid(Vec3::ONE), Transform::from_xyz(5.0, 0.0, 0.0), ContactsDisabled);
    app.world_mut().spawn(gone);
    tick(&mut app, 2);
    let sinew = app.world().resource::<SinewWorld>();
    let (config, all) = (MoveAndSlideConfig::default(), QueryFilter::default());
    for shape in shapes() {
        for speed in [0.01, 1.0, 300.0, 1e5] {
            for delta in [TICK / 8, TICK, Duration::from_secs(1), Duration::from_secs(3000)] {
                let velocity = Vec3::new(speed, 0.0, 0.0);
                let out = sinew.move_and_slide(
                    &shape,
                    Isometry3d::IDENTITY,
                    velocity,
                    delta,
                    &config,
                    &all,
                );
                let reach = speed * delta.as_secs_f32();
                assert!(out.position.x < 19.8 && out.position.is_finite(), "{speed} {delta:?}");
                assert_eq!(out.hits.iter().any(|hit| hit.entity == wall), reach > 20.0);
            }
        }
        let broken = [Vec3::NAN, Vec3::INFINITY];
        for velocity in broken {
            let out =
                sinew.move_and_slide(&shape, Isometry3d::IDENTITY, velocity, TICK, &config, &all);
            assert_eq!(out, MoveAndSlideOutput::default());
        }
    }
    for shape in [Collider::sphere(f32::NAN), Collider::plane()] {
        let out = sinew.move_and_slide(&shape, Isometry3d::IDENTITY, Vec3::X, TICK, &config, &all);
        assert_eq!(out, MoveAndSlideOutput::default(), "{shape:?}");
    }
    assert!(config.is_floor(Vec3::Y) && !config.is_floor(Vec3::X));
}
