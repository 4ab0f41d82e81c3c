//! The plan: constraints sorted into islands, and within an island into groups that a kernel solves as a whole. It is compiled when the topology changes, and
//! depends on the present constraints alone: a world with the same constraints has the same plan, and so the same bits, whatever was added and removed before.
//! After a few additions or removals the plan is [updated incrementally](incremental) to the same result, and the islands before the first changed one [are
//! kept](marks): spawning or despawning a body beside many large cloths costs in proportion to that body, not to the cloths.
//!
//! An **island** is a set of particles connected by constraints. Each island is swept independently until its constraints hold or its sweeps are used up. What
//! happens in one island never changes a bit in another, however many sweeps it takes.
//!
//! **Colours**: in the order in which a game adds constraints, each one waits for the particle that the previous one moved, and stiff cloth swept outwards from
//! its pins gains energy until it explodes. No two constraints of a colour share a particle, so a core can overlap them, eight lanes can solve them at once,
//! and the sweep has no preferred direction ([`colours`] computes them).
//!
//! **Clusters**: a body larger than a core's cache is swept cluster by cluster: all colours of one cluster before the next is loaded, and then the constraints
//! between neighbouring clusters ([`clusters`]). Clusters of one phase can be solved by several threads.
//!
//! A sweep goes through an island by rank, within a rank by phase and cluster, and within a cluster by colour. Ranks: soft and one-sided constraints first,
//! then hard rods, then rigid shapes. What comes later prevails, so bones keep their length where the limits of their joints conflict with it.

mod changes;
mod clusters;
mod colours;
mod cut;
mod incremental;
pub(super) mod instance_batches;
mod keys;
mod marks;
mod place;
mod rigid;
mod tasks;
#[cfg(test)]
mod tests;
mod tethers;

use core::ops::Range;

use super::chains::Chains;
use super::rods::Rods;
use super::tethers::Tethers;
use super::wide::{BatchRange, ConstraintBatches, LooseDistances};
use crate::constraints::{Constraint, Distance};
use crate::islands::{Island, Islands};
use crate::lanes::LANES;
use changes::Added;
pub(crate) use changes::{Change, Changes, List};
use instance_batches::InstanceBatches;
use keys::{Fields, Key};
use marks::Mark;
use place::Compiling;
pub(crate) use tasks::Task;

/// Distances and constraints in solving order, and the data that a sweep needs beside them. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// The distances, ordered by island and then by group.
    pub(crate) distances: Vec<Distance>,
    /// All other constraints, in the same order.
    pub(crate) constraints: Vec<Constraint>,
    /// The rods among the distances, in batches of eight lanes.
    pub(crate) rods: Rods,
    /// The other distances and constraints that have an eight-lane kernel.
    pub(crate) constraint_batches: ConstraintBatches,
    /// The soft distances that are swept in columns but are not part of a strided batch.
    pub(crate) loose_distances: LooseDistances,
    /// Groups of distances and constraints, in the order of a sweep.
    pub(crate) groups: Vec<ConstraintGroup>,
    /// The cluster batches that the groups form.
    pub(crate) cluster_batches: Vec<ClusterBatch>,
    /// Rows in the column-swept run of a large island that are used by cluster batches which are not swept in those columns; ascending within each batch.
    pub(crate) shared_rows: Vec<u32>,
    /// Units of work that threads may do in parallel.
    pub(crate) tasks: Vec<Task>,
    /// The islands.
    pub(crate) islands: Islands,
    /// Number of rows that the plan was compiled for.
    pub(crate) rows: usize,
    /// Islands of the same topology, solved side by side.
    pub(crate) instance_batches: InstanceBatches,
    /// Tethers: additional length limits between pins and what hangs on them.
    pub(crate) tethers: Tethers,
    /// Chains of rods, each solved directly.
    pub(super) chains: Chains,
    /// Lengths of the lists at the beginning of some islands, ascending.
    marks: Vec<Mark>,
    compiling: Compiling,
}

