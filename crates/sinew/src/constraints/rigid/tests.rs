//! Tests of a single projection of a rigid shape.

use super::super::checks::{self, Particles, Random, points_of};
use super::super::{Points, project_equation};
use super::*;
use crate::constraints::SubstepContext;

/// An asymmetric shape of six particles, rotated, moved and slightly deformed, and their masses.
fn bent() -> (Rigid, Vec<Vec3>, Vec<f32>) {
    let mut random = Random::new(21);
    let rest = random.positions(6);
    let (turn, masses) = (DQuat::from_xyzw(0.5, -0.1, 0.7, 0.3).normalize(), random.masses(6));
    let now = rest.iter().map(|r| {
        (DMat3::from_quat(turn) * r.as_dvec3()).as_vec3() + random.vector() * 0.05 + Vec3::X
    });
    (Rigid::of(rest.as_slice()), now.collect(), masses)
}

/// The largest error of any pair distance, metres.
fn strain(rest: &[Vec3], now: &[Vec3]) -> f32 {
    let pairs = (0..rest.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let errors = pairs.map(|(i, j)| (rest[i].distance(rest[j]) - now[i].distance(now[j])).abs());
    errors.fold(0.0, f32::max)
}

/// One projection with the gradient at the start of the step.
fn project_from_start(equation: &Rigid, particles: &mut Particles) {
    let mut moves = vec![Vec3::ZERO; particles.now.len()];
    let points = Points { gradient_at: GradientAt::StepStart, ..particles.points() };
    let mut gradients = moves.clone();
    let substep_context = SubstepContext { h: 0.01, sweeps: 1 };
    project_equation(equation, &points, &mut gradients, substep_context, &mut 0.0, |i, d| {
        moves[i] = d;
    });
    for (q, d) in particles.now.iter_mut().zip(moves) {
        *q += d.extend(0.0);
    }
}

#[test]
fn one_projection_meets_all_distances_and_keeps_both_momenta() {
    let (equation, places, masses) = bent();
    checks::assert_gradients(&equation, &places);
    checks::assert_momentum_kept(&equation, &places, &masses);
    let mut particles = points_of(&places, &masses);
    assert!(strain(&equation.rest, &places) > 0.03);
    particles.project(&equation);
    let left = strain(&equation.rest, &particles.positions());
    assert!(left < 1e-6, "{left}");
    assert!(particles.error(&equation) < 1e-6);
}

#[test]
fn every_other_place_of_the_shape_costs_more() {
    let (equation, places, masses) = bent();
    let mut particles = points_of(&places, &masses);
    particles.project(&equation);
    let least = particles.cost(&places);
    let found = particles.positions();
    let mut random = Random::new(9);
    for size in [1e-3, 1e-2, 0.3] {
        for _ in 0..200 {
            let turn = (random.vector() * size).as_dvec3();
            let turn = DQuat::from_xyzw(turn.x, turn.y, turn.z, 1.0).normalize();
            let shift = random.vector() * size;
            let other = found.iter().map(|p| {
                (DMat3::from_quat(turn) * (*p - found[0]).as_dvec3()).as_vec3() + found[0] + shift
            });
            let cost: f64 = other
                .zip(&places)
                .zip(&masses)
                .map(|((x, p), m)| f64::from(*m) * (x - p).as_dvec3().length_squared())
                .sum();
            assert!(cost > least, "{size} {cost} {least}");
        }
    }
}

#[test]
fn along_the_start_of_the_step_the_angular_momentum_of_the_step_is_kept() {
    let (equation, starts, masses) = bent();
    let mut shape = points_of(&starts, &masses);
    shape.project(&equation);
    let starts = shape.positions();
    let mut random = Random::new(2);
    for sine in [1e-3, 0.1, 0.35, 0.8] {
        let spin = random.vector().normalize() * sine;
        let mut particles = points_of(&starts, &masses);
        for (q, p) in particles.now.iter_mut().zip(&starts) {
            *q += (spin.cross(*p) + random.vector() * (0.1 * sine)).extend(0.0);
        }
        let momentum = |particles: &Particles| -> DVec3 {
            let of = |(q, p): (&glam::Vec4, &Vec3)| {
                (*p - starts[0]).as_dvec3().cross((q.truncate() - *p).as_dvec3()) / f64::from(q.w)
            };
            particles.now.iter().zip(&starts).map(of).sum()
        };
        let before = momentum(&particles);
        let lost = |p: &Particles| (momentum(p) - before).length() / before.length();
        let mut nearest = particles.clone();
        project_from_start(&equation, &mut particles);
        nearest.project(&equation);
        assert!(lost(&particles) < 1e-6 / f64::from(sine), "{sine}: {}", lost(&particles));
        assert!(strain(&equation.rest, &particles.positions()) < 1e-6);
        assert!(
            sine < 0.1 || lost(&nearest) > 1e-3,
            "the nearest way does not: {}",
            lost(&nearest)
        );
    }
}

#[test]
fn what_turned_too_far_or_came_out_mirrored_goes_to_the_nearest_place() {
    let (equation, _, masses) = bent();
    let turned: Vec<_> = equation.rest.iter().map(|r| Vec3::new(-r.x, -r.y, r.z)).collect();
    let mirrored: Vec<_> = equation.rest.iter().map(|r| Vec3::new(r.x, r.y, -r.z)).collect();
    for places in [turned, mirrored] {
        let mut particles = points_of(&equation.rest, &masses);
        for (q, p) in particles.now.iter_mut().zip(&places) {
            *q = p.extend(q.w);
        }
        let mut nearest = particles.clone();
        project_from_start(&equation, &mut particles);
        nearest.project(&equation);
        assert_eq!(particles.now, nearest.now);
        let now = particles.positions();
        assert!(strain(&equation.rest, &now) < 2e-6);
        let volume = |p: &[Vec3]| (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]);
        assert!(volume(&equation.rest) * volume(&now) > 0.0, "never a reflection");
    }
}

