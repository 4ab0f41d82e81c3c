//! Contacts of body colliders with single particles.

use super::*;
use crate::{BodySettings, ParticleSeed};

/// A world without gravity, with a box at zero and a particle that collides with bodies.
fn with_particle(seed: ParticleSeed, material: Material) -> (Simulation, usize, usize) {
    let mut world = world();
    world.forces.gravity = Vec3::ZERO;
    let first = add_box(&mut world, Vec3::ONE, 2.0, Vec3::ZERO, Quat::IDENTITY);
    let row = world.particles.push(seed).unwrap() as usize;
    let body = world.bodies.len() as u32;
    world.bodies.push(BodySettings::default());
    world.particles.set_body(row, Some(body));
    set_material(&mut world, material);
    world.contacts[body as usize].with_bodies = true;
    (world, first, row)
}

#[test]
fn a_particle_pushes_a_box_and_momentum_is_kept() {
    let seed = ParticleSeed::at(Vec3::new(-1.0, 0.3, 0.1)).with_radius(0.1);
    for (e, v) in [(0.0, 3.0), (1.0, 3.0), (0.5, 80.0)] {
        let material = rough(0.5).with_restitution(e);
        let (mut world, first, row) = with_particle(seed.with_velocity(Vec3::X * v), material);
        let sum = |world: &Simulation| {
            (0..world.particles.len()).fold((Vec3::ZERO, Vec3::ZERO), |(p, l), i| {
                let m = world.particles.velocity(i) * world.particles.mass(i);
                (p + m, l + world.particles.position(i).cross(m))
            })
        };
        let before = sum(&world);
        step(&mut world, 1.0);
        let after = sum(&world);
        let (box_v, particle_v) = (velocity(&world, first), world.particles.velocity(row));
        assert!(box_v.x > 0.3 && particle_v.x < 0.5 * v);
        assert!((after.0 - before.0).length() < 2e-4 * v);
        assert!((after.1 - before.1).length() < 2e-4 * v);
    }
}

#[test]
fn a_particle_without_collision_passes_through() {
    let seed = ParticleSeed::at(Vec3::X * -1.0).with_radius(0.1).with_velocity(Vec3::X * 3.0);
    let (mut world, _, row) = with_particle(seed, rough(0.5));
    let body = world.particles.body(row).unwrap() as usize;
    world.contacts[body].with_bodies = false;
    step(&mut world, 1.0);
    assert_eq!(world.particles.velocity(row), Vec3::X * 3.0);
}