/// Constraints of one kind and one colour. No two share a particle, except in the overflow colour.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ConstraintGroup {
    /// Which list they are in, and which kernel solves them.
    pub(crate) kind: GroupKind,
    /// Their range in that list.
    pub(crate) range: Range<usize>,
    /// For rods: ranges among the plan's runs (strided batches, if swept in columns) and blocks. For soft distances swept in columns: strided batches and loose
    /// blocks.
    pub(crate) runs: Range<usize>,
    pub(crate) blocks: Range<usize>,
    /// For the others: their range among the constraint batches, if they have an eight-lane kernel and are not swept in columns.
    pub(crate) wide: Option<BatchRange>,
}

impl ConstraintGroup {
    /// Whether the group is a range of the plan's distances.
    pub(crate) fn has_distances(&self) -> bool {
        self.kind != GroupKind::Constraints
    }

    /// Ranges of its rods among the plan's runs and blocks.
    pub(crate) fn rods(&self) -> (&Range<usize>, &Range<usize>) {
        (&self.runs, &self.blocks)
    }
}

/// Groups of one rank, phase and cluster, swept one after the other. This is the unit of work of a thread.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClusterBatch {
    /// The kind of its groups.
    pub(crate) kind: GroupKind,
    /// Range of its groups in the plan.
    pub(crate) groups: Range<usize>,
    /// Rank and phase combined. Cluster batches of one island and one stage share no particle.
    pub(crate) stage: u32,
    /// Bounds of all rows that it uses.
    pub(crate) rows: Range<u32>,
    /// Whether it is swept in columns: rods or soft distances that are mostly strided, and numerous enough to pay for transposing the rows.
    pub(crate) columns: bool,
    /// Range in the plan's `shared_rows`: the rows that it uses in the run of its island. Empty where it is swept in the columns of that run itself.
    pub(crate) shared_rows: Range<usize>,
}

impl ClusterBatch {
    /// Whether it is swept in columns, lies in the given run of rows, and begins an even number of rows after the start of that run.
    pub(crate) fn is_within(&self, run: &Range<u32>) -> bool {
        let from = self.rows.start.checked_sub(run.start);
        let even = from.is_some_and(|from| from.is_multiple_of(2));
        self.columns && even && self.rows.end <= run.end
    }

    /// Whether it consists of rods that are swept in columns.
    pub(crate) fn has_rods_in_columns(&self) -> bool {
        self.columns && self.kind == GroupKind::Rods
    }
}

/// The kinds of groups. Each kind is coloured separately: a rod and a constraint of the same colour may share a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum GroupKind {
    /// Hard equality distances, solved by the shortest kernel.
    Rods,
    /// All other distances, solved by the general distance kernel.
    Distances,
    /// All other constraints, solved by their equations.
    Constraints,
}

/// Share of an island's constraints (numerator, denominator) that has to be swept in columns for its particles to stay in columns all the time. The remaining
/// constraints then read their particles from the columns and write them back.
const IN_COLUMNS: (usize, usize) = (7, 8);

/// The input of compilation.
#[derive(Clone, Copy)]
pub(crate) struct PlanInput<'a> {
    pub(crate) distances: &'a [Distance],
    pub(crate) constraints: &'a [Constraint],
    /// Number of rows.
    pub(crate) particles: usize,
}

impl Plan {
    /// Compiles the valid ones of the given distances and constraints. Reuses allocated memory.
    ///
    /// A pinned particle (infinite mass) belongs to the island of the constraints attached to it, and merges several into one.
    pub(crate) fn compile(&mut self, given: PlanInput) {
        self.compiling.keys.clear();
        self.compile_from(&given, 0, &given.valid_from([0, 0]));
    }

