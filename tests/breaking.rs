//! Constraints and attachments that break at a force or a strain: at the load that statics predicts, in a known order, and with the right report.

use bevy::ecs::relationship::RelationshipTarget;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    AnchorConstraint, Attached, AttachmentOf, BodyConstraints, BodyParticles, RopeEnd,
};

use crate::support::{app, hash, heard, particles_of, position, tick};

const G: f32 = 9.81;

/// Everything that broke, as messages and as entity events.
#[derive(Resource, Default)]
struct All {
    messages: Vec<Broke>,
    events: Vec<(Entity, Entity)>,
}

fn listen(app: &mut App) {
    app.init_resource::<All>();
    app.add_systems(Last, |mut all: ResMut<All>, mut messages: MessageReader<Broke>| {
        all.messages.extend(messages.read().cloned());
    });
    app.add_observer(|broke: On<Broke>, mut all: ResMut<All>| {
        all.events.push((broke.entity, broke.constraint));
    });
}

fn broken(app: &App) -> &[Broke] {
    &app.world().resource::<All>().messages
}

fn rods(app: &App, body: Entity) -> Vec<Entity> {
    app.world().get::<BodyConstraints>(body).map(|all| all.iter().collect()).unwrap_or_default()
}

/// A rope of 2 kg that hangs from a hook by an attachment that breaks at `force`, newtons.
fn hung(substeps: u32, sweeps: u32, force: f32) -> (App, Entity, Entity) {
    let mut app = app();
    listen(&mut app);
    app.insert_resource(AirDrag(0.0));
    app.insert_resource(SolverConfig { substeps, max_sweeps: sweeps, ..default() });
    let world = app.world_mut();
    let hook = world.spawn(Transform::from_xyz(0.0, 3.0, 0.0)).id();
    let rope = Rope { mass: 2.0, from: Vec3::Y * 3.0, to: Vec3::Y * 2.0, ..default() };
    let rope = Rope { pin_start: false, ..rope };
    let by = AttachTo::new(hook).part(Anchor::RopeEnd(RopeEnd::First));
    let rope = world.spawn(rope).id();
    let by = world.spawn((by, AttachmentOf(rope), BreakAt::force(force))).id();
    (app, rope, by)
}

#[test]
fn a_rope_breaks_off_at_its_weight_and_holds_just_above_it_at_any_substeps_and_sweeps() {
    for (substeps, sweeps) in [(1, 4), (4, 1), (10, 4), (20, 10)] {
        let weight = 2.0 * G;
        let (mut app, rope, by) = hung(substeps, sweeps, weight * 0.98);
        tick(&mut app, 2);
        let known = broken(&app);
        assert_eq!(known.len(), 1, "{substeps} substeps, {sweeps} sweeps");
        let Broke { constraint, body, force, point, ref particles, .. } = known[0];
        assert_eq!((constraint, body), (by, Some(rope)));
        assert!((force / weight - 1.0).abs() < 0.02, "{force} N of {weight} N");
        assert!(point.abs_diff_eq(Vec3::Y * 3.0, 1e-2), "{point}");
        assert!(particles.contains(&particles_of(&app, rope)[0]));
        let events = app.world().resource::<All>().events.clone();
        assert_eq!(events, [(by, by), (rope, by)]);
        tick(&mut app, 30);
        assert!(position(&app, particles_of(&app, rope)[0]).y < 2.5, "it fell");
        assert!(app.world().get_entity(by).is_err());
        assert_eq!(heard(&app), []);

        let (mut app, rope, _) = hung(substeps, sweeps, weight * 1.02);
        tick(&mut app, 1200);
        assert_eq!(broken(&app), [], "{substeps} substeps, {sweeps} sweeps");
        assert!(position(&app, particles_of(&app, rope)[0]).y > 2.99);
    }
}

#[test]
fn a_loaded_rope_breaks_where_its_tension_is_largest() {
    let mut app = app();
    listen(&mut app);
    let world = app.world_mut();
    let rope = Rope { mass: 1.0, ..Rope::between(Vec3::Y * 3.0, Vec3::Y * 2.0) };
    let rope = world.spawn((rope, BreakAt::force(1.5 * G))).id();
    tick(&mut app, 60);
    assert_eq!(broken(&app), []);
    let all = rods(&app, rope);
    let last = *particles_of(&app, rope).last().unwrap();
    app.world_mut().get_mut::<Mass>(last).unwrap().0 += 0.4;
    tick(&mut app, 60);
    assert_eq!(broken(&app), [], "1.4 kg");
    app.world_mut().get_mut::<Mass>(last).unwrap().0 += 0.2;
    tick(&mut app, 2);
    // The top segment bears 1.6 kg less half a segment, and two segments further down the load is 1.5 kg.
    let which: Vec<Entity> = broken(&app).iter().map(|one| one.constraint).collect();
    assert!(!which.is_empty() && which.iter().all(|one| all[..3].contains(one)), "{which:?}");
    assert_eq!(which[0], all[0]);
    assert_eq!(broken(&app)[0].body, Some(rope));
    tick(&mut app, 30);
    assert!(position(&app, last).y < 1.5);
}

