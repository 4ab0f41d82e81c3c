//! Two boxes: no contact is missed, and depths are right.

use glam::Vec3;

use super::super::BoxPairs;
use super::*;
use crate::lanes::InstructionSet;

/// The separation of two boxes along a direction.
fn along(ha: Vec3, hb: Vec3, frame: &Frame, n: Vec3) -> f32 {
    frame.translation.dot(n) - hb.dot(n.abs()) - ha.dot(frame.turn_back(n).abs())
}

/// The greatest error of a depth that the bias towards faces causes.
fn slack(ha: Vec3, hb: Vec3, apart: f32) -> f32 {
    2.0 * (0.03 * apart.abs() + 2e-3 * ha.min_element().min(hb.min_element())) + 1e-4
}

fn random_boxes(random: &mut Random) -> (Vec3, Vec3, Frame) {
    let ha = random.vector() * 0.4 + Vec3::splat(0.6);
    let hb = random.vector() * 0.4 + Vec3::splat(0.6);
    (ha, hb, random.frame(1.6))
}

fn on_surface(point: Vec3, half: Vec3) -> f32 {
    let out = point.abs() - half;
    let outside = out.max(Vec3::ZERO).length();
    if outside > 0.0 { outside } else { out.max_element().abs() }
}

#[test]
fn depth_is_the_least_over_all_directions_and_none_is_missed_that_is_within_reach() {
    let mut random = Random::new(1);
    let (reach, mut overlapping, mut near, mut missed, mut worst) = (0.1, 0, 0, 0, 0.0_f32);
    let (mut shallow, mut by_corners) = (0, 0);
    for _ in 0..3000 {
        let (ha, hb, frame) = random_boxes(&mut random);
        let apart = brute_force(|n| along(ha, hb, &frame, n));
        let (a, b) = (Shape::cuboid(ha * 2.0).unwrap(), Shape::cuboid(hb * 2.0).unwrap());
        let found = all(&a, &b, &frame, reach);
        for manifold in &found {
            check(manifold, &frame, reach);
        }
        let deepest = found.iter().flat_map(Manifold::points).map(|p| p.distance).reduce(f32::min);
        if apart > reach + 1e-3 {
            assert_eq!(found, [], "{apart}");
        } else if apart < reach - 1e-3 {
            missed += usize::from(found.is_empty());
        }
        let Some(deepest) = deepest else { continue };
        if apart > 0.0 {
            near += 1;
            assert!(deepest <= apart + slack(ha, hb, apart), "{deepest} {apart}");
        } else {
            overlapping += 1;
            let off = (deepest - apart).abs() / slack(ha, hb, apart);
            worst = worst.max(off);
        }
        if apart < -1e-3 && apart > -0.1 {
            shallow += 1;
            let inside = |p: Vec3, half: Vec3| (p.abs() - half).max_element() < 0.0;
            let corners = crate::collide::manifold::boxes::edges::SIGNS;
            let any = corners
                .iter()
                .any(|c| inside(frame.point(*c * ha), hb) || inside(frame.local(*c * hb), ha));
            by_corners += usize::from(!any);
        }
    }
    println!(
        "overlapping {overlapping}, near {near}, missed {missed}, worst {worst} of the slack; {by_corners} of {shallow} shallow without a corner inside"
    );
    assert!(overlapping > 500 && near > 50 && shallow > 100);
    assert_eq!(missed, 0);
    assert!(worst <= 1.0, "{worst}");
    assert!(by_corners * 10 > shallow, "this test should show what corners alone miss");
}

