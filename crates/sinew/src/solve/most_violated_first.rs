//! Most-violated-first: a heap yields the constraint with the largest error; projecting it only changes the errors of its neighbours.

use std::collections::BinaryHeap;

use super::constraint_ref::{ConstraintRef, Local, SolveMode};
use super::multipliers::MultiplierSlice;
use super::plan::Plan;
use crate::islands::Island;
use crate::particles::Places;

/// The state of the heap. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Queue {
    /// The error (as bits, which have the order of the number, since it is not negative), the place in the list (reversed, so that the first wins a tie), and a
    /// stamp.
    heap: BinaryHeap<(u32, core::cmp::Reverse<u32>, u32)>,
    /// How often each constraint's error was measured: a heap entry with an older stamp is out of date.
    stamps: Vec<u32>,
    /// The place of each particle among the members of the island, by row.
    slots: Vec<u32>,
    /// For each member, where the list of its constraints begins in `touching`.
    begins: Vec<u32>,
    touching: Vec<u32>,
}

/// Makes as many projections as the island has constraints, always of the one with the largest error. Returns the largest error found, metres. Compliant
/// constraints, which are not meant to reach zero error, are projected once each, before the others.
pub(super) fn sweep(
    places: &mut Places,
    plan: &Plan,
    island: &Island,
    multipliers: &mut MultiplierSlice,
    mode: SolveMode,
    (local, constraint_refs): (&mut Local, &[ConstraintRef]),
    queue: &mut Queue,
) -> f32 {
    let (mut pair, tolerance) = ([0; 2], island.settings.tolerance);
    queue.connect(plan, island, constraint_refs);
    let mut worst = 0.0_f32;
    for constraint in constraint_refs {
        if !constraint.is_hard(plan) {
            worst = worst.max(constraint.project(places, plan, multipliers, mode, local));
        }
    }
    queue.heap.clear();
    queue.stamps.clear();
    queue.stamps.resize(constraint_refs.len(), 0);
    for (place, constraint) in constraint_refs.iter().enumerate() {
        let error = constraint.error(places, plan, local);
        worst = worst.max(error);
        queue.enter(place, error, tolerance);
    }
    let mut left = constraint_refs.len();
    while left > 0 {
        let Some((_, core::cmp::Reverse(place), stamp)) = queue.heap.pop() else { break };
        if queue.stamps[place as usize] != stamp {
            continue;
        }
        left -= 1;
        let constraint = constraint_refs[place as usize];
        constraint.project(places, plan, multipliers, mode, local);
        for &row in constraint.rows(plan, &mut pair) {
            let slot = queue.slots[row as usize] as usize;
            let (begin, end) = (queue.begins[slot], queue.begins[slot + 1]);
            for k in begin..end {
                let neighbour = queue.touching[k as usize] as usize;
                let error = constraint_refs[neighbour].error(places, plan, local);
                queue.enter(neighbour, error, tolerance);
            }
        }
    }
    worst
}

impl Queue {
    /// Lists the constraints of each particle of the island.
    fn connect(&mut self, plan: &Plan, island: &Island, constraint_refs: &[ConstraintRef]) {
        let Self { slots, begins, touching, .. } = self;
        let members = &plan.islands.members[island.members.clone()];
        slots.resize(plan.rows, 0);
        for (slot, &row) in members.iter().enumerate() {
            slots[row as usize] = slot as u32;
        }
        let mut pair = [0; 2];
        begins.clear();
        begins.resize(members.len() + 1, 0);
        for constraint in constraint_refs {
            for &row in constraint.rows(plan, &mut pair) {
                begins[slots[row as usize] as usize] += 1;
            }
        }
        // Prefix sums to the end of each list. Filling a list from its back then leaves `begins` at its beginning.
        let mut sum = 0;
        for begin in begins.iter_mut() {
            sum += *begin;
            *begin = sum;
        }
        touching.clear();
        touching.resize(sum as usize, 0);
        for (place, constraint) in constraint_refs.iter().enumerate().rev() {
            for &row in constraint.rows(plan, &mut pair) {
                let begin = &mut begins[slots[row as usize] as usize];
                *begin -= 1;
                touching[*begin as usize] = place as u32;
            }
        }
    }

    /// Enters the present error of a constraint. One within the tolerance is not queued.
    fn enter(&mut self, place: usize, error: f32, tolerance: f32) {
        self.stamps[place] += 1;
        if error > tolerance {
            let entry = (error.to_bits(), core::cmp::Reverse(place as u32), self.stamps[place]);
            self.heap.push(entry);
        }
    }
}
