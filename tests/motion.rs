//! Motion is two-way: velocities are read off a body, and a body follows the velocities, forces and impulses that a game writes.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    Charge, ContactsDisabled, ControlForce, Drag, ExtractedVelocity, Inertia, Refusal,
    SinewSnapshot, TickForces,
};

use crate::support::{app, bits, hash, heard, particles_of, tick};

/// An app without gravity and without drag.
fn space() -> App {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO)).insert_resource(AirDrag(0.0));
    app
}

/// A box of 2 kg with its particles at the corners.
fn boxed() -> RigidBox {
    RigidBox::new(Vec3::new(1.0, 0.6, 0.4)).with_mass(2.0)
}

fn velocity(app: &App, body: Entity) -> Vec3 {
    app.world().get::<LinearVelocity>(body).unwrap().0
}

fn spin(app: &App, body: Entity) -> Vec3 {
    app.world().get::<AngularVelocity>(body).unwrap().0
}

#[track_caller]
fn assert_close(found: Vec3, expected: Vec3, what: &str) {
    let allowed = 1e-3 * expected.length().max(1.0);
    assert!((found - expected).length() < allowed, "{what}: {found} instead of {expected}");
}

#[test]
fn velocities_spawned_with_a_body_of_any_kind_are_its_initial_velocities() {
    let (along, about) = (Vec3::new(1.0, 2.0, -0.5), Vec3::new(0.0, 1.5, 0.0));
    let spawns: [fn(&mut World) -> Entity; 5] = [
        |w| w.spawn(boxed()).id(),
        |w| w.spawn(Rope { pin_start: false, ..Rope::between(Vec3::ZERO, Vec3::X) }).id(),
        |w| w.spawn(Cloth::grid(1.0, 1.0, 4, 4)).id(),
        |w| w.spawn(SoftBody::cuboid(Vec3::ONE, UVec3::splat(3))).id(),
        |w| w.spawn(Ragdoll::default()).id(),
    ];
    for spawn in spawns {
        let mut app = space();
        app.insert_resource(AirDrag(0.0));
        let body = spawn(app.world_mut());
        app.world_mut().entity_mut(body).insert((
            LinearVelocity(along),
            AngularVelocity(about),
            ContactsDisabled,
        ));
        tick(&mut app, 2);
        assert!((velocity(&app, body) - along).length() < 0.02, "{}", velocity(&app, body));
        assert!((spin(&app, body) - about).length() < 0.1, "{}", spin(&app, body));
        assert_eq!(heard(&app), []);
    }
}

#[test]
fn a_velocity_written_by_a_game_is_followed_and_leaves_the_other_one_unchanged() {
    let mut app = space();
    let body = app.world_mut().spawn((boxed(), AngularVelocity(Vec3::Y * 2.0))).id();
    tick(&mut app, 5);
    app.world_mut().get_mut::<LinearVelocity>(body).unwrap().0.x += 3.0;
    tick(&mut app, 10);
    assert_close(velocity(&app, body), Vec3::X * 3.0, "set");
    assert_close(spin(&app, body), Vec3::Y * 2.0, "kept");
    app.world_mut().get_mut::<AngularVelocity>(body).unwrap().0 = Vec3::ZERO;
    tick(&mut app, 10);
    assert_close(velocity(&app, body), Vec3::X * 3.0, "kept");
    assert_close(spin(&app, body), Vec3::ZERO, "set");
    // Each tick, as a character controller writes it.
    app.add_systems(FixedUpdate, |mut all: Query<&mut LinearVelocity>| {
        all.iter_mut().for_each(|mut velocity| velocity.0.z += 1.0 / 60.0);
    });
    tick(&mut app, 60);
    assert_close(velocity(&app, body), Vec3::new(3.0, 0.0, 1.0), "accelerated");
}