    /// Like [`compile`](Self::compile), where the first `same` distances and constraints are unchanged.
    pub(crate) fn compile_changed(&mut self, given: PlanInput, same: [usize; 2]) {
        let Compiling { keys, given: before, .. } = &mut self.compiling;
        // Constraints that were invalid at the last compilation may be valid now.
        if keys.len() < before.iter().sum() {
            return self.compile(given);
        }
        let was_there = |key: &Key| (key.number as usize) < same[changes::list_of(key) as usize];
        let mut kept = self.islands.list.len() as u32;
        let any_gone = same[0] < before[0] || same[1] < before[1];
        let first = if any_gone { keys.iter().position(|key| !was_there(key)) } else { None };
        if let Some(place) = first {
            kept = Fields::of(keys[place].group).island;
            let others = keys.split_off(place);
            keys.extend(others.into_iter().filter(was_there));
        }
        let gone = self.islands.of.get(given.particles..).unwrap_or(&[]);
        let kept = gone.iter().copied().fold(kept, u32::min) as usize;
        if self.marked_before(kept) == 0 {
            return self.compile(given);
        }
        self.compile_from(&given, kept, &given.valid_from(same));
    }

    /// Gives the result of [`compile`](Self::compile), incrementally where possible. The number of particles must not have changed.
    pub(crate) fn update(&mut self, given: PlanInput, changes: &Changes) {
        let mut compiling = core::mem::take(&mut self.compiling);
        let updated = incremental::update_incrementally(self, &mut compiling, (&given, changes));
        self.compiling = compiling;
        match updated {
            Ok(islands) => {
                self.compiling.note(&given);
                for &island in &islands {
                    let island = &mut self.islands.list[island as usize];
                    (island.tethers, island.spans, island.rod_graph) = (None, None, None);
                    island.tie_rods = None;
                }
                if let Some(&first) = islands.first() {
                    self.cut(&given, self.marked_before(first as usize));
                }
            }
            Err(incremental::Fault { kept, added }) => self.compile_from(&given, kept, &added),
        }
    }

    /// Compiles all but the first `kept` islands, from the constraints that have a key and from those `added`. No constraint of the kept islands may have
    /// changed. Where an added constraint connects to one of them, fewer islands are kept.
    fn compile_from(&mut self, given: &PlanInput, kept: usize, added: &[Added]) {
        let mut compiling = core::mem::take(&mut self.compiling);
        let old = &self.islands.of[..self.rows.min(given.particles)];
        let island = |&row: &u32| old.get(row as usize).map(|&island| island as usize);
        let kept = added.iter().fold(kept, |kept, &(list, number)| {
            let first = |rows: &[u32]| rows.iter().filter_map(island).min();
            given.on_rows(list, number, first).map_or(kept, |first| first.min(kept))
        });
        let kept = self.marked_before(kept);

        let numbers = compiling.take_from(kept, given, added);
        let connected = &mut compiling.connected;
        connected.isolate(self.islands.members_from(kept));
        connected.resize(given.particles);
        for list in [List::Distances, List::Constraints] {
            for &number in &numbers[list as usize] {
                given.on_rows(list, number, |rows| {
                    rows.iter().skip(1).for_each(|&row| connected.unite(rows[0], row));
                });
            }
        }
        self.rows = given.particles;
        self.islands.number(kept, connected);
        compiling.place_from(kept, self, given, &numbers);
        compiling.note(given);
        self.compiling = compiling;
        self.cut(given, kept);
    }

    /// The input indices of the plan's distances and of its constraints.
    pub(crate) fn numbers(&self) -> [Vec<u32>; 2] {
        let mut numbers = [Vec::new(), Vec::new()];
        for key in &self.compiling.keys {
            let constraint = keys::Fields::of(key.group).kind() == GroupKind::Constraints;
            numbers[usize::from(constraint)].push(key.number);
        }
        numbers
    }

    /// Copies the input in key order, beginning at the marked island `from`, and finds chains and instance batches.
    fn cut(&mut self, given: &PlanInput, from: usize) {
        self.cut_off(from);
        let keys = core::mem::take(&mut self.compiling.keys);
        let first = keys.partition_point(|key| Fields::is_before(key.group, from));
        self.take_in_order(given.distances, given.constraints, &keys[first..]);
        self.compiling.keys = keys;
        self.find_chains(from);
        let mut instance_batches = core::mem::take(&mut self.instance_batches);
        instance_batches.find(self);
        self.instance_batches = instance_batches;
        self.tethers.mark_stale();
        let Self { islands, groups, constraints, .. } = self;
        for island in &mut islands.list[from..] {
            let own = groups[island.groups.clone()].iter();
            let own = own.filter(|group| group.kind == GroupKind::Constraints);
            let mut own = own.flat_map(|group| constraints.get(group.range.clone()).unwrap_or(&[]));
            island.external = own.any(|one| !one.kind.equation().is_internal());
        }
    }

