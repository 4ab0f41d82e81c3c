//! Incremental update of a plan after a few constraints were added or removed, without sorting and colouring all of them again.
//!
//! The result equals that of compiling from scratch, key by key, so a tick depends on the present constraints and not on their history. This is possible
//! because a colour depends on little: the colour of a stride on the place of the two particles alone, a greedy colour on the *earlier* constraints in the
//! input that share a particle. The update therefore recolours the added constraints, and those with an earlier neighbour that was added, removed or
//! recoloured, in input order until nothing changes any more. On a mesh that is a handful.
//!
//! Where more than colours would change (an island splits, merges with another, or gets other clusters or other strides), or where more than a few constraints
//! are affected, the plan is compiled again instead.

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use super::changes::{Added, Changes, List, Removed, list_of};
use super::colours::{GREEDY, OVERFLOW, StrideCounts, lowest};
use super::keys::{Fields, Key};
use super::place::{Compiling, may_stride};
use super::{GroupKind, Plan, PlanInput};
use crate::constraints::Rows;

/// Most constraints of an island that are recoloured before the update is given up.
const MAX_RECHECKS: usize = 64;

/// Depth of the search for whether the particles of a removed constraint are still connected, in constraints: it reaches two mesh cells beyond them.
const MAX_DEPTH: usize = 3;

/// An incremental update is not possible. The keys have been renumbered, but their colours are not up to date.
pub(super) struct Fault {
    /// How many islands at the beginning of the list are unchanged.
    pub(super) kept: usize,
    /// Constraints that have no key.
    pub(super) added: Vec<Added>,
}

/// Updates the keys after a few changes, with the number of particles unchanged. Returns the islands that changed, ascending.
pub(super) fn update_incrementally(
    plan: &Plan,
    compiling: &mut Compiling,
    (given, changes): (&PlanInput, &Changes),
) -> Result<Vec<u32>, Fault> {
    let mut keys = core::mem::take(&mut compiling.keys);
    let mut scratch = core::mem::take(&mut compiling.scratch);
    let (removed, added) = changes.renumber(&mut keys, given);
    let old = keys.len();
    let mut update = IncrementalUpdate {
        plan,
        compiling,
        given,
        keys: &mut keys,
        old,
        moved: Vec::new(),
        rechecks: BTreeSet::new(),
    };
    let updated = update.run(&removed, &added, &mut scratch);
    compiling.scratch = scratch;
    if updated.is_none() {
        keys.truncate(old);
    }
    compiling.keys = keys;
    updated.ok_or_else(|| {
        let first = removed.iter().map(|(key, _)| island_of(key)).min();
        Fault { kept: first.map_or(plan.islands.list.len(), |first| first as usize), added }
    })
}

/// A constraint to be recoloured. The order is that in which colours are assigned.
type Recheck = (GroupKind, u32);

struct IncrementalUpdate<'a> {
    plan: &'a Plan,
    compiling: &'a mut Compiling,
    given: &'a PlanInput<'a>,
    /// The existing keys, sorted except where a colour changed, followed by the added ones.
    keys: &'a mut Vec<Key>,
    /// Number of existing keys.
    old: usize,
    /// Indices of existing keys whose colour changed.
    moved: Vec<usize>,
    /// Constraints to be recoloured.
    rechecks: BTreeSet<Recheck>,
}

