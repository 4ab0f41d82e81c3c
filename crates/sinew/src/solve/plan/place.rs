//! Placement: computes the key of each constraint, which is its position in the plan.

use core::ops::Range;

use super::changes::{Added, list_of};
use super::clusters::{Clusters, Place};
use super::colours::{Colours, StrideCounts, Strides};
use super::keys::{Fields, Key, is_rod, rank_of, rank_of_kind};
use super::{GroupKind, Plan, PlanInput};
use crate::constraints::{Bound, Constraint, Distance};
use crate::islands::Island;
use crate::solve::rods;
use crate::union_find::UnionFind;

/// Scratch and state of compilation, kept to reuse its memory and for the next [incremental update](super::incremental).
#[derive(Clone, Debug, Default)]
pub(super) struct Compiling {
    pub(super) connected: UnionFind,
    /// The member index of each particle in its island.
    pub(super) slots: Vec<u32>,
    /// The valid distances of each island being compiled, by island, then in input order.
    pub(super) of_island: Vec<u32>,
    /// Where those of each of these islands begin, and where the last ones end.
    begins: Vec<u32>,
    /// Number of distances and constraints of the input.
    pub(super) given: [usize; 2],
    pub(super) colours: Colours,
    /// The strides of each island, for rods and for other distances; and scratch to count them in.
    pub(super) strides: Vec<[Strides; 2]>,
    pub(super) scratch: [StrideCounts; 2],
    /// The division into clusters of each island.
    pub(super) clusters: Vec<Clusters>,
    /// The greatest reach of a constraint of each island, in member indices.
    pub(super) reaches: Vec<u32>,
    /// The keys of all valid constraints, ascending.
    pub(super) keys: Vec<Key>,
}

impl Compiling {
    /// Records the size of an input whose valid constraints all have keys.
    pub(super) fn note(&mut self, given: &PlanInput) {
        self.given = [given.distances.len(), given.constraints.len()];
    }

    /// The input indices of the distances and of the constraints to compile, ascending: those with a key in an island from `kept` on, as far as they are valid,
    /// and those `added`. Removes their keys.
    pub(super) fn take_from(
        &mut self,
        kept: usize,
        given: &PlanInput,
        added: &[Added],
    ) -> [Vec<u32>; 2] {
        let first = self.keys.partition_point(|key| Fields::is_before(key.group, kept));
        let taken = self.keys.drain(first..).map(|key| (list_of(&key), key.number));
        let taken = taken.filter(|&(list, number)| given.is_valid(list, number as usize));
        let mut numbers = [Vec::new(), Vec::new()];
        taken.chain(added.iter().copied()).for_each(|(list, n)| numbers[list as usize].push(n));
        numbers.iter_mut().for_each(|numbers| numbers.sort_unstable());
        numbers
    }

    /// Computes the keys of the constraints with these input indices: all those of the islands from `kept` on.
    pub(super) fn place_from(
        &mut self,
        kept: usize,
        plan: &Plan,
        given: &PlanInput,
        numbers: &[Vec<u32>; 2],
    ) {
        self.number_slots(kept, plan);
        let [distances, constraints] = numbers;
        self.sort_by_island(kept, plan, (given.distances, distances));
        let first = self.keys.len();
        self.colours.reset(plan.rows, plan.islands.members_from(kept));
        self.clusters.truncate(kept);
        self.reaches.truncate(kept);
        self.reaches.resize(plan.islands.list.len(), 0);
        self.strides.truncate(kept);
        for (island, place) in (kept..plan.islands.list.len()).zip(0..) {
            let own = self.begins[place] as usize..self.begins[place + 1] as usize;
            self.place_distances(plan, given.distances, (island, own));
        }
        for &number in constraints {
            self.place_constraint(plan, &given.constraints[number as usize], number);
        }
        self.keys[first..].sort_unstable();
    }

    /// The position of a constraint among these particles, without its colour, and its first and last member index. Distances of a large island that cannot be
    /// swept in columns are placed in the last phase, so that the others can be: a character that wears a cape has some.
    pub(super) fn fields(
        &self,
        plan: &Plan,
        rows: &[u32],
        (rank, distance): (u32, Option<&Distance>),
    ) -> (Fields, (u32, u32)) {
        let island = plan.islands.of[rows[0] as usize];
        let ends = self.ends(rows);
        let last = distance.is_some_and(|d| !may_stride(d))
            && !plan.islands.list[island as usize].is_small();
        let place = self.clusters[island as usize].place(ends.0, ends.1);
        let Place { phase, cluster } = if last { Place::LAST } else { place };
        (Fields { island, rank, phase, cluster, colour: 0 }, ends)
    }

    /// The first and the last member index of some particles.
    pub(super) fn ends(&self, rows: &[u32]) -> (u32, u32) {
        let slots = || rows.iter().map(|&row| self.slots[row as usize]);
        (slots().min().unwrap_or(0), slots().max().unwrap_or(0))
    }

