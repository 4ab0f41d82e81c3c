//! The plan: constraints sorted into islands, and within an island into groups that the kernels take as a whole. Compiled when the topology changes, from
//! the present constraints alone: whatever came and went before, the same world has the same plan, and so the same bits.
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

mod clusters;
mod colours;
mod islands;
mod keys;
mod tasks;
#[cfg(test)]
mod tests;

use core::ops::Range;

use super::flock::Flocks;
use super::rods::Rods;
use super::wide::{Laws, Which};
use crate::constraints::{Bound, Constraint, Distance, Law};
use crate::solve::SolverSettings;
use clusters::{Clusters, PHASES, Place};
use colours::{Colours, Strides};
use islands::Connected;
use keys::{DISTANCES, Fields, Key, RIGID, RODS};

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
    pub(crate) laws: Laws,
    /// The groups of all of them, in the order of a sweep.
    pub(crate) groups: Vec<Group>,
    /// The bundles that these make.
    pub(crate) bundles: Vec<Bundle>,
    /// What threads may do side by side.
    pub(crate) tasks: Vec<Task>,
    /// The islands, in the order of their first particles. Every particle is in one.
    pub(crate) islands: Vec<Island>,
    /// The rows of the particles, island after island, ascending in each.
    pub(crate) members: Vec<u32>,
    /// The number of each particle's island.
    pub(crate) island_of: Vec<u32>,
    /// How many rows it was compiled for.
    pub(crate) rows: usize,
    /// Islands that are built alike, to be solved side by side.
    pub(crate) flocks: Flocks,
    compiling: Compiling,
}

/// Constraints of one kind and one colour: no two share a particle, except in the overflow.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group {
    /// Which list they are in, and which kernel serves them.
    pub(crate) kind: Kind,
    /// Where they are in that list.
    pub(crate) range: Range<usize>,
    /// Of rods: where they are among the plan's runs (or eights, in columns), and blocks.
    pub(crate) runs: Range<usize>,
    pub(crate) blocks: Range<usize>,
    /// Of others: where they are among its laws, if those have a kernel for eight at a time.
    pub(crate) wide: Option<Which>,
}

/// Groups of one rank, of one cluster in one phase, which are swept one after the other: what a thread takes at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Bundle {
    /// Where they are among the plan's groups.
    pub(crate) groups: Range<usize>,
    /// Rank and phase. Bundles of one island and one stage share no particle.
    pub(crate) stage: u32,
    /// All rows that it touches are within these.
    pub(crate) rows: Range<u32>,
    /// Whether it is swept in columns: rods, of which most are in runs, and enough of them to be worth turning the rows.
    pub(crate) columns: bool,
}

/// The kinds of groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Of the plan's constraints, by their equations.
    Constraints,
    /// Of the plan's distances, by the general kernel.
    Distances,
    /// Of the plan's distances, hard ones of equality, by the shortest kernel.
    Rods,
}

/// Particles that constraints connect, and those constraints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Island {
    /// Where its groups are among the plan's.
    pub(crate) groups: Range<usize>,
    /// Where its bundles are.
    pub(crate) bundles: Range<usize>,
    /// Where its particles are among the plan's members.
    pub(crate) members: Range<usize>,
    /// Whether a compound in it moves as an explicit rigid body, which keeps its own momenta.
    pub(crate) rigid: bool,
    /// Whether nothing outside holds it in this step: its constraints are among its own particles, of which none is pinned.
    pub(crate) free: bool,
    /// Whether it sleeps through this step.
    pub(crate) asleep: bool,
    /// How it is solved in this step: the world's settings, and those of the bodies in it.
    pub(crate) settings: SolverSettings,
}

/// What compiling needs; kept for its memory.
#[derive(Clone, Debug, Default)]
struct Compiling {
    connected: Connected,
    /// The place of each particle among the members of its island.
    slots: Vec<u32>,
    /// The sound distances of each island, island after island, in the order given.
    of_island: Vec<u32>,
    /// Where those of each island begin, and where the last end.
    begins: Vec<u32>,
    colours: Colours,
    strides: Strides,
    /// The clusters of each island.
    clusters: Vec<Clusters>,
    keys: Vec<Key>,
}

