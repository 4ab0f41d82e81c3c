//! Validity of a manifold: the bounds that it states for sliding and turning.

use super::*;

/// Heights of a manifold's points with the first shape at another frame, metres.
fn heights(manifold: &Manifold, frame: &Frame) -> Vec<f32> {
    let height = |p: &Point| (frame.point(p.on_a) - p.on_b).dot(manifold.normal);
    manifold.points().iter().map(height).collect()
}

#[test]
fn a_capsule_that_slides_on_a_face_no_farther_than_it_may_touches_it_as_before() {
    let capsule = Shape::capsule(0.05, 0.4).unwrap();
    let plate = Shape::cuboid(Vec3::new(1.2, 0.4, 2.0)).unwrap();
    let mut random = Random::new(5);
    let (mut slid, mut at_rims) = (0, 0);
    for _ in 0..4000 {
        let mut frame = turned(Vec3::ZERO, random.vector().normalize(), 3.0 * random.number());
        let low = (frame.rotation.y_axis.y * 0.2).abs() + 0.05;
        frame.translation =
            Vec3::new(0.8 * random.number(), 0.2 + low + 0.01 * random.number(), random.number());
        for manifold in all(&capsule, &plate, &frame, 0.03) {
            assert!(manifold.is_round() && manifold.slope == 0.0);
            if manifold.slide_limit == 0.0 {
                at_rims += 1;
                continue;
            }
            let aside = (random.vector() * Vec3::new(1.0, 0.0, 1.0)).normalize() * 0.99;
            let there =
                Frame { translation: frame.translation + aside * manifold.slide_limit, ..frame };
            let found = all(&capsule, &plate, &there, 0.03);
            assert!(found[0].normal == manifold.normal, "{manifold:?}");
            for known in heights(&manifold, &there) {
                // Beyond a rim another end may be clipped, which is higher.
                let same = |p: &Point| (p.distance - known).abs() < 1e-5;
                assert!(found[0].points().iter().any(same), "{known} {found:?}");
                assert!(found[0].nearest() > manifold.nearest() - 1e-5);
            }
            slid += 1;
        }
    }
    assert!(slid > 500 && at_rims > 100, "{slid} {at_rims}");
}

#[test]
fn a_shape_on_a_half_space_may_slide_without_limit() {
    let mut random = Random::new(6);
    for (shape, i) in pairs::convex().iter().zip(0..) {
        for _ in 0..50 {
            let mut frame = random.frame(1.0);
            frame.translation.y =
                pairs::support(i, frame.turn_back(Vec3::Y)) + 0.01 * random.number();
            let known = all(shape, &Shape::half_space(), &frame, 0.05)[0];
            assert!(known.slide_limit == f32::INFINITY);
            frame.translation += random.vector() * Vec3::new(10.0, 0.0, 10.0);
            let now = all(shape, &Shape::half_space(), &frame, 0.05)[0];
            for (now, known) in now.points().iter().zip(heights(&known, &frame)) {
                assert!((now.distance - known).abs() < 1e-5, "{now:?} {known}");
            }
        }
    }
}

#[test]
fn what_is_round_is_where_its_manifold_says_after_it_has_rolled_a_little() {
    let capsule = Shape::capsule(0.05, 0.4).unwrap();
    let plate = Shape::cuboid(Vec3::new(2.0, 0.4, 2.0)).unwrap();
    // 0.05 rad is what it may turn: half the square of that is 1/800 of its radius.
    let (lies, angle) = (turn_of(Vec3::Z, core::f32::consts::FRAC_PI_2), 0.05);
    let frame = Frame::new(Vec3::Y * 0.25, lies);
    let known = all(&capsule, &plate, &frame, 0.03)[0];
    assert!(known.is_round() && known.points().len() == 2);
    let rolled = Frame::new(Vec3::Y * 0.25, turn_of(Vec3::X, angle) * lies);
    for height in heights(&known, &rolled) {
        assert!(height.abs() < 0.05 / 700.0, "{height}");
    }
    // For a box the error is the full rise of its corners.
    let cube = Shape::cuboid(Vec3::splat(0.4)).unwrap();
    let known = all(&cube, &plate, &Frame::at(Vec3::Y * 0.4), 0.03)[0];
    assert!(!known.is_round());
}

/// A rotation about an axis, rad.
fn turn_of(axis: Vec3, angle: f32) -> Quat {
    let axis = axis * libm::sinf(0.5 * angle);
    Quat::from_xyzw(axis.x, axis.y, axis.z, libm::cosf(0.5 * angle))
}
