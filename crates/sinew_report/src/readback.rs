//! Rows E1 to E3: pose, motion and inertia that are computed from the particles of a compound.

use sinew::glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};
use sinew::pose::{motion, pose};

use crate::Row;
use crate::case::cases;
use crate::measure::{Dice, largest, rotation, vector};

cases! {
    "E1" the_transform_is_exact_for_any_rotation_and_stretch;
    "E1" the_transform_survives_mirrors_lines_points_and_half_turns;
    "E2" mass_barycentre_and_velocity_are_the_weighted_means;
    "E3" inertia_and_spin_are_those_of_a_rigid_body;
}

/// Angle between two rotations, radians.
fn turned(a: Quat, b: DQuat) -> f64 {
    let a = DQuat::from_xyzw(f64::from(a.x), f64::from(a.y), f64::from(a.z), f64::from(a.w));
    let d = a.conjugate() * b;
    2.0 * libm::atan2(DVec3::new(d.x, d.y, d.z).length(), d.w.abs())
}

/// Tolerance: positions and rotation are rounded to `f32`, 6e-8 of a metre or a radian, about four times each.
fn the_transform_is_exact_for_any_rotation_and_stretch() -> Vec<Row> {
    let mut dice = Dice(11);
    // The cube has equal moments, for which the rotation is exact under any stretch; the random bodies do not.
    let cube: Vec<DVec3> = (0..8)
        .map(|i| {
            DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 2.0 - 1.0
        })
        .collect();
    let mut worst = [0.0; 3];
    let mut error = |kind: usize, shape: &[DVec3], stretch: DMat3, dice: &mut Dice| {
        let (q, shift) = (rotation(dice), vector(dice));
        let now: Vec<Vec3> = shape.iter().map(|r| (q * (stretch * *r) + shift).as_vec3()).collect();
        let points = now.iter().zip(shape).map(|(&p, r)| (p, r.as_vec3(), 1.0));
        let found =
            pose(points, Quat::IDENTITY).map_or(f64::NAN, |found| turned(found.rotation, q));
        worst[kind] = largest([worst[kind], found]);
    };
    for _ in 0..1000 {
        let loose: Vec<DVec3> = (0..7).map(|_| vector(&mut dice)).collect();
        error(0, &loose, DMat3::IDENTITY, &mut dice);
        // S = Q D Qᵀ, symmetric and positive definite, along arbitrary axes.
        let axes = DMat3::from_quat(rotation(&mut dice));
        let scale = DVec3::new(0.5, 1.0, 2.0);
        error(1, &cube, axes * DMat3::from_diagonal(scale) * axes.transpose(), &mut dice);
        let flat: Vec<DVec3> = loose.iter().map(|r| DVec3::new(r.x, r.y, 0.0)).collect();
        error(2, &flat, DMat3::IDENTITY, &mut dice);
    }
    vec![
        Row::absolute(
            "1000 random bodies, turned at random, largest error",
            "rad",
            0.0,
            worst[0],
            5e-7,
        ),
        Row::absolute("1000 cubes, stretched by R·S along any axes", "rad", 0.0, worst[1], 5e-7),
        Row::absolute("1000 flat bodies", "rad", 0.0, worst[2], 2e-6),
    ]
}

/// `v` rotated by `q`.
fn carried(q: Quat, v: DVec3) -> DVec3 {
    DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into()) * v
}

