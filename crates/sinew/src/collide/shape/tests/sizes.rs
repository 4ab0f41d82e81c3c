//! Scaling, bounding boxes, and what is solid.

use glam::{Mat3, Quat, Vec3};

use super::{Random, convex, hills, torus, waves};
use crate::collide::Frame;
use crate::collide::shape::{Kind, Shape};

#[test]
fn a_shape_in_another_size_has_its_surface_where_it_then_is() {
    let mut shapes = convex();
    shapes.extend([("torus", torus(24, 12)), ("sheet", waves(10)), ("hills", hills())]);
    let factor = Vec3::new(2.0, 0.5, 3.0);
    for (name, shape) in shapes {
        let scaled = shape.scaled(factor).unwrap();
        let mut random = Random::new(31);
        let mut worst = 0.0_f32;
        for _ in 0..1000 {
            let on = shape.nearest(random.vector() * 1.5).point;
            worst = worst.max(scaled.nearest(on * factor).distance.abs());
        }
        println!("{name}: scaled unevenly, off by {worst:.1e} m");
        // Only shapes that are no longer round are approximated, with 24 sides.
        let round =
            ["sphere", "capsule", "thin capsule", "cylinder", "disc", "wire"].contains(&name);
        assert!(worst < if round { 0.04 } else { 1e-5 }, "{name}: {worst}");
        let even = shape.scaled(Vec3::splat(2.0)).unwrap();
        assert_eq!(std::mem::discriminant(&even.form), std::mem::discriminant(&shape.form));
        let p = Vec3::new(0.4, 1.9, -0.8);
        let (one, two) = (shape.nearest(p).distance, even.nearest(p * 2.0).distance);
        assert!((two - 2.0 * one).abs() < 1e-5, "{name}: {one} and {two}");
    }
    let pillar = Shape::cylinder(1.0, 4.0).unwrap().scaled(Vec3::new(2.0, 3.0, 2.0)).unwrap();
    assert_eq!(pillar, Shape::cylinder(2.0, 12.0).unwrap());
    assert_eq!(Shape::half_space().scaled(factor), Ok(Shape::half_space()));
}

#[test]
fn the_box_around_a_turned_shape_holds_it_and_is_tight() {
    let frame = Frame::new(Vec3::new(3.0, -2.0, 5.0), Quat::from_xyzw(0.3, -0.5, 0.2, 0.7));
    for (name, shape) in convex() {
        let (low, high) = shape.bounds_in(&frame);
        let mut random = Random::new(37);
        let (mut least, mut most) = (Vec3::INFINITY, -Vec3::INFINITY);
        for _ in 0..4000 {
            let far = random.vector().normalize() * 1000.0;
            let p = frame.point(shape.nearest(far).point);
            (least, most) = (least.min(p), most.max(p));
        }
        let room = Vec3::splat(1e-5);
        assert!((low - room).cmple(least).all() && (high + room).cmpge(most).all(), "{name}");
        let loose = (least - low).max(high - most).max_element();
        assert!(loose < 0.05, "{name}: {loose}");
    }
    for shape in [torus(24, 12), hills()] {
        let (low, high) = shape.bounds_in(&frame);
        let mut random = Random::new(41);
        for _ in 0..1000 {
            let p = frame.point(shape.nearest(random.vector() * 2.0).point);
            assert!(low.cmple(p + 1e-5).all() && high.cmpge(p - 1e-5).all());
        }
    }
    let floor = Shape::half_space();
    let (low, high) = floor.bounds_in(&Frame::at(Vec3::Y * 3.0));
    assert_eq!((low, high), (-Vec3::INFINITY, Vec3::INFINITY.with_y(3.0)));
    let rotation = Mat3::from_cols(Vec3::Y, Vec3::NEG_X, Vec3::Z);
    let (low, high) = floor.bounds_in(&Frame { translation: Vec3::X, rotation });
    assert_eq!((low, high), ((-Vec3::INFINITY).with_x(1.0), Vec3::INFINITY));
    assert_eq!(floor.bounds_in(&frame), (-Vec3::INFINITY, Vec3::INFINITY));
}

#[test]
fn a_closed_mesh_is_solid_and_an_open_or_inverted_one_is_a_sheet() {
    let points: Vec<Vec3> = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let out = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let solid = Shape::mesh(points.clone(), out.clone()).unwrap();
    assert!(solid.contains(Vec3::splat(0.1)) && !solid.contains(Vec3::splat(0.5)));
    let open = Shape::mesh(points.clone(), out[1..].to_vec()).unwrap();
    assert!(!open.contains(Vec3::splat(0.1)));
    let inverted = out.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert!(!Shape::mesh(points.clone(), inverted).unwrap().contains(Vec3::splat(0.1)));
    // As games store them: each triangle has vertices of its own.
    let apart: Vec<Vec3> = out.iter().flatten().map(|&i| points[i as usize]).collect();
    let split =
        Shape::mesh(apart, (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()).unwrap();
    assert!(split.contains(Vec3::splat(0.1)));
}

#[test]
fn a_box_of_triangles_touches_as_a_box_does() {
    let half = Vec3::new(0.5, 0.8, 0.3);
    let corner = |i: u32| {
        (Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0) * half
    };
    let corners: Vec<Vec3> = (0..8).map(corner).collect();
    let sides: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let of_triangles = Shape::mesh(corners.clone(), triangles).unwrap();
    let hull = Shape::hull(&corners).unwrap();
    let cuboid = Shape::cuboid(half * 2.0).unwrap();
    assert!(matches!(hull.kind(), Kind::Hull(points) if points.len() == 8));
    let mut random = Random::new(43);
    let (mut touched, mut worst) = (0, 0.0_f32);
    for _ in 0..5000 {
        let from = random.vector();
        if cuboid.nearest(from).distance < 0.1 {
            continue;
        }
        let to = from + random.vector() * 0.1;
        let a = cuboid.touch(from, to, 0.1);
        for b in [hull.touch(from, to, 0.1), of_triangles.touch(from, to, 0.1)] {
            let depth = |touch: Option<crate::collide::shape::ShapeTouch>| {
                touch.map_or(Vec3::ZERO, |t| t.normal * t.depth)
            };
            touched += usize::from(a.is_some());
            worst = worst.max((depth(a) - depth(b)).length());
        }
    }
    println!("{touched} touches, differing by {worst:.1e} m");
    assert!(touched > 200 && worst < 1e-5, "{touched}, {worst}");
}

#[test]
fn equal_numbers_are_equal_shapes() {
    assert_eq!(torus(8, 6), torus(8, 6));
    assert_ne!(torus(8, 6), torus(6, 8));
    assert_ne!(Shape::sphere(1.0), Shape::sphere(2.0));
    let ball = Shape::sphere(1.0).unwrap();
    assert_eq!(ball, ball.clone());
}
