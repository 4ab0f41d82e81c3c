//! Nearest points and rays of each kind of shape against those of `parry3d`.

use glam::Vec3;
use parry3d::math::Vector;
use parry3d::query::{PointQuery as _, Ray};
use parry3d::shape::TriMesh;

use super::{Random, convex, hills, torus, waves};
use crate::collide::shape::{Form, Kind, Shape};

fn vector(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// The greatest difference of distances over random points, and how many points differ in their side.
fn distances(shape: &Shape, signed: bool) -> (f32, usize) {
    let mut random = Random::new(11);
    let (mut worst, mut sides) = (0.0_f32, 0);
    for _ in 0..5000 {
        let p = random.vector() * 1.6;
        let mine = shape.nearest(p);
        let theirs = shape.parry().project_local_point(vector(p), false);
        let away = (theirs.point - vector(p)).length();
        worst = worst.max((mine.distance.abs() - away).abs());
        // On the surface either side is right.
        sides += usize::from(signed && away > 1e-5 && (mine.distance < 0.0) != theirs.is_inside);
        assert!((mine.normal.length() - 1.0).abs() < 1e-5, "{} at {p}", mine.normal);
        let back = p - mine.normal * mine.distance;
        assert!((back - mine.point).length() < 2e-5, "{shape:?} {p}: {back} is not {}", mine.point);
    }
    (worst, sides)
}

/// The greatest difference between a hull and the `parry3d` mesh of its triangles.
fn hull_as_triangles(shape: &Shape) -> f32 {
    let Form::Hull(hull) = &shape.form else { return 0.0 };
    let points = hull.points.iter().map(|p| vector(*p)).collect();
    let mesh = TriMesh::new(points, hull.triangles.clone()).unwrap();
    let mut random = Random::new(13);
    let mut worst = 0.0_f32;
    for _ in 0..5000 {
        let p = random.vector() * 1.6;
        let theirs = (mesh.project_local_point(vector(p), false).point - vector(p)).length();
        worst = worst.max((shape.nearest(p).distance.abs() - theirs).abs());
    }
    worst
}

#[test]
fn the_nearest_point_is_the_one_that_parry_finds() {
    for (name, shape) in convex() {
        let (worst, sides) = distances(&shape, true);
        println!("{name}: distances differ by {worst:.1e} m");
        // For a hull `parry3d` iterates, and stops early; for a mesh it does not.
        let (most, exact) = if let Kind::Hull(_) = shape.kind() {
            (2e-3, hull_as_triangles(&shape))
        } else {
            (1e-5, 0.0)
        };
        println!("{name}: and from its triangles by {exact:.1e} m");
        assert!(worst < most && exact < 1e-5 && sides == 0, "{name}: {worst}, {exact}, {sides}");
    }
    let (worst, sides) = distances(&torus(24, 12), true);
    println!("torus: distances differ by {worst:.1e} m");
    assert!(worst < 1e-5 && sides == 0, "torus: {worst}, {sides}");
    let (worst, _) = distances(&waves(20), false);
    println!("sheet: distances differ by {worst:.1e} m");
    assert!(worst < 1e-5, "sheet: {worst}");
}

#[test]
fn rays_hit_where_those_of_parry_do() {
    let mut shapes = convex();
    shapes.push(("half space", Shape::half_space()));
    shapes.push(("torus", torus(24, 12)));
    shapes.push(("sheet", waves(20)));
    for (name, shape) in shapes {
        let mut random = Random::new(7);
        let (mut worst, mut differ, mut hits) = (0.0_f32, 0, 0);
        for _ in 0..5000 {
            let (from, to) = (random.vector() * 2.0, random.vector() * 0.7);
            if shape.contains(from) {
                assert!(shape.cast_ray(from, Vec3::X, 10.0).is_none() || name == "torus");
                continue;
            }
            let direction = (to - from).normalize();
            let mine = shape.cast_ray(from, direction, 10.0);
            if let Some(hit) = mine {
                let off = shape.nearest(from + direction * hit.distance).distance;
                assert!(off.abs() < 1e-5, "{name}: {off} off the surface");
            }
            let ray = Ray::new(vector(from), vector(direction));
            let theirs = shape.parry().cast_local_ray(&ray, 10.0, true);
            if let (Some(mine), Some(theirs)) = (mine, theirs) {
                hits += 1;
                // At grazing angles the distance along a ray is inaccurate.
                worst = worst.max((mine.distance - theirs).abs() * -mine.normal.dot(direction));
                assert!(mine.normal.dot(direction) <= 1e-3, "{name}: out of the surface");
            }
            differ += usize::from(mine.is_some() != theirs.is_some());
        }
        println!(
            "{name}: {hits} hits, distances differ by {worst:.1e} m, {differ} hit or miss by a hair"
        );
        // Iterative in `parry3d`.
        let stepped = ["cylinder", "disc", "wire", "hull", "flat hull", "tetrahedron"];
        let most = if stepped.contains(&name) { 5e-3 } else { 1e-5 };
        assert!(
            worst < most && differ <= 20 && hits > 10,
            "{name}: {worst}, {differ} differ, {hits} hits"
        );
    }
}

#[test]
fn heights_agree_with_those_of_parry() {
    let shape = hills();
    let mut random = Random::new(3);
    let mut worst = 0.0_f32;
    for _ in 0..3000 {
        let p = (random.vector() * Vec3::new(1.99, 0.0, 0.99)).with_y(1.0);
        let ray = Ray::new(vector(p), Vector::new(0.0, -1.0, 0.0));
        let theirs = shape.parry().cast_local_ray(&ray, 5.0, true).unwrap();
        let mine = shape.cast_ray(p, Vec3::NEG_Y, 5.0).unwrap();
        worst = worst.max((mine.distance - theirs).abs());
        let q = random.vector() * Vec3::new(2.5, 0.6, 1.5);
        let near = shape.nearest(q);
        let away = (shape.parry().project_local_point(vector(q), false).point - vector(q)).length();
        assert!(near.distance.abs() <= away + 1e-5, "{q}: {} and {away}", near.distance);
    }
    assert!(worst < 1e-5, "{worst}");
}
