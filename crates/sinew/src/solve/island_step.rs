//! Island steps: with no external force but gravity, no island depends on another between two substeps. So a task takes its islands through all substeps of a
//! step while their particles are in a core's own cache, and threads synchronise once a step instead of three times a substep. The result has the same bits as
//! phase after phase.

use core::mem::take;
use core::sync::atomic::{AtomicU32, Ordering};

use smallvec::SmallVec;

use super::context::{SolveContext, SubstepParameters};
use super::instances::{BatchMotion, BatchSolve, WholeStep};
use super::island::sweep_in_order;
use super::microsteps::{derive_whole_steps, list_step_rows};
use super::plan::{Plan, Task};
use super::remaining::Remaining;
use super::report::SolverReport;
use super::task_slice::{TaskSlice, slices};
use super::wavefront::{pipelined_wavefront, run_wavefronts};
use super::world::{SolveScratch, ThreadScratch};
use crate::collide::{NormalImpulse, NormalImpulses};
use crate::integrate::{MotionColumns, Predict, StepRows, predict_all};
use crate::lanes::with;
use crate::particles::{Particles, Places};
use crate::threads::{Pool, each};

/// Predicts, solves and derives for `substeps` substeps. Forces have been accumulated before and are the same in all of them.
pub(crate) fn advance_all(
    particles: &mut Particles,
    normal_impulses: &mut [NormalImpulse],
    context: SolveContext,
    substeps: u32,
    scratch: &mut SolveScratch,
    report: &mut SolverReport,
) {
    let (all_multipliers, thread_scratches, iteration_counts) = scratch.parts();
    let SolveContext { plan, execution, .. } = context;
    all_multipliers.resize(plan.distances.len(), plan.constraints.len());
    iteration_counts.clear();
    iteration_counts.resize_with(substeps as usize, AtomicU32::default);
    let (places, motion) = MotionColumns::all(particles);
    // The accumulated forces are the same for all particles, and are in `uniform_acceleration`.
    let motion = MotionColumns { acceleration: &[], medium: &[], drift: &[], ..motion };
    let (normal_impulses, multipliers) =
        (NormalImpulses::all(normal_impulses), all_multipliers.all());
    let bodies = (places, motion);
    let task_slices =
        slices(context, bodies, multipliers, normal_impulses, &mut report.islands, &mut []);
    let iteration_counts = &*iteration_counts;
    let mut large = SmallVec::<[TaskSlice; 4]>::new();
    let small = task_slices.filter_map(|mut slice| {
        if pipelined_wavefront(&mut slice, thread_scratches, iteration_counts) {
            return None;
        }
        if slice.is_shared() {
            large.push(slice);
            return None;
        }
        Some(slice)
    });
    each(execution.workers, small, |mut slice| {
        thread_scratches.with(|thread_scratch| {
            thread_scratch.begin(&slice.task);
            leave_rigid_states(plan, &slice.task, &mut thread_scratch.remaining);
            thread_scratch.remaining.remove_singles(&plan.islands.singles, &slice.task);
            if !slice.task.instance_batches.is_empty() {
                slice.step_batches(thread_scratch, iteration_counts).run();
            }
            let ThreadScratch { remaining, wavefront, .. } = thread_scratch;
            run_wavefronts(&mut slice, remaining, wavefront, iteration_counts);
            if !thread_scratch.remaining.is_empty() {
                slice.step_one_by_one(thread_scratch, iteration_counts);
            }
        });
    });
    for slice in large {
        slice.step_shared(thread_scratches, iteration_counts);
    }
    for iteration_counts in iteration_counts {
        let iteration_counts = iteration_counts.load(Ordering::Relaxed);
        report.sweeps += iteration_counts;
        report.most_sweeps = report.most_sweeps.max(iteration_counts);
    }
}

/// Removes islands that move as one rigid state. The rows of each are contiguous.
fn leave_rigid_states(plan: &Plan, task: &Task, remaining: &mut Remaining) {
    let mut islands = task.islands.clone();
    while let Some(first) = islands.find(|&number| plan.islands.list[number].is_rigid_state) {
        let mut end = first + 1;
        let members = |number: usize| plan.members(number);
        let Some(&begin) = members(first).first() else { continue };
        let mut rows = begin..begin + members(first).len() as u32;
        while islands.end > end
            && plan.islands.list[end].is_rigid_state
            && members(end).first() == Some(&rows.end)
        {
            rows.end += members(end).len() as u32;
            end += 1;
        }
        remaining.remove(first..end, rows);
        islands.start = end;
    }
}

