//! Contact events, spatial queries, and sleeping bodies.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyContacts, BodyParts, ContactsDisabled, SinewWorld, SleepingDisabled};
use bevy_sinew::{BodyParticles, ParticleOf, QueryFilter, Touching, WorldCenterOfMass};
use bevy_sinew::{SinewPlugin, SinewSystems, SinewTick};

use crate::support::{app, heard, tick};

fn floor() -> (Collider, Transform) {
    (Collider::cuboid(Vec3::new(10.0, 1.0, 10.0)), Transform::from_xyz(0.0, -0.5, 0.0))
}

fn crate_at(x: f32, y: f32) -> (RigidBox, BodyContacts, Transform) {
    let place = Transform::from_xyz(x, y, 0.0);
    (RigidBox::new(Vec3::splat(0.4)), BodyContacts::default(), place)
}

/// What the observers recorded: entity, other entity, and whether the contact started or is of a sensor.
#[derive(Resource, Default)]
struct Seen(Vec<(Entity, Entity, bool)>);

#[test]
fn a_contact_is_reported_once_when_it_begins_and_once_when_it_ends() {
    let mut app = app();
    app.init_resource::<Seen>();
    let world = app.world_mut();
    let ground = world.spawn(floor()).id();
    let body = world.spawn((crate_at(0.0, 0.6), ContactEvents::default())).id();
    let quiet = world.spawn(crate_at(2.0, 0.6)).id();
    world.entity_mut(body).observe(|on: On<ContactStarted>, mut seen: ResMut<Seen>| {
        assert!(on.impulse > 0.0 && !on.sensor);
        assert!((on.normal - Vec3::Y).length() < 1e-3, "{}", on.normal);
        seen.0.push((on.entity, on.other, true));
    });
    world.entity_mut(body).observe(|on: On<ContactEnded>, mut seen: ResMut<Seen>| {
        seen.0.push((on.entity, on.other, false));
    });
    tick(&mut app, 60);
    assert_eq!(app.world().resource::<Seen>().0, [(body, ground, true)]);
    assert_eq!(app.world().get::<Touching>(body).unwrap().0, [ground]);
    assert!(app.world().get::<Touching>(quiet).is_none());
    app.world_mut().commands().entity(body).set_linear_velocity(Vec3::Y * 4.0);
    tick(&mut app, 10);
    assert_eq!(app.world().resource::<Seen>().0[1..], [(body, ground, false)]);
    assert_eq!(app.world().get::<Touching>(body).unwrap().0, []);
    assert_eq!(heard(&app), []);
}

#[test]
fn a_sensor_reports_a_ball_that_passes_through() {
    let mut app = app();
    app.init_resource::<Seen>();
    let world = app.world_mut();
    let gate = (Collider::cuboid(Vec3::new(2.0, 0.1, 2.0)), Sensor, ContactEvents::default());
    let gate = world.spawn((gate, Transform::from_xyz(0.0, 1.0, 0.0))).id();
    world.add_observer(|on: On<ContactStarted>, mut seen: ResMut<Seen>| {
        seen.0.push((on.entity, on.other, on.sensor));
    });
    let ball =
        world.spawn((Particle::at(Vec3::Y * 2.0), Radius(0.1), SurfaceMaterial::default())).id();
    tick(&mut app, 60);
    assert_eq!(app.world().resource::<Seen>().0, [(gate, ball, true)]);
    assert!(app.world().get::<Particle>(ball).unwrap().position.y < 0.5, "it went through");
    assert_eq!(app.world().get::<Touching>(gate).unwrap().0, [], "it has left");
}

