//! Shapes on triangles.

use glam::Vec3;

use super::pairs::{convex, support};
use super::*;
use crate::collide::shape::Kind;

/// A flat mesh of 2 × 8 × 8 triangles, whose inner edges must not affect contacts, and a heightfield of the same shape.
pub(super) fn flat() -> [Shape; 2] {
    let at = |i: u32, j: u32| i * 9 + j;
    let vertices =
        (0..81).map(|n| Vec3::new((n / 9) as f32 - 4.0, 0.0, (n % 9) as f32 - 4.0)).collect();
    let mut triangles = Vec::new();
    for i in 0..8 {
        for j in 0..8 {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            triangles.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
    let land = Shape::height_field(9, 9, &[0.0; 81], Vec3::new(8.0, 1.0, 8.0)).unwrap();
    [Shape::mesh(vertices, triangles).unwrap(), land]
}

#[test]
fn on_triangles_and_on_a_landscape_everything_stands_upright_and_nothing_is_missed() {
    let shapes = convex();
    let mut random = Random::new(33);
    let grounds = flat();
    for (g, ground) in grounds.iter().enumerate() {
        for (i, shape) in shapes.iter().enumerate() {
            let (mut worst, mut tilt) = (0.0_f32, 0.0_f32);
            for _ in 0..100 {
                let mut frame = random.frame(2.0);
                let lift = 0.02 * random.number();
                frame.translation.y = support(i, frame.turn_back(Vec3::Y)) + lift;
                let found = all(shape, ground, &frame, 0.05);
                let nearest = found.iter().map(Manifold::nearest).fold(f32::INFINITY, f32::min);
                worst = worst.max((nearest - lift).abs());
                for manifold in &found {
                    check(manifold, &frame, 0.05);
                    tilt = tilt.max(1.0 - manifold.normal.y);
                }
                let back = crate::collide::manifold::inverse(&frame);
                assert_eq!(all(ground, shape, &back, 0.05).len(), found.len());
            }
            println!("ground {g}, shape {i}: height off by {worst}, tilt {tilt}");
            assert!(worst < 2e-3 && tilt < 0.01);
        }
        for other in grounds.iter().chain([&Shape::half_space()]) {
            assert_eq!(all(ground, other, &Frame::IDENTITY, 0.1), []);
        }
    }
}

/// Shapes with a height, metres, at which they rest in a pose: on a face, a side or a rim.
fn at_rest() -> Vec<(Shape, f32, Frame)> {
    let lies = turned(Vec3::ZERO, Vec3::Z, core::f32::consts::FRAC_PI_2);
    let (upright, aslant) = (Frame::IDENTITY, turned(Vec3::ZERO, Vec3::Y, 0.4));
    let sides = [-0.25_f32, 0.25];
    let corners = sides
        .into_iter()
        .flat_map(|x| sides.into_iter().flat_map(move |y| sides.map(|z| Vec3::new(x, y, z))));
    let hull = Shape::hull(&corners.collect::<Vec<_>>()).unwrap();
    let cube = Shape::cuboid(Vec3::splat(0.5)).unwrap();
    let (cylinder, capsule) = (Shape::cylinder(0.25, 0.5), Shape::capsule(0.25, 0.5));
    let (cylinder, capsule) = (cylinder.unwrap(), capsule.unwrap());
    vec![
        (Shape::sphere(0.25).unwrap(), 0.25, upright),
        (cube.clone(), 0.25, upright),
        (cube, 0.25, aslant),
        (hull.clone(), 0.25, upright),
        (hull, 0.25, aslant),
        (cylinder.clone(), 0.25, upright),
        (cylinder, 0.25, lies),
        (capsule.clone(), 0.5, upright),
        (capsule, 0.25, lies),
    ]
}

/// Of cylinders on a mesh, at places on a grid, a tenth touched some triangle from below, because the direction to its edge was level to rounding; hulls,
/// cylinders, balls and capsules on the common edge of two triangles, to a millionth, were sometimes above neither.
#[test]
fn on_inner_edges_to_rounding_nothing_is_missed_and_nothing_is_touched_from_below() {
    let mut random = Random::new(4);
    for (ground, (shape, height, pose)) in
        flat().iter().flat_map(|ground| at_rest().into_iter().map(move |rests| (ground, rests)))
    {
        for round in 0..3000 {
            let lift = [0.0, 1e-7, -1e-7, 1e-5, -1e-5, 1e-3, -1e-3, 0.01, -0.01][round % 9];
            let place = |free: bool, random: &mut Random| {
                let grid = 0.125 * random.below(17) as f32 - 1.0;
                if free { random.number() } else { grid + 4e-6 * random.number() }
            };
            let free = random.below(3);
            let (x, z) = (place(free == 1, &mut random), place(free == 2, &mut random));
            let frame = Frame { translation: Vec3::new(x, height + lift, z), ..pose };
            let found = all(&shape, ground, &frame, 0.1);
            let nearest = found.iter().map(Manifold::nearest).fold(f32::INFINITY, f32::min);
            let at = frame.translation;
            assert!((nearest - lift).abs() < 1e-3, "{shape:?} at {at}: {nearest}, {lift}");
            for manifold in &found {
                check(manifold, &frame, 0.1);
                assert!(manifold.normal.y > 0.99, "{shape:?} at {at}: {}", manifold.normal);
            }
        }
    }
}

/// On a floor of triangles a box had a manifold for each of up to eight, of thirty points together, and took three times as long as on a plane.
#[test]
fn on_coplanar_triangles_a_shape_has_the_manifold_that_it_has_on_a_plane() {
    let mut random = Random::new(12);
    let plane = Shape::half_space();
    for (ground, (shape, height, pose)) in
        flat().iter().flat_map(|ground| at_rest().into_iter().map(move |rests| (ground, rests)))
    {
        for round in 0..300 {
            let turn = turned(Vec3::ZERO, Vec3::Y, 3.0 * random.number()).rotation;
            // Every second one leans by up to two degrees, as far as its far side stays in reach.
            let lean = if round % 2 == 0 { 0.0 } else { 0.035 * random.number() };
            let lean = turned(Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8), lean).rotation;
            let translation = Vec3::new(2.0 * random.number(), height, 2.0 * random.number());
            let frame = Frame { translation, rotation: lean * turn * pose.rotation };
            let [mut found, expected] = [ground, &plane].map(|on| all(&shape, on, &frame, 0.1));
            // A cylinder that lies is above the triangles beside it with other points of its side, which do not roll.
            found.retain(|one| one.radii == expected[0].radii);
            let [[one], [same]] = [&found[..], &expected[..]] else {
                panic!("{shape:?} at {translation}: {} manifolds", found.len());
            };
            assert!((one.nearest() - same.nearest()).abs() < 1e-4, "{shape:?} at {translation}");
            // The four of sixteen corners of a cylinder's end are chosen by rounding.
            if matches!(shape.kind(), Kind::Cylinder { .. }) {
                continue;
            }
            for point in same.points() {
                let near = one.points().iter().map(|other| other.on_b.distance(point.on_b));
                let near = near.fold(f32::INFINITY, f32::min);
                // A capsule that leans touches a triangle below its axis.
                let most = if matches!(shape.kind(), Kind::Capsule { .. }) { 0.01 } else { 1e-4 };
                assert!(near < most, "{shape:?} at {translation}: {near} from {}", point.on_b);
            }
        }
    }
}
