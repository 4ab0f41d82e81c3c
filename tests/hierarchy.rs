//! Bodies, colliders and regions in a hierarchy are where Bevy would draw them.

use core::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{Attractor, BuiltBody, Charge, ElectricField, Touching, sinew};
use bevy_sinew::{Refusal, Region, WorldCenterOfMass};

use crate::support::{app, forget, heard, particles_of, position, tick};

/// An app without gravity and without drag.
fn space() -> App {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    app
}

/// A child of a parent that is moved, turned and scaled. Returns the child and its frame in the world.
fn nested(world: &mut World) -> (Entity, Transform) {
    let outer = Transform::from_xyz(4.0, 1.0, -2.0)
        .with_rotation(Quat::from_rotation_z(0.5))
        .with_scale(Vec3::splat(2.0));
    let inner = Transform::from_xyz(0.5, 0.3, 0.1).with_rotation(Quat::from_rotation_x(0.7));
    let outer_one = world.spawn(outer).id();
    (world.spawn((inner, ChildOf(outer_one))).id(), outer * inner)
}

fn all_positions(app: &App, body: Entity) -> Vec<Vec3> {
    particles_of(app, body).into_iter().map(|one| position(app, one)).collect()
}

#[track_caller]
fn assert_near(found: &[Vec3], expected: &[Vec3]) {
    assert!(!found.is_empty() && found.len() == expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((*found - *expected).length() < 1e-4, "{found} instead of {expected}");
    }
}

#[test]
fn every_recipe_is_built_at_the_place_and_scale_of_its_parents() {
    let own = Transform::from_xyz(0.2, -0.4, 0.6).with_rotation(Quat::from_rotation_y(0.3));
    let spawns: [fn(&mut World) -> Entity; 5] = [
        |w| w.spawn(RigidBox::new(Vec3::new(1.0, 0.5, 0.25))).id(),
        |w| w.spawn(Rope::default()).id(),
        |w| w.spawn(Cloth::grid(1.0, 0.5, 6, 3)).id(),
        |w| w.spawn(SoftBody::cuboid(Vec3::splat(0.5), UVec3::splat(3))).id(),
        |w| w.spawn(Ragdoll::default()).id(),
    ];
    for spawn in spawns {
        let (mut inside, mut alone) = (space(), space());
        let (parent, frame) = nested(inside.world_mut());
        let child = spawn(inside.world_mut());
        inside.world_mut().entity_mut(child).insert((own, ChildOf(parent)));
        let root = spawn(alone.world_mut());
        alone.world_mut().entity_mut(root).insert(frame * own);
        for app in [&mut inside, &mut alone] {
            tick(app, 1);
        }
        assert_near(&all_positions(&inside, child), &all_positions(&alone, root));
        tick(&mut inside, 1);
        let drawn = inside.world().get::<GlobalTransform>(child).unwrap().to_matrix();
        assert!(drawn.abs_diff_eq((frame * own).to_matrix(), 1e-3), "{drawn}");
        assert_eq!(heard(&inside), []);
    }
}

#[test]
fn colliders_and_regions_are_where_their_parents_put_them() {
    let mut app = app();
    let world = app.world_mut();
    let up = world.spawn(Transform::from_xyz(5.0, 2.0, 0.0).with_scale(Vec3::splat(2.0))).id();
    world.spawn((Collider::cuboid(Vec3::new(1.0, 0.5, 1.0)), ChildOf(up)));
    let ball = world.spawn((Particle::at(Vec3::new(5.0, 3.0, 0.0)), Radius(0.1))).id();
    let far = world.spawn(Transform::from_xyz(-8.0, 0.0, 0.0).with_scale(Vec3::splat(3.0))).id();
    world.spawn((Attractor { strength: 0.0, ..default() }, ChildOf(far)));
    let lift = Vec3::Y * 2e7;
    world.spawn((ElectricField::new(lift), Region::sphere(1.0), ChildOf(far)));
    let at = |x: f32| (Particle::at(Vec3::new(x, 0.0, 0.0)), Charge(1e-6), Mass(1.0));
    let inside = world.spawn(at(-5.5)).id();
    let outside = world.spawn(at(-4.5)).id();
    tick(&mut app, 60);
    assert!((position(&app, ball).y - 2.6).abs() < 2e-3, "{}", position(&app, ball));
    assert!(position(&app, inside).y > 0.5, "it is lifted: {}", position(&app, inside));
    assert!(position(&app, outside).y < -1.0, "it falls: {}", position(&app, outside));
    assert_eq!(heard(&app), []);
}

