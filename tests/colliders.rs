//! Colliders hold what falls on them, carry it when they move, and let through what they should; bodies collide by their shape or by their particles.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::ContactParticipant;
use bevy_sinew::{BodyContacts, ParticleRow};
use bevy_sinew::{
    BodyParts, ColliderFault, ColliderMotion, Combine, ContactShape, ParticleBody, Refusal,
    RestPlace,
};

use crate::support::{app, assert_finite, heard, particles_of, position, tick, vertices};

/// A floor with its surface at y = 0.
fn floor() -> (Collider, Transform) {
    (Collider::cuboid(Vec3::new(10.0, 1.0, 10.0)), Transform::from_xyz(0.0, -0.5, 0.0))
}

/// A box of 0.4 m, whose centre is 0.2 m above the floor at rest.
fn crate_at(x: f32, y: f32) -> (RigidBox, Transform) {
    (RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(x, y, 0.0))
}

fn height(app: &App, entity: Entity) -> f32 {
    app.world().get::<Transform>(entity).unwrap().translation.y
}

/// Moves an entity at this velocity, m/s.
#[derive(Component, Clone, Copy)]
struct Drive(Vec3);

fn drive(app: &mut App) {
    app.add_systems(FixedUpdate, |mut driven: Query<(&Drive, &mut Transform)>, time: Res<Time>| {
        for (drive, mut transform) in &mut driven {
            transform.translation += drive.0 * time.delta_secs();
        }
    });
}

#[test]
fn a_ball_and_boxes_come_to_rest_on_a_box() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn(floor());
    let ball = world.spawn((Particle::at(Vec3::new(-2.0, 1.0, 0.0)), Radius(0.1))).id();
    let corners = BodyContacts::default().shaped(ContactShape::Particles);
    let by_corners = world.spawn((crate_at(0.0, 1.0), corners)).id();
    let by_shape = world.spawn(crate_at(2.0, 1.0)).id();
    tick(&mut app, 180);
    assert!((position(&app, ball).y - 0.1).abs() < 2e-3, "{}", position(&app, ball));
    for body in [by_corners, by_shape] {
        assert!((height(&app, body) - 0.2).abs() < 5e-3, "{}", height(&app, body));
        let speed = app.world().get::<LinearVelocity>(body).unwrap().0.length();
        assert!(speed < 0.02, "it lies still: {speed}");
    }
    assert_eq!(heard(&app), []);
}

#[test]
fn every_shape_holds_a_ball_at_its_height() {
    // Each with the height of its top above its centre.
    let octahedron: Vec<Vec3> =
        [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|v| [v * 0.5, v * -0.5]).collect();
    let hill =
        Collider::height_field(3, 3, &[0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0], Vec3::ONE);
    let shapes = [
        (Collider::plane(), 0.0),
        (Collider::sphere(0.5), 0.5),
        (Collider::capsule(0.2, 0.6), 0.5),
        (Collider::cuboid(Vec3::ONE), 0.5),
        (Collider::cylinder(0.3, 1.0), 0.5),
        (Collider::hull(&octahedron).unwrap(), 0.5),
        (hill.unwrap(), 0.5),
        (Collider::from_mesh(&Cuboid::new(1.0, 1.0, 1.0).into()).unwrap(), 0.5),
        (Collider::hull_from_mesh(&Cuboid::new(1.0, 1.0, 1.0).into()).unwrap(), 0.5),
    ];
    let mut app = app();
    let mut balls = Vec::new();
    for (i, (shape, top)) in shapes.into_iter().enumerate() {
        // Scaled where the shape allows it in height alone, far enough apart, and under a parent that is not at the origin.
        let x = 1e3 * i as f32;
        let scale = if matches!(shape, Collider::Sphere { .. } | Collider::Capsule { .. }) {
            Vec3::splat(2.0)
        } else {
            Vec3::new(1.0, 2.0, 1.0)
        };
        let parent = app.world_mut().spawn(Transform::from_xyz(x, 10.0, 0.0)).id();
        let own = Transform::from_xyz(0.0, -10.0, 0.0).with_scale(scale);
        // Each shape has a layer of its own with its ball, because the plane is endless.
        let layers = CollisionLayers::of(&[i as u32], &[i as u32]);
        app.world_mut().spawn((shape, own, layers, ChildOf(parent)));
        let at = Particle::at(Vec3::new(x, 2.0, 0.0));
        balls.push((app.world_mut().spawn((at, Radius(0.1), layers)).id(), 2.0 * top + 0.1));
    }
    for _ in 0..40 {
        tick(&mut app, 1);
        for &(ball, least) in &balls {
            // On a round shape the ball may roll off, but not before it has touched it.
            let at = position(&app, ball);
            let within = (at.x - (at.x / 1e3).round() * 1e3).abs() < 1e-3 && at.z.abs() < 1e-3;
            assert!(!within || at.y > least - 3e-3, "{ball}: {at} under {least}");
        }
    }
    let held = balls.iter().filter(|(ball, least)| (position(&app, *ball).y - least).abs() < 0.02);
    assert_eq!(held.count(), balls.len(), "{:?}", balls.map_positions(&app));
    assert_eq!(heard(&app), []);
}

