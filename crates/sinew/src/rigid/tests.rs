//! Explicit rigid bodies: falling, turning, flipping, and what must be conserved.

use glam::{DQuat, DVec3, Mat3, Quat, Vec3};

use super::principal::{Principal, Spin};
use super::*;

const ALL: [RigidIntegrator; 3] =
    [RigidIntegrator::Euler, RigidIntegrator::Leapfrog, RigidIntegrator::Verlet];
const GOOD: [RigidIntegrator; 2] = [RigidIntegrator::Leapfrog, RigidIntegrator::Verlet];

/// An integrator of the rotation, in `f64`.
type Way = fn(Spin, &Principal, DVec3, f64) -> Spin;

/// The box of physics.md B2: edges 1, 2, 3 m, ω = 6 rad/s about the middle axis, tilted by 1 % towards the
/// shortest edge. (Towards the longest, it would flip every 4.057 s.)
fn tumbling() -> RigidBody {
    let angular_velocity = Vec3::new(0.06, 6.0, 0.0);
    RigidBody { angular_velocity, ..RigidBody::solid_box(Vec3::new(1.0, 2.0, 3.0), 5.0) }
}

/// Angular velocity in the body's frame.
fn inside(body: &RigidBody) -> DVec3 {
    body.turn().conjugate() * body.angular_velocity.as_dvec3()
}

fn run(body: &mut RigidBody, torque: Vec3, h: f32, steps: u32, integrator: RigidIntegrator) {
    for _ in 0..steps {
        body.step(Vec3::ZERO, torque, h, integrator).unwrap();
    }
}

