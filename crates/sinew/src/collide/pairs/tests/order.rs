//! What the result depends on: positions and the order of rows, and neither the instruction set, nor the place in the world, nor unrelated particles.

use glam::Vec3;

use super::heap::heap;
use super::{World, bits, self_colliding};
use crate::lanes::InstructionSet;
use crate::particles::ParticleSeed;

const DT: f32 = 1.0 / 60.0;

/// A cluster of balls that fall together, with friction, bounces and fast particles.
fn cluster(world: &mut World, at: Vec3, body: u32, row: impl Fn(usize) -> bool) -> Vec<usize> {
    let heap = heap(150, 5, 0.5);
    let mut rows = Vec::new();
    for i in 0..heap.particles.len() {
        let mut seed = heap.particles.seed(i);
        seed.velocity = -seed.position * 3.0;
        if i % 29 == 0 {
            seed.velocity *= 40.0;
        }
        seed.position += at;
        seed.radius = 0.0235;
        if row(i) {
            // An unrelated particle in between.
            world.push(
                ParticleSeed::at(at * 3.0 + Vec3::X * (world.particles.len() - rows.len()) as f32)
                    .with_radius(0.02),
                body,
            );
        }
        rows.push(world.push(seed, body));
    }
    rows
}

fn places(world: &World, rows: &[usize]) -> Vec<[[u32; 4]; 2]> {
    let (p, v) = (bits(&world.particles.position), bits(&world.particles.velocity));
    rows.iter().map(|&row| [p[row], v[row]]).collect()
}

fn run(world: &mut World, steps: u32) {
    for _ in 0..steps {
        world.step(DT);
    }
}

fn contacts() -> World {
    World { contacts: vec![self_colliding(0.4, 0.3); 2], ..Default::default() }
}

#[test]
fn all_instructions_give_the_same_bits() {
    let results =
        [InstructionSet::Scalar, InstructionSet::Simd128, InstructionSet::Avx2].map(|set| {
            let mut world = contacts();
            let rows = cluster(&mut world, Vec3::ONE, 0, |_| false);
            world.pairs.instructions = set;
            run(&mut world, 20);
            assert!(world.rebuilds > 40, "there are fast ones: {}", world.rebuilds);
            places(&world, &rows)
        });
    assert_eq!(results[0], results[1]);
    assert_eq!(results[0], results[2]);
}

#[test]
fn unrelated_particles_change_no_bit_wherever_their_rows_are() {
    // The same ten unrelated particles: between, before and after the others.
    let [one, two, three] =
        [|i: usize| i % 15 == 3, |i: usize| i < 10, |i: usize| i > 139].map(|which| {
            let mut world = contacts();
            let rows = cluster(&mut world, Vec3::ONE * 0.25, 0, which);
            assert_eq!(world.particles.len(), rows.len() + 10);
            run(&mut world, 15);
            places(&world, &rows)
        });
    assert!(one == two && one == three, "a bit has changed");
}

#[test]
fn five_kilometres_away_it_is_the_same_to_the_bit() {
    let run_at = |offset: Vec3| {
        let mut world = contacts();
        let rows = cluster(&mut world, Vec3::ZERO, 0, |_| false);
        for origin in &mut world.particles.origin {
            *origin += offset;
        }
        run(&mut world, 15);
        places(&world, &rows)
    };
    assert!(run_at(Vec3::ZERO) == run_at(Vec3::new(5000.0, -3000.0, 4000.0)));
}

#[test]
fn neither_what_was_before_nor_a_copy_makes_a_difference() {
    let mut world = contacts();
    let rows = cluster(&mut world, Vec3::ZERO, 0, |_| false);
    run(&mut world, 7);
    let mut fresh = World { pairs: Default::default(), ..world.clone() };
    run(&mut world, 7);
    run(&mut fresh, 7);
    assert!(places(&world, &rows) == places(&fresh, &rows));
}

#[test]
fn candidates_that_are_kept_give_the_bits_of_those_that_are_found_anew() {
    let mut kept = contacts();
    for i in 0..60_u32 {
        let speed = if i % 3 == 0 { 0.02 } else { -0.01 };
        let seed = ParticleSeed::at(Vec3::X * (0.103 * i as f32)).with_radius(0.05);
        kept.push(seed.with_velocity(Vec3::X * speed), i % 2);
    }
    // One particle, which touches nothing, moves by the limit of its candidates in every fifth step.
    let lone = ParticleSeed::at(Vec3::Y).with_radius(0.05);
    kept.push(lone.with_velocity(Vec3::Y * 0.1), 0);
    let mut anew = kept.clone();
    let mut steps_kept = 0;
    for step in 0..120 {
        let before = kept.pairs.candidates.place.clone();
        kept.step(DT);
        steps_kept += usize::from(kept.pairs.candidates.place == before);
        anew.pairs.candidates = Default::default();
        anew.step(DT);
        assert_eq!(kept.pairs.neighbours.pairs, anew.pairs.neighbours.pairs, "step {step}");
        assert!(kept.particles.position == anew.particles.position, "step {step}");
        assert!(kept.particles.velocity == anew.particles.velocity, "step {step}");
    }
    println!("candidates were kept through {steps_kept} of 120 steps");
    assert!((60..115).contains(&steps_kept), "{steps_kept}");
}

/// Restitution is solved in rounds while anything still changes. They used to go over all that touched in the substep, so that a row without restitution was
/// solved further where balls bounced elsewhere.
#[test]
fn an_impact_elsewhere_changes_no_bit() {
    let [alone, beside] = [0.0, 1.0].map(|restitution| {
        let contacts = [0.0, restitution].map(|restitution| self_colliding(0.2, restitution));
        let mut world = World { contacts: contacts.into(), ..Default::default() };
        let row = |world: &mut World, at: Vec3, body| -> Vec<usize> {
            let seed = |k: usize| ParticleSeed::at(at + Vec3::X * k as f32).with_radius(0.5);
            let last = at - Vec3::new(1.1, 0.02, 0.0);
            let thrown = ParticleSeed::at(last).with_velocity(Vec3::X * 5.0).with_radius(0.5);
            (0..5).map(seed).chain([thrown]).map(|seed| world.push(seed, body)).collect()
        };
        let rows = row(&mut world, Vec3::ZERO, 0);
        row(&mut world, Vec3::Z * 20.0, 1);
        run(&mut world, 5);
        assert!(world.particles.velocity(rows[4]).x > 0.3, "the impact has reached its end");
        places(&world, &rows)
    });
    assert_eq!(alone, beside);
}