/// Regression: the component was silently ignored on a single particle, where a new user threw a ball with it.
#[test]
fn a_single_particle_follows_its_linear_velocity_too() {
    let mut app = app();
    app.insert_resource(AirDrag(0.0));
    let thrown = LinearVelocity(Vec3::new(2.0, 5.0, 0.0));
    let ball = app.world_mut().spawn((Particle::at(Vec3::ZERO), Mass(0.5), thrown)).id();
    let own = Particle::at(Vec3::Z).with_velocity(Vec3::X);
    let other = app.world_mut().spawn((own, LinearVelocity::default())).id();
    tick(&mut app, 30);
    let time = 0.5;
    let place = app.world().get::<Particle>(ball).unwrap().position;
    assert_close(place, Vec3::new(1.0, 5.0 * time - 0.5 * 9.81 * time * time, 0.0), "a parabola");
    assert_close(velocity(&app, ball), Vec3::new(2.0, 5.0 - 9.81 * time, 0.0), "read off it");
    assert_close(velocity(&app, other), Vec3::new(1.0, -9.81 * time, 0.0), "it keeps its own");
    app.world_mut().get_mut::<LinearVelocity>(ball).unwrap().0 = Vec3::Y * 3.0;
    let saved = SinewSnapshot::capture(app.world());
    tick(&mut app, 60);
    assert_close(velocity(&app, ball), Vec3::Y * (3.0 - 9.81), "written");
    let first = hash(&mut app);
    saved.restore(app.world_mut()).unwrap();
    tick(&mut app, 60);
    assert_eq!(hash(&mut app), first);
    app.world_mut().resource_mut::<SinewControl>().pause();
    let own = Particle::at(Vec3::X).with_velocity(Vec3::Z);
    let late = app.world_mut().spawn((own, LinearVelocity::default())).id();
    tick(&mut app, 2);
    assert_eq!(velocity(&app, late), Vec3::Z, "read off it while time stands still");
    app.world_mut().get_mut::<LinearVelocity>(ball).unwrap().0.x = f32::INFINITY;
    tick(&mut app, 1);
    assert!(velocity(&app, ball).is_finite(), "refused");
    assert!(matches!(heard(&app)[..], [(entity, Refusal::Edit(_))] if entity == ball));
}

#[test]
fn a_velocity_that_is_not_finite_is_refused_and_the_body_goes_on() {
    let mut app = space();
    let body = app.world_mut().spawn((boxed(), LinearVelocity(Vec3::X))).id();
    tick(&mut app, 5);
    app.world_mut().get_mut::<LinearVelocity>(body).unwrap().0.y = f32::NAN;
    tick(&mut app, 5);
    assert_close(velocity(&app, body), Vec3::X, "as before");
    let refusals = heard(&app);
    assert!(matches!(refusals[..], [(entity, Refusal::Edit(_))] if entity == body), "{refusals:?}");
}

#[test]
fn velocities_marked_as_changed_but_equal_change_no_bit() {
    let run = |touched: bool| {
        let mut app = app();
        app.world_mut().spawn(Ground);
        app.world_mut().spawn((boxed(), Transform::from_xyz(0.0, 1.0, 0.0)));
        app.world_mut().spawn((Ragdoll::default(), Transform::from_xyz(3.0, 1.0, 0.0)));
        if touched {
            app.add_systems(FixedUpdate, |mut all: Query<&mut LinearVelocity>| {
                all.iter_mut().for_each(|mut velocity| velocity.set_changed());
            });
        }
        tick(&mut app, 60);
        hash(&mut app)
    };
    assert_eq!(run(false), run(true));
}

