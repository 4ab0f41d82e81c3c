//! `Ground` and `BoundingBox` are colliders like others: material, layers, sensors, events and spatial queries apply to them, and a game may move them.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Combine, ContactImpulse, ContactsDisabled, QueryFilter, Touching};

use crate::support::{TICK, app, heard, tick};

/// An app with one of the two, whose solid surface is at y = 0.
fn with(room: bool) -> (App, Entity) {
    let mut app = app();
    let floor = if room {
        let size = Vec3::new(40.0, 20.0, 40.0);
        let at = Transform::from_xyz(0.0, 10.0, 0.0);
        app.world_mut().spawn((BoundingBox { size }, at)).id()
    } else {
        app.world_mut().spawn(Ground).id()
    };
    (app, floor)
}

/// One thing for each kind of contact: a particle, a box, a cloth, and a rope, which collides by its segments.
fn things(app: &mut App, with: impl Bundle + Clone) -> [(&'static str, Entity); 4] {
    let world = app.world_mut();
    let at = |x: f32| Transform::from_xyz(x, 1.0, 0.0);
    let particle = (Particle::at(Vec3::new(-6.0, 1.0, 0.0)), Radius(0.1), Mass(0.2));
    let solid = RigidBox::new(Vec3::splat(0.4));
    [
        ("particle", world.spawn((particle, with.clone())).id()),
        ("box", world.spawn((solid, at(-2.0), with.clone())).id()),
        ("cloth", world.spawn((Cloth::grid(0.5, 0.5, 3, 3), at(2.0), with.clone())).id()),
        (
            "rope",
            world.spawn((Rope { to: Vec3::X, pin_start: false, ..default() }, at(5.0), with)).id(),
        ),
    ]
}

/// Height of the lowest particle of a thing, metres.
fn height(app: &App, thing: Entity) -> f32 {
    let world = app.world();
    let place = |entity: Entity| world.get::<Particle>(entity).map(|one| one.position.y);
    let own = place(thing);
    own.unwrap_or_else(|| {
        let all = crate::support::particles_of(app, thing);
        all.into_iter().filter_map(place).fold(f32::INFINITY, f32::min)
    })
}

#[test]
fn layers_decide_which_things_fall_through() {
    for room in [false, true] {
        for substeps in [2, 10] {
            let (mut app, floor) = with(room);
            app.world_mut().resource_mut::<SolverConfig>().substeps = substeps;
            app.world_mut().entity_mut(floor).insert(CollisionLayers::of(&[3], &[1]));
            let held = things(&mut app, CollisionLayers::of(&[1], &[3]));
            let mut shifted = things(&mut app, CollisionLayers::of(&[2], &[3]));
            let bare = things(&mut app, ());
            shifted.iter_mut().for_each(|one| one.0 = "falls");
            tick(&mut app, 90);
            for (name, thing) in held {
                let at = height(&app, thing);
                assert!(at > -0.02, "{name}, room {room}, {substeps}: held at {at}");
            }
            for (name, thing) in shifted.into_iter().chain(bare) {
                let at = height(&app, thing);
                assert!(at < -2.0, "{name}, room {room}, {substeps}: falls, is at {at}");
            }
            assert_eq!(heard(&app), []);
        }
    }
}

/// How high a ball bounces that falls from a metre above a floor, as a share of that metre.
fn bounce(room: bool, floor: SurfaceMaterial, ball: SurfaceMaterial, rigid: bool) -> f32 {
    let (mut app, entity) = with(room);
    app.world_mut().entity_mut(entity).insert(floor);
    app.insert_resource(AirDrag(0.0));
    let at = Vec3::new(0.0, 1.1, 0.0);
    let ball = if rigid {
        let shape = RigidMesh::density(700.0).shaped(RigidShape::Sphere { radius: 0.1 });
        app.world_mut().spawn((shape, ball, Transform::from_translation(at))).id()
    } else {
        app.world_mut().spawn((Particle::at(at), Radius(0.1), ball)).id()
    };
    let (mut before, mut landed, mut top) = (f32::INFINITY, false, 0.0_f32);
    for _ in 0..90 {
        tick(&mut app, 1);
        let world = app.world();
        let y = match world.get::<Particle>(ball) {
            Some(particle) => particle.position.y,
            None => world.get::<Transform>(ball).unwrap().translation.y,
        };
        landed |= y > before - 1e-3;
        before = y;
        if landed {
            top = top.max(y - 0.1);
        }
    }
    top
}

#[test]
fn restitution_follows_from_the_materials_of_both() {
    let lively = SurfaceMaterial::default().with_restitution(0.8);
    let most = lively.with_rules(Combine::Average, Combine::Max);
    for room in [false, true] {
        for rigid in [false, true] {
            let cases = [
                (lively, lively, 0.8_f32),
                (SurfaceMaterial::default(), lively, 0.4),
                (lively, SurfaceMaterial::default(), 0.4),
                (SurfaceMaterial::default(), most, 0.8),
                (SurfaceMaterial::default(), SurfaceMaterial::default(), 0.0),
            ];
            for (floor, ball, e) in cases {
                let top = bounce(room, floor, ball, rigid);
                let expected = e * e;
                assert!(
                    (top - expected).abs() < 0.06,
                    "room {room}, rigid {rigid}: {floor:?} {ball:?} {top} instead of {expected}"
                );
            }
        }
    }
}

/// The floor that things slide on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Floor {
    Ground,
    Room,
    Slab,
}