impl Plan {
    /// Compiles the valid ones among `distances` and `constraints`, for `particles` rows. Keeps its memory.
    ///
    /// A pinned particle (of infinite mass) belongs to the island of what hangs on it, and joins several into one.
    pub(crate) fn compile(
        &mut self,
        distances: &[Distance],
        constraints: &[Constraint],
        particles: usize,
    ) {
        self.rows = particles;
        let mut compiling = core::mem::take(&mut self.compiling);
        let sound: Vec<bool> = constraints.iter().map(|c| c.fault(particles).is_none()).collect();
        let kept = || distances.iter().zip(0..).filter(|(d, _)| d.fault(particles).is_none());
        let bound = || constraints.iter().zip(0..).zip(&sound).filter(|(_, sound)| **sound);

        let connected = &mut compiling.connected;
        connected.reset(particles);
        for (d, _) in kept() {
            connected.unite(d.a, d.b);
        }
        for ((c, _), _) in bound() {
            c.rows.iter().for_each(|&row| connected.unite(c.rows[0], row));
        }
        connected.number(&mut self.islands, &mut self.island_of, &mut self.members);
        compiling.number_slots(self);
        compiling.sort_by_island(self, kept(), distances.len());

        compiling.keys.clear();
        compiling.colours.reset(particles);
        compiling.clusters.clear();
        for island in 0..self.islands.len() {
            compiling.place_distances(self, distances, island);
        }
        for ((constraint, number), _) in bound() {
            compiling.place_constraint(self, constraint, number);
        }
        compiling.keys.sort_unstable();
        self.take_in_order(distances, constraints, &compiling.keys);
        let mut flocks = core::mem::take(&mut self.flocks);
        flocks.find(self);
        self.flocks = flocks;
        self.compiling = compiling;
    }

    /// Copies the constraints in the order of their keys, and cuts them into bundles and groups.
    fn take_in_order(&mut self, distances: &[Distance], constraints: &[Constraint], keys: &[Key]) {
        self.distances.clear();
        self.constraints.clear();
        self.groups.clear();
        self.bundles.clear();
        self.rods.clear();
        self.laws.clear();
        self.islands.iter_mut().for_each(|island| (island.groups, island.bundles) = (0..0, 0..0));
        for keys in
            keys.chunk_by(|one, other| Fields::bundle(one.group) == Fields::bundle(other.group))
        {
            let found = Fields::of(keys[0].group);
            let island = &mut self.islands[found.island as usize];
            if island.bundles.is_empty() {
                island.groups = self.groups.len()..self.groups.len();
                island.bundles = self.bundles.len()..self.bundles.len();
            }
            let first = self.groups.len();
            let stage = found.rank * PHASES + found.phase;
            // Rows before this bundle's may be turned with it, but not those of another one of its stage, or of another island.
            let begin = match self.bundles.last().filter(|_| !island.bundles.is_empty()) {
                Some(last) if last.stage == stage => last.rows.end,
                _ => self.members[island.members.start],
            };
            let (rows, columns) = self.take_bundle(distances, constraints, keys, found, begin);
            let groups = first..self.groups.len();
            let island = &mut self.islands[found.island as usize];
            (island.groups.end, island.bundles.end) = (groups.end, island.bundles.end + 1);
            self.bundles.push(Bundle { groups, stage, rows, columns });
        }
        self.tasks = tasks::cut(self);
    }

    /// Copies the constraints of one bundle, group by group; returns within which rows they are, and whether they are to be swept in columns.
    fn take_bundle(
        &mut self,
        distances: &[Distance],
        constraints: &[Constraint],
        keys: &[Key],
        found: Fields,
        first: u32,
    ) -> (Range<u32>, bool) {
        let kind = found.kind();
        let (mut rows, alone) = (Range { start: u32::MAX, end: 0 }, colours::OVERFLOW);
        let mut reach = |row: u32| rows = rows.start.min(row)..rows.end.max(row + 1);
        let numbers = keys.iter().map(|key| key.number as usize);
        let mut begin = if kind == Kind::Constraints {
            let begin = self.constraints.len();
            self.constraints.extend(numbers.map(|number| constraints[number].clone()));
            self.constraints[begin..].iter().flat_map(|c| &c.rows).for_each(|&row| reach(row));
            begin
        } else {
            let begin = self.distances.len();
            self.distances.extend(numbers.map(|number| distances[number]));
            self.distances[begin..].iter().flat_map(|d| [d.a, d.b]).for_each(reach);
            begin
        };
        // Of strides, nearly all are in runs. Gathering from columns costs thrice what it costs packed, running a third.
        let strided = |key: &&Key| Fields::of(key.group).colour < colours::GREEDY;
        let running = keys.iter().filter(strided).count();
        let columns =
            kind == Kind::Rods && running * 4 >= keys.len() * 3 && rows.len() <= 2 * keys.len();
        if columns {
            // Strides are mostly even numbers: where the island's rows begin a line of the cache, most eights do.
            let origin = self.members[self.islands[found.island as usize].members.start];
            rows.start -= (rows.start - origin) % 32;
            rows.start = rows.start.max(first);
        }
        for run in keys.chunk_by(|one, other| one.group == other.group) {
            let range = begin..begin + run.len();
            begin = range.end;
            let alone = Fields::of(run[0].group).colour == alone;
            let (mut runs, mut blocks, mut wide) = (0..0, 0..0, None);
            match kind {
                Kind::Rods if columns => {
                    let rods = &self.distances[range.clone()];
                    (runs, blocks) = self.rods.add_to_columns(rods, alone, &rows);
                }
                Kind::Rods => {
                    (runs, blocks) = self.rods.add(&self.distances[range.clone()], alone);
                }
                Kind::Distances => {
                    wide = Some(self.laws.add_distances(&self.distances[range.clone()], alone));
                }
                Kind::Constraints => {
                    wide = self.laws.add(&self.constraints[range.clone()], alone);
                }
            }
            self.groups.push(Group { kind, range, runs, blocks, wide });
        }
        (rows, columns)
    }
}

