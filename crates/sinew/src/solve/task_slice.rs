//! Task slices: the parts of the columns, multipliers and reports that belong to one task or one island.

use core::ops::Range;

use glam::Vec4;

use super::context::SolveContext;
use super::multipliers::MultiplierSlice;
use super::plan::Task;
use super::report::IslandReport;
use crate::collide::NormalImpulses;
use crate::integrate::{MotionColumns, Predict};
use crate::particles::Places;
use crate::settings::Order;

/// Islands with at least this many rows are shared by all workers, which synchronise after each stage of each sweep. Two workers have two thirds of the speed
/// of one at 16 thousand rows, and 1.2 times its speed at 65 thousand: at 16 thousand a stage takes some 30 µs, as long as synchronising, and each worker has
/// to fetch what another has written. Even spinning threads, which synchronise within a microsecond, only reach a speed-up of 1.1 there with two threads and
/// 1.4 with four.
const SHARED_ROWS: usize = 32_768;

/// A task with exclusive access to its part of everything.
pub(super) struct TaskSlice<'a> {
    pub(super) context: SolveContext<'a>,
    pub(super) task: Task,
    pub(super) places: Places<'a>,
    pub(super) motion: MotionColumns<'a>,
    pub(super) multipliers: MultiplierSlice<'a>,
    pub(super) normal_impulses: NormalImpulses<'a>,
    pub(super) reports: &'a mut [IslandReport],
    /// For each particle the velocity to be removed when it is derived later, m/s; empty if velocities are derived at once.
    pub(super) momentum_drift: &'a mut [Vec4],
}

/// Cuts everything into the tasks of a plan.
pub(super) fn slices<'a>(
    context: SolveContext<'a>,
    (places, motion): (Places<'a>, MotionColumns<'a>),
    multipliers: MultiplierSlice<'a>,
    normal_impulses: NormalImpulses<'a>,
    reports: &'a mut [IslandReport],
    momentum_drift: &'a mut [Vec4],
) -> impl Iterator<Item = TaskSlice<'a>> {
    let mut left = Some((places, motion, multipliers, normal_impulses, reports, momentum_drift));
    context.plan.tasks(context.execution.workers.is_none()).filter_map(move |task| {
        let (places, motion, multipliers, normal_impulses, reports, drift) = left.take()?;
        let (own, places) = places.split_at(task.rows.end);
        let (own_motion, motion) = motion.split_at(own.position.len());
        let (own_multipliers, multipliers) =
            multipliers.split(Some(task.distances.end), Some(task.constraints.end));
        let (own_impulses, normal_impulses) =
            context.contacts.split(normal_impulses, task.rows.end);
        let (own_reports, reports) = reports.split_at_mut(task.islands.len());
        let (own_drift, drift) = drift.split_at_mut(own.position.len().min(drift.len()));
        left = Some((places, motion, multipliers, normal_impulses, reports, drift));
        Some(TaskSlice {
            context,
            task,
            places: own,
            motion: own_motion,
            multipliers: own_multipliers,
            normal_impulses: own_impulses,
            reports: own_reports,
            momentum_drift: own_drift,
        })
    })
}

impl TaskSlice<'_> {
    /// Whether all workers solve it together. It is a single island then.
    pub(super) fn is_shared(&self) -> bool {
        let SolveContext { plan, execution, .. } = self.context;
        let order = plan.islands.list[self.task.islands.start].settings.order;
        let many = self.task.large && self.task.rows.len() >= SHARED_ROWS;
        many && execution.workers.is_some() && order == Order::GaussSeidel
    }

    /// Reborrows the slice with another context.
    pub(super) fn with_context<'b>(&'b mut self, context: SolveContext<'b>) -> TaskSlice<'b> {
        TaskSlice {
            context,
            task: self.task.clone(),
            places: self.places.reborrow(),
            motion: self.motion.reborrow(),
            multipliers: self.multipliers.reborrow(),
            normal_impulses: self.normal_impulses.reborrow(),
            reports: self.reports,
            momentum_drift: self.momentum_drift,
        }
    }

    /// The report of one of its islands.
    pub(super) fn report(&mut self, number: usize) -> &mut IslandReport {
        &mut self.reports[number - self.task.islands.start]
    }

    /// The slice of one of its islands.
    pub(super) fn island(&mut self, number: usize) -> IslandSlice<'_> {
        IslandSlice {
            places: self.places.reborrow(),
            multipliers: self.multipliers.reborrow(),
            normal_impulses: self.normal_impulses.reborrow(),
            report: &mut self.reports[number - self.task.islands.start],
        }
    }

    /// The prediction of some of its particles, counted from its first row.
    #[inline(always)]
    pub(super) fn predict(&mut self, rows: Range<usize>) -> Predict<'_> {
        let Places { position, start, velocity, .. } = &mut self.places;
        self.motion.predict([position, start, velocity], rows, self.context.substep.h)
    }
}

/// What solving an island changes: columns that contain its rows, and its report.
pub(super) struct IslandSlice<'a> {
    pub(super) places: Places<'a>,
    pub(super) multipliers: MultiplierSlice<'a>,
    pub(super) normal_impulses: NormalImpulses<'a>,
    pub(super) report: &'a mut IslandReport,
}