/// Mean time in seconds between successive flips over the middle axis, from the first few.
fn flips(mut body: RigidBody, h: f32, integrator: RigidIntegrator) -> f64 {
    let (mut times, mut before) = (Vec::new(), inside(&body).y);
    for step in 1..(30.0 / h) as u32 {
        run(&mut body, Vec3::ZERO, h, 1, integrator);
        let now = inside(&body).y;
        if now * before < 0.0 {
            times.push(f64::from(h) * (f64::from(step) - now / (now - before)));
        }
        before = now;
    }
    (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64
}

#[test]
fn a_thrown_box_flips_every_3_903_seconds() {
    for integrator in GOOD {
        let period = flips(tumbling(), 1.0 / 240.0, integrator);
        println!("{integrator:?}: flip every {period:.5} s");
        assert!((period / 3.903 - 1.0).abs() < 0.01, "{integrator:?} {period}");
    }
}

#[test]
fn it_is_the_rounding_to_f32_that_moves_the_flips_by_a_thousandth() {
    for way in [leapfrog::turn as Way, verlet::turn] {
        let body = tumbling();
        let principal = body.principal().unwrap();
        let mut spin = Spin { rotation: DQuat::IDENTITY, momentum: body.angular_momentum() };
        let (mut times, mut before, h) = (Vec::new(), spin.body_momentum().y, 1.0 / 240.0);
        for step in 1..7200 {
            spin = way(spin, &principal, DVec3::ZERO, h);
            let now = spin.body_momentum().y;
            if now * before < 0.0 {
                times.push(h * (f64::from(step) - now / (now - before)));
            }
            before = now;
        }
        let period = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
        println!("in f64: flip every {period:.5} s");
        assert!((period - 3.90315).abs() < 1e-3, "{period}");
    }
}

/// The rotation of a free asymmetric top, not axis-aligned, after 2 s, in `f64` throughout.
fn turned(steps: u32, way: Way) -> Spin {
    let tilt = Mat3::from_quat(Quat::from_xyzw(0.5, 0.1, -0.7, 0.5).normalize());
    let inertia = tilt * Mat3::from_diagonal(Vec3::new(1.0, 1.7, 2.4)) * tilt.transpose();
    let principal = Principal::new(((inertia + inertia.transpose()) * 0.5).as_dmat3()).unwrap();
    let mut spin = Spin { rotation: DQuat::IDENTITY, momentum: DVec3::new(2.0, 5.0, -3.0) };
    for _ in 0..steps {
        spin = way(spin, &principal, DVec3::ZERO, 2.0 / f64::from(steps));
    }
    spin
}

fn apart(a: DQuat, b: DQuat) -> f64 {
    (a - b).length().min((a + b).length()) * 2.0
}

#[test]
fn leapfrog_and_verlet_are_of_order_two_and_euler_of_order_one() {
    let ways: [(&str, Way, f64); 3] = [
        ("Euler", euler::turn, 1.0),
        ("Leapfrog", leapfrog::turn, 2.0),
        ("Verlet", verlet::turn, 2.0),
    ];
    // Two independent methods agree on the reference.
    let exact = turned(1 << 17, leapfrog::turn).rotation;
    assert!(apart(exact, turned(1 << 17, verlet::turn).rotation) < 1e-8);
    for (name, way, order) in ways {
        let coarsest = if order == 1.0 { 4096 } else { 128 };
        let errors: Vec<f64> =
            (0..4).map(|k| apart(turned(coarsest << k, way).rotation, exact)).collect();
        let orders: Vec<f64> = errors.windows(2).map(|e| libm::log2(e[0] / e[1])).collect();
        println!("{name}: errors {errors:?}, orders {orders:.3?}");
        assert!(orders.iter().all(|o| (o - order).abs() < 0.1), "{name} {orders:?}");
    }
}

#[test]
fn ten_thousand_steps_keep_energy_and_angular_momentum() {
    for integrator in ALL {
        let mut body = tumbling();
        let (energy, momentum) = (body.kinetic_energy(), body.angular_momentum());
        let (mut worst, mut late) = (0.0_f64, 0.0_f64);
        for step in 0..10_000 {
            run(&mut body, Vec3::ZERO, 1.0 / 240.0, 1, integrator);
            let off = body.kinetic_energy() / energy - 1.0;
            worst = worst.max(off.abs());
            // The error is largest just after a flip of the box, so a drift shows in the mean, not in the maximum.
            late += if step >= 9000 { off / 1000.0 } else { 0.0 };
        }
        let turned = (body.angular_momentum() - momentum).length() / momentum.length();
        println!("{integrator:?}: energy {worst:.2e}, mean of last {late:.2e}, L {turned:.2e}");
        if integrator == RigidIntegrator::Euler {
            assert!(worst > 1e-2 && turned > 1e-2, "not so bad after all: {worst} {turned}");
        } else {
            assert!(worst < 1e-3 && late.abs() < 2e-4, "{integrator:?} {worst} {late}");
            assert!(turned < 1e-5, "{integrator:?} {turned}");
        }
    }
    // Without rounding to f32, exact to the last bits.
    for way in [leapfrog::turn, verlet::turn] {
        let left = turned(10_000, way).momentum - DVec3::new(2.0, 5.0, -3.0);
        assert_eq!(left, DVec3::ZERO);
    }
}

#[test]
fn a_step_back_undoes_a_step() {
    let torque = Vec3::new(0.5, -2.0, 1.0);
    for integrator in GOOD {
        let start = RigidBody { velocity: Vec3::new(1.0, 2.0, 3.0), ..tumbling() };
        let mut body = start;
        for h in [0.02, -0.02] {
            for _ in 0..100 {
                body.step(Vec3::NEG_Y * 49.05, torque, h, integrator).unwrap();
            }
        }
        let away = (body.rotation.xyz() - start.rotation.xyz()).length();
        let rate = (body.angular_velocity - start.angular_velocity).length();
        let moved = body.origin + body.position;
        assert!(away < 1e-5 && rate < 1e-4 && moved.length() < 1e-4, "{away} {rate} {moved}");
    }
}

#[test]
fn a_thrown_body_falls_along_the_parabola() {
    let (h, velocity) = (1.0 / 64.0, Vec3::new(3.0, 8.0, -1.0));
    let gravity = Vec3::NEG_Y * 9.81;
    for integrator in ALL {
        let mut body = RigidBody { velocity, ..tumbling() };
        for _ in 0..128 {
            body.step(gravity * body.mass, Vec3::ZERO, h, integrator).unwrap();
        }
        let exact = velocity * 2.0 + gravity * 2.0;
        let early = if integrator == RigidIntegrator::Euler { gravity * h } else { Vec3::ZERO };
        let place = body.origin + body.position;
        assert!((place - exact - early).length() < 2e-5, "{integrator:?} {place} {exact}");
        assert!((body.velocity - velocity - gravity * 2.0).length() < 2e-5);
    }
}

#[test]
fn a_torque_about_a_principal_axis_gives_alpha_and_half_alpha_t_squared() {
    let box_ = RigidBody::solid_box(Vec3::new(1.0, 2.0, 3.0), 6.0);
    for integrator in ALL {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let mut body = box_;
            run(&mut body, axis * 2.0, 1.0 / 256.0, 256, integrator);
            let moment = (body.inertia * axis).dot(axis);
            let alpha = 2.0 / moment;
            // 256 equal changes, each rounded to f32.
            let off = (body.angular_velocity - axis * alpha).length() / alpha;
            assert!(off < 1e-5, "{integrator:?} {axis} {off}");
            let angle = 2.0 * libm::atan2f(body.rotation.xyz().length(), body.rotation.w.abs());
            // A Verlet step turns by the angle whose sine it should have; Euler is half a step ahead.
            let allowed = if integrator == RigidIntegrator::Euler { 0.01 } else { 1e-5 };
            assert!((angle / (0.5 * alpha) - 1.0).abs() < allowed, "{integrator:?} {angle}");
        }
    }
}

