//! Every kind of shape against every other.

use glam::Vec3;

use super::*;

/// One shape of each convex kind.
pub(super) fn convex() -> Vec<Shape> {
    let corners = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z].map(|p| p * 0.8);
    vec![
        Shape::sphere(0.5).unwrap(),
        Shape::capsule(0.3, 1.2).unwrap(),
        Shape::cuboid(Vec3::new(0.8, 1.0, 1.4)).unwrap(),
        Shape::cylinder(0.4, 1.2).unwrap(),
        Shape::hull(&corners).unwrap(),
    ]
}

/// The support distance of a shape of [`convex`] along a direction.
pub(super) fn support(number: usize, n: Vec3) -> f32 {
    match number {
        0 => 0.5,
        1 => 0.3 + 0.6 * n.y.abs(),
        2 => Vec3::new(0.4, 0.5, 0.7).dot(n.abs()),
        3 => 0.4 * (n.x * n.x + n.z * n.z).sqrt() + 0.6 * n.y.abs(),
        _ => 0.8 * n.abs().max_element(),
    }
}

#[test]
fn every_convex_pair_is_as_deep_as_by_a_search_over_directions() {
    let shapes = convex();
    let names = ["sphere", "capsule", "box", "cylinder", "hull"];
    let reach = 0.1;
    for (i, a) in shapes.iter().enumerate() {
        for (j, b) in shapes.iter().enumerate() {
            let mut random = Random::new(7 + (5 * i + j) as u64);
            let (mut worst, mut missed, mut found_some, mut off) = (0.0_f32, 0, 0, 0.0_f32);
            for _ in 0..300 {
                let frame = random.frame(1.2);
                let apart = brute_force(|n| {
                    frame.translation.dot(n) - support(i, frame.turn_back(n)) - support(j, n)
                });
                let found = all(a, b, &frame, reach);
                assert!(found.len() <= 1);
                for manifold in &found {
                    check(manifold, &frame, reach);
                    found_some += 1;
                    let deepest =
                        manifold.points().iter().map(|p| p.distance).fold(f32::INFINITY, f32::min);
                    worst = worst.max((deepest - apart).abs() - 0.03 * apart.abs());
                    for p in manifold.points() {
                        off = off
                            .max(a.nearest(p.on_a).distance.abs())
                            .max(b.nearest(p.on_b).distance.abs());
                    }
                }
                if apart > reach + 1e-3 {
                    assert!(found.is_empty(), "{} {} {apart}", names[i], names[j]);
                } else if apart < reach - 1e-3 && found.is_empty() {
                    missed += 1;
                }
            }
            println!(
                "{} {}: {found_some} found, {missed} missed, depth off by {worst}, surface by {off}",
                names[i], names[j]
            );
            assert!(found_some > 80, "{} {}", names[i], names[j]);
            assert_eq!(missed, 0, "{} {}", names[i], names[j]);
            // `parry3d` is as accurate as it is for cylinders, which it clips as prisms.
            let library = i.max(j) > 2 && i.min(j) > 0;
            assert!(worst < if library { 6e-3 } else { 3e-3 }, "{} {} {worst}", names[i], names[j]);
            assert!(off < if library { 2e-3 } else { 1e-4 }, "{} {} {off}", names[i], names[j]);
        }
    }
}

#[test]
fn swapped_pairs_touch_as_deep() {
    let mut shapes = convex();
    shapes.push(Shape::half_space());
    let mut random = Random::new(31);
    let mut both = 0;
    for (i, a) in shapes.iter().enumerate() {
        for b in &shapes[i..] {
            for _ in 0..100 {
                let frame = random.frame(0.9);
                let back = crate::collide::manifold::inverse(&frame);
                let (one, other) = (all(a, b, &frame, 0.05), all(b, a, &back, 0.05));
                assert_eq!(one.len(), other.len());
                for (one, other) in one.iter().zip(&other) {
                    check(one, &frame, 0.05);
                    check(other, &back, 0.05);
                    let off = (one.nearest() - other.nearest()).abs();
                    assert!(off < 5e-3 + 0.06 * one.nearest().abs(), "{one:?} {other:?}");
                    both += 1;
                }
            }
        }
    }
    assert!(both > 800, "{both}");
}

