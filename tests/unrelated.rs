//! What has nothing to do with a body does not change a bit of it: distant bodies, unrelated entities, archetypes, the order of spawning.

use bevy::prelude::*;
use bevy_sinew::Charge;
use bevy_sinew::Drag;
use bevy_sinew::prelude::*;

use crate::support::{app, busy_scene, hash_of, particles_of, tick};

/// Hashes of the busy scene's bodies for 90 ticks, while `meddle` changes something else in the same world before each.
fn beside(mut meddle: impl FnMut(&mut App, &[Entity], u64)) -> Vec<u64> {
    let mut app = app();
    let bodies = busy_scene(&mut app);
    (0..90)
        .map(|now| {
            meddle(&mut app, &bodies, now);
            tick(&mut app, 1);
            hash_of(&app, &bodies)
        })
        .collect()
}

fn alone() -> Vec<u64> {
    beside(|_, _, _| ())
}

/// A component without a meaning.
#[derive(Component, Clone)]
struct Junk<const N: usize>;

#[test]
fn junk_entities_and_archetype_changes_do_not_change_a_bit() {
    let meddled = beside(|app, bodies, now| {
        let world = app.world_mut();
        for i in 0..now % 7 {
            world.spawn((Name::new(format!("junk {i}")), Mass(i as f32), Transform::default()));
        }
        let particles = particles_of(app, bodies[now as usize % bodies.len()]);
        for (i, particle) in particles.into_iter().enumerate() {
            let mut entity = app.world_mut().entity_mut(particle);
            match (i as u64 * 7 + now) % 5 {
                0 => drop(entity.insert(Junk::<0>).id()),
                1 => drop(entity.insert((Junk::<1>, Name::new("x"))).id()),
                2 => drop(entity.remove::<Junk<0>>().id()),
                3 => drop(entity.remove::<(Junk<1>, Name)>().id()),
                _ => (),
            }
        }
    });
    assert_eq!(meddled, alone());
}

#[test]
fn loose_particles_far_away_do_not_change_a_bit() {
    let meddled = beside(|app, _, now| {
        let far = Vec3::new(0.0, 1e4 + now as f32, 0.0);
        app.world_mut().spawn((Particle::at(far), Pinned::HERE));
    });
    assert_eq!(meddled, alone());
}

#[test]
fn bodies_at_rest_and_without_gravity_far_away_do_not_change_a_bit() {
    // They are spawned and despawned, so that rows move and the plan is compiled again.
    let mut guest = None;
    let meddled = beside(|app, _, now| {
        if now % 10 == 0 {
            guest = Some(
                app.world_mut()
                    .spawn((
                        Cloth::default().pinned(ClothPins::Particles((0..441).collect())),
                        Transform::from_xyz(100.0, 1e3, 0.0),
                    ))
                    .id(),
            );
        } else if now % 10 == 5 {
            app.world_mut().despawn(guest.take().unwrap());
        }
    });
    assert_eq!(meddled, alone());
}

#[test]
fn strained_bodies_far_away_do_not_change_a_bit() {
    // The solver stops sweeping when the error is small. A heavy rope far away must not cause more sweeps of this flag.
    let meddled = beside(|app, _, now| {
        if now == 20 {
            let rope =
                Rope { segments: 60, to: Vec3::X * 3.0, pin_end: true, slack: 0.1, ..default() };
            app.world_mut().spawn((rope, Transform::from_xyz(0.0, 5.0, -0.5)));
        }
    });
    let alone = alone();
    let first = meddled.iter().zip(&alone).position(|(a, b)| a != b);
    assert_eq!(first, None, "the first tick that differs");
}

