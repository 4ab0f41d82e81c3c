//! Heaps, ragdolls, and unusual contacts.

use super::*;
use crate::collide::Frame;
use crate::pose::pose;
use crate::recipes::{RagdollSpec, ragdoll};

/// Adds boxes of random sizes above each other.
pub(super) fn pour(world: &mut Simulation, count: usize, seed: u64) -> Vec<usize> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|i| {
            let size = random.vector() * 0.35 + 0.65;
            let at = Vec3::new(1.5 * random.number(), 1.0 + i as f32 * 0.35, 1.5 * random.number());
            let turned = turn(random.vector(), 3.0 * random.fraction());
            add_box(world, size, 1.0 + random.fraction(), at, turned)
        })
        .collect()
}

/// Height of the lowest corner of a box, metres.
fn lowest(world: &Simulation, first: usize) -> f32 {
    // Particles are at 1/√3 of the way to the corners.
    let middle = centre(world, first);
    let out = |i: usize| middle + (world.particles.position(first + i) - middle) * 3.0_f32.sqrt();
    (0..8).map(|i| out(i).y).fold(f32::INFINITY, f32::min)
}

/// Height of the lowest point of all shapes, metres.
fn lowest_of_shapes(world: &Simulation) -> f32 {
    let particles = &world.particles;
    let heights = world.body_colliders().iter().map(|collider| {
        let points = collider.rows.iter().map(|&row| row as usize).zip(&*collider.rest);
        let points = points.map(|(i, &rest)| (particles.position(i), rest, particles.mass(i)));
        let pose = pose(points, Quat::IDENTITY).unwrap();
        let rotation = glam::Mat3::from_quat(pose.rotation);
        collider.shape.bounds_in(&Frame { translation: pose.translation, rotation }).0.y
    });
    heights.fold(f32::INFINITY, f32::min)
}

#[test]
fn a_hundred_boxes_poured_out_come_to_rest_above_the_floor() {
    let mut world = world();
    floor(&mut world, rough(0.5));
    let boxes = pour(&mut world, 100, 7);
    let mut deepest = 0.0_f32;
    for _ in 0..20 {
        for _ in 0..60 {
            world.step(1.0 / 60.0).unwrap();
            let low = boxes.iter().map(|&first| lowest(&world, first));
            deepest = deepest.min(low.fold(f32::INFINITY, f32::min));
        }
    }
    let low = boxes.iter().map(|&first| lowest(&world, first));
    let low = low.fold(f32::INFINITY, f32::min);
    // The last ones arrive at 26 m/s, which is 4.3 cm a substep, and turn; the depth of the deepest corner is chance: 5 to 13 mm with eight other seeds, and
    // 6 cm with one of them before restitution was one problem.
    assert!(deepest > -0.06 && low > -2e-3, "{deepest} {low}");
    assert!(speed(&world) < 1e-3, "{}", speed(&world));
}

#[test]
fn two_boxes_that_meet_edge_on_edge_stay_sound() {
    for angle in [0.0, 0.785, 1.2] {
        let mut world = world();
        floor(&mut world, rough(0.5));
        let edge = turn(Vec3::X, core::f32::consts::FRAC_PI_4);
        let low = add_box(&mut world, Vec3::ONE, 1.0, Vec3::Y * 0.71, edge);
        let across = turn(Vec3::Y, angle);
        let both = Quat::from_mat3(&(glam::Mat3::from_quat(across) * glam::Mat3::from_quat(edge)));
        let high = add_box(&mut world, Vec3::ONE, 1.0, Vec3::Y * 2.3, both);
        let mut top = 0.0_f32;
        for _ in 0..600 {
            world.step(1.0 / 60.0).unwrap();
            top = top.max(speed(&world));
        }
        assert!(top < 8.0 && speed(&world) < 0.02);
        assert!(centre(&world, low).y > 0.49 && centre(&world, high).y > 0.49);
    }
}

#[test]
fn a_ragdoll_lies_down_on_the_floor_and_rests() {
    let mut world = world();
    floor(&mut world, rough(0.6));
    let body = ragdoll(&RagdollSpec::default()).unwrap();
    let turned = turn(Vec3::new(1.0, 0.0, 0.3), 0.4);
    let rows = body.transformed(turned, Vec3::Y * 1.0).build(&mut world).unwrap();
    let first = rows.start as u32;
    for part in &body.parts {
        let limb = part.particles.len() < 4 && part.size.x == part.size.z;
        let shape = if limb {
            let radius = part.size.x * 0.5;
            Shape::capsule(radius, part.size.y - 2.0 * radius)
        } else {
            Shape::cuboid(part.size)
        };
        world.body_colliders_mut().push(BodyCollider {
            rows: part.particles.iter().map(|&p| first + p).collect(),
            rest: part.rest.clone().into(),
            shape: shape.unwrap(),
            id: u64::from(first + part.particles[0]),
        });
    }
    step(&mut world, 12.0);
    // The pins stick out.
    let low =
        rows.clone().take(18).map(|i| world.particles.position(i).y).fold(f32::INFINITY, f32::min);
    let high = rows.map(|i| world.particles.position(i).y).fold(0.0, f32::max);
    // No bone is deeper in the floor than its load overlaps it, and a joint, such as the tip of the nose, no deeper than the bone that it is on.
    let deepest = -lowest_of_shapes(&world);
    assert!(deepest < 1e-4 && low > -deepest - 1e-6 && high < 0.6, "{deepest} {low} {high}");
    assert!(speed(&world) < 0.02, "{}", speed(&world));
}

#[test]
fn a_fast_box_does_not_go_through_a_thin_wall() {
    for speed in [20.0, 100.0, 300.0] {
        let mut world = world();
        world.forces.gravity = Vec3::ZERO;
        let wall = Shape::cuboid(Vec3::new(0.04, 10.0, 10.0)).unwrap();
        world.colliders.push(Collider::fixed(wall, Frame::IDENTITY));
        let first =
            add_box(&mut world, Vec3::splat(0.2), 1.0, Vec3::X * -4.0, turn(Vec3::ONE, 0.4));
        throw(&mut world, first, Vec3::X * speed, Vec3::new(3.0, 1.0, 0.0));
        step(&mut world, 1.0);
        assert!(centre(&world, first).x < 0.0);
    }
}

#[test]
fn a_non_finite_body_does_not_affect_its_neighbours() {
    let mut world = world();
    floor(&mut world, rough(0.5));
    let firsts: Vec<_> = (0..9)
        .map(|i| add_box(&mut world, Vec3::ONE, 1.0, Vec3::Y * (0.5 + i as f32), Quat::IDENTITY))
        .collect();
    step(&mut world, 0.5);
    world.particles.set_velocity(firsts[4], Vec3::NAN);
    step(&mut world, 0.5);
    for &first in &firsts {
        if first != firsts[4] {
            assert!(centre(&world, first).is_finite());
        }
    }
}
