//! Bad input is set aside with one message that names it, and the rest of the world goes on, bit for bit, as if it were not there.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::{DistanceFault, ParticleFault, SpringFault};
use bevy_sinew::{Charge, Drag, Refusal, Refused, SinewClock};
use bevy_sinew::{ParticleRow, PhaseSystems, SinewSystems, SinewTick, SubstepSchedule};

use crate::support::{app, assert_finite, busy_scene, forget, hash_of, heard, tick};

/// Runs a busy scene beside something bad and the same scene alone, and compares all bodies tick by tick. Returns the bad entity and the refusals.
fn beside(bad: impl FnOnce(&mut World) -> Entity) -> (Entity, Vec<(Entity, Refusal)>) {
    let (mut with, mut without) = (app(), app());
    let (bodies, controls) = (busy_scene(&mut with), busy_scene(&mut without));
    let culprit = bad(with.world_mut());
    for tick_number in 0..40 {
        tick(&mut with, 1);
        tick(&mut without, 1);
        assert_eq!(hash_of(&with, &bodies), hash_of(&without, &controls), "tick {tick_number}");
    }
    (culprit, heard(&with))
}

/// Like [`beside`]; asserts that there is one message, about the bad entity.
pub(crate) fn refused(reason: Refusal, bad: impl FnOnce(&mut World) -> Entity) {
    let (culprit, reported) = beside(bad);
    assert_eq!(reported, [(culprit, reason)]);
}

/// A pinned particle far from the busy scene.
pub(crate) fn nail(world: &mut World, x: f32) -> Entity {
    world.spawn((Particle::at(Vec3::new(x, 5.0, 5.0)), Pinned::HERE)).id()
}

#[test]
fn a_constraint_whose_particle_is_gone_is_named_once() {
    let missing = DistanceFault::MissingParticle;
    refused(Refusal::Distance(missing), |world| {
        let (a, b) = (nail(world, 0.0), nail(world, 1.0));
        world.despawn(b);
        world.spawn(DistanceConstraint::new(a, b, 1.0)).id()
    });
    refused(Refusal::Distance(missing), |world| {
        let (a, b) = (nail(world, 0.0), world.spawn(Name::new("no particle")).id());
        world.spawn(DistanceConstraint::new(a, b, 1.0)).id()
    });
    refused(Refusal::Distance(missing), |world| {
        let (a, b) = (nail(world, 0.0), nail(world, 1.0));
        world.despawn(a);
        world.despawn(b);
        world.spawn(DistanceConstraint::new(a, b, 1.0)).id()
    });
    refused(Refusal::Spring(SpringFault::MissingParticle), |world| {
        let (a, b) = (nail(world, 0.0), nail(world, 1.0));
        world.despawn(a);
        world.spawn(Spring::new(a, b, 1.0, 10.0)).id()
    });
}

#[test]
fn a_constraint_from_a_particle_to_itself_is_named_once() {
    refused(Refusal::Distance(DistanceFault::SameParticle), |world| {
        let a = nail(world, 0.0);
        world.spawn(DistanceConstraint::new(a, a, 1.0)).id()
    });
    refused(Refusal::Spring(SpringFault::SameParticle), |world| {
        let a = nail(world, 0.0);
        world.spawn(Spring::new(a, a, 1.0, 10.0)).id()
    });
}

#[test]
fn a_constraint_with_a_broken_number_is_named_once() {
    for rest in [f32::NAN, f32::INFINITY, -1.0] {
        refused(Refusal::Distance(DistanceFault::Rest), |world| {
            let (a, b) = (nail(world, 0.0), nail(world, 1.0));
            world.spawn(DistanceConstraint::new(a, b, rest)).id()
        });
    }
    for compliance in [f32::NAN, f32::INFINITY, -1.0] {
        refused(Refusal::Distance(DistanceFault::Softness), |world| {
            let (a, b) = (nail(world, 0.0), nail(world, 1.0));
            world.spawn(DistanceConstraint::new(a, b, 1.0).with_compliance(compliance)).id()
        });
    }
    for (rest, stiffness, damping) in
        [(f32::NAN, 1.0, 1.0), (1.0, f32::NAN, 1.0), (1.0, 1.0, f32::NAN), (1.0, -1.0, 0.0)]
    {
        refused(Refusal::Spring(SpringFault::Number), |world| {
            let (a, b) = (nail(world, 0.0), nail(world, 1.0));
            world.spawn(Spring::new(a, b, rest, stiffness).with_damping(damping)).id()
        });
    }
}

