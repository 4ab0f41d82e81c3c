//! Wavefront (temporal blocking): all substeps of a step are pipelined through an island while its particles are in columns.
//!
//! One sweep over a large island reads all of it from memory, and the next sweep reads it again. But what a substep does with a particle depends only on its
//! neighbours, so the second substep can begin at one end while the first is still in progress. The stages of a step (`predict`, each stage of the sweep,
//! `derive` with the next `predict`, and so on) therefore follow each other at a distance of a cluster or two, and the particles between the first and the last
//! stage are a few clusters, which fit into a cache.
//!
//! **The bits equal those of running one stage after the other.** A stage processes its tiles in the order of their rows, and a tile waits until all earlier
//! stages are past its last row, so the operations on each particle keep their order. Whether another sweep follows depends on the largest error of the whole
//! sweep before it, so no stage can start ahead of that decision: with several sweeps the stages run one after the other, and the gain is that particles stay
//! in columns.
//!
//! Several threads process a large island as a [pipelined wavefront](pipelined_wavefront).

mod pipeline;
mod sliding_window;
mod stages;

use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use super::plan::{ClusterBatch, ConstraintGroup, Plan};
use super::relaxation::may_relax;
use super::remaining::Remaining;
use super::report::IslandReport;
use super::task_slice::TaskSlice;
use glam::Vec4;
use smallvec::SmallVec;

use crate::constraints::GradientAt;
use crate::integrate::{Predict, StepConstants, advance_columns, derive_columns, predict_columns};
use crate::lanes::InstructionSet;
use crate::settings::Order;
pub(super) use pipeline::pipelined_wavefront;
use sliding_window::SlidingWindow;
use stages::{StageKind, Stages, Tile};

/// Scratch of a wavefront.
#[derive(Clone, Debug, Default)]
pub(super) struct Wavefront {
    window: SlidingWindow,
    stages: Stages,
    /// Positions of the pins of an island with tethers.
    pins: Vec<Vec4>,
    /// The largest error found in each substep, metres.
    worst: Vec<f32>,
    /// The remaining error at the end of the step: the largest error, metres, and the largest share of a rest length.
    left: (f32, f32),
}

/// Takes the islands of a task that can be run as wavefronts through a step, and removes them from `remaining`. `iteration_counts` receives the greatest number
/// of sweeps in each substep.
pub(super) fn run_wavefronts(
    island_step: &mut TaskSlice,
    remaining: &mut Remaining,
    wavefront: &mut Wavefront,
    iteration_counts: &[AtomicU32],
) {
    let begin = island_step.task.islands.start;
    for number in island_step.task.islands.clone() {
        if !remaining.contains(number) {
            continue;
        }
        let (plan, mut report) = (island_step.context.plan, island_step.reports[number - begin]);
        let counts = SweepCounts::new(plan.islands.list[number].microsteps, iteration_counts);
        let step = island_step.step(number, counts.each().len(), &mut wavefront.stages);
        let Some(step) = step else { continue };
        let members = &plan.islands.members[plan.islands.list[number].members.clone()];
        let first = (members[0] - island_step.task.rows.start) as usize;
        let instructions = island_step.context.execution.instructions;
        island_step.gather_pins(number, &mut wavefront.pins);
        let mut own = TaskStore { island_step, first };
        let measured = (counts.each(), true);
        run_substeps(
            &mut own,
            (plan, number),
            step,
            wavefront,
            &mut report,
            measured,
            instructions,
        );
        counts.join(&mut report);
        island_step.reports[number - begin] = report;
        remaining.remove(number..number + 1, members[0]..members[0] + members.len() as u32);
    }
}

