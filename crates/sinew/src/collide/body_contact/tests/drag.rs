//! Planar drag between body colliders: a share of the velocity is lost in each second.

use super::*;
use crate::constraints::{PlanarDrag, Plane};

fn sticky(along: f32, across: f32) -> Material {
    Material { drag: PlanarDrag { along, across }, ..rough(0.0) }
}

/// A plate of 1 × 0.2 × 1 m on the floor that slides at 3 m/s and spins at 2 rad/s; returns its speed and its spin after a second.
fn slide(world: &mut Simulation) -> (f32, f32) {
    let first = add_box(world, Vec3::new(1.0, 0.2, 1.0), 2.0, Vec3::Y * 0.1, Quat::IDENTITY);
    for i in first..first + 8 {
        let arm = world.particles.position(i) - Vec3::Y * 0.1;
        world.particles.set_velocity(i, Vec3::X * 3.0 + Vec3::Y.cross(arm) * 2.0);
    }
    step(world, 1.0);
    let (place, speed) = (centre(world, first), velocity(world, first));
    let (mut spin, mut inertia) = (0.0, 0.0);
    for i in first..first + 8 {
        let arm = world.particles.position(i) - place;
        spin += arm.cross(world.particles.velocity(i) - speed).y;
        inertia += arm.with_y(0.0).length_squared();
    }
    assert!((place.y - 0.1).abs() < 2e-3, "{place}");
    (speed.length(), spin / inertia)
}

#[test]
fn a_plate_that_slides_and_spins_loses_its_share_of_both_in_a_second() {
    for along in [0.0, 0.5, 0.9] {
        let mut world = world();
        floor(&mut world, sticky(along, 0.0));
        let (speed, spin) = slide(&mut world);
        let left = 1.0 - along;
        assert!((speed - 3.0 * left).abs() < 0.02 * 3.0 * left, "{along}: {speed}");
        assert!((spin - 2.0 * left).abs() < 0.02 * 2.0 * left, "{along}: {spin}");
    }
}

#[test]
fn a_plane_drags_solids_once_and_no_more() {
    let mut world = world();
    let drag = PlanarDrag { along: 0.5, across: 0.0 };
    world.boundaries.planes.push(Plane { drag, ..Plane::ground(0.0).with_friction(0.0) });
    let (speed, _) = slide(&mut world);
    assert!((speed - 1.5).abs() < 0.03, "{speed}");
}

#[test]
fn full_drag_along_stops_sliding_and_across_stops_bouncing() {
    let mut sticking = world();
    floor(&mut sticking, sticky(1.0, 0.0));
    let (speed, spin) = slide(&mut sticking);
    assert!(speed < 1e-3 && spin.abs() < 1e-3, "{speed} {spin}");

    let top = |across: f32| {
        let mut world = world();
        floor(&mut world, Material { restitution: 1.0, ..sticky(0.0, across) });
        let ball = Shape::sphere(0.5).unwrap();
        let body = box_3d(&BoxSpec { layout: BoxLayout::Equimomental, ..BoxSpec::default() });
        let first = add(&mut world, &body.unwrap(), ball, Vec3::Y * 1.5, Quat::IDENTITY);
        step(&mut world, 0.9);
        centre(&world, first).y - 0.5
    };
    let (free, held) = (top(0.0), top(1.0));
    assert!(free > 0.9 && held.abs() < 0.01, "{free} {held}");
}

#[test]
fn drag_between_bodies_keeps_momenta() {
    let mut world = world();
    world.forces.gravity = Vec3::ZERO;
    set_material(&mut world, sticky(0.9, 0.5));
    for (x, v) in [(-0.5, Vec3::new(1.0, 2.0, 0.0)), (0.501, Vec3::ZERO)] {
        let first = add_box(&mut world, Vec3::ONE, 1.0, Vec3::X * x, Quat::IDENTITY);
        (first..first + 8).for_each(|i| world.particles.set_velocity(i, v));
        world.bodies.push(Default::default());
        world.contacts[first / 8].with_bodies = true;
        (first..first + 8).for_each(|i| world.particles.set_body(i, Some(first as u32 / 8)));
    }
    let sums = |world: &Simulation| {
        let mut sums = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..world.particles.len() {
            let p = world.particles.velocity(i) / 8.0;
            sums = (sums.0 + p, sums.1 + world.particles.position(i).cross(p));
        }
        sums
    };
    let before = sums(&world);
    let past = |world: &Simulation| (velocity(world, 0) - velocity(world, 8)).y.abs();
    step(&mut world, 0.2);
    let after = sums(&world);
    // They press each other for a substep or two, each of which takes 0.4 %.
    assert!(past(&world) < 1.99, "it dragged: {}", past(&world));
    assert!(before.0.abs_diff_eq(after.0, 1e-4), "{} {}", before.0, after.0);
    assert!(before.1.abs_diff_eq(after.1, 1e-3), "{} {}", before.1, after.1);
}