/// How far a thing slides that starts at 2 m/s on a floor, metres.
fn slide(floor: Floor, friction: f32, thing: SurfaceMaterial, kind: usize) -> f32 {
    let (mut app, entity) = with(floor == Floor::Room);
    if floor == Floor::Slab {
        let slab = Collider::cuboid(Vec3::new(40.0, 1.0, 40.0));
        let at = Transform::from_xyz(0.0, -0.5, 0.0);
        app.world_mut().entity_mut(entity).remove::<Ground>().insert((slab, at));
    }
    app.world_mut().entity_mut(entity).insert(SurfaceMaterial::new(friction));
    app.insert_resource(AirDrag(0.0));
    let start = Vec3::new(0.0, 0.1, 0.0);
    let velocity = Vec3::X * 2.0;
    let at = Transform::from_translation(start);
    let world = app.world_mut();
    let one = match kind {
        0 => world.spawn((Particle::at(start).with_velocity(velocity), Radius(0.1), thing)).id(),
        1 => {
            let plate = RigidBox::new(Vec3::new(0.8, 0.2, 0.8));
            world.spawn((plate, thing, at, LinearVelocity(velocity))).id()
        }
        _ => {
            let flat = Transform::from_xyz(0.0, 0.01, 0.0)
                .with_rotation(Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2));
            let cloth = Cloth::grid(0.5, 0.5, 4, 4);
            world.spawn((cloth, thing, flat, LinearVelocity(velocity))).id()
        }
    };
    tick(&mut app, 1);
    let begins = place(&app, one);
    tick(&mut app, 240);
    (place(&app, one) - begins).x
}

fn place(app: &App, thing: Entity) -> Vec3 {
    let all = crate::support::particles_of(app, thing);
    let all = if all.is_empty() { vec![thing] } else { all };
    let places = all.iter().map(|&one| app.world().get::<Particle>(one).unwrap().position);
    places.sum::<Vec3>() / all.len() as f32
}

#[test]
fn friction_combines_both_materials_by_their_rules() {
    let rule = |friction: f32, rule| SurfaceMaterial::new(friction).with_rules(rule, rule);
    for kind in [0, 1, 2] {
        for (friction, thing, mu) in [
            (0.5, SurfaceMaterial::default(), 0.5),
            (0.2, SurfaceMaterial::new(0.6), 0.4),
            (0.8, rule(0.3, Combine::Min), 0.3),
            (0.2, rule(0.7, Combine::Max), 0.7),
            (0.5, rule(0.6, Combine::Multiply), 0.3),
        ] {
            let slab = slide(Floor::Slab, friction, thing, kind);
            for floor in [Floor::Ground, Floor::Room] {
                let far = slide(floor, friction, thing, kind);
                let case = format!("{floor:?}, kind {kind}: {friction} on {thing:?}");
                assert!((far / slab - 1.0).abs() < 0.02, "{case}: {far}, and {slab} on a slab");
                // The first tick, at 2 m/s, is over before the start is measured. A cloth wrinkles, so it is compared with the slab alone.
                let (expected, first) = (4.0 / (2.0 * mu * 9.81), 2.0 * TICK.as_secs_f32());
                let right = far < expected * 1.04 && far > expected * 0.94 - first;
                assert!(kind == 2 || right, "{case}: {far} for {expected}");
            }
        }
    }
}

#[derive(Resource, Default)]
struct Heard(Vec<(Entity, Entity, bool)>, Vec<(Entity, Entity)>, f32);

fn listen(app: &mut App) {
    app.init_resource::<Heard>();
    app.add_systems(
        Last,
        |mut heard: ResMut<Heard>,
         mut started: MessageReader<ContactStarted>,
         mut ended: MessageReader<ContactEnded>,
         mut impulses: MessageReader<ContactImpulse>| {
            heard.0.extend(started.read().map(|one| (one.entity, one.other, one.sensor)));
            heard.1.extend(ended.read().map(|one| (one.entity, one.other)));
            heard.2 += impulses.read().map(|one| one.impulse).sum::<f32>();
        },
    );
}