#[test]
fn a_body_with_two_equal_moments_is_exact_with_leapfrog_at_any_step() {
    let top = RigidBody::solid_box(Vec3::new(1.0, 1.0, 0.1), 1.0);
    let start = RigidBody { angular_velocity: Vec3::new(1.0, 2.0, 20.0), ..top };
    let (mut coarse, mut fine) = (start, start);
    run(&mut coarse, Vec3::ZERO, 0.25, 8, RigidIntegrator::Leapfrog);
    run(&mut fine, Vec3::ZERO, 1.0 / 4096.0, 8192, RigidIntegrator::Verlet);
    assert!((coarse.angular_velocity - fine.angular_velocity).length() < 1e-3);
    assert!((coarse.kinetic_energy() / start.kinetic_energy() - 1.0).abs() < 1e-6);
}

#[test]
fn five_kilometres_away_it_moves_bit_for_bit_as_at_zero() {
    let far = Vec3::new(5000.0, -3000.0, 70_000.0);
    let here = RigidBody { velocity: Vec3::new(9.0, 1.0, -2.0), ..tumbling() };
    let (mut a, mut b) = (here, RigidBody { origin: far, ..here });
    for _ in 0..500 {
        for body in [&mut a, &mut b] {
            let weight = Vec3::NEG_Y * 9.81 * body.mass;
            body.step(weight, Vec3::X, 1.0 / 60.0, RigidIntegrator::Leapfrog).unwrap();
        }
    }
    assert_eq!(b, RigidBody { origin: a.origin + far, ..a });
    assert!(a.origin.x > 70.0 && a.position.abs().max_element() <= 0.5, "{a:?}");
}

#[test]
fn an_impulse_changes_momentum_and_angular_momentum_by_exactly_itself() {
    let mut body = RigidBody { position: Vec3::new(0.25, -0.5, 0.125), ..tumbling() };
    run(&mut body, Vec3::ZERO, 0.01, 37, RigidIntegrator::Verlet);
    let before = (body.momentum(), body.angular_momentum_about_zero());
    let (impulse, point) = (Vec3::new(1.0, -2.0, 3.0), Vec3::new(1.0, 1.0, -0.5));
    let speed = body.point_velocity(point);
    body.apply_impulse_at(impulse, point);
    assert!((body.momentum() - before.0 - impulse.as_dvec3()).length() < 1e-6);
    let gained = body.angular_momentum_about_zero() - before.1;
    assert!((gained - point.as_dvec3().cross(impulse.as_dvec3())).length() < 1e-5, "{gained}");
    assert!((body.point_velocity(point) - speed).dot(impulse) > 0.0, "it gave way");
    let after = body;
    body.apply_impulse(Vec3::NAN);
    body.apply_angular_impulse(Vec3::INFINITY);
    assert_eq!(body, after);
}

#[test]
fn rods_and_points_turn_only_about_axes_that_have_inertia() {
    let rod = RigidBody::new(1.0, Mat3::from_diagonal(Vec3::new(0.0, 2.0, 2.0)));
    let point = RigidBody::new(1.0, Mat3::ZERO);
    for integrator in ALL {
        let mut body = RigidBody { angular_velocity: Vec3::new(5.0, 1.0, 0.0), ..rod };
        run(&mut body, Vec3::new(1.0, 0.0, 0.5), 0.01, 300, integrator);
        let along = body.turn() * DVec3::X;
        assert!(body.angular_velocity.as_dvec3().dot(along).abs() < 1e-5, "{body:?}");
        assert!(body.angular_velocity.length() > 0.5);
        let mut body = RigidBody { angular_velocity: Vec3::ONE, ..point };
        run(&mut body, Vec3::ONE, 0.01, 10, integrator);
        assert_eq!((body.angular_velocity, body.rotation), (Vec3::ZERO, Quat::IDENTITY));
    }
}

