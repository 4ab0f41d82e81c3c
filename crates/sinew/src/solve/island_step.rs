//! Whole steps in one go: where nothing but gravity acts from outside, no island needs to know of another between two substeps. So a task takes its
//! islands through all substeps of a step, while their particles lie in a core's own cache, and threads meet once a step instead of thrice a substep.
//! The bits are those of phase after phase.

use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};

use glam::{Vec3, Vec4};
use smallvec::SmallVec;

use super::instances::{BatchMotion, BatchSolve, WholeStep};
use super::island::{Common, InOrder, ThreadScratch, solve};
use super::multipliers::MultiplierSlice;
use super::plan::{Plan, Task};
use super::remaining::Remaining;
use super::wavefront::{pipelined_wavefront, run_wavefronts};
use super::world::{SolveScratch, TaskSlice};
use super::{IslandReport, SolverReport};
use crate::collide::{NormalImpulse, NormalImpulses};
use crate::integrate::{Derive, Predict, predict_all};
use crate::lanes::with;
use crate::particles::{Particles, Places};
use crate::threads::{ExecutionContext, Pool, each};

/// Predicts, solves and derives, so many substeps of `h` seconds. Forces have been summed up, and are the same in all of them.
pub(crate) fn advance_all(
    particles: &mut Particles,
    normal_impulses: &mut [NormalImpulse],
    common: Common,
    substeps: u32,
    scratch: &mut SolveScratch,
    report: &mut SolverReport,
) {
    let (all_multipliers, thread_scratches, iteration_counts) = scratch.parts();
    let Common { plan, execution, .. } = common;
    all_multipliers.resize(plan.distances.len(), plan.constraints.len());
    iteration_counts.clear();
    iteration_counts.resize_with(substeps as usize, AtomicU32::default);
    let outside = Outside { common: particles.common, air: particles.air };
    let damping = match &particles.column_summary.damping {
        Some(all) => core::slice::from_ref(all),
        None => particles.damping.as_slice(),
    };
    let mut left = Some((
        particles.position.as_mut_slice(),
        particles.start.as_mut_slice(),
        particles.velocity.as_mut_slice(),
        particles.rounding.as_mut_slice(),
        all_multipliers.all(),
        NormalImpulses::all(normal_impulses),
        &mut report.islands[..],
    ));
    let (origins, radii) = (&particles.origin, &particles.radius);
    let shares = plan.tasks(execution.workers.is_none()).filter_map(|task| {
        let (position, start, velocity, rounding, multipliers, normal_impulses, reports) =
            left.take()?;
        let rows = task.rows.start as usize..task.rows.end as usize;
        let (position, positions) = position.split_at_mut(rows.len());
        let (start, starts) = start.split_at_mut(rows.len());
        let (velocity, velocities) = velocity.split_at_mut(rows.len());
        let (rounding, roundings) = rounding.split_at_mut(rows.len());
        let (own_sums, multipliers) =
            multipliers.split(Some(task.distances.end), Some(task.constraints.end));
        let (own_presses, normal_impulses) = common.contacts.split(normal_impulses, task.rows.end);
        let (own_reports, reports) = reports.split_at_mut(task.islands.len());
        left =
            Some((positions, starts, velocities, roundings, multipliers, normal_impulses, reports));
        Some(IslandStep {
            common,
            outside,
            task,
            position,
            start,
            velocity,
            rounding,
            damping: if damping.len() < 2 { damping } else { &damping[rows.clone()] },
            origin: &origins[rows.clone()],
            radius: &radii[rows],
            multipliers: own_sums,
            normal_impulses: own_presses,
            reports: own_reports,
        })
    });
    let iteration_counts = &*iteration_counts;
    let mut large = SmallVec::<[IslandStep; 4]>::new();
    let small = shares.filter_map(|alone| {
        if alone.task.large && execution.workers.is_some() {
            large.push(alone);
            return None;
        }
        Some(alone)
    });
    each(execution.workers, small, |mut alone| {
        thread_scratches.with(|thread_scratch| {
            thread_scratch.begin(&alone.task);
            leave_states(plan, &alone.task, &mut thread_scratch.remaining);
            if !alone.task.instance_batches.is_empty() {
                alone.instance_batches(thread_scratch, iteration_counts).run();
            }
            run_wavefronts(&mut alone, thread_scratch, iteration_counts);
            if !thread_scratch.remaining.is_empty() {
                alone.one_by_one(thread_scratch, iteration_counts);
            }
        });
    });
    for mut alone in large {
        if !pipelined_wavefront(&mut alone, thread_scratches, iteration_counts) {
            alone.by_all(thread_scratches, iteration_counts);
        }
    }
    for iteration_counts in iteration_counts {
        let iteration_counts = iteration_counts.load(Ordering::Relaxed);
        report.sweeps += iteration_counts;
        report.most_sweeps = report.most_sweeps.max(iteration_counts);
    }
    report.converged &= report.islands.iter().all(|island| island.converged);
}

