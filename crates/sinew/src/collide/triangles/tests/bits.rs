//! What the result depends on: positions and the order of rows, and neither the order of triangles, nor instructions, nor where in the world it is,
//! nor who else is there.

use glam::Vec3;

use super::{DT, Sheet, asks, bits, body, empty, particle};
use crate::collide::BodyContacts;
use crate::lanes::InstructionSet;
use crate::particles::ParticleSeed;
use crate::simulation::Simulation;

/// A free sheet that folds up around balls that are shot at it; with somebody unrelated before rows for which that is said. Returns the rows of the
/// others.
fn scene(somebody: impl Fn(usize) -> bool) -> (Simulation, Vec<usize>) {
    let mut world = empty(9.81);
    let mut rows = Vec::new();
    let others = body(&mut world, BodyContacts { surface: false, ..asks(false) });
    let mut strangers = 0;
    let mut stranger = |world: &mut Simulation, number: usize| {
        if somebody(number) {
            strangers += 1;
            // As light as the others, and far away: they fall side by side.
            let at = Vec3::new(300.0 + strangers as f32, 0.0, 40.0);
            particle(world, ParticleSeed::at(at).with_radius(0.01), others);
        }
    };
    for i in 0..6 {
        stranger(&mut world, i);
        let at = Vec3::new(0.11 * i as f32 - 0.3, 0.15, 0.04 * i as f32 - 0.1);
        let seed = ParticleSeed::at(at).with_mass(0.03).with_radius(0.015);
        let velocity = Vec3::new(0.1, -2.0 - 5.0 * i as f32, 0.2);
        rows.push(particle(&mut world, seed.with_velocity(velocity), others));
    }
    let sheet = Sheet { contacts: asks(true), radius: 0.01, ..Sheet::flat(5, 0.15, 0.0) };
    let own = sheet.build(&mut world, |_, _| false);
    rows.extend(own);
    stranger(&mut world, 100);
    (world, rows)
}

fn run(world: &mut Simulation, steps: u32) {
    for _ in 0..steps {
        world.step(DT).unwrap();
    }
}

#[test]
fn neither_the_order_of_triangles_nor_which_way_round_they_are_makes_a_difference() {
    let (mut world, rows) = scene(|_| false);
    let (mut other, _) = scene(|_| false);
    other.forces.surfaces.reverse();
    for (i, triangle) in other.forces.surfaces.iter_mut().enumerate() {
        triangle.rotate_left(i % 3);
        if i % 2 == 0 {
            triangle.swap(0, 1);
        }
    }
    let again = other.forces.surfaces[..7].to_vec();
    other.forces.surfaces.extend(again);
    run(&mut world, 40);
    run(&mut other, 40);
    assert!(bits(&world, &rows) == bits(&other, &rows));
}

#[test]
fn unrelated_ones_change_no_bit_wherever_their_rows_are() {
    let [one, two, three] = [|_: usize| false, |i: usize| i.is_multiple_of(2), |i: usize| i == 100]
        .map(|which| {
            let (mut world, rows) = scene(which);
            run(&mut world, 30);
            bits(&world, &rows)
        });
    assert!(one == two && one == three, "a bit has changed");
}

#[test]
fn all_instructions_give_the_same_bits() {
    let results =
        [InstructionSet::Scalar, InstructionSet::Simd128, InstructionSet::Avx2].map(|set| {
            let (mut world, rows) = scene(|_| false);
            world.instructions = set;
            run(&mut world, 40);
            bits(&world, &rows)
        });
    assert!(results[0] == results[1] && results[0] == results[2]);
}

#[test]
fn five_kilometres_away_it_is_the_same_to_the_bit() {
    let run_at = |offset: Vec3| {
        let (mut world, rows) = scene(|_| false);
        for origin in &mut world.particles.origin {
            *origin += offset;
        }
        run(&mut world, 30);
        rows.iter().map(|&i| world.particles.velocity(i).to_array().map(f32::to_bits)).collect()
    };
    let [here, there]: [Vec<[u32; 3]>; 2] =
        [Vec3::ZERO, Vec3::new(5000.0, -3000.0, 4000.0)].map(run_at);
    assert!(here == there);
}

#[test]
fn nothing_is_remembered_from_step_to_step() {
    let (mut world, rows) = scene(|_| false);
    run(&mut world, 15);
    let (mut copy, _) = scene(|_| false);
    copy.particles = world.particles.clone();
    run(&mut world, 15);
    run(&mut copy, 15);
    assert!(bits(&world, &rows) == bits(&copy, &rows));
}