trait Positions {
    fn map_positions(&self, app: &App) -> Vec<Vec3>;
}

impl Positions for Vec<(Entity, f32)> {
    fn map_positions(&self, app: &App) -> Vec<Vec3> {
        self.iter().map(|(ball, _)| position(app, *ball)).collect()
    }
}

#[test]
fn a_lift_and_a_conveyor_carry_a_crate_that_lies_on_them() {
    for by_shape in [false, true] {
        let mut app = app();
        drive(&mut app);
        let lift = app.world_mut().spawn(floor()).id();
        let body = app.world_mut().spawn(crate_at(0.0, 0.25)).id();
        if !by_shape {
            let corners = BodyContacts::default().shaped(ContactShape::Particles);
            app.world_mut().entity_mut(body).insert(corners);
        }
        tick(&mut app, 60);
        app.world_mut().entity_mut(lift).insert(Drive(Vec3::Y));
        tick(&mut app, 60);
        let above = height(&app, body) - height(&app, lift);
        assert!((above - 0.7).abs() < 0.01, "{above} above the middle of the lift");
        app.world_mut().entity_mut(lift).insert(Drive(Vec3::X));
        tick(&mut app, 120);
        let place = app.world().get::<Transform>(body).unwrap().translation;
        // The crate flew up a little when the lift stopped, and slid until it was as fast as the lift.
        assert!((1.7..2.05).contains(&place.x), "carried along, by shape: {by_shape}: {place}");
        let speed = app.world().get::<LinearVelocity>(body).unwrap().0;
        assert!((speed - Vec3::X).length() < 0.05, "as fast as the conveyor: {speed}");
        assert_eq!(heard(&app), []);
    }
}

#[test]
fn a_collider_that_jumps_carries_nothing_along() {
    let run = |jumps: bool| {
        let mut app = app();
        let lift = app.world_mut().spawn((floor(), SurfaceMaterial::new(1.0))).id();
        let ball = app.world_mut().spawn((Particle::at(Vec3::Y * 0.1), Radius(0.1))).id();
        tick(&mut app, 30);
        app.world_mut().get_mut::<Transform>(lift).unwrap().translation.x += 0.5;
        if jumps {
            app.world_mut().entity_mut(lift).remove::<ColliderMotion>();
        }
        tick(&mut app, 1);
        assert!(
            app.world().get::<ColliderMotion>(lift).unwrap().0.is_some(),
            "its pose is kept again"
        );
        position(&app, ball).x
    };
    // Friction of one tick: at most μ g dt², 2 mm.
    assert!(run(false) > 5e-4, "moved, it carries along: {}", run(false));
    assert_eq!(run(true), 0.0);
}

#[test]
fn layers_and_sensors_let_through() {
    let mut app = app();
    let world = app.world_mut();
    let (floor, at) = floor();
    world.spawn((floor, at, CollisionLayers::of(&[3], &[0, 1])));
    let sieve = Transform::from_xyz(0.0, 1.0, 0.0);
    let sieve = world.spawn((Collider::cuboid(Vec3::new(10.0, 0.2, 10.0)), sieve, Sensor)).id();
    let ball = |x: f32| (Particle::at(Vec3::new(x, 2.0, 0.0)), Radius(0.1));
    let held = world.spawn(ball(-3.0)).id();
    let held_by_layer = world.spawn((ball(-2.0), CollisionLayers::of(&[1], &[3]))).id();
    let of_other_layer = world.spawn((ball(-1.0), CollisionLayers::of(&[2], &[3]))).id();
    let blind = world.spawn((ball(1.0), CollisionLayers::of(&[1], &[2]))).id();
    let nothing = world.spawn((crate_at(3.0, 2.0), CollisionLayers::NONE)).id();
    let boxed = world.spawn((crate_at(2.0, 2.0), CollisionLayers::of(&[1], &[3]))).id();
    tick(&mut app, 120);
    for ball in [held, held_by_layer] {
        assert!((position(&app, ball).y - 0.1).abs() < 5e-3, "{}", position(&app, ball));
    }
    for ball in [of_other_layer, blind] {
        assert!(position(&app, ball).y < -5.0, "{}", position(&app, ball));
    }
    assert!(height(&app, nothing) < -5.0 && (height(&app, boxed) - 0.2).abs() < 0.01);
    // No longer a sensor: a ball that falls on it now is held.
    app.world_mut().entity_mut(sieve).remove::<Sensor>();
    let late = app.world_mut().spawn(ball(0.0)).id();
    tick(&mut app, 90);
    assert!((position(&app, late).y - 1.2).abs() < 5e-3, "{}", position(&app, late));
}

