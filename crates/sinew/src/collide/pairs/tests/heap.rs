//! Many particles at once: a heap of balls in a box, and a gas.

use glam::Vec3;

use super::{World, self_colliding};
use crate::particles::ParticleSeed;
use crate::test_random::Random;

const DT: f32 = 1.0 / 60.0;

/// Balls of 2 cm in a box of 24 × 24 cm, dropped layer by layer.
pub(super) fn heap(count: usize, side: usize, friction: f32) -> World {
    let (radius, spacing) = (0.02, 0.044);
    let size = side as f32 * spacing;
    let mut world = World {
        contacts: vec![self_colliding(friction, 0.0)],
        gravity: Vec3::Y * -9.81,
        room: Some((Vec3::ZERO, Vec3::new(size, 1e3, size), friction)),
        ..Default::default()
    };
    let mut random = Random::new(1);
    for i in 0..count {
        let cell = Vec3::new((i % side) as f32, (i / side / side) as f32, (i / side % side) as f32);
        let at = (cell + 0.5) * spacing + random.vector() * 0.0015;
        world.push(ParticleSeed::at(at).with_radius(radius).with_mass(0.03), 0);
    }
    world
}

/// The greatest overlap, as a share of the radius, and the root mean square speed, m/s.
fn state(world: &World) -> (f32, f32) {
    let (mut worst, count) = (0.0_f32, world.particles.len());
    for i in 0..count {
        for j in 0..i {
            let reach = world.particles.radius(i) + world.particles.radius(j);
            let overlap = reach - world.particles.separation(i, j).length();
            worst = worst.max(overlap / world.particles.radius(i));
        }
    }
    let sum: f32 = (0..count).map(|i| world.particles.velocity(i).length_squared()).sum();
    (worst, (sum / count as f32).sqrt())
}

#[test]
fn five_hundred_balls_in_a_box_stay_a_heap_without_sinking_into_each_other() {
    let mut world = heap(500, 6, 0.5);
    for second in 1..=6 {
        world.rebuilds = 0;
        for _ in 0..60 {
            world.step(DT);
        }
        let (overlap, speed) = state(&world);
        println!(
            "{second} s: {:.2} % of the radius, {:.3} mm/s, {} looks",
            overlap * 100.0,
            speed * 1e3,
            world.rebuilds
        );
    }
    let (overlap, speed) = state(&world);
    assert!(overlap < 0.1, "{overlap}");
    assert!(speed < 0.015, "{speed} m/s");
    assert!((0..500).all(|i| world.particles.position(i).y < 1.0), "none was thrown out");
}

#[test]
fn a_gas_that_bounces_never_has_more_energy_than_before() {
    for (restitution, friction) in [(1.0, 0.0), (1.0, 0.5), (0.5, 0.0), (0.0, 0.0)] {
        let mut world = World {
            contacts: vec![self_colliding(friction, restitution); 2],
            ..Default::default()
        };
        let mut random = Random::new(3);
        for i in 0..400_usize {
            let cell = Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32);
            let seed =
                ParticleSeed::at(cell * 0.05).with_velocity(random.vector() * 3.0 - cell * 0.3);
            let mass = 1.0 + 0.9 * random.number();
            world.push(seed.with_radius(0.015).with_mass(mass), (i % 2) as u32);
        }
        let (mut before, p) = (world.energy(), world.momentum());
        let first = before;
        for _ in 0..30 {
            world.step(DT);
            let now = world.energy();
            assert!(now <= before * 1.000_01, "{before} J to {now} J");
            before = now;
        }
        println!("e {restitution} μ {friction}: {:.4} of the energy is left", before / first);
        assert!(before < 0.9 * first || restitution == 1.0);
        assert!(before > 0.7 * first || restitution < 1.0 || friction > 0.0);
        for (now, before) in world.momentum().iter().zip(p) {
            assert!((now - before).abs() < 1e-3);
        }
    }
}

#[test]
fn a_foreseen_displacement_needs_no_rebuild() {
    let mut world = World { contacts: vec![self_colliding(0.5, 0.0)], ..Default::default() };
    for (x, speed) in [(0.0, 0.0), (0.3, 0.0), (0.6, 1.0)] {
        let seed = ParticleSeed::at(Vec3::X * x).with_velocity(Vec3::X * speed);
        world.push(seed.with_radius(0.065), 0);
    }
    (0..10).for_each(|_| {
        world.step(DT);
    });
    assert_eq!(world.rebuilds, 10, "once a step");
}
