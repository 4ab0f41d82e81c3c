//! Rows C1 to C5, C10 and C11: distances, pins, boundaries, joint limits, and a constraint defined by the game.

use core::f64::consts::PI;

use sinew::constraints::{Angle, Cone, Hinge};
use sinew::glam::{DVec3, Vec3};
use sinew::{
    Bound, Constraint, ConstraintKind, Distance, Equation, InsideBox, ParticleSeed, Pin, Plane,
    Points, Simulation,
};

use crate::Row;
use crate::case::cases;
use crate::measure::{TICK, at, empty, largest, step, steps};

cases! {
    "C1" two_particles_share_a_correction_by_their_masses;
    "C1" coincident_particles_separate_along_x;
    "C2" ropes_only_pull_and_struts_only_push;
    "C3" a_pinned_particle_is_where_its_moving_target_is;
    "C4" boundaries_project_to_the_nearest_point;
    "C5" a_joint_stays_within_its_limits;
    "C5" limits_keep_momentum_and_angular_momentum;
    "C10" a_particle_at_rest_on_a_plane_does_not_creep;
    "C11" a_custom_constraint_gives_the_results_of_a_built_in_one;
}

/// A simulation of particles at rest without gravity, each with a position and a mass; one substep a step, with `sweeps` sweeps in it.
pub(crate) fn placed(points: &[(Vec3, f32)], sweeps: u32) -> Simulation {
    let mut world = empty(1);
    world.settings.max_sweeps = sweeps;
    world.settings.tolerance = 0.0;
    for &(at, mass) in points {
        world.particles.push(ParticleSeed::at(at).with_mass(mass)).expect("a sound particle");
    }
    world
}

/// Positions of the particles, metres.
pub(crate) fn places(world: &Simulation) -> Vec<DVec3> {
    (0..world.particles.len()).map(|i| at(world, i)).collect()
}

/// Tolerance: one or two roundings of a coordinate of 4 m.
fn two_particles_share_a_correction_by_their_masses() -> Vec<Row> {
    let points = [(Vec3::new(0.0, 1.0, 0.0), 2.0), (Vec3::new(3.0, 1.0, 4.0), 3.0)];
    let mut world = placed(&points, 1);
    world.distances_mut().push(Distance::new(0, 1, 2.0));
    let before = places(&world);
    step(&mut world, TICK);
    let after = places(&world);
    let way = [0, 1].map(|i| after[i] - before[i]);
    let balance = (way[0] * 2.0 + way[1] * 3.0).length();
    vec![
        Row::absolute(
            "displacement of 2 kg, 3 m too far from 3 kg: 3·m_b/(m_a+m_b)",
            "m",
            1.8,
            way[0].length(),
            1e-6,
        ),
        Row::absolute("displacement of 3 kg", "m", 1.2, way[1].length(), 1e-6),
        Row::absolute("Σ m d", "kg·m", 0.0, balance, 3e-6),
        Row::absolute(
            "their distance after one projection",
            "m",
            2.0,
            (after[0] - after[1]).length(),
            1e-6,
        ),
    ]
}

fn coincident_particles_separate_along_x() -> Vec<Row> {
    let mut world = placed(&[(Vec3::Y, 1.0), (Vec3::Y, 1.0)], 1);
    world.distances_mut().push(Distance::new(0, 1, 1.0));
    step(&mut world, TICK);
    let apart = at(&world, 0) - at(&world, 1);
    vec![
        Row::absolute("distance along x of two that coincided, rest 1 m", "m", 1.0, apart.x, 0.0),
        Row::absolute("distance along y and z", "m", 0.0, apart.y.abs() + apart.z.abs(), 0.0),
    ]
}

