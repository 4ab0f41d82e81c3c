//! No tunnelling, at any speed.

use glam::Vec3;

use super::{Random, convex, hills, torus, waves};
use crate::collide::shape::Shape;

/// Moves spheres along random paths from outside to anywhere. Returns how many were stopped, and panics where one passed through or was placed wrongly.
fn nothing_passes(name: &str, shape: &Shape, radius: f32, sheet: bool) -> usize {
    let (low, high) = shape.bounds();
    let size = (high - low).max_element();
    let mut random = Random::new(17);
    let (mut held, mut paths) = (0, 0);
    while paths < 10_000 {
        let about = (high - low) * 0.5 * 1.5 + Vec3::splat(0.3 * size);
        let middle = (low + high) * 0.5;
        let from = middle + random.vector() * about;
        let to = middle + random.vector() * about;
        if shape.nearest(from).distance < radius + 1e-5 {
            continue;
        }
        paths += 1;
        let motion = to - from;
        let (length, direction) = (motion.length(), motion.normalize());
        let entry = shape.cast_ray(from, direction, length);
        let Some(touch) = shape.touch(from, to, radius) else {
            let end = shape.nearest(to).distance;
            // A hit at the very end, or grazing an edge, is not tunnelling.
            assert!(
                entry.is_none_or(|hit| hit.distance > length - 1e-5) || grazes(shape, from, to),
                "{name}: {from} to {to} went through at {entry:?}"
            );
            assert!(end >= radius - 1e-4 * size, "{name}: {to} is {end} away, of {radius}");
            continue;
        };
        held += 1;
        assert!(
            (touch.normal.length() - 1.0).abs() < 1e-4 && touch.depth > 0.0,
            "{name}: {touch:?}"
        );
        let place = to + touch.normal * touch.depth;
        let away = shape.nearest(place).distance;
        assert!(away >= radius - 1e-4 * size, "{name}: {from} to {to}: {place} is {away} away");
        let back = place - from;
        let passed = shape.cast_ray(from, back.normalize(), back.length() - 1e-4 * size);
        let bend = entry.is_some_and(|entry| touch.normal.dot(entry.normal) >= 0.49);
        assert!(
            passed.is_none() || (bend && !sheet) || grazes(shape, from, place),
            "{name}: {from} to {to}: {place} is on the other side, {touch:?}, {entry:?}"
        );
    }
    held
}

/// Whether a path is in a solid by less than rounding.
fn grazes(shape: &Shape, from: Vec3, to: Vec3) -> bool {
    let (low, high) = shape.bounds();
    let room = 1e-5 * (high - low).max_element();
    (0..=1000).all(|i| shape.nearest(from + (to - from) * (i as f32 * 1e-3)).distance > -room)
}

#[test]
fn no_convex_shape_lets_a_sphere_through() {
    for (name, shape) in convex() {
        for radius in [0.0, 0.05] {
            let held = nothing_passes(name, &shape, radius, false);
            println!("{name}, radius {radius}: {held} of 10000 held back");
            assert!(held > 20, "{name}: {held}");
        }
    }
}

#[test]
fn no_triangles_let_a_sphere_through() {
    for radius in [0.0, 0.02] {
        let held = nothing_passes("torus", &torus(24, 12), radius, true);
        let sheet = nothing_passes("sheet", &waves(20), radius, true);
        let hills = nothing_passes("hills", &hills(), radius, true);
        println!("radius {radius}: torus {held}, sheet {sheet}, hills {hills} of 10000 held back");
        assert!(held.min(sheet).min(hills) > 1000);
    }
}

#[test]
fn a_half_space_has_no_other_side() {
    let floor = Shape::half_space();
    let touch = floor.touch(Vec3::Y * 3.0, Vec3::new(1.0, -2.0, 0.0), 0.5).unwrap();
    assert_eq!((touch.normal, touch.depth), (Vec3::Y, 2.5));
    assert!(floor.touch(Vec3::Y, Vec3::Y * 0.6, 0.5).is_none());
}

