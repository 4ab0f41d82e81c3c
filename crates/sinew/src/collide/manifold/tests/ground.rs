//! Shapes on triangles.

use glam::Vec3;

use super::pairs::{convex, support};
use super::*;

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
