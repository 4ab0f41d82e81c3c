//! Tests of the energy, the momentum and the robustness of isometric bending.

use super::super::checks::{self, points_of};
use super::super::equation_energy;
use super::*;
use crate::constraints::{Constraint, ConstraintKind};
use crate::{ParticleSeed, Simulation};

/// Two uneven triangles, flat.
const FLAT: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.8, 0.0), Vec3::new(0.6, -0.5, 0.0)];
/// The same, folded.
const FOLDED: [Vec3; 4] =
    [Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.7, 0.4), Vec3::new(0.6, -0.4, 0.3)];
const MASSES: [f32; 4] = [1.0, 0.5, 2.0, 4.0];

/// The signed fold angle at the edge, rad.
fn fold(p: &[Vec3]) -> f32 {
    let edge = p[1] - p[0];
    let (na, nb) = (edge.cross(p[2] - p[0]), (p[3] - p[0]).cross(edge));
    libm::atan2f(na.cross(nb).dot(edge.normalize()), na.dot(nb))
}

#[test]
fn the_flat_shape_is_at_rest_and_the_gap_is_where_the_diagonals_cross() {
    let bend = Bend::of(FLAT).unwrap();
    assert_eq!(bend.rest, 0.0);
    assert!(checks::evaluate(&bend, &FLAT).0.abs() < 1e-7);
    let [e0, e1, a, b] = bend.weights;
    assert!((e0 + e1 - 1.0).abs() < 1e-6 && (a + b + 1.0).abs() < 1e-6);
    // The line from a to b crosses y = 0 at 0.3 + 0.3·0.8/1.3.
    assert!((FLAT[1] * e1).x - (0.3 + 0.3 * 0.8 / 1.3) < 1e-6);
    assert!((FOLDED[2].y - FOLDED[3].y) > 1.0 && checks::evaluate(&bend, &FOLDED).0 > 0.2);
}

#[test]
fn the_gradient_is_that_of_the_value_and_both_momenta_are_kept() {
    let bend = Bend::of(FLAT).unwrap();
    checks::assert_gradients(&bend, &FOLDED);
    checks::assert_momentum_kept(&bend, &FOLDED, &MASSES);
    checks::assert_least(&bend, &FOLDED, &MASSES);
    checks::assert_kept(&bend, &FOLDED, &MASSES, 1e-6);
}

#[test]
fn one_projection_unfolds_it_and_a_folded_rest_comes_back() {
    let mut particles = points_of(&FOLDED, &MASSES);
    let before = fold(&particles.positions());
    particles.project(&Bend::of(FLAT).unwrap());
    let after = fold(&particles.positions());
    assert!(before.abs() > 0.5 && after.abs() < 1e-5, "{before} {after}");

    let folded = Bend::of(FOLDED).unwrap();
    assert!(folded.rest > 0.2);
    let flatter = FOLDED.map(|p| p * Vec3::new(1.0, 1.0, 0.5));
    let mut particles = points_of(&flatter, &MASSES);
    particles.project(&folded);
    assert!(checks::evaluate(&folded, &particles.positions()).0.abs() < 1e-6);
    // The same triangles, laid flat.
    let (a, b) = (Vec3::new(0.3, 0.65_f32.sqrt(), 0.0), Vec3::new(0.6, -0.5, 0.0));
    let mut flat = points_of(&[Vec3::ZERO, Vec3::X, a, b], &MASSES);
    for _ in 0..8 {
        flat.project(&folded);
    }
    let value = checks::evaluate(&folded, &flat.positions()).0;
    assert!(
        value.abs() < 1e-6 && fold(&flat.positions()).abs() > 0.3,
        "flat, it is folded: {value}"
    );
}

#[test]
fn degenerate_sets_stay_finite() {
    checks::assert_survives(&Bend::of(FLAT).unwrap(), &FOLDED);
    checks::assert_survives(&Bend::of(FOLDED).unwrap(), &FLAT);
    checks::assert_survives(&Bend::stiff(FLAT, 1e-3).unwrap(), &FOLDED);
}

#[test]
fn triangles_without_area_and_stiffness_that_is_none_are_refused() {
    let [e0, e1, a, b] = FLAT;
    for bad in [
        [e0, e0, a, b],
        [e0, e1, Vec3::X * 3.0, b],
        [e0, e1, a, e1],
        [e0, e1, a, Vec3::NAN],
        [e0, e1, Vec3::INFINITY, b],
        [Vec3::ZERO; 4],
    ] {
        assert_eq!(Bend::of(bad), None, "{bad:?}");
    }
    for stiffness in [0.0, -1.0, f32::NAN, 1e-44] {
        assert_eq!(Bend::stiff(FLAT, stiffness), None, "{stiffness}");
    }
    assert_eq!(Bend::stiff(FLAT, f32::INFINITY).unwrap().softness, Softness::Hard);
    assert!(Bend::of(FLAT.map(|p| p * 1e-6)).is_some(), "small is not thin");
}

