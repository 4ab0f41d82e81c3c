//! Things that collide, bounce, slide and fall asleep are rolled back like everything else: their state is in components, and contacts are found again.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::snapshot::{Snapshot, hashes, roll_back_in_every_tick};
use crate::support::{app, hash, heard, tick};

/// A ramp over a floor, boxes that tumble down it onto each other, a figure beside them, a sheet that folds up on a ball, marbles in a net; all may sleep.
fn colliding_scene(app: &mut App) {
    let world = app.world_mut();
    world.spawn((Collider::plane(), SurfaceMaterial::new(0.6).with_restitution(0.3)));
    let tilt = Transform::from_xyz(-1.0, 0.4, 0.0).with_rotation(Quat::from_rotation_z(-0.4));
    world.spawn((Collider::cuboid(Vec3::new(2.0, 0.2, 2.0)), tilt));
    world.spawn((Collider::sphere(0.3), Transform::from_xyz(3.0, 0.3, 0.0)));
    for i in 0..5 {
        let place = Transform::from_xyz(-1.2 + 0.1 * i as f32, 1.2 + 0.5 * i as f32, 0.0);
        let place = place.with_rotation(Quat::from_rotation_x(0.3 * i as f32));
        let size = Vec3::new(0.4, 0.3, 0.5);
        world.spawn((ParticleBox::new(size), BodyContacts::default(), Sleep::default(), place));
    }
    let figure = Transform::from_xyz(0.6, 1.0, 1.0).with_rotation(Quat::from_rotation_z(0.4));
    world.spawn((Ragdoll::default(), BodyContacts::default(), Sleep::default(), figure));
    let folds = BodyContacts { with_itself: true, ..default() };
    let flat = Transform::from_xyz(3.0, 0.9, 0.0)
        .with_rotation(Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2));
    let sheet = Cloth { radius: 0.02, ..Cloth::grid(1.0, 1.0, 14, 14) };
    world.spawn((sheet, folds, Sleep::default(), flat));
    // A coarse one that catches marbles by its triangles.
    let net = Cloth { radius: 0.01, ..Cloth::grid(0.8, 0.8, 4, 4) }.pinned(ClothPins::Corners);
    let place = Transform { translation: Vec3::new(6.0, 0.8, 0.0), ..flat };
    world.spawn((net, folds.shaped(ContactShape::Triangles), Sleep::default(), place));
    for i in 0..4 {
        let at = Vec3::new(5.85 + 0.1 * i as f32, 1.1 + 0.2 * i as f32, 0.07);
        let marble = (Particle::at(at), Mass(0.02), Radius(0.02), Sleep::default());
        world.spawn((marble, BodyContacts::default()));
    }
}

fn asleep(app: &mut App) -> usize {
    let mut bodies = app.world_mut().query::<&Sleep>();
    bodies.iter(app.world()).filter(|sleep| sleep.asleep).count()
}

#[test]
fn contacts_put_back_lead_to_the_same_bits_while_bodies_hit_each_other_and_when_they_sleep() {
    let mut app = app();
    colliding_scene(&mut app);
    let mut slept = Vec::new();
    // In the air, among the first hits, and when the first are asleep.
    for ticks in [20, 40, 240] {
        tick(&mut app, ticks);
        let saved = Snapshot::take(app.world_mut());
        let there = hash(&mut app);
        let first = hashes(&mut app, 60);
        slept.push(asleep(&mut app));
        saved.put_back(app.world_mut());
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
fn a_fresh_app_that_is_given_bodies_in_contact_goes_on_as_the_old_one_did() {
    let mut old = app();
    colliding_scene(&mut old);
    tick(&mut old, 60);
    let saved = Snapshot::take(old.world_mut());
    let mut new = app();
    saved.spawn(new.world_mut());
    assert_eq!(hashes(&mut new, 60), hashes(&mut old, 60));
}
