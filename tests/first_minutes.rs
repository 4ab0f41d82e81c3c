//! What a new user tries in the first ten minutes, with nothing configured. Each of these was once silently wrong.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyParts, Particle, SubstepSchedule, WorldCenterOfMass};

use crate::support::{app, assert_finite, heard, particles_of, position, tick};

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<Transform>(entity).unwrap().translation
}

#[test]
fn two_boxes_dropped_one_onto_the_other_stand_one_on_the_other() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn(Ground);
    let boxed = |y: f32| (RigidBox::new(Vec3::ONE), Transform::from_xyz(0.0, y, 0.0));
    let (low, high) = (world.spawn(boxed(1.0)).id(), world.spawn(boxed(2.5)).id());
    tick(&mut app, 300);
    for (body, y) in [(low, 0.5), (high, 1.5)] {
        assert!((place(&app, body) - Vec3::Y * y).length() < 0.01, "{}", place(&app, body));
    }
    assert_eq!(heard(&app), []);
}

/// One recipe of every kind: its name, how to spawn it at a height, the height of its centre when it lies on a surface at y = 0, and the tolerance, metres.
fn every_recipe() -> Vec<(&'static str, fn(&mut World, f32) -> Entity, f32, f32)> {
    vec![
        (
            "a small box",
            |w, y| {
                w.spawn((RigidBox::new(Vec3::splat(0.2)), Transform::from_xyz(0.0, y, 0.0))).id()
            },
            0.1,
            0.02,
        ),
        (
            "an icosahedron",
            |w, y| {
                let phi = 0.5 * (1.0 + 5.0_f32.sqrt());
                let corners = [-0.1, 0.1].into_iter().flat_map(|a: f32| {
                    [-0.1, 0.1].map(|b: f32| {
                        let (a, b) = (a, b * phi);
                        [Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]
                    })
                });
                let shape = RigidShape::Points(corners.flatten().collect());
                let at = Transform::from_xyz(0.0, y, 0.0);
                w.spawn((RigidMesh::default().shaped(shape), at)).id()
            },
            0.15,
            0.02,
        ),
        (
            "a rope",
            |w, y| {
                let ends = [-0.2, 0.2].map(|x| Vec3::new(x, 0.0, 0.0));
                let rope = Rope { pin_start: false, ..Rope::between(ends[0], ends[1]) };
                w.spawn((rope, Transform::from_xyz(0.0, y, 0.0))).id()
            },
            0.01,
            0.02,
        ),
        (
            "a cloth",
            |w, y| {
                let flat = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
                let at = Transform::from_xyz(0.0, y, 0.0).with_rotation(flat);
                w.spawn((Cloth::grid(0.4, 0.4, 8, 8), at)).id()
            },
            0.0,
            0.03,
        ),
        (
            "a soft cube",
            |w, y| {
                let cube = SoftBody::cuboid(Vec3::splat(0.3), UVec3::splat(3));
                w.spawn((cube, Transform::from_xyz(0.0, y, 0.0))).id()
            },
            0.15,
            0.05,
        ),
    ]
}

/// Mean position of a body's particles.
fn middle(app: &App, body: Entity) -> Vec3 {
    let own = particles_of(app, body);
    own.iter().map(|&one| position(app, one)).sum::<Vec3>() / own.len() as f32
}

#[test]
fn bodies_of_every_recipe_rest_on_a_box_on_a_collider_and_on_a_ground() {
    for (name, spawn, height, margin) in every_recipe() {
        for (on, top) in [("a ground", 0.0), ("a collider", 0.5), ("a box", 1.0)] {
            let mut app = app();
            let world = app.world_mut();
            match on {
                "a collider" => {
                    let shelf = Collider::cuboid(Vec3::new(3.0, 0.2, 3.0));
                    world.spawn((shelf, Transform::from_xyz(0.0, 0.4, 0.0)));
                }
                "a box" => {
                    world.spawn(Ground);
                    let heavy = RigidBox::new(Vec3::ONE).with_mass(100.0);
                    world.spawn((heavy, Transform::from_xyz(0.0, 0.5, 0.0)));
                }
                _ => drop(world.spawn(Ground)),
            }
            let body = spawn(world, top + height + 0.2);
            tick(&mut app, 120);
            let y = middle(&app, body).y - top;
            assert!((y - height).abs() < margin, "{name} on {on}: {y} instead of {height}");
            assert_eq!(heard(&app), [], "{name} on {on}");
            assert_finite(&mut app);
        }
    }
}

