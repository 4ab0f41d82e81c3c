//! An incrementally updated plan equals the plan that compiling from scratch gives.

use super::super::Distance;
use super::super::changes::{Change, MAX_CHANGES};
use super::super::tests::bend;
use super::*;
use crate::constraints::{Bound, Constraint};
use crate::test_random::Random;

/// The input lists of a world, and their changes since the last update.
#[derive(Clone, Default)]
struct Lists {
    distances: Vec<Distance>,
    constraints: Vec<Constraint>,
    particles: usize,
    changes: Changes,
}

impl Lists {
    /// A grid with rods along its edges and one diagonal each, ropes across every second cell, and bends over every third edge.
    fn grid(side: u32) -> Self {
        let mut lists = Self { particles: (side * side) as usize, ..Self::default() };
        let at = |x: u32, y: u32| y * side + x;
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let mut tie = |dx: u32, dy: u32, bound: Bound| {
                if x + dx < side && y + dy < side {
                    let rod = Distance::new(at(x, y), at(x + dx, y + dy), 1.0);
                    lists.distances.push(Distance { bound, ..rod });
                }
            };
            tie(1, 0, Bound::Equal);
            tie(0, 1, Bound::Equal);
            tie(1, 1, Bound::Equal);
            if x % 2 == 0 {
                tie(2, 1, Bound::AtMost);
            }
            if x % 3 == 0 && x + 1 < side && y + 1 < side {
                let rows = [at(x, y), at(x + 1, y + 1), at(x + 1, y), at(x, y + 1)];
                lists.constraints.push(bend(rows));
            }
        }
        lists
    }

    /// Cloth: a grid with rods along its edges and one diagonal each, and soft distances to the second neighbour.
    fn woven(side: u32) -> Self {
        let mut lists = Self { particles: (side * side) as usize, ..Self::default() };
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let mut tie = |dx: u32, dy: u32, compliance: f32| {
                if x + dx < side && y + dy < side {
                    let (a, b) = (y * side + x, (y + dy) * side + x + dx);
                    lists.distances.push(Distance::new(a, b, 1.0).with_compliance(compliance));
                }
            };
            tie(1, 0, 0.0);
            tie(0, 1, 0.0);
            tie(1, 1, 0.0);
            tie(2, 0, 1.0);
            tie(0, 2, 1.0);
        }
        lists
    }

    /// A mesh in no particular order: rods between random particles that are not far apart.
    fn tangle(particles: usize, rods: usize) -> Self {
        let mut random = Random::new(1);
        let mut lists = Self { particles, ..Self::default() };
        for _ in 0..rods {
            let a = random.below(particles);
            let b = (a + 1 + random.below(9)) % particles;
            lists.distances.push(Distance::new(a as u32, b as u32, 1.0));
        }
        lists
    }

    fn given(&self) -> PlanInput<'_> {
        let Self { distances, constraints, particles, .. } = self;
        PlanInput { distances, constraints, particles: *particles }
    }

    fn compiled(&self) -> Plan {
        let mut plan = Plan::default();
        plan.compile(self.given());
        plan
    }

    fn remove_distance(&mut self, at: usize) {
        let d = self.distances.remove(at);
        let rows = Rows::from_slice(&[d.a, d.b]);
        self.changes.note(Change::Removed(List::Distances, at, rows));
    }

    fn insert_distance(&mut self, at: usize, distance: Distance) {
        self.distances.insert(at, distance);
        self.changes.note(Change::Added(List::Distances, at));
    }

    fn remove_constraint(&mut self, at: usize) {
        let rows = self.constraints.remove(at).rows;
        self.changes.note(Change::Removed(List::Constraints, at, rows));
    }

    fn insert_constraint(&mut self, at: usize, constraint: Constraint) {
        self.constraints.insert(at, constraint);
        self.changes.note(Change::Added(List::Constraints, at));
    }

    /// One random change.
    fn change(&mut self, random: &mut Random) {
        let distances = self.distances.len();
        match random.below(5) {
            0 | 1 if distances > 0 => self.remove_distance(random.below(distances)),
            2 if !self.constraints.is_empty() => {
                self.remove_constraint(random.below(self.constraints.len()));
            }
            3 => {
                let corner = random.below(self.particles - 8) as u32;
                let rows = [corner, corner + 1, corner + 2, corner + 7];
                self.insert_constraint(random.below(self.constraints.len() + 1), bend(rows));
            }
            _ => {
                let (a, far) = (random.below(self.particles - 12), 1 + random.below(11));
                let (bound, rest) = match random.below(8) {
                    0 => (Bound::AtMost, 1.0),
                    // An invalid one, which has an index and no key.
                    1 => (Bound::Equal, f32::NAN),
                    _ => (Bound::Equal, 2.0),
                };
                let compliance = if random.below(4) == 0 { 1.0 } else { 0.0 };
                let rod = Distance::new(a as u32, (a + far) as u32, rest);
                let rod = rod.with_compliance(compliance);
                self.insert_distance(random.below(distances + 1), Distance { bound, ..rod });
            }
        }
    }
}