#[test]
fn a_floor_with_contact_events_reports_what_lands_on_it_and_its_weight() {
    for room in [false, true] {
        let (mut app, floor) = with(room);
        listen(&mut app);
        app.world_mut().entity_mut(floor).insert(ContactEvents::Every);
        let things = things(&mut app, ());
        let crates = things[1].1;
        tick(&mut app, 180);
        let touching = app.world().get::<Touching>(floor).unwrap().0.clone();
        for (name, thing) in things {
            let heard = app.world().resource::<Heard>();
            assert!(heard.0.contains(&(floor, thing, false)), "room {room}: {name} landed");
            assert!(touching.contains(&thing), "room {room}: {name} lies on it");
        }
        // The impulses are those of the weight of what lies on it.
        for (_, thing) in things.iter().filter(|one| one.1 != crates) {
            app.world_mut().despawn(*thing);
        }
        tick(&mut app, 2);
        app.world_mut().resource_mut::<Heard>().2 = 0.0;
        tick(&mut app, 30);
        let mass = app.world().get::<Mass>(crates).map_or(1.0, |mass| mass.0);
        let force = app.world().resource::<Heard>().2 / (30.0 * TICK.as_secs_f32());
        assert!((force / (mass * 9.81) - 1.0).abs() < 0.02, "room {room}: {force} N of {mass} kg");
        app.world_mut().despawn(crates);
        tick(&mut app, 2);
        assert!(app.world().resource::<Heard>().1.contains(&(floor, crates)), "room {room}");
    }
}

#[test]
fn a_floor_that_is_a_sensor_lets_through_and_reports() {
    for room in [false, true] {
        let (mut app, floor) = with(room);
        listen(&mut app);
        app.world_mut().entity_mut(floor).insert((Sensor, ContactEvents::default()));
        let things = things(&mut app, ());
        tick(&mut app, 90);
        for (name, thing) in things {
            assert!(height(&app, thing) < -1.0, "room {room}: {name} falls through");
            let heard = app.world().resource::<Heard>();
            assert!(heard.0.contains(&(floor, thing, true)), "room {room}: {name} was reported");
        }
    }
}

#[test]
fn a_disabled_floor_holds_nothing_until_it_is_enabled_again() {
    for room in [false, true] {
        let (mut app, floor) = with(room);
        app.world_mut().entity_mut(floor).insert(ContactsDisabled);
        let things = things(&mut app, ());
        tick(&mut app, 36);
        for (name, thing) in things {
            assert!(height(&app, thing) < -0.2, "{name} falls through");
        }
        app.world_mut().entity_mut(floor).remove::<ContactsDisabled>();
        tick(&mut app, 240);
        for (name, thing) in things {
            let at = height(&app, thing);
            assert!(at > -0.02, "room {room}: {name} is held again: {at}");
        }
    }
}

#[test]
fn spatial_queries_hit_grounds_and_walls() {
    let mut app = app();
    let world = app.world_mut();
    let tilted = Transform::from_xyz(0.0, -1.0, 0.0)
        .with_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_6));
    let ground = world.spawn((Ground, tilted, CollisionLayers::of(&[1], &[1]))).id();
    let size = Vec3::new(8.0, 6.0, 4.0);
    let room = BoundingBox { size };
    let at = Transform::from_xyz(0.0, 1.0, 0.0);
    let room = world.spawn((room, at, CollisionLayers::of(&[2], &[2]))).id();
    tick(&mut app, 1);
    let world = app.world_mut().resource::<SinewWorld>();
    let all = QueryFilter::default();
    let down = Ray3d::new(Vec3::ZERO, Dir3::NEG_Y);
    let hit = world.cast_ray(down, 100.0, &all).expect("it hits the ground");
    assert_eq!((hit.entity, hit.particle), (ground, None));
    assert!((hit.distance - 1.0).abs() < 1e-4, "{hit:?}");
    assert!(hit.normal.dot(Vec3::Y) < 0.9 && hit.normal.dot(Vec3::Y) > 0.8);
    // Filtered out by layers or by entity, the ground is passed, and the floor of the bounding box is hit next.
    let layers = Some(CollisionLayers::of(&[2], &[2]));
    for filter in [QueryFilter { layers, ..all }, QueryFilter { except: Some(ground), ..all }] {
        let hit = world.cast_ray(down, 100.0, &filter).expect("the floor of the room");
        assert_eq!(hit.entity, room);
        assert!((hit.distance - 2.0).abs() < 1e-4 && hit.normal == Vec3::Y, "{hit:?}");
    }
    let inside = QueryFilter { except: Some(ground), ..all };
    for (direction, far) in [
        (Dir3::X, 4.0),
        (Dir3::NEG_X, 4.0),
        (Dir3::Y, 4.0),
        (Dir3::NEG_Y, 2.0),
        (Dir3::Z, 2.0),
        (Dir3::NEG_Z, 2.0),
    ] {
        let hit = world.cast_ray(Ray3d::new(Vec3::ZERO, direction), 100.0, &inside).unwrap();
        assert!(hit.entity == room && (hit.distance - far).abs() < 1e-4, "{direction:?} {hit:?}");
        assert!((hit.normal + *direction).length() < 1e-5);
        let ball = Collider::sphere(0.5);
        let hit = world.cast_shape(&ball, Isometry3d::IDENTITY, direction, 100.0, &inside);
        let hit = hit.expect("it hits a wall");
        assert!((hit.distance - far + 0.5).abs() < 1e-3, "{direction:?} {hit:?}");
        let at = Isometry3d::from_translation(*direction * (far - 0.4));
        assert_eq!(world.overlapping(&ball, at, &inside), [room]);
        let at = Isometry3d::from_translation(*direction * (far - 0.6));
        assert_eq!(world.overlapping(&ball, at, &inside), []);
    }
    assert_eq!(world.cast_ray(down, 100.0, &QueryFilter { no_colliders: true, ..all }), None);
}

