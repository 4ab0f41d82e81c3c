//! Commands that cannot be carried out are refused and change nothing; despawned or broken targets do no harm; pending commands are part of the state.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyEdit, EditFault, ExtractedTransform, ParticleBody, PendingEdits, Refusal, SinewSnapshot,
};

use crate::commands::{PUSH, SPIN, brick, built, command, momenta, space};
use crate::support::{forget, hash, heard, particles_of, position, tick};

#[test]
fn edits_that_are_not_finite_are_refused_and_change_nothing() {
    let mut app = space();
    let body = built(&mut app, brick(), Transform::default());
    let stone = app.world_mut().spawn(Particle::at(Vec3::X * 9.0)).id();
    tick(&mut app, 1);
    let nan = Vec3::new(0.0, f32::NAN, 0.0);
    let edits = [
        BodyEdit::Impulse(nan),
        BodyEdit::ImpulseAt(PUSH, nan),
        BodyEdit::AngularImpulse(Vec3::INFINITY),
        BodyEdit::LinearVelocity(nan),
        BodyEdit::AngularVelocity(nan),
        BodyEdit::Motion(nan, SPIN),
        BodyEdit::Teleport(Transform::from_translation(nan)),
        BodyEdit::Teleport(Transform::from_rotation(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0))),
        BodyEdit::Displace(nan),
        BodyEdit::Displace(Vec3::splat(f32::MAX) * 2.0),
        BodyEdit::Turn(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
    ];
    let state = |app: &mut App| (hash(app), *app.world().get::<Transform>(body).unwrap());
    for entity in [body, stone] {
        for edit in edits {
            forget(&mut app);
            let before = state(&mut app);
            command(&mut app, entity, |entity| _ = entity.edit_body(edit));
            assert_eq!(state(&mut app), before, "{edit:?}");
            app.update();
            assert_eq!(heard(&app), [(entity, Refusal::Edit(EditFault::NotFinite))], "{edit:?}");
        }
    }
}

#[test]
fn edits_of_despawned_entities_and_of_no_bodies_do_no_harm() {
    let mut app = space();
    let body = built(&mut app, brick(), Transform::default());
    let rock = app.world_mut().spawn(Transform::default()).id();
    command(&mut app, rock, |rock| _ = rock.apply_impulse(PUSH));
    app.update();
    assert_eq!(heard(&app), [(rock, Refusal::Edit(EditFault::NoParticles))]);
    forget(&mut app);

    app.world_mut().commands().entity(body).apply_impulse(PUSH);
    app.world_mut().commands().entity(body).despawn();
    app.world_mut().commands().entity(body).apply_impulse(PUSH).teleport(Transform::default());
    app.world_mut().flush();
    tick(&mut app, 1);
    assert_eq!(heard(&app), [], "gone is gone");

    // The queue of a body that is never built is bounded.
    let never = app.world_mut().spawn(ParticleBody).id();
    for _ in 0..PendingEdits::MAX + 2 {
        command(&mut app, never, |never| _ = never.apply_impulse(PUSH));
    }
    tick(&mut app, 1);
    let refused = heard(&app);
    assert_eq!(refused, vec![(never, Refusal::Edit(EditFault::TooMany)); 2]);
    assert_eq!(app.world().get::<PendingEdits>(never).unwrap().0.len(), PendingEdits::MAX);

    // Without the plugin the command does nothing, and nothing fails.
    let mut bare = World::new();
    let stone = bare.spawn(Particle::at(Vec3::ZERO)).id();
    bare.entity_mut(stone).apply_impulse(PUSH);
    assert_eq!(bare.get::<Particle>(stone).unwrap().velocity, Vec3::ZERO);
}

#[test]
fn impulses_skip_a_bad_particle_and_a_teleport_repairs_a_broken_transform() {
    let mut app = space();
    let body = built(&mut app, brick(), Transform::default());
    let all = particles_of(&app, body);
    app.world_mut().get_mut::<Particle>(all[0]).unwrap().velocity.x = f32::NAN;
    let (_, before, _) = momenta(&app, &all[1..], Vec3::ZERO);
    command(&mut app, body, |body| _ = body.apply_impulse(PUSH));
    let (_, after, _) = momenta(&app, &all[1..], Vec3::ZERO);
    assert!((after - before - PUSH.as_dvec3()).length() < 1e-5, "{}", after - before);
    // A teleport moves the bad particle too, so that the body is whole once the number is repaired.
    let was = position(&app, all[0]);
    command(&mut app, body, |body| _ = body.displace(Vec3::Z * 5.0));
    assert!(position(&app, all[0]).abs_diff_eq(was + Vec3::Z * 5.0, 1e-5));

    let other = built(&mut app, brick(), Transform::from_xyz(20.0, 0.0, 0.0));
    app.world_mut().get_mut::<Transform>(other).unwrap().translation.y = f32::NAN;
    command(&mut app, other, |body| _ = body.teleport(Transform::from_xyz(30.0, 0.0, 0.0)));
    let centre = particles_of(&app, other).iter().map(|&p| position(&app, p)).sum::<Vec3>() / 8.0;
    assert!(centre.abs_diff_eq(Vec3::X * 30.0, 1e-4), "{centre}");
    let known = app.world().get::<ExtractedTransform>(other).unwrap().0;
    assert_eq!(known, app.world().get::<Transform>(other).copied());
}

#[test]
fn pending_edits_are_part_of_the_state() {
    let mut app = space();
    built(&mut app, brick(), Transform::default());
    let late = app.world_mut().spawn(ParticleBody).id();
    app.world_mut().entity_mut(late).insert(bevy_sinew::CreationOrder::default());
    command(&mut app, late, |late| _ = late.apply_impulse(PUSH));
    let saved = SinewSnapshot::capture(app.world());
    app.world_mut().get_mut::<PendingEdits>(late).unwrap().0.clear();
    saved.restore(app.world_mut()).unwrap();
    let kept = app.world().get::<PendingEdits>(late).unwrap();
    assert_eq!(kept.0, [BodyEdit::Impulse(PUSH)]);
}