#[test]
fn a_particle_with_a_broken_number_is_named_once() {
    let place = Particle::at(Vec3::new(0.0, 5.0, 5.0));
    let with = |fault, bundle: Box<dyn FnOnce(&mut World) -> Entity>| {
        refused(Refusal::Particle(fault), bundle);
    };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let at = Vec3::new(1.0, bad, 1.0);
        with(ParticleFault::Position, Box::new(move |w| w.spawn(Particle::at(at)).id()));
        with(ParticleFault::Velocity, Box::new(move |w| w.spawn(place.with_velocity(at)).id()));
        let lag = Particle { lag: bad, ..place };
        with(ParticleFault::Velocity, Box::new(move |w| w.spawn(lag).id()));
        with(ParticleFault::Charge, Box::new(move |w| w.spawn((place, Charge(bad))).id()));
        with(ParticleFault::Radius, Box::new(move |w| w.spawn((place, Radius(bad))).id()));
        with(ParticleFault::Drag, Box::new(move |w| w.spawn((place, Drag(bad))).id()));
        with(ParticleFault::Force, Box::new(move |w| w.spawn((place, ExternalForce(at))).id()));
    }
    for bad in [-1.0, 0.0, -0.0, f32::NAN, f32::NEG_INFINITY, 1e-45] {
        with(ParticleFault::Mass, Box::new(move |w| w.spawn((place, Mass(bad))).id()));
    }
    with(ParticleFault::Radius, Box::new(move |w| w.spawn((place, Radius(-0.1))).id()));
    with(ParticleFault::Drag, Box::new(move |w| w.spawn((place, Drag(1.5))).id()));
}

#[test]
fn a_pin_to_an_entity_that_is_gone_or_has_no_place_is_released_and_named_once() {
    for gone in [true, false] {
        let (pinned, reported) = beside(|world| {
            let hand = world.spawn(Name::new("a hand without a transform")).id();
            if gone {
                world.despawn(hand);
            }
            let at = Vec3::new(0.0, 5.0, 5.0);
            world.spawn((Particle::at(at), PinnedTo { entity: hand, offset: Vec3::ZERO })).id()
        });
        assert!(
            matches!(reported[..], [(entity, Refusal::PinTarget(_))] if entity == pinned),
            "{reported:?}"
        );
    }
}

#[test]
fn surroundings_with_a_broken_number_are_named_once_and_do_nothing() {
    let cases: [(&str, fn(&mut World) -> Entity); 8] = [
        ("wind", |w| w.spawn(Wind { pressure: Vec3::NAN, ..default() }).id()),
        ("gusts", |w| w.spawn(Wind { gusts: f32::NAN, ..default() }).id()),
        ("fluid", |w| w.spawn(Fluid { density: f32::NAN, ..default() }).id()),
        ("nowhere", |w| w.spawn((Fluid::default(), Transform::from_translation(Vec3::NAN))).id()),
        ("ground", |w| w.spawn((Ground, SurfaceMaterial::new(-1.0))).id()),
        ("abyss", |w| w.spawn((Ground, Transform::from_xyz(0.0, f32::NAN, 0.0))).id()),
        ("room", |w| w.spawn(BoundingBox { size: Vec3::splat(-2.0) }).id()),
        ("pin", |w| {
            let at = Vec3::new(0.0, 5.0, 5.0);
            w.spawn((Particle::at(at), Pinned::at(Vec3::NAN))).id()
        }),
    ];
    let mut wrong = Vec::new();
    for (name, spawn) in cases {
        let (culprit, reported) = beside(spawn);
        let named: Vec<Entity> = reported.iter().map(|(entity, _)| *entity).collect();
        if named != [culprit] {
            wrong.push((name, culprit, named));
        }
    }
    assert!(wrong.is_empty(), "one message each was expected: {wrong:?}");
}

#[test]
fn a_repaired_particle_goes_on_and_is_named_again_when_it_breaks_again() {
    let mut app = app();
    let stone = app.world_mut().spawn(Particle::at(Vec3::Y)).id();
    let set = |app: &mut App, mass: f32| {
        app.world_mut().get_mut::<Mass>(stone).unwrap().0 = mass;
        tick(app, 10);
        let at = app.world().get::<Particle>(stone).unwrap().position.y;
        let reported = heard(app).len();
        forget(app);
        (at, reported)
    };
    assert_eq!(set(&mut app, -1.0), (1.0, 1), "set aside where it is");
    let (fell, reported) = set(&mut app, 2.0);
    assert!(fell < 1.0 && reported == 0, "repaired, it falls");
    assert_eq!(set(&mut app, f32::NAN), (fell, 1));
    assert_eq!(set(&mut app, f32::NAN), (fell, 0), "named once");
}

#[test]
fn a_repaired_constraint_holds_again() {
    let mut app = app();
    let world = app.world_mut();
    let hook = world.spawn((Particle::at(Vec3::ZERO), Pinned::HERE)).id();
    let bob = world.spawn(Particle::at(Vec3::X)).id();
    let rod = world.spawn(DistanceConstraint::new(hook, bob, f32::NAN)).id();
    tick(&mut app, 30);
    let length = |app: &App| app.world().get::<Particle>(bob).unwrap().position.length();
    assert!(length(&app) > 1.1, "it falls freely");
    app.world_mut().get_mut::<DistanceConstraint>(rod).unwrap().rest = 1.0;
    tick(&mut app, 60);
    assert!((length(&app) - 1.0).abs() < 1e-3, "{}", length(&app));
    app.world_mut().get_mut::<DistanceConstraint>(rod).unwrap().b = rod;
    tick(&mut app, 2);
    let reported: Vec<_> = heard(&app).into_iter().map(|(entity, _)| entity).collect();
    assert_eq!(reported, [rod, rod], "once for each time that it broke");
}

