//! The plan: constraints sorted into islands, and within an island into groups that the kernels take as a whole. Compiled when the topology changes,
//! from the present constraints alone: whatever was added and removed before, the same world has the same plan, and so the same bits. Where few were
//! added or removed, it is [updated incrementally](incremental) instead, to what compiling would have given; and islands before the first that has changed
//! [stay](marks): what is spawned or despawned beside a hall full of cloth costs what it is, and not what stands there.
//!
//! An **island** is a set of particles that constraints connect. Each is swept until it holds, or its sweeps are spent, by itself: what happens
//! in one never changes a bit in another, however hard it works.
//!
//! **Colours**: in the order in which a game adds them, each constraint waits for the particle that the last one moved, and stiff cloth swept
//! outwards from its pins pumps up energy until it bursts. No two constraints of a colour share a particle: a core overlaps them, eight lanes
//! take them at once, and the sweep has no direction ([`colours`] finds them).
//!
//! **Clusters**: a body that is larger than a core's cache is swept cluster by cluster, all colours of one before the next is fetched, and then
//! what binds neighbouring clusters ([`clusters`]). Several threads may each take one.
//!
//! A sweep goes through an island by rank (what is soft or one-sided first, then the hard rods: bones have the last word over the limits of their
//! joints; rigid shapes after those), within a rank by phase and cluster, within a cluster by colour.

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
use super::wide::{ConstraintBatches, LooseDistances, Which};
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

/// The distances and constraints in solving order, and what a sweep needs beside them. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// The distances, island after island, group after group.
    pub(crate) distances: Vec<Distance>,
    /// All other constraints, in the same way.
    pub(crate) constraints: Vec<Constraint>,
    /// The rods among the distances, eight by eight.
    pub(crate) rods: Rods,
    /// The others that have a kernel for eight at a time.
    pub(crate) constraint_batches: ConstraintBatches,
    /// The soft distances that are swept in columns and are in no step.
    pub(crate) loose_distances: LooseDistances,
    /// The groups of all of them, in the order of a sweep.
    pub(crate) groups: Vec<ConstraintGroup>,
    /// The cluster batches that these make.
    pub(crate) cluster_batches: Vec<ClusterBatch>,
    /// What those that are not swept in the columns of a large island touch there: rows, ascending for each.
    pub(crate) shared_rows: Vec<u32>,
    /// What threads may do side by side.
    pub(crate) tasks: Vec<Task>,
    /// The islands.
    pub(crate) islands: Islands,
    /// How many rows it was compiled for.
    pub(crate) rows: usize,
    /// Islands that are built alike, to be solved side by side.
    pub(crate) instance_batches: InstanceBatches,
    /// What hangs on pins is held to them by these, besides.
    pub(crate) tethers: Tethers,
    /// Rods one behind the other, which are solved at once.
    pub(super) chains: Chains,
    /// How long the lists were where some of the islands begin, ascending.
    marks: Vec<Mark>,
    compiling: Compiling,
}

/// Constraints of one kind and one colour: no two share a particle, except in the overflow.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ConstraintGroup {
    /// Which list they are in, and which kernel serves them.
    pub(crate) kind: GroupKind,
    /// Where they are in that list.
    pub(crate) range: Range<usize>,
    /// Of rods: where they are among the plan's runs (or strided batches, in columns), and blocks. Of soft distances in columns: the same, and loose blocks.
    pub(crate) runs: Range<usize>,
    pub(crate) blocks: Range<usize>,
    /// Of others: where they are among its constraint batches, if those have a kernel for eight at a time, and are not in columns.
    pub(crate) wide: Option<Which>,
}

impl ConstraintGroup {
    /// Whether what is in it is of the plan's distances.
    pub(crate) fn has_distances(&self) -> bool {
        self.kind != GroupKind::Constraints
    }

    /// Where its rods are among the plan's runs and blocks.
    pub(crate) fn rods(&self) -> (&Range<usize>, &Range<usize>) {
        (&self.runs, &self.blocks)
    }
}

/// Groups of one rank, of one cluster in one phase, which are swept one after the other: what a thread takes at a time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClusterBatch {
    /// Which kind its groups are of.
    pub(crate) kind: GroupKind,
    /// Where they are among the plan's groups.
    pub(crate) groups: Range<usize>,
    /// Rank and phase. Cluster batches of one island and one stage share no particle.
    pub(crate) stage: u32,
    /// All rows that it touches are within these.
    pub(crate) rows: Range<u32>,
    /// Whether it is swept in columns: rods or soft distances, of which most are in runs, and enough of them to be worth turning the rows.
    pub(crate) columns: bool,
    /// Where the rows are among the plan's that it touches of the run of its island, if that is swept in columns and it is not.
    pub(crate) shared_rows: Range<usize>,
}

impl ClusterBatch {
    /// Whether it is swept in columns that begin where a run of rows does, and have all of that.
    pub(crate) fn is_within(&self, run: &Range<u32>) -> bool {
        let from = self.rows.start.checked_sub(run.start);
        let even = from.is_some_and(|from| from.is_multiple_of(2));
        self.columns && even && self.rows.end <= run.end
    }

    /// Whether it is of rods that are swept in columns.
    pub(crate) fn has_rods_in_columns(&self) -> bool {
        self.columns && self.kind == GroupKind::Rods
    }
}

/// The kinds of groups. Each has colours of its own: a rod and a constraint may have the same one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum GroupKind {
    /// Of the plan's distances, hard ones of equality, by the shortest kernel.
    Rods,
    /// Of the plan's distances, by the general kernel.
    Distances,
    /// Of the plan's constraints, by their equations.
    Constraints,
}