/// Tolerance: some roundings of `f32`, as above; the direction of a line is accurate to 1e-7 rad.
fn the_transform_survives_mirrors_lines_points_and_half_turns() -> Vec<Row> {
    let mut dice = Dice(21);
    let [mut mirrored, mut aimed, mut kept, mut half] = [0.0; 4];
    for _ in 0..1000 {
        let q = rotation(&mut dice);
        let previous = rotation(&mut dice).as_quat();
        let shape: Vec<DVec3> = (0..7).map(|_| vector(&mut dice)).collect();
        let find = |now: &dyn Fn(DVec3) -> DVec3, shape: &[DVec3], previous| {
            let points: Vec<_> =
                shape.iter().map(|r| (now(*r).as_vec3(), r.as_vec3(), 1.0)).collect();
            pose(points.into_iter(), previous).map_or(Quat::NAN, |found| found.rotation)
        };
        let found = find(&|r| q * DVec3::new(-r.x, r.y, r.z), &shape, previous);
        mirrored = largest([mirrored, (f64::from(found.length()) - 1.0).abs()]);
        let line: Vec<DVec3> = [-1.0, 0.3, 1.0].map(|x| DVec3::X * x).into();
        let found = find(&|r| q * r, &line, previous);
        aimed = largest([aimed, (carried(found, DVec3::X) - q * DVec3::X).length()]);
        let found = find(&|_| DVec3::ONE, &shape, previous);
        kept = largest([kept, turned(found, previous.as_dquat().normalize())]);
        let axis = vector(&mut dice).normalize();
        let turn = DQuat::from_xyzw(axis.x, axis.y, axis.z, 0.0);
        half = largest([half, turned(find(&|r| turn * r, &shape, Quat::IDENTITY), turn)]);
    }
    vec![
        Row::absolute(
            "1000 mirrored bodies: error of the quaternion's length",
            "",
            0.0,
            mirrored,
            3e-7,
        ),
        Row::absolute("1000 lines: error of the direction", "", 0.0, aimed, 5e-7),
        Row::absolute(
            "1000 bodies collapsed to a point: rotation from the previous one",
            "rad",
            0.0,
            kept,
            5e-7,
        ),
        Row::absolute("1000 half turns, largest error", "rad", 0.0, half, 5e-7),
    ]
}

/// Eight particles of different masses, moving rigidly: position, velocity and mass of each, the velocity and the angular velocity.
fn moving_body() -> (Vec<(Vec3, Vec3, f32)>, DVec3, DVec3) {
    let mut dice = Dice(5);
    let (velocity, omega) = (DVec3::new(1.0, -2.0, 0.5), DVec3::new(0.7, 3.0, -1.1));
    let points = (0..8)
        .map(|n| {
            let r = vector(&mut dice);
            let v = velocity + omega.cross(r);
            (r.as_vec3(), v.as_vec3(), 0.5 + n as f32)
        })
        .collect();
    (points, velocity, omega)
}

fn mass_barycentre_and_velocity_are_the_weighted_means() -> Vec<Row> {
    let (points, velocity, omega) = moving_body();
    let found = motion(points.iter().copied()).expect("a compound of finite particles");
    let mass: f64 = points.iter().map(|p| f64::from(p.2)).sum();
    let centre = points.iter().map(|p| p.0.as_dvec3() * f64::from(p.2)).sum::<DVec3>() / mass;
    let exact = velocity + omega.cross(centre);
    let off = (found.barycentre.as_dvec3() - centre).length();
    let slow = (found.velocity.as_dvec3() - exact).length();
    vec![
        Row::relative("mass of 8 particles", "kg", mass, f64::from(found.mass), 1e-7),
        // Summed in f64 and rounded once at the end.
        Row::absolute("error of the barycentre", "m", 0.0, off, 1e-7),
        Row::absolute("error of its velocity", "m/s", 0.0, slow, 5e-7),
    ]
}

fn inertia_and_spin_are_those_of_a_rigid_body() -> Vec<Row> {
    let (points, _, omega) = moving_body();
    let found = motion(points.iter().copied()).expect("a compound of finite particles");
    let off = (found.angular_velocity.as_dvec3() - omega).length();
    let centre = found.barycentre.as_dvec3();
    let mut exact = DMat3::ZERO;
    for &(p, _, m) in &points {
        let r = p.as_dvec3() - centre;
        let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
        exact += (DMat3::IDENTITY * r.length_squared() - outer) * f64::from(m);
    }
    let size = |m: Mat3| {
        (m.as_dmat3() - exact).to_cols_array().iter().map(|x| x.abs()).fold(0.0, f64::max)
    };
    // The spin of a rod about its own length is undetermined; the pseudo-inverse gives zero.
    let rod = [-1.0, 1.0].map(|x| {
        let r = Vec3::X * x;
        (r, Vec3::new(5.0, 2.0, 0.0).cross(r), 1.0)
    });
    let line = motion(rod.into_iter()).expect("a rod").angular_velocity.as_dvec3();
    vec![
        Row::absolute("error of the angular velocity", "rad/s", 0.0, off, 1e-6),
        Row::relative(
            "largest relative error of the inertia tensor",
            "",
            1.0,
            1.0 + size(found.inertia) / exact.x_axis.x,
            2e-7,
        ),
        Row::absolute("spin of a rod about its length", "rad/s", 0.0, line.x, 0.0),
        Row::absolute("spin of a rod across it", "rad/s", 2.0, line.y, 2e-7),
    ]
}