#[test]
fn rays_overlaps_and_the_nearest_particle_name_entities() {
    let mut app = app();
    let world = app.world_mut();
    let ground = world.spawn(floor()).id();
    let body = world.spawn(crate_at(0.0, 0.2)).id();
    tick(&mut app, 2);
    let sinew = app.world().resource::<SinewWorld>();
    let all = QueryFilter::default();
    let down = |x: f32| Ray3d::new(Vec3::new(x, 3.0, 0.05), Dir3::NEG_Y);
    let hit = sinew.cast_ray(down(0.0), 10.0, &all).unwrap();
    assert_eq!(hit.entity, body);
    assert!((hit.distance - 2.6).abs() < 0.01 && (hit.normal - Vec3::Y).length() < 0.01, "{hit:?}");
    assert_eq!(sinew.cast_ray(down(1.0), 10.0, &all).unwrap().entity, ground);
    let past = QueryFilter { except: Some(body), ..all };
    assert_eq!(sinew.cast_ray(down(0.0), 10.0, &past).unwrap().entity, ground);
    assert_eq!(sinew.cast_ray(down(0.0), 1.0, &all), None);
    let probe = Collider::sphere(0.3);
    let at = |y: f32| Isometry3d::from_translation(Vec3::Y * y);
    assert_eq!(sinew.overlapping(&probe, at(0.5), &all), [body]);
    assert_eq!(sinew.overlapping(&probe, at(0.2), &all), [ground, body]);
    assert_eq!(sinew.overlapping(&probe, at(5.0), &all), []);
    let (particle, distance) = sinew.nearest_particle(Vec3::splat(0.2), 1.0, &all).unwrap();
    assert!(app.world().get::<ParticleOf>(particle).is_some_and(|of| of.0 == body));
    assert!(distance < 0.25, "{distance}");
}

#[test]
fn resting_bodies_sleep_and_wake_when_they_are_pushed_or_the_floor_is_gone() {
    let mut app = app();
    let world = app.world_mut();
    let ground = world.spawn(floor()).id();
    let body = world.spawn((crate_at(0.0, 0.2), Sleep::default())).id();
    let other = world.spawn((crate_at(3.0, 0.2), Sleep::default())).id();
    let asleep = |app: &App, entity| app.world().get::<Sleep>(entity).unwrap().asleep;
    tick(&mut app, 120);
    assert!(asleep(&app, body) && asleep(&app, other));
    app.world_mut().commands().entity(body).apply_impulse(Vec3::X * 2.0);
    tick(&mut app, 2);
    assert!(!asleep(&app, body) && asleep(&app, other), "only the pushed body");
    tick(&mut app, 200);
    assert!(asleep(&app, body));
    app.world_mut().despawn(ground);
    tick(&mut app, 30);
    let height = |app: &App, entity| app.world().get::<Transform>(entity).unwrap().translation.y;
    assert!(height(&app, body) < 0.0 && height(&app, other) < 0.0, "they fall");
    assert_eq!(heard(&app), []);
}

#[test]
fn components_of_sleeping_bodies_are_not_written() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn(floor());
    let crates: Vec<Entity> = (0..9)
        .map(|n| {
            let (body, contacts, _) = crate_at(0.0, 0.0);
            let place = Vec3::new(0.8 * (n % 3) as f32, 0.2, 0.8 * (n / 3) as f32);
            world.spawn((body, contacts, Sleep::default(), Transform::from_translation(place))).id()
        })
        .collect();
    tick(&mut app, 120);
    let written = |app: &App, body: Entity| {
        let world = app.world();
        let first = world.get::<BodyParticles>(body).unwrap().iter().next().unwrap();
        let [particle, transform, motion] = [
            world.entity(first).get_ref::<Particle>().unwrap().last_changed(),
            world.entity(body).get_ref::<Transform>().unwrap().last_changed(),
            world.entity(body).get_ref::<LinearVelocity>().unwrap().last_changed(),
        ];
        [particle, transform, motion].map(bevy::ecs::change_detection::Tick::get)
    };
    let all = |app: &App| crates.iter().map(|&body| written(app, body)).collect::<Vec<_>>();
    let before = all(&app);
    tick(&mut app, 10);
    assert_eq!(all(&app), before, "no component of a sleeping body is written");
}

