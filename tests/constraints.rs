//! Every constraint of the solver is a component: what it does, that it can be added, changed and removed while time runs, and how it is refused.

use core::f32::consts::PI;
use core::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::sinew::ConstraintFault;
use bevy_sinew::sinew::constraints::{Area, Bend, Cone, Rigid, Tetrahedron, Volume};
use bevy_sinew::{AngleConstraint, HingeConstraint, Refusal, VolumeConstraint};
use bevy_sinew::{
    AreaConstraint, BendConstraint, CollinearConstraint, ConeConstraint, CoplanarConstraint,
    PatchConstraint, RigidConstraint, SizeCorrection, TetrahedronConstraint,
};

use crate::bad_input::{nail, refused};
use crate::support::{app, busy_scene, forget, hash_of, heard, position, tick};

/// The faces of a tetrahedron `[a, b, c, d]`, counter-clockwise from outside.
pub(crate) const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// An app without gravity.
fn still_app() -> App {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    app
}

/// Loose particles at rest.
fn particles<const N: usize>(app: &mut App, places: [Vec3; N]) -> [Entity; N] {
    places.map(|place| app.world_mut().spawn(Particle::at(place)).id())
}

fn pin(app: &mut App, particle: Entity) {
    app.world_mut().entity_mut(particle).insert(Pinned::HERE);
}

/// A rigid distance constraint between two particles at their present distance.
fn rod(app: &mut App, a: Entity, b: Entity) {
    let length = position(app, a).distance(position(app, b));
    app.world_mut().spawn(DistanceConstraint::new(a, b, length));
}

fn places<const N: usize>(app: &App, particles: [Entity; N]) -> [Vec3; N] {
    particles.map(|particle| position(app, particle))
}

#[test]
fn an_elbow_stops_at_its_limit() {
    let fall = |limit: Option<f32>| {
        let mut app = app();
        let arm = particles(&mut app, [Vec3::Y, Vec3::ZERO, Vec3::X]);
        (0..2).for_each(|i| pin(&mut app, arm[i]));
        rod(&mut app, arm[1], arm[2]);
        if let Some(max) = limit {
            app.world_mut().spawn(AngleConstraint::new(arm, 0.5, max));
        }
        let angles = (0..240).map(|_| {
            tick(&mut app, 1);
            position(&app, arm[2]).angle_between(Vec3::Y)
        });
        angles.fold(0.0, f32::max)
    };
    assert!(fall(None) > 3.0, "it swings through");
    let most = fall(Some(2.0));
    assert!((most - 2.0).abs() < 0.01, "{most}");
}

#[test]
fn a_knee_folds_one_way_and_not_the_other() {
    let kick = |speed: f32| {
        let mut app = still_app();
        let knee = particles(&mut app, [Vec3::Y, Vec3::ZERO, Vec3::Z, Vec3::NEG_Y]);
        (0..3).for_each(|i| pin(&mut app, knee[i]));
        rod(&mut app, knee[1], knee[3]);
        rod(&mut app, knee[2], knee[3]);
        app.world_mut().spawn(HingeConstraint::new(knee, 0.5, PI));
        app.world_mut().get_mut::<Particle>(knee[3]).unwrap().set_velocity(Vec3::X * speed);
        tick(&mut app, 90);
        position(&app, knee[3])
    };
    let straight = kick(2.0);
    assert!(straight.abs_diff_eq(Vec3::NEG_Y, 0.02), "{straight}");
    // From 180° to half a radian short of the thigh, on the side of -x.
    let folded = kick(-2.0);
    assert!(folded.abs_diff_eq(Vec3::new(-0.479, 0.878, 0.0), 0.05), "{folded}");
}

#[test]
fn a_shoulder_stays_in_its_cone() {
    let mut app = still_app();
    let [o, x, y, hand] = particles(&mut app, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]);
    [o, x, y].into_iter().for_each(|particle| pin(&mut app, particle));
    rod(&mut app, o, hand);
    let cone = Cone::about(Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, 0.6).unwrap();
    app.world_mut().spawn(ConeConstraint::from_kind([o, x, y, hand], &cone));
    app.world_mut().get_mut::<Particle>(hand).unwrap().set_velocity(Vec3::new(1.0, 2.0, 0.0));
    let mut widest = 0.0_f32;
    for _ in 0..120 {
        tick(&mut app, 1);
        widest = widest.max(position(&app, hand).angle_between(Vec3::Z));
    }
    assert!((widest - 0.6).abs() < 0.01, "{widest}");
}