#[test]
fn ice_is_slippery_and_rubber_bounces() {
    let mut app = app();
    let world = app.world_mut();
    let tilt = Quat::from_rotation_z(0.2);
    let slope = |z: f32| {
        let at = Transform::from_xyz(0.0, 0.0, z).with_rotation(tilt);
        (Collider::cuboid(Vec3::new(10.0, 1.0, 1.0)), at)
    };
    let ice = SurfaceMaterial::new(0.0).with_rules(Combine::Min, Combine::Average);
    world.spawn((slope(0.0), ice));
    world.spawn(slope(2.0));
    let up = tilt * Vec3::Y * 0.6;
    let ball = |z: f32| (Particle::at(up + Vec3::Z * z), Radius(0.1));
    let (slides, stays) = (world.spawn(ball(0.0)).id(), world.spawn(ball(2.0)).id());
    let rubber = SurfaceMaterial::default().with_restitution(1.0);
    let rubber = rubber.with_rules(Combine::Average, Combine::Max);
    world.spawn((Collider::plane(), rubber, Transform::from_xyz(0.0, -5.0, 0.0)));
    let drop = Particle::at(Vec3::new(20.0, -3.9, 0.0));
    let bounces = world.spawn((drop, Radius(0.1))).id();
    tick(&mut app, 27);
    assert!((position(&app, bounces).y + 4.9).abs() < 0.03, "{}", position(&app, bounces));
    tick(&mut app, 27);
    assert!(position(&app, bounces).y > -4.05, "{}", position(&app, bounces));
    tick(&mut app, 6);
    // s = ½ g sin α t², along the slope.
    let slid = (position(&app, slides) - up).length();
    let expected = 0.5 * 9.81 * 0.2_f32.sin();
    assert!((slid / expected - 1.0).abs() < 0.05, "{slid} instead of {expected}");
    let stuck = (position(&app, stays) - up - Vec3::Z * 2.0).length();
    assert!(stuck < 0.01, "{stuck}");
}

#[test]
fn a_heightfield_and_a_mesh_hold_a_cloth() {
    let heights: Vec<f32> = (0..81)
        .map(|i| ((i % 9) as f32 * 0.7).sin() * 0.1 + ((i / 9) as f32 * 0.5).cos() * 0.1)
        .collect();
    let hills = Collider::height_field(9, 9, &heights, Vec3::new(3.0, 1.0, 3.0)).unwrap();
    let ball = Collider::from_mesh(&Sphere::new(0.4).mesh().ico(4).unwrap()).unwrap();
    for (ground, lowest) in [(hills, -0.25), (ball, -0.65)] {
        let mut app = app();
        app.world_mut().spawn(ground);
        let flat = Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let cloth = Cloth { radius: 0.02, ..Cloth::grid(1.0, 1.0, 16, 16) };
        let at = Transform::from_xyz(0.0, 0.7, 0.0).with_rotation(flat);
        let cloth = app.world_mut().spawn((cloth, at)).id();
        tick(&mut app, 120);
        for particle in particles_of(&app, cloth) {
            let at = position(&app, particle);
            assert!(at.y > lowest, "it fell through: {at}");
        }
        assert_eq!(heard(&app), []);
        assert_finite(&mut app);
    }
}

