//! A body that is spawned inside another shape is pushed out at a bounded speed, and is not thrown.
//!
//! Cloth that started 5 to 40 cm inside a shape reached 30 to 60 m/s in its first tick, and ragdolls up to 115 m/s: the whole depth was corrected in one
//! substep, and became a velocity of that depth over the substep's length.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{
    Blueprint, BoxSpec, ClothSpec, RagdollSpec, RopeSpec, box_3d, cloth_grid, ragdoll, rope,
};
use sinew::{BodyContacts, Collider, Frame, ParticleSeed, Shape, Simulation};

const DT: f32 = 1.0 / 60.0;

/// The highest speed of any particle in this many ticks, m/s.
fn fastest(world: &mut Simulation, ticks: u32) -> f32 {
    let mut worst = 0.0_f32;
    for _ in 0..ticks {
        world.step(DT).unwrap();
        let particles = &world.particles;
        let speeds = (0..particles.len()).map(|i| particles.velocity(i).length());
        worst = speeds.fold(worst, f32::max);
    }
    worst
}

/// Penetration of the deepest particle in a solid, metres.
fn deepest(world: &Simulation, solid: &Collider) -> f32 {
    let particles = &world.particles;
    let depth = |i: usize| {
        let at = solid.end.rotation.transpose() * (particles.position(i) - solid.end.translation);
        particles.radius(i) - solid.shape.nearest(at).distance
    };
    (0..particles.len()).map(depth).fold(0.0, f32::max)
}

fn empty(substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.settings.substeps = substeps;
    world
}

/// Solids whose highest point is the origin, each more than 1 m deep and wide there.
fn solids() -> Vec<(&'static str, Collider)> {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5;
    let corners: Vec<Vec3> = (0..8).map(|i| corner(i) * Vec3::new(3.0, 2.0, 3.0)).collect();
    let sides = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4]];
    let more = [[2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]];
    let at = |shape: Shape, y: f32| Collider::fixed(shape, Frame::at(Vec3::Y * y));
    let across = Quat::from_xyzw(
        core::f32::consts::FRAC_1_SQRT_2,
        0.0,
        0.0,
        core::f32::consts::FRAC_1_SQRT_2,
    );
    vec![
        ("half-space", at(Shape::half_space(), 0.0)),
        ("box", at(Shape::cuboid(Vec3::new(3.0, 2.0, 3.0)).unwrap(), -1.0)),
        ("sphere", at(Shape::sphere(1.5).unwrap(), -1.5)),
        (
            "capsule",
            Collider::fixed(Shape::capsule(1.0, 4.0).unwrap(), Frame::new(Vec3::NEG_Y, across)),
        ),
        ("cylinder", at(Shape::cylinder(1.5, 2.0).unwrap(), -1.0)),
        ("hull", at(Shape::hull(&corners).unwrap(), -1.0)),
        ("mesh", at(Shape::mesh(corners, [sides, more].concat()).unwrap(), -1.0)),
    ]
}

fn level() -> Quat {
    Quat::from_xyzw(1.0, 0.0, 0.0, -1.0).normalize()
}

#[test]
fn cloth_that_begins_inside_is_put_out_in_peace() {
    for substeps in [4, 10, 40] {
        for (name, collider) in solids() {
            for depth in [0.05, 0.4] {
                for tilt in [0.0, 0.5] {
                    let mut world = empty(substeps);
                    world.colliders.push(collider.clone());
                    let turn = Quat::from_xyzw(0.3 * tilt, 0.0, tilt, 1.0).normalize() * level();
                    let cloth = cloth_grid(&ClothSpec::default()).unwrap();
                    let cloth = cloth.transformed(turn, Vec3::NEG_Y * depth);
                    cloth.build_colliding(&mut world, BodyContacts::default()).unwrap();
                    let worst = fastest(&mut world, 60);
                    let place = format!("{name}, {substeps} substeps, {depth} m, tilt {tilt}");
                    // It is pushed out at 2 m/s, crumples more and more where the directions out differ, and slides off a round shape.
                    let most = if name == "sphere" { 18.0 } else { 9.0 };
                    assert!(worst < most, "{place}: {worst} m/s");
                    let left = deepest(&world, &collider);
                    assert!(left < 1e-3, "{place}: {left} m");
                }
            }
        }
    }
}

#[test]
fn particles_and_ropes_that_begin_inside_are_put_out_in_peace() {
    for substeps in [4, 10, 40] {
        for (name, collider) in solids() {
            for depth in [0.05, 0.15, 0.4] {
                let mut world = empty(substeps);
                world.colliders.push(collider.clone());
                for i in 0..5 {
                    let seed = ParticleSeed::at(Vec3::new(0.1 * i as f32, -depth, 0.05))
                        .with_radius(0.02 * i as f32)
                        .with_mass(10f32.powi(i - 2));
                    world.particles.push(seed).unwrap();
                }
                let spec = RopeSpec {
                    from: Vec3::new(-0.5, -depth, 0.0),
                    to: Vec3::new(0.5, 0.2 - depth, 0.2),
                    ..Default::default()
                };
                rope(&spec).unwrap().build(&mut world).unwrap();
                let worst = fastest(&mut world, 30);
                assert!(worst < 4.0, "{name}, {substeps} substeps, {depth} m: {worst} m/s");
                let left = deepest(&world, &collider);
                assert!(left < 1e-3, "{name}, {substeps} substeps, {depth} m: {left} m");
            }
        }
    }
}

