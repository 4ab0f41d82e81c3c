//! Marks: the lengths of a plan's lists at the beginning of an island. The compiled lists are ordered by island, so the plan of all islands before a change
//! stays valid: the lists are truncated at the last mark before the change and compiled from there on.

#[cfg(test)]
mod tests;

use super::Plan;
use crate::solve::rods::RodCounts;
use crate::solve::wide::{BatchCounts, LooseCounts};

/// A mark is set every so many islands or constraints. This bounds how much is compiled again although it has not changed.
const ISLANDS: usize = 64;
const CONSTRAINTS: usize = 256;

/// Lengths of a plan's lists at the beginning of an island.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mark {
    /// Index of the island.
    pub(super) island: usize,
    distances: usize,
    constraints: usize,
    groups: usize,
    cluster_batches: usize,
    shared_rows: usize,
    rods: RodCounts,
    constraint_batches: BatchCounts,
    loose_distances: LooseCounts,
}

impl Mark {
    /// Whether enough islands or constraints lie between two marks to keep both.
    fn is_far_from(&self, before: &Self) -> bool {
        let constraints = self.distances + self.constraints;
        self.island - before.island >= ISLANDS
            || constraints - before.distances - before.constraints >= CONSTRAINTS
    }
}

impl Plan {
    /// Sets a mark at the beginning of an island, if enough was added since the last mark.
    pub(super) fn mark(&mut self, island: usize) {
        let mark = self.lengths(island);
        if self.marks.last().is_none_or(|last| mark.is_far_from(last)) {
            self.marks.push(mark);
        }
    }

    /// Sets a mark at the end of the lists, since most additions are appended there.
    pub(super) fn mark_end(&mut self) {
        let end = self.lengths(self.islands.list.len());
        if let [.., before, last] = &self.marks[..]
            && !last.is_far_from(before)
        {
            self.marks.pop();
        }
        self.marks.push(end);
    }

    /// The last marked island up to and including island `island`, or 0: the first one that has to be compiled again.
    pub(super) fn marked_before(&self, island: usize) -> usize {
        let marks = self.marks.partition_point(|mark| mark.island <= island);
        self.marks[..marks].last().map_or(0, |mark| mark.island)
    }

    /// Truncates the lists at the beginning of a marked island, and clears the ranges of the islands from there on.
    pub(super) fn cut_off(&mut self, island: usize) {
        let known = self.marks.iter().position(|mark| mark.island == island);
        self.marks.truncate(known.map_or(0, |place| place + 1));
        let mark = self.marks.last().cloned().unwrap_or_default();
        self.distances.truncate(mark.distances);
        self.constraints.truncate(mark.constraints);
        self.groups.truncate(mark.groups);
        self.cluster_batches.truncate(mark.cluster_batches);
        self.shared_rows.truncate(mark.shared_rows);
        self.rods.truncate(&mark.rods);
        self.constraint_batches.truncate(&mark.constraint_batches);
        self.loose_distances.truncate(&mark.loose_distances);
        let chains = self.islands.list[..island].iter().map(|island| island.chains.end);
        self.chains.truncate(chains.max().unwrap_or(0));
        for island in &mut self.islands.list[island..] {
            (island.groups, island.cluster_batches, island.chains) = Default::default();
        }
    }

    fn lengths(&self, island: usize) -> Mark {
        Mark {
            island,
            distances: self.distances.len(),
            constraints: self.constraints.len(),
            groups: self.groups.len(),
            cluster_batches: self.cluster_batches.len(),
            shared_rows: self.shared_rows.len(),
            rods: self.rods.counts(),
            constraint_batches: self.constraint_batches.counts(),
            loose_distances: self.loose_distances.counts(),
        }
    }
}