#[test]
fn each_fault_is_refused_and_changes_nothing() {
    let good = tumbling();
    let skew = Mat3::from_cols(Vec3::new(1.0, 0.5, 0.0), Vec3::Y, Vec3::Z);
    let bad = [
        (RigidBody { origin: Vec3::NAN, ..good }, RigidFault::Position),
        (RigidBody { centre: Vec3::INFINITY, ..good }, RigidFault::Position),
        (RigidBody { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..good }, RigidFault::Rotation),
        (RigidBody { rotation: Quat::NAN, ..good }, RigidFault::Rotation),
        (RigidBody { velocity: Vec3::NAN, ..good }, RigidFault::Velocity),
        (RigidBody { angular_velocity: Vec3::INFINITY, ..good }, RigidFault::Velocity),
        (RigidBody { mass: 0.0, ..good }, RigidFault::Mass),
        (RigidBody { mass: f32::INFINITY, ..good }, RigidFault::Mass),
        (RigidBody { mass: 1e-45, ..good }, RigidFault::Mass),
        (RigidBody { inertia: skew, ..good }, RigidFault::Inertia),
        (RigidBody { inertia: Mat3::NAN, ..good }, RigidFault::Inertia),
        (RigidBody { inertia: -good.inertia, ..good }, RigidFault::Inertia),
    ];
    for (mut body, fault) in bad {
        assert_eq!(body.fault(), Some(fault));
        let before = format!("{body:?}");
        let step = body.step(Vec3::ZERO, Vec3::ZERO, 0.1, RigidIntegrator::Verlet);
        assert_eq!((step, format!("{body:?}")), (Err(fault), before));
    }
    let mut body = good;
    for (force, torque, h) in [
        (Vec3::NAN, Vec3::ZERO, 0.1),
        (Vec3::ZERO, Vec3::INFINITY, 0.1),
        (Vec3::ZERO, Vec3::ZERO, f32::NAN),
        (Vec3::MAX, Vec3::ZERO, 1e30),
        (Vec3::ZERO, Vec3::MAX, 1e30),
    ] {
        for integrator in ALL {
            assert_eq!(
                body.step(force, torque, h, integrator),
                Err(RigidFault::Step),
                "{force} {torque} {h}"
            );
            assert_eq!(body, good);
        }
    }
}

#[test]
fn however_fast_it_turns_and_however_long_the_step_it_stays_finite_and_keeps_its_momentum() {
    for rate in [10.0, 1e3, 1e6, 1e12] {
        for integrator in GOOD {
            let angular_velocity = Vec3::new(rate, 0.3 * rate, -0.5 * rate);
            let mut body = RigidBody { angular_velocity, ..tumbling() };
            let (energy, momentum) = (body.kinetic_energy(), body.angular_momentum());
            run(&mut body, Vec3::ZERO, 1.0 / 60.0, 100, integrator);
            let turned = (body.angular_momentum() - momentum).length() / momentum.length();
            let ratio = body.kinetic_energy() / energy;
            assert!(turned < 1e-5, "{integrator:?} {rate} {turned}");
            // With |L| kept, the energy lies between L²/2I of the axes of greatest and least inertia.
            assert!((0.2..5.0).contains(&ratio), "{integrator:?} {rate} {ratio}");
        }
    }
}

#[test]
fn euler_runs_away_in_the_end_and_the_body_stays_where_it_was_last_finite() {
    let mut body = RigidBody { angular_velocity: Vec3::new(30.0, 20.0, 10.0), ..tumbling() };
    let step = |body: &mut RigidBody| {
        body.step(Vec3::ZERO, Vec3::ZERO, 1.0 / 60.0, RigidIntegrator::Euler)
    };
    let refused = (0..100_000).find(|_| step(&mut body).is_err());
    println!("Euler is refused after {refused:?} steps");
    assert!(refused.is_some() && body.fault().is_none());
    let last = body;
    assert_eq!((step(&mut body), body), (Err(RigidFault::Step), last));
}

#[test]
fn no_step_at_all_changes_nothing_but_the_length_of_a_quaternion() {
    for integrator in ALL {
        let mut body = tumbling();
        run(&mut body, Vec3::ONE, 0.0, 1, integrator);
        assert!((body.angular_velocity - tumbling().angular_velocity).length() < 1e-6);
        assert_eq!((body.rotation, body.position), (Quat::IDENTITY, Vec3::ZERO));
    }
}