/// An island of whose constraints so large a share is swept in columns is swept with its particles in columns all the time: what the others touch is read
/// from there, and written back.
const IN_COLUMNS: (usize, usize) = (7, 8);

/// What a plan is compiled from.
#[derive(Clone, Copy)]
pub(crate) struct Given<'a> {
    pub(crate) distances: &'a [Distance],
    pub(crate) constraints: &'a [Constraint],
    /// How many rows there are.
    pub(crate) particles: usize,
}

impl Plan {
    /// Compiles the valid ones among some distances and constraints. Keeps its memory.
    ///
    /// A pinned particle (of infinite mass) belongs to the island of what hangs on it, and joins several into one.
    pub(crate) fn compile(&mut self, given: Given) {
        self.compiling.keys.clear();
        self.compile_from(&given, 0, &given.sound_from([0, 0]));
    }

    /// The same where so many distances and constraints, from the first on, are what they were.
    pub(crate) fn compile_changed(&mut self, given: Given, same: [usize; 2]) {
        let Compiling { keys, given: before, .. } = &mut self.compiling;
        // What was faulty may be in order now.
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
        self.compile_from(&given, kept, &given.sound_from(same));
    }

    /// Compiles as [`compile`](Self::compile) does, for as many particles as before, and where that can be without looking at everything again.
    pub(crate) fn keep_up(&mut self, given: Given, changes: &Changes) {
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

    /// Compiles all but the first `kept` islands: of what was there, that which has a key, and what was added. No constraint of those islands has
    /// changed, and what was added may tie something to them.
    fn compile_from(&mut self, given: &Given, kept: usize, added: &[Added]) {
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
        connected.part(self.islands.members_from(kept));
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

    /// The number, as given, of each distance and of each constraint of the plan.
    pub(crate) fn numbers(&self) -> [Vec<u32>; 2] {
        let mut numbers = [Vec::new(), Vec::new()];
        for key in &self.compiling.keys {
            let constraint = keys::Fields::of(key.group).kind() == GroupKind::Constraints;
            numbers[usize::from(constraint)].push(key.number);
        }
        numbers
    }

    /// Copies what was given in the order of its keys, from that of a marked island on, and finds what goes side by side.
    fn cut(&mut self, given: &Given, from: usize) {
        self.cut_off(from);
        let keys = core::mem::take(&mut self.compiling.keys);
        let first = keys.partition_point(|key| Fields::is_before(key.group, from));
        self.take_in_order(given.distances, given.constraints, &keys[first..]);
        self.compiling.keys = keys;
        self.find_chains(from);
        let mut instance_batches = core::mem::take(&mut self.instance_batches);
        instance_batches.find(self);
        self.instance_batches = instance_batches;
        self.tethers.expire();
        let Self { islands, groups, constraints, .. } = self;
        for island in &mut islands.list[from..] {
            let own = groups[island.groups.clone()].iter();
            let own = own.filter(|group| group.kind == GroupKind::Constraints);
            let mut own = own.flat_map(|group| constraints.get(group.range.clone()).unwrap_or(&[]));
            island.external = own.any(|one| !one.kind.equation().is_internal());
        }
    }

    /// The rows of the particles of the island of a number, ascending.
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

    /// The rows of an island that follow each other, if it is worth sweeping it with those in columns: where nearly all of its constraints are.
    pub(crate) fn fits_columns(&self, island: &Island) -> Option<Range<u32>> {
        let run = self.run(island);
        // Beyond the last row, some more are read, and written back.
        let has_room = run.len().div_ceil(2) + 2 * LANES <= self.rods.half();
        (has_room && self.is_mostly_in_columns(island)).then_some(run)
    }

    /// Whether nearly all constraints of an island are of cluster batches that are swept in columns, among its rows that follow each other.
    pub(crate) fn is_mostly_in_columns(&self, island: &Island) -> bool {
        let run = self.run(island);
        let (mut all, mut within) = (0, 0);
        for cluster_batch in &self.cluster_batches[island.cluster_batches.clone()] {
            let groups = &self.groups[cluster_batch.groups.clone()];
            let count = groups.iter().map(|group| group.range.len()).sum::<usize>();
            all += count;
            within += if cluster_batch.is_within(&run) { count } else { 0 };
        }
        within * IN_COLUMNS.1 >= all * IN_COLUMNS.0
    }

    /// Most of the rows of an island, which follow each other.
    pub(crate) fn run(&self, island: &Island) -> Range<u32> {
        match self.islands.members.get(island.run.clone()) {
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

    /// The rows of an island's particles, stretch by stretch.
    pub(crate) fn runs(&self, island: &Island) -> impl Iterator<Item = Range<u32>> {
        // Mostly it is known that there is one.
        let one = (island.run == island.members).then(|| self.run(island));
        let several = if one.is_some() { 0..0 } else { island.members.clone() };
        let members = self.islands.members.get(several).unwrap_or(&[]);
        let several = members.chunk_by(|one, next| one + 1 == *next);
        one.into_iter().chain(several.map(|run| run[0]..run[run.len() - 1] + 1))
    }

    /// The rows of an island's particles, where no other's are between them.
    pub(crate) fn stretch(&self, island: &Island) -> Option<Range<usize>> {
        let members = self.islands.members.get(island.members.clone())?;
        let (first, last) = (*members.first()? as usize, *members.last()? as usize);
        (last + 1 - first == members.len()).then_some(first..last + 1)
    }
}