#[test]
fn flat_lined_up_small_and_single_shapes_are_met_too() {
    let (_, places, masses) = bent();
    let line = |x: f32| Vec3::new(1.0, 2.0, -0.5) * x;
    let shapes: [Vec<Vec3>; 6] = [
        places.iter().map(|p| Vec3::new(p.x, p.y, 0.0)).collect(),
        places.iter().map(|p| line(p.x)).collect(),
        vec![Vec3::ZERO, Vec3::X],
        vec![Vec3::ONE],
        vec![Vec3::ONE; 4],
        places.iter().map(|p| *p * 1e-3).collect(),
    ];
    for rest in shapes {
        let equation = Rigid::of(rest.clone());
        assert_eq!(equation.fault(rest.len()), None);
        checks::assert_survives(&equation, &places[..rest.len()]);
        for from_start in [false, true] {
            let mut particles = points_of(&places[..rest.len()], &masses);
            for _ in 0..2 {
                if from_start {
                    project_from_start(&equation, &mut particles);
                } else {
                    particles.project(&equation);
                }
            }
            let left = strain(&rest, &particles.positions());
            assert!(left < 2e-6, "{rest:?}: {left}");
        }
    }
}

#[test]
fn degenerate_sets_stay_finite_along_the_start_as_well() {
    let (equation, places, _) = bent();
    checks::assert_survives(&equation, &places);
    for masses in [vec![1.0; 6], vec![1.0, 1e6, 1e-6, f32::INFINITY, 1.0, 1.0]] {
        for scale in [0.0, 1e-30, 1e-9, 1e9, 1e18] {
            for start_scale in [0.0, 1e-30, 1.0, 1e18] {
                let starts: Vec<_> = places.iter().map(|p| *p * start_scale).collect();
                let mut particles = points_of(&starts, &masses);
                for (q, p) in particles.now.iter_mut().zip(&places) {
                    *q = (*p * scale).extend(q.w);
                }
                project_from_start(&equation, &mut particles);
                assert!(particles.now.iter().all(|q| q.is_finite()), "{scale} {start_scale}");
            }
        }
    }
}

#[test]
fn pinned_particles_stay_and_the_others_find_their_places_around_them() {
    let (equation, places, _) = bent();
    for from_start in [false, true] {
        // A single pinned particle is a ball joint and is met at once. Two, at a distance that does not quite fit the shape, are met by a compromise.
        for (pinned, allowed) in [(vec![2], 2e-6), (vec![1, 4], 0.06)] {
            let mut masses = vec![1.0; 6];
            for &i in &pinned {
                masses[i] = f32::INFINITY;
            }
            let mut particles = points_of(&places, &masses);
            for _ in 0..3 {
                if from_start {
                    project_from_start(&equation, &mut particles);
                } else {
                    particles.project(&equation);
                }
            }
            let now = particles.positions();
            assert!(pinned.iter().all(|&i| now[i] == places[i]));
            assert!(
                strain(&equation.rest, &now) < allowed,
                "{pinned:?}: {}",
                strain(&equation.rest, &now)
            );
            assert!(particles.error(&equation) < 1e-4, "no argument is left with the free ones");
        }
    }
}

#[test]
fn faults_are_told_apart() {
    let equation = Rigid::of([Vec3::ZERO, Vec3::X]);
    assert_eq!((equation.fault(2), equation.fault(3)), (None, Some(ConstraintFault::Count)));
    assert_eq!(Rigid::of([]).fault(0), Some(ConstraintFault::Count));
    assert_eq!(Rigid::of([Vec3::ZERO, Vec3::NAN]).fault(2), Some(ConstraintFault::Number));
}
