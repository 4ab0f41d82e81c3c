//! Colliders are added, removed, moved, broken and repaired in any tick: one message each, and no effect on anything else. After a restored snapshot everything
//! happens again, bit for bit.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyContacts, ColliderFault, ColliderMotion, ContactsDisabled, Refusal, SinewClock,
    SinewSnapshot,
};

use crate::bad_input::refused;
use crate::snapshot::{hashes, roll_back_in_every_tick};
use crate::support::{app, assert_finite, busy_scene, forget, hash_of, heard, position, tick};

const BAD: f32 = f32::NAN;

/// A mesh of one triangle.
fn triangle() -> Collider {
    Collider::mesh([Vec3::ZERO, Vec3::X, Vec3::Z], [[0, 2, 1]]).unwrap()
}

/// A platform that the game moves in a circle.
#[derive(Component)]
struct Carousel;

fn turn(mut driven: Query<&mut Transform, With<Carousel>>, clock: Res<SinewClock>) {
    for mut transform in &mut driven {
        let t = clock.tick as f32 * 0.03;
        let to = Vec3::new(t.sin() * 0.5, 0.3 + t.cos() * 0.1, 0.0);
        *transform = transform.with_rotation(Quat::from_rotation_y(t)).with_translation(to);
    }
}

#[test]
fn an_invalid_collider_is_named_once() {
    let cases: [(fn(&mut EntityWorldMut), ColliderFault); 4] = [
        (|e| _ = e.insert(Transform::from_xyz(0.0, BAD, 0.0)), ColliderFault::Transform),
        (
            |e| _ = e.insert(Transform::from_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0))),
            ColliderFault::Transform,
        ),
        (|e| _ = e.insert(SurfaceMaterial::new(BAD)), ColliderFault::Material),
        (
            |e| _ = e.insert(SurfaceMaterial::default().with_restitution(1.5)),
            ColliderFault::Material,
        ),
    ];
    for (spoil, fault) in cases {
        refused(Refusal::Collider(fault), |world| {
            // In the middle of the scene.
            let mut entity = world.spawn(Collider::cuboid(Vec3::splat(6.0)));
            spoil(&mut entity);
            entity.id()
        });
    }
    for broken in [
        Collider::sphere(BAD),
        Collider::sphere(0.0),
        Collider::capsule(-1.0, 2.0),
        Collider::capsule(1.0, BAD),
        Collider::cuboid(Vec3::new(2.0, 0.0, BAD)),
        Collider::cylinder(f32::INFINITY, 2.0),
    ] {
        let fault = ColliderFault::from(broken.shape().unwrap_err());
        refused(Refusal::Collider(fault), |world| world.spawn(broken.clone()).id());
    }
    for scale in [Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), Vec3::splat(BAD)] {
        for shape in [
            triangle(),
            Collider::cuboid(Vec3::splat(2.0)),
            Collider::sphere(1.0),
            Collider::plane(),
        ] {
            let scaled = Transform::from_scale(scale);
            let mut app = app();
            let bodies = busy_scene(&mut app);
            let culprit = app.world_mut().spawn((shape.clone(), scaled)).id();
            tick(&mut app, 10);
            let refusals = heard(&app);
            assert_eq!(refusals.len(), 1, "{shape:?} {scale}: {refusals:?}");
            assert!(
                matches!(&refusals[0], (e, Refusal::Collider(_)) if *e == culprit),
                "{refusals:?}"
            );
            let mut alone = crate::support::app();
            let controls = busy_scene(&mut alone);
            tick(&mut alone, 10);
            assert_eq!(hash_of(&app, &bodies), hash_of(&alone, &controls), "{shape:?} {scale}");
        }
    }
}

#[test]
fn invalid_meshes_are_refused_by_their_constructors() {
    assert!(Collider::mesh([Vec3::ZERO], [[0, 1, 2]]).is_err());
    assert!(Collider::mesh([Vec3::splat(BAD); 3], [[0, 1, 2]]).is_err());
    assert!(Collider::mesh(Vec::<Vec3>::new(), Vec::<[u32; 3]>::new()).is_err());
    assert!(Collider::hull(&[Vec3::ZERO; 8]).is_err());
    assert!(Collider::hull(&[Vec3::X, Vec3::Y, Vec3::splat(BAD), Vec3::ZERO]).is_err());
    assert!(Collider::height_field(1, 9, &[0.0; 9], Vec3::ONE).is_err());
    assert!(Collider::height_field(3, 3, &[0.0; 8], Vec3::ONE).is_err());
    assert!(Collider::height_field(2, 2, &[0.0, BAD, 0.0, 0.0], Vec3::ONE).is_err());
}

