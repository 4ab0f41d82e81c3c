//! What collides with what by default, and the components that change it.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::ContactParticipant;
use bevy_sinew::{BodyContacts, ContactsDisabled, WorldCenterOfMass};
use bevy_sinew::{BodyParts, ContactShape, QueryFilter};

use crate::support::{app, hash, heard, particles_of, position, tick};

fn height(app: &App, entity: Entity) -> f32 {
    app.world().get::<Transform>(entity).unwrap().translation.y
}

fn crate_at(x: f32, y: f32) -> (RigidBox, Transform) {
    (RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(x, y, 0.0))
}

#[test]
fn components_spawned_with_a_recipe_are_not_overridden_by_it() {
    let mut app = app();
    let world = app.world_mut();
    let alone = BodyContacts { with_bodies: false, ..default() };
    let figure = world.spawn((Ragdoll::default(), alone)).id();
    let plain = world.spawn((Ragdoll::default(), Transform::from_xyz(9.0, 0.0, 0.0))).id();
    let own = (crate_at(3.0, 0.0), Collider::sphere(0.2), SurfaceMaterial::new(0.9));
    let own = world.spawn(own).id();
    tick(&mut app, 2);
    assert_eq!(*app.world().get::<BodyContacts>(figure).unwrap(), alone);
    assert_eq!(*app.world().get::<BodyContacts>(plain).unwrap(), BodyContacts::ALL);
    assert_eq!(*app.world().get::<Collider>(own).unwrap(), Collider::sphere(0.2));
    assert_eq!(app.world().get::<SurfaceMaterial>(own).unwrap().friction, 0.9);
    // Also when it is built anew.
    app.world_mut().get_mut::<Ragdoll>(figure).unwrap().height = 1.5;
    tick(&mut app, 2);
    assert_eq!(*app.world().get::<BodyContacts>(figure).unwrap(), alone);
}

#[test]
fn one_component_takes_a_body_a_ball_or_a_collider_out_of_all_contacts_and_back() {
    let mut app = app();
    let world = app.world_mut();
    let ground = world.spawn(Ground).id();
    let shelf = Transform::from_xyz(0.0, 0.9, 0.0);
    let shelf = (Collider::cuboid(Vec3::new(9.0, 0.2, 9.0)), shelf, ContactsDisabled);
    let shelf = world.spawn(shelf).id();
    let ghost = world.spawn((crate_at(0.0, 0.2), ContactsDisabled)).id();
    let ball = (Particle::at(Vec3::new(1.0, 0.3, 0.0)), Radius(0.1), ContactsDisabled);
    let ball = world.spawn(ball).id();
    let figure = (Ragdoll::default(), Transform::from_xyz(3.0, 1.0, 0.0), ContactsDisabled);
    let figure = world.spawn(figure).id();
    let body = world.spawn(crate_at(0.0, 1.6)).id();
    tick(&mut app, 120);
    assert!(height(&app, ghost) < -5.0 && position(&app, ball).y < -5.0);
    let pelvis = app.world().get::<WorldCenterOfMass>(figure).unwrap().position.y;
    assert!(pelvis < -5.0, "a whole figure: {pelvis}");
    assert!((height(&app, body) - 0.2).abs() < 0.01, "through the shelf and the ghost");
    let sinew = app.world().resource::<SinewWorld>();
    let down = Ray3d::new(Vec3::new(2.0, 3.0, 0.0), Dir3::NEG_Y);
    let hit = sinew.cast_ray(down, 10.0, &QueryFilter::default()).map(|hit| hit.entity);
    assert_ne!(hit, Some(shelf), "rays pass through it, too");
    let _ = ground;
    app.world_mut().entity_mut(shelf).remove::<ContactsDisabled>();
    let late = app.world_mut().spawn(crate_at(2.0, 1.6)).id();
    tick(&mut app, 90);
    assert!((height(&app, late) - 1.2).abs() < 0.01, "{}", height(&app, late));
    assert_eq!(heard(&app), []);
}

#[test]
fn layers_keep_bodies_apart_from_bodies_alone() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn(Ground);
    let low = world.spawn((crate_at(0.0, 0.2), CollisionLayers::of(&[1], &[0]))).id();
    let high = world.spawn((crate_at(0.0, 0.8), CollisionLayers::of(&[2], &[0]))).id();
    let met = world.spawn((crate_at(0.0, 1.4), CollisionLayers::of(&[0], &[0, 2]))).id();
    tick(&mut app, 120);
    for (body, y) in [(low, 0.2), (high, 0.2), (met, 0.6)] {
        assert!((height(&app, body) - y).abs() < 0.02, "{} instead of {y}", height(&app, body));
    }
}

#[test]
fn jointed_bodies_collide_only_after_the_joint_is_removed() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let world = app.world_mut();
    // They overlap by half.
    let (a, b) = (world.spawn(crate_at(0.0, 0.0)).id(), world.spawn(crate_at(0.2, 0.0)).id());
    tick(&mut app, 1);
    // Overlapping boxes are pushed apart; a joint that comes at once prevents it.
    let (p, q) = (particles_of(&app, a)[0], particles_of(&app, b)[0]);
    let rest = position(&app, p).distance(position(&app, q));
    let joint = app.world_mut().spawn(DistanceConstraint::new(p, q, rest)).id();
    app.world_mut().commands().entity(a).set_motion(Vec3::ZERO, Vec3::ZERO);
    app.world_mut().commands().entity(b).set_motion(Vec3::ZERO, Vec3::ZERO);
    let gap = |app: &App| {
        let at = |body| app.world().get::<Transform>(body).unwrap().translation;
        at(a).distance(at(b))
    };
    let joined = gap(&app);
    tick(&mut app, 30);
    assert!((gap(&app) - joined).abs() < 2e-3, "{} after {joined}", gap(&app));
    app.world_mut().despawn(joint);
    tick(&mut app, 120);
    assert!(gap(&app) > 0.38, "pushed apart: {}", gap(&app));
}