/// Regression: after each substep in which any bodies of the world touched, the velocity of cloth without contacts was computed in another way, which changed
/// its last digits.
#[test]
fn contacts_far_away_do_not_change_a_bit_of_cloth() {
    let run = |busy: bool| {
        let mut app = app();
        let cloth = app.world_mut().spawn((
            Cloth::grid(2.0, 2.0, 31, 31).pinned(ClothPins::TopCorners),
            Transform::from_xyz(0.0, 2.5, 0.0),
        ));
        let cloth = cloth.id();
        app.world_mut().spawn(Ground);
        (0..90)
            .map(|now| {
                if busy && now == 20 {
                    for height in [0.5, 1.5] {
                        let at = Transform::from_xyz(50.0, height, 0.0);
                        app.world_mut().spawn((RigidBox::default(), at));
                    }
                }
                tick(&mut app, 1);
                hash_of(&app, &[cloth])
            })
            .collect::<Vec<_>>()
    };
    let (busy, alone) = (run(true), run(false));
    let first = busy.iter().zip(&alone).position(|(a, b)| a != b);
    assert_eq!(first, None, "the first tick that differs");
}

#[test]
fn one_light_body_is_the_same_alone_and_beside_a_busy_one() {
    let run = |busy: bool| {
        let mut app = app();
        let body =
            app.world_mut().spawn((RigidBox::default(), Transform::from_xyz(0.0, 2.0, 0.0))).id();
        app.world_mut().spawn(Ground);
        if busy {
            app.world_mut().spawn((
                Cloth::default().pinned(ClothPins::TopCorners),
                Transform::from_xyz(50.0, 5.0, 0.0),
            ));
        }
        (0..120)
            .map(|_| {
                tick(&mut app, 1);
                hash_of(&app, &[body])
            })
            .collect::<Vec<_>>()
    };
    let (with, without) = (run(true), run(false));
    let first = with.iter().zip(&without).position(|(a, b)| a != b);
    assert_eq!(first, None, "the first tick that differs");
}

#[test]
fn the_order_in_which_archetypes_are_created_does_not_change_a_bit() {
    // The same bodies in the same order, after the archetypes of their particles were created in each of six orders.
    let run = |first: usize| {
        let mut app = app();
        let world = app.world_mut();
        let mut warm: Vec<Entity> = Vec::new();
        for i in 0..6 {
            let particle = Particle::at(Vec3::Y * 1e3);
            warm.push(match (i + first) % 6 {
                0 => world.spawn((particle, Pinned::HERE)).id(),
                1 => world.spawn((particle, Radius(0.0))).id(),
                2 => world.spawn((particle, Charge(0.0), Drag(0.0))).id(),
                3 => world.spawn((particle, Radius(0.0), Drag(0.0))).id(),
                4 => world.spawn((particle, Transform::default())).id(),
                _ => world.spawn((particle, Radius(0.0), Charge(0.0), Drag(0.0))).id(),
            });
        }
        for entity in warm {
            world.despawn(entity);
        }
        let bodies = busy_scene(&mut app);
        tick(&mut app, 90);
        hash_of(&app, &bodies)
    };
    let hashes: Vec<u64> = (0..6).map(run).collect();
    assert!(hashes.iter().all(|&hash| hash == hashes[0]), "{hashes:?}");
}

#[test]
fn ropes_that_collide_by_their_segments_far_away_do_not_change_a_bit_of_a_figure() {
    // Limbs and segments are gathered and scattered eight at a time. Regression: a segment cannot be found by its two particles alone, so its batch of eight
    // was read twice, and the limbs in it got other bits too. And contributions to shared limbs were summed in the order of their batches.
    let run = |among: bool| {
        let mut app = app();
        let world = app.world_mut();
        world.spawn(Ground);
        let tilted = Transform::from_xyz(2.0, 1.0, -2.0).with_rotation(Quat::from_rotation_z(0.4));
        let figure = world.spawn((Ragdoll::default(), tilted)).id();
        (0..60)
            .map(|now| {
                if among && now == 20 {
                    let rope = Rope { segments: 60, to: Vec3::X * 3.0, slack: 0.1, ..default() };
                    app.world_mut().spawn((rope, Transform::from_xyz(0.0, 500.0, 0.0)));
                }
                tick(&mut app, 1);
                hash_of(&app, &[figure])
            })
            .collect::<Vec<_>>()
    };
    let (alone, among) = (run(false), run(true));
    let first = among.iter().zip(&alone).position(|(a, b)| a != b);
    assert_eq!(first, None, "the first tick that differs");
}