impl TaskSlice<'_> {
    /// The constants for taking an island through this many substeps as a wavefront; `None` if it is not possible. It requires that the island consists of
    /// clusters of rods in columns alone, that it has pins, and that there are no contacts.
    fn step(&self, number: usize, substeps: usize, stages: &mut Stages) -> Option<StepConstants> {
        let Self { context, motion, .. } = self;
        let plan = context.plan;
        let island = &plan.islands.list[number];
        let members = &plan.islands.members[island.members.clone()];
        let (first, last) = (*members.first()?, *members.last()?);
        let fits = |cluster_batch: &ClusterBatch| {
            let from = cluster_batch.rows.start.checked_sub(first);
            cluster_batch.has_rods_in_columns() && from.is_some_and(|from| from.is_multiple_of(2))
        };
        let cluster_batches = island.cluster_batches.clone();
        let excluded =
            island.is_skipped() || island.rigid || island.free || island.groups.is_empty();
        let excluded = excluded || island.pivot.is_some();
        // Spans would connect cluster batches at different stages.
        let excluded = excluded || plan.tethers.spans_of(island).is_some() || island.has_chains();
        // Relaxation ends the step with sweeps of its own.
        let excluded = excluded || (island.takes_microsteps() && may_relax(plan, island));
        let touches = !context.contacts.is_empty() || context.contacts.bounces();
        let fit = !excluded
            && !touches
            && island.settings.order == Order::GaussSeidel
            && island.settings.gradient_at == GradientAt::Current
            && members.len() == (last - first) as usize + 1
            && plan.cluster_batches[cluster_batches.clone()].iter().all(fits);
        let rate = match motion.damping {
            [] => 0.0,
            [all] => *all,
            _ => return None,
        };
        let rate = rate + (motion.uniform_damping + 0.0);
        if !fit {
            return None;
        }
        stages.begin(plan, island);
        // An island within the capacity fits. Of a larger one the rows in flight have to fit, which is only possible with a single sweep a substep.
        let (rows, capacity) = (members.len(), SlidingWindow::capacity(plan.rods.half()));
        let is_single_sweep = island.settings.max_sweeps == 1;
        if rows > capacity
            && !(is_single_sweep && stages.window(substeps, plan, first, rows) <= capacity)
        {
            return None;
        }
        StepConstants::new(
            motion.uniform_acceleration.truncate(),
            rate,
            context.substep.h / island.microsteps as f32,
        )
    }

    /// Gathers the positions of the pins of an island's tethers; none if it has no tethers. These pins are static: islands with kinematic pins are solved phase
    /// by phase.
    fn gather_pins(&mut self, number: usize, pins: &mut Vec<Vec4>) {
        pins.clear();
        let plan = self.context.plan;
        if let Some(tethers) = plan.tethers.of(&plan.islands.list[number]) {
            let rows = self.task.rows.clone();
            pins.extend(tethers.pins(self.predict(0..rows.len()).position, rows.start));
        }
    }
}

/// The number of sweeps of each microstep of a step.
struct SweepCounts<'a> {
    /// The maximum over all islands for each substep.
    of_substeps: &'a [AtomicU32],
    microsteps: u32,
    /// The counts of each microstep, where microsteps differ from substeps. Inline storage avoids heap allocation in a step of a few substeps.
    own: SmallVec<[AtomicU32; 64]>,
}

impl<'a> SweepCounts<'a> {
    fn new(microsteps: u32, of_substeps: &'a [AtomicU32]) -> Self {
        let all = if microsteps > 1 { of_substeps.len() * microsteps as usize } else { 0 };
        Self { of_substeps, microsteps, own: (0..all).map(|_| AtomicU32::new(0)).collect() }
    }

    fn each(&self) -> &[AtomicU32] {
        if self.microsteps > 1 { &self.own } else { self.of_substeps }
    }

    /// Adds them up by substeps.
    fn join(&self, report: &mut IslandReport) {
        if self.microsteps > 1 {
            let substeps = self.own.chunks(self.microsteps as usize);
            for (all, own) in self.of_substeps.iter().zip(substeps) {
                let sweeps = own.iter().map(|count| count.load(Ordering::Relaxed)).sum();
                all.fetch_max(sweeps, Ordering::Relaxed);
                report.note_substep(sweeps);
            }
        }
    }
}

/// Storage of the particles of an island. Rows count from the first of the island.
trait Store {
    /// Blocks until all rows before `end` are ready to be processed.
    fn wait(&mut self, end: usize);

    /// Borrows some rows for reading or writing.
    fn slice(&mut self, rows: Range<usize>) -> Predict<'_>;

    /// Returns the borrowed rows. All rows before `settled` are not needed any more at all.
    fn put_back(&mut self, settled: Option<usize>);
}

/// Storage in the columns of a task, to which no other thread has access.
struct TaskStore<'a, 'b> {
    island_step: &'a mut TaskSlice<'b>,
    /// The first row of the island in those columns.
    first: usize,
}

impl Store for TaskStore<'_, '_> {
    #[inline(always)]
    fn wait(&mut self, _: usize) {}

    #[inline(always)]
    fn slice(&mut self, rows: Range<usize>) -> Predict<'_> {
        self.island_step.predict(self.first + rows.start..self.first + rows.end)
    }

    #[inline(always)]
    fn put_back(&mut self, _: Option<usize>) {}
}