#[test]
fn bodies_collide_unless_contacts_with_bodies_are_off() {
    let run = |contacts: Option<BodyContacts>| {
        let mut app = app();
        app.world_mut().spawn(floor());
        let low = app.world_mut().spawn(crate_at(0.0, 0.3)).id();
        let high = app.world_mut().spawn(crate_at(0.05, 0.9)).id();
        let ball = (Particle::at(Vec3::new(0.0, 2.0, 0.0)), Radius(0.1), Mass(0.1));
        let ball = app.world_mut().spawn(ball).id();
        if let Some(contacts) = contacts {
            for entity in [low, high, ball] {
                app.world_mut().entity_mut(entity).insert(contacts);
            }
        }
        tick(&mut app, 150);
        assert_eq!(heard(&app), []);
        [height(&app, low), height(&app, high), position(&app, ball).y]
    };
    let near = |found: [f32; 3], expected: [f32; 3]| {
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.02)
    };
    let alone = BodyContacts { with_bodies: false, ..default() };
    let (with, without) = (run(None), run(Some(alone)));
    assert!(near(with, [0.2, 0.6, 0.9]), "a tower: {with:?}");
    assert_eq!(with, run(Some(BodyContacts::default())), "the default, given explicitly");
    assert!(near(without, [0.2, 0.2, 0.1]), "overlapping: {without:?}");
}

#[test]
fn rigid_parts_have_the_shape_of_their_recipe_unless_the_game_gives_another() {
    let mut app = app();
    let world = app.world_mut();
    let boxed = world.spawn(crate_at(0.0, 1.0)).id();
    let own = world.spawn((crate_at(2.0, 1.0), Collider::sphere(0.2))).id();
    let points = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let solid = RigidMesh::default().shaped(RigidShape::Points(points.clone()));
    let solid = world.spawn((solid, Transform::from_xyz(4.0, 1.0, 0.0))).id();
    let doll = world.spawn((Ragdoll::default(), Transform::from_xyz(6.0, 1.0, 0.0))).id();
    tick(&mut app, 2);
    let shape = |app: &App, entity| app.world().get::<Collider>(entity).cloned();
    assert_eq!(shape(&app, boxed), Some(Collider::cuboid(Vec3::splat(0.4))));
    assert_eq!(shape(&app, own), Some(Collider::sphere(0.2)));
    assert_eq!(shape(&app, solid), Some(Collider::hull(&points).unwrap()));
    let parts: Vec<Entity> = app.world().get::<BodyParts>(doll).unwrap().iter().collect();
    let limbs =
        parts.iter().filter(|&&part| matches!(shape(&app, part), Some(Collider::Capsule { .. })));
    assert_eq!(limbs.count(), 8);
    // A rebuilt body has its new shape; a collider that the game gave stays.
    for body in [boxed, own] {
        app.world_mut().get_mut::<RigidBox>(body).unwrap().size = Vec3::ONE;
    }
    tick(&mut app, 1);
    assert_eq!(shape(&app, boxed), Some(Collider::cuboid(Vec3::ONE)));
    assert_eq!(shape(&app, own), Some(Collider::sphere(0.2)));
    let body_colliders =
        |app: &App| app.world().resource::<SinewWorld>().simulation().body_colliders().len();
    assert_eq!(body_colliders(&app), 3 + parts.len());
    // A body that collides by its particles has no collider, and a despawned body takes its colliders with it.
    let corners = BodyContacts::default().shaped(ContactShape::Particles);
    app.world_mut().entity_mut(boxed).insert(corners);
    app.world_mut().despawn(doll);
    tick(&mut app, 1);
    assert_eq!(body_colliders(&app), 2);
    app.world_mut().entity_mut(boxed).remove::<BodyContacts>();
    tick(&mut app, 1);
    assert_eq!(body_colliders(&app), 3);
    assert_eq!(heard(&app), []);
}

#[test]
fn a_cloth_with_a_solid_contact_shape_is_refused_once() {
    let mut app = app();
    let solid = BodyContacts::default().shaped(ContactShape::Solid);
    let cloth = app.world_mut().spawn((Cloth::grid(1.0, 1.0, 4, 4), solid)).id();
    let late = app.world_mut().spawn((ParticleBody, solid)).id();
    tick(&mut app, 5);
    assert_eq!(
        heard(&app),
        [(cloth, Refusal::NotSolid)],
        "a body that is not built yet is not refused: {late}"
    );
}

