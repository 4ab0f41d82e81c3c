//! The transform of particles that determine no orientation, or only a part of one: rods, points, and invalid input.

use super::tests::{about, angle, carried, cube, fit, starts};
use super::*;
use crate::test_random::Random;
use std::f32::consts::{PI, TAU};

fn rod(direction: Vec3) -> [Vec3; 3] {
    [-1.0, 0.5, 2.0].map(|x| direction * x)
}

#[test]
fn a_rod_turns_by_the_shortest_arc() {
    let mut random = Random::new(8);
    let mut worst = 0.0_f32;
    for _ in 0..2000 {
        let (along, to) = (random.direction().normalize(), random.direction().normalize());
        let previous = random.rotation();
        let points: Vec<_> = [-1.0, 0.5, 2.0].map(|x| (to * x + Vec3::Y, along * x, 1.0)).to_vec();
        let found = fit(&points, previous);
        let from = previous * along;
        let arc = libm::atan2f(from.cross(to).length(), from.dot(to));
        worst = worst.max((found.rotation * along - to).length());
        worst = worst.max((angle(found.rotation, previous) - arc).abs());
    }
    println!("rod: worst {worst:e}");
    assert!(worst < 1e-5, "{worst:e}");
}

#[test]
fn a_rod_swung_around_by_small_steps_gathers_no_twist() {
    // A rest direction that f32 does not hold exactly, far from the origin, through ten full circles.
    let along = Vec3::new(1.0, 2.0, 3.0).normalize();
    let axis = along.cross(Vec3::X);
    let start = about(Vec3::new(0.3, -0.5, 0.8), 1.0);
    let (axis, mut last) = (start * axis, start);
    for step in 1..=3600 {
        let swing = about(axis, (step % 360) as f32 * (TAU / 360.0));
        let points = carried(&rod(along), |r| swing * (start * r) + Vec3::new(10.0, 20.0, -30.0));
        last = fit(&points, last).rotation;
        assert!(angle(last, swing * start) < 1e-4, "{step}");
    }
}

#[test]
fn a_rod_that_is_reversed_exactly_is_turned_over() {
    for along in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.48, 0.6, 0.64)] {
        let points = carried(&rod(along), |r| -r);
        let found = fit(&points, Quat::IDENTITY).rotation;
        assert!((found * along + along).length() < 1e-6);
        assert!((angle(found, Quat::IDENTITY) - PI).abs() < 1e-6);
        assert_eq!(found, fit(&points, Quat::IDENTITY).rotation);
    }
}

#[test]
fn two_particles_are_a_rod() {
    let rest = [Vec3::ZERO, Vec3::X];
    let points = carried(&rest, |r| Vec3::new(0.0, r.x, 0.0) + Vec3::Z);
    let found = fit(&points, Quat::IDENTITY);
    assert!(angle(found.rotation, about(Vec3::Z, PI / 2.0)) < 1e-6);
    assert!((found.translation - Vec3::Z).length() < 1e-6);
}

#[test]
fn a_thin_rod_has_a_twist_of_its_own_down_to_a_ten_thousandth() {
    let mut random = Random::new(9);
    for width in [1e-1, 1e-2, 1e-3, 1e-4] {
        let mut worst = 0.0_f32;
        for _ in 0..200 {
            let rest = cube().map(|r| r * Vec3::new(1.0, width, width));
            let q = random.rotation();
            for previous in starts(q, &mut random) {
                worst = worst.max(angle(fit(&carried(&rest, |r| q * r), previous).rotation, q));
            }
        }
        println!("width {width:e}: worst {worst:e} rad");
        // The round-off of the positions, divided by the rod's width.
        assert!(worst < 3e-7 / width + 1e-6, "{width:e}: {worst:e}");
    }
}

#[test]
fn one_particle_or_many_in_one_place_keep_the_rotation() {
    let mut random = Random::new(10);
    let previous = random.rotation();
    let (at, rest) = (Vec3::new(0.1, 7.7, -1e5), Vec3::new(0.3, 0.7, 0.9));
    let one = fit(&[(at, rest, 2.0)], previous);
    assert!(angle(one.rotation, previous) < 1e-6);
    assert!((one.point(rest) - at).length() < 1e-2);

    let crushed: Vec<_> = cube().iter().map(|&r| (at, r, random.number() + 1.5)).collect();
    assert!(angle(fit(&crushed, previous).rotation, previous) < 1e-6);
    let shapeless: Vec<_> = cube().iter().map(|&p| (p, rest, random.number() + 1.5)).collect();
    assert!(angle(fit(&shapeless, previous).rotation, previous) < 1e-6);
}

#[test]
fn what_is_not_finite_or_not_there_has_no_pose() {
    let empty: [(Vec3, Vec3, f32); 0] = [];
    assert_eq!(pose(empty.into_iter(), Quat::IDENTITY), None);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for row in 0..8 {
            let mut points = carried(&cube(), |r| r);
            points[row].0.y = bad;
            assert_eq!(pose(points.iter().copied(), Quat::IDENTITY), None);
            points[row] = (Vec3::ZERO, Vec3::X * bad, 1.0);
            assert_eq!(pose(points.iter().copied(), Quat::IDENTITY), None);
            // But it is ignored if it does not count.
            points[row].2 = 0.0;
            assert!(pose(points.iter().copied(), Quat::IDENTITY).is_some());
        }
    }
}

#[test]
fn a_previous_rotation_that_is_none_is_taken_for_the_identity() {
    let points = carried(&rod(Vec3::X), |r| Vec3::new(0.0, r.x, 0.0));
    let expected = fit(&points, Quat::IDENTITY);
    for bad in [0.0, f32::NAN, f32::INFINITY] {
        assert_eq!(fit(&points, Quat::from_xyzw(bad, bad, bad, bad)), expected);
    }
    assert_eq!(fit(&points, Quat::from_xyzw(0.0, 0.0, 0.0, 7.0)), expected);
}
