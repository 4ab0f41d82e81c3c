//! Ropes that collide by their segments: a body with this contact shape gets it, a body without segments is refused, and all lasting state is in components.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyContacts, Bound, ContactCache, ContactShape, ParticleBody, ParticleOf, Refusal, TubeMesh,
};
use sinew_scenes::ScenesPlugin;

use crate::snapshot::roll_back_in_every_tick;
use crate::support::{app, app_with, assert_finite, hash, heard, particles_of, position, tick};

/// A thin post across, and a coarse rope whose middle falls onto it.
fn over_a_post(app: &mut App, shape: ContactShape) -> Entity {
    let across = Transform::from_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
    app.world_mut().spawn((Collider::capsule(0.005, 2.0), across));
    let ends = [-0.55, 0.55].map(|x| Vec3::new(x, 0.05, 0.0));
    let rope =
        Rope { segments: 11, radius: 0.005, pin_start: false, ..Rope::between(ends[0], ends[1]) };
    app.world_mut().spawn((rope, BodyContacts::default().shaped(shape))).id()
}

/// Height of the highest particle of a body, metres.
fn top(app: &App, body: Entity) -> f32 {
    let heights = particles_of(app, body).into_iter().map(|one| position(app, one).y);
    heights.fold(f32::NEG_INFINITY, f32::max)
}

/// The number of rods with a contact cache, and the rods whose cache is not empty.
fn caches(app: &mut App) -> (usize, Vec<Entity>) {
    let world = app.world_mut();
    let mut rods = world.query_filtered::<(Entity, &ContactCache), With<DistanceConstraint>>();
    let all: Vec<_> = rods.iter(world).collect();
    let holding = all.iter().filter(|(_, cache)| !cache.is_empty()).map(|&(rod, _)| rod);
    (all.len(), holding.collect())
}

#[test]
fn a_coarse_rope_hangs_over_a_post_by_its_segments_and_bodies_without_are_refused_once() {
    let run = |shape: ContactShape| {
        let mut app = app();
        let rope = over_a_post(&mut app, shape);
        tick(&mut app, 120);
        assert_eq!(heard(&app), []);
        top(&app, rope)
    };
    assert!(run(ContactShape::Segments).abs() < 0.05);
    assert!(run(ContactShape::Particles) < -5.0);
    assert!(run(ContactShape::Auto).abs() < 0.05, "the default for this rope");

    let mut app = app();
    let shaped = BodyContacts::default().shaped(ContactShape::Segments);
    let thread = app.world_mut().spawn((Rope { radius: 0.0, ..default() }, shaped)).id();
    let late = app.world_mut().spawn((ParticleBody, shaped)).id();
    let heap = app.world_mut().spawn((ParticleBody, shaped)).id();
    for x in [0.0, 0.5] {
        app.world_mut().spawn((Particle::at(Vec3::X * x), Radius(0.1), ParticleOf(heap)));
    }
    tick(&mut app, 5);
    let mut refusals = heard(&app);
    refusals.sort_unstable_by_key(|&(body, _)| body);
    let mut expected = [(thread, Refusal::NoSegments), (heap, Refusal::NoSegments)];
    expected.sort_unstable_by_key(|&(body, _)| body);
    assert_eq!(refusals, expected, "a body that is not built yet is not refused: {late}");
}

#[test]
fn segments_switched_on_and_off_while_time_runs_hold_and_release() {
    let mut app = app();
    let rope = over_a_post(&mut app, ContactShape::Particles);
    tick(&mut app, 3);
    assert_eq!(caches(&mut app), (0, Vec::new()));
    app.world_mut().get_mut::<BodyContacts>(rope).unwrap().shape = ContactShape::Segments;
    tick(&mut app, 120);
    assert!(top(&app, rope).abs() < 0.05, "it was caught: {}", top(&app, rope));
    let (count, holding) = caches(&mut app);
    assert_eq!((count, holding.is_empty()), (11, false));
    // The segments that lie on the post are torn, and their capsules go with them.
    for rod in holding {
        app.world_mut().despawn(rod);
    }
    tick(&mut app, 120);
    assert!(top(&app, rope) < -5.0, "it fell: {}", top(&app, rope));
    assert_eq!(heard(&app), []);

    let mut app = self::app();
    let rope = over_a_post(&mut app, ContactShape::Segments);
    tick(&mut app, 120);
    assert!(top(&app, rope).abs() < 0.05);
    app.world_mut().get_mut::<BodyContacts>(rope).unwrap().shape = ContactShape::Particles;
    tick(&mut app, 120);
    assert!(top(&app, rope) < -5.0, "it was let go: {}", top(&app, rope));
    assert_eq!(caches(&mut app), (0, Vec::new()));
}

