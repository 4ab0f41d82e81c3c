//! Things that collide, bounce, slide and fall asleep are rolled back like everything else: their state is in components, and contacts are found again.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyContacts, SinewSnapshot};
use bevy_sinew::{ContactCache, ContactShape};

use crate::snapshot::{hashes, roll_back_in_every_tick};
use crate::support::{app, hash, heard, tick};

/// A ramp over a floor, boxes that tumble down it onto each other, a ragdoll beside them, a sheet that folds over a ball, marbles in a net, and a rope across a
/// thin post; all may sleep.
fn colliding_scene(app: &mut App) {
    let world = app.world_mut();
    world.spawn((Collider::plane(), SurfaceMaterial::new(0.6).with_restitution(0.3)));
    let tilt = Transform::from_xyz(-1.0, 0.4, 0.0).with_rotation(Quat::from_rotation_z(-0.4));
    world.spawn((Collider::cuboid(Vec3::new(4.0, 0.4, 4.0)), tilt));
    world.spawn((Collider::sphere(0.3), Transform::from_xyz(3.0, 0.3, 0.0)));
    for i in 0..5 {
        let place = Transform::from_xyz(-1.2 + 0.1 * i as f32, 1.2 + 0.5 * i as f32, 0.0);
        let place = place.with_rotation(Quat::from_rotation_x(0.3 * i as f32));
        let size = Vec3::new(0.4, 0.3, 0.5);
        world.spawn((RigidBox::new(size), BodyContacts::default(), Sleep::default(), place));
    }
    let figure = Transform::from_xyz(0.6, 1.0, 1.0).with_rotation(Quat::from_rotation_z(0.4));
    world.spawn((Ragdoll::default(), BodyContacts::default(), Sleep::default(), figure));
    let folds = BodyContacts { with_itself: true, ..default() };
    let flat = Transform::from_xyz(3.0, 0.9, 0.0)
        .with_rotation(Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2));
    let sheet = Cloth { radius: 0.02, ..Cloth::grid(1.0, 1.0, 14, 14) };
    world.spawn((sheet, folds, Sleep::default(), flat));
    // A coarse net that catches marbles by its triangles.
    let net = Cloth { radius: 0.01, ..Cloth::grid(0.8, 0.8, 4, 4) }.pinned(ClothPins::Corners);
    let place = Transform { translation: Vec3::new(6.0, 0.8, 0.0), ..flat };
    world.spawn((net, folds.shaped(ContactShape::Triangles), Sleep::default(), place));
    for i in 0..4 {
        let at = Vec3::new(5.85 + 0.1 * i as f32, 1.1 + 0.2 * i as f32, 0.07);
        let marble = (Particle::at(at), Mass(0.02), Radius(0.02), Sleep::default());
        world.spawn((marble, BodyContacts::default()));
    }
    // A coarse rope that hangs by its segments.
    let across = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let post = Transform::from_xyz(-4.0, 0.6, 0.0).with_rotation(across);
    world.spawn((Collider::capsule(0.005, 1.0), post));
    let ends = [-4.4, -3.5].map(|x| Vec3::new(x, 0.8, 0.0));
    let rope = Rope { segments: 9, pin_start: false, ..Rope::between(ends[0], ends[1]) };
    world.spawn((rope, folds.shaped(ContactShape::Segments), Sleep::default()));
}

fn asleep(app: &mut App) -> usize {
    let mut bodies = app.world_mut().query::<&Sleep>();
    bodies.iter(app.world()).filter(|sleep| sleep.asleep).count()
}