#[test]
fn the_transform_of_a_sleeping_body_follows_its_particles() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn(floor());
    let body = world.spawn((crate_at(0.0, 0.2), Sleep::default())).id();
    tick(&mut app, 120);
    assert!(app.world().get::<Sleep>(body).unwrap().asleep);
    let particles: Vec<Entity> = app.world().get::<BodyParticles>(body).unwrap().iter().collect();
    for particle in particles {
        app.world_mut().get_mut::<Particle>(particle).unwrap().position.x += 2.0;
    }
    tick(&mut app, 2);
    let place = *app.world().get::<Transform>(body).unwrap();
    assert!((place.translation.x - 2.0).abs() < 1e-3, "{place:?}");
    assert!((app.world().get::<WorldCenterOfMass>(body).unwrap().position.x - 2.0).abs() < 1e-3);
    // It wakes when it is pushed.
    let first = app.world().get::<BodyParticles>(body).unwrap().iter().next().unwrap();
    app.world_mut().get_mut::<Particle>(first).unwrap().velocity = Vec3::Y;
    tick(&mut app, 1);
    assert!(!app.world().get::<Sleep>(body).unwrap().asleep);
}

/// Regression: bodies that are not solved have no contacts that the solver could report, so a body that fell asleep ended its contacts with what it lay on, and
/// started them again when it woke.
#[test]
fn falling_asleep_and_waking_end_and_start_no_contact() {
    let mut app = app();
    app.init_resource::<Seen>();
    let world = app.world_mut();
    world.add_observer(|on: On<ContactStarted>, mut seen: ResMut<Seen>| {
        seen.0.push((on.entity, on.other, true));
    });
    world.add_observer(|on: On<ContactEnded>, mut seen: ResMut<Seen>| {
        seen.0.push((on.entity, on.other, false));
    });
    let ground = world.spawn((floor(), ContactEvents::default())).id();
    let lower = world.spawn((crate_at(0.0, 0.2), ContactEvents::default())).id();
    let upper = world.spawn(crate_at(0.0, 0.6)).id();
    tick(&mut app, 240);
    let asleep = |app: &App, body| app.world().get::<Sleep>(body).unwrap().asleep;
    assert!(asleep(&app, lower) && asleep(&app, upper));
    let mut began = core::mem::take(&mut app.world_mut().resource_mut::<Seen>().0);
    began.sort_unstable();
    let mut all = [(ground, lower, true), (lower, ground, true), (lower, upper, true)];
    all.sort_unstable();
    assert_eq!(began, all);
    let mut touching = app.world().get::<Touching>(lower).unwrap().0.clone();
    touching.sort_unstable();
    let mut both = [ground, upper];
    both.sort_unstable();
    assert_eq!(touching, both);
    // Waking without a change triggers no event; a despawned body ends its contact.
    app.world_mut().get_mut::<Sleep>(lower).unwrap().wake();
    tick(&mut app, 5);
    assert!(!asleep(&app, lower));
    assert_eq!(app.world().resource::<Seen>().0, []);
    tick(&mut app, 120);
    assert!(asleep(&app, lower));
    app.world_mut().despawn(upper);
    tick(&mut app, 2);
    assert_eq!(app.world().resource::<Seen>().0, [(lower, upper, false)]);
    assert_eq!(app.world().get::<Touching>(lower).unwrap().0, [ground]);
}

