//! Unfavourable but stable supports: on two thin corners, or wedged between two slopes. Both were found in heaps of a thousand boxes that did not come to
//! rest.

use glam::Mat3;

use super::*;

/// Half of an edge of all boxes here, metres.
const HALF: f32 = 0.25;

/// A rotation from two of its axes.
fn facing(x: [f32; 3], y: [f32; 3]) -> Quat {
    let x = Vec3::from(x).normalize();
    let z = x.cross(Vec3::from(y)).normalize();
    Quat::from_mat3(&Mat3::from_cols(x, z.cross(x), z)).normalize()
}

/// Kinetic and potential energy of all particles, J.
fn energy(world: &Simulation) -> f64 {
    let particles = &world.particles;
    let of = |i: usize| {
        let (speed, height) = (particles.velocity(i).length_squared(), particles.position(i).y);
        f64::from(particles.mass(i)) * (0.5 * f64::from(speed) + 9.81 * f64::from(height))
    };
    (0..particles.len()).map(of).sum()
}

/// It lies on a corner of each of two boxes, triangles of 3 cm by 15. Whenever it leaned to one side, the edges that crossed there were nearer than its face
/// was assumed to be, whose lowest corner is far away; so it was held in that one point of three, came down on the others a millimetre later, and was pushed
/// out of them: it rocked for minutes.
#[test]
fn a_box_that_rocks_on_two_thin_corners_gains_nothing_and_comes_to_rest() {
    let mut world = world();
    floor(&mut world, rough(0.5));
    let size = Vec3::splat(2.0 * HALF);
    let below = [
        ([-0.0849, HALF, 0.5079], [-0.99945, 0.0, -0.03303], [0.03303, 0.0, -0.99945]),
        ([-0.1857, HALF, -0.5149], [0.05484, 0.0, 0.9985], [-0.9985, 0.0, 0.05484]),
    ];
    for (at, x, y) in below {
        add_box(&mut world, size, 5.0, Vec3::from(at), facing(x, y));
    }
    let turned = facing([0.2313, 0.0, -0.9729], [0.0, 1.0, 0.0]);
    let first = add_box(&mut world, size, 5.0, Vec3::Y * 3.0 * HALF, turned);
    throw(&mut world, first, Vec3::new(0.06, -0.021, -0.024), Vec3::new(-0.098, 0.0, -0.242));
    let (mut before, mut gained) = (energy(&world), 0.0_f64);
    for _ in 0..180 {
        step(&mut world, 1.0 / 60.0);
        let now = energy(&world);
        gained += (now - before).max(0.0);
        before = now;
    }
    assert!(gained < 2e-3, "{gained} J of the 0.03 that it had");
    assert!(speed(&world) < 1e-3, "{}", speed(&world));
}

/// It leans on one box by a face and on another one by an edge, both too steep for friction on either one alone. Friction acted on both against all of the
/// fall of a substep, and against that alone.
#[test]
fn a_box_wedged_between_two_slopes_does_not_creep() {
    let mut world = world();
    set_material(&mut world, rough(0.5));
    let around = [
        ([0.74679, -0.32887, 0.27868], [0.2881, -0.9553, -0.06637], [-0.94493, -0.29484, 0.14204]),
        ([-0.35458, -0.36855, 0.09321], [-0.66405, 0.56501, 0.48969], [0.4701, 0.8248, -0.31419]),
        ([0.59406, -0.02533, -0.4157], [-0.80199, 0.58816, 0.10432], [0.59323, 0.76375, 0.2545]),
        (
            [0.14736, -0.28505, -0.57905],
            [-0.74208, 0.52518, 0.41655],
            [-0.64823, -0.72045, -0.24647],
        ),
    ];
    for (at, x, y) in around {
        let frame = Frame::new(Vec3::from(at), facing(x, y));
        let shape = Shape::cuboid(Vec3::splat(HALF * 2.0)).unwrap();
        world.colliders.push(Collider::fixed(shape, frame).with_material(rough(0.5)));
    }
    let size = Vec3::splat(2.0 * HALF);
    let turned = facing([0.70421, -0.5651, -0.42982], [-0.53206, -0.01917, -0.84649]);
    let first = add_box(&mut world, size, 5.0, Vec3::ZERO, turned);
    step(&mut world, 2.0);
    let places = |world: &Simulation| {
        (first..first + 8).map(|i| world.particles.position(i)).collect::<Vec<_>>()
    };
    let before = places(&world);
    step(&mut world, 4.0);
    let crept = places(&world).iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(before.iter().all(|p| p.length() < 0.5), "it has fallen out: {before:?}");
    assert!(crept < 1e-4, "{crept} m in four seconds");
}