impl IncrementalUpdate<'_> {
    fn run(
        &mut self,
        removed: &[Removed],
        added: &[Added],
        scratch: &mut [StrideCounts; 2],
    ) -> Option<Vec<u32>> {
        for &(list, number) in added {
            let key = self.uncoloured(list, number)?;
            self.keys.push(key);
        }
        let concerned = removed.iter().map(|(key, _)| key).chain(&self.keys[self.old..]);
        let islands: BTreeSet<u32> = concerned.map(island_of).collect();
        let updated = islands.iter().all(|&island| self.update_island(island, removed, scratch));
        updated.then(|| {
            self.put_in_order();
            islands.into_iter().collect()
        })
    }

    /// Recolours the constraints of an island as required; false if the island's connectivity, clusters or strides changed, or too many constraints are
    /// affected.
    fn update_island(
        &mut self,
        island: u32,
        removed: &[Removed],
        scratch: &mut [StrideCounts; 2],
    ) -> bool {
        let removed = || removed.iter().filter(|(key, _)| island_of(key) == island);
        let connected = removed().all(|(_, rows)| self.are_connected(island, rows));
        if !connected || !self.is_cut_as_before(island, scratch) {
            return false;
        }
        self.rechecks.clear();
        let added = self.keys[self.old..].iter().filter(|key| island_of(key) == island);
        self.rechecks.extend(added.map(recheck));
        for (key, rows) in removed() {
            self.release(key, rows);
        }
        for _ in 0..MAX_RECHECKS {
            let Some(recheck) = self.rechecks.pop_first() else { return true };
            self.recolour(island, recheck);
        }
        false
    }

    /// The key of an added constraint, without a colour; `None` if it merges islands.
    fn uncoloured(&mut self, list: List, number: u32) -> Option<Key> {
        let (rows, rank) = self.given.rows_and_rank(list, number as usize);
        let distance = match list {
            List::Distances => self.given.distances.get(number as usize),
            List::Constraints => None,
        };
        let (fields, ends) = self.compiling.fields(self.plan, &rows, (rank, distance));
        let together = rows.iter().all(|&row| self.plan.islands.of[row as usize] == fields.island);
        let group = Fields { colour: UNCOLOURED, ..fields }.key();
        let reach = &mut self.compiling.reaches[fields.island as usize];
        *reach = (*reach).max(ends.1 - ends.0);
        together.then_some(Key { group, first: ends.0, number })
    }

    /// Whether the clusters and the strides of an island are unchanged.
    fn is_cut_as_before(&self, island: u32, scratch: &mut [StrideCounts; 2]) -> bool {
        let keys = self.of_island(island).map(|place| &self.keys[place]);
        let distances = keys.filter(|key| list_of(key) == List::Distances);
        let distances = distances.map(|key| &self.given.distances[key.number as usize]);
        let number = island as usize;
        let (clusters, strides) = self.compiling.examine(self.plan, number, distances, scratch);
        clusters == self.compiling.clusters[number] && strides == self.compiling.strides[number]
    }

    /// Indices of the keys of an island whose constraints share a particle with these rows.
    ///
    /// All keys of the island are scanned, but only few constraints are read: one that begins farther before a row than the greatest reach in the island cannot
    /// use it.
    fn around<'a>(&'a self, island: u32, rows: &'a [u32]) -> impl Iterator<Item = usize> + use<'a> {
        let (first, last) = self.compiling.ends(rows);
        let first = first.saturating_sub(self.compiling.reaches[island as usize]);
        self.of_island(island).filter(move |&place| {
            let key = &self.keys[place];
            (first..=last).contains(&key.first) && self.share(key, rows)
        })
    }

    /// Whether the particles of a removed constraint are still connected, within a few steps.
    fn are_connected(&self, island: u32, rows: &[u32]) -> bool {
        let mut reached: Vec<u32> = rows.first().copied().into_iter().collect();
        for _ in 0..MAX_DEPTH {
            if rows.iter().all(|row| reached.contains(row)) {
                return true;
            }
            let next = self.around(island, &reached);
            let next: Vec<u32> = next.flat_map(|place| self.rows(&self.keys[place])).collect();
            reached.extend(next);
            reached.sort_unstable();
            reached.dedup();
        }
        rows.iter().all(|row| reached.contains(row))
    }

    /// Queues the constraints that may take the colour of a removed one.
    fn release(&mut self, removed: &Key, rows: &[u32]) {
        let (colour, ends) = (colour_of(removed), self.compiling.ends(rows));
        let keys = self.around(island_of(removed), rows).map(|place| &self.keys[place]);
        let conflicting = keys.filter(|key| conflict(key, removed));
        let candidates = conflicting.filter(|key| {
            let lower = colour >= GREEDY && colour_of(key) > colour;
            lower || self.ends(key) == ends
        });
        self.rechecks.extend(candidates.map(recheck).collect::<Vec<_>>());
    }

    /// Assigns the required colour to a constraint, and queues those that may need another colour because of it.
    fn recolour(&mut self, island: u32, (kind, number): Recheck) {
        let list = if kind == GroupKind::Constraints { List::Constraints } else { List::Distances };
        let (rows, _) = self.given.rows_and_rank(list, number as usize);
        let own = |&place: &usize| recheck(&self.keys[place]) == (kind, number);
        let Some(mine) = self.around(island, &rows).find(own) else { return };
        let key = self.keys[mine];
        let (fields, ends) = (Fields::of(key.group), self.ends(&key));
        let may = |number: u32| may_stride(&self.given.distances[number as usize]);
        let may_stride = list == List::Distances && may(number);
        // Of two distances between the same particles, only the first gets the colour of their stride.
        let (mut taken, mut is_second, mut later) = (0_u64, false, Vec::new());
        for place in self.around(island, &rows).filter(|&place| place != mine) {
            let other = &self.keys[place];
            if !conflict(other, &key) {
                continue;
            }
            if other.number > number {
                later.push((colour_of(other), recheck(other)));
            } else {
                is_second |= may_stride && self.ends(other) == ends && may(other.number);
                taken |= bit(colour_of(other));
            }
        }
        let strides = self.compiling.strides[fields.island as usize].get(kind as usize);
        let strided =
            strides.filter(|_| may_stride && !is_second).and_then(|of| of.colour(ends.0, ends.1));
        let colour = strided.map_or_else(|| lowest(taken), |(_, colour)| colour);
        if colour == fields.colour {
            return;
        }
        self.keys[mine].group = Fields { colour, ..fields }.key();
        if mine < self.old {
            self.moved.push(mine);
        }
        // Those that have to give up this colour, and those that may move down to the previous one.
        later.retain(|&(theirs, _)| theirs == colour || theirs > fields.colour);
        self.rechecks.extend(later.into_iter().map(|(_, recheck)| recheck));
    }

    /// Moves the keys that are new or recoloured to their sorted places.
    fn put_in_order(&mut self) {
        let mut new = self.keys.split_off(self.old);
        self.moved.sort_unstable();
        self.moved.dedup();
        for &place in self.moved.iter().rev() {
            new.push(self.keys.remove(place));
        }
        for key in new {
            let place = self.keys.partition_point(|other| *other < key);
            self.keys.insert(place, key);
        }
    }

    /// Indices of the keys of an island, including the added ones.
    fn of_island(&self, island: u32) -> impl Iterator<Item = usize> + Clone + use<'_> {
        let old = &self.keys[..self.old];
        let begin = old.partition_point(|key| island_of(key) < island);
        let end = begin + old[begin..].partition_point(|key| island_of(key) == island);
        let added =
            (self.old..self.keys.len()).filter(move |&n| island_of(&self.keys[n]) == island);
        (begin..end).chain(added)
    }

    fn rows(&self, key: &Key) -> Rows {
        self.given.rows_and_rank(list_of(key), key.number as usize).0
    }

    fn ends(&self, key: &Key) -> (u32, u32) {
        self.compiling.ends(&self.rows(key))
    }

    /// Whether a constraint shares a particle with these rows.
    fn share(&self, key: &Key, rows: &[u32]) -> bool {
        match list_of(key) {
            List::Distances => {
                let d = &self.given.distances[key.number as usize];
                rows.contains(&d.a) || rows.contains(&d.b)
            }
            List::Constraints => {
                let own = &self.given.constraints[key.number as usize].rows;
                own.iter().any(|row| rows.contains(row))
            }
        }
    }
}

/// Placeholder colour of an added constraint: above all others. No key has it when the update is complete.
const UNCOLOURED: u32 = OVERFLOW + 1;

/// The bit of a greedy colour; 0 for any other colour.
fn bit(colour: u32) -> u64 {
    if (GREEDY..OVERFLOW).contains(&colour) { 1 << (colour - GREEDY) } else { 0 }
}

fn recheck(key: &Key) -> Recheck {
    (kind_of(key), key.number)
}

fn island_of(key: &Key) -> u32 {
    Fields::of(key.group).island
}

fn colour_of(key: &Key) -> u32 {
    Fields::of(key.group).colour
}

fn kind_of(key: &Key) -> GroupKind {
    Fields::of(key.group).kind()
}

/// Whether two constraints must have different colours if they share a particle.
fn conflict(one: &Key, other: &Key) -> bool {
    kind_of(one) == kind_of(other) && Fields::of(one.group).phase == Fields::of(other.group).phase
}