#[test]
fn points_lie_on_both_surfaces() {
    let mut random = Random::new(2);
    let mut worst = 0.0_f32;
    for _ in 0..20_000 {
        let (ha, hb, frame) = random_boxes(&mut random);
        let (a, b) = (Shape::cuboid(ha * 2.0).unwrap(), Shape::cuboid(hb * 2.0).unwrap());
        for manifold in all(&a, &b, &frame, 0.2) {
            check(&manifold, &frame, 0.2);
            for p in manifold.points() {
                worst = worst.max(on_surface(p.on_a, ha)).max(on_surface(p.on_b, hb));
            }
        }
    }
    println!("off the surface by {worst}");
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn swapped_boxes_touch_in_the_same_places() {
    let mut random = Random::new(3);
    let mut both = 0;
    for _ in 0..2000 {
        let (ha, hb, frame) = random_boxes(&mut random);
        let (a, b) = (Shape::cuboid(ha * 2.0).unwrap(), Shape::cuboid(hb * 2.0).unwrap());
        let back = crate::collide::manifold::inverse(&frame);
        let (one, other) = (points(&a, &b, &frame, 0.1), points(&b, &a, &back, 0.1));
        assert_eq!(one.is_empty(), other.is_empty());
        let least =
            |points: &[Point]| points.iter().map(|p| p.distance).fold(f32::INFINITY, f32::min);
        if !one.is_empty() {
            both += 1;
            // One order may take a face and the other an edge or the other box's face, which the bias treats as equal.
            assert!(
                (least(&one) - least(&other)).abs() < slack(ha, hb, least(&one)),
                "{one:?} {other:?}"
            );
        }
    }
    assert!(both > 500);
}

#[test]
fn a_face_on_a_face_gives_four_points_that_span_what_they_share() {
    let (a, b) = (
        Shape::cuboid(Vec3::splat(2.0)).unwrap(),
        Shape::cuboid(Vec3::new(4.0, 1.0, 2.0)).unwrap(),
    );
    for lift in [-0.01, 0.0, 0.01] {
        let frame = Frame::at(Vec3::new(1.5, 1.5 + lift, 0.5));
        let found = all(&a, &b, &frame, 0.02);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].normal, Vec3::Y);
        let mut at: Vec<_> = found[0].points().iter().map(|p| (p.on_b.x, p.on_b.z)).collect();
        // In tenths, because rounding displaces points on a rim.
        at.sort_by_key(|(x, z)| ((x * 10.0).round() as i32, (z * 10.0).round() as i32));
        let expected = [(0.5, -0.5), (0.5, 1.0), (2.0, -0.5), (2.0, 1.0)];
        assert_eq!(at.len(), 4);
        for (p, q) in at.iter().zip(expected) {
            assert!((p.0 - q.0).abs() < 1e-5 && (p.1 - q.1).abs() < 1e-5, "{at:?}");
        }
        assert!(found[0].points().iter().all(|p| (p.distance - lift).abs() < 1e-5));
    }
    // Turned by 45° the common area has eight corners, of which four are kept.
    let unit = Shape::cuboid(Vec3::splat(2.0)).unwrap();
    let frame = turned(Vec3::Y * 1.99, Vec3::Y, core::f32::consts::FRAC_PI_4);
    let found = all(&unit, &unit, &frame, 0.0);
    assert_eq!(found[0].points().len(), 4);
    let centre = found[0].points().iter().map(|p| p.on_b).sum::<Vec3>() * 0.25;
    assert!(centre.with_y(0.0).length() < 0.3, "{centre}");
}

#[test]
fn a_box_at_rest_keeps_its_face_whatever_its_noise() {
    let mut random = Random::new(4);
    let unit = Shape::cuboid(Vec3::ONE).unwrap();
    for turn in [0.0, 0.3, core::f32::consts::FRAC_PI_4, 1.2] {
        for _ in 0..500 {
            let axis = (Vec3::Y + random.vector() * 1e-4).normalize();
            let place = Vec3::new(0.2, 1.0, 0.1) + random.vector() * 1e-4;
            let found = all(&unit, &unit, &turned(place, axis, turn), 0.01);
            assert_eq!(found.len(), 1);
            assert!(found[0].normal.y > 0.999 && found[0].points().len() == 4, "{found:?}");
        }
    }
}

