//! The stages of a wavefront, and the order in which their tiles run.

use core::ops::Range;

use crate::islands::Island;
use crate::solve::plan::Plan;

/// Stages over all rows of an island, one after the other, each divided into tiles in the order of their rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Stages {
    all: Vec<Stage>,
    /// The stages of a sweep, as ranges of the plan's cluster batches.
    sweep_stages: Vec<Range<usize>>,
    /// Whether the first sweep of a substep begins with tethers, and whether every sweep does.
    tethered: bool,
    tethered_again: bool,
    /// The stage under consideration.
    at: usize,
}

/// The operation of a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum StageKind {
    /// Loads particles, and predicts the first substep.
    Begin,
    /// Derives the velocities of a substep and predicts the next one, whose number this is.
    Advance(usize),
    /// Projects tethers, before a sweep in a substep.
    Tethers { substep: usize },
    /// Sweeps the cluster batches before `end`, in a substep.
    Sweep { end: usize, substep: usize },
    /// Measures the remaining error of the cluster batches before `end`.
    Measure { end: usize },
    /// Derives the last velocities, and stores the particles.
    Settle,
}

impl StageKind {
    /// The end of a stage's cluster batches; `None` for a stage over rows.
    fn end(self) -> Option<usize> {
        match self {
            Self::Sweep { end, .. } | Self::Measure { end } => Some(end),
            _ => None,
        }
    }
}

/// A tile of a stage: its rows, counted from the first of the island, and its cluster batch, for a stage over cluster batches.
pub(super) struct Tile {
    pub(super) kind: StageKind,
    pub(super) rows: Range<usize>,
    pub(super) cluster_batch: usize,
    /// The row up to which everything is settled.
    pub(super) settled: usize,
}

#[derive(Clone, Debug)]
struct Stage {
    kind: StageKind,
    /// The next tile: its first row, or its index among the plan's cluster batches.
    next: usize,
    /// The row up to which this stage and all before it are done, and the row up to which they are currently required to be.
    done: usize,
    required: usize,
}

/// Number of rows of a tile in stages over rows, where rows do not depend on each other; a multiple of 32.
pub(super) const TILE: usize = 1024;

impl Stages {
    /// Begins with an island.
    pub(super) fn begin(&mut self, plan: &Plan, island: &Island) {
        let cluster_batches = &plan.cluster_batches[island.cluster_batches.clone()];
        let mut first = island.cluster_batches.start;
        self.tethered = plan.tethers.of(island).is_some();
        self.tethered_again = !island.is_small();
        self.all.clear();
        self.sweep_stages.clear();
        for stage in cluster_batches.chunk_by(|one, other| one.stage == other.stage) {
            self.sweep_stages.push(first..first + stage.len());
            first += stage.len();
        }
    }

    pub(super) fn clear(&mut self) {
        self.all.clear();
    }

    pub(super) fn push(&mut self, kind: StageKind) {
        self.all.push(Stage { kind, next: 0, done: 0, required: 0 });
    }

    /// Appends a sweep in a substep; `first` for the first one of that substep.
    pub(super) fn push_sweep(&mut self, substep: usize, first: bool) {
        if self.tethered && (first || self.tethered_again) {
            self.push(StageKind::Tethers { substep });
        }
        let sweep_stages = self.sweep_stages.iter();
        self.all.extend(sweep_stages.map(|stage| {
            let kind = StageKind::Sweep { end: stage.end, substep };
            Stage { kind, next: stage.start, done: 0, required: 0 }
        }));
    }

    /// Appends the end of a step.
    pub(super) fn push_end(&mut self, measures: bool) {
        let sweep_stages = self.sweep_stages.iter().filter(|_| measures);
        self.all.extend(sweep_stages.map(|stage| {
            let kind = StageKind::Measure { end: stage.end };
            Stage { kind, next: stage.start, done: 0, required: 0 }
        }));
        self.push(StageKind::Settle);
    }

    /// Appends all stages of some substeps with one sweep each.
    pub(super) fn push_all(&mut self, substeps: usize, measures: bool) {
        for substep in 0..substeps {
            self.push(if substep == 0 { StageKind::Begin } else { StageKind::Advance(substep) });
            self.push_sweep(substep, true);
        }
        self.push_end(measures);
    }

    /// Starts a run of this many rows through all stages.
    pub(super) fn start(&mut self, rows: usize) {
        self.at = self.all.len() - 1;
        self.all[self.at].required = rows;
    }

    /// The next tile. The last stage runs as early as possible, so that few particles are in flight. `rows` and `first` are those of the island.
    pub(super) fn next(&mut self, plan: &Plan, first: u32, rows: usize) -> Option<Tile> {
        const NONE: Range<usize> = usize::MAX..usize::MAX;
        loop {
            let at = self.at;
            let before = if at > 0 { self.all[at - 1].done } else { usize::MAX };
            let Stage { kind, next, required, done } = &mut self.all[at];
            let tile = match kind.end() {
                Some(end) if *next < end => {
                    let rows = &plan.cluster_batches[*next].rows;
                    (rows.start - first) as usize..(rows.end - first) as usize
                }
                None if *next < rows => *next..(*next + TILE).min(rows),
                _ => NONE,
            };
            let goes = tile.start < *required;
            let needed = if goes { tile.end } else { *required };
            if before < needed {
                self.all[at - 1].required = needed;
                self.at -= 1;
            } else if goes {
                let (kind, cluster_batch) = (*kind, *next);
                *next = if kind.end().is_some() { cluster_batch + 1 } else { tile.end };
                let last = &self.all[self.all.len() - 1];
                let settled =
                    if last.kind == StageKind::Settle { last.next.min(tile.start) } else { 0 };
                return Some(Tile { kind, rows: tile, cluster_batch, settled });
            } else {
                *done = tile.start.min(before);
                if at + 1 == self.all.len() {
                    return None;
                }
                self.at += 1;
            }
        }
    }

    /// The greatest number of rows in flight at a time when this many substeps run.
    pub(super) fn window(
        &mut self,
        substeps: usize,
        plan: &Plan,
        first: u32,
        rows: usize,
    ) -> usize {
        self.clear();
        self.push_all(substeps, true);
        self.start(rows);
        let mut window = 0;
        while let Some(tile) = self.next(plan, first, rows) {
            if tile.kind == StageKind::Begin {
                // The window begins at a multiple of 32 rows.
                window = window.max(tile.rows.end - tile.settled / 32 * 32);
            }
        }
        self.clear();
        window
    }
}
