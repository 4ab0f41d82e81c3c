//! The tree compared with all pairs, and properties that hold for both.

use glam::{DVec3, Vec3, Vec4};

use super::*;
use crate::particles::ParticleSeed;
use crate::simulation::Simulation;
use crate::test_random::Random;

const ALL_PAIRS: u32 = u32::MAX;

/// Charges of about a microcoulomb in a box; `sign` is the share of positive ones.
fn cloud(count: usize, sign: f32, at: Vec3) -> Particles {
    let mut numbers = Random::new(1);
    let mut random = || numbers.fraction();
    let mut particles = Particles::default();
    for _ in 0..count {
        let place = Vec3::new(random(), random(), random()) * Vec3::new(4.0, 2.0, 3.0);
        let magnitude = 1e-6 * (0.5 + random());
        let charge = if random() < sign { magnitude } else { -magnitude };
        // On a grid of 2⁻¹⁰ m, which is exact in f32 5 km from the origin as well.
        let place = (place * 1024.0).round() / 1024.0;
        particles.push(ParticleSeed::at(at + place).with_charge(charge)).unwrap();
    }
    particles
}

fn forces_with(particles: &mut Particles, electric: Electric) -> Vec<DVec3> {
    let forces = Forces { electric, ..Forces::default() };
    particles.clear_sums(0.0);
    apply(particles, &forces, &mut ElectricScratch::default(), InstructionSet::best());
    (0..particles.len()).map(|i| particles.acceleration(i).as_dvec3()).collect()
}

fn forces(particles: &mut Particles, all_pairs_up_to: u32) -> Vec<DVec3> {
    forces_with(particles, Electric { all_pairs_up_to, ..Electric::default() })
}

/// The root mean square of each force's relative error, and the total error relative to the total of the forces.
fn errors(found: &[DVec3], exact: &[DVec3]) -> (f64, f64) {
    let pairs = || found.iter().zip(exact);
    let each: f64 =
        pairs().map(|(f, e)| (*f - *e).length_squared() / e.length_squared()).sum::<f64>();
    let all = pairs().map(|(f, e)| (*f - *e).length_squared()).sum::<f64>()
        / exact.iter().map(|e| e.length_squared()).sum::<f64>();
    ((each / exact.len() as f64).sqrt(), all.sqrt())
}

fn imbalance(forces: &[DVec3]) -> f64 {
    forces.iter().sum::<DVec3>().length() / forces.iter().map(|f| f.length()).sum::<f64>()
}

#[test]
fn the_tree_agrees_with_all_pairs_within_one_per_cent() {
    for sign in [0.5, 1.0] {
        let mut particles = cloud(5000, sign, Vec3::ZERO);
        let exact = forces(&mut particles, ALL_PAIRS);
        let found = forces(&mut particles, 0);
        let (each, all) = errors(&found, &exact);
        println!(
            "{sign}: each {each:.2e}, all {all:.2e}; sum of forces: pairs {:.1e}, tree {:.1e}",
            imbalance(&exact),
            imbalance(&found)
        );
        // `each` is dominated by charges on which large forces nearly cancel.
        assert!(each < 0.03 && all < 0.01, "{sign}: {each} {all}");
        assert!(imbalance(&exact) < 1e-7 && imbalance(&found) < 2e-3);
    }
}

