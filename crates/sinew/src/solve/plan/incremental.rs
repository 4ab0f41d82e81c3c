//! Incremental update of a plan after a few constraints were added or removed, without sorting and colouring all of them again.
//!
//! What comes of it is what compiling would have given, key by key, so that the result of a tick depends on what is there and not on what was. That
//! is possible because a colour depends on little: one by a stride on the place of its particles alone, a greedy one on the constraints given
//! *before* it that share a particle with it. So those that were added, and those whose earlier neighbours were added, removed or recoloured, are
//! looked at again in the order given, until nothing changes any more; on a mesh that is a handful.
//!
//! Where more would change than colours (an island falls apart or grows together with another one, is cut into other clusters, or gets other
//! strides), or more than a few are concerned, nothing is updated, and the plan is compiled afresh.

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use super::changes::{Added, Changes, List, Removed, list_of};
use super::colours::{GREEDY, OVERFLOW, StrideCounts, lowest};
use super::keys::{Fields, Key};
use super::place::{Compiling, may_stride};
use super::{Given, GroupKind, Plan};
use crate::constraints::Rows;

/// So many may be looked at again.
const RECHECKS: usize = 64;

/// So far from a constraint that was removed it is looked whether its particles are still connected: beyond them two of the cells of a mesh.
const ROUNDS: usize = 3;

/// It takes more than an incremental update: keys have the numbers of what they are of, and not their colours.
pub(super) struct Fault {
    /// So many islands, from the first on, are what they were.
    pub(super) kept: usize,
    /// What has no key.
    pub(super) added: Vec<Added>,
}

/// Brings the keys up to date after few changes of as many particles, and says which islands have changed, ascending.
pub(super) fn update_incrementally(
    plan: &Plan,
    compiling: &mut Compiling,
    (given, changes): (&Given, &Changes),
) -> Result<Vec<u32>, Fault> {
    let mut keys = core::mem::take(&mut compiling.keys);
    let mut scratch = core::mem::take(&mut compiling.scratch);
    let (removed, added) = changes.renumber(&mut keys, given);
    let old = keys.len();
    let mut mending = IncrementalUpdate {
        plan,
        compiling,
        given,
        keys: &mut keys,
        old,
        moved: Vec::new(),
        rechecks: BTreeSet::new(),
    };
    let mended = mending.run(&removed, &added, &mut scratch);
    compiling.scratch = scratch;
    if mended.is_none() {
        keys.truncate(old);
    }
    compiling.keys = keys;
    mended.ok_or_else(|| {
        let first = removed.iter().map(|(key, _)| island_of(key)).min();
        Fault { kept: first.map_or(plan.islands.list.len(), |first| first as usize), added }
    })
}

/// One to be looked at again. They are, in the order in which colours are given.
type Recheck = (GroupKind, u32);