#[test]
fn areas_and_volumes_grow_to_their_rest_sizes() {
    let mut app = still_app();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let triangle = particles(&mut app, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    let patch = particles(&mut app, corners);
    let (tetrahedron, mesh) = (particles(&mut app, corners), particles(&mut app, corners));
    let world = app.world_mut();
    world.spawn(AreaConstraint::new(triangle, 0.8));
    world.spawn(PatchConstraint::new(patch, FACES, 3.0));
    world.spawn(TetrahedronConstraint::new(tetrahedron, 0.3));
    world.spawn(VolumeConstraint::new(mesh, FACES, 0.3).with_correction(SizeCorrection::Scaling));
    tick(&mut app, 10);
    let close = |found: f32, meant: f32| assert!((found - meant).abs() < 1e-3, "{found} {meant}");
    close(Area::of(places(&app, triangle)).rest, 0.8);
    let patch = places(&app, patch);
    close(FACES.map(|face| Area::of(face.map(|i| patch[i as usize])).rest).iter().sum(), 3.0);
    close(Tetrahedron::of(places(&app, tetrahedron)).rest, 0.3);
    close(Volume::of(FACES, &places(&app, mesh)).rest, 0.3);
    assert_eq!(heard(&app), []);
}

/// Drops an octahedron whose edges are springs onto the ground. Returns its least volume on the way, as a share of the initial volume.
fn least_volume_of_a_ball(kept: bool) -> f32 {
    let mut app = app();
    app.world_mut().spawn(Ground);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let corners = [axes, axes.map(|axis| -axis)].concat();
    let corners: [Vec3; 6] = core::array::from_fn(|i| corners[i] * 0.5 + Vec3::Y);
    let ball = particles(&mut app, corners);
    for i in 0..6 {
        for j in (i + 1..6).filter(|j| j - i != 3) {
            app.world_mut().spawn(Spring::new(ball[i], ball[j], 0.5 * 2_f32.sqrt(), 150.0));
        }
    }
    let faces =
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let whole = Volume::of(faces, &corners).rest;
    if kept {
        app.world_mut().spawn(VolumeConstraint::new(ball, faces, whole));
    }
    let shares = (0..120).map(|_| {
        tick(&mut app, 1);
        Volume::of(faces, &places(&app, ball)).rest / whole
    });
    shares.fold(1.0, f32::min)
}

#[test]
fn a_ball_keeps_its_volume_when_it_falls() {
    let (kept, squashed) = (least_volume_of_a_ball(true), least_volume_of_a_ball(false));
    assert!(kept > 0.99 && squashed < 0.8, "{kept} {squashed}");
}

#[test]
fn a_shelf_does_not_bend() {
    let end = |bends: bool| {
        let mut app = app();
        let corners = [Vec3::ZERO, Vec3::Z, Vec3::new(-1.0, 0.0, 0.5), Vec3::new(1.0, 0.0, 0.5)];
        let shelf = particles(&mut app, corners);
        (0..3).for_each(|i| pin(&mut app, shelf[i]));
        (0..2).for_each(|i| rod(&mut app, shelf[i], shelf[3]));
        if !bends {
            let bend = Bend::of(corners).unwrap();
            app.world_mut().spawn(BendConstraint::from_kind(shelf, &bend));
        }
        tick(&mut app, 30);
        position(&app, shelf[3]).y
    };
    assert!(end(true) < -0.5 && end(false).abs() < 0.01, "{} {}", end(true), end(false));
}

#[test]
fn a_plane_a_line_and_a_rigid_shape_are_kept() {
    let mut app = still_app();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.5)];
    let (plane, rigid) = (particles(&mut app, corners), particles(&mut app, corners));
    let line = particles(&mut app, [Vec3::ZERO, Vec3::new(1.0, 0.3, 0.0), Vec3::X * 2.0]);
    let world = app.world_mut();
    world.spawn(CoplanarConstraint::new(plane));
    world.spawn(CollinearConstraint::new(line));
    world.spawn(RigidConstraint::from_kind(rigid, &Rigid::of(corners)));
    world.get_mut::<Particle>(rigid[3]).unwrap().set_velocity(Vec3::new(1.0, -2.0, 3.0));
    tick(&mut app, 60);
    assert!(Tetrahedron::of(places(&app, plane)).rest.abs() < 1e-4);
    assert!(Area::of(places(&app, line)).rest < 1e-4);
    let now = places(&app, rigid);
    assert!(now[3].distance(corners[3]) > 0.3, "it was kicked, and flies");
    for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        let (meant, found) = (corners[i].distance(corners[j]), now[i].distance(now[j]));
        assert!((meant - found).abs() < 2e-3, "{i} {j}: {meant} {found}");
    }
}