#[test]
fn a_weight_tied_to_a_rope_that_is_pinned_to_a_post_hangs_still() {
    let mut app = app();
    let world = app.world_mut();
    let post = (Collider::capsule(0.1, 1.0), Transform::from_xyz(0.0, 3.0, 0.0));
    let post = world.spawn(post).id();
    // The first particle is inside the post, on its axis.
    let rope = Rope { segments: 20, pin_start: false, ..Rope::between(Vec3::ZERO, Vec3::NEG_Y) };
    let rope = world.spawn((rope, Transform::from_xyz(0.0, 3.0, 0.0))).id();
    tick(&mut app, 1);
    let own = particles_of(&app, rope);
    app.world_mut().entity_mut(own[0]).insert(PinnedTo { entity: post, offset: Vec3::ZERO });
    let at = position(&app, own[20]);
    let weight = RigidBox::new(Vec3::splat(0.2)).with_mass(3.0);
    let at = Transform::from_translation(at - Vec3::Y * 0.05);
    let weight = app.world_mut().spawn((weight, at)).id();
    tick(&mut app, 1);
    let corner = particles_of(&app, weight)[0];
    app.world_mut().spawn(DistanceConstraint::new(own[20], corner, 0.1));
    tick(&mut app, 300);
    for &particle in &own {
        let at = position(&app, particle);
        assert!(at.xz().length() < 0.2, "it hangs straight: {at}");
    }
    assert!(height(&app, weight) < 2.1 && height(&app, weight) > 1.6, "{}", height(&app, weight));
}

#[test]
fn cloth_collides_with_itself_only_when_that_is_enabled() {
    let itself = |app: &App, body: usize| {
        app.world().resource::<SinewWorld>().simulation().contacts[body].with_itself
    };
    let mut app = app();
    app.world_mut().spawn(Cloth::grid(1.0, 1.0, 4, 4));
    app.world_mut().spawn((Cloth::grid(1.0, 1.0, 4, 4), BodyContacts::default().and_itself()));
    app.world_mut().spawn(Ragdoll::default());
    tick(&mut app, 1);
    assert_eq!([0, 1, 2].map(|body| itself(&app, body)), [false, true, true]);
}

#[test]
fn automatic_contact_shapes_let_nothing_through() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let world = app.world_mut();
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    world.spawn((RigidBox::default(), at(0.0)));
    let figure = world.spawn((Ragdoll::default(), at(3.0))).id();
    let fine = Cloth { radius: 0.06, ..Cloth::grid(1.0, 1.0, 8, 8) };
    let fine = world.spawn((fine, at(6.0))).id();
    let coarse = Cloth { radius: 0.01, ..Cloth::grid(1.0, 1.0, 8, 8) };
    let coarse = world.spawn((coarse, at(9.0))).id();
    let thin = world.spawn((Rope { radius: 0.01, ..default() }, at(12.0))).id();
    let thick = world.spawn((Rope { radius: 0.03, ..default() }, at(15.0))).id();
    let soft = world.spawn((SoftBody::cuboid(Vec3::ONE, UVec3::splat(3)), at(18.0))).id();
    tick(&mut app, 2);
    let parts = app.world().get::<BodyParts>(figure).unwrap().iter().count();
    let sinew = app.world().resource::<SinewWorld>();
    let simulation = sinew.simulation();
    // A cuboid for the box, shapes for the limbs, and a capsule for each segment of the thin rope.
    assert_eq!(simulation.body_colliders().len(), 1 + parts + 20);
    let number = |body: Entity| {
        (0..simulation.contacts.len())
            .find(|&i| sinew.entity_of(ContactParticipant::Body(i as u32)) == Some(body))
    };
    let by_triangles =
        |body: Entity| simulation.contacts[number(body).expect("it is listed")].surface;
    assert!(!by_triangles(fine) && by_triangles(coarse) && by_triangles(soft));
    assert!(!by_triangles(thin) && !by_triangles(thick));
    // A change is picked up, and an explicit choice overrides the automatic one.
    app.world_mut().get_mut::<Cloth>(coarse).unwrap().radius = 0.06;
    let particles = BodyContacts::default().shaped(ContactShape::Particles);
    app.world_mut().entity_mut(thin).insert(particles);
    tick(&mut app, 2);
    let sinew = app.world().resource::<SinewWorld>();
    assert_eq!(sinew.simulation().body_colliders().len(), 1 + parts);
    let number = |body: Entity| {
        (0..sinew.simulation().contacts.len())
            .find(|&i| sinew.entity_of(ContactParticipant::Body(i as u32)) == Some(body))
    };
    let surface = |body: Entity| sinew.simulation().contacts[number(body).unwrap()].surface;
    assert!(!surface(coarse) && surface(soft));
    assert_eq!(heard(&app), []);
}

#[test]
fn contacts_with_bodies_change_no_bit_where_no_body_is_near() {
    let run = |alone: bool| {
        let mut app = app();
        let world = app.world_mut();
        world.spawn(Ground);
        for i in 0..4 {
            let mut body = world.spawn(crate_at(3.0 * i as f32, 1.0));
            if alone {
                body.insert(BodyContacts { with_bodies: false, ..default() });
            }
        }
        tick(&mut app, 120);
        hash(&mut app)
    };
    assert_eq!(run(true), run(false));
}