struct IncrementalUpdate<'a> {
    plan: &'a Plan,
    compiling: &'a mut Compiling,
    given: &'a Given<'a>,
    /// Those there were, sorted but for colours that changed; behind them those that were added.
    keys: &'a mut Vec<Key>,
    /// How many there were.
    old: usize,
    /// Which of them got another colour.
    moved: Vec<usize>,
    /// Who is to be looked at again.
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
        let mended = islands.iter().all(|&island| self.update_island(island, removed, scratch));
        mended.then(|| {
            self.put_in_order();
            islands.into_iter().collect()
        })
    }

    /// Gives the constraints of an island the colours that they have to have; false if it is not what it was.
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
            self.free(key, rows);
        }
        for _ in 0..RECHECKS {
            let Some(recheck) = self.rechecks.pop_first() else { return true };
            self.recolour(island, recheck);
        }
        false
    }

    /// The key of one that was added, without a colour; `None` if it joins islands.
    fn uncoloured(&mut self, list: List, number: u32) -> Option<Key> {
        let (rows, rank) = self.given.rows_and_rank(list, number as usize);
        let distance = match list {
            List::Distances => self.given.distances.get(number as usize),
            List::Constraints => None,
        };
        let (fields, ends) = self.compiling.fields(self.plan, &rows, (rank, distance));
        let together = rows.iter().all(|&row| self.plan.islands.of[row as usize] == fields.island);
        let group = Fields { colour: UNKNOWN, ..fields }.key();
        let reach = &mut self.compiling.reaches[fields.island as usize];
        *reach = (*reach).max(ends.1 - ends.0);
        together.then_some(Key { group, first: ends.0, number })
    }

    /// Whether the clusters and the strides of an island are what they were.
    fn is_cut_as_before(&self, island: u32, scratch: &mut [StrideCounts; 2]) -> bool {
        let keys = self.of_island(island).map(|place| &self.keys[place]);
        let distances = keys.filter(|key| list_of(key) == List::Distances);
        let distances = distances.map(|key| &self.given.distances[key.number as usize]);
        let number = island as usize;
        let (clusters, strides) = self.compiling.examine(self.plan, number, distances, scratch);
        clusters == self.compiling.clusters[number] && strides == self.compiling.strides[number]
    }

    /// Where the keys of an island are that share a particle with these rows.
    ///
    /// All keys are looked at, but hardly any constraint: one that begins farther ahead of a particle than any in the island reaches does not touch
    /// it.
    fn around<'a>(&'a self, island: u32, rows: &'a [u32]) -> impl Iterator<Item = usize> + use<'a> {
        let (first, last) = self.compiling.ends(rows);
        let first = first.saturating_sub(self.compiling.reaches[island as usize]);
        self.of_island(island).filter(move |&place| {
            let key = &self.keys[place];
            (first..=last).contains(&key.first) && self.share(key, rows)
        })
    }

    /// Whether particles that a constraint bound are still connected, and within a few steps.
    fn are_connected(&self, island: u32, rows: &[u32]) -> bool {
        let mut reached: Vec<u32> = rows.first().copied().into_iter().collect();
        for _ in 0..ROUNDS {
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

    /// Has those looked at who may take the colour of what was removed.
    fn free(&mut self, removed: &Key, rows: &[u32]) {
        let (colour, ends) = (colour_of(removed), self.compiling.ends(rows));
        let keys = self.around(island_of(removed), rows).map(|place| &self.keys[place]);
        let rivals = keys.filter(|key| are_rivals(key, removed));
        let heirs = rivals.filter(|key| {
            let lower = colour >= GREEDY && colour_of(key) > colour;
            lower || self.ends(key) == ends
        });
        self.rechecks.extend(heirs.map(recheck).collect::<Vec<_>>());
    }

    /// Gives one the colour that it has to have; and has those looked at who may have to have another one because of that.
    fn recolour(&mut self, island: u32, (kind, number): Recheck) {
        let list = if kind == GroupKind::Constraints { List::Constraints } else { List::Distances };
        let (rows, _) = self.given.rows_and_rank(list, number as usize);
        let own = |&place: &usize| recheck(&self.keys[place]) == (kind, number);
        let Some(mine) = self.around(island, &rows).find(own) else { return };
        let key = self.keys[mine];
        let (fields, ends) = (Fields::of(key.group), self.ends(&key));
        let may = |number: u32| may_stride(&self.given.distances[number as usize]);
        let may_stride = list == List::Distances && may(number);
        // Of two between the same particles, only the first has the colour of their stride.
        let (mut taken, mut is_second, mut later) = (0_u64, false, Vec::new());
        for place in self.around(island, &rows).filter(|&place| place != mine) {
            let other = &self.keys[place];
            if !are_rivals(other, &key) {
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
        // Those who have to make room, and those who may move down to where it was.
        later.retain(|&(theirs, _)| theirs == colour || theirs > fields.colour);
        self.rechecks.extend(later.into_iter().map(|(_, recheck)| recheck));
    }

    /// Puts the keys that are new, or have another colour, to their places among the others.
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

    /// Where the keys of an island are, those that were added included.
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

    /// Whether a constraint shares a particle with these.
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

/// The colour of what has none yet: above all others, and no key has it when all is done.
const UNKNOWN: u32 = OVERFLOW + 1;

/// The bit of a greedy colour; of no other.
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

/// Whether two may not have the same colour if they share a particle.
fn are_rivals(one: &Key, other: &Key) -> bool {
    kind_of(one) == kind_of(other) && Fields::of(one.group).phase == Fields::of(other.group).phase
}
