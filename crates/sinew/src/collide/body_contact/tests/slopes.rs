//! Coulomb friction (physics.md F8).

use super::*;
use crate::recipes::{BoxLayout, BoxSpec, box_3d};

/// A box on a slope: its displacement down in two seconds, and the exact one under Coulomb friction.
fn slide(friction: f32, tangent: f32) -> (f32, f32) {
    let mut world = world();
    let angle = libm::atanf(tangent);
    let turned = turn(Vec3::Z, -angle);
    let floor = Collider::fixed(Shape::half_space(), Frame::new(Vec3::ZERO, turned));
    world.colliders.push(floor.with_material(rough(friction)));
    set_material(&mut world, rough(friction));
    let frame = Frame::new(Vec3::ZERO, turned);
    let first =
        add_box(&mut world, Vec3::new(1.0, 0.5, 1.0), 2.0, frame.point(Vec3::Y * 0.25), turned);
    let before = centre(&world, first);
    step(&mut world, 2.0);
    let slid = frame.turn_back(centre(&world, first) - before);
    assert!(slid.z.abs() < 1e-3 && slid.y.abs() < 2e-3, "{slid}");
    let acceleration = 9.81 * (libm::sinf(angle) - friction * libm::cosf(angle));
    (slid.x, 0.5 * acceleration.max(0.0) * 4.0)
}

#[test]
fn a_box_slides_where_the_slope_is_steeper_than_its_friction_and_not_before() {
    for friction in [0.2, 0.5, 0.8] {
        let (still, _) = slide(friction, friction * 0.98);
        let (slid, exact) = slide(friction, friction * 1.1);
        // This close to sliding it creeps, by less than a millimetre a second.
        assert!(still.abs() < 2e-3, "{still}");
        assert!((slid / exact - 1.0).abs() < 0.02, "{slid} {exact}");
    }
}

#[test]
fn a_box_that_slides_stops_after_v2_by_2_mu_g() {
    for (friction, v) in [(0.5, 4.0), (0.25, 2.0), (0.8, 10.0)] {
        let mut world = world();
        floor(&mut world, rough(friction));
        let size = Vec3::new(1.0, 0.4, 1.0);
        let first = add_box(&mut world, size, 1.0, Vec3::Y * 0.2, Quat::IDENTITY);
        throw(&mut world, first, Vec3::X * v, Vec3::ZERO);
        step(&mut world, 4.0);
        let (slid, exact) = (centre(&world, first), v * v / (2.0 * friction * 9.81));
        assert!((slid.x / exact - 1.0).abs() < 0.02, "{slid} {exact}");
        assert!(slid.z.abs() < 0.01 && speed(&world) < 1e-3);
    }
}

#[test]
fn a_box_that_spins_on_the_floor_stops_where_it_is() {
    let mut world = world();
    floor(&mut world, rough(0.5));
    let first = add_box(&mut world, Vec3::new(1.0, 0.4, 1.0), 1.0, Vec3::Y * 0.2, Quat::IDENTITY);
    throw(&mut world, first, Vec3::ZERO, Vec3::Y * 5.0);
    step(&mut world, 3.0);
    assert!(centre(&world, first).with_y(0.0).length() < 0.01 && speed(&world) < 1e-3);
}

/// It touches the floor in a point, about which it used to turn for ever: now as on a patch of a hundredth of its size.
#[test]
fn a_ball_that_spins_on_the_floor_slows_down_as_on_a_small_patch_and_stops() {
    let mut world = world();
    let (friction, radius) = (0.5, 0.5);
    floor(&mut world, rough(friction));
    let spec = BoxSpec { layout: BoxLayout::Equimomental, ..BoxSpec::default() };
    let ball = Shape::sphere(radius).unwrap();
    let body = box_3d(&spec).unwrap();
    let first = add(&mut world, &body, ball, Vec3::Y * radius, Quat::IDENTITY);
    let spin = |world: &Simulation| {
        let at = centre(world, first);
        let each = (first..first + 8).map(|i| {
            let arm = world.particles.position(i) - at;
            (arm.cross(world.particles.velocity(i)).y, arm.with_y(0.0).length_squared())
        });
        let (sum, squares) = each.fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
        sum / squares
    };
    throw(&mut world, first, Vec3::ZERO, Vec3::Y);
    // M = μ m g · s / 100, with half the diagonal of its bounding box; for a mass with the inertia of a cube of 1 m.
    let size = radius * 3.0_f32.sqrt();
    let slowing = friction * 9.81 * size * 0.01 * 6.0;
    step(&mut world, 3.0);
    let (now, exact) = (spin(&world), 1.0 - 3.0 * slowing);
    assert!((now / exact - 1.0).abs() < 0.03, "{now} {exact}");
    step(&mut world, 1.1 / slowing - 3.0);
    assert!(spin(&world).abs() < 1e-3 && speed(&world) < 1e-3, "{}", spin(&world));
    assert!(centre(&world, first).with_y(0.0).length() < 1e-3);
}
