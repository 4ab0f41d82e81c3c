//! Attachments to a bone, a rope's end, a vertex or a corner: built, kept, built anew and released.

use bevy::ecs::relationship::RelationshipTarget;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    AnchorConstraint, Articulated, AttachFault, Attached, AttachmentJoints, AttachmentOf,
    BodyAttachments, BodyConstraints, BodyParticles, BodyParts, Bone, BuiltBody, Refusal, RopeEnd,
    SinewClock,
};

use crate::support::{app, assert_finite, forget, heard, particles_of, position, tick};

/// The bodies that were built, in order: the body, whether it was built anew, and the tick.
#[derive(Resource, Default)]
struct Built(Vec<(Entity, bool, u64)>);

fn listen(app: &mut App) {
    app.init_resource::<Built>();
    app.add_observer(|built: On<BodyBuilt>, mut all: ResMut<Built>, clock: Res<SinewClock>| {
        all.0.push((built.entity, built.again, clock.tick));
    });
}

fn built(app: &mut App) -> Vec<(Entity, bool, u64)> {
    core::mem::take(&mut app.world_mut().resource_mut::<Built>().0)
}

fn transform(app: &App, entity: Entity) -> Transform {
    *app.world().get::<Transform>(entity).unwrap()
}

/// Position of a rope's last particle.
fn end_of(app: &App, rope: Entity) -> Vec3 {
    position(app, *particles_of(app, rope).last().unwrap())
}

fn momentum(app: &mut App) -> Vec3 {
    let world = app.world_mut();
    let mut all = world.query::<(&Particle, &Mass)>();
    all.iter(world).map(|(particle, mass)| particle.velocity * mass.0).sum()
}

fn place_in(app: &App, body: Entity, local: Vec3) -> Vec3 {
    transform(app, body).transform_point(local)
}

#[test]
fn every_recipe_triggers_an_event_when_it_is_built_or_rebuilt_in_the_order_of_creation() {
    let mut app = app();
    listen(&mut app);
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    let world = app.world_mut();
    let limb = Articulated::new([Bone::new("post", Vec3::Y, Vec3::ZERO)]);
    let shape = RigidShape::Points(vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]);
    let bodies = vec![
        world.spawn((limb, at(0.0))).id(),
        world.spawn((SoftBody::cuboid(Vec3::ONE, UVec3::splat(2)), at(3.0))).id(),
        world.spawn((RigidMesh::mass(1.0).shaped(shape), at(6.0))).id(),
        world.spawn((Ragdoll::default(), at(9.0))).id(),
        world.spawn((Cloth::grid(1.0, 1.0, 3, 3), at(12.0))).id(),
        world.spawn((Rope::default(), at(15.0))).id(),
        world.spawn((RigidBox::default(), at(18.0))).id(),
    ];
    tick(&mut app, 1);
    let first: Vec<_> = bodies.iter().map(|&body| (body, false, 0)).collect();
    assert_eq!(built(&mut app), first);
    for &body in &bodies {
        assert_eq!(app.world().get::<BuiltBody>(body), Some(&BuiltBody { builds: 1 }));
        assert!(!particles_of(&app, body).is_empty());
    }
    tick(&mut app, 3);
    assert_eq!(built(&mut app), []);
    app.world_mut().get_mut::<Rope>(bodies[5]).unwrap().segments = 7;
    app.world_mut().get_mut::<Ragdoll>(bodies[3]).unwrap().height = 1.5;
    tick(&mut app, 1);
    assert_eq!(built(&mut app), [(bodies[3], true, 4), (bodies[5], true, 4)]);
    assert_eq!(app.world().get::<BuiltBody>(bodies[5]), Some(&BuiltBody { builds: 2 }));
    // A body that cannot be built has no `BuiltBody` and triggers no `BodyBuilt`.
    app.world_mut().get_mut::<Rope>(bodies[5]).unwrap().segments = 0;
    tick(&mut app, 1);
    assert_eq!(built(&mut app), []);
    assert_eq!(app.world().get::<BuiltBody>(bodies[5]), None);
}

