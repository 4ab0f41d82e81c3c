//! What pushing, moving and reversing several particles must leave behind (physics.md I6 to I8).

use glam::{DVec3, Quat, Vec3};

use super::{ParticleSeed, Particles};
use crate::forces::Spring;
use crate::simulation::Simulation;

/// A lopsided compound far from the origin, in motion; with it a pinned particle, and a loose one that is not among the rows.
fn compound(at: Vec3) -> (Particles, Vec<u32>) {
    let mut particles = Particles::default();
    let corners =
        [(0.0, 0.0, 0.0), (1.0, 0.2, 0.0), (0.1, 2.0, 0.3), (-0.5, 0.4, 1.5), (0.7, 0.7, 0.7)];
    for (i, (x, y, z)) in corners.into_iter().enumerate() {
        let seed = ParticleSeed::at(at + Vec3::new(x, y, z)).with_mass(0.5 + i as f32);
        particles.push(seed.with_velocity(Vec3::new(y, -x, z + x))).unwrap();
    }
    particles.push(ParticleSeed::at(at + Vec3::Z * 9.0).pinned()).unwrap();
    particles.push(ParticleSeed::at(at - Vec3::X)).unwrap();
    (particles, vec![0, 1, 2, 3, 4, 5, 77])
}

/// Momentum, and angular momentum about a point, of the first five.
fn momenta(particles: &Particles, about: Vec3) -> (DVec3, DVec3) {
    let (mut p, mut l) = (DVec3::ZERO, DVec3::ZERO);
    for i in 0..5 {
        let momentum = particles.velocity(i).as_dvec3() * f64::from(particles.mass(i));
        p += momentum;
        l += particles.relative_to(i, about).as_dvec3().cross(momentum);
    }
    (p, l)
}

fn barycentre(particles: &Particles, near: Vec3) -> DVec3 {
    let of = |i: usize| f64::from(particles.mass(i));
    let sum: DVec3 = (0..5).map(|i| particles.relative_to(i, near).as_dvec3() * of(i)).sum();
    near.as_dvec3() + sum / (0..5).map(of).sum::<f64>()
}

const PUSH: Vec3 = Vec3::new(3.0, -2.0, 0.7);

#[test]
fn an_impulse_on_many_changes_their_momentum_by_itself_and_leaves_their_spin() {
    for at in [Vec3::ZERO, Vec3::new(5000.0, 10.0, -3000.0)] {
        let (mut particles, rows) = compound(at);
        let centre = barycentre(&particles, at).as_vec3();
        let before = momenta(&particles, centre);
        particles.apply_impulse(&rows, PUSH);
        let after = momenta(&particles, centre);
        assert!((after.0 - before.0 - PUSH.as_dvec3()).length() < 5e-6);
        // Only the lever arm of the barycentre's rounding to `f32` remains.
        assert!((after.1 - before.1).length() < if at.x == 0.0 { 5e-6 } else { 2e-3 });
    }
}

#[test]
fn an_angular_impulse_changes_angular_momentum_by_itself_and_leaves_the_momentum() {
    for at in [Vec3::ZERO, Vec3::new(5000.0, 10.0, -3000.0)] {
        let (mut particles, rows) = compound(at);
        let before = momenta(&particles, at);
        particles.apply_angular_impulse(&rows, PUSH);
        let after = momenta(&particles, at);
        assert!((after.0 - before.0).length() < 5e-6, "{}", after.0 - before.0);
        assert!((after.1 - before.1 - PUSH.as_dvec3()).length() < 2e-5, "{}", after.1 - before.1);
        assert_eq!((particles.velocity(5), particles.velocity(6)), (Vec3::ZERO, Vec3::ZERO));
    }
}

#[test]
fn an_impulse_at_a_point_has_the_angular_momentum_of_its_lever() {
    for at in [Vec3::ZERO, Vec3::new(5000.0, 10.0, -3000.0)] {
        let (mut particles, rows) = compound(at);
        let lever = Vec3::new(0.5, 3.0, -1.0);
        let before = momenta(&particles, at);
        particles.apply_impulse_at(&rows, PUSH, at + lever);
        let after = momenta(&particles, at);
        assert!((after.0 - before.0 - PUSH.as_dvec3()).length() < 5e-6);
        let turned = after.1 - before.1 - lever.as_dvec3().cross(PUSH.as_dvec3());
        assert!(turned.length() < 3e-5, "{turned}");
    }
}

#[test]
fn a_line_takes_the_angular_impulse_across_it_and_one_particle_takes_none() {
    let mut particles = Particles::default();
    for x in [-1.0, 0.0, 2.0] {
        particles.push(ParticleSeed::at(Vec3::X * x)).unwrap();
    }
    particles.apply_angular_impulse(&[0, 1, 2], Vec3::new(5.0, 1.0, 2.0));
    let turn: Vec3 = (0..3).map(|i| particles.position(i).cross(particles.velocity(i))).sum();
    assert!(turn.abs_diff_eq(Vec3::new(0.0, 1.0, 2.0), 1e-6), "{turn}");
    particles.set_velocity(0, Vec3::ZERO);
    particles.apply_angular_impulse(&[0], PUSH);
    assert_eq!(particles.velocity(0), Vec3::ZERO);
    particles.apply_impulse_at(&[0], PUSH, Vec3::Y * 40.0);
    assert_eq!(particles.velocity(0), PUSH);
}

