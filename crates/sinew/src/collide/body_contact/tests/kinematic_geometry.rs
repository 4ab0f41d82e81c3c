//! Kinematic geometry: belts, lifts and turntables; and pinned bodies.

use super::*;

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

#[test]
fn a_box_on_a_turntable_goes_round_with_it() {
    let mut world = world();
    let plate = Shape::cylinder(3.0, 0.2).unwrap();
    world.colliders.push(Collider::fixed(plate, Frame::at(Vec3::Y * -0.1)));
    let first =
        add_box(&mut world, Vec3::splat(0.5), 1.0, Vec3::new(1.0, 0.25, 0.0), Quat::IDENTITY);
    // 1 rad/s at 1 m needs a tenth of the available friction.
    throw(&mut world, first, Vec3::Z * -1.0, Vec3::Y);
    for i in 0..360 {
        let frame = |i: i32| Frame::new(Vec3::Y * -0.1, turn(Vec3::Y, i as f32 / 60.0));
        (world.colliders[0].start, world.colliders[0].end) = (frame(i), frame(i + 1));
        world.step(1.0 / 60.0).unwrap();
    }
    let at = centre(&world, first);
    let exact = Vec3::new(libm::cosf(6.0), 0.25, -libm::sinf(6.0));
    assert!((at - exact).length() < 0.02, "{at} {exact}");
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