#[test]
fn a_pin_added_by_an_observer_of_a_new_body_holds_from_the_first_tick_on() {
    let mut app = app();
    let world = app.world_mut();
    let rope = world.spawn(Rope { pin_start: false, ..default() }).id();
    world.entity_mut(rope).observe(
        |built: On<BodyBuilt>, ropes: Query<&BodyParticles>, mut commands: Commands| {
            let first = ropes.get(built.entity).unwrap().iter().next().unwrap();
            commands.entity(first).insert(Pinned::HERE);
        },
    );
    tick(&mut app, 60);
    assert_eq!(position(&app, particles_of(&app, rope)[0]), Vec3::ZERO);
    assert!(end_of(&app, rope).y > -1.02, "it hangs: {}", end_of(&app, rope));
}

#[test]
fn a_body_spawned_in_a_pause_is_built_and_triggers_its_event() {
    let mut app = app();
    listen(&mut app);
    app.world_mut().resource_mut::<SinewControl>().paused = true;
    let body = app.world_mut().spawn(RigidBox::default()).id();
    tick(&mut app, 3);
    assert_eq!(built(&mut app), [(body, false, 0)]);
}

#[test]
fn a_cape_follows_a_moving_and_turning_parent_from_the_frame_in_which_both_are_spawned() {
    let mut app = app();
    let world = app.world_mut();
    let hero = world.spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id();
    let edge = Anchor::InBox { center: Vec3::Y * 0.5, half_size: Vec3::new(1.0, 0.01, 0.1) };
    let cape = world
        .spawn((
            Cloth::grid(0.6, 1.0, 6, 10),
            AttachTo::new(hero).part(edge),
            Transform::from_xyz(0.0, 1.9, -0.2),
        ))
        .id();
    tick(&mut app, 1);
    let edge: Vec<Entity> = app.world().get::<Attached>(cape).unwrap().pinned.clone();
    assert_eq!(edge.len(), 7, "the upper edge has six cells");
    let local = |app: &App| -> Vec<Vec3> {
        let back = transform(app, hero).compute_affine().inverse();
        edge.iter().map(|&p| back.transform_point3(position(app, p))).collect()
    };
    let before = local(&app);
    assert!((before[0].y - 1.4).abs() < 1e-5, "{before:?}");
    for i in 0..60 {
        let turn = Quat::from_rotation_y(0.02 * i as f32);
        *app.world_mut().get_mut::<Transform>(hero).unwrap() =
            Transform::from_xyz(0.03 * i as f32, 1.0, 0.0).with_rotation(turn);
        tick(&mut app, 1);
        for (now, then) in local(&app).iter().zip(&before) {
            assert!(now.abs_diff_eq(*then, 1e-4), "tick {i}: {now} {then}");
        }
    }
    let lowest = particles_of(&app, cape).iter().map(|&p| position(&app, p).y).reduce(f32::min);
    assert!(lowest.unwrap() > 1.0, "the cape hangs without stretching: {lowest:?}");
    assert_eq!(heard(&app), []);
}

#[test]
fn a_rope_between_two_boxes_keeps_both_momenta_and_pulls_both() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    let world = app.world_mut();
    let one = world.spawn((RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(-1.0, 0.0, 0.0)));
    let one = one.id();
    let other = (RigidBox::new(Vec3::splat(0.4)).with_mass(3.0), LinearVelocity(Vec3::X * 2.0));
    let other = world.spawn((other, Transform::from_xyz(1.0, 0.0, 0.0))).id();
    let from = (one, Anchor::Corner(Vec3::new(1.0, 1.0, 0.0)));
    let rope = world.spawn(Rope::between(from, (other, Vec3::new(-0.2, 0.05, 0.0)))).id();
    tick(&mut app, 1);
    let before = momentum(&mut app);
    assert!((before.x - 6.0).abs() < 1e-3, "{before}");
    tick(&mut app, 300);
    let after = momentum(&mut app);
    assert!(after.abs_diff_eq(before, 2e-3), "{before} {after}");
    // The rope's ends are at their anchors, and the first box has been pulled along.
    let start = position(&app, particles_of(&app, rope)[0]);
    let corner = place_in(&app, one, Vec3::new(0.2, 0.2, 0.0));
    assert!(start.distance(corner) < 5e-3, "{start} {corner}");
    let end = place_in(&app, other, Vec3::new(-0.2, 0.05, 0.0));
    assert!(end_of(&app, rope).distance(end) < 5e-3, "{} {end}", end_of(&app, rope));
    assert!(transform(&app, one).translation.x > 2.0, "{:?}", transform(&app, one));
    assert_eq!(heard(&app), []);
}