/// Takes an island through some substeps: pipelined if each has one sweep, or else sweep by sweep. Afterwards measures the remaining error, if these substeps
/// are the last ones of a step.
fn run_substeps(
    store: &mut impl Store,
    (plan, number): (&Plan, usize),
    step: StepConstants,
    wavefront: &mut Wavefront,
    report: &mut IslandReport,
    (iteration_counts, measures): (&[AtomicU32], bool),
    instructions: InstructionSet,
) {
    let settings = &plan.islands.list[number].settings;
    let began = settings.timed.then(Instant::now);
    let is_single_sweep = settings.max_sweeps == 1;
    wavefront.window.begin(plan.rods.half());
    wavefront.left = (0.0, 0.0);
    wavefront.worst.clear();
    wavefront.worst.resize(iteration_counts.len(), 0.0);
    wavefront.stages.clear();
    let (mut substep, mut sweeps) = (0, 0);
    if is_single_sweep {
        wavefront.stages.push_all(iteration_counts.len(), measures);
    } else {
        wavefront.stages.push(StageKind::Begin);
        wavefront.stages.push_sweep(0, true);
    }
    loop {
        wavefront.run_tiles(store, (plan, number), step, iteration_counts.len(), instructions);
        if is_single_sweep {
            for (worst, iteration_counts) in wavefront.worst.iter().zip(iteration_counts) {
                report.note(1, *worst <= settings.tolerance);
                iteration_counts.fetch_max(1, Ordering::Relaxed);
            }
            break;
        }
        if substep == iteration_counts.len() {
            break;
        }
        sweeps += 1;
        let converged = wavefront.worst[substep] <= settings.tolerance;
        wavefront.stages.clear();
        if sweeps < settings.max_sweeps && !converged {
            wavefront.worst[substep] = 0.0;
            wavefront.stages.push_sweep(substep, false);
            continue;
        }
        report.note(sweeps, converged);
        iteration_counts[substep].fetch_max(sweeps, Ordering::Relaxed);
        (substep, sweeps) = (substep + 1, 0);
        if substep < iteration_counts.len() {
            wavefront.stages.push(StageKind::Advance(substep));
            wavefront.stages.push_sweep(substep, true);
        } else {
            wavefront.stages.push_end(measures);
        }
    }
    if measures {
        report.note_left(wavefront.left);
    }
    report.seconds += began.map_or(0.0, |began| began.elapsed().as_secs_f64());
}

impl Wavefront {
    /// Runs all stages.
    fn run_tiles(
        &mut self,
        store: &mut impl Store,
        (plan, number): (&Plan, usize),
        step: StepConstants,
        substeps: usize,
        instructions: InstructionSet,
    ) {
        let members = plan.islands.list[number].members.clone();
        let (first, all) = (plan.islands.members[members.start], members.len());
        let Self { window, stages, pins, worst, left } = self;
        let tethers = plan.tethers.of(&plan.islands.list[number]);
        stages.start(all);
        while let Some(Tile { kind, rows, cluster_batch, settled }) = stages.next(plan, first, all)
        {
            match kind {
                StageKind::Begin => {
                    window.admit(rows.end, settled);
                    store.wait(rows.end);
                    window.transpose_in(rows.start, &store.slice(rows.clone()), instructions);
                    store.put_back(None);
                    let (lanes, last) = (window.lanes(rows), substeps == 1);
                    predict_columns(&mut window.moving, lanes, step, last, instructions);
                }
                StageKind::Advance(substep) => {
                    let (lanes, last) = (window.lanes(rows), substep + 1 == substeps);
                    advance_columns(&mut window.moving, lanes, step, last, instructions);
                }
                StageKind::Tethers { substep } => {
                    let Some(tethers) = tethers else { continue };
                    let (columns, begin) = (&mut window.moving.position, window.rows.start);
                    let out = tethers.project_columns(columns, begin, &rows, pins, instructions);
                    worst[substep] = worst[substep].max(out);
                }
                StageKind::Sweep { substep, .. } => {
                    let cluster_batch = &plan.cluster_batches[cluster_batch];
                    let groups =
                        plan.groups[cluster_batch.groups.clone()].iter().map(ConstraintGroup::rods);
                    let rows = (cluster_batch.rows.start, first + window.rows.start as u32);
                    let columns = &mut window.moving.position;
                    let found = plan.rods.sweep_columns(columns, groups, rows, None, instructions);
                    worst[substep] = worst[substep].max(found);
                }
                StageKind::Measure { .. } => {
                    let cluster_batch = &plan.cluster_batches[cluster_batch];
                    let groups =
                        plan.groups[cluster_batch.groups.clone()].iter().map(ConstraintGroup::rods);
                    let rows = (cluster_batch.rows.start, first + window.rows.start as u32);
                    let columns = &mut window.moving.position;
                    let (error, strain) =
                        plan.rods.measure_transposed(columns, groups, rows, instructions);
                    *left = (left.0.max(error), left.1.max(strain));
                }
                StageKind::Settle => {
                    let lanes = window.lanes(rows.clone());
                    derive_columns(&mut window.moving, lanes, step, instructions);
                    window.transpose_out(rows.start, store.slice(rows.clone()), instructions);
                    store.put_back(Some(rows.end));
                }
            }
        }
    }
}
