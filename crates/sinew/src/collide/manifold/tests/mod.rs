//! Properties that hold for every pair of shapes.

mod boxes;
mod ground;
mod pairs;
mod slide;

use glam::{Mat3, Quat, Vec3};

use super::super::{Frame, Shape};
use super::{Manifold, ManifoldScratch, Point, collide};
pub(super) use crate::test_random::Random;

/// All manifolds of two shapes.
pub(super) fn all(a: &Shape, b: &Shape, frame: &Frame, reach: f32) -> Vec<Manifold> {
    let mut found = Vec::new();
    collide(a, b, frame, reach, &mut ManifoldScratch::default(), &mut |manifold| {
        found.push(*manifold);
    });
    found
}

/// All points of two shapes.
pub(super) fn points(a: &Shape, b: &Shape, frame: &Frame, reach: f32) -> Vec<Point> {
    all(a, b, frame, reach).iter().flat_map(|m| m.points().to_vec()).collect()
}

/// The greatest separation of two bodies along any direction from `b` to `a`, metres: their distance if positive, else minus their penetration depth.
///
/// `support` gives the separation along a direction. A hill climb from each of 400 directions.
pub(super) fn brute_force(support: impl Fn(Vec3) -> f32) -> f32 {
    let mut best = f32::NEG_INFINITY;
    for i in 0..400 {
        let z = 1.0 - (2.0 * i as f32 + 1.0) / 400.0;
        let angle = i as f32 * 2.399_963;
        let r = (1.0 - z * z).sqrt();
        let mut n = Vec3::new(r * libm::cosf(angle), r * libm::sinf(angle), z);
        let (mut value, mut step) = (support(n), 0.1_f32);
        if value < best - 0.3 {
            continue;
        }
        while step > 1e-5 {
            let side = n.any_orthonormal_vector();
            let other = n.cross(side);
            let around = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| {
                let a = k as f32 * core::f32::consts::FRAC_PI_4;
                (n + (side * libm::cosf(a) + other * libm::sinf(a)) * step).normalize()
            });
            let before = value;
            for m in around {
                let at = support(m);
                if at > value {
                    (value, n) = (at, m);
                }
            }
            if value <= before {
                step *= 0.5;
            }
        }
        best = best.max(value);
    }
    best
}

/// A frame turned about an axis by an angle, radians.
pub(super) fn turned(place: Vec3, axis: Vec3, angle: f32) -> Frame {
    let (s, c) = (libm::sinf(0.5 * angle), libm::cosf(0.5 * angle));
    Frame::new(place, Quat::from_xyzw(axis.x * s, axis.y * s, axis.z * s, c))
}

/// Checks that a manifold is consistent: a unit normal, and distances that fit its points.
pub(super) fn check(manifold: &Manifold, frame: &Frame, reach: f32) {
    assert!((manifold.normal.length() - 1.0).abs() < 1e-4, "{manifold:?}");
    assert!((1..=4).contains(&manifold.points().len()));
    for point in manifold.points() {
        let apart = frame.point(point.on_a) - point.on_b;
        let along = apart.dot(manifold.normal);
        assert!((along - point.distance).abs() < 1e-4, "{along} {manifold:?}");
        assert!(point.distance <= reach + 1e-5, "{manifold:?}");
        assert!((frame.point(point.on_a) - point.on_b).is_finite());
    }
}

#[test]
fn shapes_without_a_finite_place_touch_nothing() {
    let shapes = pairs::convex();
    for a in &shapes {
        for b in shapes.iter().chain([&Shape::half_space()]) {
            for place in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 0.0)] {
                assert_eq!(all(a, b, &Frame::at(place), 0.1), []);
            }
            let frame = Frame { rotation: Mat3::from_diagonal(Vec3::NAN), ..Frame::IDENTITY };
            assert!(all(a, b, &frame, 0.1).iter().all(|m| m.normal.is_finite()));
        }
    }
}
