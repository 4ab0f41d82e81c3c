//! A constraint that comes, goes or changes among thousands is mended into what is there: nothing tells the result from that of compiling everything
//! again.

use core::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::BodyConstraints;
use bevy_sinew::prelude::*;

use crate::support::{app, forget, hash, heard, particles_of, tick};

/// A cloth of some two thousand distances, with bends.
fn hung() -> (App, Entity) {
    let mut app = app();
    let cloth = app.world_mut().spawn(Cloth::default().pinned(ClothPins::TopCorners)).id();
    tick(&mut app, 2);
    (app, cloth)
}

/// The constraints of a body, in the order in which they came.
fn ties(app: &App, body: Entity) -> Vec<Entity> {
    app.world()
        .get::<BodyConstraints>(body)
        .into_iter()
        .flat_map(RelationshipTarget::iter)
        .collect()
}

/// What is done to the cloth before tick number `n`: a tear or two, a new rod, another length.
fn fray(app: &mut App, cloth: Entity, n: usize) {
    let (ties, particles) = (ties(app, cloth), particles_of(app, cloth));
    let world = app.world_mut();
    world.despawn(ties[n * 7919 % ties.len()]);
    if n.is_multiple_of(3) {
        world.despawn(ties[(n * 104_729 + 1) % ties.len()]);
    }
    if n % 4 == 1 {
        let (a, b) = (n * 31 % (particles.len() - 3), n * 31 % (particles.len() - 3) + 2);
        world.spawn(DistanceConstraint::new(particles[a], particles[b], 0.05));
    }
    if n % 5 == 2
        && let Some(mut rod) =
            world.get_mut::<DistanceConstraint>(ties[(n * 15_485_863 + 2) % ties.len()])
    {
        rod.rest *= 0.9;
    }
}

/// Has everything compiled again: more changed than is worth mending.
fn touch_all(app: &mut App) {
    let world = app.world_mut();
    let mut all = world.query::<&mut DistanceConstraint>();
    all.iter_mut(world).for_each(|mut rod| rod.set_changed());
}

#[test]
fn a_hundred_ticks_of_tears_leave_the_bits_of_compiling_everything_each_time() {
    let ((mut mended, cloth), (mut afresh, same)) = (hung(), hung());
    for n in 0..100 {
        fray(&mut mended, cloth, n);
        fray(&mut afresh, same, n);
        touch_all(&mut afresh);
        tick(&mut mended, 1);
        tick(&mut afresh, 1);
        assert_eq!(hash(&mut mended), hash(&mut afresh), "tick {n}");
    }
    assert_eq!(heard(&mended), []);
}

#[test]
fn what_goes_many_frames_before_a_tick_is_gone_in_that_tick() {
    // Bevy tells for two frames what was removed; here a tick comes every eighth.
    let ((mut slow, cloth), (mut fast, same)) = (hung(), hung());
    slow.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(1953)));
    for n in 0..20 {
        fray(&mut slow, cloth, n);
        (0..5).for_each(|_| slow.update());
        tick(&mut slow, 1);
        fray(&mut fast, same, n);
        tick(&mut fast, 1);
        assert_eq!(hash(&mut slow), hash(&mut fast), "tick {n}");
    }
}

#[test]
fn one_that_cannot_act_is_set_aside_among_those_that_are_mended_and_told_once() {
    let (mut app, cloth) = hung();
    let particles = particles_of(&app, cloth);
    let rod = DistanceConstraint::new(particles[0], particles[2], f32::NAN);
    let broken = app.world_mut().spawn(rod).id();
    for n in 0..5 {
        tick(&mut app, 1);
        let told: Vec<Entity> = heard(&app).iter().map(|(entity, _)| *entity).collect();
        assert_eq!(told, [broken]);
        fray(&mut app, cloth, n);
    }
    tick(&mut app, 1);
    let listed = |app: &App| app.world().resource::<SinewWorld>().simulation().distances().len();
    let before = listed(&app);
    app.world_mut().get_mut::<DistanceConstraint>(broken).expect("it is there").rest = 0.1;
    tick(&mut app, 1);
    assert_eq!(listed(&app), before + 1);
    forget(&mut app);
    tick(&mut app, 5);
    assert_eq!(heard(&app), []);
}
