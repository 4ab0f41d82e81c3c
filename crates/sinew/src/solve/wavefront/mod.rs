//! Wavefront (temporal blocking): all substeps of a step run through an island one behind the other, while its particles are in columns.
//!
//! One sweep over a large island reads all of it from memory, and the next one again. But what a substep does with a particle depends only on what
//! its neighbours did: the second may begin at one end while the first is still on its way to the other. So the stages of a step, `predict`, each
//! stage of the sweep, `derive` with the next `predict` and so on, follow each other at the distance of a cluster or two, and the particles between
//! the first and the last are a few clusters, which a cache holds.
//!
//! **The bits are those of stage after stage.** A stage takes its tiles in the order of their rows, and a tile waits until all earlier stages are
//! beyond its last row; so whatever touches a particle does so in the same order. What has to know the largest error of a whole sweep, whether
//! another follows, cannot be overtaken; there the stages follow each other, and what is gained is that particles stay in columns.
//!
//! Several threads take a large island through a step as a [pipelined wavefront](pipelined_wavefront).

mod pipeline;
mod sliding_window;
mod stages;

use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use super::plan::{ClusterBatch, ConstraintGroup, Plan};
use super::remaining::Remaining;
use super::report::IslandReport;
use super::task_slice::TaskSlice;
use glam::Vec4;
use smallvec::SmallVec;

use crate::constraints::GradientAt;
use crate::integrate::{Predict, StepConstants, begin_columns, go_on_with_columns, settle_columns};
use crate::lanes::InstructionSet;
use crate::settings::Order;
pub(super) use pipeline::pipelined_wavefront;
use sliding_window::SlidingWindow;
use stages::{Stages, Tile, What};

/// What a wavefront needs. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Wavefront {
    window: SlidingWindow,
    stages: Stages,
    /// Where the pins of an island are that has tethers.
    pins: Vec<Vec4>,
    /// The largest error that each substep found, metres.
    worst: Vec<f32>,
    /// What is left at the end of the step: the largest error, metres, and the largest share of a rest length.
    left: (f32, f32),
}

/// Takes the islands of a task through a step that can go as wavefronts, and out of what is left of the task. `iteration_counts` are the most sweeps
/// in each substep.
pub(super) fn run_wavefronts(
    island_step: &mut TaskSlice,
    remaining: &mut Remaining,
    wavefront: &mut Wavefront,
    iteration_counts: &[AtomicU32],
) {
    let begin = island_step.task.islands.start;
    for number in island_step.task.islands.clone() {
        if !remaining.holds(number) {
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
        remaining.leave(number..number + 1, members[0]..members[0] + members.len() as u32);
    }
}

impl TaskSlice<'_> {
    /// How an island would go through so many substeps, if it can: clusters of rods in columns alone, which nothing but each other holds back.
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
        let held =
            island.is_left_alone() || island.rigid || island.free || island.groups.is_empty();
        // Spans reach over cluster batches that have gone on.
        let held = held || plan.tethers.spans_of(island).is_some() || island.has_chains();
        let touches = !context.contacts.is_empty() || context.contacts.bounces();
        let fit = !held
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
        let rate = rate + (motion.air + 0.0);
        if !fit {
            return None;
        }
        stages.begin(plan, island);
        // All of a small island has room. Of a large one, what is on its way has, unless it is whole sweeps.
        let (rows, capacity) = (members.len(), SlidingWindow::capacity(plan.rods.half()));
        let is_single_sweep = island.settings.max_sweeps == 1;
        if rows > capacity
            && !(is_single_sweep && stages.window(substeps, plan, first, rows) <= capacity)
        {
            return None;
        }
        StepConstants::new(
            motion.common.truncate(),
            rate,
            context.substep.h / island.microsteps as f32,
        )
    }

    /// Where the pins are that an island's tethers go to; none without. They stand: what is led goes phase after phase.
    fn gather_pins(&mut self, number: usize, pins: &mut Vec<Vec4>) {
        pins.clear();
        let plan = self.context.plan;
        if let Some(tethers) = plan.tethers.of(&plan.islands.list[number]) {
            let rows = self.task.rows.clone();
            pins.extend(tethers.pins(self.predict(0..rows.len()).position, rows.start));
        }
    }
}