#[test]
fn a_floor_that_the_game_moves_carries_the_things_on_it() {
    for room in [false, true] {
        let (mut app, floor) = with(room);
        let things = things(&mut app, ());
        tick(&mut app, 120);
        let before: Vec<f32> = things.iter().map(|one| height(&app, one.1)).collect();
        let across: Vec<Vec3> = things.iter().map(|one| place(&app, one.1)).collect();
        for _ in 0..60 {
            app.world_mut().get_mut::<Transform>(floor).unwrap().translation +=
                Vec3::new(0.01, 0.01, 0.0);
            tick(&mut app, 1);
        }
        for (i, (name, thing)) in things.into_iter().enumerate() {
            let up = height(&app, thing) - before[i];
            assert!((up - 0.6).abs() < 0.03, "room {room}: {name} goes up: {up}");
            let along = (place(&app, thing) - across[i]).x;
            assert!((along - 0.6).abs() < 0.06, "room {room}: {name} is carried: {along}");
        }
    }
}

#[test]
fn a_room_may_be_turned_and_scaled() {
    let mut app = app();
    let turn = Quat::from_rotation_z(core::f32::consts::FRAC_PI_4);
    let at = Transform::from_rotation(turn).with_scale(Vec3::splat(2.0));
    app.world_mut().spawn((BoundingBox { size: Vec3::splat(1.0) }, at));
    let ice = SurfaceMaterial::new(0.0).with_rules(Combine::Min, Combine::Average);
    let ball = (Particle::at(Vec3::new(0.3, 0.0, 0.0)), Radius(0.1), ice);
    let ball = app.world_mut().spawn(ball).id();
    tick(&mut app, 600);
    let at = app.world().get::<Particle>(ball).unwrap().position;
    // In the lowest corner, a radius away from both of its walls.
    let lowest = (1.0 - 0.1) * 2f32.sqrt();
    assert!((at.y + lowest).abs() < 0.01 && at.x.abs() < 0.05, "{at}");
    assert_eq!(heard(&app), []);
}

#[test]
fn a_sleeping_body_wakes_when_its_floor_changes() {
    let changes: [(&str, fn(EntityWorldMut)); 5] = [
        ("friction", |mut floor| {
            floor.insert(SurfaceMaterial::new(0.0));
        }),
        ("layers", |mut floor| {
            floor.insert(CollisionLayers::NONE);
        }),
        ("sensor", |mut floor| {
            floor.insert(Sensor);
        }),
        ("disabled", |mut floor| {
            floor.insert(ContactsDisabled);
        }),
        ("gone", |floor| floor.despawn()),
    ];
    for (name, change) in changes {
        for room in [false, true] {
            let (mut app, floor) = with(room);
            let at = Transform::from_xyz(0.0, 0.2, 0.0);
            let body = (RigidBox::new(Vec3::splat(0.4)), Sleep::default(), at);
            let body = app.world_mut().spawn(body).id();
            let asleep = |app: &App| app.world().get::<Sleep>(body).unwrap().asleep;
            tick(&mut app, 180);
            assert!(asleep(&app), "{name}, room {room}: it sleeps");
            change(app.world_mut().entity_mut(floor));
            tick(&mut app, 2);
            assert!(!asleep(&app), "{name}, room {room}: it wakes");
        }
    }
}