#[test]
fn a_figure_lies_on_a_box_and_a_loose_ball_on_both() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn(Ground);
    let table = RigidBox::new(Vec3::new(2.0, 0.6, 3.0)).with_mass(500.0);
    world.spawn((table, Transform::from_xyz(0.0, 0.3, 0.0)));
    let lying = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
    let at = Transform::from_xyz(0.0, 1.2, -0.6).with_rotation(lying);
    let figure = world.spawn((Ragdoll::default(), at)).id();
    let ball = (Particle::at(Vec3::new(0.7, 1.5, 0.0)), Radius(0.1), Mass(0.5));
    let ball = world.spawn(ball).id();
    tick(&mut app, 180);
    let parts: Vec<Entity> = app.world().get::<BodyParts>(figure).unwrap().iter().collect();
    let above = parts.iter().filter(|&&part| place(&app, part).y > 0.6).count();
    assert!(above + 2 >= parts.len(), "{above} of {} parts are on the table", parts.len());
    assert!((position(&app, ball).y - 0.7).abs() < 0.02, "{}", position(&app, ball));
    assert_eq!(heard(&app), []);
}

#[test]
fn a_body_that_is_a_child_is_where_its_parent_puts_it() {
    let mut app = app();
    let world = app.world_mut();
    world.insert_resource(Gravity(Vec3::ZERO));
    let parent = world.spawn(Transform::from_xyz(10.0, 0.0, 0.0)).id();
    let at = Transform::from_xyz(0.0, 2.0, 0.0);
    let body = world.spawn((RigidBox::new(Vec3::ONE), at, ChildOf(parent))).id();
    tick(&mut app, 3);
    let there = Vec3::new(10.0, 2.0, 0.0);
    assert!((middle(&app, body) - there).length() < 1e-5, "{}", middle(&app, body));
    let global = app.world().get::<GlobalTransform>(body).unwrap().translation();
    assert!((global - there).length() < 1e-5, "{global}");
    assert!((place(&app, body) - at.translation).length() < 1e-5, "{}", place(&app, body));
}

#[test]
fn a_body_has_the_velocity_and_the_mass_and_feels_the_force_that_it_is_spawned_with() {
    let mut app = app();
    let world = app.world_mut();
    world.insert_resource(Gravity(Vec3::ZERO));
    world.insert_resource(AirDrag(0.0));
    let boxed = |y: f32| (RigidBox::new(Vec3::ONE), Transform::from_xyz(0.0, y, 0.0));
    let fast = world.spawn((boxed(0.0), LinearVelocity(Vec3::X * 5.0))).id();
    let heavy = world.spawn((boxed(3.0), Mass(500.0))).id();
    let pushed = world.spawn((boxed(6.0), Mass(10.0), ExternalForce(Vec3::X * 100.0))).id();
    tick(&mut app, 30);
    assert!((place(&app, fast).x - 2.5).abs() < 1e-3, "{}", place(&app, fast));
    let mass = app.world().get::<WorldCenterOfMass>(heavy).unwrap().mass;
    assert!((mass - 500.0).abs() < 1e-3, "{mass} kg");
    // v = F/m t.
    let speed = app.world().get::<LinearVelocity>(pushed).unwrap().0;
    assert!((speed - Vec3::X * 5.0).length() < 1e-3, "{speed}");
    assert_eq!(heard(&app), []);
}

#[test]
fn sizes_are_full_sizes_as_of_bevys_primitives() {
    let size = Vec3::new(2.0, 0.6, 2.0);
    let shapes = [
        (Collider::cuboid(size), Cuboid::from_size(size).half_size.y),
        (Collider::cylinder(0.5, 0.6), Cylinder::new(0.5, 0.6).half_height),
        (Collider::capsule(0.2, 0.6), 0.2 + Capsule3d::new(0.2, 0.6).half_length),
    ];
    for (shape, top) in shapes {
        let mut app = app();
        app.world_mut().spawn(shape.clone());
        let ball = app.world_mut().spawn((Particle::at(Vec3::Y), Radius(0.1))).id();
        tick(&mut app, 90);
        let y = position(&app, ball).y;
        assert!((y - top - 0.1).abs() < 2e-3, "{y} on {shape:?}");
    }
}

#[test]
fn the_mouse_is_not_in_the_plugin_group_and_substeps_are_taken_at_once() {
    let app = app();
    let world = app.world();
    assert!(world.get_resource::<bevy_sinew::MouseDrag>().is_none());
    // Any other system in this schedule counts as a game's, for which the substeps run one by one.
    let substeps = world.resource::<Schedules>().get(SubstepSchedule).unwrap();
    assert_eq!(substeps.systems_len(), 7);
    let mut dragging = crate::support::app_with(bevy_sinew::MouseDragPlugin);
    dragging.world_mut().spawn(RigidBox::default());
    tick(&mut dragging, 2);
    let substeps = dragging.world().resource::<Schedules>().get(SubstepSchedule).unwrap();
    assert_eq!(substeps.systems_len(), 7, "nor does the mouse add one");
}