#[test]
fn sheared_children_are_refused_by_name_and_come_back_when_that_is_repaired() {
    let mut app = space();
    let world = app.world_mut();
    let long = world.spawn(Transform::from_scale(Vec3::new(1.0, 3.0, 1.0))).id();
    let turned = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_4));
    let body = world.spawn((RigidBox::default(), turned, ChildOf(long))).id();
    let cloth = world.spawn((Cloth::grid(1.0, 1.0, 2, 2), turned, ChildOf(long))).id();
    let wall = world.spawn((Collider::default(), turned, ChildOf(long))).id();
    let wind = (Wind::default(), Region::boxed(Vec3::ONE), turned);
    let wind = world.spawn((wind, ChildOf(long))).id();
    // A quarter turn keeps right angles.
    let quarter = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_2));
    let flag = world.spawn((Cloth::grid(1.0, 1.0, 2, 2), quarter, ChildOf(long))).id();
    tick(&mut app, 3);
    let mut refusals = heard(&app);
    refusals.sort_by_key(|(entity, _)| *entity);
    let mut expected = [body, cloth, wall, wind].map(|entity| (entity, Refusal::Sheared));
    expected.sort_by_key(|(entity, _)| *entity);
    assert_eq!(refusals, expected);
    assert_eq!(particles_of(&app, body), []);
    let wide = all_positions(&app, flag).into_iter().fold(0.0_f32, |y, p| y.max(p.y.abs()));
    assert!((wide - 1.5).abs() < 1e-4, "its width is along the parent's height: {wide}");
    forget(&mut app);
    *app.world_mut().get_mut::<Transform>(long).unwrap() = Transform::from_xyz(1.0, 0.0, 0.0);
    tick(&mut app, 2);
    assert_eq!(heard(&app), []);
    assert!(!particles_of(&app, body).is_empty() && !particles_of(&app, cloth).is_empty());
}

#[test]
fn a_moving_parent_carries_its_bodies_without_changing_their_own_motion() {
    let fall = |speed: Vec3| {
        let mut app = app();
        let world = app.world_mut();
        let lift = world.spawn(Transform::default()).id();
        let at = Transform::from_xyz(0.0, 1.0, 0.0).with_rotation(Quat::from_rotation_z(0.3));
        let body = world.spawn((RigidBox::default(), at, ChildOf(lift))).id();
        app.add_systems(FixedUpdate, move |mut all: Query<&mut Transform, With<Children>>| {
            all.iter_mut().for_each(|mut transform| transform.translation += speed / 60.0);
        });
        tick(&mut app, 30);
        let own = *app.world().get::<Transform>(body).unwrap();
        let velocity = app.world().get::<LinearVelocity>(body).unwrap().0;
        (own, velocity, all_positions(&app, body))
    };
    let (still, carried) = (fall(Vec3::ZERO), fall(Vec3::new(2.0, 0.0, 1.0)));
    assert!(carried.0.translation.distance(still.0.translation) < 1e-4, "the same in its frame");
    assert!(carried.1.distance(still.1) < 1e-4, "the carrying is no velocity of its own");
    for (a, b) in still.2.iter().zip(&carried.2) {
        assert!((*b - *a - Vec3::new(1.0, 0.0, 0.5)).length() < 1e-4, "{a} {b}");
    }
}

#[test]
fn a_teleport_is_in_the_frame_of_the_parents() {
    for by_command in [false, true] {
        let mut app = space();
        let (parent, frame) = nested(app.world_mut());
        let body = app.world_mut().spawn((RigidBox::default(), ChildOf(parent))).id();
        tick(&mut app, 2);
        let to = Transform::from_xyz(-1.0, 0.5, 0.3).with_rotation(Quat::from_rotation_y(1.0));
        if by_command {
            app.world_mut().commands().entity(body).teleport(to);
        } else {
            *app.world_mut().get_mut::<Transform>(body).unwrap() = to;
        }
        tick(&mut app, 2);
        let middle = app.world().get::<WorldCenterOfMass>(body).unwrap().position;
        let there = (frame * to).translation;
        assert!((middle - there).length() < 1e-4, "{middle} instead of {there}");
        let own = app.world().get::<Transform>(body).unwrap();
        assert!(own.translation.distance(to.translation) < 1e-4, "{own:?}");
        assert!(own.rotation.angle_between(to.rotation) < 1e-3, "{own:?}");
    }
}