#[test]
fn a_lamp_swings_at_a_corner_and_at_a_point_outside_it_as_a_rigid_pendulum() {
    for (part, arm) in
        [(Anchor::Corner(Vec3::Y), 0.1_f32), (Anchor::Point(Vec3::new(0.0, 0.5, 0.0)), 0.5)]
    {
        let mut app = app();
        app.insert_resource(AirDrag(0.0));
        let world = app.world_mut();
        let hook = world.spawn(Transform::from_xyz(0.0, 3.0, 0.0)).id();
        let tilt = Quat::from_rotation_z(0.1);
        let at = Transform::from_translation(Vec3::Y * 3.0 - tilt * Vec3::Y * arm);
        let lamp = world
            .spawn((RigidBox::new(Vec3::splat(0.2)), AttachTo::new(hook).part(part)))
            .insert(at.with_rotation(tilt))
            .id();
        let mut crossings = Vec::new();
        let mut last = 1.0;
        for i in 1..360 {
            tick(&mut app, 1);
            let at = transform(&app, lamp);
            let held = at.transform_point(Vec3::Y * arm);
            assert!(held.distance(Vec3::Y * 3.0) < 2e-3, "{i}: {held}");
            if last * at.translation.x < 0.0 {
                crossings.push(i as f32 / 60.0);
            }
            last = at.translation.x;
        }
        // A physical pendulum of corner particles: I = 8 · m/8 · (0.1² + 0.1²) about the centre, T = 2π √((I + m l²)/(m g l)).
        let period = core::f32::consts::TAU * ((0.02 + arm * arm) / (9.81 * arm)).sqrt();
        let (first, last) = (crossings[0], crossings[crossings.len() - 1]);
        let found = 2.0 * (last - first) / (crossings.len() - 1) as f32;
        assert!((found / period - 1.0).abs() < 0.03, "arm {arm}: {found} s, not {period}");
    }
}

#[test]
fn a_rope_is_tied_to_a_bone_a_vertex_of_cloth_and_a_region_of_a_soft_body_as_they_are_spawned() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let world = app.world_mut();
    // The ropes come first, so they wait until the bodies at their other ends are built.
    let later: Vec<Entity> = (0..3).map(|_| world.spawn_empty().id()).collect();
    let [doll, cloth, soft] = later[..] else { unreachable!() };
    let skull = Anchor::Bone { name: "head".into(), point: Vec3::new(0.0, 0.1, 0.0) };
    let patch = Anchor::InSphere { center: Vec3::Y * 0.5, radius: 0.3 };
    let ropes = [
        world.spawn(Rope::between(Vec3::new(0.0, 3.0, 0.0), (doll, skull))).id(),
        world.spawn(Rope::between(Vec3::new(4.0, 3.0, 0.0), (cloth, Anchor::Vertex(0)))).id(),
        world.spawn(Rope::between(Vec3::new(8.0, 3.0, 0.0), (soft, patch))).id(),
    ];
    world.entity_mut(doll).insert(Ragdoll::default());
    world
        .entity_mut(cloth)
        .insert((Cloth::grid(1.0, 1.0, 4, 4), Transform::from_xyz(4.0, 0.0, 0.0)));
    world
        .entity_mut(soft)
        .insert((SoftBody::cuboid(Vec3::ONE, UVec3::splat(4)), Transform::from_xyz(8.0, 0.0, 0.0)));
    tick(&mut app, 2);
    let head = {
        let world = app.world();
        let parts = world.get::<BodyParts>(doll).unwrap().iter();
        parts.into_iter().find(|&p| world.get::<Name>(p).unwrap().as_str() == "head").unwrap()
    };
    for _ in 0..2 {
        let at = place_in(&app, head, Vec3::new(0.0, 0.1, 0.0));
        assert!(end_of(&app, ropes[0]).distance(at) < 2e-3, "{} {at}", end_of(&app, ropes[0]));
        let corner = particles_of(&app, cloth)[0];
        assert!(end_of(&app, ropes[1]).distance(position(&app, corner)) < 2e-3);
        let far = end_of(&app, ropes[2]).distance(Vec3::new(8.0, 0.5, 0.0));
        assert!(far < 0.05, "the middle of the patch: {far}");
        tick(&mut app, 60);
    }
    assert_eq!(heard(&app), []);
}