#[test]
fn restored_contacts_lead_to_the_same_bits_during_hits_and_in_sleep() {
    let mut app = app();
    colliding_scene(&mut app);
    let mut slept = Vec::new();
    // In the air, among the first hits, and when the first bodies are asleep.
    for ticks in [20, 40, 240] {
        tick(&mut app, ticks);
        let saved = SinewSnapshot::capture(app.world());
        let there = hash(&mut app);
        let first = hashes(&mut app, 60);
        slept.push(asleep(&mut app));
        saved.restore(app.world_mut()).unwrap();
        assert_eq!(hash(&mut app), there, "it is put back");
        assert_eq!(hashes(&mut app, 60), first, "after {ticks} more ticks");
    }
    assert!(slept[0] == 0 && slept[2] > 0, "{slept:?}");
    assert_eq!(heard(&app), []);
}

#[test]
fn a_rollback_by_seven_ticks_in_every_tick_changes_nothing_about_contacts() {
    let mut app = app();
    colliding_scene(&mut app);
    tick(&mut app, 30);
    roll_back_in_every_tick(&mut app, 30);
}

#[test]
fn a_fresh_app_with_restored_bodies_in_contact_goes_on_bit_for_bit() {
    let mut old = app();
    colliding_scene(&mut old);
    tick(&mut old, 60);
    let saved = SinewSnapshot::capture(old.world());
    let mut new = app();
    saved.restore(new.world_mut()).unwrap();
    assert_eq!(hashes(&mut new, 60), hashes(&mut old, 60));
}

/// Three plates on a slope that holds them by friction.
fn stack(app: &mut App) -> Vec<Entity> {
    let turned = Quat::from_rotation_z(-0.35);
    let slope = Transform::from_rotation(turned);
    app.world_mut().spawn((Collider::plane(), SurfaceMaterial::new(0.5), slope));
    let plate = |n: u32| {
        let at = turned * Vec3::Y * (0.1 + 0.2 * n as f32);
        let place = Transform::from_translation(at).with_rotation(turned);
        let size = Vec3::new(1.0, 0.2, 1.0);
        (RigidBox::new(size), BodyContacts::default(), SurfaceMaterial::new(0.5), place)
    };
    (0..3).map(|n| app.world_mut().spawn(plate(n)).id()).collect()
}

#[test]
fn a_stack_on_a_slope_stays_and_cached_contacts_go_with_their_bodies() {
    let mut app = app();
    let plates = stack(&mut app);
    tick(&mut app, 120);
    let place = |app: &App, n: usize| app.world().get::<Transform>(plates[n]).unwrap().translation;
    let held = |app: &App, n: usize| app.world().get::<ContactCache>(plates[n]).unwrap().len();
    let before = [0, 1, 2].map(|n| place(&app, n));
    tick(&mut app, 360);
    for (n, before) in before.into_iter().enumerate() {
        assert!(before.distance(place(&app, n)) < 1e-4, "plate {n} creeps");
    }
    // A contact is cached on the older of its two bodies, and static geometry caches none.
    assert_eq!([0, 1, 2].map(|n| held(&app, n)), [2, 1, 0]);
    app.world_mut().despawn(plates[1]);
    tick(&mut app, 60);
    assert_eq!(held(&app, 0), 2, "the slope, and the plate that fell onto it");
    let fallen = before[2].distance(place(&app, 2));
    assert!((fallen - 0.2).abs() < 0.02, "{fallen}");
    assert_eq!(heard(&app), []);
}

#[test]
fn the_contact_cache_of_a_stack_is_rolled_back_and_independent_of_other_bodies() {
    let (mut alone, mut among) = (app(), app());
    stack(&mut alone);
    stack(&mut among);
    // A distant collider that is added and removed: the caches of the others must not be cleared by it.
    let far = among
        .world_mut()
        .spawn((Collider::cuboid(Vec3::splat(2.0)), Transform::from_xyz(90.0, 0.0, 0.0)));
    let far = far.id();
    tick(&mut alone, 90);
    tick(&mut among, 60);
    among.world_mut().despawn(far);
    tick(&mut among, 30);
    assert_eq!(hash(&mut alone), hash(&mut among));
    roll_back_in_every_tick(&mut alone, 30);
}
