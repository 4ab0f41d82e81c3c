//! The transform of a compound, case by case.

use super::*;
use crate::test_random::Random;

impl Random {
    /// Uniform in the cube -1..1, except short ones.
    pub(super) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.vector();
            if v.length() > 0.1 {
                return v;
            }
        }
    }

    /// Uniform over all rotations.
    pub(super) fn rotation(&mut self) -> Quat {
        loop {
            let q = Quat::from_xyzw(self.number(), self.number(), self.number(), self.number());
            if (0.1..1.0).contains(&q.length()) {
                return unit(q).as_quat();
            }
        }
    }

    /// Any matrix, of norm 1.
    fn matrix(&mut self) -> DMat3 {
        let mut column = || self.direction().as_dvec3();
        let m = DMat3::from_cols(column(), column(), column());
        m * (1.0 / norm(m))
    }
}

pub(super) fn norm(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// `tr(Rᵀ M)`.
pub(super) fn score(q: DQuat, m: DMat3) -> f64 {
    let r = DMat3::from_quat(q);
    r.x_axis.dot(m.x_axis) + r.y_axis.dot(m.y_axis) + r.z_axis.dot(m.z_axis)
}

/// Angle between two rotations, rad; accurate for small angles too.
pub(super) fn angle_f64(a: DQuat, b: DQuat) -> f64 {
    let between = a.conjugate() * b;
    2.0 * libm::atan2(between.xyz().length(), between.w.abs())
}

pub(super) fn angle(a: Quat, b: Quat) -> f32 {
    angle_f64(unit(a), unit(b)) as f32
}

pub(super) fn about(axis: Vec3, angle: f32) -> Quat {
    let (sin, cos) = libm::sincosf(angle * 0.5);
    let v = axis.normalize() * sin;
    Quat::from_xyzw(v.x, v.y, v.z, cos)
}

/// Previous rotations: none, a random one, and the exact half turns away from `q`.
pub(super) fn starts(q: Quat, random: &mut Random) -> [Quat; 6] {
    let half = |x, y, z| q * Quat::from_xyzw(x, y, z, 0.0);
    [
        Quat::IDENTITY,
        random.rotation(),
        half(1.0, 0.0, 0.0),
        half(0.0, 1.0, 0.0),
        half(0.0, 0.0, 1.0),
        half(0.48, 0.6, 0.64),
    ]
}

pub(super) fn carried(rest: &[Vec3], by: impl Fn(Vec3) -> Vec3) -> Vec<(Vec3, Vec3, f32)> {
    rest.iter().map(|&r| (by(r), r, 1.0)).collect()
}

pub(super) fn fit(points: &[(Vec3, Vec3, f32)], previous: Quat) -> Pose {
    let found = pose(points.iter().copied(), previous).unwrap();
    assert!((found.rotation.length() - 1.0).abs() < 1e-6);
    found
}

pub(super) fn cube() -> [Vec3; 8] {
    let sign = |bit: usize| (bit & 1) as f32 * 2.0 - 1.0;
    std::array::from_fn(|i| Vec3::new(sign(i), sign(i >> 1), sign(i >> 2)))
}

#[test]
fn a_rigid_motion_is_found_from_any_previous_rotation() {
    let mut random = Random::new(1);
    let (mut turned, mut moved) = (0.0_f32, 0.0_f32);
    for _ in 0..2000 {
        let rest: [Vec3; 6] = std::array::from_fn(|_| random.direction() + Vec3::X);
        let (q, t) = (random.rotation(), random.direction());
        let points: Vec<_> = rest.iter().map(|&r| (q * r + t, r, random.number() + 1.1)).collect();
        for previous in starts(q, &mut random) {
            let found = fit(&points, previous);
            turned = turned.max(angle(found.rotation, q));
            moved = moved.max(
                points
                    .iter()
                    .fold(0.0, |worst, &(p, r, _)| worst.max((found.point(r) - p).length())),
            );
            assert!(unit(found.rotation).dot(unit(previous)) >= -1e-6);
        }
    }
    println!("rigid: worst {turned:e} rad, {moved:e} m");
    assert!(turned < 1e-5 && moved < 1e-5, "{turned:e} {moved:e}");
}

#[test]
fn a_rotation_times_any_stretch_is_found_exactly() {
    let mut random = Random::new(2);
    let mut worst = 0.0_f32;
    for _ in 0..2000 {
        // U D Uᵀ, with stretches from a fifth to five.
        let (q, u) = (random.rotation(), random.rotation());
        let d = Vec3::from_array(std::array::from_fn(|_| libm::powf(5.0, random.number())));
        let points = carried(&cube(), |r| q * (u * (d * (u.inverse() * r))));
        for previous in starts(q, &mut random) {
            worst = worst.max(angle(fit(&points, previous).rotation, q));
        }
    }
    println!("stretched: worst {worst:e} rad");
    assert!(worst < 1e-5, "{worst:e}");
}

#[test]
fn a_millimetre_and_a_kilometre_are_alike() {
    let mut random = Random::new(3);
    for size in [1e-15, 1e-3, 1.0, 1e3, 1e15] {
        let q = random.rotation();
        let points: Vec<_> =
            cube().iter().map(|&r| (q * (r * size), r * size, 1.0 / size)).collect();
        for previous in starts(q, &mut random) {
            assert!(angle(fit(&points, previous).rotation, q) < 1e-6, "{size:e}");
        }
    }
}

#[test]
fn the_warm_path_agrees_with_the_eigenproblem_and_beats_every_rotation_tried() {
    let mut random = Random::new(4);
    let (mut anywhere, mut near, mut worst) = (0, 0, 0.0_f64);
    for _ in 0..10_000 {
        let (m, previous) = (random.matrix(), unit(random.rotation()));
        let sure = rotation::davenport(m, previous);
        let mut agrees = |start| {
            let warm = rotation::newton(m, start);
            worst = worst.max(warm.map_or(0.0, |(q, _)| angle_f64(q, sure)));
            u32::from(warm.is_some())
        };
        anywhere += agrees(previous);
        near += agrees(sure * unit(about(random.direction(), 0.1)));
        let best = score(sure, m);
        for _ in 0..20 {
            assert!(score(unit(random.rotation()), m) <= best + 1e-15);
        }
    }
    println!("warm: {anywhere} from anywhere, {near} from 0.1 rad; worst {worst:e} rad");
    assert!(anywhere > 1000 && near > 8000, "{anywhere} {near}");
    assert!(worst < 1e-8, "{worst:e}");
}

#[test]
fn a_mirrored_compound_gets_the_best_proper_rotation() {
    let mut random = Random::new(5);
    for _ in 0..200 {
        let q = random.rotation();
        let rest: [Vec3; 8] =
            std::array::from_fn(|_| random.direction() * Vec3::new(3.0, 2.0, 1.0));
        let points = carried(&rest, |r| q * (r * Vec3::new(1.0, 1.0, -1.0)));
        let found = unit(fit(&points, random.rotation()).rotation);
        let m = MatchedMoments::sum(points.iter().map(|&(p, r, _)| (p, r, 1.0))).unwrap().moments;
        let m = m * (1.0 / norm(m));
        assert!(m.determinant() < 0.0);
        // Hill climbing from the best of many random rotations, with ever smaller turns: independent of rotation.rs.
        let mut best = (0..500).map(|_| unit(random.rotation())).fold(found, |best, q| {
            if best == found || score(q, m) > score(best, m) { q } else { best }
        });
        let mut size = 0.5;
        while size > 1e-7 {
            let mut better = false;
            for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
                let v = axis * size;
                let q = (best * DQuat::from_xyzw(v.x, v.y, v.z, 1.0)).normalize();
                if score(q, m) > score(best, m) {
                    (best, better) = (q, true);
                }
            }
            if !better {
                size *= 0.5;
            }
        }
        // The scores of rotations rounded to f32: the score is flat at its maximum.
        assert!(
            (score(found, m) - score(best, m)).abs() < 1e-11,
            "{} {}",
            score(found, m),
            score(best, m)
        );
    }
}

