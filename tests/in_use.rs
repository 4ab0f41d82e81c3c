//! Despawning what is in use: a particle, a constraint, a body, the target of a pin, a mesh; before and after every set, from within a substep, in an observer,
//! and in the very tick in which it was spawned.

use bevy::ecs::schedule::ScheduleConfigs;
use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;
use bevy_sinew::prelude::*;
use bevy_sinew::{
    BodyConstraints, ConstraintOf, ParticleBody, ParticleOf, PhaseSystems, PinnedTo, SinewClock,
    SinewSystems, SinewTick, SubstepSchedule,
};

use crate::bevy_version::{OnAdd, OnInsert};
use crate::support::{app, assert_finite, busy_scene, hash_of, heard, particles_of, tick};

/// What is going to be despawned.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Victim {
    Particle,
    Constraint,
    Body,
    PinTarget,
    MeshAsset,
}

const VICTIMS: [Victim; 5] =
    [Victim::Particle, Victim::Constraint, Victim::Body, Victim::PinTarget, Victim::MeshAsset];

/// The entity to despawn in the tenth tick.
#[derive(Resource)]
struct Doomed {
    what: Victim,
    entity: Entity,
    mesh: Entity,
}

fn despawn_doomed(world: &mut World) {
    if world.resource::<SinewClock>().tick != 10 {
        return;
    }
    let Some(doomed) = world.remove_resource::<Doomed>() else { return };
    if doomed.what == Victim::MeshAsset {
        let handle = world.get::<Mesh3d>(doomed.mesh).unwrap().0.id();
        assert!(world.resource_mut::<Assets<Mesh>>().remove(handle).is_some());
    } else {
        assert!(world.despawn(doomed.entity));
    }
}

/// Runs a cloth that hangs from a moving anchor, beside other bodies, through the loss of something. Returns the number of refusals and the other bodies' hash.
fn lose(what: Option<Victim>, place: impl FnOnce(&mut App)) -> (usize, u64) {
    let mut app = app();
    let others = busy_scene(&mut app);
    let world = app.world_mut();
    let anchor = world.spawn(Transform::from_xyz(0.5, 5.0, 4.0)).id();
    let cloth = world.spawn((Cloth::grid(0.4, 0.4, 4, 4), Transform::from_xyz(0.3, 4.8, 4.0))).id();
    tick(&mut app, 1);
    let particles = particles_of(&app, cloth);
    let offset = Vec3::ZERO;
    app.world_mut().entity_mut(particles[4]).insert(PinnedTo { entity: anchor, offset });
    let constraints = app.world().get::<BodyConstraints>(cloth).unwrap().iter().collect::<Vec<_>>();
    if let Some(what) = what {
        let entity = match what {
            Victim::Particle => particles[12],
            Victim::Constraint => constraints[20],
            Victim::Body | Victim::MeshAsset => cloth,
            Victim::PinTarget => anchor,
        };
        app.insert_resource(Doomed { what, entity, mesh: cloth });
    }
    place(&mut app);
    tick(&mut app, 30);
    assert_finite(&mut app);
    assert!(!app.world().contains_resource::<Doomed>(), "it was despawned");
    (heard(&app).len(), hash_of(&app, &others))
}

/// The most messages that a loss may cause: one for the pin, one for each constraint that lost its particle (8 threads and 4 bends).
fn most_messages(what: Victim) -> usize {
    match what {
        Victim::PinTarget => 1,
        Victim::Particle => 12,
        _ => 0,
    }
}

#[test]
fn a_loss_before_or_after_any_set_harms_no_other_body() {
    let calm = lose(None, |_| ()).1;
    let sets = [
        SinewSystems::Build,
        SinewSystems::Gather,
        SinewSystems::Substeps,
        SinewSystems::Scatter,
        SinewSystems::Extract,
    ];
    for what in VICTIMS {
        for set in sets {
            let places: [(&str, ScheduleConfigs<ScheduleSystem>); 2] =
                [("before", despawn_doomed.before(set)), ("after", despawn_doomed.after(set))];
            for (when, place) in places {
                let (count, others) = lose(Some(what), |app| {
                    app.add_systems(SinewTick, place);
                });
                assert_eq!(others, calm, "{what:?} {when} {set:?}");
                let most = most_messages(what);
                assert!(count <= most, "{what:?} {when} {set:?}: {count} messages, at most {most}");
            }
        }
    }
}

#[test]
fn a_loss_within_a_substep_or_between_frames_harms_no_other_body() {
    let calm = lose(None, |_| ()).1;
    for what in VICTIMS {
        let (_, others) = lose(Some(what), |app| {
            app.add_systems(
                SubstepSchedule,
                despawn_doomed
                    .after(PhaseSystems::Integrate)
                    .before(PhaseSystems::SolveConstraints),
            );
        });
        assert_eq!(others, calm, "{what:?} within a substep");
        for label in [0, 1] {
            let (_, others) = lose(Some(what), |app| {
                if label == 0 {
                    app.add_systems(Update, despawn_doomed);
                } else {
                    app.add_systems(PostUpdate, despawn_doomed);
                }
            });
            assert_eq!(others, calm, "{what:?} between frames");
        }
    }
}

