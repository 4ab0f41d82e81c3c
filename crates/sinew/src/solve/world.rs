//! Solves all islands: distributes them to the workers and reports on them.

use core::mem::take;
use core::sync::atomic::AtomicU32;

use glam::Vec4;

use super::constraint_ref::SolveMode;
use super::context::{SolveContext, SubstepParameters};
use super::gauss_seidel;
use super::instances::{BatchMotion, BatchScratch, BatchSolve, LaneCompaction};
use super::island::{
    project_tethers_and_chains, project_tethers_and_spans, propagate_impact, solve, sweep_in_order,
};
use super::loads::Loads;
use super::microsteps::{MicrostepScratch, derive_whole_steps, list_step_rows, resume};
use super::mixed_places::MixedPlaces;
use super::momentum::{MomentumDrift, note_drift};
use super::multipliers::{MultiplierSlice, Multipliers};
use super::parts::Parts;
use super::plan::{Plan, Task};
use super::pressed_cloth::{HeldCloth, PressedScratch};
use super::remaining::Remaining;
use super::report::{IslandReport, SolverReport};
use super::sweep_scratch::SweepScratch;
use super::task_slice::{IslandSlice, TaskSlice, slices};
use super::wavefront::Wavefront;
use crate::collide::{NormalImpulse, NormalImpulses};
use crate::integrate::{Derive, MotionColumns, StepRows, derive};
use crate::islands::{Island, Singles};
use crate::not_cloned::NotCloned;
use crate::particles::{Particles, Places};
use crate::threads::{ExecutionContext, Pool, each};

/// What solving needs and what is not saved. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct SolveScratch {
    all_multipliers: Multipliers,
    thread_scratches: Pool<ThreadScratch>,
    /// For each row, the velocity to be removed when it is derived, m/s. Empty if velocities are derived at once.
    momentum_drift: Vec<Vec4>,
    /// The momentum drifts of islands with measured loads.
    measured: Vec<(u32, MomentumDrift)>,
    /// Positions of an island's particles before an additional sweep.
    before: Vec<Vec4>,
    /// Scratch of cloth that shapes press on.
    pressed: PressedScratch,
    /// The largest sweep count of each substep of a whole step.
    iteration_counts: NotCloned<Vec<AtomicU32>>,
}

/// What a thread needs while it solves.
#[derive(Clone, Debug, Default)]
pub(super) struct ThreadScratch {
    pub(super) sweep: SweepScratch,
    pub(super) lane_compaction: LaneCompaction,
    /// What remains of a task beside its instance batches.
    pub(super) remaining: Remaining,
    /// State of a large island that is solved as a wavefront.
    pub(super) wavefront: Wavefront,
    /// Rows of a task by their number of microsteps.
    pub(super) step_rows: Vec<StepRows>,
    pub(super) microsteps: MicrostepScratch,
    /// Islands with corrections that added momentum, which has to be removed.
    pub(super) momentum_drifts: Vec<(u32, MomentumDrift)>,
}

impl ThreadScratch {
    /// Begins a task.
    pub(super) fn begin(&mut self, task: &Task) {
        self.remaining.reset(task);
        self.momentum_drifts.clear();
    }

    /// The part that solving instance batches needs.
    pub(super) fn of_batches(&mut self) -> BatchScratch<'_> {
        let Self { sweep, lane_compaction, remaining, momentum_drifts, .. } = self;
        BatchScratch { sweep, lane_compaction, remaining, momentum_drifts }
    }
}

impl AsMut<SweepScratch> for ThreadScratch {
    fn as_mut(&mut self) -> &mut SweepScratch {
        &mut self.sweep
    }
}

impl AsMut<Wavefront> for ThreadScratch {
    fn as_mut(&mut self) -> &mut Wavefront {
        &mut self.wavefront
    }
}