/// Updates a plan and checks that it equals a compilation from scratch; returns whether the incremental update succeeded.
fn update(plan: &mut Plan, lists: &mut Lists) -> bool {
    let mut compiling = core::mem::take(&mut plan.compiling);
    let (given, changes) = (lists.given(), &lists.changes);
    let few = changes.are_few();
    let updated = few.then(|| update_incrementally(plan, &mut compiling, (&given, changes)));
    plan.compiling = compiling;
    let incremental = matches!(updated, Some(Ok(_)));
    match updated {
        Some(Ok(islands)) => {
            let first = islands.first().map_or(0, |&first| plan.marked_before(first as usize));
            plan.cut(&given, first);
        }
        Some(Err(Fault { kept, added })) => plan.compile_from(&given, kept, &added),
        None => plan.compile_changed(given, changes.same()),
    }
    plan.compiling.note(&given);
    let fresh = lists.compiled();
    assert!(plan.compiling.keys == fresh.compiling.keys, "keys differ");
    assert_eq!(plan.distances, fresh.distances);
    assert_eq!(plan.groups, fresh.groups);
    assert_eq!(plan.cluster_batches, fresh.cluster_batches);
    assert_eq!(plan.shared_rows, fresh.shared_rows);
    assert_eq!(plan.islands.list, fresh.islands.list);
    assert_eq!(plan.tasks, fresh.tasks);
    lists.changes.clear();
    incremental
}

#[test]
fn a_tear_in_a_grid_is_updated_incrementally_wherever_it_is() {
    for whole in [Lists::grid(24), Lists::woven(24)] {
        let plan = whole.compiled();
        for at in (0..whole.distances.len()).step_by(7) {
            let (mut lists, mut plan) = (whole.clone(), plan.clone());
            lists.remove_distance(at);
            assert!(update(&mut plan, &mut lists), "distance {at}");
        }
        for at in (0..whole.constraints.len()).step_by(5) {
            let (mut lists, mut plan) = (whole.clone(), plan.clone());
            lists.remove_constraint(at);
            assert!(update(&mut plan, &mut lists), "constraint {at}");
        }
    }
}

#[test]
fn five_hundred_changes_one_after_the_other_leave_the_plan_of_what_is_left() {
    // No constraint of cloth reaches as far along a row as some of the random ones, whose removal can split an island.
    let all = [(Lists::grid(24), 50), (Lists::woven(24), 100), (Lists::tangle(600, 2400), 100)];
    let afresh = all.map(|(mut lists, most)| {
        let (mut plan, mut random, mut afresh) = (lists.compiled(), Random::new(2), 0);
        for _ in 0..500 {
            for _ in 0..=random.below(3) {
                lists.change(&mut random);
            }
            afresh += i32::from(!update(&mut plan, &mut lists));
        }
        (afresh, most)
    });
    assert!(afresh.iter().all(|(own, most)| own < most), "not incremental and most: {afresh:?}");
}

#[test]
fn what_falls_apart_or_grows_together_is_compiled_afresh() {
    let rope = |first: u32| (first..first + 9).map(|a| Distance::new(a, a + 1, 1.0));
    let mut lists = Lists { particles: 20, ..Lists::default() };
    lists.distances = rope(0).chain(rope(10)).collect();
    let mut plan = lists.compiled();
    let mut torn = lists.clone();
    torn.remove_distance(4);
    assert!(!update(&mut plan.clone(), &mut torn));
    let mut tied = lists.clone();
    tied.insert_distance(18, Distance::new(9, 10, 1.0));
    assert!(!update(&mut plan.clone(), &mut tied));
    // Replacing a rod by one of another length is no tear: the same two particles are connected again.
    lists.remove_distance(4);
    lists.insert_distance(4, Distance::new(4, 5, 2.0));
    assert!(update(&mut plan, &mut lists));
}

#[test]
fn a_duplicate_takes_over_the_colour_of_the_stride() {
    let mut lists = Lists::grid(24);
    let mut plan = lists.compiled();
    let duplicate = lists.distances[100];
    lists.insert_distance(lists.distances.len(), duplicate);
    assert!(update(&mut plan, &mut lists));
    lists.remove_distance(100);
    assert!(update(&mut plan, &mut lists));
    lists.insert_distance(0, duplicate);
    assert!(update(&mut plan, &mut lists));
}

#[test]
fn more_than_a_few_changes_are_compiled_afresh() {
    let mut lists = Lists::grid(24);
    let mut plan = lists.compiled();
    (0..=MAX_CHANGES).for_each(|at| lists.remove_distance(3 * at));
    assert!(!update(&mut plan, &mut lists));
}