    fn number_slots(&mut self, kept: usize, plan: &Plan) {
        self.slots.resize(plan.rows, 0);
        for island in &plan.islands.list[kept..] {
            for (slot, &row) in (0..).zip(&plan.islands.members[island.members.clone()]) {
                self.slots[row as usize] = slot;
            }
        }
    }

    /// Sorts the distances of all but the first `kept` islands by island, in input order within each: a counting sort.
    fn sort_by_island(
        &mut self,
        kept: usize,
        plan: &Plan,
        (distances, numbers): (&[Distance], &[u32]),
    ) {
        let Self { begins, of_island, .. } = self;
        begins.clear();
        begins.resize(plan.islands.list.len() - kept + 1, 0);
        let place = |number: u32| {
            let row = distances[number as usize].a;
            plan.islands.of[row as usize] as usize - kept
        };
        for &number in numbers {
            begins[place(number)] += 1;
        }
        let mut sum = 0;
        for begin in begins.iter_mut() {
            sum += core::mem::replace(begin, sum);
        }
        of_island.clear();
        of_island.resize(numbers.len(), 0);
        for &number in numbers {
            let begin = &mut begins[place(number)];
            of_island[*begin as usize] = number;
            *begin += 1;
        }
        // Each entry has advanced to the beginning of the next island.
        begins.rotate_right(1);
        begins[0] = 0;
    }

    /// Computes the keys of an island's distances, given their range in `of_island`.
    fn place_distances(
        &mut self,
        plan: &Plan,
        distances: &[Distance],
        (island, places): (usize, Range<usize>),
    ) {
        let mut scratch = core::mem::take(&mut self.scratch);
        let numbers = self.of_island[places.clone()].iter();
        let all = numbers.map(|&number| &distances[number as usize]);
        let (clusters, strides) = self.examine(plan, island, all, &mut scratch);
        self.scratch = scratch;
        self.clusters.push(clusters);
        for place in places {
            let number = self.of_island[place];
            let d = &distances[number as usize];
            let rows = [d.a, d.b];
            let (fields, ends) = self.fields(plan, &rows, (rank_of(d), Some(d)));
            self.reaches[island] = self.reaches[island].max(ends.1 - ends.0);
            let phase = fields.phase;
            let (kind, row) = (kind_of(d), d.a.min(d.b));
            let strided = strides[kind as usize].colour(ends.0, ends.1).filter(|_| may_stride(d));
            let colour = match strided {
                Some((number, colour)) if self.colours.take_stride(kind, number, phase, row) => {
                    colour
                }
                _ => self.colours.greedy(kind, phase, &rows),
            };
            let group = Fields { colour, ..fields }.key();
            self.keys.push(Key { group, first: ends.0, number });
        }
        self.strides.push(strides);
    }

    /// The division into clusters and the strides of the island of these distances.
    pub(super) fn examine<'a>(
        &self,
        plan: &Plan,
        island: usize,
        distances: impl Iterator<Item = &'a Distance>,
        scratch: &mut [StrideCounts; 2],
    ) -> (Clusters, [Strides; 2]) {
        let Island { members, contiguous: run, .. } = &plan.islands.list[island];
        let run = run.start - members.start..run.end - members.start;
        scratch.iter_mut().for_each(StrideCounts::clear);
        let (mut count, mut reach) = (0, 0);
        for d in distances {
            let ends = self.ends(&[d.a, d.b]);
            (count, reach) = (count + 1, reach + u64::from(ends.1 - ends.0));
            let kind = kind_of(d);
            // Distances of small islands other than rods are solved in lanes of an instance batch, not in columns.
            if may_stride(d) && (kind == GroupKind::Rods || !plan.islands.list[island].is_small()) {
                scratch[kind as usize].add(ends);
            }
        }
        (
            Clusters::of(members.len(), run, count, reach),
            [0, 1].map(|kind| Strides::of(&scratch[kind])),
        )
    }

    /// Computes the key of a constraint.
    fn place_constraint(&mut self, plan: &Plan, constraint: &Constraint, number: u32) {
        let (fields, ends) =
            self.fields(plan, &constraint.rows, (rank_of_kind(&constraint.kind), None));
        let reach = &mut self.reaches[fields.island as usize];
        *reach = (*reach).max(ends.1 - ends.0);
        let colour = self.colours.greedy(GroupKind::Constraints, fields.phase, &constraint.rows);
        let group = Fields { colour, ..fields }.key();
        self.keys.push(Key { group, first: ends.0, number });
    }
}

/// The kind of group that a distance belongs to.
fn kind_of(d: &Distance) -> GroupKind {
    if is_rod(d) { GroupKind::Rods } else { GroupKind::Distances }
}

/// Whether a distance may get the colour of a stride and be swept in columns: a rod, or a two-sided compliant distance without damping. Damping needs the
/// positions at the start of the substep, which columns do not store.
pub(super) fn may_stride(d: &Distance) -> bool {
    is_rod(d) || (d.bound == Bound::Equal && rods::compliance(d).is_some())
}