#[test]
fn scaling_a_body_or_its_parent_rebuilds_it_in_the_new_size() {
    let mut app = space();
    let world = app.world_mut();
    let parent = world.spawn(Transform::default()).id();
    let child = (RigidBox::default(), Transform::from_xyz(3.0, 0.0, 0.0), ChildOf(parent));
    let child = world.spawn(child).id();
    let alone = world.spawn((RigidBox::default(), LinearVelocity(Vec3::Y))).id();
    tick(&mut app, 2);
    let width = |app: &App, body| {
        let all = all_positions(app, body);
        let most = |f: fn(f32, f32) -> f32, from| all.iter().map(|p| p.x).fold(from, f);
        most(f32::max, f32::MIN) - most(f32::min, f32::MAX)
    };
    let before = width(&app, alone);
    app.world_mut().get_mut::<Transform>(alone).unwrap().scale = Vec3::splat(2.0);
    app.world_mut().get_mut::<Transform>(parent).unwrap().scale = Vec3::splat(3.0);
    tick(&mut app, 2);
    assert!((width(&app, alone) - 2.0 * before).abs() < 1e-3, "{}", width(&app, alone));
    assert!((width(&app, child) - 3.0 * before).abs() < 1e-3, "{}", width(&app, child));
    let velocity = app.world().get::<LinearVelocity>(alone).unwrap().0;
    assert!((velocity - Vec3::Y).length() < 1e-3, "it goes on as it went: {velocity}");
    assert_eq!(heard(&app), []);
}

#[derive(Resource, Default)]
struct Ended(Vec<(Entity, Entity)>);

#[test]
fn reparenting_scaling_or_despawning_a_body_ends_its_contacts_with_an_event() {
    let changes: [(&str, fn(&mut World, Entity)); 3] = [
        ("a new parent", |world, body| {
            let high = world.spawn(Transform::from_xyz(0.0, 5.0, 0.0)).id();
            world.entity_mut(body).insert(ChildOf(high));
        }),
        ("another scale", |world, body| {
            world.get_mut::<Transform>(body).unwrap().scale = Vec3::splat(0.5);
        }),
        ("it goes", |world, body| assert!(world.despawn(body))),
    ];
    for (name, change) in changes {
        let mut app = app();
        app.init_resource::<Ended>();
        app.add_observer(|on: On<ContactEnded>, mut ended: ResMut<Ended>| {
            ended.0.push((on.entity, on.other));
        });
        let world = app.world_mut();
        let ground = world.spawn((Ground, ContactEvents::default())).id();
        let at = Transform::from_xyz(0.0, 0.5, 0.0);
        let body = world.spawn((RigidBox::new(Vec3::ONE), at, ContactEvents::default())).id();
        tick(&mut app, 20);
        assert_eq!(app.world().get::<Touching>(body).unwrap().0, [ground], "{name}");
        change(app.world_mut(), body);
        tick(&mut app, 2);
        let ended = &app.world().resource::<Ended>().0;
        assert!(ended.contains(&(body, ground)), "{name}: {ended:?}");
        assert_eq!(ended.iter().filter(|pair| **pair == (body, ground)).count(), 1, "{name}");
    }
}

#[test]
fn interpolation_may_be_switched_on_and_off_at_any_time() {
    use bevy_sinew::Interpolate;
    let mut app = space();
    // Frames of a third of a tick.
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(crate::support::TICK / 3));
    let moving = || (RigidBox::default(), LinearVelocity(Vec3::X * 6.0));
    let body = app.world_mut().spawn(moving()).id();
    let figure =
        (Ragdoll::default(), LinearVelocity(Vec3::X * 6.0), Transform::from_xyz(0.0, 9.0, 0.0));
    let figure = app.world_mut().spawn(figure).id();
    tick(&mut app, 5);
    let head = app.world().get::<bevy_sinew::BodyParts>(figure).unwrap().iter().next().unwrap();
    let places = |app: &mut App, entity: Entity| {
        let mut seen = Vec::new();
        for _ in 0..9 {
            app.update();
            seen.push(app.world().get::<Transform>(entity).unwrap().translation.x);
        }
        seen.dedup();
        seen.len()
    };
    assert!(places(&mut app, body) <= 4, "it is drawn where a tick leaves it");
    for entity in [body, figure] {
        app.world_mut().entity_mut(entity).insert(Interpolate);
    }
    tick(&mut app, 3);
    assert_eq!(places(&mut app, body), 9, "it is drawn between ticks");
    assert_eq!(places(&mut app, head), 9, "and so are the parts of a figure");
    app.world_mut().entity_mut(body).remove::<Interpolate>();
    tick(&mut app, 3);
    assert!(places(&mut app, body) <= 4);
}