/// Leaves out what moves as rigid states, whose rows are one stretch each.
fn leave_states(plan: &Plan, task: &Task, remaining: &mut Remaining) {
    let mut islands = task.islands.clone();
    while let Some(first) = islands.find(|&number| plan.islands.list[number].one_state) {
        let mut end = first + 1;
        let members =
            |number: usize| &plan.islands.members[plan.islands.list[number].members.clone()];
        let Some(&begin) = members(first).first() else { continue };
        let mut rows = begin..begin + members(first).len() as u32;
        while islands.end > end
            && plan.islands.list[end].one_state
            && members(end).first() == Some(&rows.end)
        {
            rows.end += members(end).len() as u32;
            end += 1;
        }
        remaining.leave(first..end, rows);
        islands.start = end;
    }
}

/// What acts on all particles alike.
#[derive(Clone, Copy)]
pub(super) struct Outside {
    /// Acceleration, m/s².
    pub(super) common: Vec3,
    /// Damping, 1/s.
    pub(super) air: f32,
}

/// A task, and what is its alone.
pub(super) struct IslandStep<'a> {
    pub(super) common: Common<'a>,
    pub(super) outside: Outside,
    pub(super) task: Task,
    position: &'a mut [Vec4],
    start: &'a mut [Vec4],
    velocity: &'a mut [Vec4],
    rounding: &'a mut [Vec4],
    /// One number for all, or one for each.
    pub(super) damping: &'a [f32],
    origin: &'a [Vec3],
    radius: &'a [f32],
    multipliers: MultiplierSlice<'a>,
    normal_impulses: NormalImpulses<'a>,
    pub(super) reports: &'a mut [IslandReport],
}

impl IslandStep<'_> {
    /// Some of its particles, to be predicted; counted from its first row on.
    #[inline(always)]
    pub(super) fn predict(&mut self, rows: Range<usize>) -> Predict<'_> {
        let damping = self.damping;
        Predict {
            position: &mut self.position[rows.clone()],
            start: &mut self.start[rows.clone()],
            velocity: &mut self.velocity[rows.clone()],
            rounding: &mut self.rounding[rows.clone()],
            acceleration: &[],
            damping: if damping.len() < 2 { damping } else { &damping[rows] },
            medium: &[],
            drift: &[],
            common: self.outside.common.extend(0.0),
            air: self.outside.air,
            h: self.common.h,
        }
    }

    /// The instance batches in it.
    fn instance_batches<'b>(
        &'b mut self,
        thread_scratch: &'b mut ThreadScratch,
        iteration_counts: &'b [AtomicU32],
    ) -> BatchSolve<'b> {
        BatchSolve {
            common: self.common,
            task: &self.task,
            position: self.position,
            origin: self.origin,
            radius: self.radius,
            normal_impulses: self.normal_impulses.lend(),
            reports: self.reports,
            motion: BatchMotion::Step(WholeStep {
                start: self.start,
                velocity: self.velocity,
                rounding: self.rounding,
                damping: self.damping,
                air: self.outside.air,
                common: self.outside.common,
                iteration_counts,
            }),
            thread_scratch,
        }
    }
}