impl Compiling {
    fn number_slots(&mut self, plan: &Plan) {
        self.slots.resize(plan.rows, 0);
        for island in &plan.islands {
            for (slot, &row) in (0..).zip(&plan.members[island.members.clone()]) {
                self.slots[row as usize] = slot;
            }
        }
    }

    /// Lists the sound distances island by island, in the order given: a counting sort.
    fn sort_by_island<'a>(
        &mut self,
        plan: &Plan,
        kept: impl Iterator<Item = (&'a Distance, u32)> + Clone,
        most: usize,
    ) {
        let Self { begins, of_island, .. } = self;
        begins.clear();
        begins.resize(plan.islands.len() + 1, 0);
        let island = |d: &Distance| plan.island_of[d.a as usize] as usize;
        for (d, _) in kept.clone() {
            begins[island(d)] += 1;
        }
        let mut sum = 0;
        for begin in begins.iter_mut() {
            sum += core::mem::replace(begin, sum);
        }
        of_island.clear();
        of_island.resize(most, 0);
        for (d, number) in kept {
            let begin = &mut begins[island(d)];
            of_island[*begin as usize] = number;
            *begin += 1;
        }
        // Each begin has moved on to where the next one was.
        begins.rotate_right(1);
        begins[0] = 0;
    }

    /// Gives each distance of an island its key.
    fn place_distances(&mut self, plan: &Plan, distances: &[Distance], island: usize) {
        let Self { slots, of_island, begins, colours, strides, clusters, keys, .. } = self;
        let numbers = &of_island[begins[island] as usize..begins[island + 1] as usize];
        let ends = |number: u32| {
            let d = &distances[number as usize];
            let (a, b) = (slots[d.a as usize], slots[d.b as usize]);
            (a.min(b), a.max(b))
        };
        let is_rod = |number: u32| {
            let d = &distances[number as usize];
            d.softness.is_hard() && d.bound == Bound::Equal
        };
        let members = plan.islands[island].members.len();
        let own = Clusters::of(members, numbers.iter().map(|&number| ends(number)));
        strides.find(numbers.iter().filter(|&&number| is_rod(number)).map(|&number| ends(number)));
        clusters.push(own);
        for &number in numbers {
            let d = &distances[number as usize];
            let (a, b) = ends(number);
            let Place { phase, cluster } = own.place(a, b);
            let (rank, colour) = if is_rod(number) {
                let strided = strides.colour(a, b, phase, d.a.min(d.b), colours);
                (RODS, strided.unwrap_or_else(|| colours.rod(phase, &[d.a, d.b])))
            } else {
                (DISTANCES, colours.distance(phase, &[d.a, d.b]))
            };
            let fields = Fields { island: island as u32, rank, phase, cluster, colour };
            keys.push(Key { group: fields.key(), first: a, number });
        }
    }

    /// Gives a constraint its key.
    fn place_constraint(&mut self, plan: &Plan, constraint: &Constraint, number: u32) {
        let island = plan.island_of[constraint.rows[0] as usize];
        let slots = || constraint.rows.iter().map(|&row| self.slots[row as usize]);
        let (first, last) = (slots().min().unwrap_or(0), slots().max().unwrap_or(0));
        let Place { phase, cluster } = self.clusters[island as usize].place(first, last);
        let rigid = matches!(constraint.law, Law::Rigid(_));
        let rank = if rigid { RIGID } else { constraint.law.rank() };
        let colour = self.colours.law(phase, &constraint.rows);
        let fields = Fields { island, rank, phase, cluster, colour };
        self.keys.push(Key { group: fields.key(), first, number });
    }
}