#[test]
fn a_mirrored_cube_turns_no_more_than_it_must() {
    // Where three directions are equally good, `previous` decides; starting from any of the optima, it is kept.
    let mut random = Random::new(6);
    for _ in 0..100 {
        let q = random.rotation();
        let points = carried(&cube(), |r| q * -r);
        let found = fit(&points, random.rotation()).rotation;
        assert!(angle(fit(&points, found).rotation, found) < 1e-6);
    }
}

#[test]
fn a_flat_square_has_all_of_its_orientation() {
    let mut random = Random::new(7);
    let square = [
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(-1.0, 1.0, 0.0),
        Vec3::new(-1.0, -1.0, 0.0),
        Vec3::new(1.0, -1.0, 0.0),
    ];
    for _ in 0..1000 {
        let q = random.rotation();
        for previous in starts(q, &mut random) {
            assert!(angle(fit(&carried(&square, |r| q * r), previous).rotation, q) < 1e-6);
            // Mirrored in its plane it is the square seen from behind.
            let behind = q * Quat::from_xyzw(0.0, 1.0, 0.0, 0.0);
            let mirrored = carried(&square, |r| q * (r * Vec3::new(-1.0, 1.0, 1.0)));
            assert!(angle(fit(&mirrored, previous).rotation, behind) < 1e-6);
        }
    }
}