/// Stepping through all substeps of a step.
impl TaskSlice<'_> {
    /// The instance batches of the task.
    fn step_batches<'b>(
        &'b mut self,
        thread_scratch: &'b mut ThreadScratch,
        iteration_counts: &'b [AtomicU32],
    ) -> BatchSolve<'b> {
        let Places { position, start, velocity, origin, radius, .. } = &mut self.places;
        let MotionColumns { rounding, damping, uniform_damping, uniform_acceleration, .. } =
            &mut self.motion;
        BatchSolve {
            context: self.context,
            task: &self.task,
            position,
            origin,
            radius,
            normal_impulses: self.normal_impulses.reborrow(),
            reports: self.reports,
            motion: BatchMotion::Step(WholeStep {
                start,
                velocity,
                rounding,
                damping,
                uniform_damping: *uniform_damping,
                uniform_acceleration: uniform_acceleration.truncate(),
                iteration_counts,
            }),
            scratch: thread_scratch.of_batches(),
        }
    }

    /// Steps a single large island by all workers, which synchronise after each stage of each sweep.
    fn step_shared(
        mut self,
        thread_scratches: &Pool<ThreadScratch>,
        iteration_counts: &[AtomicU32],
    ) {
        let (all, execution) = (self.task.rows.len(), self.context.execution);
        let island = &self.context.plan.islands.list[self.task.islands.start];
        let first = if island.takes_microsteps() { island.microsteps } else { 1 };
        let h = self.context.substep.h / first as f32;
        for (number, iteration_counts) in iteration_counts.iter().enumerate() {
            predict_all(Predict { h, ..self.predict(0..all) }, execution);
            let slice = self.with_context(self.context.later(number as u32));
            slice.solve_shared(thread_scratches);
            thread_scratches.with(|thread_scratch| {
                let (number, report) = (self.task.islands.start, &mut self.reports[0]);
                self.context.limit_recovery(
                    number,
                    &mut self.places,
                    report,
                    &mut thread_scratch.sweep,
                );
            });
            iteration_counts.fetch_max(self.reports[0].last_sweeps, Ordering::Relaxed);
        }
    }

    /// Steps the remaining islands one after the other through all substeps. `iteration_counts` has the largest sweep count of each substep.
    fn step_one_by_one(
        mut self,
        thread_scratch: &mut ThreadScratch,
        iteration_counts: &[AtomicU32],
    ) {
        self.context = self.context.by_one();
        let begun = self.context;
        let SolveContext { plan, substep: SubstepParameters { h, .. }, execution, .. } = begun;
        let remaining = take(&mut thread_scratch.remaining);
        let mut step_rows = take(&mut thread_scratch.step_rows);
        let mut microsteps = take(&mut thread_scratch.microsteps);
        let (first, divided) = (self.task.rows.start, &mut microsteps.divided_rows);
        list_step_rows(plan, first, &remaining, &mut step_rows, divided);
        let islands = || remaining.islands.iter().cloned().flatten();
        for (number, iteration_counts) in iteration_counts.iter().enumerate() {
            self.context = begun.later(number as u32);
            for StepRows { rows, microsteps } in step_rows.iter().cloned() {
                let h = h / microsteps as f32;
                with(execution.instructions, Predict { h, ..self.predict(rows) });
            }
            thread_scratch.momentum_drifts.clear();
            let mut sweeps = 0;
            self.solve_singles();
            for number in islands() {
                let island = &plan.islands.list[number];
                if island.is_skipped() {
                    continue;
                }
                let sweep = sweep_in_order(plan, island, &mut thread_scratch.sweep);
                let momentum_drift = self.solve_substep(number, sweep, &mut microsteps);
                thread_scratch
                    .momentum_drifts
                    .extend(momentum_drift.map(|momentum_drift| (number as u32, momentum_drift)));
                sweeps = sweeps.max(self.report(number).last_sweeps);
            }
            iteration_counts.fetch_max(sweeps, Ordering::Relaxed);
            let Self { context, task, places, normal_impulses, reports, .. } = &mut self;
            derive_whole_steps(places, &step_rows, *context);
            for (number, momentum_drift) in thread_scratch.momentum_drifts.drain(..) {
                momentum_drift.subtract_from(places, plan.members(number as usize));
            }
            context.bounce(places, normal_impulses, task.rows.clone());
            for number in islands() {
                let report = &mut reports[number - task.islands.start];
                context.limit_recovery(number, places, report, &mut thread_scratch.sweep);
            }
        }
        thread_scratch.remaining = remaining;
        (thread_scratch.step_rows, thread_scratch.microsteps) = (step_rows, microsteps);
    }
}