#[test]
fn a_repaired_collider_acts_again_and_is_named_again_when_it_breaks_again() {
    let mut app = app();
    let floor = (Collider::cuboid(Vec3::splat(BAD)), Transform::from_xyz(0.0, -1.0, 0.0));
    let floor = app.world_mut().spawn(floor).id();
    let ball = app.world_mut().spawn((Particle::at(Vec3::Y), Radius(0.1))).id();
    let broken = |app: &App| heard(app).iter().filter(|(e, _)| *e == floor).count();
    tick(&mut app, 5);
    assert_eq!(broken(&app), 1);
    *app.world_mut().get_mut::<Collider>(floor).unwrap() = Collider::cuboid(Vec3::splat(2.0));
    tick(&mut app, 90);
    assert!((position(&app, ball).y - 0.1).abs() < 2e-3, "{}", position(&app, ball));
    forget(&mut app);
    app.world_mut().get_mut::<Transform>(floor).unwrap().scale.y = BAD;
    tick(&mut app, 3);
    assert_eq!((broken(&app), heard(&app).len()), (1, 1));
    app.world_mut().get_mut::<Transform>(floor).unwrap().scale.y = 1.0;
    tick(&mut app, 90);
    // A repaired collider starts where it is: it has no motion that would carry the ball along.
    assert_eq!(position(&app, ball).x, 0.0);
    assert_eq!(heard(&app).len(), 1);
    assert_finite(&mut app);
}

#[test]
fn distant_colliders_that_are_added_moved_scaled_and_removed_change_no_bit() {
    let run = |meddle: bool| {
        let mut app = app();
        let bodies = busy_scene(&mut app);
        let mut guests: Vec<Entity> = Vec::new();
        let mut hashes = Vec::new();
        for now in 0..80_u32 {
            if meddle {
                let far = Transform::from_xyz(200.0, 30.0 * (now % 5) as f32, 0.0);
                let shapes = [
                    Collider::default(),
                    Collider::sphere(1.0),
                    Collider::cylinder(1.0, 2.0),
                    triangle(),
                ];
                let shape = shapes[now as usize % 4].clone();
                let world = app.world_mut();
                match now % 8 {
                    // Despawned in the tick in which it was spawned.
                    0 => {
                        let gone = world.spawn((shape, far)).id();
                        world.despawn(gone);
                    }
                    1 | 2 => guests.push(world.spawn((shape, far)).id()),
                    3 => {
                        let parent = world.spawn(far).id();
                        guests.push(world.spawn((shape, ChildOf(parent))).id());
                    }
                    4 => world.get_mut::<Transform>(guests[0]).unwrap().translation.y += 1.0,
                    5 => world.get_mut::<Transform>(guests[0]).unwrap().scale = Vec3::splat(2.0),
                    6 => drop(
                        world.entity_mut(guests[0]).insert((Sensor, SurfaceMaterial::new(0.1))),
                    ),
                    _ => drop(world.despawn(guests.remove(0))),
                }
            }
            tick(&mut app, 1);
            hashes.push(hash_of(&app, &bodies));
        }
        assert_eq!(heard(&app), []);
        hashes
    };
    let (with, without) = (run(true), run(false));
    let first = with.iter().zip(&without).position(|(a, b)| a != b);
    assert_eq!(first, None, "the first tick that differs");
}

#[test]
fn neither_the_order_of_archetypes_nor_that_of_queries_changes_a_bit() {
    let run = |turned: bool| {
        let mut app = app();
        if turned {
            // The archetypes are created in another order.
            let early = app
                .world_mut()
                .spawn((Collider::default(), Sensor, SurfaceMaterial::default()))
                .id();
            let other = app.world_mut().spawn((Collider::default(), CollisionLayers::NONE)).id();
            app.world_mut().despawn(early);
            app.world_mut().despawn(other);
        }
        let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
        let world = app.world_mut();
        world.spawn((Collider::sphere(0.5), at(0.0)));
        world.spawn((Collider::sphere(0.6), CollisionLayers::default(), at(0.3)));
        world.spawn((Collider::sphere(0.4), SurfaceMaterial::new(0.1), at(-0.3)));
        let cloth = Cloth { radius: 0.02, ..Cloth::grid(1.0, 1.0, 12, 12) };
        let flat = Quat::from_rotation_x(1.5);
        let cloth =
            world.spawn((cloth, Transform::from_xyz(0.1, 0.8, 0.0).with_rotation(flat))).id();
        tick(&mut app, 60);
        hash_of(&app, &[cloth])
    };
    assert_eq!(run(false), run(true));
}

/// A turning, moving platform with things on it, and things that collide beside it.
fn fair(app: &mut App) {
    app.add_systems(FixedUpdate, turn);
    let world = app.world_mut();
    world.spawn((Collider::cylinder(1.5, 0.4), SurfaceMaterial::new(0.8), Carousel));
    world.spawn((Collider::plane(), Transform::from_xyz(0.0, -0.5, 0.0)));
    for i in 0..3 {
        let at = Transform::from_xyz(0.3 * i as f32 - 0.3, 0.9 + 0.45 * i as f32, 0.0);
        world.spawn((RigidBox::new(Vec3::splat(0.3)), at, BodyContacts::default()));
    }
    for i in 0..10 {
        let place = Vec3::new(0.1 * i as f32 - 0.5, 1.2, 0.6);
        world.spawn((Particle::at(place), Radius(0.08), Mass(0.1), BodyContacts::default()));
    }
    let cloth = Cloth { radius: 0.02, ..Cloth::grid(0.8, 0.8, 10, 10) };
    let flat = Quat::from_rotation_x(1.5);
    let at = Transform::from_xyz(0.0, 1.8, -0.2).with_rotation(flat);
    world.spawn((cloth, at, BodyContacts::ALL));
}