#[test]
fn faults_are_told_apart() {
    let good = Bend::of(FOLDED).unwrap();
    assert_eq!((good.fault(4), good.fault(3)), (None, Some(ConstraintFault::Count)));
    let numbers = [
        Bend { rest: -1.0, ..good.clone() },
        Bend { rest: f32::NAN, ..good.clone() },
        Bend { weights: [1.0, 0.0, -1.0, 0.5], ..good.clone() },
        Bend { weights: [f32::INFINITY, 0.0, 0.0, 0.0], ..good },
    ];
    assert!(numbers.iter().all(|bad| bad.fault(4) == Some(ConstraintFault::Number)));
}

/// Bending energy per area of a regular mesh that is rolled to a cylinder about an axis in its plane, relative to `½ B κ²`. The mesh repeats the triangle with
/// the edges `u` and `v`, so one edge in each of its three directions accounts for twice the area of a triangle.
fn rolled(u: Vec3, v: Vec3, towards: f32, curvature: f32) -> f32 {
    const STIFFNESS: f32 = 2e-3;
    let (sin, cos) = libm::sincosf(towards);
    let roll = |p: Vec3| {
        let (along, across) = (p.x * cos + p.y * sin, p.y * cos - p.x * sin);
        let (s, c) = libm::sincosf(curvature * along);
        Vec3::new(s / curvature, across, (1.0 - c) / curvature)
    };
    let energy = |[edge, a]: [Vec3; 2]| {
        // About the middle of the edge, so that the three edges are treated alike.
        let flat = [-edge * 0.5, edge * 0.5, a - edge * 0.5, edge * 0.5 - a];
        let bend = Bend::stiff(flat, STIFFNESS).unwrap();
        let bent = points_of(&flat.map(roll), &[]);
        equation_energy(&bend, &bent.points(), &mut [Vec3::ZERO; 4])
    };
    let sum: f32 = [[u, v], [v, u], [u - v, u]].map(energy).iter().sum();
    sum / (0.5 * STIFFNESS * curvature * curvature * u.cross(v).length())
}

#[test]
fn a_stiffness_means_the_same_bending_energy_whatever_the_size_of_the_triangles() {
    let (u, v) = (Vec3::X, Vec3::new(0.5, 0.75_f32.sqrt(), 0.0));
    for size in [0.01, 0.1, 1.0] {
        for degrees in [0.0_f32, 17.0, 30.0, 45.0, 75.0, 90.0] {
            let even = rolled(u * size, v * size, degrees.to_radians(), 0.1 / size);
            assert!((even - 1.0).abs() < 0.01, "equilateral, {size} m, {degrees}°: {even}");
        }
        for degrees in [0.0_f32, 90.0] {
            let right = rolled(Vec3::X * size, Vec3::Y * size, degrees.to_radians(), 0.1 / size);
            assert!((right - 1.0).abs() < 0.01, "right-angled, {size} m, {degrees}°: {right}");
        }
    }
    // Anisotropy of right-angled triangles: cylinders along the two diagonals.
    let grain = [45.0_f32, 135.0].map(|d| rolled(Vec3::X, Vec3::Y, d.to_radians(), 0.1));
    println!("along the diagonals of a right-angled mesh: {grain:?}");
    assert!(grain.iter().all(|x| (0.3..3.1).contains(x)), "{grain:?}");
}

#[test]
fn two_triangles_swing_at_the_frequency_of_their_stiffness_at_any_number_of_sweeps() {
    // Rigid wings about a hinge: the gap is Σ wᵢxᵢ, a coordinate with the mass 1/Σw wᵢ², on a spring of stiffness 1/α.
    let half = 0.5_f32;
    let flat = [Vec3::ZERO, Vec3::X, Vec3::new(0.5, half, 0.0), Vec3::new(0.5, -half, 0.0)];
    for sweeps in [1, 8] {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::ZERO;
        world.settings.max_sweeps = sweeps;
        world.settings.substeps = 20;
        for (i, p) in flat.iter().enumerate() {
            let lift = if i < 2 { -0.005 } else { 0.005 };
            world.particles.push(ParticleSeed::at(*p + Vec3::Z * lift)).unwrap();
        }
        let bend = Bend::stiff(flat, 1.0).unwrap();
        // w = ½, ½, -½, -½ and 1 kg each: μ = 1 kg. k = ‖e‖·2/h = 4, A = ½: 1/α = B k²/A = 32 N/m.
        assert!((checks::evaluate(&bend, &flat).0).abs() < 1e-6);
        world.constraints_mut().push(Constraint::new(0..4, ConstraintKind::Bend(bend)));
        let period = core::f32::consts::TAU / 32.0_f32.sqrt();
        let mut lowest = (0.0, 0.0_f32);
        // After half a period the gap is at the opposite extreme.
        for step in 1..=70 {
            world.step(0.01).unwrap();
            let gap = world.particles.position(2).z - world.particles.position(0).z;
            if gap < lowest.1 {
                lowest = (step as f32 * 0.01, gap);
            }
        }
        println!("{sweeps} sweeps: {lowest:?}, half a period is {}", 0.5 * period);
        assert!((lowest.0 - 0.5 * period).abs() < 0.011, "{lowest:?}");
        assert!(lowest.1 < -0.009, "implicit Euler takes some: {lowest:?}");
    }
}
