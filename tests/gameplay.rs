//! Contacts as a game uses them: impulses of every tick, shape casts, and the weight of a character.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{ContactImpulse, QueryFilter, Refusal, SinewQuery, Weighs};

use crate::support::{TICK, app, heard, tick};

/// The contact impulses since this was last cleared, tick by tick, N·s.
#[derive(Resource, Default)]
struct Got(Vec<(Entity, Entity, f32)>);

fn listen(app: &mut App) {
    app.init_resource::<Got>();
    app.add_systems(Last, |mut got: ResMut<Got>, mut heard: MessageReader<ContactImpulse>| {
        got.0.extend(heard.read().map(|one| (one.entity, one.other, one.impulse)));
    });
}

/// Mean contact force between two entities over some ticks, N, from the impulses reported to the first.
fn force(app: &mut App, entity: Entity, other: Entity, ticks: u64) -> f32 {
    app.world_mut().resource_mut::<Got>().0.clear();
    tick(app, ticks);
    let got = &app.world().resource::<Got>().0;
    let sum: f32 =
        got.iter().filter(|one| (one.0, one.1) == (entity, other)).map(|one| one.2).sum();
    sum / (ticks as f32 * TICK.as_secs_f32())
}

fn floor(top: f32) -> (Collider, Transform) {
    (Collider::cuboid(Vec3::new(20.0, 1.0, 20.0)), Transform::from_xyz(0.0, top - 0.5, 0.0))
}

#[test]
fn contact_impulses_of_every_tick_add_up_to_the_weight_on_a_collider() {
    for (mass, substeps) in [(0.2, 10), (12.0, 4), (12.0, 10), (300.0, 40)] {
        let mut app = app();
        listen(&mut app);
        app.world_mut().resource_mut::<SolverConfig>().substeps = substeps;
        let world = app.world_mut();
        let ground = world.spawn((floor(0.0), ContactEvents::Every)).id();
        let body = RigidBox::new(Vec3::splat(0.5)).with_mass(mass);
        let at = Transform::from_xyz(0.0, 0.26, 0.0);
        let body = world.spawn((body, ContactEvents::default(), at)).id();
        tick(&mut app, 90);
        let weight = force(&mut app, ground, body, 30);
        let expected = mass * 9.81;
        assert!(
            (weight / expected - 1.0).abs() < 0.01,
            "{mass} kg, {substeps}: {weight} {expected}"
        );
        let got = &app.world().resource::<Got>().0;
        assert_eq!(got.len(), 30, "one in every tick, and none for the other entity");
        assert_eq!(heard(&app), []);
    }
}

/// A player that the game moves: it stays a centimetre above what is below it.
#[derive(Component, Default)]
struct Player {
    stands_on: Option<Entity>,
}

fn follow(query: SinewQuery, mut players: Query<(Entity, &mut Player, &mut Transform, &Collider)>) {
    for (entity, mut player, mut place, shape) in &mut players {
        let filter = QueryFilter { except: Some(entity), ..default() };
        let from = place.to_isometry();
        let hit = query.cast_shape(shape, from, Dir3::NEG_Y, 1.0, &filter);
        player.stands_on = hit.map(|hit| hit.entity);
        place.translation.y -= hit.map_or(0.0, |hit| hit.distance - 0.01);
    }
}

fn player_at(app: &mut App, at: Vec3) -> Entity {
    app.add_systems(FixedUpdate, follow);
    let place = Transform::from_translation(at + Vec3::Y * 0.92);
    app.world_mut().spawn((Player::default(), Collider::capsule(0.3, 1.2), place)).id()
}

#[test]
fn a_player_presses_on_a_plank_with_its_weight() {
    for (plank_mass, mass) in [(5.0, 80.0), (20.0, 40.0)] {
        let mut app = app();
        listen(&mut app);
        let world = app.world_mut();
        let scale = world.spawn((floor(0.0), ContactEvents::Every)).id();
        let plank = RigidBox::new(Vec3::new(2.0, 0.1, 0.6)).with_mass(plank_mass);
        let plank = world.spawn((plank, Transform::from_xyz(0.0, 0.05, 0.0))).id();
        let player = player_at(&mut app, Vec3::new(0.4, 0.1, 0.0));
        tick(&mut app, 60);
        let light = force(&mut app, scale, plank, 60) / 9.81;
        assert!((light / plank_mass - 1.0).abs() < 0.02, "without a weight: {light}");
        app.world_mut().entity_mut(player).insert(Weighs::new(mass));
        tick(&mut app, 60);
        assert_eq!(app.world().get::<Player>(player).unwrap().stands_on, Some(plank));
        let heavy = force(&mut app, scale, plank, 60) / 9.81;
        assert!((heavy / (plank_mass + mass) - 1.0).abs() < 0.02, "{plank_mass} {mass}: {heavy}");
        // When the player steps off, the plank is light again.
        let aside = Transform::from_xyz(4.0, 0.92, 0.0);
        app.world_mut().entity_mut(player).insert(aside);
        tick(&mut app, 60);
        let light = force(&mut app, scale, plank, 60) / 9.81;
        assert!((light / plank_mass - 1.0).abs() < 0.02, "{light}");
        assert_eq!(app.world().get::<Player>(player).unwrap().stands_on, Some(scale));
        assert_eq!(heard(&app), []);
    }
}