/// The highest speeds of twelve figures in each solid, which start there in various positions and orientations, or with some of their particles pinned.
fn put_out_figures(substeps: u32, seed: &mut u32) -> Vec<(f32, String)> {
    let mut next = move || {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / 16_777_216.0
    };
    let figure: Blueprint = ragdoll(&RagdollSpec::default()).unwrap();
    let mut all = Vec::new();
    for (name, collider) in solids() {
        for i in 0..12 {
            let mut world = empty(substeps);
            world.colliders.push(collider.clone());
            let turn =
                Quat::from_xyzw(next() - 0.5, next() - 0.5, next() - 0.5, next() - 0.5).normalize();
            let at = Vec3::new(next() - 0.5, 0.0, next() - 0.5);
            let mut body = figure.transformed(turn, at);
            let low = body.particles.iter().map(|p| p.position.y).fold(f32::MAX, f32::min);
            let depth = 0.05 + 0.25 * next();
            let lift = -depth - low;
            body = body.transformed(Quat::IDENTITY, Vec3::Y * lift);
            let pins = i % 3;
            for _ in 0..pins {
                let which = (next() * body.particles.len() as f32) as u32;
                let _ = body.pin(which);
            }
            body.build_colliding(&mut world, BodyContacts::default()).unwrap();
            let place = format!("{name}, {substeps} substeps, {depth} m, {pins} pins");
            all.push((fastest(&mut world, 60), place));
        }
    }
    all
}

#[test]
fn ragdolls_that_begin_inside_are_put_out_in_peace() {
    let mut seed = 7;
    for substeps in [4, 10, 40] {
        for (worst, place) in put_out_figures(substeps, &mut seed) {
            // A limb that is pushed out swings faster than its middle, and some figures fall off.
            assert!(worst < 16.0, "{place}: {worst} m/s");
        }
    }
}

/// To take the speed of a recovery off, a contact near a pin was solved anew for impulses instead of their changes, and a torso beside its pin came to turn at
/// 250 rad/s by that; and a pinned body could be moved by as much as a tower needs, 10 m/s at four substeps. Of 840 figures some left at 59, 44 and 24 m/s.
#[test]
fn no_figure_is_thrown_out() {
    let all = (1..=10).flat_map(|n| put_out_figures(4, &mut (7919 * n)));
    let mut all: Vec<(f32, String)> = all.collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(all[all.len() * 99 / 100].0 < 14.0, "{:?}", &all[all.len() * 99 / 100]);
    assert!(all[all.len() - 1].0 < 22.0, "{:?}", all.last());
}

#[test]
fn cloth_that_begins_inside_of_a_body_is_put_out_in_peace() {
    for substeps in [4, 10, 40] {
        for mass in [5.0, 500.0] {
            let mut world = empty(substeps);
            world.colliders.push(Collider::fixed(Shape::half_space(), Frame::IDENTITY));
            let size = Vec3::new(1.5, 0.8, 1.5);
            let brick = box_3d(&BoxSpec { size, mass, ..BoxSpec::default() }).unwrap();
            let brick = brick.transformed(Quat::IDENTITY, Vec3::Y * 0.4);
            brick.build_colliding(&mut world, BodyContacts::default()).unwrap();
            let cloth = cloth_grid(&ClothSpec::default()).unwrap();
            let cloth = cloth.transformed(level(), Vec3::Y * 0.6);
            cloth.build_colliding(&mut world, BodyContacts::default()).unwrap();
            let worst = fastest(&mut world, 60);
            assert!(worst < 9.0, "{substeps} substeps, {mass} kg: {worst} m/s");
        }
    }
}

/// A body that approaches is stopped as before, however thin the obstacle, and a body that moves out by itself keeps its speed.
#[test]
fn what_comes_from_outside_is_stopped_and_what_leaves_leaves() {
    for substeps in [1, 4, 10, 40] {
        for radius in [0.0, 0.02] {
            let mut world = empty(substeps);
            let plate = Shape::cuboid(Vec3::new(4.0, 0.001, 4.0)).unwrap();
            world.colliders.push(Collider::fixed(plate, Frame::at(Vec3::ZERO)));
            for (i, speed) in [1.0, 30.0, 400.0].into_iter().enumerate() {
                let at = Vec3::new(i as f32 - 1.0, 0.3, 0.0);
                let seed = ParticleSeed::at(at).with_velocity(Vec3::NEG_Y * speed);
                world.particles.push(seed.with_radius(radius)).unwrap();
            }
            for _ in 0..60 {
                world.step(DT).unwrap();
                let lowest = (0..3).map(|i| world.particles.position(i).y).fold(f32::MAX, f32::min);
                assert!(lowest > radius - 1e-4, "{substeps} substeps, radius {radius}: {lowest}");
            }
        }
        let mut world = empty(substeps);
        world.forces.gravity = Vec3::ZERO;
        world.colliders.push(Collider::fixed(Shape::half_space(), Frame::at(Vec3::ZERO)));
        let seed = ParticleSeed::at(Vec3::NEG_Y * 0.2).with_velocity(Vec3::Y * 6.0);
        world.particles.push(seed).unwrap();
        fastest(&mut world, 30);
        let speed = world.particles.velocity(0).y;
        assert!((speed - 6.0).abs() < 1e-3, "{substeps} substeps: {speed} m/s");
    }
}