#[test]
fn all_pairs_are_coulombs_law_whatever_the_number_that_stand_side_by_side() {
    for count in [1, 2, 7, 8, 9, 100, 128, 129, 300] {
        let mut particles = cloud(count, 0.5, Vec3::ZERO);
        let found = forces(&mut particles, ALL_PAIRS);
        for (a, found) in found.iter().enumerate() {
            let mut sum = DVec3::ZERO;
            for b in (0..count).filter(|&b| b != a) {
                let d = particles.separation(a, b).as_dvec3();
                let charges = f64::from(particles.charge[a]) * f64::from(particles.charge[b]);
                sum += d * (8.987_552e9 * charges / (d.length_squared() * d.length()));
            }
            assert!((*found - sum).length() <= 1e-4 * sum.length(), "{count}: {a}");
        }
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let crowd = |count: usize| {
        let mut particles = cloud(count, 0.5, Vec3::ZERO);
        // Some coincident, some nearly so, some far away, one not finite.
        for i in 0..count {
            let place = match i % 10 {
                0 => Vec3::new(0.25, 0.5, 0.75),
                1 => Vec3::new(0.25, 0.5, 0.75 + 1e-7 * i as f32),
                2 => Vec3::new(1e4 * i as f32, -3.0, 0.1),
                _ => continue,
            };
            particles.set_position(i, place);
        }
        particles.position[count / 2] = Vec3::NAN.extend(1.0);
        particles
    };
    for (mut particles, softening) in [
        (cloud(1003, 0.5, Vec3::ZERO), 0.0),
        (cloud(300, 1.0, Vec3::ONE * 4e3), 0.01),
        (crowd(517), 0.0),
    ] {
        for all_pairs_up_to in [ALL_PAIRS, 0] {
            let electric = Electric { all_pairs_up_to, softening, ..Electric::default() };
            let forces = Forces { electric, ..Forces::default() };
            let mut with = |instructions| {
                particles.clear_sums(0.0);
                apply(&mut particles, &forces, &mut ElectricScratch::default(), instructions);
                particles.acceleration.clone()
            };
            let truth = with(InstructionSet::Scalar);
            assert!(truth.iter().all(|a| a.is_finite()) && truth.iter().any(|a| *a != Vec4::ZERO));
            assert!(truth == with(InstructionSet::Simd128), "{all_pairs_up_to}");
            assert!(truth == with(InstructionSet::Avx2), "{all_pairs_up_to}");
        }
    }
}

#[test]
fn the_tree_gives_the_energy_of_all_pairs() {
    for (sign, softening) in [(0.5, 0.0), (1.0, 0.0), (0.5, 0.1)] {
        let particles = cloud(3000, sign, Vec3::ZERO);
        let with = |all_pairs_up_to| {
            let electric = Electric { all_pairs_up_to, softening, ..Electric::default() };
            energy(&particles, &Forces { electric, ..Forces::default() })
        };
        let (found, exact) = (with(0), with(ALL_PAIRS));
        println!("{sign} {softening}: {found} {exact}");
        // Charges of opposite sign bind each other by about Σ q² K/spacing; the sum over all pairs is a small difference of such terms.
        let spacing = libm::cbrt(24.0_f64 / 3000.0);
        let scale = 3000.0 * 8.987_552e9 * 1e-12 / spacing;
        assert!((found - exact).abs() < 2e-3 * scale.max(exact.abs()), "{sign}: {found} {exact}");
    }
}

#[test]
fn five_kilometres_away_the_forces_are_the_same_bits() {
    let (mut here, mut there) =
        (cloud(3000, 0.5, Vec3::ZERO), cloud(3000, 0.5, Vec3::new(5000.0, 0.0, -3000.0)));
    for limit in [ALL_PAIRS, 0] {
        let (near, far) = (forces(&mut here, limit), forces(&mut there, limit));
        assert_eq!(near, far, "{limit}");
    }
}

#[test]
fn charges_at_one_point_feel_nothing_from_each_other_and_act_on_others_as_one() {
    for limit in [ALL_PAIRS, 0] {
        for softening in [0.0, 0.1] {
            let mut crowd = Particles::default();
            for _ in 0..1000 {
                let seed = ParticleSeed::at(Vec3::new(0.1, 0.2, 0.3)).with_charge(1e-6);
                crowd.push(seed).unwrap();
            }
            let law = Electric { all_pairs_up_to: limit, softening, ..Electric::default() };
            assert!(forces_with(&mut crowd, law).iter().all(|f| *f == DVec3::ZERO));
            let one = crowd.push(ParticleSeed::at(Vec3::new(1.1, 0.2, 0.3)).with_charge(1e-6));
            let found = forces_with(&mut crowd, law)[one.unwrap() as usize];
            let s2 = 1.0 + f64::from(softening * softening);
            let expected = 8.987_552 / (s2 * s2.sqrt());
            assert!((found - DVec3::X * expected).length() < 1e-4, "{limit} {softening}: {found}");
        }
    }
}

#[test]
fn pairs_that_nearly_touch_are_finite_and_push_apart() {
    for limit in [ALL_PAIRS, 0] {
        for distance in [0.0, 1e-30, 1e-9, 1e-7, 1e-5] {
            let mut pair = Particles::default();
            for x in [0.0, distance] {
                pair.push(ParticleSeed::at(Vec3::X * x).with_charge(1.0)).unwrap();
            }
            let found = forces(&mut pair, limit);
            assert!(found[0].is_finite() && found[0] == -found[1], "{distance}: {found:?}");
            assert!(found[1].x > 0.0 || distance < 1e-25);
        }
    }
}

#[test]
fn a_charge_that_is_nowhere_leaves_the_others_in_peace() {
    for limit in [ALL_PAIRS, 0] {
        let mut particles = cloud(100, 0.5, Vec3::ZERO);
        let good = forces(&mut particles, limit);
        let lost = particles.push(ParticleSeed::at(Vec3::ZERO).with_charge(1e-6)).unwrap() as usize;
        for place in [Vec3::NAN, Vec3::INFINITY, Vec3::X * 1e20] {
            particles.position[lost] = place.extend(1.0);
            assert_eq!(forces(&mut particles, limit)[..100], good);
        }
    }
}

#[test]
fn a_law_with_a_broken_number_does_nothing() {
    let mut particles = cloud(20, 0.5, Vec3::ZERO);
    let good = Electric::default();
    for law in [
        Electric { constant: f32::NAN, ..good },
        Electric { softening: -1.0, ..good },
        Electric { field: Vec3::INFINITY, ..good },
        Electric { opening: 0.0, ..good },
    ] {
        assert!(forces_with(&mut particles, law).iter().all(|f| *f == DVec3::ZERO));
    }
}

#[test]
fn a_charge_in_a_uniform_field_flies_a_parabola_and_keeps_its_energy() {
    for region in [Region::default(), Region::boxed(Vec3::ZERO, Vec3::splat(100.0))] {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::ZERO;
        world.forces.electric.field = Vec3::Y * 3e4;
        let field = Vec3::new(1e4, 2e4, 0.0);
        world.forces.electric_fields.push(ElectricField { field, region });
        world.forces.electric_fields.push(ElectricField { field: Vec3::NAN, region });
        let seed = ParticleSeed::at(Vec3::ZERO).with_velocity(Vec3::Z * 2.0).with_mass(0.5);
        world.particles.push(seed.with_charge(1e-4)).unwrap();
        let before = world.ledger().energy();
        for _ in 0..60 {
            world.step(1.0 / 60.0).unwrap();
        }
        // f/m = q E/m = 1e-4 C · (1, 5, 0)·10⁴ N/C / 0.5 kg.
        let exact = Vec3::new(2.0, 10.0, 0.0) * 0.5 + Vec3::Z * 2.0;
        let error = (world.particles.position(0) - exact).length();
        assert!(error < 1e-4, "{error}");
        let after = world.ledger();
        assert!(
            region != Region::default() || (after.energy() - before).abs() < 1e-4 * after.kinetic
        );
        assert!(after.kinetic > 10.0);
    }
}

#[test]
fn a_field_ends_where_its_region_does() {
    let region = Region::boxed(Vec3::ZERO, Vec3::splat(2.0));
    let forces = Forces {
        electric_fields: vec![ElectricField { field: Vec3::X, region }],
        ..Forces::default()
    };
    let mut particles = Particles::default();
    for x in [0.9, 1.1] {
        particles.push(ParticleSeed::at(Vec3::Y * x).with_charge(0.5)).unwrap();
    }
    apply_fields(&mut particles, &forces.electric, &forces.electric_fields);
    assert_eq!([0, 1].map(|i| particles.acceleration(i)), [Vec3::X * 0.5, Vec3::ZERO]);
}