#[test]
fn an_attachment_holds_again_when_either_side_is_rebuilt() {
    let mut app = app();
    let world = app.world_mut();
    let hand = world.spawn(Transform::from_xyz(0.0, 4.0, 0.0)).id();
    let body = world.spawn((RigidBox::new(Vec3::splat(0.4)), Transform::from_xyz(1.0, 4.0, 0.0)));
    let body = body.id();
    let rope = world.spawn(Rope::between((hand, Vec3::X * 0.1), (body, Vec3::ZERO))).id();
    tick(&mut app, 30);
    let joined = |app: &App| {
        let start = position(app, particles_of(app, rope)[0]);
        let middle = transform(app, body).translation;
        (start.distance(Vec3::new(0.1, 4.0, 0.0)), end_of(app, rope).distance(middle))
    };
    let close = |(a, b): (f32, f32)| a < 2e-3 && b < 0.02;
    assert!(close(joined(&app)), "{:?}", joined(&app));
    app.world_mut().get_mut::<Rope>(rope).unwrap().segments = 9;
    tick(&mut app, 30);
    assert_eq!(particles_of(&app, rope).len(), 10);
    assert!(close(joined(&app)), "a rope built anew: {:?}", joined(&app));
    app.world_mut().get_mut::<RigidBox>(body).unwrap().size = Vec3::splat(0.2);
    tick(&mut app, 60);
    assert!(close(joined(&app)), "a box built anew: {:?}", joined(&app));
    assert_eq!(heard(&app), []);
    // A region whose particles differ after a rebuild stays where it was.
    let world = app.world_mut();
    let edge = Anchor::InBox { center: Vec3::Y * 0.5, half_size: Vec3::new(1.0, 0.01, 0.1) };
    let flag = (Cloth::grid(1.0, 1.0, 4, 4), AttachTo::new(hand).part(edge));
    let flag = world.spawn((flag, Transform::from_xyz(3.0, 3.0, 0.0))).id();
    tick(&mut app, 10);
    app.world_mut().get_mut::<Transform>(hand).unwrap().translation.y += 1.0;
    tick(&mut app, 10);
    app.world_mut().get_mut::<Cloth>(flag).unwrap().shape = Cloth::grid(1.0, 1.0, 8, 8).shape;
    tick(&mut app, 10);
    let pinned = app.world().get::<Attached>(flag).unwrap().pinned.clone();
    assert_eq!(pinned.len(), 9);
    let middle = pinned.iter().map(|&p| position(&app, p)).sum::<Vec3>() / 9.0;
    assert!(middle.abs_diff_eq(Vec3::new(3.0, 4.5, 0.0), 1e-3), "{middle}");
}