#[test]
fn a_rod_that_becomes_a_strut_or_loses_its_thickness_is_no_segment_until_it_is_one_again() {
    let mut app = app();
    let rope = over_a_post(&mut app, ContactShape::Segments);
    tick(&mut app, 2);
    assert_eq!(caches(&mut app).0, 11);
    let end = particles_of(&app, rope)[0];
    app.world_mut().get_mut::<Radius>(end).unwrap().0 = 0.0;
    tick(&mut app, 2);
    assert_eq!(caches(&mut app).0, 10);
    app.world_mut().get_mut::<Radius>(end).unwrap().0 = 0.005;
    let world = app.world_mut();
    let rods = world.query_filtered::<Entity, With<DistanceConstraint>>();
    let rod = { rods }.iter(world).next().unwrap();
    world.get_mut::<DistanceConstraint>(rod).unwrap().bound = Bound::AtLeast;
    tick(&mut app, 2);
    assert_eq!(caches(&mut app).0, 10);
    app.world_mut().get_mut::<DistanceConstraint>(rod).unwrap().bound = Bound::AtMost;
    tick(&mut app, 2);
    assert_eq!(caches(&mut app).0, 11);
    assert_eq!(heard(&app), []);
}

#[test]
fn the_contact_caches_of_segments_are_rolled_back_and_independent_of_other_bodies() {
    let (mut alone, mut among) = (app(), app());
    over_a_post(&mut alone, ContactShape::Segments);
    over_a_post(&mut among, ContactShape::Segments);
    // A distant rope that is added and removed: the caches of the first must not be cleared by it.
    let far = Rope::between(Vec3::X * 90.0, Vec3::X * 91.0);
    let far = among.world_mut().spawn((far, BodyContacts::ALL.shaped(ContactShape::Segments)));
    let far = far.id();
    tick(&mut alone, 90);
    tick(&mut among, 60);
    among.world_mut().despawn(far);
    tick(&mut among, 30);
    assert_eq!(hash(&mut alone), hash(&mut among));
    roll_back_in_every_tick(&mut alone, 30);
}

#[test]
fn the_ropes_of_the_scene_hang_by_their_segments_and_not_by_their_particles() {
    let mut app = app_with(ScenesPlugin);
    sinew_scenes::load(app.world_mut(), sinew_scenes::find("rails").unwrap());
    tick(&mut app, 300);
    let world = app.world_mut();
    let mut bodies = world.query_filtered::<(Entity, &BodyContacts), With<TubeMesh>>();
    let ropes: Vec<_> = bodies.iter(world).map(|(rope, own)| (rope, own.shape)).collect();
    // Higher than the middle of the slack line.
    let hanging = |shape: ContactShape| {
        ropes.iter().filter(|&&(rope, own)| own == shape && top(&app, rope) > 0.9).count()
    };
    assert_eq!(ropes.len(), 16);
    assert_eq!(hanging(ContactShape::Segments), 8, "five on the rail, the line, two on that");
    assert_eq!(hanging(ContactShape::Particles), 1, "the line alone, which is pinned");
    let world = app.world_mut();
    let mut named = world.query::<(&Name, &Particle)>();
    let weights = named.iter(world).filter(|(name, _)| name.as_str() == "weight");
    let [mut kept, mut lost] = [0; 2];
    for (_, weight) in weights {
        let by_segments = weight.position.x > 0.0;
        kept += usize::from(by_segments && weight.position.y > 0.3);
        lost += usize::from(!by_segments && weight.position.y < 0.3);
    }
    assert_eq!((kept, lost), (4, 4));
    assert_finite(&mut app);
}