/// When contact events were switched off, the list of what the entity touched stayed as it was, wherever the entity went.
#[test]
fn switching_contact_events_off_ends_the_contacts() {
    let mut app = app();
    app.init_resource::<Seen>();
    app.add_observer(|on: On<ContactEnded>, mut seen: ResMut<Seen>| {
        seen.0.push((on.entity, on.other, false));
    });
    let world = app.world_mut();
    let ground = world.spawn(floor()).id();
    let body = world.spawn((crate_at(0.0, 0.2), ContactEvents::default())).id();
    tick(&mut app, 10);
    let touched = |app: &App| app.world().get::<Touching>(body).unwrap().0.clone();
    assert_eq!(touched(&app), [ground]);
    app.world_mut().entity_mut(body).remove::<ContactEvents>();
    tick(&mut app, 1);
    assert_eq!(touched(&app), []);
    assert_eq!(app.world().resource::<Seen>().0, [(body, ground, false)]);
    app.world_mut().entity_mut(body).insert(ContactEvents::default());
    tick(&mut app, 2);
    assert_eq!(touched(&app), [ground]);
    // With the entity, they end once.
    app.world_mut().despawn(body);
    tick(&mut app, 1);
    assert_eq!(app.world().resource::<Seen>().0.len(), 2);
}

/// The transform of a sleeping body with a parent was written in every tick in which anything was awake.
#[test]
fn the_transform_of_a_sleeping_child_is_not_written() {
    #[derive(Resource, Default)]
    struct Written(Vec<Entity>);
    let mut app = app();
    app.init_resource::<Written>();
    let note = |mut written: ResMut<Written>,
                all: Query<Entity, (Changed<Transform>, With<Sleep>)>| {
        written.0 = all.iter().collect();
    };
    app.add_systems(Last, note);
    let world = app.world_mut();
    world.spawn(floor());
    let turned = Transform::from_rotation(Quat::from_rotation_y(0.7));
    let level = world.spawn(turned.with_translation(Vec3::X)).id();
    let child = (crate_at(0.0, 0.2), ChildOf(level));
    let child = world.spawn(child).insert(turned.with_translation(Vec3::Y * 0.2)).id();
    let awake = world.spawn((crate_at(4.0, 0.2), SleepingDisabled)).id();
    tick(&mut app, 180);
    assert!(app.world().get::<Sleep>(child).unwrap().asleep);
    assert_eq!(app.world().resource::<Written>().0, [awake]);
    // It is still moved with its parent.
    let before = app.world().get::<WorldCenterOfMass>(child).unwrap().position;
    app.world_mut().get_mut::<Transform>(level).unwrap().translation.x += 0.5;
    tick(&mut app, 1);
    let moved = app.world().get::<WorldCenterOfMass>(child).unwrap().position - before;
    assert!(moved.distance(Vec3::X * 0.5) < 1e-3, "{moved}");
}

/// A sensor that was switched off, moved away or given other layers still counted as touching what slept in it.
#[test]
fn the_overlap_of_a_sensor_with_a_sleeping_body_begins_and_ends_as_with_any_other() {
    type Edit = fn(&mut EntityWorldMut);
    let ends: [(&str, Edit); 4] = [
        ("switched off", |sensor| _ = sensor.insert(ContactsDisabled)),
        ("moved", |sensor| _ = sensor.insert(Transform::from_xyz(50.0, 0.0, 0.0))),
        ("other layers", |sensor| _ = sensor.insert(CollisionLayers::NONE)),
        ("smaller", |sensor| _ = sensor.insert(Collider::sphere(0.05))),
    ];
    for (name, end) in ends {
        let mut app = app();
        app.init_resource::<Seen>();
        app.add_observer(|on: On<ContactStarted>, mut seen: ResMut<Seen>| {
            seen.0.push((on.entity, on.other, true));
        });
        app.add_observer(|on: On<ContactEnded>, mut seen: ResMut<Seen>| {
            seen.0.push((on.entity, on.other, false));
        });
        let world = app.world_mut();
        world.spawn(floor());
        let body = world.spawn(crate_at(0.0, 0.2)).id();
        tick(&mut app, 240);
        assert!(app.world().get::<Sleep>(body).unwrap().asleep);
        let zone = (Collider::cuboid(Vec3::splat(0.3)), Sensor, ContactEvents::default());
        let zone = app.world_mut().spawn((zone, Transform::from_xyz(0.0, 0.5, 0.0))).id();
        tick(&mut app, 300);
        assert_eq!(app.world().resource::<Seen>().0, [(zone, body, true)], "{name}");
        end(&mut app.world_mut().entity_mut(zone));
        tick(&mut app, 2);
        let all = [(zone, body, true), (zone, body, false)];
        assert_eq!(app.world().resource::<Seen>().0, all, "{name}");
        assert!(app.world().get::<Sleep>(body).unwrap().asleep, "{name}: it sleeps on");
    }
}