#[test]
fn on_a_half_space_each_shape_has_its_lowest_points() {
    let ground = Shape::half_space();
    let shapes = convex();
    let mut random = Random::new(32);
    for (i, shape) in shapes.iter().enumerate() {
        for _ in 0..300 {
            let frame = random.frame(0.8);
            let lowest = frame.translation.y - support(i, frame.turn_back(Vec3::NEG_Y));
            let found = all(shape, &ground, &frame, 0.05);
            assert_eq!(found.is_empty(), lowest > 0.05);
            for manifold in &found {
                check(manifold, &frame, 0.05);
                assert!((manifold.nearest() - lowest).abs() < 1e-5, "{i} {manifold:?} {lowest}");
                assert!(manifold.points().iter().all(|p| p.on_b.y == 0.0));
                let off = |p: &Point| shape.nearest(p.on_a).distance.abs();
                assert!(manifold.points().iter().all(|p| off(p) < 1e-5));
            }
        }
    }
    // Shapes that stand have as many points as support them.
    let counts = [1, 1, 4, 4, 1];
    for ((shape, count), height) in shapes.iter().zip(counts).zip([0.5, 0.9, 0.5, 0.6, 0.8]) {
        let found = points(shape, &ground, &Frame::at(Vec3::Y * height), 0.01);
        assert_eq!(found.len(), count);
    }
    let lying = turned(Vec3::Y * 0.4, Vec3::X, core::f32::consts::FRAC_PI_2);
    assert_eq!(points(&shapes[3], &ground, &lying, 0.01).len(), 2);
}

#[test]
fn capsules_that_lie_touch_in_two_points() {
    let capsule = Shape::capsule(0.3, 1.2).unwrap();
    let side_by_side = Frame::at(Vec3::new(0.59, 0.4, 0.0));
    let found = all(&capsule, &capsule, &side_by_side, 0.0);
    let e: Vec<_> = found[0].points().iter().map(|p| p.on_b.y).collect();
    assert_eq!(found[0].normal, Vec3::X);
    assert!(e.len() == 2 && (e[0] + 0.2).abs() < 1e-5 && (e[1] - 0.6).abs() < 1e-5, "{e:?}");
    // Half over the edge of a table: from the capsule's end to the edge.
    let table = Shape::cuboid(Vec3::splat(2.0)).unwrap();
    let lying = turned(Vec3::new(0.8, 1.29, 0.0), Vec3::Z, core::f32::consts::FRAC_PI_2);
    let found = all(&capsule, &table, &lying, 0.0);
    let mut e: Vec<_> = found[0].points().iter().map(|p| p.on_b.x).collect();
    e.sort_by(f32::total_cmp);
    assert!(e.len() == 2 && (e[0] - 0.2).abs() < 1e-3 && (e[1] - 1.0).abs() < 1e-3, "{e:?}");
    // At the same place, crossing, and one above the other.
    for frame in [
        Frame::IDENTITY,
        turned(Vec3::ZERO, Vec3::X, 1.0),
        Frame::at(Vec3::Y * 1.7),
        turned(Vec3::ZERO, Vec3::X, 1e-4),
    ] {
        let found = all(&capsule, &capsule, &frame, 0.0);
        check(&found[0], &frame, 0.0);
    }
}

#[test]
fn earlier_queries_change_nothing() {
    let shapes = convex();
    let mut random = Random::new(34);
    let mut used = ManifoldScratch::default();
    let frames: Vec<_> = (0..40).map(|_| random.frame(0.9)).collect();
    let slow =
        frames.iter().flat_map(|f| [*f, Frame { translation: f.translation * 1.0001, ..*f }]);
    for frame in slow {
        for (a, b) in [(3, 2), (4, 2), (4, 4), (1, 4)] {
            let mut found = Vec::new();
            collide(&shapes[a], &shapes[b], &frame, 0.05, &mut used, &mut |m| found.push(*m));
            assert_eq!(found, all(&shapes[a], &shapes[b], &frame, 0.05));
        }
    }
}

/// Where one centre lies exactly on the other's surface or at its centre, no direction leads from one to the other. A contact without a normal would apply no
/// impulse, and the shapes would stay overlapped.
#[test]
fn shapes_with_a_centre_in_the_other_ones_surface_or_centre_have_a_normal() {
    let shapes = convex();
    let mut grounds = super::ground::flat().to_vec();
    grounds.extend(shapes.iter().cloned());
    let places = [Vec3::ZERO, Vec3::X * 0.5, Vec3::new(0.25, 0.0, 0.25), Vec3::Y * 0.5];
    for (g, ground) in grounds.iter().enumerate() {
        for (i, shape) in shapes.iter().enumerate() {
            for place in places {
                let frame = Frame { translation: place, ..Frame::IDENTITY };
                for manifold in all(shape, ground, &frame, 0.05) {
                    let length = manifold.normal.length();
                    assert!((length - 1.0).abs() < 1e-4, "{i} in {g} at {place}: {length}");
                }
            }
        }
    }
}
