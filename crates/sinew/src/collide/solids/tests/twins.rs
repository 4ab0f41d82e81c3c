//! The same bits from all instruction sets; and how long it takes.

use glam::{Vec3, Vec4};

use super::super::Solids;
use super::heaps::pour;
use super::*;
use crate::collide::World;
use crate::lanes::InstructionSet;
use crate::particles::Particles;
use crate::solve::Plan;

/// Some substeps of contacts alone, by hand; and how long looking for them and solving them took, seconds.
fn substeps(
    world: &Simulation,
    solids: &mut Solids,
    particles: &mut Particles,
    count: u32,
) -> [f64; 2] {
    let plan = Plan::default();
    let h = 1.0 / 600.0;
    let seen = World {
        boundaries: &world.boundaries,
        colliders: &world.colliders,
        solids: world.solids(),
        bodies: &world.contacts,
        plan: &plan,
        dt: 1.0 / 60.0,
        substeps: 10,
        gravity: 9.81,
    };
    let mut spent = [0.0; 2];
    let mut clock = |which: usize, work: &mut dyn FnMut()| {
        let now = std::time::Instant::now();
        work();
        spent[which] += now.elapsed().as_secs_f64();
    };
    clock(0, &mut || solids.find(particles, &seen, &mut Default::default()));
    for number in 0..count {
        for i in 0..particles.len() {
            particles.start[i] = particles.position[i];
            let v = particles.velocity[i].truncate() + Vec3::Y * (-9.81 * h);
            particles.velocity[i] = v.extend(h);
            particles.position[i] += (v * h).extend(0.0);
        }
        clock(1, &mut || solids.project(particles, &seen, h, number));
        for i in 0..particles.len() {
            let v = (particles.position[i] - particles.start[i]).truncate() / h;
            particles.velocity[i] = v.extend(h);
        }
        clock(1, &mut || solids.bounce(particles, h, 9.81));
    }
    spent
}

#[test]
fn all_instruction_sets_give_the_same_bits() {
    let mut world = world();
    floor(&mut world, rough(0.4).with_restitution(0.3));
    pour(&mut world, 43, 3);
    step(&mut world, 2.5);
    let run = |instructions: InstructionSet| -> Vec<[u32; 4]> {
        let mut particles = world.particles.clone();
        let mut solids = Solids { instructions, ..Solids::default() };
        solids.compile(world.solids(), &particles);
        substeps(&world, &mut solids, &mut particles, 10);
        let bits = |v: &Vec4| v.to_array().map(f32::to_bits);
        particles.position.iter().chain(&particles.velocity).map(bits).collect()
    };
    let scalar = run(InstructionSet::Scalar);
    assert!(scalar == run(InstructionSet::Simd128));
    assert!(scalar == run(InstructionSet::Avx2));
}

#[test]
#[ignore = "a measurement"]
fn how_long_a_pile_of_a_thousand_boxes_takes() {
    let mut world = world();
    floor(&mut world, rough(0.5));
    let mut dice = Dice(9);
    for i in 0..1000 {
        let (x, y, z) = (i % 10, i / 100, i / 10 % 10);
        let off = (dice.vector() - 0.5) * Vec3::new(0.1, 0.0, 0.1);
        let at = Vec3::new(x as f32 * 1.05, 0.51 + y as f32 * 1.01, z as f32 * 1.05) + off;
        add_box(&mut world, Vec3::ONE, 1.0, at, turn(Vec3::Y, 0.1 * dice.next()));
    }
    step(&mut world, 1.0);
    let now = std::time::Instant::now();
    step(&mut world, 0.5);
    let whole = now.elapsed().as_secs_f64() / 30.0;
    println!("whole step {:.3} ms, speed {}", whole * 1e3, speed(&world));
    for instructions in [InstructionSet::Avx2, InstructionSet::Simd128, InstructionSet::Scalar] {
        let mut solids = Solids { instructions, ..Solids::default() };
        solids.compile(world.solids(), &world.particles);
        let mut spent = [f64::INFINITY; 2];
        for _ in 0..20 {
            let mut particles = world.particles.clone();
            let now = substeps(&world, &mut solids, &mut particles, 10);
            spent = [spent[0].min(now[0]), spent[1].min(now[1])];
        }
        let points: usize =
            solids.memory.now.iter().map(|known| known.manifold.points().len()).sum();
        println!(
            "{instructions:?}: {:.3} ms to look and {:.3} ms to solve a step, {} manifolds in {} packs, {points} points",
            spent[0] * 1e3,
            spent[1] * 1e3,
            solids.found.len(),
            solids.packs.len(),
        );
    }
}