#[test]
fn a_teleport_turns_and_moves_exactly_and_leaves_every_bit_of_the_velocities() {
    let (mut particles, rows) = compound(Vec3::ZERO);
    let before = particles.clone();
    let centre = barycentre(&particles, Vec3::ZERO);
    // 120° about (1, 1, 1), of length 2: x goes to y, y to z, z to x.
    particles.teleport(&rows, Vec3::new(7000.25, 0.0, -3.0), Quat::from_xyzw(1.0, 1.0, 1.0, 1.0));
    for i in 0..6 {
        let arm = before.position(i).as_dvec3() - centre;
        let target = centre + DVec3::new(arm.z, arm.x, arm.y) + DVec3::new(7000.25, 0.0, -3.0);
        let error =
            particles.relative_to(i, Vec3::X * 7000.0).as_dvec3() + DVec3::X * 7000.0 - target;
        assert!(error.length() < 1e-6, "{i}: {error}, beyond the digits of f32 at 7 km");
    }
    assert_eq!(particles.velocity, before.velocity);
    assert_eq!(particles.position(6), before.position(6));
    // And back, whole metres without any error at all.
    let there = particles.clone();
    particles.teleport(&rows, Vec3::X * 1e5, Quat::IDENTITY);
    particles.teleport(&rows, Vec3::X * -1e5, Quat::IDENTITY);
    assert_eq!(particles.position, there.position);
    assert_eq!(particles.origin, there.origin);
}

#[test]
fn a_motion_that_was_set_is_read_back_as_it_is() {
    let (mut particles, rows) = compound(Vec3::new(5000.0, 0.0, 0.0));
    let (velocity, spin) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(-0.5, 4.0, 0.2));
    particles.set_motion(&rows, velocity, spin);
    let points = (0..5).map(|i| {
        (particles.relative_to(i, Vec3::X * 5000.0), particles.velocity(i), particles.mass(i))
    });
    let found = crate::pose::motion(points).unwrap();
    assert!(found.velocity.abs_diff_eq(velocity, 2e-6), "{}", found.velocity);
    assert!(found.angular_velocity.abs_diff_eq(spin, 5e-6), "{}", found.angular_velocity);
    assert_eq!((particles.lag(0), particles.velocity(5)), (0.0, Vec3::ZERO));
}

#[test]
fn motion_that_is_reversed_returns_to_its_start_with_springs_too() {
    let at = Vec3::new(3000.0, 4.0, 0.0);
    let (particles, rows) = compound(at);
    let mut world = Simulation::default();
    world.particles = particles;
    world.settings.substeps = 1;
    for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0), (1, 3)] {
        let rest = world.particles.separation(a, b).length() * 0.8;
        let (a, b) = (a as u32, b as u32);
        world.forces.springs.push(Spring { a, b, rest, stiffness: 40.0, damping: 0.0 });
    }
    let start = world.particles.clone();
    let n = 240;
    for _ in 0..n {
        world.step(1.0 / 60.0).unwrap();
    }
    assert!((world.particles.position(0) - start.position(0)).length() > 10.0, "it went somewhere");
    world.particles.reverse(&rows);
    for _ in 0..n - 1 {
        world.step(1.0 / 60.0).unwrap();
    }
    for i in 0..5 {
        let error = world.particles.relative_to(i, at) - start.relative_to(i, at);
        assert!(error.length() < 2e-4, "{i}: {error}");
    }
}

#[test]
fn what_is_not_finite_changes_nothing() {
    let (particles, rows) = compound(Vec3::ZERO);
    let nan = Vec3::new(0.0, f32::NAN, 0.0);
    let edits: [&dyn Fn(&mut Particles); 8] = [
        &|p| p.apply_impulse(&rows, nan),
        &|p| p.apply_angular_impulse(&rows, nan),
        &|p| p.apply_impulse_at(&rows, PUSH, nan),
        &|p| p.teleport(&rows, nan, Quat::IDENTITY),
        &|p| p.teleport(&rows, PUSH, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
        &|p| p.set_motion(&rows, PUSH, nan),
        &|p| p.apply_impulse(&[], PUSH),
        &|p| p.apply_impulse(&[5, 99], PUSH),
    ];
    for (number, edit) in edits.iter().enumerate() {
        let mut edited = particles.clone();
        edit(&mut edited);
        assert_eq!(edited.position, particles.position, "{number}");
        assert_eq!(edited.velocity, particles.velocity, "{number}");
    }
}