#[test]
fn a_seesaw_tips_to_the_side_of_a_player_with_a_weight() {
    let tilt = |side: f32, weighs: bool| {
        let mut app = app();
        let world = app.world_mut();
        world.spawn(floor(0.0));
        let beam = Collider::cuboid(Vec3::new(0.1, 0.4, 2.0));
        world.spawn((beam, Transform::from_xyz(0.0, 0.2, 0.0)));
        let plank = RigidBox::new(Vec3::new(3.0, 0.06, 0.8)).with_mass(20.0);
        let plank = world.spawn((plank, Transform::from_xyz(0.0, 0.43, 0.0))).id();
        let player = player_at(&mut app, Vec3::new(1.0 * side, 0.46, 0.0));
        if weighs {
            app.world_mut().entity_mut(player).insert(Weighs::new(60.0));
        }
        tick(&mut app, 120);
        (app.world().get::<Transform>(plank).unwrap().rotation * Vec3::X).y
    };
    let (right, left, none) = (tilt(1.0, true), tilt(-1.0, true), tilt(1.0, false));
    assert!(right < -0.15 && left > 0.15, "{right} {left}");
    assert!(none.abs() < 0.02, "{none}");
}

#[test]
fn a_weight_with_a_broken_number_is_refused_once_and_presses_on_nothing() {
    for broken in [f32::NAN, f32::INFINITY, -1.0] {
        let mut app = app();
        let world = app.world_mut();
        world.spawn(floor(0.0));
        let body = (RigidBox::new(Vec3::splat(0.5)), Transform::from_xyz(0.0, 0.25, 0.0));
        let body = world.spawn(body).id();
        let foot = (Collider::sphere(0.2), Weighs { mass: broken, ..default() });
        let foot = world.spawn((foot, Transform::from_xyz(0.0, 0.71, 0.0))).id();
        tick(&mut app, 20);
        assert_eq!(heard(&app), [(foot, Refusal::Weight)], "{broken}");
        assert!(app.world().get::<Transform>(body).unwrap().is_finite());
        app.world_mut().entity_mut(foot).insert(Weighs::default());
        tick(&mut app, 20);
        assert_eq!(heard(&app).len(), 1, "repaired");
    }
}

#[test]
fn a_shape_cast_names_the_entity_that_it_hits() {
    #[derive(Resource, Default)]
    struct Met(Vec<Option<(Entity, f32)>>);
    let mut app = app();
    app.init_resource::<Met>();
    let world = app.world_mut();
    let ground = world.spawn(floor(0.0)).id();
    let at = Transform::from_xyz(0.0, 0.25, 0.0);
    let body = world.spawn((RigidBox::new(Vec3::splat(0.5)), at)).id();
    let sheet = Transform::from_xyz(4.0, 2.0, 0.0)
        .with_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
    let cloth = world.spawn((Cloth::grid(2.0, 2.0, 4, 4), sheet)).id();
    let ball = (Particle::at(Vec3::new(8.0, 2.0, 0.0)), Pinned::HERE, Radius(0.5));
    let ball = world.spawn(ball).id();
    app.insert_resource(Gravity(Vec3::ZERO));
    app.add_systems(Update, move |query: SinewQuery, mut met: ResMut<Met>| {
        let probe = Collider::cuboid(Vec3::splat(0.2));
        let down = |x: f32, filter: &QueryFilter| {
            let place = Isometry3d::from_translation(Vec3::new(x, 5.0, 0.07));
            let hit = query.cast_shape(&probe, place, Dir3::NEG_Y, 20.0, filter);
            hit.map(|hit| (hit.entity, hit.distance))
        };
        let all = QueryFilter::default();
        let past = QueryFilter { except: Some(body), ..all };
        let none = QueryFilter { no_colliders: true, ..past };
        met.0 = [(0.0, all), (0.0, past), (0.0, none), (4.1, all), (8.0, all), (2.0, all)]
            .map(|(x, filter)| down(x, &filter))
            .to_vec();
    });
    tick(&mut app, 3);
    let met = &app.world().resource::<Met>().0;
    let expected = [
        Some((body, 4.4)),
        Some((ground, 4.9)),
        None,
        Some((cloth, 2.9)),
        Some((ball, 2.41)),
        Some((ground, 4.9)),
    ];
    for (i, (found, expected)) in met.iter().zip(&expected).enumerate() {
        let entity = |hit: &Option<(Entity, f32)>| hit.map(|hit| hit.0);
        assert_eq!(entity(found), entity(expected), "{i}: {met:?}");
        if let (Some(found), Some(expected)) = (found, expected) {
            assert!((found.1 - expected.1).abs() < 0.02, "{i}: {found:?} {expected:?}");
        }
    }
}
