//! A body may be particles or an explicit rigid body, and change in any tick without a jump in its state.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyParticles, BodyReport, BoxParticles, Inertia, Refusal, Representation, RigidIntegrator,
    SinewClock, SinewSnapshot, WorldCenterOfMass,
};

use crate::support::{bare_app, hash, heard, tick};

const RIGID: Representation = Representation::Rigid(RigidIntegrator::Leapfrog);

/// A world without gravity or drag, in which a solid box flies and tumbles.
fn tumbling(representation: Representation) -> (App, Entity) {
    let mut app = bare_app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    let box_ = RigidBox {
        particles: BoxParticles::Equimomental,
        ..RigidBox::new(Vec3::new(1.0, 2.0, 3.0))
    };
    let body = app.world_mut().spawn((box_, representation)).id();
    tick(&mut app, 1);
    let world = app.world_mut();
    world.entity_mut(body).set_motion(Vec3::new(1.0, 0.0, -0.5), Vec3::new(3.0, -2.0, 4.0));
    (app, body)
}

/// Centre of mass, rotation, momentum (kg·m/s) and angular momentum (kg·m²/s) of a body.
fn whole(app: &App, body: Entity) -> (Vec3, Quat, Vec3, Vec3) {
    let entity = app.world().entity(body);
    let (transform, centre) =
        (entity.get::<Transform>().unwrap(), entity.get::<WorldCenterOfMass>().unwrap());
    let velocity = entity.get::<LinearVelocity>().unwrap().0;
    let spin = entity.get::<AngularVelocity>().unwrap().0;
    let inertia = entity.get::<Inertia>().unwrap().0;
    (centre.position, transform.rotation, velocity * centre.mass, inertia * spin)
}

#[test]
fn changing_the_representation_takes_effect_at_once_and_keeps_the_motion() {
    let (mut plain, reference) = tumbling(Representation::Particles);
    let (mut swapped, body) = tumbling(Representation::Particles);
    tick(&mut plain, 30);
    tick(&mut swapped, 30);
    let (_, _, momentum, turning) = whole(&swapped, body);
    for round in 0..6 {
        let next = if round % 2 == 0 { RIGID } else { Representation::Particles };
        swapped.world_mut().entity_mut(body).insert(next);
        tick(&mut swapped, 10);
        tick(&mut plain, 10);
        let (a, b) = (whole(&swapped, body), whole(&plain, reference));
        assert!(a.0.distance(b.0) < 1e-4, "round {round}: {} and {}", a.0, b.0);
        assert!(a.1.angle_between(b.1) < 0.01, "round {round}: {} and {}", a.1, b.1);
        assert!((a.2 - momentum).length() < 1e-4 * momentum.length(), "round {round}: {}", a.2);
        assert!(
            (a.3 - turning).length() < 1e-3 * turning.length(),
            "round {round}: {} of {turning}",
            a.3
        );
    }
    assert_eq!(heard(&swapped), []);
}

#[test]
fn a_rigid_body_has_no_constraints_to_solve_and_particles_have_28() {
    let (mut app, body) = tumbling(RIGID);
    tick(&mut app, 2);
    let (rods, compounds) = {
        let simulation = app.world().resource::<SinewWorld>().simulation();
        (simulation.colours(), simulation.compounds().len())
    };
    assert_eq!((rods, compounds), (1, 1), "one shape and no rods");
    app.world_mut().entity_mut(body).remove::<Representation>();
    tick(&mut app, 1);
    let simulation = app.world().resource::<SinewWorld>().simulation();
    assert!(simulation.colours() >= 7 && simulation.compounds().is_empty());
}

#[test]
fn a_rope_pulls_a_rigid_box_off_the_ground_and_lets_it_down() {
    let mut app = bare_app();
    app.world_mut().spawn(Ground);
    let place = Transform::from_xyz(0.0, 0.5, 0.0);
    let body = app.world_mut().spawn((RigidBox::new(Vec3::ONE), RIGID, place)).id();
    tick(&mut app, 60);
    let rest = app.world().get::<Transform>(body).unwrap().translation;
    assert!((rest.y - 0.5).abs() < 2e-3, "{rest}");
    let corner = app.world().get::<BodyParticles>(body).unwrap().iter().nth(7).unwrap();
    let hook = app.world_mut().spawn((Particle::at(Vec3::new(0.5, 2.0, 0.5)), Pinned::HERE)).id();
    let rope = app.world_mut().spawn(DistanceConstraint::new(corner, hook, 1.0)).id();
    tick(&mut app, 1);
    for step in 1..=60 {
        let up = Vec3::new(0.5, 2.0 + step as f32 * 0.02, 0.5);
        app.world_mut().entity_mut(hook).insert(Pinned::at(up));
        tick(&mut app, 1);
    }
    tick(&mut app, 120);
    let hung = *app.world().get::<Transform>(body).unwrap();
    assert!(hung.translation.y > 1.2, "{hung:?}");
    app.world_mut().despawn(rope);
    tick(&mut app, 240);
    let down = app.world().get::<Transform>(body).unwrap().translation;
    assert!(down.y < 0.9, "{down}");
}