#[test]
fn a_constraint_acts_from_the_tick_after_it_was_added_until_it_is_removed() {
    let mut app = still_app();
    let triangle = particles(&mut app, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    tick(&mut app, 1);
    let area = |app: &mut App| {
        tick(app, 1);
        (Area::of(places(app, triangle)).rest * 100.0).round() / 100.0
    };
    let constraint = app.world_mut().spawn(AreaConstraint::new(triangle, 0.6)).id();
    assert_eq!(area(&mut app), 0.6, "added");
    app.world_mut().get_mut::<AreaConstraint>(constraint).unwrap().rest = 0.7;
    assert_eq!(area(&mut app), 0.7, "changed");
    let count = |app: &App| app.world().resource::<SinewWorld>().simulation().constraints().len();
    assert_eq!(count(&app), 1);
    app.world_mut().entity_mut(constraint).remove::<AreaConstraint>();
    tick(&mut app, 1);
    assert_eq!(count(&app), 0, "removed");
    app.world_mut().entity_mut(constraint).insert(AreaConstraint::new(triangle, 0.6));
    tick(&mut app, 1);
    // Ten frames a tick: Bevy drops the record of a removed component long before the tick.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(1700)));
    app.update();
    app.world_mut().despawn(constraint);
    tick(&mut app, 2);
    assert_eq!(count(&app), 0, "despawned, at a high frame rate");
    assert_eq!(heard(&app), []);
}

#[test]
fn a_constraint_whose_particle_is_gone_is_named_once_and_affects_nothing_else() {
    let missing = Refusal::Constraint(ConstraintFault::MissingParticle);
    refused(missing.clone(), |world| {
        let nails = [0.0, 1.0, 2.0].map(|x| nail(world, x));
        world.despawn(nails[1]);
        world.spawn(AngleConstraint::new(nails, 0.0, 1.0)).id()
    });
    // While time runs, and again only after the constraint was repaired and broke anew.
    let run = |lost: bool| {
        let mut app = app();
        let bodies = busy_scene(&mut app);
        let nails = [0.0, 1.0, 2.0].map(|x| nail(app.world_mut(), x));
        let constraint = app.world_mut().spawn(AngleConstraint::new(nails, 0.0, 1.0)).id();
        tick(&mut app, 10);
        if lost {
            app.world_mut().despawn(nails[2]);
            tick(&mut app, 20);
            assert_eq!(heard(&app), [(constraint, missing.clone())]);
            forget(&mut app);
            let other = nail(app.world_mut(), 3.0);
            app.world_mut().get_mut::<AngleConstraint>(constraint).unwrap().particles[2] = other;
            tick(&mut app, 10);
            assert_eq!(heard(&app), []);
            app.world_mut().despawn(other);
            tick(&mut app, 10);
            assert_eq!(heard(&app), [(constraint, missing.clone())]);
        } else {
            tick(&mut app, 40);
        }
        hash_of(&app, &bodies)
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn a_constraint_waits_silently_for_a_particle_that_is_set_aside() {
    let mut app = still_app();
    let triangle = particles(&mut app, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    app.world_mut().spawn(AreaConstraint::new(triangle, 0.7));
    app.world_mut().get_mut::<Mass>(triangle[0]).unwrap().0 = -1.0;
    tick(&mut app, 5);
    assert_eq!(
        heard(&app).into_iter().map(|(entity, _)| entity).collect::<Vec<_>>(),
        [triangle[0]]
    );
    app.world_mut().get_mut::<Mass>(triangle[0]).unwrap().0 = 1.0;
    tick(&mut app, 5);
    assert!((Area::of(places(&app, triangle)).rest - 0.7).abs() < 1e-3);
    assert_eq!(heard(&app).len(), 1);
}

#[test]
fn a_constraint_with_a_broken_number_is_named_once() {
    let refused = |fault, spawn: fn(&mut World, [Entity; 4]) -> Entity| {
        refused(Refusal::Constraint(fault), |world| {
            let nails = [0.0, 1.0, 2.0, 3.0].map(|x| nail(world, x));
            spawn(world, nails)
        });
    };
    use ConstraintFault::{Count, Limits, Number, SameParticle, Softness as Soft, Triangle};
    const NAN: f32 = f32::NAN;
    refused(Number, |w, [a, b, c, _]| w.spawn(AngleConstraint::new([a, b, c], NAN, 1.0)).id());
    refused(Limits, |w, [a, b, c, _]| w.spawn(AngleConstraint::new([a, b, c], 1.0, 0.5)).id());
    refused(SameParticle, |w, [a, b, ..]| w.spawn(AngleConstraint::new([a, b, a], 0.0, 1.0)).id());
    refused(Number, |w, all| w.spawn(HingeConstraint::new(all, 0.0, NAN)).id());
    refused(Number, |w, all| w.spawn(ConeConstraint::new(all, Vec3::ZERO, 1.0)).id());
    refused(Count, |w, [a, b, ..]| w.spawn(ConeConstraint::new([a, b], Vec3::X, 1.0)).id());
    refused(Number, |w, [a, b, c, _]| w.spawn(AreaConstraint::new([a, b, c], NAN)).id());
    refused(Number, |w, all| w.spawn(PatchConstraint::new(all, FACES, -1.0)).id());
    refused(Number, |w, all| w.spawn(TetrahedronConstraint::new(all, NAN)).id());
    refused(Triangle, |w, all| w.spawn(VolumeConstraint::new(all, [[0, 1, 9]], 1.0)).id());
    refused(Number, |w, all| w.spawn(BendConstraint::new(all, [NAN; 4], 0.0)).id());
    refused(Count, |w, [a, b, ..]| w.spawn(CoplanarConstraint::new([a, b])).id());
    refused(Count, |w, [a, ..]| w.spawn(CollinearConstraint::new([a])).id());
    refused(Count, |w, all| w.spawn(RigidConstraint::new(all, [Vec3::ZERO])).id());
    refused(Soft, |w, all| {
        let soft = Softness::frequency(NAN, 1.0);
        w.spawn(CoplanarConstraint::new(all).with_softness(soft)).id()
    });
}
