//! Convex shapes set down exactly where they touch (physics.md K4): rounding must not decide whether they are held.

use super::*;

/// Size of the body that is set down, metres, and of the one below: a plate of twice that width.
const SIZE: f32 = 0.5;

/// An upright prism with a number of sides, a diameter and a height.
fn prism(sides: u32, across: f32, height: f32) -> Shape {
    let corners: Vec<Vec3> = (0..sides)
        .flat_map(|i| {
            let angle = core::f32::consts::TAU * i as f32 / sides as f32;
            let (sine, cosine) = libm::sincosf(angle);
            [-0.5, 0.5].map(|y| Vec3::new(0.5 * across * cosine, y * height, 0.5 * across * sine))
        })
        .collect();
    Shape::hull(&corners).unwrap()
}

/// Shapes with a flat top and bottom, of a width, and as high.
fn flat(across: f32) -> [(&'static str, Shape); 4] {
    [
        ("box", Shape::cuboid(Vec3::splat(across)).unwrap()),
        ("cylinder", Shape::cylinder(0.5 * across, across).unwrap()),
        ("prism of 7", prism(7, across, across)),
        ("prism of 32", prism(32, across, across)),
    ]
}

/// Shapes to set down: name, shape, height of the centre, and rotation for that.
fn tops() -> Vec<(&'static str, Shape, f32, Quat)> {
    let (radius, lies) = (0.5 * SIZE, turn(Vec3::Z, core::f32::consts::FRAC_PI_2));
    let thin = 0.5 * radius;
    let flat = flat(SIZE).map(|(name, shape)| (name, shape, radius, Quat::IDENTITY));
    let mut tops = Vec::from(flat);
    tops.push(("sphere", Shape::sphere(radius).unwrap(), radius, Quat::IDENTITY));
    tops.push(("capsule", Shape::capsule(thin, SIZE - radius).unwrap(), thin, lies));
    tops.push(("lying cylinder", Shape::cylinder(thin, SIZE).unwrap(), thin, lies));
    tops
}

/// The worst of a body that is set down in several places, with each of the gaps: its rise above the touching pose, its depth below that, and its sideways
/// speed.
fn worst(
    (top, tall, own): (&Shape, f32, Quat),
    below: &Shape,
    places: u32,
    is_body: bool,
    gaps: &[f32],
) -> [f32; 3] {
    let (mut random, mut worst) = (Random::new(7), [0.0_f32; 3]);
    for &gap in gaps {
        for _ in 0..places {
            let mut world = world();
            set_material(&mut world, rough(0.5));
            let (aside, yaws) = (0.5 * random.vector(), [random.fraction(), random.fraction()]);
            let [yaw, turned] = yaws.map(|share| turn(Vec3::Y, 6.0 * share));
            let height = if is_body {
                let ground = Collider::fixed(Shape::half_space(), Frame::IDENTITY);
                world.colliders.push(ground.with_material(rough(0.5)));
                let spec =
                    BoxSpec { size: Vec3::splat(2.0 * SIZE), mass: 10.0, ..BoxSpec::default() };
                add(&mut world, &box_3d(&spec).unwrap(), below.clone(), Vec3::Y * SIZE, yaw);
                2.0 * SIZE
            } else {
                let at = Frame::new(Vec3::ZERO, yaw);
                world.colliders.push(Collider::fixed(below.clone(), at).with_material(rough(0.5)));
                SIZE
            };
            let lies = height + tall;
            let at = Vec3::new(0.6 * SIZE * aside.x, lies + gap, 0.6 * SIZE * aside.z);
            let spec = BoxSpec { size: Vec3::splat(SIZE), mass: 2.0, ..BoxSpec::default() };
            let first = add(&mut world, &box_3d(&spec).unwrap(), top.clone(), at, turned * own);
            let mut met = gap < 1e-3;
            for _ in 0..120 {
                step(&mut world, 1.0 / 60.0);
                let (now, speed) = (centre(&world, first), velocity(&world, first));
                let above = now.y - lies;
                met |= above < 1e-5;
                let rose = if met { above } else { 0.0 };
                let seen = [rose - gap.min(1e-4), -above, speed.with_y(0.0).length()];
                for (worst, seen) in worst.iter_mut().zip(seen) {
                    *worst = if seen.is_nan() { f32::INFINITY } else { worst.max(seen) };
                }
            }
        }
    }
    worst
}

/// Rebound at most 0.1 mm, depth at most a thousandth of the size, no sideways speed.
fn good([rose, sank, aside]: [f32; 3]) -> bool {
    rose < 1e-4 && sank < 1e-3 * SIZE && aside < 1e-3
}

#[test]
fn convex_shapes_set_down_where_they_touch_stay_there() {
    let mut bad = Vec::new();
    for (name, top, tall, own) in tops() {
        for (other, below) in flat(2.0 * SIZE) {
            for is_body in [false, true] {
                let seen =
                    worst((&top, tall, own), &below, 5, is_body, &[0.0, 1e-7, 1e-6, 1e-4, 1e-3]);
                println!("{name} on {other}, {is_body}: {seen:?}");
                if !good(seen) {
                    bad.push(format!("{name} on {other} (a body: {is_body}): {seen:?}"));
                }
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}