fn ropes_only_pull_and_struts_only_push() -> Vec<Row> {
    let length = |apart: f32, bound| {
        let mut world = placed(&[(Vec3::ZERO, 1.0), (Vec3::X * apart, 1.0)], 1);
        world.distances_mut().push(Distance::new(0, 1, 1.0).with_bound(bound));
        step(&mut world, TICK);
        (at(&world, 0) - at(&world, 1)).length()
    };
    let row = |what: &str, expected, measured| Row::absolute(what, "m", expected, measured, 2e-7);
    vec![
        row("rope of 1 m between particles 0.5 m apart", 0.5, length(0.5, Bound::AtMost)),
        row("rope of 1 m between particles 1.5 m apart", 1.0, length(1.5, Bound::AtMost)),
        row("strut of 1 m between particles 0.5 m apart", 1.0, length(0.5, Bound::AtLeast)),
        row("strut of 1 m between particles 1.5 m apart", 1.5, length(1.5, Bound::AtLeast)),
    ]
}

fn a_pinned_particle_is_where_its_moving_target_is() -> Vec<Row> {
    let mut world = Simulation::default();
    world.particles.push(ParticleSeed::at(Vec3::ZERO).pinned()).expect("a sound particle");
    let mut off = 0.0;
    for tick in 1..=60 {
        let target = Vec3::X * (tick as f32 * 0.02);
        world.boundaries.pins = vec![Pin { particle: 0, target }];
        step(&mut world, TICK);
        off = largest([off, (at(&world, 0) - target.as_dvec3()).length()]);
    }
    vec![Row::absolute(
        "largest distance from a target that moves at 1.2 m/s, at the end of a tick",
        "m",
        0.0,
        off,
        0.0,
    )]
}

fn boundaries_project_to_the_nearest_point() -> Vec<Row> {
    let normal = Vec3::new(1.0, 2.0, 2.0) / 3.0;
    // The particles leave the bounds within the step. One that starts outside would come back at a limited speed.
    let foot = Vec3::new(2.0, -1.0, 0.0);
    let mut world = placed(&[(foot + normal * 0.1, 1.0), (normal * 0.2, 1.0)], 1);
    world.particles.set_velocity(0, normal * (-0.4 / TICK));
    let plane = Plane::new(Vec3::ZERO, normal).expect("a plane with a direction");
    world.boundaries.planes.push(plane.with_friction(0.0));
    step(&mut world, TICK);
    let landed = (at(&world, 0) - DVec3::new(2.0, -1.0, 0.0)).length();
    let kept = (at(&world, 1) - normal.as_dvec3() * f64::from(0.2_f32)).length();
    let (from, beyond) = (Vec3::new(0.9, 0.5, -0.9), Vec3::new(3.0, 0.5, -7.0));
    let mut boxed = placed(&[(from, 1.0)], 1);
    boxed.particles.set_velocity(0, (beyond - from) / TICK);
    let inside = InsideBox { friction: 0.0, ..InsideBox::new(Vec3::splat(-1.0), Vec3::ONE) };
    boxed.boundaries.boxes.push(inside);
    step(&mut boxed, TICK);
    let clamped = (at(&boxed, 0) - DVec3::new(1.0, 0.5, -1.0)).length();
    vec![
        Row::absolute(
            "0.3 m under a slanted plane: from the point above it",
            "m",
            0.0,
            landed,
            5e-7,
        ),
        Row::absolute("0.2 m over it: moved by", "m", 0.0, kept, 1e-7),
        Row::absolute("outside a box: from the clamped point", "m", 0.0, clamped, 2e-7),
    ]
}

/// Angle, degrees, of a joint of two bones of 1 m after one step with the constraint; it starts at `degrees` (180 is straight).
fn bent(degrees: f64, kind: &ConstraintKind) -> f64 {
    let angle = degrees * PI / 180.0;
    let bone = DVec3::new(libm::cos(angle), libm::sin(angle), 0.0).as_vec3();
    let mut world = placed(&[(Vec3::X, 1.0), (Vec3::ZERO, 2.0), (bone, 0.5), (Vec3::Z, 1.0)], 100);
    let rows: &[u32] =
        if matches!(kind, ConstraintKind::Angle(_)) { &[0, 1, 2] } else { &[0, 1, 3, 2] };
    world.constraints_mut().push(Constraint::new(rows.iter().copied(), kind.clone()));
    step(&mut world, TICK);
    let p = places(&world);
    let axis = if rows.len() == 3 { DVec3::Z } else { (p[3] - p[1]).normalize() };
    let flat = |v: DVec3| v - axis * axis.dot(v);
    let (u, v) = (flat(p[0] - p[1]), flat(p[2] - p[1]));
    let found = libm::atan2(axis.dot(u.cross(v)), u.dot(v)) * 180.0 / PI;
    if found < 0.0 { found + 360.0 } else { found }
}

