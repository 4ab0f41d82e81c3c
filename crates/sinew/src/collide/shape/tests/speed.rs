//! How long a touch takes. Run with `cargo test --release touch_takes -- --ignored --nocapture`.

use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;

use super::{Dice, convex, egg, hills, torus, waves};
use crate::collide::shape::Shape;

#[test]
#[ignore = "a measurement"]
fn what_a_touch_takes() {
    let mut shapes = convex();
    shapes.push(("half space", Shape::half_space()));
    shapes.push(("hull of 12 corners", Shape::hull(&egg(12, Vec3::ONE)).unwrap()));
    shapes.push(("torus of 576", torus(24, 12)));
    shapes.push(("torus of 40k", torus(200, 100)));
    shapes.push(("sheet of 800", waves(20)));
    shapes.push(("sheet of 80k", waves(200)));
    shapes.push(("hills", hills()));
    for (name, shape) in shapes {
        let mut dice = Dice(9);
        let (mut resting, mut near) = (Vec::new(), Vec::new());
        while resting.len() < 2000 {
            let p = dice.place(Vec3::splat(1.2));
            let nearest = shape.nearest(p);
            if nearest.distance.is_finite() {
                // 1 mm too deep on the surface, and 10 cm off.
                let on = nearest.point + nearest.normal * 0.02;
                let slip = dice.place(Vec3::splat(1e-3));
                resting.push((on, on + slip - nearest.normal * 1e-3));
                let off = on + nearest.normal * 0.1;
                near.push((off, off + slip));
            }
        }
        let time = |ways: &[(Vec3, Vec3)]| {
            (0..20)
                .map(|_| {
                    let start = Instant::now();
                    for (from, to) in ways {
                        black_box(shape.touch(black_box(*from), black_box(*to), 0.02));
                    }
                    start.elapsed().as_secs_f64() * 1e9 / ways.len() as f64
                })
                .fold(f64::INFINITY, f64::min)
        };
        let (resting, near) = (time(&resting), time(&near));
        println!("{name}: {resting:.1} ns in contact, {near:.1} ns 10 cm off");
    }
}