#[test]
fn a_body_that_an_observer_despawns_while_it_is_built_harms_no_other_body() {
    fn check(name: &str, watch: impl FnOnce(&mut App)) {
        let mut app = app();
        let others =
            [app.world_mut().spawn((RigidBox::default(), Transform::from_xyz(9.0, 0.0, 0.0))).id()];
        tick(&mut app, 2);
        watch(&mut app);
        let body = app.world_mut().spawn(Cloth::default()).id();
        tick(&mut app, 5);
        assert!(app.world().get_entity(body).is_err(), "{name}: it is gone");
        let particles = app.world().resource::<SinewWorld>().particles().len();
        assert_eq!(particles, 8, "{name}: and so are its particles");
        assert_eq!(particles_of(&app, others[0]).len(), 8);
    }
    check("on a particle", |app| {
        app.add_observer(
            |put: OnInsert<ParticleOf>, of: Query<&ParticleOf>, mut commands: Commands| {
                if let Ok(of) = of.get(put.entity) {
                    commands.entity(of.0).try_despawn();
                }
            },
        );
    });
    check("on a constraint", |app| {
        app.add_observer(
            |put: OnInsert<ConstraintOf>, of: Query<&ConstraintOf>, mut commands: Commands| {
                if let Ok(of) = of.get(put.entity) {
                    commands.entity(of.0).try_despawn();
                }
            },
        );
    });
    // Earlier: while the component is being inserted, with the rest of its bundle.
    check("on a new particle", |app| {
        app.add_observer(|put: OnAdd<Particle>, of: Query<&ParticleOf>, mut commands: Commands| {
            if let Ok(of) = of.get(put.entity) {
                commands.entity(of.0).try_despawn();
            }
        });
    });
    check("on a new constraint", |app| {
        app.add_observer(
            |put: OnAdd<DistanceConstraint>, of: Query<&ConstraintOf>, mut commands: Commands| {
                if let Ok(of) = of.get(put.entity) {
                    commands.entity(of.0).try_despawn();
                }
            },
        );
    });
    check("on its surface", |app| {
        app.add_observer(|put: OnInsert<bevy_sinew::WindSurface>, mut commands: Commands| {
            commands.entity(put.entity).try_despawn();
        });
    });
    check("on its mesh", |app| {
        app.add_observer(|put: OnInsert<Mesh3d>, mut commands: Commands| {
            commands.entity(put.entity).try_despawn();
        });
    });
}

#[test]
fn bodies_that_are_despawned_in_the_tick_that_they_were_spawned_in_leave_nothing() {
    let mut app = app();
    for _ in 0..10 {
        let world = app.world_mut();
        let body = world.spawn(Ragdoll::default()).id();
        let particle = world.spawn(Particle::at(Vec3::ZERO)).id();
        let rod = world.spawn(DistanceConstraint::new(particle, particle, 1.0)).id();
        for entity in [body, particle, rod] {
            world.despawn(entity);
        }
        tick(&mut app, 1);
    }
    // The recipe builds it during a pause, and it is despawned before it is ever gathered.
    let world = app.world_mut();
    world.insert_resource(SinewControl { paused: true, ..default() });
    let body = world.spawn(Ragdoll::default()).id();
    tick(&mut app, 1);
    assert!(!particles_of(&app, body).is_empty());
    app.world_mut().despawn(body);
    app.insert_resource(SinewControl::default());
    tick(&mut app, 5);
    assert!(app.world().resource::<SinewWorld>().particles().is_empty());
    assert_eq!(heard(&app), []);
}

#[test]
fn components_that_are_removed_and_inserted_again_do_no_harm() {
    let mut app = app();
    let bodies = busy_scene(&mut app);
    tick(&mut app, 5);
    let box_particles = particles_of(&app, bodies[0]);
    let saved = *app.world().get::<Particle>(box_particles[7]).unwrap();
    app.world_mut().entity_mut(box_particles[7]).remove::<Particle>();
    tick(&mut app, 5);
    app.world_mut().entity_mut(box_particles[7]).insert(saved);
    app.world_mut().entity_mut(box_particles[0]).remove::<ParticleOf>();
    tick(&mut app, 5);
    app.world_mut().entity_mut(box_particles[1]).insert(ParticleOf(bodies[1]));
    tick(&mut app, 5);
    app.world_mut().entity_mut(bodies[3]).remove::<ParticleBody>();
    app.world_mut().entity_mut(bodies[2]).remove::<(Cloth, Transform)>();
    tick(&mut app, 30);
    assert_finite(&mut app);
}
