//! Messages of a tick arrive in the order of creation, whatever the entities' ids are and wherever they are stored.

use bevy::prelude::*;
use bevy_sinew::ContactImpulse;
use bevy_sinew::prelude::*;

use crate::support::{app, tick};

/// What was reported: the kind of event, the entity and the other entity.
#[derive(Resource, Default)]
struct Log(Vec<(&'static str, Entity, Entity)>);

#[derive(Component)]
struct Odd;

/// Runs crates that fall in a row and a heap, all with contact events, for 60 ticks. Returns the events, with entities by their order of spawning. `spoil`
/// changes ids and archetypes on the way.
fn heard_of(spoil: impl Fn(&mut World, usize)) -> Vec<(&'static str, usize, usize)> {
    let mut app = app();
    app.init_resource::<Log>()
        .add_observer(|on: On<ContactStarted>, mut log: ResMut<Log>| {
            log.0.push(("started", on.entity, on.other));
        })
        .add_observer(|on: On<ContactEnded>, mut log: ResMut<Log>| {
            log.0.push(("ended", on.entity, on.other));
        })
        .add_observer(|on: On<ContactImpulse>, mut log: ResMut<Log>| {
            log.0.push(("impulse", on.entity, on.other));
        });
    let mut names = Vec::new();
    let world = app.world_mut();
    spoil(world, 0);
    let floor = (Collider::cuboid(Vec3::new(20.0, 1.0, 20.0)), ContactEvents::Every);
    names.push(world.spawn((floor, Transform::from_xyz(0.0, -0.5, 0.0))).id());
    for i in 0..12 {
        spoil(world, i + 1);
        let place = Vec3::new(0.55 * (i % 4) as f32, 0.26 + 0.55 * (i / 4) as f32, 0.0);
        let place = place + Vec3::X * 0.1 * (i / 4) as f32;
        let body = RigidBox::new(Vec3::splat(0.5));
        let body = (body, ContactEvents::Every, Transform::from_translation(place));
        let body = (body, LinearVelocity(Vec3::new(1.5 - i as f32, 0.0, 0.0)));
        let mut body = world.spawn(body);
        if names.len().is_multiple_of(2) {
            body.insert(ContactEvents::Changes);
        }
        names.push(body.id());
    }
    for (i, &name) in names.iter().enumerate() {
        spoil(world, 100 + i);
        if i % 3 == 1 {
            world.entity_mut(name).insert(Odd);
        }
    }
    tick(&mut app, 60);
    let name = |entity: Entity| names.iter().position(|&one| one == entity).unwrap();
    let log = core::mem::take(&mut app.world_mut().resource_mut::<Log>().0);
    log.into_iter().map(|(what, entity, other)| (what, name(entity), name(other))).collect()
}

#[test]
fn contacts_are_reported_in_the_order_of_creation() {
    let plain = heard_of(|_, _| {});
    for what in ["started", "ended", "impulse"] {
        assert!(plain.iter().filter(|one| one.0 == what).count() > 12, "{what}");
    }
    // Ids that descend where they ascended, and other archetypes.
    let spoiled = heard_of(|world, i| {
        let junk: Vec<Entity> = (0..7).map(|_| world.spawn(Odd).id()).collect();
        for &one in junk.iter().skip(i % 3).step_by(2) {
            world.despawn(one);
        }
    });
    assert!(plain == spoiled, "the same messages in the same order");
    let moved = heard_of(|world, i| {
        if i >= 100 {
            let mut bodies = world.query_filtered::<Entity, (With<RigidBox>, Without<Odd>)>();
            let body = bodies.iter(world).last();
            if let Some(body) = body.filter(|_| i % 2 == 0) {
                world.entity_mut(body).insert(Odd);
            }
        }
    });
    assert!(plain == moved, "from whatever archetype");
}
