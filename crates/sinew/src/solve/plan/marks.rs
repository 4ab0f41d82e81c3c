//! Marks: how long the lists of a plan were where an island begins. What is compiled stands island after island, so that the plan of all that comes before a
//! change stays as it is: it is cut off at the last mark before it, and compiled from there on.

#[cfg(test)]
mod tests;

use super::Plan;
use crate::solve::rods::RodCounts;
use crate::solve::wide::{BatchCounts, LooseCounts};

/// There is a mark for so many islands, or so many constraints, at least: so much is compiled again for nothing at the most.
const ISLANDS: usize = 64;
const CONSTRAINTS: usize = 256;

/// How long the lists of a plan are where an island begins.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mark {
    /// The number of the island.
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
    /// Whether so much lies between two that both are wanted.
    fn is_far_from(&self, before: &Self) -> bool {
        let constraints = self.distances + self.constraints;
        self.island - before.island >= ISLANDS
            || constraints - before.distances - before.constraints >= CONSTRAINTS
    }
}

impl Plan {
    /// Marks how long the lists are where the island of a number begins, if so much has come since the last mark.
    pub(super) fn mark(&mut self, island: usize) {
        let mark = self.lengths(island);
        if self.marks.last().is_none_or(|last| mark.is_far_from(last)) {
            self.marks.push(mark);
        }
    }

    /// Marks how long they are in the end: what is added next is mostly added there.
    pub(super) fn mark_end(&mut self) {
        let end = self.lengths(self.islands.list.len());
        if let [.., before, last] = &self.marks[..]
            && !last.is_far_from(before)
        {
            self.marks.pop();
        }
        self.marks.push(end);
    }

    /// The number of the last marked island up to that of a number: with that one, compiling may begin.
    pub(super) fn marked_before(&self, island: usize) -> usize {
        let marks = self.marks.partition_point(|mark| mark.island <= island);
        self.marks[..marks].last().map_or(0, |mark| mark.island)
    }

    /// Cuts the lists off where a marked island begins, and forgets what is known of the islands from there on.
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
