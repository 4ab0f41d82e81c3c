//! Bodies and worlds that are brought to rest at once.

use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyParticles, BodySolver, EditFault, Refusal, Relax, RelaxFinished, RelaxWorld, SinewClock,
};

use crate::support::{app, hash_of, heard, particles_of, position, tick};

/// A rope of 1.5 m between pins 1 m apart.
fn slack(segments: u32) -> (Rope, BodySolver) {
    let rope =
        Rope { to: Vec3::X, segments, slack: 0.5, pin_start: true, pin_end: true, ..default() };
    (rope, BodySolver { max_sweeps: Some(60), ..default() })
}

/// How far the lowest particle of a rope hangs below the rope's start, metres.
fn sag(app: &App, rope: Entity) -> f32 {
    let particles = particles_of(app, rope);
    particles.iter().map(|&p| -position(app, p).y).fold(f32::NEG_INFINITY, f32::max)
}

#[derive(Resource, Default)]
struct Seen(Vec<RelaxFinished>);

fn watch(app: &mut App) {
    app.init_resource::<Seen>().add_observer(|on: On<RelaxFinished>, mut seen: ResMut<Seen>| {
        seen.0.push(*on);
    });
}

#[test]
fn a_rope_that_is_spawned_to_rest_hangs_as_a_catenary_in_its_first_tick() {
    for (segments, expected) in [(10, 0.50595), (20, 0.50345), (50, 0.50276), (100, 0.50267)] {
        let mut app = app();
        watch(&mut app);
        // With the shorter step a link of 3 cm or less is long compared with what it falls in a substep.
        let step = if segments < 50 { 0.2 } else { 0.05 };
        let relax = Relax { step, max_steps: 20_000, ..default() };
        let rope = app.world_mut().spawn((slack(segments), relax)).id();
        tick(&mut app, 1);
        let found = sag(&app, rope);
        let seen = app.world().resource::<Seen>().0.clone();
        assert!((found / expected - 1.0).abs() < 5e-3, "{segments}: {found}, {seen:?}");
        assert_eq!(seen.len(), 1);
        assert!(seen[0].entity == Some(rope) && seen[0].settled, "{seen:?}");
        assert!(app.world().get::<Relax>(rope).is_none(), "once");
        // It stays there, except that the rods have other errors in the long steps of statics than in motion: a rope of 100 segments swings by that.
        for _ in 0..120 {
            tick(&mut app, 1);
            let off = (sag(&app, rope) / expected - 1.0).abs();
            assert!(off < if segments > 64 { 8e-3 } else { 3e-3 }, "{segments}: {off}");
        }
        assert_eq!(heard(&app), []);
    }
}

#[test]
fn a_command_relaxes_one_body_also_in_a_pause_and_no_bit_of_another_one_changes() {
    let run = |relaxes: bool| {
        let mut app = app();
        let rope = app.world_mut().spawn(slack(20)).id();
        let other = (RigidBox::default(), Transform::from_xyz(4.0, 30.0, 1.0));
        let other = app.world_mut().spawn((other, AngularVelocity(Vec3::Y))).id();
        tick(&mut app, 7);
        app.world_mut().resource_mut::<SinewControl>().pause();
        if relaxes {
            app.world_mut().commands().entity(rope).relax();
        }
        tick(&mut app, 2);
        let clock = *app.world().resource::<SinewClock>();
        let hung = sag(&app, rope);
        app.world_mut().resource_mut::<SinewControl>().unpause();
        tick(&mut app, 20);
        assert_eq!(heard(&app), []);
        (hash_of(&app, &[other]), clock, hung)
    };
    let ((relaxed, clock, hung), (plain, same_clock, swinging)) = (run(true), run(false));
    assert_eq!(relaxed, plain, "the other one flies and spins on");
    assert_eq!(clock, same_clock, "no time has passed");
    assert!(
        (hung / 0.50345 - 1.0).abs() < 5e-3 && (swinging - hung).abs() > 0.005,
        "{hung} {swinging}"
    );
}

#[test]
fn the_world_comes_to_rest_at_once() {
    let mut app = app();
    watch(&mut app);
    let world = app.world_mut();
    world.spawn(Ground);
    let crates = [0.0, 3.0].map(|x| {
        world.spawn((RigidBox::default(), Sleep::default(), Transform::from_xyz(x, 3.0, 0.0))).id()
    });
    let rope = (slack(20), Transform::from_xyz(0.0, 3.0, 9.0));
    let rope = world.spawn(rope).id();
    world.commands().relax_world();
    tick(&mut app, 1);
    assert!(app.world().get_resource::<RelaxWorld>().is_none(), "once");
    for body in crates {
        let lies = app.world().get::<Transform>(body).unwrap().translation;
        assert!((lies.y - 0.5).abs() < 2e-3, "{lies}");
        let still = app.world().get::<LinearVelocity>(body).unwrap().0.length();
        assert!(still < 0.01, "{still}");
    }
    let hung = 3.0 + sag(&app, rope);
    assert!((hung / 0.50345 - 1.0).abs() < 0.01, "{hung}");
    assert_eq!(app.world().resource::<Seen>().0[0].entity, None);
}

#[test]
fn relaxing_no_body_or_with_broken_numbers_is_refused_and_changes_nothing() {
    let mut app = app();
    let empty = app.world_mut().spawn(Relax::default()).id();
    tick(&mut app, 1);
    assert_eq!(heard(&app), [(empty, Refusal::Edit(EditFault::NoParticles))]);
    let rope = app.world_mut().spawn(slack(20)).id();
    tick(&mut app, 3);
    for step in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        crate::support::forget(&mut app);
        let before = sag(&app, rope);
        app.world_mut().resource_mut::<SinewControl>().paused = true;
        app.world_mut().entity_mut(rope).insert(Relax { step, ..default() });
        tick(&mut app, 1);
        assert_eq!(heard(&app), [(rope, Refusal::Edit(EditFault::NotFinite))], "{step}");
        assert_eq!(sag(&app, rope), before);
    }
    assert_eq!(app.world().get::<BodyParticles>(rope).unwrap().iter().count(), 21);
}