/// A limit is an inequality: the Newton step that moves the joint to it may go a little beyond, to the allowed side. An equality (equal limits) is satisfied.
/// Both to a few roundings of a coordinate: 1e-6 rad, 6e-5°.
fn a_joint_stays_within_its_limits() -> Vec<Row> {
    let rad = |degrees: f64| (degrees * PI / 180.0) as f32;
    let angle = |min, max| ConstraintKind::Angle(Angle::between(rad(min), rad(max)));
    let elbow = ConstraintKind::Hinge(Hinge::between(rad(30.0), rad(180.0)));
    let kept = ConstraintKind::Hinge(Hinge::between(rad(120.0), rad(120.0)));
    let met = |what: &str, expected, measured| Row::absolute(what, "°", expected, measured, 1e-4);
    let least = |what: &str, limit, measured| Row::at_least(what, "°", limit - 1e-4, measured);
    let most = |what: &str, limit, measured| Row::at_most(what, "°", limit + 1e-4, measured);
    vec![
        least("angle of 20°, allowed 60° to 150°", 60.0, bent(20.0, &angle(60.0, 150.0))),
        met("angle of 100°", 100.0, bent(100.0, &angle(60.0, 150.0))),
        most("angle of 175°", 150.0, bent(175.0, &angle(60.0, 150.0))),
        met("angle of 20° fixed at 60°", 60.0, bent(20.0, &angle(60.0, 60.0))),
        least("elbow of 10°, allowed 30° to 180°", 30.0, bent(10.0, &elbow)),
        met("elbow of 120°", 120.0, bent(120.0, &elbow)),
        most("elbow bent backward by 20°", 180.0, bent(200.0, &elbow)),
        met("hinge of 200° fixed at 120°", 120.0, bent(200.0, &kept)),
        met("bone at 20° in a cone of 35°", 20.0, coned(20.0)),
        most("bone at 80° in a cone of 35°", 35.0, coned(80.0)),
    ]
}

/// Angle, degrees, between a bone and the axis of a cone of 35° after one step with the constraint; it starts at `degrees`.
fn coned(degrees: f64) -> f64 {
    let (axis, widest) = (Vec3::X, (35.0 * PI / 180.0) as f32);
    let cone = Cone::about(Vec3::ZERO, Vec3::Y, Vec3::Z, axis, widest).expect("a frame");
    let angle = degrees * PI / 180.0;
    let bone = DVec3::new(libm::cos(angle), libm::sin(angle), 0.0).as_vec3();
    let points = [(Vec3::ZERO, 1.0), (Vec3::Y, 1.0), (Vec3::Z, 1.0), (bone, 0.5)];
    let mut world = placed(&points, 100);
    world.constraints_mut().push(Constraint::new(0..4, ConstraintKind::Cone(cone.clone())));
    step(&mut world, TICK);
    let p = places(&world);
    let seen = |i: usize| p[i].as_vec3();
    let axis = cone.axis_in(seen(0), seen(1), seen(2)).as_dvec3();
    let segment = p[3] - p[0];
    libm::atan2(axis.cross(segment).length(), axis.dot(segment)) * 180.0 / PI
}

