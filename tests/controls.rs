//! Control forces accelerate bodies by F/m and τ/I, with the inertia that is read back.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BoxParticles, ConstraintOf, ContactsDisabled, ControlForce, EditFault, Inertia, Refusal,
    Representation, SinewSnapshot, WorldCenterOfMass,
};

use crate::commands::{brick, space};
use crate::snapshot::clear;
use crate::support::{hash, heard, tick};

/// Of the brick of 1 × 2 × 3 m and 6 kg about its axes, kg·m².
const INERTIA: Vec3 = Vec3::new(6.5, 5.0, 2.5);

fn linear(app: &App, body: Entity) -> Vec3 {
    app.world().get::<LinearVelocity>(body).unwrap().0
}

fn spin(app: &App, body: Entity) -> Vec3 {
    app.world().get::<AngularVelocity>(body).unwrap().0
}

/// Length of a tick, seconds.
fn tick_seconds(app: &App) -> f32 {
    app.world().resource::<Time<Fixed>>().timestep().as_secs_f32()
}

#[test]
fn a_force_accelerates_by_force_over_mass_from_the_first_tick_and_turns_nothing() {
    let mut app = space();
    let force = Vec3::new(3.0, -12.0, 1.5);
    let body = app.world_mut().spawn((brick(), ControlForce::new(force))).id();
    tick(&mut app, 60);
    let expected = force / 6.0 * 60.0 * tick_seconds(&app);
    let (velocity, spin) = (linear(&app, body), spin(&app, body));
    assert!(velocity.abs_diff_eq(expected, 1e-3), "{velocity} {expected}");
    assert!(spin.length() < 1e-3, "{spin}");
    assert_eq!(heard(&app), []);
}

#[test]
fn a_torque_accelerates_by_torque_over_inertia_as_particles_and_as_a_rigid_body() {
    for rigid in [false, true] {
        for (axis, inertia) in Vec3::AXES.into_iter().zip(INERTIA.to_array()) {
            let mut app = space();
            let body = app.world_mut().spawn(brick()).id();
            if rigid {
                app.world_mut().entity_mut(body).insert(Representation::Rigid(default()));
            }
            app.world_mut().spawn(ControlForce::torque(axis * 2.0).on(body));
            tick(&mut app, 60);
            let expected = axis * (2.0 / inertia * 60.0 * tick_seconds(&app));
            let found = spin(&app, body);
            assert!(
                found.abs_diff_eq(expected, 0.01 * expected.length()),
                "{rigid}: {found} {expected}"
            );
            assert!(linear(&app, body).length() < 1e-3);
        }
    }
}

#[test]
fn a_force_at_a_point_has_its_lever_and_a_local_one_turns_with_the_body() {
    let mut app = space();
    let turned = Transform::from_xyz(10.0, 0.0, 0.0)
        .with_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_2));
    let body = app.world_mut().spawn((brick(), turned)).id();
    tick(&mut app, 1);
    // Along the body's x, which is the world's y, half a metre off along the body's z.
    let thrust = ControlForce::new(Vec3::X * 6.0).on(body).at(Vec3::Z * 0.5).local();
    app.world_mut().spawn(thrust);
    tick(&mut app, 3);
    let seconds = 3.0 * tick_seconds(&app);
    let (velocity, found) = (linear(&app, body), spin(&app, body));
    assert!(velocity.abs_diff_eq(Vec3::Y * seconds, 1e-3), "{velocity}");
    // (0, 0, ½) × (0, 6, 0) N·m about the world's x, which is the body's -y.
    let expected = Vec3::X * (-3.0 / 5.0 * seconds);
    assert!(found.abs_diff_eq(expected, 1e-3), "{found} {expected}");

    // The same in the world's frame.
    let other = app.world_mut().spawn((brick(), Transform::from_xyz(-10.0, 0.0, 0.0))).id();
    let at = Vec3::new(-10.0, 0.0, 0.5);
    app.world_mut().spawn(ControlForce::new(Vec3::X * 6.0).on(other).at(at));
    tick(&mut app, 3);
    let (velocity, found) = (linear(&app, other), spin(&app, other));
    assert!(velocity.abs_diff_eq(Vec3::X * seconds, 1e-3), "{velocity}");
    assert!(found.abs_diff_eq(Vec3::Y * (3.0 / 5.0 * seconds), 1e-3), "{found}");
}

#[test]
fn a_control_is_steered_while_time_runs_and_acts_on_particles_too() {
    let mut app = space();
    let stone = app.world_mut().spawn((Particle::at(Vec3::ZERO), Mass(2.0))).id();
    let hand = app.world_mut().spawn(ControlForce::new(Vec3::X * 4.0).on(stone)).id();
    let velocity = |app: &App| app.world().get::<Particle>(stone).unwrap().velocity;
    tick(&mut app, 30);
    let seconds = 30.0 * tick_seconds(&app);
    let first = velocity(&app);
    assert!((first.x - 2.0 * seconds).abs() < 0.03, "{first}");
    app.world_mut().get_mut::<ControlForce>(hand).unwrap().force = Vec3::Y;
    tick(&mut app, 30);
    let second = velocity(&app);
    assert!((second.y - 0.5 * seconds).abs() < 0.03 && (second.x - first.x).abs() < 0.03);
    app.world_mut().despawn(hand);
    let third = velocity(&app);
    tick(&mut app, 30);
    assert!((velocity(&app) - third).length() < 0.03, "let go of");
    assert!(app.world().resource::<SinewWorld>().simulation().forces.controls.is_empty());
}