/// How many sweeps each microstep of a step has.
struct SweepCounts<'a> {
    /// The most of all islands in each substep.
    of_substeps: &'a [AtomicU32],
    microsteps: u32,
    /// In each microstep, where those are not the substeps. Without a heap in a step of a few substeps.
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

    /// Sums them up by substeps.
    fn join(&self, report: &mut IslandReport) {
        if self.microsteps > 1 {
            let substeps = self.own.chunks(self.microsteps as usize);
            for (all, own) in self.of_substeps.iter().zip(substeps) {
                let sweeps = own.iter().map(|count| count.load(Ordering::Relaxed)).sum();
                all.fetch_max(sweeps, Ordering::Relaxed);
                report.last_sweeps = sweeps;
                report.most_sweeps = report.most_sweeps.max(sweeps);
            }
        }
    }
}

/// Where the particles of an island are kept. Rows count from the first of the island.
trait Store {
    /// Returns when all rows before one may be taken up.
    fn wait(&mut self, end: usize);

    /// Some rows, to be read or to be written.
    fn lend(&mut self, rows: Range<usize>) -> Predict<'_>;

    /// They are not needed any more; all rows before `settled` not at all.
    fn put_back(&mut self, settled: Option<usize>);
}

/// In the columns of a task, which nobody else has.
struct TaskStore<'a, 'b> {
    island_step: &'a mut TaskSlice<'b>,
    /// The first row of the island in those.
    first: usize,
}

impl Store for TaskStore<'_, '_> {
    #[inline(always)]
    fn wait(&mut self, _: usize) {}

    #[inline(always)]
    fn lend(&mut self, rows: Range<usize>) -> Predict<'_> {
        self.island_step.predict(self.first + rows.start..self.first + rows.end)
    }

    #[inline(always)]
    fn put_back(&mut self, _: Option<usize>) {}
}

/// Takes an island through some substeps: all at once if each has one sweep, or else sweep by sweep. Measures what is left then if those are the last
/// of a step.
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
        wavefront.stages.push(What::Begin);
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
            wavefront.stages.push(What::GoOn(substep));
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

impl IslandReport {
    /// Notes how a substep went.
    fn note(&mut self, sweeps: u32, converged: bool) {
        self.sweeps += sweeps;
        self.most_sweeps = self.most_sweeps.max(sweeps);
        self.last_sweeps = sweeps;
        self.converged &= converged;
    }

    /// Notes what is left of it at the end of a step.
    fn note_left(&mut self, (error, strain): (f32, f32)) {
        (self.error, self.strain, self.measured) = (error, strain, true);
    }
}

impl Wavefront {
    /// Does all stages.
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
        while let Some(Tile { what, rows, cluster_batch, settled }) = stages.next(plan, first, all)
        {
            match what {
                What::Begin => {
                    window.admit(rows.end, settled);
                    store.wait(rows.end);
                    window.turn_in(rows.start, &store.lend(rows.clone()), instructions);
                    store.put_back(None);
                    let (lanes, last) = (window.lanes(rows), substeps == 1);
                    begin_columns(&mut window.moving, lanes, step, last, instructions);
                }
                What::GoOn(substep) => {
                    let (lanes, last) = (window.lanes(rows), substep + 1 == substeps);
                    go_on_with_columns(&mut window.moving, lanes, step, last, instructions);
                }
                What::Tethers { substep } => {
                    let Some(tethers) = tethers else { continue };
                    let (columns, begin) = (&mut window.moving.position, window.rows.start);
                    let out = tethers.project_columns(columns, begin, &rows, pins, instructions);
                    worst[substep] = worst[substep].max(out);
                }
                What::Sweep { substep, .. } => {
                    let cluster_batch = &plan.cluster_batches[cluster_batch];
                    let groups =
                        plan.groups[cluster_batch.groups.clone()].iter().map(ConstraintGroup::rods);
                    let rows = (cluster_batch.rows.start, first + window.rows.start as u32);
                    let columns = &mut window.moving.position;
                    let found = plan.rods.sweep_turned(columns, groups, rows, None, instructions);
                    worst[substep] = worst[substep].max(found);
                }
                What::Measure { .. } => {
                    let cluster_batch = &plan.cluster_batches[cluster_batch];
                    let groups =
                        plan.groups[cluster_batch.groups.clone()].iter().map(ConstraintGroup::rods);
                    let rows = (cluster_batch.rows.start, first + window.rows.start as u32);
                    let columns = &mut window.moving.position;
                    let (error, strain) =
                        plan.rods.measure_turned(columns, groups, rows, instructions);
                    *left = (left.0.max(error), left.1.max(strain));
                }
                What::Settle => {
                    let lanes = window.lanes(rows.clone());
                    settle_columns(&mut window.moving, lanes, step, instructions);
                    window.turn_out(rows.start, store.lend(rows.clone()), instructions);
                    store.put_back(Some(rows.end));
                }
            }
        }
    }
}
