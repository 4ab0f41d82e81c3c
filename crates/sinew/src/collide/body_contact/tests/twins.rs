//! The same bits from all instruction sets.

use glam::{Vec3, Vec4};

use super::super::BodyContactSolver;
use super::heaps::pour;
use super::*;
use crate::collide::nearby::Nearby;
use crate::collide::restitution::ImpactRounds;
use crate::collide::{ContactFilter, ParticleContacts, World};
use crate::forces::RowGravity;
use crate::islands::Islands;
use crate::lanes::InstructionSet;
use crate::particles::Particles;

/// Some substeps of contacts alone.
fn substeps(
    world: &Simulation,
    body_colliders: &mut BodyContactSolver,
    particles: &mut Particles,
    count: u32,
) {
    let islands = Islands::default();
    let filter = ContactFilter::untied(&world.contacts);
    let nearby = Nearby::everywhere(&world.contacts);
    let (h, gravity, mut rounds) = (1.0 / 600.0, RowGravity::from(9.81), ImpactRounds::default());
    let seen = World {
        boundaries: &world.boundaries,
        colliders: &world.colliders,
        body_colliders: world.body_colliders(),
        filter: &filter,
        islands: &islands,
        dt: 1.0 / 60.0,
        substeps: 10,
        gravity: Vec3::Y * -9.81,
        row_gravity: &gravity,
        at_rest: false,
    };
    body_colliders.broad_phase(
        particles,
        &seen,
        (&nearby, &Default::default()),
        &mut Default::default(),
    );
    for number in 0..count {
        for i in 0..particles.len() {
            particles.start[i] = particles.position[i];
            let v = particles.velocity[i].truncate() + Vec3::Y * (-9.81 * h);
            particles.velocity[i] = v.extend(h);
            particles.position[i] += (v * h).extend(0.0);
        }
        let no_cloth = (&mut (), &ParticleContacts::default(), &mut [][..]);
        let near = (&seen, &nearby, &Default::default());
        body_colliders.project(particles, near, (h, number), no_cloth);
        for i in 0..particles.len() {
            let v = (particles.position[i] - particles.start[i]).truncate() / h;
            particles.velocity[i] = v.extend(h);
        }
        body_colliders.begin_impacts();
        let ends = (particles.len(), body_colliders.impact_rows());
        rounds.run(ends, (h, &gravity), |round| body_colliders.bounce(particles, round));
        body_colliders.end_impacts(particles, h);
    }
}

#[test]
fn all_instruction_sets_give_the_same_bits() {
    let mut world = world();
    floor(&mut world, rough(0.4).with_restitution(0.3));
    pour(&mut world, 43, 3);
    step(&mut world, 2.5);
    let run = |instructions: InstructionSet| -> Vec<[u32; 4]> {
        let mut particles = world.particles.clone();
        let mut body_colliders = BodyContactSolver { instructions, ..BodyContactSolver::default() };
        body_colliders.compile(world.body_colliders(), &particles);
        substeps(&world, &mut body_colliders, &mut particles, 10);
        let bits = |v: &Vec4| v.to_array().map(f32::to_bits);
        particles.position.iter().chain(&particles.velocity).map(bits).collect()
    };
    let scalar = run(InstructionSet::Scalar);
    assert!(scalar == run(InstructionSet::Simd128));
    assert!(scalar == run(InstructionSet::Avx2));
}