/// The recipe took the first snapped attachment of an end for its own: that of the game was overwritten as soon as the rope was built. And it left the
/// attachment of a tie that was removed.
#[test]
fn a_rope_updates_and_removes_the_attachments_of_its_ties_and_leaves_those_of_the_game() {
    let mut app = app();
    let world = app.world_mut();
    let hooks = [0.0, 1.0, 2.0].map(|x| world.spawn(Transform::from_xyz(x, 4.0, 0.0)).id());
    let rope = world.spawn(Rope::between(hooks[0], hooks[1])).id();
    let end = AttachTo::new(hooks[2]).part(Anchor::RopeEnd(RopeEnd::Last)).snapped();
    let by_game = end.with_compliance(0.1);
    let own = world.spawn((by_game.clone(), AttachmentOf(rope))).id();
    let targets = |app: &App| {
        let all = app.world().get::<BodyAttachments>(rope).unwrap().iter();
        all.map(|one| app.world().get::<AttachTo>(one).unwrap().entity).collect::<Vec<_>>()
    };
    tick(&mut app, 10);
    for segments in [9, 7] {
        assert_eq!(targets(&app), [hooks[2], hooks[0], hooks[1]]);
        assert_eq!(app.world().get::<AttachTo>(own), Some(&by_game));
        app.world_mut().get_mut::<Rope>(rope).unwrap().segments = segments;
        tick(&mut app, 10);
    }
    let mut recipe = app.world_mut().get_mut::<Rope>(rope).unwrap();
    recipe.start = None;
    recipe.end.as_mut().unwrap().entity = hooks[0];
    tick(&mut app, 10);
    assert_eq!(targets(&app), [hooks[2], hooks[0]]);
    assert_eq!(app.world().get::<AttachTo>(own), Some(&by_game));
    assert_eq!(heard(&app), []);
}

#[test]
fn an_attachment_ends_with_one_message_with_its_target_and_silently_with_its_body() {
    let mut app = app();
    let world = app.world_mut();
    let hand = world.spawn(Transform::from_xyz(0.0, 4.0, 0.0)).id();
    let body = world.spawn((RigidBox::default(), Transform::from_xyz(2.0, 4.0, 0.0))).id();
    let rope = world.spawn(Rope::between(hand, body)).id();
    let edge = Anchor::InBox { center: Vec3::Y * 0.5, half_size: Vec3::new(1.0, 0.01, 0.1) };
    let flag = (Cloth::grid(1.0, 1.0, 4, 4), AttachTo::new(hand).part(edge));
    let flag = world.spawn((flag, Transform::from_xyz(-3.0, 4.0, 0.0))).id();
    tick(&mut app, 10);
    let count = |app: &mut App| {
        let world = app.world_mut();
        let joints = world.query::<&AnchorConstraint>().iter(world).count();
        (joints, world.query::<&PinnedTo>().iter(world).count())
    };
    assert_eq!(count(&mut app), (1, 6));
    app.world_mut().despawn(hand);
    tick(&mut app, 10);
    assert_eq!(count(&mut app), (1, 0));
    let refusals = heard(&app);
    assert_eq!(refusals.len(), 2, "one message for the rope's end, one for the flag: {refusals:?}");
    assert!(refusals.iter().all(|(_, reason)| *reason == Refusal::AttachTarget(hand)));
    assert!(
        app.world().get::<AttachTo>(flag).is_none() && app.world().get::<Attached>(flag).is_none()
    );
    forget(&mut app);
    app.world_mut().despawn(rope);
    tick(&mut app, 2);
    assert_eq!(count(&mut app), (0, 0));
    let world = app.world_mut();
    assert_eq!(world.query::<&AttachTo>().iter(world).count(), 0);
    assert_eq!(heard(&app), []);
    assert_finite(&mut app);
}