#[test]
fn a_sphere_in_a_closed_room_of_sheets_stays_inside() {
    // The walls of the box face inward: it is no solid, but nothing passes.
    let corner =
        |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let sides: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let walls = sides.iter().flat_map(|&[a, b, c, d]| [[a, c, b], [a, d, c]]).collect();
    let room = Shape::mesh((0..8).map(corner).collect(), walls).unwrap();
    assert!(!room.contains(Vec3::ZERO));
    for radius in [0.0, 0.1] {
        let mut random = Random::new(23);
        let mut place = Vec3::ZERO;
        let mut held = 0;
        for step in 0..10_000 {
            let to = place + random.vector() * if step % 2 == 0 { 3.0 } else { 0.05 };
            let touch = room.touch(place, to, radius);
            held += usize::from(touch.is_some());
            place = touch.map_or(to, |touch| to + touch.normal * touch.depth);
            let out = place.abs().max_element();
            assert!(out <= 1.0 - radius + 1e-4, "step {step}: {place}");
        }
        println!("radius {radius}: {held} of 10000 steps held back");
    }
}

#[test]
fn a_slanted_sheet_of_a_kilometre_stops_what_is_small() {
    let corners =
        vec![Vec3::new(-9e4, -300.0, -7e4), Vec3::new(1e3, 40.0, -2e3), Vec3::new(3e3, 10.0, 8e4)];
    let sheet = Shape::mesh(corners.clone(), vec![[0, 1, 2]]).unwrap();
    let middle = (corners[0] + corners[1] * 60.0 + corners[2]) / 62.0;
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    let mut random = Random::new(3);
    let skin = 9e4 * 4e-6;
    for _ in 0..1000 {
        let place = middle + random.vector() * 5.0;
        let on = place - normal * normal.dot(place - middle);
        let touch = sheet.touch(on + normal * 1.5, on - normal, 0.1).unwrap();
        assert!(touch.normal.dot(normal).abs() > 0.999, "{touch:?}");
        assert!((touch.depth - 1.0 - skin).abs() < 0.05, "{touch:?}");
    }
}

#[test]
fn what_rests_on_a_plate_is_not_pressed_through_by_a_little() {
    let shapes = [
        ("plate", Shape::cuboid(Vec3::new(2.0, 0.02, 2.0)).unwrap()),
        ("disc", Shape::cylinder(1.0, 0.02).unwrap()),
        ("hull", {
            let corner = |i: u32| {
                Vec3::new(
                    (i & 1) as f32 - 0.5,
                    0.02 * (i >> 1 & 1) as f32 - 0.01,
                    (i >> 2) as f32 - 0.5,
                )
            };
            Shape::hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap()
        }),
    ];
    for (name, shape) in shapes {
        // It is already 1 mm deep, because something pulls at it, and then moves beyond the middle.
        let (from, to) = (Vec3::new(0.1, 0.009, 0.1), Vec3::new(0.1, -0.008, 0.1));
        let touch = shape.touch(from, to, 0.0).unwrap();
        assert!((touch.normal - Vec3::Y).length() < 1e-4, "{name}: {touch:?}");
        assert!((touch.depth - 0.018).abs() < 1e-5, "{name}: {touch:?}");
    }
}

#[test]
fn a_sphere_that_begins_inside_leaves_by_the_shortest_way() {
    let cube = Shape::cuboid(Vec3::splat(2.0)).unwrap();
    let p = Vec3::new(0.1, -0.2, 0.7);
    let touch = cube.touch(p, p, 0.5).unwrap();
    assert_eq!((touch.normal, touch.depth), (Vec3::Z, 0.5 + (1.0 - 0.7)));
    let ring = torus(24, 12);
    let p = Vec3::new(1.0, 0.2, 0.0);
    let touch = ring.touch(p, p, 0.1).unwrap();
    assert!(touch.normal.y > 0.9 && (touch.depth - 0.3).abs() < 0.03, "{touch:?}");
    assert!(hills().touch(Vec3::ZERO, Vec3::ZERO, 0.1).is_some());
}

#[test]
fn what_is_not_a_number_touches_nothing() {
    let mut shapes = convex();
    shapes.extend([("torus", torus(8, 8)), ("sheet", waves(4)), ("hills", hills())]);
    for (name, shape) in shapes {
        for bad in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NEG_INFINITY, 0.0)] {
            assert_eq!(shape.touch(Vec3::ZERO, bad, 0.1), None, "{name} {bad}");
            assert_eq!(shape.cast_ray(bad, Vec3::X, 1.0), None, "{name} {bad}");
            assert!(shape.touch(bad, Vec3::ZERO, 0.1).is_none_or(|touch| touch.normal.is_finite()));
        }
        assert_eq!(shape.touch(Vec3::ZERO, Vec3::ZERO, f32::NAN), None, "{name}");
    }
}