impl SolveScratch {
    /// Large cloth that shapes press on, for the contacts of a substep.
    pub(crate) fn pressed_cloth<'a>(
        &'a mut self,
        plan: &'a Plan,
        substep: SubstepParameters,
        execution: ExecutionContext<'a>,
    ) -> HeldCloth<'a> {
        HeldCloth::new(plan, (substep, execution), &mut self.pressed)
    }

    pub(super) fn parts(
        &mut self,
    ) -> (&mut Multipliers, &Pool<ThreadScratch>, &mut Vec<AtomicU32>) {
        (&mut self.all_multipliers, &self.thread_scratches, &mut self.iteration_counts.0)
    }
}

/// Sweeps each island until its largest error is within its tolerance, at most `max_sweeps` times; then derives the velocities. If some rows are `open`,
/// velocities are not derived: contacts between islands follow first, then [`derive_all`] for those rows. Adds to the report.
pub(crate) fn solve_all(
    particles: &mut Particles,
    normal_impulses: &mut [NormalImpulse],
    context: SolveContext,
    open: Option<&[StepRows]>,
    (scratch, loads): (&mut SolveScratch, &mut Loads),
    report: &mut SolverReport,
) {
    let SolveScratch { all_multipliers, thread_scratches, momentum_drift, measured, .. } = scratch;
    let SolveContext { plan, execution, .. } = context;
    all_multipliers.resize(plan.distances.len(), plan.constraints.len());
    measured.clear();
    let reports = &mut report.islands[..];
    loads.solve(context, particles, normal_impulses, all_multipliers, reports, measured);
    momentum_drift.resize(if open.is_some() { particles.len() } else { 0 }, Vec4::ZERO);
    for StepRows { rows, .. } in open.into_iter().flatten() {
        momentum_drift[rows.clone()].fill(Vec4::ZERO);
    }
    let (normal_impulses, drift) = (NormalImpulses::all(normal_impulses), &mut momentum_drift[..]);
    let (bodies, multipliers) = (MotionColumns::all(particles), all_multipliers.all());
    let task_slices =
        slices(context, bodies, multipliers, normal_impulses, &mut report.islands, drift);
    let mut large = smallvec::SmallVec::<[TaskSlice; 4]>::new();
    let small = task_slices.filter_map(|slice| {
        if slice.is_shared() {
            large.push(slice);
            return None;
        }
        Some(slice)
    });
    each(execution.workers, small, |mut slice| {
        thread_scratches.with(|thread_scratch| {
            thread_scratch.begin(&slice.task);
            if !slice.task.instance_batches.is_empty() {
                slice.instance_batches(thread_scratch).run();
            }
            slice.one_by_one(thread_scratch);
        });
    });
    for slice in large {
        slice.solve_shared(thread_scratches);
    }
    for (number, drift) in &*measured {
        let rows = plan.members(*number as usize);
        let mut places = Places::all(particles);
        if open.is_some() {
            note_drift(drift, &places, rows, momentum_drift, execution.instructions);
        } else {
            drift.subtract_from(&mut places, rows);
        }
    }
    // Single particles are not swept.
    let (mut iteration_counts, mut next) = (0, 0);
    let most = |reports: &[IslandReport]| reports.iter().map(|own| own.last_sweeps).max();
    for singles in &plan.islands.singles {
        let swept = most(&report.islands[next..singles.islands.start]);
        iteration_counts = iteration_counts.max(swept.unwrap_or(0));
        next = singles.islands.end;
    }
    iteration_counts = iteration_counts.max(most(&report.islands[next..]).unwrap_or(0));
    report.sweeps += iteration_counts;
    report.most_sweeps = report.most_sweeps.max(iteration_counts);
}

