//! A hull is closed and convex and contains all points, whatever the points are.

use super::*;
use crate::test_random::Random;

/// Checks that the hull is closed, of genus 0 and convex, and contains all points; returns its number of corners.
fn assert_hull(points: &[Vec3]) -> usize {
    let faces = convex_hull(points).unwrap();
    let mut sides = BTreeSet::new();
    let mut corners = BTreeSet::new();
    for &[a, b, c] in &faces {
        for side in [(a, b), (b, c), (c, a)] {
            assert!(sides.insert(side), "{side:?} is there twice");
            corners.insert(side.0);
        }
    }
    assert!(sides.iter().all(|&(a, b)| sides.contains(&(b, a))), "it is open");
    assert_eq!(corners.len() + faces.len(), sides.len() / 2 + 2, "Euler's formula");
    let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let size = f64::from((high - low).max_element());
    for t in &faces {
        let [a, b, c] = t.map(|i| points[i as usize].as_dvec3());
        let normal = (b - a).cross(c - a);
        let thick = 4.0 * size * size * size * 1e-8;
        for p in points {
            // Six times a volume: exact for slivers too, whose normal has few valid digits.
            let above = normal.dot(p.as_dvec3() - a);
            assert!(
                above <= thick.min(normal.length() * size * 1e-6 + thick * 1e-3),
                "{t:?} {p} {above}"
            );
        }
    }
    corners.len()
}

#[test]
fn hulls_of_random_points_are_closed_and_convex_and_contain_all() {
    let mut random = Random::new(1);
    for round in 0..60 {
        let count = 4 + round * 5;
        let shift = random.vector() * 100.0 * (round % 3) as f32;
        let shape = [Vec3::ONE, Vec3::new(1.0, 1.0, 1e-3), Vec3::new(1e-3, 1.0, 1e-3)][round % 3];
        let points: Vec<Vec3> = (0..count).map(|_| random.vector() * shape + shift).collect();
        assert_hull(&points);
    }
}

#[test]
fn all_points_of_a_sphere_are_corners() {
    let mut random = Random::new(2);
    let points: Vec<Vec3> = (0..1000).map(|_| random.vector().normalize()).collect();
    let begin = std::time::Instant::now();
    let corners = assert_hull(&points);
    println!("1000 points on a sphere: {corners} corners, {:?} with the checks", begin.elapsed());
    assert_eq!(corners, 1000);
}

#[test]
fn points_in_rows_and_planes_and_in_the_same_place_do_no_harm() {
    let grid: Vec<Vec3> = (0..216)
        .map(|i| Vec3::new((i % 6) as f32, (i / 6 % 6) as f32, (i / 36) as f32) * 0.1)
        .collect();
    assert_hull(&grid);
    let mut random = Random::new(3);
    for _ in 0..50 {
        let mut mixed = grid.clone();
        for i in (1..mixed.len()).rev() {
            mixed.swap(i, (random.number().abs() * (i + 1) as f32) as usize % (i + 1));
        }
        mixed.extend_from_within(..50);
        assert_hull(&mixed);
    }
    // A round column: two rims whose points lie in a plane, and rows of points along the side.
    let column: Vec<Vec3> = (0..400)
        .map(|i| {
            let (sin, cos) = libm::sincosf((i % 40) as f32 * core::f32::consts::TAU / 40.0);
            Vec3::new(cos, (i / 40) as f32 * 0.25, sin)
        })
        .collect();
    assert!(assert_hull(&column) >= 80);
}

#[test]
fn a_cube_is_a_cube_whatever_is_inside_of_it() {
    let mut random = Random::new(4);
    let corner =
        |i: u8| Vec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into()) * 2.0 - 1.0;
    let mut points: Vec<Vec3> = (0..500).map(|_| random.vector()).collect();
    points.extend((0..8).map(corner));
    let faces = convex_hull(&points).unwrap();
    assert_eq!(faces.len(), 12);
    assert!(faces.iter().flatten().all(|&i| i >= 500));
}

#[test]
fn points_without_a_hull_are_refused() {
    let square = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)];
    assert_eq!(convex_hull(&[]), Err(ConvexHullFault::TooFew));
    assert_eq!(convex_hull(&square[..3]), Err(ConvexHullFault::TooFew));
    assert_eq!(convex_hull(&square), Err(ConvexHullFault::Flat));
    assert_eq!(convex_hull(&square.map(|p| p.with_y(0.0))), Err(ConvexHullFault::Flat));
    assert_eq!(convex_hull(&[Vec3::ONE; 9]), Err(ConvexHullFault::Flat));
    assert_eq!(
        convex_hull(&[Vec3::ZERO, Vec3::X, Vec3::ZERO, Vec3::X, Vec3::Y]),
        Err(ConvexHullFault::Flat)
    );
    let spoilt = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z * f32::NAN];
    assert_eq!(convex_hull(&spoilt), Err(ConvexHullFault::NotFinite(3)));
    assert_eq!(convex_hull(&vec![Vec3::ONE; MAX_POINTS + 1]), Err(ConvexHullFault::TooMany));
    // Extreme magnitudes of `f32` are valid points.
    for scale in [1e-38, 3e38] {
        let points = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| p * scale);
        assert_eq!(convex_hull(&points).unwrap().len(), 4, "{scale}");
    }
}