    /// The rows of the particles of island `number`, ascending.
    pub(crate) fn members(&self, number: usize) -> &[u32] {
        &self.islands.members[self.islands.list[number].members.clone()]
    }

    fn find_chains(&mut self, from: usize) {
        let Self { chains, islands: Islands { list, members, .. }, groups, distances, .. } = self;
        for island in &mut list[from..] {
            let groups = groups[island.groups.clone()].iter();
            let rods = groups.filter(|group| group.kind == GroupKind::Rods);
            let count = rods.clone().map(|group| group.range.len()).sum();
            let each = rods.flat_map(|group| group.range.clone());
            let each = each.map(|rod| (rod as u32, &distances[rod]));
            island.chains = chains.find(&members[island.members.clone()], count, each);
        }
    }

    /// The contiguous run of rows of an island, if the island is worth sweeping with that run in columns because nearly all of its constraints are there.
    pub(crate) fn fits_columns(&self, island: &Island) -> Option<Range<u32>> {
        let run = self.contiguous_rows(island);
        // Some rows beyond the last one are read and written back.
        let has_room = run.len().div_ceil(2) + 2 * LANES <= self.rods.half();
        (has_room && self.is_mostly_in_columns(island)).then_some(run)
    }

    /// Whether nearly all constraints of an island are in cluster batches that are swept in columns, within the island's contiguous run of rows.
    pub(crate) fn is_mostly_in_columns(&self, island: &Island) -> bool {
        let run = self.contiguous_rows(island);
        let (mut all, mut within) = (0, 0);
        for cluster_batch in &self.cluster_batches[island.cluster_batches.clone()] {
            let groups = &self.groups[cluster_batch.groups.clone()];
            let count = groups.iter().map(|group| group.range.len()).sum::<usize>();
            all += count;
            within += if cluster_batch.is_within(&run) { count } else { 0 };
        }
        within * IN_COLUMNS.1 >= all * IN_COLUMNS.0
    }

    /// The longest contiguous run of rows of an island.
    pub(crate) fn contiguous_rows(&self, island: &Island) -> Range<u32> {
        match self.islands.members.get(island.contiguous.clone()) {
            Some([first, .., last]) => *first..*last + 1,
            Some([one]) => *one..*one + 1,
            _ => 0..0,
        }
    }

    /// Whether none of an island's constraints is soft.
    pub(crate) fn is_hard(&self, island: &Island) -> bool {
        self.groups[island.groups.clone()].iter().all(|group| match group.kind {
            GroupKind::Rods => true,
            GroupKind::Distances => {
                self.distances[group.range.clone()].iter().all(|one| one.softness.is_hard())
            }
            GroupKind::Constraints => self.constraints[group.range.clone()]
                .iter()
                .all(|one| one.kind.equation().softness().is_hard()),
        })
    }

    /// The rows of an island's particles as contiguous ranges.
    pub(crate) fn runs(&self, island: &Island) -> impl Iterator<Item = Range<u32>> {
        // Shortcut: most islands are known to be one range.
        let one = (island.contiguous == island.members).then(|| self.contiguous_rows(island));
        let several = if one.is_some() { 0..0 } else { island.members.clone() };
        let members = self.islands.members.get(several).unwrap_or(&[]);
        let several = members.chunk_by(|one, next| one + 1 == *next);
        one.into_iter().chain(several.map(|run| run[0]..run[run.len() - 1] + 1))
    }

    /// The rows of an island's particles, if no other island's rows lie between them.
    pub(crate) fn stretch(&self, island: &Island) -> Option<Range<usize>> {
        let members = self.islands.members.get(island.members.clone())?;
        let (first, last) = (*members.first()? as usize, *members.last()? as usize);
        (last + 1 - first == members.len()).then_some(first..last + 1)
    }
}