/// Sweeps the `stopped` islands once more, after an `open` [`solve_all`] and after contacts between bodies that suddenly stopped a part of each. So the impact
/// propagates through the constraints within the same substep.
pub(crate) fn propagate_impacts(
    particles: &mut Particles,
    normal_impulses: &mut [NormalImpulse],
    context: SolveContext,
    stopped: &[u32],
    scratch: &mut SolveScratch,
    report: &mut SolverReport,
) {
    let SolveScratch { all_multipliers, thread_scratches, momentum_drift, before, .. } = scratch;
    let (plan, context) = (context.plan, context.by_one());
    for number in stopped.iter().map(|&number| number as usize) {
        let own = IslandSlice {
            places: Places::all(particles),
            multipliers: all_multipliers.all(),
            normal_impulses: NormalImpulses::all(normal_impulses),
            report: &mut report.islands[number],
        };
        let drift = thread_scratches.with(|thread_scratch| {
            let sweep = sweep_in_order(plan, &plan.islands.list[number], &mut thread_scratch.sweep);
            propagate_impact(context, number, own, sweep, before)
        });
        if let Some(drift) = drift {
            drift.add_to(&Places::all(particles), plan.members(number), momentum_drift);
        }
    }
}

/// Derives the velocities of some rows after an `open` [`solve_all`].
pub(crate) fn derive_all(
    particles: &mut Particles,
    normal_impulses: &mut [NormalImpulse],
    context: SolveContext,
    which: &[StepRows],
    scratch: &mut SolveScratch,
) {
    let rows = 0..particles.len() as u32;
    let (mut places, momentum_drift) = (Places::all(particles), &scratch.momentum_drift[..]);
    let SolveContext { substep: SubstepParameters { h, lag, .. }, execution, .. } = context;
    for StepRows { rows, microsteps } in which.iter().cloned() {
        if microsteps > 1 {
            resume(&mut places, rows, momentum_drift, h);
            continue;
        }
        let derive_some = Derive {
            position: &places.position[rows.clone()],
            start: &places.start[rows.clone()],
            velocity: &mut places.velocity[rows.clone()],
            momentum_drift: &momentum_drift[rows],
            h,
            lag,
        };
        derive(derive_some, execution);
    }
    if context.contacts.bounces() {
        let mut normal_impulses = NormalImpulses::all(normal_impulses);
        context.contacts.bounce(&mut places, &mut normal_impulses, rows, h);
    }
}