impl IslandStep<'_> {
    /// A single large island, by all workers, who meet after each stage of each sweep.
    fn by_all(mut self, thread_scratches: &Pool<ThreadScratch>, iteration_counts: &[AtomicU32]) {
        let (rows, execution) = (self.task.rows.len(), self.common.execution);
        for (number, iteration_counts) in iteration_counts.iter().enumerate() {
            predict_all(self.predict(0..rows), execution);
            let share = TaskSlice {
                common: Common { substep: self.common.substep + number as u32, ..self.common },
                task: self.task.clone(),
                places: Places {
                    first: self.task.rows.start,
                    position: self.position,
                    start: self.start,
                    origin: self.origin,
                    radius: self.radius,
                    velocity: self.velocity,
                },
                multipliers: self.multipliers.lend(),
                normal_impulses: self.normal_impulses.lend(),
                reports: self.reports,
                momentum_drift: &mut [],
            };
            share.by_all(thread_scratches);
            iteration_counts.fetch_max(self.reports[0].last_sweeps, Ordering::Relaxed);
        }
    }
}

impl IslandStep<'_> {
    /// Its islands one after the other through all substeps. `iteration_counts` are the most sweeps in each.
    fn one_by_one(self, thread_scratch: &mut ThreadScratch, iteration_counts: &[AtomicU32]) {
        let Self { common, outside, task, position, start, velocity, rounding, .. } = self;
        let (mut multipliers, mut normal_impulses, reports) =
            (self.multipliers, self.normal_impulses, self.reports);
        let Common { plan, h, execution: ExecutionContext { instructions, .. }, .. } = common;
        let remaining = core::mem::take(&mut thread_scratch.remaining);
        let in_task = |rows: &Range<u32>| {
            (rows.start - task.rows.start) as usize..(rows.end - task.rows.start) as usize
        };
        let islands = || remaining.islands.iter().cloned().flatten();
        for (number, iteration_counts) in iteration_counts.iter().enumerate() {
            let common = Common { substep: common.substep + number as u32, ..common };
            for rows in remaining.rows.iter().map(in_task) {
                let damping = self.damping;
                let predict = Predict {
                    position: &mut position[rows.clone()],
                    start: &mut start[rows.clone()],
                    velocity: &mut velocity[rows.clone()],
                    rounding: &mut rounding[rows.clone()],
                    acceleration: &[],
                    damping: if damping.len() < 2 { damping } else { &damping[rows] },
                    medium: &[],
                    drift: &[],
                    common: outside.common.extend(0.0),
                    air: outside.air,
                    h,
                };
                with(instructions, predict);
            }
            let mut places = Places {
                first: task.rows.start,
                position,
                start,
                origin: self.origin,
                radius: self.radius,
                velocity,
            };
            thread_scratch.momentum_drifts.clear();
            let mut sweeps = 0;
            for number in islands() {
                let report = &mut reports[number - task.islands.start];
                let island = &plan.islands.list[number];
                if island.is_left_alone() {
                    continue;
                }
                let sweeper = InOrder::new(plan, island, thread_scratch);
                let momentum_drift = solve(
                    common,
                    number,
                    &mut places,
                    &mut multipliers,
                    &mut normal_impulses,
                    report,
                    sweeper,
                );
                thread_scratch
                    .momentum_drifts
                    .extend(momentum_drift.map(|momentum_drift| (number as u32, momentum_drift)));
                sweeps = sweeps.max(report.last_sweeps);
            }
            iteration_counts.fetch_max(sweeps, Ordering::Relaxed);
            for rows in remaining.rows.iter().map(in_task) {
                let (position, start) =
                    (&places.position[rows.clone()], &places.start[rows.clone()]);
                let velocity = &mut places.velocity[rows];
                let derive = Derive { position, start, velocity, momentum_drift: &[], h, lag: h };
                with(instructions, derive);
            }
            for (number, momentum_drift) in thread_scratch.momentum_drifts.drain(..) {
                let members = plan.islands.list[number as usize].members.clone();
                momentum_drift.take_off(&mut places, &plan.islands.members[members]);
            }
            if common.contacts.bounces() {
                let moment = (h, common.gravity);
                common.contacts.bounce(
                    &mut places,
                    &mut normal_impulses,
                    task.rows.clone(),
                    moment,
                );
            }
        }
        thread_scratch.remaining = remaining;
    }
}