#[test]
fn particles_of_a_body_have_rest_places_and_contact_participants_have_entities() {
    let mut app = app();
    let world = app.world_mut();
    let ground = world.spawn(Ground).id();
    let room = world.spawn(BoundingBox::default()).id();
    let broken = world.spawn((Collider::sphere(f32::NAN), Transform::default())).id();
    let collider = world.spawn((Collider::sphere(0.1), Transform::from_xyz(0.0, -9.0, 0.0))).id();
    let far = Transform::from_xyz(7.0, 3.0, 0.0).with_rotation(Quat::from_rotation_z(1.0));
    let cloth = world.spawn((Cloth::grid(1.0, 1.0, 2, 2), far, BodyContacts::ALL)).id();
    let ball = world.spawn((Particle::at(Vec3::Y), Radius(0.1), BodyContacts::default())).id();
    let plain = world.spawn(Particle::at(Vec3::Y * 2.0)).id();
    tick(&mut app, 2);
    let places = particles_of(&app, cloth);
    let place = |i: usize| app.world().get::<RestPlace>(places[i]).unwrap().0;
    assert!((place(0).distance(place(1)) - 0.5).abs() < 1e-6);
    assert!(place(0).length() < 0.8, "in its own frame: {}", place(0));
    let sinew = app.world().resource::<SinewWorld>();
    assert_eq!(sinew.entity_of(ContactParticipant::Collider(0)), Some(ground));
    assert_eq!(sinew.entity_of(ContactParticipant::Collider(1)), Some(room));
    assert_eq!(
        sinew.entity_of(ContactParticipant::Collider(2)),
        Some(collider),
        "{broken} has no index"
    );
    assert_eq!(sinew.entity_of(ContactParticipant::Collider(3)), None);
    assert_eq!(sinew.entity_of(ContactParticipant::Body(0)), Some(cloth));
    assert_eq!(sinew.entity_of(ContactParticipant::Body(1)), Some(ball));
    let row = app.world().get::<ParticleRow>(plain).unwrap().get().unwrap();
    assert_eq!(sinew.entity_of(ContactParticipant::Particle(row as u32)), Some(plain));
    let contacts = &sinew.simulation().contacts;
    assert!(contacts[0].with_itself && contacts[0].with_bodies && !contacts[1].with_itself);
}

#[test]
fn a_box_with_an_unsuitable_collider_is_refused_once_and_collides_by_its_particles() {
    let mut app = app();
    app.world_mut().spawn(floor());
    for (collider, refusals) in [(Collider::plane(), 1), (Collider::sphere(f32::NAN), 1)] {
        let body = (crate_at(0.0, 0.5), collider, BodyContacts::default());
        let body = app.world_mut().spawn(body).id();
        tick(&mut app, 60);
        assert!((height(&app, body) - 0.2).abs() < 5e-3, "{}", height(&app, body));
        let reported = heard(&app);
        assert_eq!(
            reported.iter().filter(|(entity, _)| *entity == body).count(),
            refusals,
            "{reported:?}"
        );
        app.world_mut().despawn(body);
    }
    assert_eq!(heard(&app).len(), 2);
}

/// A square of 1 m in the plane y = 0.
fn four_corners(topology: PrimitiveTopology, indices: Option<Indices>) -> Mesh {
    let positions = vec![[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let mut mesh = Mesh::new(topology, RenderAssetUsages::default());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    if let Some(indices) = indices {
        mesh.insert_indices(indices);
    }
    mesh
}

#[test]
fn lists_and_strips_of_a_mesh_have_their_triangles_all_facing_one_way() {
    let [list, strip] = [PrimitiveTopology::TriangleList, PrimitiveTopology::TriangleStrip];
    let corners = four_corners(list, None);
    let positions: Vec<Vec3> = vertices(&corners);
    let of = |triangles: &[[u32; 3]]| Collider::mesh(positions.clone(), triangles.to_vec());
    let expected = of(&[[0, 2, 1], [1, 2, 3]]);
    assert!(expected.is_ok());
    assert_ne!(expected, of(&[[0, 2, 1], [1, 3, 2]]), "a triangle turned round is another mesh");
    let listed = four_corners(list, Some(Indices::U16(vec![0, 2, 1, 1, 2, 3])));
    assert_eq!(Collider::from_mesh(&listed), expected);
    let stripped = four_corners(strip, Some(Indices::U32(vec![0, 2, 1, 3, 3])));
    assert_eq!(Collider::from_mesh(&stripped), expected);
    let bare = four_corners(strip, None);
    assert_eq!(Collider::from_mesh(&bare), of(&[[0, 1, 2], [2, 1, 3]]));
}

#[test]
fn a_mesh_that_has_no_triangles_is_refused() {
    for unreadable in [
        four_corners(PrimitiveTopology::LineList, None),
        four_corners(PrimitiveTopology::TriangleList, Some(Indices::U16(vec![0, 1]))),
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default()),
    ] {
        assert_eq!(Collider::from_mesh(&unreadable), Err(ColliderFault::UnreadableMesh));
    }
    let missing = four_corners(PrimitiveTopology::TriangleList, Some(Indices::U16(vec![0, 1, 9])));
    assert!(matches!(Collider::from_mesh(&missing), Err(ColliderFault::Shape(_))));
}