#[test]
fn a_restored_snapshot_with_a_moving_collider_goes_on_bit_for_bit() {
    let mut app = app();
    fair(&mut app);
    tick(&mut app, 40);
    let saved = SinewSnapshot::capture(app.world());
    let first = hashes(&mut app, 60);
    saved.restore(app.world_mut()).unwrap();
    assert_eq!(hashes(&mut app, 60), first);
    assert_eq!(heard(&app), []);
    assert_finite(&mut app);
}

#[test]
fn a_fresh_app_with_the_restored_colliders_goes_on_bit_for_bit() {
    let mut old = app();
    fair(&mut old);
    tick(&mut old, 40);
    let saved = SinewSnapshot::capture(old.world());
    let expected = hashes(&mut old, 60);
    let mut new = app();
    new.add_systems(FixedUpdate, turn);
    let map = saved.restore(new.world_mut()).unwrap();
    let world = old.world_mut();
    for entity in world.query_filtered::<Entity, With<Carousel>>().iter(world) {
        new.world_mut().entity_mut(map[&entity]).insert(Carousel);
    }
    assert_eq!(hashes(&mut new, 60), expected);
}

#[test]
fn a_rollback_every_tick_changes_nothing() {
    let mut app = app();
    fair(&mut app);
    roll_back_in_every_tick(&mut app, 50);
}

#[test]
fn a_pause_moves_nothing_and_a_collider_moved_meanwhile_pushes_in_one_tick() {
    let mut app = app();
    let wall = app.world_mut().spawn((Collider::cuboid(Vec3::ONE), Transform::default())).id();
    app.insert_resource(Gravity(Vec3::ZERO));
    let ball = app.world_mut().spawn((Particle::at(Vec3::X), Radius(0.1))).id();
    tick(&mut app, 5);
    let motion = |app: &App| *app.world().get::<ColliderMotion>(wall).unwrap();
    let before = motion(&app);
    app.world_mut().resource_mut::<SinewControl>().paused = true;
    for _ in 0..5 {
        app.world_mut().get_mut::<Transform>(wall).unwrap().translation.x += 0.1;
        tick(&mut app, 1);
    }
    assert_eq!((motion(&app), position(&app, ball)), (before, Vec3::X));
    app.world_mut().resource_mut::<SinewControl>().paused = false;
    tick(&mut app, 1);
    assert_ne!(motion(&app), before);
    assert!(position(&app, ball).x >= 1.1 - 1e-3, "pushed: {}", position(&app, ball));
}

/// A collider that was switched off, or removed, kept its last placement, and swept from there to where it took part again, as it did as a clone of another one:
/// a crate on the way was thrown away at 359 m/s.
#[test]
fn a_collider_that_takes_part_again_or_is_cloned_sweeps_nothing_along() {
    type Edit = fn(&mut EntityWorldMut);
    let cases: [(&str, Edit, Edit); 2] = [
        (
            "switched off",
            |door| _ = door.insert(ContactsDisabled),
            |door| _ = door.remove::<ContactsDisabled>(),
        ),
        (
            "removed",
            |door| _ = door.remove::<Collider>(),
            |door| _ = door.insert(Collider::cuboid(Vec3::ONE)),
        ),
    ];
    let scene = || {
        let mut app = app();
        let world = app.world_mut();
        world.spawn(Ground);
        let door = (Collider::cuboid(Vec3::ONE), Transform::from_xyz(-3.0, 0.5, 0.0));
        let door = world.spawn(door).id();
        let body = (RigidBox::new(Vec3::splat(0.5)), Transform::from_xyz(0.0, 0.25, 0.0));
        let body = world.spawn(body).id();
        tick(&mut app, 30);
        (app, door, body)
    };
    let assert_unmoved = |app: &App, body: Entity, name: &str| {
        let place = app.world().get::<Transform>(body).unwrap().translation;
        assert!(place.distance(Vec3::Y * 0.25) < 1e-3, "{name}: {place}");
    };
    for (name, off, on) in cases {
        let (mut app, door, body) = scene();
        off(&mut app.world_mut().entity_mut(door));
        tick(&mut app, 2);
        app.world_mut().get_mut::<Transform>(door).unwrap().translation.x = 3.0;
        tick(&mut app, 2);
        on(&mut app.world_mut().entity_mut(door));
        tick(&mut app, 3);
        assert_unmoved(&app, body, name);
        // It is a collider as any other again.
        app.world_mut().get_mut::<Transform>(door).unwrap().translation.x = 0.7;
        tick(&mut app, 2);
        assert!(app.world().get::<Transform>(body).unwrap().translation.x < -0.04, "{name}");
    }
    let (mut app, door, body) = scene();
    let clone = app.world_mut().entity_mut(door).clone_and_spawn();
    app.world_mut().get_mut::<Transform>(clone).unwrap().translation.x = 3.0;
    tick(&mut app, 3);
    assert_unmoved(&app, body, "cloned");
}
