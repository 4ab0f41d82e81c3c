//! What is pinned inside of something that it collides with stays calm: no contact can move it out, so none may try to at any price.
//!
//! Two ropes that hung from one point turned their first segments by radians in each substep and were thrown away at any speed; so was a box that is hinged
//! inside of another one.

use bevy::prelude::*;
use bevy_sinew::prelude::*;

use crate::support::{app, assert_finite, forget, heard, particles_of, position, tick};

/// The largest values over a run.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    /// Kinetic energy of the world, J.
    kinetic: f64,
    /// Speed of the fastest particle, m/s.
    speed: f32,
    /// Speed of the fastest particle in the last tick, m/s.
    last: f32,
    /// Distance of the farthest particle from the origin, metres.
    far: f32,
    /// How often a particle was reported as too fast or frozen.
    reported: usize,
}

fn watch(app: &mut App, ticks: u32) -> Worst {
    let mut worst = Worst::default();
    for _ in 0..ticks {
        tick(app, 1);
        let world = app.world_mut();
        let mut all = world.query::<&Particle>();
        worst.last = 0.0;
        for one in all.iter(world) {
            worst.last = worst.last.max(one.velocity.length());
            worst.far = worst.far.max(one.position.length());
        }
        worst.speed = worst.speed.max(worst.last);
        let mut sinew = world.resource_mut::<SinewWorld>();
        worst.kinetic = worst.kinetic.max(sinew.ledger().kinetic);
        let report = sinew.report();
        worst.reported += report.too_fast.len() + report.frozen.len();
    }
    assert_finite(app);
    worst
}

/// An app with a ground 2 m below the origin, and so many substeps.
fn world(substeps: u32) -> App {
    let mut app = app();
    app.world_mut().resource_mut::<SolverConfig>().substeps = substeps;
    app.world_mut().spawn((Ground, Transform::from_xyz(0.0, -2.0, 0.0)));
    app
}

/// A rope of a tenth of a kilogram that is pinned at both ends.
fn rope(from: Vec3, to: Vec3) -> Rope {
    Rope { pin_end: true, slack: 0.06, segments: 30, ..Rope::between(from, to) }
}

/// The ends of `count` ropes from the origin, in all directions and at different heights, 1 m and more away.
fn ends(count: usize) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| {
        let turn = Quat::from_rotation_y(i as f32 * core::f32::consts::TAU / count as f32);
        turn * Vec3::new(1.0, 0.1 * i as f32, 0.0)
    })
}

/// Asserts that nothing is thrown: what falls by half a metre at the most, or is pushed apart at 2 m/s, is no faster than about twice that.
fn assert_calm(name: &str, app: &App, worst: Worst, kinetic: f64, reach: f32) {
    let calm = worst.speed < 4.5 && worst.kinetic < kinetic && worst.far < reach;
    assert!(calm && worst.reported == 0, "{name}: {worst:?}");
    assert_eq!(heard(app), [], "{name}");
}

#[test]
fn ropes_that_are_pinned_at_one_point_hang_calmly() {
    for substeps in [1, 4, 10, 40] {
        for (count, reversed) in [(2, false), (2, true), (3, false), (5, true)] {
            let mut app = world(substeps);
            for end in ends(count) {
                let rope = if reversed { rope(end, Vec3::ZERO) } else { rope(Vec3::ZERO, end) };
                app.world_mut().spawn(rope);
            }
            let worst = watch(&mut app, 90);
            let name = format!("{count} ropes, reversed {reversed}, {substeps} substeps");
            // Each of them falls by some 7 cm.
            assert_calm(&name, &app, worst, 0.1 * count as f64, 1.2);
        }
    }
}

#[test]
fn overlapping_ropes_are_pushed_apart_at_limited_speed() {
    let mut app = world(10);
    // Two in the same place, from end to end.
    for _ in 0..2 {
        app.world_mut().spawn(rope(Vec3::ZERO, Vec3::X));
    }
    let worst = watch(&mut app, 90);
    assert_calm("twins", &app, worst, 0.1, 1.1);

    let mut app = world(10);
    for (i, end) in ends(5).enumerate() {
        let kind = Rope {
            segments: [1, 7, 12, 30, 60][i],
            mass: [3.0, 0.01, 1.0, 0.1, 0.3][i],
            radius: [0.01, 0.005, 0.02, 0.008, 0.006][i],
            slack: if i == 0 { 0.0 } else { 0.05 * i as f32 },
            ..rope(Vec3::Y * 0.003 * i as f32, end)
        };
        app.world_mut().spawn(kind);
    }
    let worst = watch(&mut app, 90);
    assert!(worst.speed < 12.0 && worst.far < 1.5 && worst.reported == 0, "{worst:?}");

    // One that is pinned inside the middle of another.
    let mut app = world(10);
    app.world_mut().spawn(rope(Vec3::X * -0.6, Vec3::X * 0.6));
    app.world_mut().spawn(rope(Vec3::Y * -0.19, Vec3::new(0.0, -0.3, 0.9)));
    let worst = watch(&mut app, 90);
    assert_calm("in the middle", &app, worst, 0.3, 1.2);
}

