//! Properties that a plan has for any input.

use super::*;
use crate::constraints::{Bend, ConstraintKind, Softness};

/// A bend of four particles.
pub(super) fn bend(rows: [u32; 4]) -> Constraint {
    let bend = Bend { weights: [0.5, 0.5, -0.5, -0.5], rest: 0.0, softness: Softness::default() };
    Constraint::new(rows, ConstraintKind::Bend(bend))
}

/// Compiles a plan of these distances among `particles` particles.
fn compile(plan: &mut Plan, distances: &[Distance], particles: usize) {
    plan.compile(PlanInput { distances, constraints: &[], particles });
}

#[test]
fn no_two_distances_of_a_colour_share_a_particle_and_none_is_lost() {
    let mut distances = Vec::new();
    let (columns, rows) = (13, 9);
    let at = |c: u32, r: u32| r * columns + c;
    for r in 0..rows {
        for c in 0..columns {
            for (dc, dr) in [(1, 0), (0, 1), (1, 1), (2, 0)] {
                if c + dc < columns && r + dr < rows {
                    distances.push(Distance::new(at(c, r), at(c + dc, r + dr), 1.0));
                }
            }
        }
    }
    let mut plan = Plan::default();
    compile(&mut plan, &distances, (columns * rows) as usize);
    assert_eq!(plan.distances.len(), distances.len());
    assert!(plan.groups.len() <= 16, "{}", plan.groups.len());
    for group in &plan.groups {
        let mut seen = std::collections::BTreeSet::new();
        for distance in &plan.distances[group.range.clone()] {
            assert!(seen.insert(distance.a) && seen.insert(distance.b));
        }
    }
}

#[test]
fn a_hub_of_a_hundred_spokes_overflows_and_is_still_all_there() {
    let distances: Vec<_> = (1..=100).map(|i| Distance::new(0, i, 1.0)).collect();
    let mut plan = Plan::default();
    compile(&mut plan, &distances, 101);
    assert_eq!(plan.distances.len(), 100);
    assert_eq!(plan.groups.len(), 65);
    assert_eq!(plan.groups.last().unwrap().range.len(), 36);
}

#[test]
fn islands_are_what_distances_connect_and_loose_particles_are_islands_too() {
    let distances = [Distance::new(4, 1, 1.0), Distance::new(0, 3, 1.0), Distance::new(3, 5, 1.0)];
    let mut plan = Plan::default();
    compile(&mut plan, &distances, 7);
    let members: Vec<_> =
        plan.islands.list.iter().map(|i| &plan.islands.members[i.members.clone()]).collect();
    assert_eq!(members, [&[0, 3, 5][..], &[1, 4], &[2], &[6]]);
    let groups: Vec<_> = plan.islands.list.iter().map(|i| i.groups.len()).collect();
    assert_eq!(groups, [2, 1, 0, 0]);
    assert_eq!(plan.distances, [distances[1], distances[2], distances[0]]);
}

#[test]
fn an_island_is_compiled_the_same_whatever_stands_beside_it() {
    let body = |first: u32| (0..5).map(move |i| Distance::new(first + i, first + i + 1, 1.0));
    let (mut alone, mut beside) = (Plan::default(), Plan::default());
    compile(&mut alone, &body(0).collect::<Vec<_>>(), 6);
    compile(&mut beside, &body(6).chain(body(0)).collect::<Vec<_>>(), 12);
    assert_eq!(beside.distances[..5], alone.distances[..]);
    assert_eq!(beside.groups[..2], alone.groups[..]);
}

#[test]
fn a_faulty_distance_is_left_out_and_the_rest_keeps_its_order() {
    let good = [Distance::new(0, 1, 1.0), Distance::new(2, 3, 2.0)];
    let bad = Distance::new(1, 1, 1.0);
    let (mut with, mut without) = (Plan::default(), Plan::default());
    compile(&mut with, &[good[0], bad, good[1], Distance::new(0, 9, 1.0)], 4);
    compile(&mut without, &good, 4);
    assert_eq!(with.distances, without.distances);
    assert_eq!(with.groups, without.groups);
}
