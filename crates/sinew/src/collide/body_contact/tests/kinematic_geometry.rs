//! Kinematic geometry: belts, lifts and turntables; and pinned bodies.

use super::*;
use crate::recipes::{SolidShape, SolidSpec, solid};

#[test]
fn a_box_on_a_belt_goes_with_it() {
    let mut world = world();
    floor(&mut world, rough(0.5));
    let first = add_box(&mut world, Vec3::ONE, 1.0, Vec3::Y * 0.5, Quat::IDENTITY);
    world.colliders[0].end = Frame::at(Vec3::X * (2.0 / 60.0));
    step(&mut world, 3.0);
    let v = velocity(&world, first);
    assert!((v - Vec3::X * 2.0).length() < 1e-3, "{v}");
    // It slides for v/(μ g) seconds until it has the speed of the belt.
    let exact = 2.0 * 3.0 - 2.0 * 2.0 / (2.0 * 0.5 * 9.81);
    assert!((centre(&world, first).x - exact).abs() < 0.02);
}

#[test]
fn a_box_on_a_lift_goes_up_and_down_with_it() {
    let mut world = world();
    let plate = Shape::cuboid(Vec3::new(4.0, 0.2, 4.0)).unwrap();
    world.colliders.push(Collider::fixed(plate, Frame::at(Vec3::Y * -0.1)));
    let first = add_box(&mut world, Vec3::ONE, 1.0, Vec3::Y * 0.5, Quat::IDENTITY);
    let mut worst = 0.0_f32;
    for i in 0..360 {
        let height = |i: i32| 0.8 - 0.8 * libm::cosf(i as f32 / 60.0 * 1.5);
        let lift = |i: i32| Frame::at(Vec3::new(height(i), height(i) - 0.1, 0.0));
        (world.colliders[0].start, world.colliders[0].end) = (lift(i), lift(i + 1));
        world.step(1.0 / 60.0).unwrap();
        let on = centre(&world, first) - Vec3::new(height(i + 1), height(i + 1) + 0.5, 0.0);
        worst = worst.max(on.with_y(3.0 * on.y).length());
    }
    // It slides a little where the speed of the plate jumps from step to step.
    assert!(worst < 0.015, "{worst}");
}

/// The frame of a turntable after a number of ticks, for its rate, rad/s.
fn turntable(rate: f32, tick: i32) -> Frame {
    let angle = libm::fmodf(rate * tick as f32 / 60.0, core::f32::consts::TAU);
    Frame::new(Vec3::Y * -0.1, turn(Vec3::Y, angle))
}

/// Where a box of 0.3 m stays that is set down at 1.5 m from the axis of a turntable with its speed, after so many seconds, in the axes of the turntable. Its
/// friction of 0.5 has to be used by this share.
fn on_a_turntable(substeps: u32, share: f32, seconds: i32) -> Vec3 {
    let mut world = world();
    world.settings.substeps = substeps;
    let plate = Shape::cylinder(3.0, 0.2).unwrap();
    world
        .colliders
        .push(Collider::fixed(plate, Frame::at(Vec3::Y * -0.1)).with_material(rough(0.5)));
    set_material(&mut world, rough(0.5));
    let at = Vec3::new(1.5, 0.15, 0.0);
    let first = add_box(&mut world, Vec3::splat(0.3), 1.0, at, Quat::IDENTITY);
    set_material(&mut world, rough(0.5));
    let rate = libm::sqrtf(share * 0.5 * 9.81 / at.x);
    throw(&mut world, first, Vec3::Y.cross(at) * rate, Vec3::Y * rate);
    for tick in 0..60 * seconds {
        let [start, end] = [tick, tick + 1].map(|tick| turntable(rate, tick));
        (world.colliders[0].start, world.colliders[0].end) = (start, end);
        world.step(1.0 / 60.0).unwrap();
    }
    turntable(rate, 60 * seconds).rotation.transpose() * centre(&world, first)
}

