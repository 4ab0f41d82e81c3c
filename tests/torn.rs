//! A constraint that is added, removed or changed among thousands updates the compiled plan incrementally: the result has the same bits as compiling everything
//! again.

use core::time::Duration;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::prelude::*;
use bevy_sinew::{BodyConstraints, WindSurface};

use crate::support::{app, forget, hash, heard, particles_of, position, tick};

/// An app with a cloth of some two thousand distance constraints, with bends.
fn hung() -> (App, Entity) {
    let mut app = app();
    let cloth = app.world_mut().spawn(Cloth::default().pinned(ClothPins::TopCorners)).id();
    tick(&mut app, 2);
    (app, cloth)
}

/// The constraints of a body, in the order in which they were added.
fn ties(app: &App, body: Entity) -> Vec<Entity> {
    app.world()
        .get::<BodyConstraints>(body)
        .into_iter()
        .flat_map(RelationshipTarget::iter)
        .collect()
}

/// Changes the cloth before tick number `n`: a tear or two, a new rod, another length.
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

/// Marks all distance constraints as changed: too many for an incremental update.
fn mark_all_changed(app: &mut App) {
    let world = app.world_mut();
    let mut all = world.query::<&mut DistanceConstraint>();
    all.iter_mut(world).for_each(|mut rod| rod.set_changed());
}

#[test]
fn incremental_updates_have_the_bits_of_compiling_everything_each_time() {
    let ((mut incremental, cloth), (mut afresh, same)) = (hung(), hung());
    for n in 0..100 {
        fray(&mut incremental, cloth, n);
        fray(&mut afresh, same, n);
        mark_all_changed(&mut afresh);
        tick(&mut incremental, 1);
        tick(&mut afresh, 1);
        assert_eq!(hash(&mut incremental), hash(&mut afresh), "tick {n}");
    }
    assert_eq!(heard(&incremental), []);
}

/// Spawns and despawns bodies beside the cloth, and changes the cloth, before tick number `n`; `others` are the spawned bodies that still exist.
fn come_and_go(app: &mut App, cloth: Entity, others: &mut Vec<Entity>, n: usize) {
    let place = Transform::from_xyz(2.0 + (n % 9) as f32, 1.0, (n / 9) as f32);
    let world = app.world_mut();
    let came = match n % 7 {
        0 => Some(world.spawn((RigidBox::new(Vec3::splat(0.3)), place)).id()),
        1 => Some(world.spawn((Cloth::grid(0.5, 0.5, 6, 6), place)).id()),
        2 => Some(world.spawn((Rope::between(Vec3::ZERO, Vec3::X), place)).id()),
        4 => Some(world.spawn((SoftBody::ball(0.2, 4), place)).id()),
        _ => None,
    };
    others.extend(came);
    if n % 3 == 2 {
        let gone = others.remove(n * 7 % others.len());
        world.despawn(gone);
    }
    if n % 4 == 3 {
        fray(app, cloth, n);
    }
    if n % 5 == 4 {
        let (old, last) = (particles_of(app, cloth), others.last().copied().unwrap_or(cloth));
        let new = particles_of(app, last);
        let old = old[n * 13 % old.len()];
        if let Some(&end) = new.first() {
            let apart = position(app, old).distance(position(app, end));
            app.world_mut().spawn(DistanceConstraint::new(old, end, apart));
        }
    }
    if n % 11 == 6 {
        app.world_mut().entity_mut(cloth).remove::<WindSurface>();
    }
    if n == 24 {
        let one = particles_of(app, cloth)[30];
        app.world_mut().despawn(one);
    }
}

#[test]
fn bodies_added_and_removed_have_the_bits_of_revalidating_everything_each_time() {
    let ((mut some, cloth), (mut all, same)) = (hung(), hung());
    // While one constraint cannot act, all are revalidated whenever anything has changed.
    let nail = all.world_mut().spawn((Particle::at(Vec3::Y * 50.0), Pinned::HERE)).id();
    let nail_of_some = some.world_mut().spawn((Particle::at(Vec3::Y * 50.0), Pinned::HERE)).id();
    all.world_mut().spawn(DistanceConstraint::new(nail, nail, 1.0));
    some.world_mut().spawn_empty();
    let (mut others, mut others_of_all) = (Vec::new(), Vec::new());
    tick(&mut some, 1);
    tick(&mut all, 1);
    for n in 0..70 {
        come_and_go(&mut some, cloth, &mut others, n);
        come_and_go(&mut all, same, &mut others_of_all, n);
        tick(&mut some, 1);
        tick(&mut all, 1);
        let lists = |app: &App| {
            let world = app.world().resource::<SinewWorld>().simulation();
            (
                world.distances().to_vec(),
                world.constraints().to_vec(),
                world.forces.surfaces.clone(),
                world.body_colliders().len(),
            )
        };
        assert!(lists(&some) == lists(&all), "tick {n}");
        assert_eq!(hash(&mut some), hash(&mut all), "tick {n}");
    }
    assert!(others.len() > 5 && some.world().get_entity(nail_of_some).is_ok());
}

#[test]
fn constraints_removed_many_frames_before_a_tick_are_gone_in_that_tick() {
    // Bevy keeps the record of a removed component for two frames; here there is a tick in every eighth or ninth frame.
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
fn an_invalid_constraint_among_updated_ones_is_set_aside_and_named_once() {
    let (mut app, cloth) = hung();
    let particles = particles_of(&app, cloth);
    let rod = DistanceConstraint::new(particles[0], particles[2], f32::NAN);
    let broken = app.world_mut().spawn(rod).id();
    for n in 0..5 {
        tick(&mut app, 1);
        let named: Vec<Entity> = heard(&app).iter().map(|(entity, _)| *entity).collect();
        assert_eq!(named, [broken]);
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