impl TaskSlice<'_> {
    /// Solves the remaining islands one after the other, by one worker.
    fn one_by_one(mut self, thread_scratch: &mut ThreadScratch) {
        self.context = self.context.by_one();
        let plan = self.context.plan;
        let mut remaining = take(&mut thread_scratch.remaining);
        let mut microsteps = take(&mut thread_scratch.microsteps);
        remaining.remove_singles(&plan.islands.singles, &self.task);
        self.solve_singles();
        for number in remaining.islands.iter().cloned().flatten() {
            let island = &plan.islands.list[number];
            if island.measured || island.is_skipped() {
                continue;
            }
            let sweep = sweep_in_order(plan, island, &mut thread_scratch.sweep);
            let momentum_drift = self.solve_substep(number, sweep, &mut microsteps);
            let Some(momentum_drift) = momentum_drift else { continue };
            if self.momentum_drift.is_empty() {
                thread_scratch.momentum_drifts.push((number as u32, momentum_drift));
            } else {
                self.note_drift(&momentum_drift, number);
            }
        }
        (thread_scratch.remaining, thread_scratch.microsteps) = (remaining, microsteps);
        if !self.momentum_drift.is_empty() {
            return;
        }
        let Self { context, task, mut places, mut normal_impulses, .. } = self;
        // Velocities are derived for all rows of the task, those of solved instance batches included.
        let mut step_rows = take(&mut thread_scratch.step_rows);
        thread_scratch.remaining.reset(&task);
        thread_scratch.remaining.remove_singles(&plan.islands.singles, &task);
        let ThreadScratch { remaining, microsteps, .. } = &mut *thread_scratch;
        let divided = &mut microsteps.divided_rows;
        list_step_rows(plan, task.rows.start, remaining, &mut step_rows, divided);
        derive_whole_steps(&mut places, &step_rows, context);
        thread_scratch.step_rows = step_rows;
        for (number, momentum_drift) in thread_scratch.momentum_drifts.drain(..) {
            momentum_drift.subtract_from(&mut places, plan.members(number as usize));
        }
        context.bounce(&mut places, &mut normal_impulses, task.rows);
    }

    /// Projects single particles out of what they touch.
    pub(super) fn solve_singles(&mut self) {
        let SolveContext { plan, contacts, .. } = self.context;
        if contacts.is_empty() {
            return;
        }
        for singles in &plan.islands.singles {
            let Singles { islands, rows } = singles.among(&self.task.islands);
            for (number, row) in islands.zip(rows) {
                if contacts.may_touch(&self.places, number, row) {
                    let nothing = |_: &mut Places, _: &mut MultiplierSlice, _: SolveMode| 0.0;
                    solve(self.context, number, self.island(number), nothing);
                }
            }
        }
    }

    /// Stores the velocities that the particles of an island are to lose when their velocities are derived.
    fn note_drift(&mut self, momentum_drift: &MomentumDrift, number: usize) {
        let SolveContext { plan, execution, .. } = self.context;
        let (places, rows, to) = (&self.places, plan.members(number), &mut *self.momentum_drift);
        note_drift(momentum_drift, places, rows, to, execution.instructions);
    }

    /// The instance batches of the task.
    fn instance_batches<'b>(&'b mut self, thread_scratch: &'b mut ThreadScratch) -> BatchSolve<'b> {
        let Self { places, momentum_drift, normal_impulses, .. } = self;
        let Places { position, start, velocity, origin, radius, .. } = places;
        BatchSolve {
            context: self.context,
            task: &self.task,
            position,
            motion: BatchMotion::Substep { start, velocity, momentum_drift },
            origin,
            radius,
            normal_impulses: normal_impulses.reborrow(),
            reports: self.reports,
            scratch: thread_scratch.of_batches(),
        }
    }

    /// Solves a single large island by all workers.
    pub(super) fn solve_shared(mut self, thread_scratches: &Pool<ThreadScratch>) {
        let SolveContext { plan, execution, substep, .. } = self.context;
        let SubstepParameters { h, lag, .. } = substep;
        let number = self.task.islands.start;
        let island = &plan.islands.list[number];
        if island.is_skipped() {
            return;
        }
        let sweep = sweep_shared(plan, island, execution, thread_scratches);
        let mut microsteps =
            thread_scratches.with(|thread_scratch| take(&mut thread_scratch.microsteps));
        // Islands with measured loads have been solved already.
        let momentum_drift =
            if island.measured { None } else { self.solve_substep(number, sweep, &mut microsteps) };
        thread_scratches.with(|thread_scratch| thread_scratch.microsteps = microsteps);
        if island.takes_microsteps() {
            return;
        }
        if !self.momentum_drift.is_empty() {
            if let Some(momentum_drift) = &momentum_drift {
                self.note_drift(momentum_drift, number);
            }
            return;
        }
        let Self { context, task, mut places, mut normal_impulses, .. } = self;
        let Places { position, start, velocity, .. } = &mut places;
        derive(Derive { position, start, velocity, momentum_drift: &[], h, lag }, execution);
        if let Some(momentum_drift) = momentum_drift {
            momentum_drift.subtract_from(&mut places, plan.members(number));
        }
        context.bounce(&mut places, &mut normal_impulses, task.rows);
    }
}

/// A sweep by all workers together, cluster by cluster.
fn sweep_shared(
    plan: &Plan,
    island: &Island,
    execution: ExecutionContext,
    thread_scratches: &Pool<ThreadScratch>,
) -> impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32 {
    move |places, multipliers, mode| {
        let out = thread_scratches
            .with(|own| project_tethers_and_chains(plan, island, places, mode, &mut own.sweep));
        let cluster_batches = island.cluster_batches.clone();
        let found = gauss_seidel::sweep_shared(
            places.reborrow(),
            plan,
            cluster_batches,
            multipliers.reborrow(),
            mode,
            execution,
            thread_scratches,
        );
        thread_scratches.with(|own| {
            let at = &mut MixedPlaces { columns: None, places };
            Parts { plan, island, mode }.sweep_again(at, multipliers, &mut own.sweep);
            project_tethers_and_spans(plan, island, places, mode, execution, &mut own.sweep);
        });
        out.max(found)
    }
}