#[test]
fn edges_that_cross_touch_in_one_point() {
    let unit = Shape::cuboid(Vec3::splat(2.0)).unwrap();
    let quarter = core::f32::consts::FRAC_PI_4;
    // The upper box stands on an edge along x, the lower one on an edge along z: both are turned by 45°.
    let lower = turned(Vec3::ZERO, Vec3::Z, quarter);
    for lift in [-0.05, 0.05] {
        let height = 2.0 * core::f32::consts::SQRT_2 + lift;
        let upper = turned(Vec3::Y * height, Vec3::X, quarter);
        let frame = upper.from_within(&lower);
        let found = all(&unit, &unit, &frame, 0.06);
        assert_eq!(found.len(), 1);
        let normal = lower.turn(found[0].normal);
        assert!((normal - Vec3::Y).length() < 1e-4, "{normal}");
        let [point] = found[0].points() else { panic!("{found:?}") };
        assert!((point.distance - lift).abs() < 1e-4);
        assert!(lower.point(point.on_b).with_y(0.0).length() < 1e-4);
    }
}

#[test]
fn past_the_rim_corners_and_parallel_edges_are_found_at_their_distance() {
    let unit = Shape::cuboid(Vec3::splat(2.0)).unwrap();
    // Corner to corner, and two parallel edges.
    for (step, count) in [(Vec3::ONE * 0.01, 1), (Vec3::new(0.01, 0.01, -2.0), 2)] {
        let found = all(&unit, &unit, &Frame::at(Vec3::splat(2.0) + step), 0.05);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].points().len(), count, "{found:?}");
        let apart = step.max(Vec3::ZERO).length();
        assert!(found[0].points().iter().all(|p| (p.distance - apart).abs() < 1e-5));
        assert_eq!(all(&unit, &unit, &Frame::at(Vec3::splat(2.0) + step), 0.9 * apart), []);
    }
}

#[test]
fn what_is_degenerate_gives_finite_points() {
    let sizes = [Vec3::ONE, Vec3::splat(1e-3), Vec3::splat(1e3), Vec3::new(10.0, 1e-3, 10.0)];
    let mut random = Random::new(5);
    let mut hits = 0;
    for ha in sizes {
        for hb in sizes {
            let (a, b) = (Shape::cuboid(ha * 2.0).unwrap(), Shape::cuboid(hb * 2.0).unwrap());
            let on_top = Vec3::Y * (ha.y + hb.y);
            for place in [Vec3::ZERO, on_top, ha + hb, on_top * 0.5, Vec3::splat(1e-20)] {
                for angle in [0.0, 1e-7, 1e-4, 1e-3, core::f32::consts::FRAC_PI_2, 0.5] {
                    for axis in [Vec3::Y, Vec3::X, random.vector().normalize_or(Vec3::Z)] {
                        let frame = turned(place, axis, angle);
                        for manifold in all(&a, &b, &frame, 1e-3) {
                            assert!(manifold.normal.is_finite());
                            let unit = (manifold.normal.length() - 1.0).abs();
                            assert!(unit < 1e-3, "{unit} {ha} {hb} {place} {angle}");
                            assert!(manifold.points().iter().all(|p| p.distance.is_finite()));
                            hits += 1;
                        }
                        // A box inside another must not be missed.
                        if place == Vec3::ZERO {
                            assert!(!points(&a, &b, &frame, 0.0).is_empty(), "{ha} {hb} {frame:?}");
                        }
                    }
                }
            }
        }
    }
    assert!(hits > 800, "{hits}");
}

#[test]
fn a_small_box_lies_flat_on_a_huge_one() {
    let (small, huge) = (
        Shape::cuboid(Vec3::splat(0.2)).unwrap(),
        Shape::cuboid(Vec3::new(1000.0, 20.0, 1000.0)).unwrap(),
    );
    for turn in [0.0, 1e-3, 0.7] {
        let frame = turned(Vec3::new(100.0, 10.0999, -200.0), Vec3::Y, turn);
        let found = all(&small, &huge, &frame, 0.01);
        assert_eq!((found[0].normal, found[0].points().len()), (Vec3::Y, 4));
        assert!(found[0].points().iter().all(|p| p.distance.abs() < 2e-4), "{found:?}");
    }
}

