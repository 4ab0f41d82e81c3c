//! How long it takes; printed, not asserted, because it is the machine's matter.

use std::hint::black_box;
use std::time::Instant;

use super::*;

#[test]
fn how_long_a_call_takes() {
    let mut dice = Dice(21);
    let unit = Shape::cuboid(Vec3::splat(0.5)).unwrap();
    let resting: Vec<_> = (0..256)
        .map(|_| turned(Vec3::new(0.3, 0.999, 0.2) + dice.vector() * 1e-3, Vec3::Y, dice.roll()))
        .collect();
    let aligned: Vec<_> = (0..256)
        .map(|_| {
            turned(
                Vec3::Y + dice.vector() * 1e-3,
                (Vec3::Y + dice.vector() * 1e-3).normalize(),
                1e-3,
            )
        })
        .collect();
    let apart: Vec<_> = resting
        .iter()
        .map(|f| Frame { translation: f.translation + Vec3::Y * 0.1, ..*f })
        .collect();
    let edges: Vec<_> =
        resting.iter().map(|f| Frame { translation: Vec3::splat(0.9), ..*f }).collect();
    let diagonal: Vec<_> =
        aligned.iter().map(|f| Frame { translation: Vec3::new(1.005, 1.005, 0.0), ..*f }).collect();
    let random: Vec<_> = (0..256).map(|_| dice.frame(0.8)).collect();
    let ground: Vec<_> = resting
        .iter()
        .map(|f| Frame { translation: f.translation - Vec3::Y * 0.5, ..*f })
        .collect();
    let [capsule, hull, cylinder, half_space, sphere] = [
        Shape::capsule(0.3, 0.5).unwrap(),
        pairs::convex().swap_remove(4),
        Shape::cylinder(0.5, 0.5).unwrap(),
        Shape::half_space(),
        Shape::sphere(0.5).unwrap(),
    ];
    let cases = [
        ("box on box, turned", &unit, &unit, &resting),
        ("box on box, aligned", &unit, &unit, &aligned),
        ("box above box", &unit, &unit, &apart),
        ("box past box", &unit, &unit, &edges),
        ("box beside box, edges", &unit, &unit, &diagonal),
        ("box in box, any way", &unit, &unit, &random),
        ("box on half-space", &unit, &half_space, &ground),
        ("cylinder on half-space", &cylinder, &half_space, &ground),
        ("hull on half-space", &hull, &half_space, &ground),
        ("sphere on box", &sphere, &unit, &resting),
        ("capsule and box", &capsule, &unit, &random),
        ("capsule and capsule", &capsule, &capsule, &random),
        ("hull on box", &hull, &unit, &resting),
        ("cylinder on box", &cylinder, &unit, &resting),
        ("hull in hull", &hull, &hull, &random),
    ];
    for (name, a, b, frames) in cases {
        let mut scratch = Scratch::default();
        let (mut best, mut count) = (f64::INFINITY, 0);
        for _ in 0..30 {
            count = 0;
            let start = Instant::now();
            for frame in frames {
                collide(a, b, black_box(frame), 0.02, &mut scratch, &mut |m| {
                    count += black_box(m).points().len();
                });
            }
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!("{name}: {:.0} ns, {:.2} points", best * 1e9 / 256.0, count as f64 / 256.0);
    }
}
