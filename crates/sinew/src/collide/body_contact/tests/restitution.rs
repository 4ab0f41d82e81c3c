//! Restitution.

use super::*;

/// A hull of a sphere of 0.5 m: an octahedron whose edges were halved three times.
fn round_hull() -> Shape {
    let mut points = Vec::new();
    let n = 8;
    for i in -n..=n {
        for j in -n..=n {
            let k = n - i32::abs(i) - i32::abs(j);
            for k in [k, -k] {
                if k.abs() + i.abs() + j.abs() == n {
                    points.push(Vec3::new(i as f32, k as f32, j as f32).normalize() * 0.5);
                }
            }
        }
    }
    Shape::hull(&points).unwrap()
}

/// Drops a shape from 1 m, measured at its centre from where that is at contact, and returns how high it bounces, metres, and its sideways speed then.
fn drop(shape: Shape, restitution: f32) -> (f32, f32) {
    let mut world = world();
    floor(&mut world, elastic(restitution));
    let spec = BoxSpec { layout: BoxLayout::Equimomental, ..BoxSpec::default() };
    let first = add(&mut world, &box_3d(&spec).unwrap(), shape, Vec3::Y * 1.5, Quat::IDENTITY);
    let (mut down, mut top) = (false, 0.0_f32);
    for _ in 0..120 {
        world.step(1.0 / 60.0).unwrap();
        let v = velocity(&world, first).y;
        down |= v > 0.0;
        if down {
            // Between two steps it may have been a little higher.
            let height = centre(&world, first).y - 0.5;
            top = top.max(height + if v > 0.0 { v * v / (2.0 * 9.81) } else { 0.0 });
        }
        if down && v < 0.0 {
            break;
        }
    }
    (top, velocity(&world, first).with_y(0.0).length())
}

#[test]
fn a_round_body_bounces_to_e_squared_of_its_height() {
    for shape in [Shape::sphere(0.5).unwrap(), round_hull()] {
        for e in [0.3, 0.5, 0.8, 1.0] {
            let (top, aside) = drop(shape.clone(), e);
            assert!(aside < 1e-3, "{aside}");
            assert!((top / (e * e) - 1.0).abs() < 0.02, "{top} {e}");
            assert!(e < 1.0 || top <= 1.0, "{top}");
        }
    }
}

#[test]
fn a_box_that_falls_flat_bounces_flat() {
    for e in [0.5, 1.0] {
        let (top, aside) = drop(Shape::cuboid(Vec3::ONE).unwrap(), e);
        assert!((top / (e * e) - 1.0).abs() < 0.02 && aside < 1e-3, "{top} {aside}");
    }
}

#[test]
fn an_elastic_bounce_never_rises_above_the_start() {
    for (substeps, shape) in [
        (2, Shape::sphere(0.5).unwrap()),
        (10, round_hull()),
        (5, Shape::cuboid(Vec3::ONE).unwrap()),
    ] {
        let mut world = world();
        world.settings.substeps = substeps;
        floor(&mut world, elastic(1.0));
        let spec = BoxSpec { layout: BoxLayout::Equimomental, ..BoxSpec::default() };
        let first = add(
            &mut world,
            &box_3d(&spec).unwrap(),
            shape,
            Vec3::Y * 1.5,
            turn(Vec3::new(1.0, 0.2, 0.4), 0.3),
        );
        let mut worst = f32::NEG_INFINITY;
        let energy = |world: &Simulation| {
            let particles = &world.particles;
            (0..8)
                .map(|i| {
                    let v = world.velocity_now(first + i);
                    (0.5 * v.length_squared() + 9.81 * particles.position(first + i).y) / 8.0
                })
                .sum::<f32>()
        };
        let before = energy(&world);
        for _ in 0..600 {
            world.step(1.0 / 60.0).unwrap();
            worst = worst.max(energy(&world) / before - 1.0);
        }
        assert!(worst < 2e-3, "{worst}");
    }
}