/// No component of the body is written when it loses its parent: whether any body may have moved is decided by change ticks of whole tables, so the loss itself
/// has to be noticed.
#[test]
fn a_body_that_loses_its_parent_moves_to_its_transform_without_one() {
    for scale in [1.0, 2.0] {
        let mut app = space();
        let outer = Transform::from_xyz(4.0, 1.0, -2.0).with_scale(Vec3::splat(scale));
        let own = Transform::from_xyz(0.2, -0.4, 0.6);
        let parent = app.world_mut().spawn(outer).id();
        let body = app.world_mut().spawn((RigidBox::new(Vec3::ONE), own, ChildOf(parent))).id();
        tick(&mut app, 120);
        assert!(app.world().get::<Sleep>(body).unwrap().asleep, "it rests");
        app.world_mut().entity_mut(body).remove::<ChildOf>();
        tick(&mut app, 2);
        let corners = all_positions(&app, body);
        let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
        assert!(middle.abs_diff_eq(own.translation, 1e-4), "it is at {middle}");
        let reach = corners.iter().map(|&corner| corner.distance(middle)).fold(0.0, f32::max);
        assert!((reach - 0.75_f32.sqrt()).abs() < 1e-3, "its corners are {reach} m from there");
    }
}

/// Modelling tools write scales such as 0.99999994 and 1.0000001. They counted as non-uniform: a ragdoll, a rope, a round region, and a box within such a parent
/// were refused, and a ball became a hull with 24 sides.
#[test]
fn a_scale_that_is_uniform_within_round_off_is_uniform() {
    let mut app = space();
    let scale = Vec3::new(2.0, 2.0000002, 1.9999998);
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0).with_scale(scale);
    let ball = RigidMesh::default().shaped(RigidShape::Sphere { radius: 0.5 });
    let world = app.world_mut();
    let ball = world.spawn((ball, at(0.0))).id();
    let parent = world.spawn(at(5.0).with_rotation(Quat::from_rotation_y(0.4))).id();
    let turned = Transform::from_rotation(Quat::from_rotation_x(0.7));
    let inner = world.spawn((RigidBox::default(), ChildOf(parent), turned)).id();
    let spin = AngularVelocity(Vec3::new(0.3, 2.0, 1.0));
    world.entity_mut(inner).insert(spin);
    world.spawn((Ragdoll::default(), at(12.0)));
    world.spawn((Rope::default(), at(16.0)));
    world.spawn((Wind::default(), Region::sphere(1.0), at(20.0)));
    world.spawn((Collider::sphere(0.5), at(24.0)));
    tick(&mut app, 60);
    assert_eq!(heard(&app), []);
    let round = |shape: &sinew::Shape| shape == &sinew::Shape::sphere(1.0).unwrap();
    let solver = app.world().resource::<SinewWorld>().simulation();
    assert!(round(&solver.colliders[0].shape));
    let own = app.world().get::<Collider>(ball).unwrap().shape().unwrap();
    assert!(round(&own), "{own:?}");
    let built = app.world().get::<BuiltBody>(inner).unwrap().builds;
    assert_eq!(built, 1, "it is not rebuilt as it turns");
    // A scale that is clearly not uniform is still refused.
    app.world_mut().get_mut::<Transform>(parent).unwrap().scale.y = 2.1;
    tick(&mut app, 2);
    assert!(heard(&app).contains(&(inner, Refusal::Sheared)), "{:?}", heard(&app));
}

/// Getting a parent in place takes the scale from a matrix, which is another one by its last digits: the body was rebuilt, and cloth lost its folds.
#[test]
fn a_body_that_changes_its_parent_in_place_is_not_rebuilt() {
    let mut app = space();
    let world = app.world_mut();
    let turned = Quat::from_euler(EulerRot::XYZ, 0.3, 1.0, 0.7);
    let parent = Transform::from_xyz(0.3, 0.1, 0.2).with_rotation(turned);
    let parent = world.spawn(parent.with_scale(Vec3::splat(1.7))).id();
    let motion = (LinearVelocity(Vec3::X), AngularVelocity(Vec3::new(0.3, 1.0, 0.2)));
    let bodies = [
        world.spawn((RigidBox::default(), motion)).id(),
        world.spawn((Cloth::grid(1.0, 1.0, 4, 4), motion, Transform::from_xyz(9.0, 0.0, 0.0))).id(),
    ];
    tick(&mut app, 10);
    for turn in 0..6 {
        for body in bodies {
            let before = all_positions(&app, body);
            let mut commands = app.world_mut().commands();
            if turn % 2 == 0 {
                commands.entity(body).set_parent_in_place(parent);
            } else {
                commands.entity(body).remove_parent_in_place();
            }
            tick(&mut app, 3);
            let moved: Vec<Vec3> = before.iter().map(|at| *at + Vec3::X * 0.05).collect();
            let now = all_positions(&app, body);
            let far = now.iter().zip(&moved).map(|(now, moved)| now.distance(*moved));
            assert!(far.fold(0.0, f32::max) < 0.1);
            assert_eq!(app.world().get::<BuiltBody>(body).unwrap().builds, 1);
        }
    }
}