#[test]
fn forces_torques_and_impulses_on_a_box_follow_newton_and_euler() {
    let mut app = space();
    let world = app.world_mut();
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    let force = world.spawn((boxed(), at(0.0), ExternalForce(Vec3::Z * 4.0))).id();
    let torque = world.spawn((boxed(), at(5.0), ExternalTorque(Vec3::Y * 0.3))).id();
    let off = ControlForce::new(Vec3::Z * 4.0).at(Vec3::new(10.5, 0.0, 0.0));
    let off_centre = world.spawn((boxed(), at(10.0), off)).id();
    let push = ExternalImpulse::new(Vec3::Z * 4.0).at(Vec3::new(15.5, 0.0, 0.0));
    let pushed = world.spawn((boxed(), at(15.0), push)).id();
    let spun = world.spawn((boxed(), at(20.0), ExternalImpulse::angular(Vec3::Y * 0.3))).id();
    tick(&mut app, 1);
    let inertia = app.world().get::<Inertia>(torque).unwrap().0;
    let turned = |moment: Vec3| inertia.inverse() * moment;
    // One tick of 1/60 s: v = F t/m, ω = J⁻¹ M t. An impulse acts once: v = P/m, ω = J⁻¹ r × P.
    let t = 1.0 / 60.0;
    assert_close(velocity(&app, force) * 60.0, Vec3::Z * 2.0, "force");
    assert_close(spin(&app, torque) * 60.0, turned(Vec3::Y * 0.3), "torque");
    assert_close(velocity(&app, off_centre) / t, Vec3::Z * 2.0, "force at a point");
    assert_close(spin(&app, off_centre) / t, turned(Vec3::Y * -2.0), "its lever");
    assert_close(velocity(&app, pushed), Vec3::Z * 2.0, "impulse at a point");
    assert_close(spin(&app, pushed), turned(Vec3::Y * -2.0), "its lever");
    assert_close(spin(&app, spun), turned(Vec3::Y * 0.3), "angular impulse");
    tick(&mut app, 5);
    assert_close(velocity(&app, pushed), Vec3::Z * 2.0, "once");
    assert_eq!(*app.world().get::<ExternalImpulse>(pushed).unwrap(), default());
    assert_close(velocity(&app, force), Vec3::Z * 2.0 * 6.0 * t, "steadily");
}

#[test]
fn force_commands_act_for_one_tick_and_add_up() {
    let mut app = space();
    let body = app.world_mut().spawn(boxed()).id();
    tick(&mut app, 2);
    let mut commands = app.world_mut().commands();
    commands.entity(body).apply_force(Vec3::X * 60.0).apply_force(Vec3::X * 60.0);
    commands.entity(body).apply_force_at(Vec3::Z * 60.0, Vec3::X * 0.5).apply_torque(Vec3::X);
    let inertia = app.world().get::<Inertia>(body).unwrap().0;
    // While forces act, the reported velocity is that of the middle of a substep and off by half a kick, so it is read a tick later.
    tick(&mut app, 2);
    let t = 1.0 / 60.0;
    assert_close(velocity(&app, body), Vec3::new(1.0, 0.0, 0.5), "two and one");
    let expected = inertia.inverse() * (Vec3::X + Vec3::new(0.0, -30.0, 0.0)) * t;
    assert!((spin(&app, body) - expected).length() < 0.05 * expected.length(), "{expected}");
    tick(&mut app, 5);
    assert_close(velocity(&app, body), Vec3::new(1.0, 0.0, 0.5), "for one tick");
    assert_eq!(*app.world().get::<TickForces>(body).unwrap(), default());
}

#[test]
fn a_limb_and_a_loose_particle_are_pushed_as_a_body_is() {
    let mut app = space();
    let figure = app.world_mut().spawn(Ragdoll::default()).id();
    let ball = (Particle::at(Vec3::X * 5.0), Mass(0.5), ExternalImpulse::new(Vec3::Y));
    let ball = app.world_mut().spawn(ball).id();
    tick(&mut app, 1);
    assert_close(app.world().get::<Particle>(ball).unwrap().velocity, Vec3::Y * 2.0, "a ball");
    let limb = app.world().get::<bevy_sinew::BodyParts>(figure).unwrap().iter().next().unwrap();
    app.world_mut().entity_mut(limb).insert(ExternalImpulse::new(Vec3::Z * 75.0));
    tick(&mut app, 1);
    assert_close(velocity(&app, figure), Vec3::Z, "the figure has the momentum");
    assert_eq!(heard(&app), []);
}

