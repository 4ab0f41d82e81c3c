//! Tests of a rigid shape in motion: spin, tumbling, momentum, energy and free fall, each in a world of its own.

use super::*;
use crate::{Constraint, ConstraintKind, ParticleSeed, Simulation};

/// Eight particles at ±`half` about the origin, of `mass` kg in total, spinning at `spin` rad/s.
fn boxed(half: Vec3, mass: f32, spin: Vec3, gradient_at: GradientAt) -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::ZERO;
    world.settings.gradient_at = gradient_at;
    // These tests are about the correction itself, not about what restores its losses.
    world.settings.keep_spin = false;
    world.settings.substeps = 1;
    let sign = |bit: u8| f32::from(bit & 1) * 2.0 - 1.0;
    let rest: Vec<_> =
        (0..8).map(|i| half * Vec3::new(sign(i), sign(i >> 1), sign(i >> 2))).collect();
    for p in &rest {
        let seed = ParticleSeed::at(*p).with_mass(mass / 8.0).with_velocity(spin.cross(*p));
        world.particles.push(seed).unwrap();
    }
    world.constraints_mut().push(Constraint::new(0..8, ConstraintKind::Rigid(Rigid::of(rest))));
    world
}

fn angular_momentum(world: &mut Simulation) -> DVec3 {
    world.ledger().angular_momentum
}

#[test]
fn a_spun_cube_keeps_its_spin_along_the_start_of_the_step() {
    let mut kept = Vec::new();
    for gradient_at in [GradientAt::StepStart, GradientAt::Current] {
        let mut world = boxed(Vec3::splat(0.5), 8.0, Vec3::Y * 10.0, gradient_at);
        world.settings.substeps = 20;
        let (before, energy) = (angular_momentum(&mut world), world.ledger().kinetic);
        for _ in 0..600 {
            world.step(1.0 / 60.0).unwrap();
        }
        let after = angular_momentum(&mut world);
        kept.push(after.y / before.y);
        println!(
            "{gradient_at:?}: angular momentum {:.6}, energy {:.6}, aside {:.1e}",
            after.y / before.y,
            world.ledger().kinetic / energy,
            after.with_y(0.0).length() / before.y
        );
    }
    assert!((kept[0] - 1.0).abs() < 0.005, "{kept:?}");
    // ω0/√(1 + 2ω0² h t) is 0.61 for rods.
    assert!((kept[1] - 0.612).abs() < 0.02, "{kept:?}");
}

#[test]
fn at_one_step_a_frame_the_nearest_way_bleeds_as_the_rods_do() {
    let spin = |gradient_at| {
        let mut world = boxed(Vec3::splat(0.5), 8.0, Vec3::Z * 5.0, gradient_at);
        for _ in 0..120 {
            world.step(1.0 / 60.0).unwrap();
        }
        let velocity = (world.particles.velocity(0) - world.particles.velocity(7)).length();
        velocity / 2.0_f32.sqrt()
    };
    let (nearest, kept) = (spin(GradientAt::Current), spin(GradientAt::StepStart));
    println!("5 rad/s after 2 s at 1/60 s: {nearest} and {kept}");
    assert!((nearest - 3.07).abs() < 0.02, "{nearest}");
    // Verlet keeps the sine of a step's rotation angle, 5/60; the value that is read back is its chord.
    let turn = libm::asinf(5.0 / 60.0);
    assert!((kept - 120.0 * libm::sinf(0.5 * turn)).abs() < 1e-3, "{kept}");
}

