//! Copies the constraints in key order to where sweeps read them, cut into groups and cluster batches, and packs them for their kernels.

use core::ops::Range;

use super::clusters::PHASES;
use super::keys::{Fields, Key};
use super::place::may_stride;
use super::{ClusterBatch, ConstraintGroup, GroupKind, Plan, colours, tasks};
use crate::constraints::{Constraint, Distance};

impl Plan {
    /// Appends constraints in key order, cut into cluster batches and groups.
    pub(super) fn take_in_order(
        &mut self,
        distances: &[Distance],
        constraints: &[Constraint],
        keys: &[Key],
    ) {
        for keys in keys.chunk_by(|one, other| {
            Fields::cluster_batch(one.group) == Fields::cluster_batch(other.group)
        }) {
            let found = Fields::of(keys[0].group);
            if self.islands.list[found.island as usize].cluster_batches.is_empty() {
                self.mark(found.island as usize);
            }
            let island = &mut self.islands.list[found.island as usize];
            if island.cluster_batches.is_empty() {
                island.groups = self.groups.len()..self.groups.len();
                island.cluster_batches = self.cluster_batches.len()..self.cluster_batches.len();
            }
            let first = self.groups.len();
            let stage = found.rank * PHASES + found.phase;
            // Rows before this cluster batch's first one may be transposed with it, but not rows of another cluster batch of the same stage or of another
            // island.
            let begin =
                match self.cluster_batches.last().filter(|_| !island.cluster_batches.is_empty()) {
                    Some(last) if last.stage == stage => last.rows.end,
                    _ => self.islands.members[island.members.start],
                };
            let (rows, columns) =
                self.take_cluster_batch(distances, constraints, keys, found, begin);
            let groups = first..self.groups.len();
            let island = &mut self.islands.list[found.island as usize];
            (island.groups.end, island.cluster_batches.end) =
                (groups.end, island.cluster_batches.end + 1);
            let mut cluster_batch = ClusterBatch {
                kind: found.kind(),
                groups,
                stage,
                rows,
                columns,
                shared_rows: 0..0,
            };
            self.share_rows(found.island as usize, &mut cluster_batch);
            self.cluster_batches.push(cluster_batch);
        }
        self.mark_end();
        self.tasks = tasks::cut(self);
    }

    /// Records which rows of a large island's run are used by a cluster batch that is not swept in the columns of that run.
    fn share_rows(&mut self, island: usize, cluster_batch: &mut ClusterBatch) {
        let island = &self.islands.list[island];
        let run = self.contiguous_rows(island);
        if island.is_small() || cluster_batch.is_within(&run) {
            return;
        }
        let begin = self.shared_rows.len();
        for ConstraintGroup { kind, range, .. } in &self.groups[cluster_batch.groups.clone()] {
            if *kind == GroupKind::Constraints {
                let rows = self.constraints[range.clone()].iter().flat_map(|c| &c.rows).copied();
                self.shared_rows.extend(rows.filter(|row| run.contains(row)));
            } else {
                let rows = self.distances[range.clone()].iter().flat_map(|d| [d.a, d.b]);
                self.shared_rows.extend(rows.filter(|row| run.contains(row)));
            }
        }
        self.shared_rows[begin..].sort_unstable();
        let mut end = begin;
        for place in begin..self.shared_rows.len() {
            if end == begin || self.shared_rows[place] != self.shared_rows[end - 1] {
                self.shared_rows[end] = self.shared_rows[place];
                end += 1;
            }
        }
        self.shared_rows.truncate(end);
        cluster_batch.shared_rows = begin..end;
    }

    /// Copies the constraints of one cluster batch, group by group. Returns the bounds of their rows, and whether they are to be swept in columns.
    fn take_cluster_batch(
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
        let mut begin = if kind == GroupKind::Constraints {
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
        // Nearly all distances of a stride are in runs. In columns, a gathered block costs three times as much as packed, and a run a third.
        let strided = |key: &&Key| Fields::of(key.group).colour < colours::GREEDY;
        let running = keys.iter().filter(strided).count();
        let columns = kind != GroupKind::Constraints
            && running * 4 >= keys.len() * 3
            && rows.len() <= 2 * keys.len()
            && self.distances[begin..].iter().all(may_stride);
        if columns {
            // Strides are mostly even. If the island's rows begin at a cache line, most batches of eight lanes then do.
            let island = &self.islands.list[found.island as usize];
            let [origin, run] =
                [&island.members, &island.contiguous].map(|of| self.islands.members[of.start]);
            let origin = if run <= rows.start { run } else { origin };
            rows.start -= (rows.start - origin) % 32;
            rows.start = rows.start.max(first);
        }
        for run in keys.chunk_by(|one, other| one.group == other.group) {
            let range = begin..begin + run.len();
            begin = range.end;
            let alone = Fields::of(run[0].group).colour == alone;
            let (mut runs, mut blocks, mut wide) = (0..0, 0..0, None);
            match kind {
                GroupKind::Rods if columns => {
                    let rods = &self.distances[range.clone()];
                    (runs, blocks) = self.rods.add_to_columns(rods, alone, &rows);
                }
                GroupKind::Rods => {
                    (runs, blocks) = self.rods.add(&self.distances[range.clone()], alone);
                }
                GroupKind::Distances if columns => {
                    let distances = &self.distances[range.clone()];
                    let in_step = if alone { &[] } else { distances };
                    let (strided, loose) = self.rods.add_soft_to_columns(in_step, &rows);
                    let loose = if alone { distances } else { &loose[..] };
                    runs = strided;
                    blocks = self.loose_distances.add(loose, alone, rows.start);
                }
                GroupKind::Distances => {
                    wide = Some(
                        self.constraint_batches
                            .add_distances(&self.distances[range.clone()], alone),
                    );
                }
                GroupKind::Constraints => {
                    wide = self.constraint_batches.add(&self.constraints[range.clone()], alone);
                }
            }
            self.groups.push(ConstraintGroup { kind, range, runs, blocks, wide });
        }
        (rows, columns)
    }
}