#[test]
fn properties_of_a_body_are_shared_out_onto_its_particles() {
    let mut app = space();
    let properties = (Mass(8.0), Radius(0.03), Charge(2.0), Drag(0.25));
    let body = app.world_mut().spawn((boxed(), properties)).id();
    tick(&mut app, 1);
    let sums = |app: &App| {
        let own = particles_of(app, body);
        let of = |f: fn(&World, Entity) -> f32| {
            own.iter().map(|&one| f(app.world(), one)).sum::<f32>() / own.len() as f32
        };
        let count = own.len() as f32;
        (
            of(|w, p| w.get::<Mass>(p).unwrap().0) * count,
            of(|w, p| w.get::<Radius>(p).unwrap().0),
            of(|w, p| w.get::<Charge>(p).unwrap().0) * count,
            of(|w, p| w.get::<Drag>(p).unwrap().0),
        )
    };
    let near = |found: (f32, f32, f32, f32), expected: (f32, f32, f32, f32)| {
        let pairs = [
            (found.0, expected.0),
            (found.1, expected.1),
            (found.2, expected.2),
            (found.3, expected.3),
        ];
        assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
    };
    near(sums(&app), (8.0, 0.03, 2.0, 0.25));
    // The distribution stays that of the recipe: the same inertia per mass as before.
    let inertia = app.world().get::<Inertia>(body).unwrap().0;
    let plain = app.world_mut().spawn((boxed(), Transform::from_xyz(0.0, 9.0, 0.0))).id();
    tick(&mut app, 1);
    let two = app.world().get::<Inertia>(plain).unwrap().0;
    assert!(inertia.abs_diff_eq(two * 4.0, 1e-3), "{inertia} {two}");
    app.world_mut().get_mut::<Mass>(body).unwrap().0 = 3.0;
    app.world_mut().get_mut::<Drag>(body).unwrap().0 = 0.5;
    tick(&mut app, 1);
    near(sums(&app), (3.0, 0.03, 2.0, 0.5));
    app.world_mut().get_mut::<Mass>(body).unwrap().0 = -1.0;
    tick(&mut app, 3);
    near(sums(&app), (3.0, 0.03, 2.0, 0.5));
    let refused = heard(&app);
    assert!(matches!(refused[..], [(one, Refusal::Body(_))] if one == body), "{refused:?}");
}

#[test]
fn a_restored_body_is_not_pushed_again() {
    let run = |restores: bool| {
        let mut app = app();
        app.world_mut().spawn(Ground);
        let properties = (Mass(4.0), LinearVelocity(Vec3::X), ExternalImpulse::new(Vec3::Y));
        let at = Transform::from_xyz(0.0, 1.0, 0.0);
        let body = app.world_mut().spawn((boxed(), at, properties)).id();
        let mut seen = Vec::new();
        for _ in 0..20 {
            tick(&mut app, 1);
            if restores {
                // As in a rollback: every component is inserted anew with its present value.
                let world = app.world_mut();
                let mut own = world.entity_mut(body);
                let state = (
                    *own.get::<Mass>().unwrap(),
                    *own.get::<LinearVelocity>().unwrap(),
                    *own.get::<AngularVelocity>().unwrap(),
                    *own.get::<ExtractedVelocity>().unwrap(),
                    *own.get::<ExternalImpulse>().unwrap(),
                    *own.get::<Transform>().unwrap(),
                );
                own.insert(state);
            }
            let own = particles_of(&app, body);
            seen.extend(own.iter().map(|&one| bits(app.world().get::<Particle>(one).unwrap())));
        }
        seen
    };
    assert_eq!(run(false), run(true));
}