/// The slip of a contact was measured where the turntable had been when the substep began, although the box had gone on along it: that misses `(ωh)² r` of what
/// the surface moves inward. The box drifted outward by `ω² r h`, 4 mm/s at half of its friction, and flew off the rim. And the accumulated slip, which holds it,
/// did not turn with the surface.
#[test]
fn a_box_on_a_turntable_stays_where_it_was_set_down() {
    for (substeps, off) in [(4, 6e-3), (10, 1e-3), (40, 1e-3)] {
        for share in [0.5, 0.9] {
            let at = on_a_turntable(substeps, share, 30);
            let moved = (at - Vec3::new(1.5, 0.15, 0.0)).length();
            println!("{substeps} substeps, {share} of its friction: {moved} m");
            assert!(moved < off, "{substeps}, {share}: {moved}");
        }
    }
    // A tenth more than its friction can hold.
    assert!(on_a_turntable(10, 1.1, 10).length() > 3.0);
}

/// A ball that rolls on a turntable runs in a circle, wherever it is, at two sevenths of the turntable's rate.
#[test]
fn a_ball_on_a_turntable_circles_at_two_sevenths_of_its_rate() {
    for substeps in [4, 10, 40] {
        let mut world = world();
        world.settings.substeps = substeps;
        let plate = Shape::cylinder(20.0, 0.2).unwrap();
        world.colliders.push(Collider::fixed(plate, Frame::at(Vec3::Y * -0.1)));
        let (rate, at, radius) = (2.0, Vec3::new(1.0, 0.25, 0.0), 0.25);
        let shape = Shape::sphere(radius).unwrap();
        let spec = SolidSpec { shape: SolidShape::Collider(shape.clone()), ..SolidSpec::default() };
        let first = add(&mut world, &solid(&spec).unwrap(), shape, at, Quat::IDENTITY);
        let surface = Vec3::Y.cross(at) * rate;
        let velocity = surface * (2.0 / 7.0);
        throw(&mut world, first, velocity, Vec3::Y.cross(velocity - surface) / radius);
        // Eleven turns of the turntable are three circles and a seventh.
        let ticks = 1320;
        for tick in 0..ticks {
            let [start, end] = [tick, tick + 1].map(|tick| turntable(rate, tick));
            (world.colliders[0].start, world.colliders[0].end) = (start, end);
            world.step(1.0 / 60.0).unwrap();
        }
        let angle = rate * (2.0 / 7.0) * ticks as f32 / 60.0;
        let exact = Vec3::new(libm::cosf(angle), radius, -libm::sinf(angle));
        let off = (centre(&world, first) - exact).length();
        assert!(off < 0.01, "{substeps}: off by {off} m");
    }
}

#[test]
fn a_box_with_pinned_particles_turns_about_them_when_it_is_hit() {
    for pins in [&[0][..], &[0, 2], &[0, 2, 4]] {
        let mut world = world();
        world.forces.gravity = Vec3::ZERO;
        set_material(&mut world, rough(0.5));
        let spec = BoxSpec { layout: BoxLayout::Equimomental, ..BoxSpec::default() };
        let mut body = box_3d(&spec).unwrap();
        for &pin in pins {
            body.pin(pin).unwrap();
        }
        let shape = Shape::cuboid(Vec3::ONE).unwrap();
        let door = add(&mut world, &body, shape, Vec3::ZERO, Quat::IDENTITY);
        let before: Vec<_> = (0..8).map(|i| world.particles.position(door + i)).collect();
        let at = Vec3::new(0.3, 0.1, 1.5);
        let ball = add_box(&mut world, Vec3::splat(0.4), 1.0, at, Quat::IDENTITY);
        throw(&mut world, ball, Vec3::Z * -3.0, Vec3::ZERO);
        step(&mut world, 0.5);
        for &pin in pins {
            let row = pin as usize;
            assert_eq!(world.particles.position(door + row), before[row]);
        }
        let moved: f32 = (0..8)
            .map(|i| (world.particles.position(door + i) - before[i]).length())
            .fold(0.0, f32::max);
        if pins.len() > 2 {
            assert!(moved < 1e-6);
        } else {
            assert!(moved > 0.1);
        }
        // Nothing passed through.
        assert!(velocity(&world, ball).z > -3.0 && centre(&world, ball).is_finite());
    }
}
