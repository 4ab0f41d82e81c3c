//! The stages of a wavefront, and in which order their tiles run.

use core::ops::Range;

use crate::islands::Island;
use crate::solve::plan::Plan;

/// Stages over all rows of an island, one after the other, each in tiles in the order of their rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Stages {
    all: Vec<Stage>,
    /// The stages of a sweep: which of the plan's cluster batches.
    sweep_stages: Vec<Range<usize>>,
    /// Whether the first sweep of a substep begins with tethers, and whether all do.
    tethered: bool,
    tethered_again: bool,
    /// Which stage is looked at.
    at: usize,
}

/// What a stage does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum What {
    /// Takes particles in, and predicts the first substep.
    Begin,
    /// Derives the velocities of a substep and predicts the next, whose number this is.
    GoOn(usize),
    /// Holds what hangs on pins, before a sweep in a substep.
    Tethers { substep: usize },
    /// Sweeps the cluster batches before one, in a substep.
    Sweep { end: usize, substep: usize },
    /// Measures what the cluster batches before one have left to correct.
    Measure { end: usize },
    /// Derives the last velocities, and gives particles back.
    Settle,
}

impl What {
    /// Before which cluster batch a stage over cluster batches ends; `None` for one over rows.
    fn end(self) -> Option<usize> {
        match self {
            Self::Sweep { end, .. } | Self::Measure { end } => Some(end),
            _ => None,
        }
    }
}

/// A tile of a stage: its rows, counted from the first of the island, and its cluster batch, if it is one.
pub(super) struct Tile {
    pub(super) what: What,
    pub(super) rows: Range<usize>,
    pub(super) cluster_batch: usize,
    /// Before which row all is settled.
    pub(super) settled: usize,
}

#[derive(Clone, Debug)]
struct Stage {
    what: What,
    /// The tile to come: its first row, or its number among the plan's cluster batches.
    next: usize,
    /// Before which row this stage and all before it are done, and are to be now.
    done: usize,
    wanted: usize,
}

/// So many rows are a tile where rows do not depend on each other; a multiple of 32.
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

    pub(super) fn push(&mut self, what: What) {
        self.all.push(Stage { what, next: 0, done: 0, wanted: 0 });
    }

    /// A sweep in a substep, its first or another.
    pub(super) fn push_sweep(&mut self, substep: usize, first: bool) {
        if self.tethered && (first || self.tethered_again) {
            self.push(What::Tethers { substep });
        }
        let sweep_stages = self.sweep_stages.iter();
        self.all.extend(sweep_stages.map(|stage| {
            let what = What::Sweep { end: stage.end, substep };
            Stage { what, next: stage.start, done: 0, wanted: 0 }
        }));
    }

    /// The end of a step.
    pub(super) fn push_end(&mut self, measures: bool) {
        let sweep_stages = self.sweep_stages.iter().filter(|_| measures);
        self.all.extend(sweep_stages.map(|stage| {
            let what = What::Measure { end: stage.end };
            Stage { what, next: stage.start, done: 0, wanted: 0 }
        }));
        self.push(What::Settle);
    }

    /// All stages of some substeps, of one sweep each.
    pub(super) fn push_all(&mut self, substeps: usize, measures: bool) {
        for substep in 0..substeps {
            self.push(if substep == 0 { What::Begin } else { What::GoOn(substep) });
            self.push_sweep(substep, true);
        }
        self.push_end(measures);
    }

    /// So many rows are to go through all of them.
    pub(super) fn start(&mut self, rows: usize) {
        self.at = self.all.len() - 1;
        self.all[self.at].wanted = rows;
    }

    /// The next tile: the last stage has its own as early as it can, so that few particles are on their way. `rows` and `first` are those of the
    /// island.
    pub(super) fn next(&mut self, plan: &Plan, first: u32, rows: usize) -> Option<Tile> {
        const NONE: Range<usize> = usize::MAX..usize::MAX;
        loop {
            let at = self.at;
            let before = if at > 0 { self.all[at - 1].done } else { usize::MAX };
            let Stage { what, next, wanted, done } = &mut self.all[at];
            let piece = match what.end() {
                Some(end) if *next < end => {
                    let rows = &plan.cluster_batches[*next].rows;
                    (rows.start - first) as usize..(rows.end - first) as usize
                }
                None if *next < rows => *next..(*next + TILE).min(rows),
                _ => NONE,
            };
            let goes = piece.start < *wanted;
            let needed = if goes { piece.end } else { *wanted };
            if before < needed {
                self.all[at - 1].wanted = needed;
                self.at -= 1;
            } else if goes {
                let (what, cluster_batch) = (*what, *next);
                *next = if what.end().is_some() { cluster_batch + 1 } else { piece.end };
                let last = &self.all[self.all.len() - 1];
                let settled =
                    if last.what == What::Settle { last.next.min(piece.start) } else { 0 };
                return Some(Tile { what, rows: piece, cluster_batch, settled });
            } else {
                *done = piece.start.min(before);
                if at + 1 == self.all.len() {
                    return None;
                }
                self.at += 1;
            }
        }
    }

    /// How many rows are on their way at a time, at most, when so many substeps run.
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
        while let Some(piece) = self.next(plan, first, rows) {
            if piece.what == What::Begin {
                // A window begins with a line of its columns.
                window = window.max(piece.rows.end - piece.settled / 32 * 32);
            }
        }
        self.clear();
        window
    }
}