#[test]
fn a_rope_that_is_pinned_inside_any_collider_hangs_calmly() {
    let cube = || {
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let corners: Vec<Vec3> = (0..8).map(|i| (corner(i) - 0.5) * 0.12).collect();
        let sides = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4]];
        let more = [[2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]];
        Collider::mesh(corners, [sides, more].concat()).unwrap()
    };
    let hill = || {
        let heights: Vec<f32> = (0..25).map(|i| if i % 5 < 3 { 0.0 } else { -0.4 }).collect();
        Collider::height_field(5, 5, &heights, Vec3::new(0.6, 1.0, 0.6)).unwrap()
    };
    for substeps in [1, 10] {
        for depth in [-0.004, 0.0, 0.006, 0.02] {
            let posts = [
                Collider::capsule(0.06, 1.0),
                Collider::cuboid(Vec3::new(0.12, 1.0, 0.12)),
                Collider::cylinder(0.06, 1.0),
                Collider::sphere(0.06),
                cube(),
                hill(),
            ];
            for (i, post) in posts.into_iter().enumerate() {
                let mut app = world(substeps);
                app.world_mut().spawn(post);
                let start = Vec3::new(0.06 - depth, if i == 5 { -0.01 } else { 0.0 }, 0.0);
                app.world_mut().spawn(rope(start, Vec3::new(1.2, 0.2, 0.0)));
                app.world_mut().spawn(rope(Vec3::new(1.0, -0.3, 0.5), start));
                let worst = watch(&mut app, 60);
                let name = format!("shape {i}, {depth} m, {substeps} substeps");
                assert_calm(&name, &app, worst, 0.4, 1.5);
            }
        }
    }
}

#[test]
fn a_rope_that_a_moving_pin_pulls_into_a_wall_is_not_thrown() {
    let mut app = world(10);
    app.world_mut().spawn(Collider::cuboid(Vec3::new(0.3, 2.0, 2.0)));
    let hand = app.world_mut().spawn(Transform::from_xyz(-0.5, 0.0, 0.0)).id();
    let from = Vec3::new(-0.5, 0.0, 0.0);
    let ropes = [0.0, 0.3].map(|z| {
        let rope = Rope { pin_start: false, ..Rope::between(from, from + Vec3::new(0.0, -1.0, z)) };
        app.world_mut().spawn(rope).id()
    });
    tick(&mut app, 1);
    for rope in ropes {
        let first = particles_of(&app, rope)[0];
        app.world_mut().entity_mut(first).insert(PinnedTo { entity: hand, offset: Vec3::ZERO });
    }
    let mut worst = Worst::default();
    for step in 0..200 {
        let x = -0.5 + 0.005 * step as f32;
        app.world_mut().get_mut::<Transform>(hand).unwrap().translation.x = x.min(0.0);
        let one = watch(&mut app, 1);
        worst.speed = worst.speed.max(one.speed);
        worst.reported += one.reported;
    }
    assert!(worst.speed < 8.0 && worst.reported == 0, "{worst:?}");
    for rope in ropes {
        let first = particles_of(&app, rope)[0];
        assert!(position(&app, first).length() < 1e-3);
    }
    forget(&mut app);
}

#[test]
fn boxes_with_corners_pinned_inside_a_collider_are_not_thrown() {
    for substeps in [4, 10, 40] {
        for pins in [&[0][..], &[0, 1], &[0, 7], &[0, 3, 5]] {
            for deep in [0.0, 0.05, 0.2] {
                let mut app = world(substeps);
                let wall = Transform::from_xyz(-0.5 + deep - 0.2, 0.0, 0.0);
                app.world_mut().spawn((Collider::cuboid(Vec3::new(1.0, 2.0, 2.0)), wall));
                let crates = [0.0, 0.25].map(|z| {
                    let at = Transform::from_xyz(0.0, 0.0, z);
                    app.world_mut().spawn((RigidBox::new(Vec3::splat(0.4)), at)).id()
                });
                tick(&mut app, 1);
                for body in crates {
                    let own = particles_of(&app, body);
                    for &pin in pins {
                        app.world_mut().entity_mut(own[pin]).insert(Pinned::HERE);
                    }
                }
                let worst = watch(&mut app, 90);
                let name = format!("pins {pins:?}, {deep} m, {substeps} substeps: {worst:?}");
                // Two that overlap by a third push each other round their pins for as long as they overlap.
                assert!(worst.speed < 45.0 && worst.far < 1.5 && worst.reported == 0, "{name}");
            }
        }
    }
}