/// `Σ m d` and `Σ m q × d` of one projection, relative to `Σ m‖d‖` and `Σ m‖q‖‖d‖`: a constraint between particles changes neither momentum nor angular
/// momentum.
fn limits_keep_momentum_and_angular_momentum() -> Vec<Row> {
    let rad = |degrees: f64| (degrees * PI / 180.0) as f32;
    let points = [
        (Vec3::new(1.0, 0.1, 0.0), 1.0),
        (Vec3::ZERO, 2.0),
        (Vec3::new(0.2, 0.9, 0.3), 0.5),
        (Vec3::new(0.1, -0.2, 1.0), 3.0),
    ];
    let cone = Cone::about(Vec3::X, Vec3::ZERO, Vec3::Y, Vec3::Z, rad(20.0)).expect("a frame");
    let mut rows = Vec::new();
    for (name, count, kind) in [
        ("an angle", 3, ConstraintKind::Angle(Angle::between(rad(120.0), rad(150.0)))),
        ("a hinge", 4, ConstraintKind::Hinge(Hinge::between(rad(170.0), rad(180.0)))),
        ("a cone", 4, ConstraintKind::Cone(cone)),
    ] {
        let mut world = placed(&points, 1);
        world.constraints_mut().push(Constraint::new(0..count, kind));
        rows.extend(conserved(name, world));
    }
    rows
}

/// One step of a simulation at rest with one constraint: rows that momentum and angular momentum stay zero. They are NaN, and so fail, if nothing moved.
pub(crate) fn conserved(name: &str, mut world: Simulation) -> Vec<Row> {
    let before = places(&world);
    let masses: Vec<f64> = (0..before.len()).map(|i| f64::from(world.particles.mass(i))).collect();
    step(&mut world, TICK);
    let after = places(&world);
    let (mut p, mut l, mut p_size, mut l_size) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for i in 0..before.len() {
        let d = (after[i] - before[i]) * masses[i];
        p += d;
        l += before[i].cross(d);
        p_size += d.length();
        l_size += before[i].length() * d.length();
    }
    // Displacements of some decimetres at coordinates of 1 m: a few roundings are 1e-6 of them.
    vec![
        Row::absolute(format!("Σ m d of {name}, of Σ m‖d‖"), "", 0.0, p.length() / p_size, 2e-6),
        Row::absolute(
            format!("Σ m q×d of {name}, of Σ m‖q‖‖d‖"),
            "",
            0.0,
            l.length() / l_size,
            2e-6,
        ),
    ]
}

fn a_particle_at_rest_on_a_plane_does_not_creep() -> Vec<Row> {
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(0.0));
    world.particles.push(ParticleSeed::at(Vec3::Y * 0.5)).expect("a sound particle");
    steps(&mut world, TICK, 120);
    let landed = at(&world, 0);
    steps(&mut world, TICK, 3600);
    vec![
        Row::absolute("height of a particle on the ground", "m", 0.0, landed.y, 1e-6),
        Row::absolute("creep in a minute", "m", 0.0, (at(&world, 0) - landed).length(), 0.0),
    ]
}

/// A rod of 1 m to the origin, as a game might define it.
#[derive(Debug)]
struct Leash;

impl Equation for Leash {
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
        let arm = points.relative_to(0, Vec3::ZERO);
        gradients[0] = arm.normalize_or_zero();
        arm.length() - 1.0
    }

    fn is_length(&self) -> bool {
        true
    }
}

/// The same sums in another order over 1200 substeps: roundings of 6e-8 m that accumulate with time.
fn a_custom_constraint_gives_the_results_of_a_built_in_one() -> Vec<Row> {
    let swing = |own: bool| {
        let mut world = Simulation::default();
        // The custom one holds on to the world, so nothing restores its angular momentum.
        world.settings.keep_spin = false;
        world.particles.push(ParticleSeed::at(Vec3::ZERO).pinned()).expect("a sound particle");
        world.particles.push(ParticleSeed::at(Vec3::X)).expect("a sound particle");
        if own {
            world.constraints_mut().push(Constraint::new([1], ConstraintKind::custom(Leash)));
        } else {
            world.distances_mut().push(Distance::new(0, 1, 1.0));
        }
        steps(&mut world, TICK, 120);
        at(&world, 1)
    };
    let apart = (swing(true) - swing(false)).length();
    vec![Row::absolute(
        "distance between a pendulum on a custom constraint and one on a built-in distance, after 2 s",
        "m",
        0.0,
        apart,
        1200.0 * 6e-8,
    )]
}