#[test]
fn removing_the_component_ends_the_attachment() {
    let mut app = app();
    let world = app.world_mut();
    let hook = world.spawn(Transform::from_xyz(0.0, 9.0, 0.0)).id();
    let by = AttachTo::new(hook).part(Anchor::Point(Vec3::Y * 0.7)).with_compliance(1e-4);
    let body = world.spawn((RigidBox::default(), by, Transform::from_xyz(0.0, 8.0, 0.0))).id();
    tick(&mut app, 30);
    assert!(app.world().get::<AttachmentJoints>(body).unwrap().iter().count() == 2);
    app.world_mut().entity_mut(body).remove::<AttachTo>();
    tick(&mut app, 30);
    assert!(transform(&app, body).translation.y < 7.5, "{:?}", transform(&app, body));
    let world = app.world_mut();
    assert_eq!(world.query::<&AnchorConstraint>().iter(world).count(), 0);
    assert!(world.get::<Attached>(body).is_none());
    assert_eq!(heard(&app), []);
}

#[test]
fn attached_bodies_do_not_collide_with_their_targets() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let world = app.world_mut();
    // A box that half overlaps another, and one that half overlaps a collider of the game.
    let one = world.spawn((RigidBox::default(), Transform::from_xyz(0.0, 0.0, 0.0))).id();
    let by = AttachTo::new(one).part(Anchor::Point(Vec3::NEG_X * 0.5));
    let other = world.spawn((RigidBox::default(), by, Transform::from_xyz(0.5, 0.0, 0.0))).id();
    let wall = world.spawn((Collider::cuboid(Vec3::ONE), Transform::from_xyz(9.0, 0.0, 0.0))).id();
    let by = AttachTo::new(wall).part(Anchor::Point(Vec3::NEG_X * 0.5));
    let third = world.spawn((RigidBox::default(), by, Transform::from_xyz(9.5, 0.0, 0.0))).id();
    tick(&mut app, 60);
    for (body, x) in [(one, 0.0), (other, 0.5), (third, 9.5)] {
        let at = transform(&app, body).translation;
        assert!(at.abs_diff_eq(Vec3::X * x, 1e-3), "{at}");
    }
}

#[test]
fn a_compliant_attachment_sags_by_its_compliance() {
    let mut app = app();
    let world = app.world_mut();
    let hook = world.spawn(Transform::from_xyz(0.0, 3.0, 0.0)).id();
    let soft = Softness::Compliant { compliance: 0.002, damping: 40.0 };
    let by = AttachTo::new(hook).part(Anchor::Corner(Vec3::Y)).with_softness(soft);
    let body = RigidBox::new(Vec3::splat(0.2)).with_mass(5.0);
    let body = world.spawn((body, by, Transform::from_xyz(0.0, 2.9, 0.0))).id();
    tick(&mut app, 600);
    let sag = 2.9 - transform(&app, body).translation.y;
    let wanted = 5.0 * 9.81 * 0.002;
    assert!((sag / wanted - 1.0).abs() < 0.02, "{sag} m, not {wanted}");
}

#[test]
fn an_impossible_attachment_is_refused_once_and_holds_when_it_is_repaired() {
    let mut app = app();
    let world = app.world_mut();
    let hook = world.spawn(Transform::from_xyz(0.0, 3.0, 0.0)).id();
    let nowhere = world.spawn(Name::new("nothing")).id();
    let cloth =
        |to: AttachTo, x: f32| (Cloth::grid(1.0, 1.0, 3, 3), to, Transform::from_xyz(x, 0.0, 0.0));
    let none = AttachTo::new(hook).part(Anchor::Vertex(99));
    let cases = [
        (world.spawn(cloth(none, 0.0)).id(), AttachFault::NoSuchPart),
        (
            world.spawn(cloth(AttachTo::new(hook).part(Anchor::bone("head")), 3.0)).id(),
            AttachFault::NoSuchPart,
        ),
        (
            world.spawn(cloth(AttachTo::new(hook).at(Anchor::RopeEnd(RopeEnd::Last)), 6.0)).id(),
            AttachFault::NoSuchAnchor,
        ),
        (world.spawn(cloth(AttachTo::new(nowhere), 9.0)).id(), AttachFault::NoPlace),
        (
            world.spawn(cloth(AttachTo::new(hook).at(Anchor::Point(Vec3::NAN)), 12.0)).id(),
            AttachFault::Number,
        ),
        (world.spawn((AttachTo::new(hook), Transform::default())).id(), AttachFault::NoParticles),
    ];
    tick(&mut app, 5);
    let refusals = heard(&app);
    let wanted: Vec<_> =
        cases.iter().map(|&(entity, fault)| (entity, Refusal::Attach(fault))).collect();
    assert_eq!(refusals, wanted);
    app.world_mut().get_mut::<AttachTo>(cases[0].0).unwrap().part = Anchor::Vertex(3);
    tick(&mut app, 5);
    assert_eq!(app.world().get::<Attached>(cases[0].0).unwrap().pinned.len(), 1);
    assert_eq!(heard(&app).len(), cases.len());
}