#[test]
fn one_nan_particle_of_a_cloth_is_named_once_and_spreads_no_nan() {
    let mut app = app();
    let bodies = busy_scene(&mut app);
    tick(&mut app, 20);
    let poisoned = crate::support::particles_of(&app, bodies[2])[40];
    app.world_mut().get_mut::<Particle>(poisoned).unwrap().position.y = f32::NAN;
    tick(&mut app, 60);
    let reported = heard(&app);
    assert_eq!(reported, [(poisoned, Refusal::Particle(ParticleFault::Position))]);
    app.world_mut().get_mut::<Particle>(poisoned).unwrap().position.y = 2.0;
    assert_finite(&mut app);
}

#[test]
fn a_force_that_is_not_a_number_freezes_its_particle_alone() {
    let run = |poison: bool| {
        let mut app = app();
        let bodies = busy_scene(&mut app);
        let victim = app.world_mut().spawn(Particle::at(Vec3::new(0.0, 5.0, 5.0))).id();
        let spoil = move |mut world: ResMut<SinewWorld>,
                          rows: Query<&ParticleRow>,
                          clock: Res<SinewClock>| {
            if poison && clock.tick == 5 {
                let row = rows.get(victim).unwrap().get().unwrap();
                world.particles_mut().add_force(row, Vec3::NAN);
            }
        };
        app.add_systems(SubstepSchedule, spoil.in_set(PhaseSystems::Wind));
        tick(&mut app, 20);
        assert_finite(&mut app);
        (victim, hash_of(&app, &bodies), heard(&app))
    };
    let (victim, poisoned, reported) = run(true);
    assert_eq!(reported, [(victim, Refusal::Diverged)]);
    assert_eq!(poisoned, run(false).1, "no other body is affected");
}

#[test]
fn a_frozen_particle_is_not_named_again_while_the_clock_stands_still() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, bevy_sinew::SinewPlugin::in_schedule(Update)));
    app.finish();
    let hurled = Particle::at(Vec3::ZERO).with_velocity(Vec3::splat(f32::MAX));
    let stone = app.world_mut().spawn((hurled, ExternalForce(Vec3::splat(f32::MAX)))).id();
    let run = |app: &mut App, length, frames| {
        app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(length));
        (0..frames).for_each(|_| app.update());
        app.world().resource::<Messages<Refused>>().len()
    };
    // Bevy keeps messages while its clock stands still, so they add up.
    let reported = run(&mut app, crate::support::TICK, 2);
    assert_eq!(reported, 1, "it froze");
    assert_eq!(run(&mut app, core::time::Duration::ZERO, 5), reported);
    app.world_mut().despawn(stone);
    assert_eq!(run(&mut app, core::time::Duration::ZERO, 2), reported);
}

#[test]
fn a_refusal_reads_as_a_sentence_about_its_entity() {
    let texts = [
        Refusal::Particle(ParticleFault::Mass),
        Refusal::Distance(DistanceFault::SameParticle),
        Refusal::Transform,
        Refusal::NoMesh,
    ]
    .map(|reason| format!("entity 7v1 {reason}"));
    assert_eq!(texts[0], "entity 7v1 is set aside: its mass is not a positive number of kilograms");
    assert_eq!(texts[1], "entity 7v1 is set aside: both its ends are the same particle");
    assert!(texts.iter().all(|text| !text.ends_with('.') && text.len() > 20), "{texts:?}");
}

/// While a condition of the game kept the substeps from running, the rows of particles that had diverged in the last step were reported in every tick, and looked
/// up among the particles of now: a panic if there were fewer.
#[test]
fn particles_that_diverged_and_are_gone_before_the_next_step_do_no_harm() {
    #[derive(Resource)]
    struct Stopped(bool);
    let mut app = app();
    let break_last = |mut world: ResMut<SinewWorld>| {
        let last = world.particles().len() - 1;
        world.particles_mut().set_velocity(last, Vec3::NAN);
    };
    let goes = |stopped: Res<Stopped>| !stopped.0;
    app.insert_resource(Stopped(false))
        .add_systems(SubstepSchedule, break_last.in_set(PhaseSystems::AccumulateForces))
        .configure_sets(SinewTick, SinewSystems::Substeps.run_if(goes));
    let particles: Vec<Entity> =
        (0..3).map(|x| app.world_mut().spawn(Particle::at(Vec3::X * x as f32)).id()).collect();
    tick(&mut app, 5);
    assert!(!app.world().resource::<SinewWorld>().report().frozen.is_empty());
    app.world_mut().resource_mut::<Stopped>().0 = true;
    forget(&mut app);
    tick(&mut app, 3);
    assert_eq!(heard(&app), [], "nothing diverges without a step");
    particles[1..].iter().for_each(|&particle| _ = app.world_mut().despawn(particle));
    tick(&mut app, 3);
    assert!(app.world().get::<Particle>(particles[0]).unwrap().position.is_finite());
}