/// A box lies across two others and leans away from one of them by three thousandths. Its lowest corner is then far below the top of that one, and the edges
/// that cross there are further apart than the face separation suggests; the contact area is a triangle nevertheless.
#[test]
fn a_box_that_leans_a_little_keeps_the_points_of_its_face() {
    let half = Vec3::splat(0.25);
    let [a, b] = [half; 2].map(|half| Shape::cuboid(half * 2.0).unwrap());
    for lean in [-0.004_f32, -0.003, 0.0, 0.003, 0.004] {
        let turned = Quat::from_xyzw(0.5 * lean, 0.0, 0.0, 1.0).normalize()
            * Quat::from_xyzw(0.0, 0.1147, 0.0, 0.9934).normalize();
        let frame = Frame::new(Vec3::new(0.085, 0.5 + 0.25 * lean.abs(), -0.508), turned);
        let found = all(&a, &b, &frame, 0.02);
        let [manifold] = &found[..] else { panic!("{lean}: {} manifolds", found.len()) };
        assert!(manifold.normal.y > 0.99, "{lean}: {}", manifold.normal);
        assert!(manifold.points().len() >= 3, "{lean}: {:?}", manifold.points());
    }
}

/// Four of eight points are kept. They used to be those that span the largest area, of which only one touched: the box rocked from one end of its low edge to
/// the other.
#[test]
fn a_box_that_leans_keeps_both_ends_of_its_low_edge() {
    let half = Vec3::splat(0.25);
    let [a, b] = [half; 2].map(|half| Shape::cuboid(half * 2.0).unwrap());
    for yaw in (5..90).step_by(10) {
        for lean in [0.03_f32, 0.05, 0.08] {
            let about = |axis: Vec3, angle: f32| turned(Vec3::ZERO, axis, angle);
            let yaw = about(Vec3::Y, (yaw as f32).to_radians());
            let leans = yaw.rotation * about(Vec3::Z, lean).rotation;
            let high = 0.25 + 0.25 * (libm::cosf(lean) + libm::sinf(lean));
            let frame = Frame { translation: Vec3::Y * high, rotation: leans };
            let found = all(&a, &b, &frame, 0.05);
            let [manifold] = &found[..] else { panic!("{} manifolds", found.len()) };
            let low = manifold.points().iter().filter(|point| point.distance < 1e-4);
            let low: Vec<Vec3> = low.map(|point| point.on_b).collect();
            let long = low.iter().map(|p| p.distance(low[0])).fold(0.0, f32::max);
            assert!(long > 0.2, "{lean}: {:?}", manifold.points());
        }
    }
}

/// Pairs in lanes, some out of reach and one with a NaN: each has the manifold that it has alone, with the same bits on each instruction set.
#[test]
fn pairs_in_a_list_have_the_manifolds_that_each_has_alone() {
    let (mut random, mut pairs, mut alone) = (Random::new(6), BoxPairs::default(), Vec::new());
    for n in 0..1003 {
        let (ha, hb, mut frame) = random_boxes(&mut random);
        if n == 501 {
            frame.translation.y = f32::NAN;
        }
        let [a, b] = [ha, hb].map(|half| Shape::cuboid(half * 2.0).unwrap());
        assert_eq!(pairs.push([&a, &b], &frame, 0.1), Some(n));
        alone.push(all(&a, &b, &frame, 0.1).first().copied().unwrap_or_default());
    }
    let ball = Shape::sphere(1.0).unwrap();
    assert_eq!(pairs.push([&ball, &ball], &Frame::IDENTITY, 0.1), None);
    for instructions in [InstructionSet::Scalar, InstructionSet::Simd128, InstructionSet::best()] {
        assert_eq!(pairs.collide(instructions), alone, "{instructions:?}");
    }
    let touching = alone.iter().filter(|manifold| !manifold.points().is_empty()).count();
    assert!(touching > 300 && touching < 900, "{touching}");
}