#[test]
fn a_body_without_a_pose_is_refused_once_and_goes_on_as_particles() {
    let mut app = bare_app();
    let rope = app.world_mut().spawn((Rope::default(), RIGID)).id();
    tick(&mut app, 5);
    assert_eq!(heard(&app), [(rope, Refusal::Representation)]);
    assert!(app.world().resource::<SinewWorld>().simulation().compounds().is_empty());
}

#[test]
fn a_rigid_body_restored_from_its_components_goes_on_bit_for_bit() {
    let (mut app, _) = tumbling(RIGID);
    tick(&mut app, 40);
    let particles: Vec<(Entity, Particle)> = {
        let mut query = app.world_mut().query::<(Entity, &Particle)>();
        query.iter(app.world()).map(|(entity, particle)| (entity, *particle)).collect()
    };
    let clock = *app.world().resource::<SinewClock>();
    tick(&mut app, 60);
    let first = hash(&mut app);
    app.insert_resource(clock);
    for (entity, particle) in particles {
        app.world_mut().entity_mut(entity).insert(particle);
    }
    tick(&mut app, 60);
    assert_eq!(hash(&mut app), first);
}

/// A box that falls on another, which lies on the ground.
fn falling_on(representation: Representation) -> (App, [Entity; 2]) {
    let mut app = bare_app();
    app.world_mut().spawn(Ground);
    let size = Vec3::new(0.6, 0.4, 0.5);
    let mut add = |y| {
        let place = Transform::from_xyz(0.0, y, 0.0);
        let body = (RigidBox::new(size), representation, place, BodyReport::default());
        app.world_mut().spawn(body).id()
    };
    let bodies = [add(0.2), add(1.0)];
    (app, bodies)
}

#[test]
fn a_box_as_one_rigid_state_comes_to_rest_where_particles_do() {
    let (mut rods, as_rods) = falling_on(Representation::Particles);
    let (mut state, as_state) = falling_on(Representation::Auto);
    let sweeps = |app: &App, body| app.world().get::<BodyReport>(body).unwrap().sweeps;
    tick(&mut rods, 10);
    tick(&mut state, 10);
    assert!(sweeps(&rods, as_rods[1]) > 0, "rods are swept");
    assert_eq!(sweeps(&state, as_state[1]), 0, "of a rigid state there is nothing to sweep");
    tick(&mut rods, 230);
    tick(&mut state, 230);
    for (number, (a, b)) in as_rods.into_iter().zip(as_state).enumerate() {
        let (a, b) = (rods.world().get::<Transform>(a), state.world().get::<Transform>(b));
        let (a, b) = (a.unwrap(), b.unwrap());
        let off = a.translation.distance(b.translation);
        assert!(off < 1e-3, "box {number}: {off} m from {}", a.translation);
        assert!((b.translation.y - 0.2 - 0.4 * number as f32).abs() < 2e-3, "{}", b.translation);
        assert!(a.rotation.angle_between(b.rotation) < 2e-3, "box {number}: {}", b.rotation);
    }
}

#[test]
fn a_rigid_state_restored_from_a_snapshot_goes_on_bit_for_bit() {
    let (mut app, _) = falling_on(Representation::Auto);
    // In flight, at the impact, at rest.
    for before in [5, 20, 100] {
        tick(&mut app, before);
        let saved = SinewSnapshot::capture(app.world());
        let run = |app: &mut App| -> Vec<u64> {
            let hash_after_a_tick = |_| {
                tick(app, 1);
                SinewSnapshot::capture(app.world()).hash()
            };
            (0..40).map(hash_after_a_tick).collect()
        };
        let first = run(&mut app);
        saved.restore(app.world_mut()).unwrap();
        assert_eq!(run(&mut app), first, "saved {before} ticks later");
    }
}

#[test]
fn a_change_to_one_rigid_state_and_back_takes_effect_at_once() {
    let (mut app, body) = tumbling(Representation::Particles);
    app.world_mut().entity_mut(body).insert(BodyReport::default());
    let sweeps = |app: &App| app.world().get::<BodyReport>(body).unwrap().sweeps;
    tick(&mut app, 10);
    let (_, _, momentum, turning) = whole(&app, body);
    for (next, is_swept) in [
        (Representation::Auto, false),
        // As an explicit rigid body it is a shape constraint, which is swept.
        (RIGID, true),
        (Representation::Auto, false),
        (Representation::Particles, true),
    ] {
        app.world_mut().entity_mut(body).insert(next);
        tick(&mut app, 10);
        assert_eq!(sweeps(&app) > 0, is_swept, "{next:?}");
        let (_, _, a, b) = whole(&app, body);
        assert!((a - momentum).length() < 1e-4 * momentum.length(), "{next:?}: {a}");
        assert!((b - turning).length() < 1e-3 * turning.length(), "{next:?}: {b}");
    }
    app.world_mut().entity_mut(body).remove::<Representation>();
    tick(&mut app, 1);
    assert_eq!(sweeps(&app), 0, "without the component it is one rigid state");
}