#[test]
fn a_snapped_part_goes_to_its_anchor_and_a_slack_rope_is_longer_than_its_gap() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let world = app.world_mut();
    let left = world.spawn(Transform::from_xyz(-1.0, 0.0, 0.0)).id();
    let right = world.spawn(Transform::from_xyz(1.0, 0.0, 0.0)).id();
    let rope = world.spawn(Rope::between(left, right).with_slack(0.25)).id();
    let by =
        AttachTo::new(right).part(Anchor::Corner(Vec3::ONE)).at(Anchor::Point(Vec3::Z)).snapped();
    let body =
        world.spawn((RigidBox::new(Vec3::splat(0.2)), by, Transform::from_xyz(1.0, 0.0, 2.0)));
    let body = body.id();
    tick(&mut app, 120);
    let length: f32 = {
        let world = app.world_mut();
        let rods = world.get::<BodyConstraints>(rope).unwrap().iter().collect::<Vec<_>>();
        rods.iter().map(|&rod| world.get::<DistanceConstraint>(rod).unwrap().rest).sum()
    };
    assert!((length - 2.5).abs() < 1e-4, "{length}");
    assert!(end_of(&app, rope).abs_diff_eq(Vec3::X, 1e-3));
    let corner = place_in(&app, body, Vec3::splat(0.1));
    assert!(corner.abs_diff_eq(Vec3::new(1.0, 0.0, 1.0), 2e-3), "{corner}");
}

/// A clone of an attached body had a copy of what the original held, and released it when it was attached itself: the original fell.
#[test]
fn a_clone_of_an_attached_body_is_attached_by_itself_and_leaves_its_original_attached() {
    let mut app = app();
    let world = app.world_mut();
    let hook = world.spawn(Transform::from_xyz(0.0, 3.0, 0.0)).id();
    let edge = Vec3::new(1.0, 0.01, 0.1);
    let edge = Anchor::InBox { center: Vec3::Y * 0.5, half_size: edge };
    let banner = (Cloth::grid(1.0, 1.0, 6, 6), AttachTo::new(hook).part(edge));
    let banner = world.spawn((banner, Transform::from_xyz(0.0, 2.5, 0.0))).id();
    let lamp = (RigidBox::new(Vec3::splat(0.2)), AttachTo::new(hook).with_compliance(1e-4));
    let lamp = world.spawn((lamp, Transform::from_xyz(0.0, 2.5, 3.0))).id();
    tick(&mut app, 30);
    let pins = |app: &mut App| app.world_mut().query::<&PinnedTo>().iter(app.world()).count();
    let before = pins(&mut app);
    for body in [banner, lamp] {
        let clone = app.world_mut().entity_mut(body).clone_and_spawn();
        app.world_mut().get_mut::<Transform>(clone).unwrap().translation.x += 3.0;
        tick(&mut app, 3);
        assert_eq!(app.world().get::<Attached>(clone).unwrap().body, clone);
        assert_eq!(app.world().get::<Attached>(body).unwrap().body, body);
    }
    assert_eq!(pins(&mut app), 2 * before);
    assert!(heard(&app).is_empty());
}
