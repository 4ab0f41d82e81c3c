//! The neighbour list against a brute-force test of all pairs.

use glam::Vec3;

use super::{World, self_colliding};
use crate::collide::{BodyContacts, Layers};
use crate::lanes::InstructionSet;
use crate::particles::ParticleSeed;
use crate::test_random::Random;

/// The expected pairs: rows of those that are closer than radii and margins, each pair once.
fn by_brute_force(world: &World) -> Vec<[u32; 2]> {
    let participants = &world.pairs.participants;
    let count = participants.rows.len();
    let mut found = Vec::new();
    for i in 0..count {
        for j in i + 1..count {
            let Some(reach) = participants.reach(&world.filter, i, j) else { continue };
            let within = reach + participants.home[i].w + participants.home[j].w;
            if participants.separation(i, j).length_squared() < within * within {
                found.push([participants.rows[i], participants.rows[j]]);
            }
        }
    }
    found
}

fn found(world: &World) -> Vec<[u32; 2]> {
    let rows = &world.pairs.participants.rows;
    world.pairs.neighbours.pairs.iter().map(|pair| pair.map(|i| rows[i as usize])).collect()
}

fn check(world: &mut World, name: &str) {
    for set in [InstructionSet::Scalar, InstructionSet::Simd128, InstructionSet::Avx2] {
        world.pairs.instructions = set;
        world.find(1.0 / 60.0);
        let expected = by_brute_force(world);
        assert_eq!(found(world), expected, "{name}, {set:?}");
        let mut packed: Vec<_> = world.pairs.neighbours.blocks.iter().flat_map(rows_of).collect();
        packed.sort_unstable();
        assert_eq!(packed, expected, "{name}: what is in blocks");
    }
    assert!(!found(world).is_empty(), "{name}");
}

fn rows_of(block: &super::super::neighbour_list::PairBlock) -> impl Iterator<Item = [u32; 2]> {
    (0..block.count as usize).map(|lane| [block.rows[0][lane], block.rows[1][lane]])
}

fn cloud(count: usize, size: f32, radius: impl Fn(usize, f32) -> f32) -> World {
    let mut world = World { contacts: vec![self_colliding(0.5, 0.0); 3], ..Default::default() };
    let mut random = Random::new(count as u64);
    for i in 0..count {
        let radius = radius(i, random.number().abs());
        let velocity = random.vector() * 2.0;
        let seed = ParticleSeed::at(random.vector() * size).with_velocity(velocity);
        world.push(seed.with_radius(radius), (i % 3) as u32);
    }
    world
}

#[test]
fn clouds_of_all_kinds_are_found_as_by_brute_force() {
    check(&mut cloud(2, 0.01, |_, _| 0.05), "two");
    check(&mut cloud(900, 0.3, |_, _| 0.02), "one size");
    check(&mut cloud(900, 0.5, |_, r| 0.002 + 0.03 * r), "many sizes");
    check(&mut cloud(700, 0.5, |i, _| if i % 100 == 7 { 0.3 } else { 0.004 }), "a few large ones");
    let sizes = |_: usize, r: f32| 0.3 * libm::powf(r, 12.0) + 1e-6;
    check(&mut cloud(700, 0.5, sizes), "sizes of all powers");
    check(&mut cloud(300, 0.0, |_, _| 0.02), "all at one place");
}

#[test]
fn groups_far_apart_are_found_and_so_are_those_far_from_the_origin() {
    for (offset, apart) in [
        (Vec3::ZERO, Vec3::new(5000.0, -300.0, 7.0)),
        (Vec3::new(5000.0, 5000.0, -5000.0), Vec3::X * 0.4),
        (Vec3::splat(-1e6), Vec3::new(2.1e6, 0.3, 4e5)),
        (Vec3::ZERO, Vec3::X * 1e14),
    ] {
        let mut world = cloud(600, 0.2, |_, _| 0.015);
        for i in 0..600 {
            let group = (i / 7 % 4) as f32;
            world.particles.origin[i] += (offset + apart * group).round();
        }
        check(&mut world, &format!("{offset} {apart}"));
    }
}

#[test]
fn a_line_a_sheet_and_a_lattice_are_found() {
    let mut random = Random::new(5);
    for scale in
        [Vec3::X * 30.0, Vec3::new(3.0, 0.0, 3.0), Vec3::splat(0.3), Vec3::new(0.0, 20.0, 0.0)]
    {
        let mut world = cloud(800, 0.0, |_, _| 0.02);
        for i in 0..800 {
            world.particles.set_position(i, random.vector() * scale);
        }
        check(&mut world, &format!("{scale}"));
    }
    // Exactly on the faces of cells.
    let mut world = cloud(729, 0.0, |_, _| 0.5);
    for i in 0..729 {
        let at = Vec3::new((i % 9) as f32, (i / 9 % 9) as f32, (i / 81) as f32);
        world.particles.set_position(i, at * 1.0);
    }
    check(&mut world, "lattice");
}

#[test]
fn non_participants_are_not_listed() {
    let mut world = cloud(300, 0.1, |i, _| if i % 5 == 0 { 0.0 } else { 0.02 });
    world.contacts[0].with_itself = false;
    world.contacts[1].layers = Layers::new(2, 2);
    world.contacts.pop();
    world.particles.position[31].y = f32::NAN;
    world.particles.radius[33] = f32::NAN;
    world.particles.set_body(37, None);
    let excluded: Vec<_> = (0..200).map(|i| i % 11 == 0).collect();
    world.find_without(&excluded, 0.02);
    let rows = found(&world);
    assert!(rows.len() > 50);
    for [a, b] in rows {
        for row in [a, b] {
            assert!(row % 5 != 0 && row % 3 == 1 && ![31, 33, 37].contains(&row), "{row}");
            assert!(!(row < 200 && row % 11 == 0), "{row} is excluded");
        }
    }
    world.contacts.fill(BodyContacts { with_bodies: false, ..Default::default() });
    world.find(0.02);
    assert!(world.pairs.is_empty() && found(&world).is_empty());
    let mut nobody = World::default();
    assert_eq!(nobody.step(0.02), 0.0);
}

#[test]
fn neighbours_in_the_rest_shape_may_be_as_near_as_they_are_there() {
    let mut world = World { contacts: vec![self_colliding(0.5, 0.0)], ..Default::default() };
    for i in 0..4 {
        world.push(ParticleSeed::at(Vec3::X * (i as f32 * 0.001)).with_radius(0.01), 0);
    }
    world.rest = [0.0, 0.015, 0.03, f32::NAN].map(|x| Vec3::X * x).to_vec();
    world.find(0.02);
    assert_eq!(found(&world), [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
    for (reach, expected) in
        world.pairs.neighbours.reach.iter().zip([0.015, 0.02, 0.02, 0.015, 0.02, 0.02])
    {
        assert!((reach - expected).abs() < 1e-7, "{reach} {expected}");
    }
    world.rest[1] = Vec3::ZERO;
    world.find(0.02);
    assert!(!found(&world).contains(&[0, 1]), "a seam");
}