#[test]
fn controls_have_names_and_are_in_the_order_of_creation() {
    let mut app = space();
    let body = app.world_mut().spawn(brick()).id();
    // Different archetypes, which a query visits one after the other.
    app.world_mut().spawn((Name::new("left"), ControlForce::new(Vec3::X).on(body)));
    app.world_mut().spawn((
        Name::new("middle"),
        Visibility::default(),
        ControlForce::default().on(body),
    ));
    app.world_mut().spawn((Name::new("right"), ControlForce::new(Vec3::X).on(body)));
    tick(&mut app, 2);
    let controls = &app.world().resource::<SinewWorld>().simulation().forces.controls;
    let names: Vec<&str> = controls.iter().map(|control| control.name.as_str()).collect();
    assert_eq!(names, ["left", "middle", "right"]);
    assert!(controls.iter().all(|control| control.rows == (0..8).collect::<Vec<u32>>()));
}

#[test]
fn a_bad_control_is_refused_once_and_the_rest_goes_on_bit_for_bit() {
    let run = |with_bad_ones: bool| {
        let mut app = space();
        let body = app.world_mut().spawn(brick()).id();
        app.world_mut().spawn(ControlForce::torque(Vec3::Y).on(body));
        let mut bad = Vec::new();
        if with_bad_ones {
            let rock = app.world_mut().spawn_empty().id();
            let gone = app.world_mut().spawn_empty().id();
            app.world_mut().despawn(gone);
            let nan = Vec3::splat(f32::NAN);
            let finite = ControlForce::new(Vec3::X);
            for control in [
                ControlForce::new(nan).on(body),
                ControlForce::torque(nan).on(body),
                finite.on(body).at(nan),
                finite.on(rock),
                finite.on(gone),
                finite,
            ] {
                bad.push(app.world_mut().spawn(control).id());
            }
        }
        tick(&mut app, 20);
        let refused = heard(&app);
        assert_eq!(refused.len(), bad.len(), "once each: {refused:?}");
        for ((entity, reason), (i, bad)) in refused.into_iter().zip(bad.into_iter().enumerate()) {
            let fault = if i < 3 { EditFault::NotFinite } else { EditFault::NoParticles };
            assert_eq!((entity, reason), (bad, Refusal::Control(fault)));
        }
        hash(&mut app)
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn a_control_whose_body_is_despawned_is_refused_once_unless_it_goes_with_it() {
    let mut app = space();
    let body = app.world_mut().spawn(brick()).id();
    let left = app.world_mut().spawn(ControlForce::new(Vec3::X).on(body)).id();
    app.world_mut().spawn((ControlForce::new(Vec3::X).on(body), ConstraintOf(body)));
    tick(&mut app, 5);
    app.world_mut().despawn(body);
    tick(&mut app, 5);
    assert_eq!(heard(&app), [(left, Refusal::Control(EditFault::NoParticles))]);
}

#[test]
fn a_rollback_under_control_goes_the_same_way_again() {
    let mut app = space();
    let body = app.world_mut().spawn(brick()).id();
    let thrust = ControlForce::new(Vec3::Y * 9.0).on(body).at(Vec3::X * 0.3).local();
    app.world_mut().spawn(thrust);
    tick(&mut app, 20);
    let saved = SinewSnapshot::capture(app.world());
    tick(&mut app, 20);
    let first = hash(&mut app);
    saved.restore(app.world_mut()).unwrap();
    tick(&mut app, 20);
    assert_eq!(hash(&mut app), first);
    clear(app.world_mut());
    saved.restore(app.world_mut()).unwrap();
    tick(&mut app, 20);
    assert_eq!(hash(&mut app), first, "under new ids");
}

#[test]
fn the_inertia_read_back_is_the_solid_boxs_and_turns_with_it() {
    let mut app = space();
    let rotation = Quat::from_euler(EulerRot::XYZ, 0.3, -1.1, 2.0);
    let at = |rotation| Transform::from_xyz(900.0, 5.0, 0.0).with_rotation(rotation);
    // All in the same place.
    let alone = ContactsDisabled;
    let straight = app.world_mut().spawn((brick(), alone, at(Quat::IDENTITY))).id();
    let turned = app.world_mut().spawn((brick(), alone, at(rotation))).id();
    let corners = RigidBox { particles: BoxParticles::Corners, ..brick() };
    let corners = app.world_mut().spawn((corners, alone, at(Quat::IDENTITY))).id();
    tick(&mut app, 1);
    let read = |entity| app.world().get::<Inertia>(entity).unwrap().0;
    let solid = Mat3::from_diagonal(INERTIA);
    assert!(read(straight).abs_diff_eq(solid, 1e-4), "{}", read(straight));
    assert!(read(corners).abs_diff_eq(solid * 3.0, 1e-3), "{}", read(corners));
    let turn = Mat3::from_quat(rotation);
    let expected = turn * solid * turn.transpose();
    assert!(read(turned).abs_diff_eq(expected, 1e-3), "{} {expected}", read(turned));
    assert!((app.world().get::<WorldCenterOfMass>(turned).unwrap().mass - 6.0).abs() < 1e-5);
}