/// Seconds between the flips of a solid box 1×2×3 at 6 rad/s about its middle axis, tilted by 1 %, over `seconds` in steps of `h`.
///
/// The particles are at ±half/√3 and have the inertia of the solid box; its moments are in the ratio 13 : 10 : 5, the middle one about y.
fn flips(h: f32, seconds: f32) -> Vec<f32> {
    let half = Vec3::new(1.0, 2.0, 3.0) * (0.5 / 3.0_f32.sqrt());
    let spin = Vec3::new(libm::sinf(0.01), libm::cosf(0.01), 0.0) * 6.0;
    let mut world = boxed(half, 12.0, spin, GradientAt::StepStart);
    let (mut last, mut times) = (1.0, Vec::new());
    for step in 0..(seconds / h) as u32 {
        world.step(h).unwrap();
        // The y axis of the body: from a particle at -y to the one at +y.
        let up = (world.particles.position(2) - world.particles.position(0)).y;
        if up * last < 0.0 {
            // Interpolated linearly between the two steps.
            times.push((step as f32 + last / (last - up)) * h);
        }
        last = up;
    }
    times.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

#[test]
fn the_middle_axis_flips_every_3_903_s() {
    let periods = flips(1.0 / 240.0, 20.0);
    println!("{periods:?} s apart");
    assert!(periods.len() >= 4, "{periods:?}");
    assert!(periods.iter().all(|p| (p / 3.903 - 1.0).abs() < 0.01), "{periods:?}");
}

#[test]
fn ten_thousand_steps_of_tumbling_keep_momentum_angular_momentum_and_energy() {
    let half = Vec3::new(1.0, 2.0, 3.0) * (0.5 / 3.0_f32.sqrt());
    let mut world = boxed(half, 12.0, Vec3::new(1.0, 4.0, 2.0), GradientAt::StepStart);
    for i in 0..8 {
        let v = world.particles.velocity(i);
        world.particles.set_velocity(i, v + Vec3::new(0.5, -0.25, 0.125));
    }
    let before = world.ledger();
    let about = |world: &mut Simulation| {
        let (ledger, mut centre) = (world.ledger(), DVec3::ZERO);
        for i in 0..8 {
            centre += world.particles.position(i).as_dvec3() / 8.0;
        }
        ledger.angular_momentum - centre.cross(ledger.momentum)
    };
    let spin = about(&mut world);
    let (mut least, mut most) = (f64::MAX, 0.0_f64);
    for _ in 0..10_000 {
        world.step(1.0 / 240.0).unwrap();
        let energy = world.ledger().kinetic / before.kinetic;
        (least, most) = (least.min(energy), most.max(energy));
    }
    let after = world.ledger();
    let momentum = (after.momentum - before.momentum).length() / before.momentum.length();
    let angular = (about(&mut world) - spin).length() / spin.length();
    let end = after.kinetic / before.kinetic;
    println!(
        "momentum {momentum:.1e}, angular momentum {angular:.1e}, energy {least:.5}..{most:.5}, at last {end:.5}"
    );
    assert!(momentum < 1e-4 && angular < 1e-4, "{momentum} {angular}");
    assert!(least > 0.995 && most < 1.005, "{least} {most}");
}

#[test]
fn in_free_fall_the_barycentre_follows_the_parabola_while_the_shape_spins() {
    for gradient_at in [GradientAt::StepStart, GradientAt::Current] {
        let mut world = boxed(Vec3::splat(0.5), 8.0, Vec3::new(3.0, 2.0, 1.0), gradient_at);
        world.forces.gravity = Vec3::new(0.0, -9.81, 0.0);
        for _ in 0..240 {
            world.step(1.0 / 240.0).unwrap();
        }
        let centre = (0..8).map(|i| world.particles.position(i)).sum::<Vec3>() / 8.0;
        assert!((centre - Vec3::Y * -4.905).length() < 1e-4, "{gradient_at:?}: {centre}");
    }
}

#[test]
fn a_plate_on_one_pinned_corner_swings_as_long_as_one_looks() {
    // A square plate hung by a corner and released from 60° to the side: a physical pendulum.
    let mut world = Simulation::default();
    world.settings.gradient_at = GradientAt::StepStart;
    let (sin, cos) = libm::sincosf(60.0_f32.to_radians());
    let at = |x: f32, y: f32| Vec3::new(x * cos - y * sin, x * sin + y * cos, 0.0);
    let rest = [at(0.0, 0.0), at(0.5, -0.5), at(-0.5, -0.5), at(0.0, -1.0)];
    for (i, p) in rest.iter().enumerate() {
        let seed = ParticleSeed::at(*p);
        world.particles.push(if i == 0 { seed.pinned() } else { seed }).unwrap();
    }
    world.constraints_mut().push(Constraint::new(0..4, ConstraintKind::Rigid(Rigid::of(rest))));
    let top = rest[3].y;
    let before = world.ledger();
    let (mut last, mut turning) = (0.0_f32, Vec::new());
    for _ in 0..1200 {
        world.step(1.0 / 120.0).unwrap();
        let speed = world.particles.velocity(3).dot(Vec3::new(
            -world.particles.position(3).y,
            world.particles.position(3).x,
            0.0,
        ));
        if speed * last < 0.0 {
            turning.push(world.particles.position(3).y);
        }
        last = speed;
    }
    let after = world.ledger();
    let (swing, lost) = (before.energy() - 3.0 * 9.81 * -0.6667, before.energy() - after.energy());
    println!("turns at {turning:?}, began at {top}; energy {lost:.2e} lost of {swing:.3}");
    assert!(turning.len() > 8 && turning.iter().all(|y| (y - top).abs() < 0.01), "{turning:?}");
    assert_eq!(world.particles.position(0), Vec3::ZERO);
}