#[test]
fn heavier_particles_pull_more_and_the_weightless_not_at_all() {
    let rest = [Vec3::X, Vec3::NEG_X];
    let found = |masses: [f32; 2]| {
        let now = [Vec3::X + Vec3::X, Vec3::NEG_X];
        let points: Vec<_> = (0..2).map(|i| (now[i], rest[i], masses[i])).collect();
        fit(&points, Quat::IDENTITY).translation.x
    };
    assert_eq!(found([1.0, 1.0]), 0.5);
    assert_eq!(found([3.0, 1.0]), 0.75);
    for none in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(found([none, 1.0]), 0.0);
        assert_eq!(found([none, none]), 0.5);
    }
}

#[test]
fn a_light_first_particle_costs_no_accuracy() {
    let mut random = Random::new(12);
    for _ in 0..200 {
        let q = random.rotation();
        let mut points = carried(&cube(), |r| q * r);
        let far = Vec3::new(30.0, -20.0, 10.0);
        points.insert(0, (q * far, far, 1e-6));
        assert!(angle(fit(&points, random.rotation()).rotation, q) < 1e-6);
    }
}

#[test]
fn the_warm_start_takes_two_or_three_steps() {
    // A box 1×2×3 at 6 rad/s and 60 Hz, a tenth of a radian a frame, deformed a little.
    let mut random = Random::new(13);
    let (mut steps, mut most) = (0, 0);
    for _ in 0..1000 {
        let q = random.rotation();
        let rest = cube().map(|r| r * Vec3::new(1.0, 2.0, 3.0));
        let now = rest.map(|r| q * r + random.direction() * 0.03);
        let m = MatchedMoments::sum((0..8).map(|i| (now[i], rest[i], 1.0))).unwrap().moments;
        let (_, taken) =
            rotation::newton(m * (1.0 / norm(m)), unit(q * about(random.direction(), 0.1)))
                .unwrap();
        steps += taken;
        most = most.max(taken);
    }
    println!("steps: mean {}, most {most}", f64::from(steps) / 1000.0);
    assert!(steps <= 3000 && most <= 4, "{steps} {most}");
}

#[test]
fn far_from_the_optimum_the_warm_path_declines_rather_than_errs() {
    let m = DMat3::IDENTITY * libm::sqrt(1.0 / 3.0);
    for half in [DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0), DQuat::from_xyzw(0.48, 0.6, 0.64, 0.0)] {
        // At a half turn all torques vanish; only the curvature shows that it is not the optimum.
        assert_eq!(rotation::newton(m, half), None);
        assert!(angle_f64(rotation::davenport(m, half), DQuat::IDENTITY) < 1e-12);
    }
}

#[test]
fn the_bits_are_the_same_on_every_machine() {
    let rest = cube().map(|r| r * Vec3::new(0.1, 0.7, 1.3));
    let points = rest.iter().enumerate().map(|(i, &r)| {
        let now = Vec3::new(0.3 * r.y + 1.7, 1.1 * r.z - 0.9 * r.x, r.x + 0.2 * r.y * r.z);
        (now, r, 0.1 * i as f32 + 0.3)
    });
    // By Newton's method, then by the eigenproblem.
    for previous in [Quat::from_xyzw(-0.4, -0.5, -0.4, 0.6), Quat::from_xyzw(0.0, 0.0, 0.0, 1.0)] {
        let Pose { translation: t, rotation: q } = pose(points.clone(), previous).unwrap();
        let sign = q.w.signum();
        let bits =
            [t.x, t.y, t.z, q.x * sign, q.y * sign, q.z * sign, q.w * sign].map(f32::to_bits);
        assert_eq!(
            bits,
            [
                0x3fcf_da55,
                0x3d13_a66e,
                0xbd23_45ed,
                0xbedc_2f50,
                0xbf0b_dfb6,
                0xbf12_4dc1,
                0x3edf_1ffa
            ],
            "{bits:#x?}"
        );
    }
}