#[test]
fn a_loose_rod_a_spring_and_a_soft_rod_break_at_their_force_or_strain() {
    let mut app = app();
    listen(&mut app);
    let world = app.world_mut();
    let mut hang = |x: f32, mass: f32| {
        let hook = world.spawn((Particle::at(Vec3::X * x), Pinned::HERE)).id();
        let bob = world.spawn((Particle::at(Vec3::new(x, -1.0, 0.0)), Mass(mass))).id();
        (hook, bob)
    };
    let pairs: Vec<_> = [(0.0, 2.0), (1.0, 2.0), (2.0, 2.0), (3.0, 2.0), (4.0, 2.0)]
        .map(|(x, m)| hang(x, m))
        .into();
    let limits = BreakAt { force: 2.0 * G * 0.98, ..default() };
    let weak = DistanceConstraint::new(pairs[0].0, pairs[0].1, 1.0);
    let weak = world.spawn((weak, limits)).id();
    let firm = DistanceConstraint::new(pairs[1].0, pairs[1].1, 1.0);
    let firm = world.spawn((firm, BreakAt::force(2.0 * G * 1.02))).id();
    // Without a limit it would swing down to twice the static stretch of 0.1962 m.
    let spring = Spring::new(pairs[2].0, pairs[2].1, 1.0, 100.0);
    let spring = world.spawn((spring, BreakAt::strain(0.3))).id();
    let tough = Spring::new(pairs[3].0, pairs[3].1, 1.0, 100.0);
    let tough = world.spawn((tough, BreakAt::strain(0.42))).id();
    let soft = DistanceConstraint::new(pairs[4].0, pairs[4].1, 1.0).with_compliance(0.01);
    let soft = world.spawn((soft, BreakAt::force(1.5 * 2.0 * G))).id();
    tick(&mut app, 120);
    let mut which: Vec<Entity> = broken(&app).iter().map(|one| one.constraint).collect();
    assert_eq!(which.remove(0), weak);
    which.sort_unstable();
    let mut wanted = [spring, soft];
    wanted.sort_unstable();
    assert_eq!(which, wanted, "a soft one swings up to twice the weight");
    assert!(app.world().get_entity(firm).is_ok() && app.world().get_entity(tough).is_ok());
    let stretched = broken(&app).iter().find(|one| one.constraint == spring).unwrap().strain;
    assert!((0.3..0.36).contains(&stretched), "{stretched}");
}

#[test]
fn a_crate_breaks_off_a_hand_and_off_another_crate_at_its_weight() {
    for (force, breaks) in [(0.98, true), (1.05, false)] {
        let mut app = app();
        listen(&mut app);
        let world = app.world_mut();
        let hand = world.spawn(Transform::from_xyz(0.0, 5.0, 0.0)).id();
        let crate_of = |mass: f32| RigidBox::new(Vec3::splat(0.4)).with_mass(mass);
        let upper = (crate_of(3.0), Transform::from_xyz(0.0, 4.8, 0.0));
        let upper = world.spawn((upper, AttachTo::new(hand).part(Anchor::Corner(Vec3::Y)))).id();
        let lower = world.spawn((crate_of(5.0), Transform::from_xyz(0.0, 4.4, 0.0))).id();
        let by = AttachTo::new(upper).part(Anchor::Corner(Vec3::Y)).at(Anchor::Corner(Vec3::NEG_Y));
        world.spawn((by.snapped(), AttachmentOf(lower), BreakAt::force(5.0 * G * force)));
        tick(&mut app, 600);
        assert_eq!(broken(&app).len(), usize::from(breaks), "{:?}", broken(&app));
        let world = app.world_mut();
        let joints = world.query::<&AnchorConstraint>().iter(world).count();
        assert_eq!(joints, 1 + usize::from(!breaks));
        assert_eq!(world.query::<&Attached>().iter(world).count(), 1 + usize::from(!breaks));
    }
}

#[test]
fn constraints_break_alike_in_each_run_and_are_reported_in_a_fixed_order() {
    let run = || {
        let mut app = app();
        listen(&mut app);
        let world = app.world_mut();
        let sheet = Cloth { density: 2.0, ..Cloth::grid(1.0, 1.0, 10, 10) };
        let cloth = world.spawn((sheet.pinned(ClothPins::TopCorners), BreakAt::force(6.0))).id();
        let breaks_in = |app: &App| {
            let place = |entity: Entity| rods(app, cloth).iter().position(|&rod| rod == entity);
            let all = broken(app).iter();
            all.map(|one| (place(one.constraint), one.force.to_bits())).collect::<Vec<_>>()
        };
        tick(&mut app, 90);
        assert!(!broken(&app).is_empty());
        let members = app.world().get::<BodyParticles>(cloth).unwrap().iter().count();
        (breaks_in(&app), members, hash(&mut app))
    };
    assert_eq!(run(), run());
}

#[test]
fn cloth_that_breaks_at_a_strain_is_exempt_from_the_strain_limit() {
    // Strains of large cloth are limited to 3 % at the end of a tick, except in cloth that breaks by strain.
    let mut app = app();
    listen(&mut app);
    let world = app.world_mut();
    world.spawn(Wind { pressure: Vec3::Z * 5.0, gusts: 0.0, ..default() });
    let sheet = Cloth::grid(2.0, 2.0, 60, 60).pinned(ClothPins::TopCorners);
    world.spawn((sheet, BreakAt::strain(0.04), Transform::from_xyz(0.0, 4.0, 0.0)));
    tick(&mut app, 90);
    let strains: Vec<f32> = broken(&app).iter().map(|broke| broke.strain).collect();
    assert!(!strains.is_empty() && strains.iter().all(|&strain| strain > 0.04), "{strains:?}");
}

#[test]
fn limits_that_are_not_positive_finite_numbers_break_nothing() {
    let mut app = app();
    listen(&mut app);
    for (x, force) in [(0.0, f32::NAN), (1.0, -1.0), (2.0, f32::INFINITY)] {
        let limits = BreakAt { force, strain: force };
        let rope = Rope { mass: 1.0, ..default() };
        app.world_mut().spawn((rope, limits, Transform::from_xyz(x, 0.0, 0.0)));
    }
    tick(&mut app, 30);
    assert_eq!(broken(&app), []);
}