/// In a tick without a step (of no length, or with a condition on the substeps) the contacts of the last step were compared by the numbers that bodies had in it:
/// after a body was despawned, others seemed to touch what they did not, and to let go of each other.
#[test]
fn a_tick_without_a_step_begins_and_ends_no_contact() {
    #[derive(Resource)]
    struct Stopped(bool);
    for by_time in [true, false] {
        let mut app = App::new();
        app.add_plugins(MinimalPlugins);
        let frame = core::time::Duration::from_millis(16);
        app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(frame));
        app.add_plugins(SinewPlugin::in_schedule(Update)).insert_resource(Stopped(false));
        let goes = |stopped: Res<Stopped>| !stopped.0;
        app.configure_sets(SinewTick, SinewSystems::Substeps.run_if(goes));
        app.init_resource::<Seen>();
        app.add_observer(|on: On<ContactStarted>, mut seen: ResMut<Seen>| {
            seen.0.push((on.entity, on.other, true));
        });
        app.add_observer(|on: On<ContactEnded>, mut seen: ResMut<Seen>| {
            seen.0.push((on.entity, on.other, false));
        });
        app.finish();
        let world = app.world_mut();
        world.spawn(floor());
        let [first, _, lower, upper] =
            [(0.0, 0.2), (2.0, 0.2), (4.0, 0.2), (4.0, 0.6)].map(|(x, y)| {
                world.spawn((crate_at(x, y), ContactEvents::default(), SleepingDisabled)).id()
            });
        (0..30).for_each(|_| app.update());
        let stop = |app: &mut App, stopped: bool| match by_time {
            false => app.world_mut().resource_mut::<Stopped>().0 = stopped,
            true if stopped => app.world_mut().resource_mut::<Time<Virtual>>().pause(),
            true => app.world_mut().resource_mut::<Time<Virtual>>().unpause(),
        };
        stop(&mut app, true);
        app.world_mut().despawn(first);
        app.world_mut().resource_mut::<Seen>().0.clear();
        (0..3).for_each(|_| app.update());
        assert_eq!(app.world().resource::<Seen>().0, [], "by time: {by_time}");
        app.world_mut().despawn(lower);
        app.world_mut().resource_mut::<Seen>().0.clear();
        (0..3).for_each(|_| app.update());
        assert_eq!(app.world().resource::<Seen>().0, [], "by time: {by_time}");
        stop(&mut app, false);
        (0..3).for_each(|_| app.update());
        let seen = &app.world().resource::<Seen>().0;
        assert_eq!(*seen, [(upper, lower, false)], "by time: {by_time}");
    }
}

/// A limb as the exception of a query excepted nothing.
#[test]
fn a_query_that_leaves_out_a_limb_leaves_out_its_body() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let figure = app.world_mut().spawn(Ragdoll::default()).id();
    tick(&mut app, 2);
    let limbs: Vec<Entity> = app.world().get::<BodyParts>(figure).unwrap().iter().collect();
    let world = app.world();
    for &limb in &limbs {
        let place = world.get::<Transform>(limb).unwrap().translation;
        let ray = Ray3d::new(place + Vec3::Z * 3.0, Dir3::NEG_Z);
        let hit = |except| {
            let filter = QueryFilter { except, ..default() };
            let hit = world.resource::<SinewWorld>().cast_ray(ray, 10.0, &filter);
            hit.map(|hit| hit.entity)
        };
        let found = [None, Some(figure), Some(limb), Some(limbs[0])].map(hit);
        assert_eq!(found, [Some(figure), None, None, None]);
    }
}
