//! Microsteps (multirate integration): a large soft island takes what sweeps it may have in a substep as steps of its own, one sweep in each.
//!
//! A thread of N pieces under an acceleration `a` is stretched by about `N a h²/s` after `s` sweeps in a substep of `h`: twice the sweeps halve that, half the
//! substep quarters it (Macklin et al., *Small Steps in Physics Simulation*, 2019). So an island that may have four sweeps goes through its substep in two
//! microsteps of one: half of the projections, at the same strain. What acts from outside is what the substep has summed up: forces are the same in all
//! microsteps, pins are led in equal parts, moving colliders are where they are at each.
//!
//! Towards everybody else a substep stays one step. Where contacts between bodies follow, they meet a particle that began where the substep began and has
//! come to where it is; what its last microstep left it faster or slower than that is given back after them.
//!
//! Substeps are taken as they are by small islands; by ropes and what else has few constraints for a particle, where integration would cost more than is
//! gained; by what keeps a volume, or has rigid parts; where springs pull, whose forces change with every bit of the way; and where
//! [loads](super::loads) are measured.

use core::ops::Range;

use glam::Vec4;

use super::IslandReport;
use super::instances::MOST;
use super::island::{Common, Sweeper, solve};
use super::momentum::MomentumDrift;
use super::multipliers::MultiplierSlice;
use super::plan::{GroupKind, Plan};
use super::remaining::Remaining;
use crate::collide::NormalImpulses;
use crate::constraints::{ConstraintKind, GradientAt};
use crate::integrate::{Derive, Integrator, Motion, StepRows, derive, predict_all};
use crate::islands::Island;
use crate::lanes::with;
use crate::particles::Places;
use crate::settings::Order;

/// As many sweeps of a substep are worth one microstep with one.
const SWEEPS: u32 = 2;

/// No microstep is shorter than this, seconds: positions are rounded to some 3e-8 of a metre, and what a step is rounded by is a speed.
const SHORTEST: f32 = 1.0 / 2500.0;

/// Which of several microsteps of a substep it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Microstep {
    /// From 0.
    pub(crate) number: u32,
    pub(crate) of: u32,
}

impl Microstep {
    /// A substep that is not divided.
    pub(crate) const WHOLE: Self = Self { number: 0, of: 1 };
}

/// Decides how an island of the `plan` goes through substeps of `h` seconds, when its settings are those of its bodies.
pub(crate) fn divide(plan: &mut Plan, number: usize, h: f32) {
    let island = &plan.islands.list[number];
    let settings = &island.settings;
    let suits = settings.microsteps
        && island.members.len() > MOST
        && !(island.rigid || island.has_solids || island.has_springs || island.measured)
        && plan.is_cloth(island)
        && settings.order == Order::GaussSeidel
        && settings.gradient_at == GradientAt::Current
        && settings.integrator == Integrator::Verlet
        && !settings.statics
        && plan.stretch(island).is_some();
    let island = &mut plan.islands.list[number];
    let sweeps = island.settings.max_sweeps;
    // A power of two: the instants of those that take few are among the instants of those that take many.
    let most = (sweeps / SWEEPS).min((h / SHORTEST) as u32).max(1).ilog2();
    island.microsteps = if suits { 1 << most } else { 1 };
    if island.microsteps > 1 {
        island.settings.max_sweeps = (sweeps / (SWEEPS * island.microsteps)).max(1);
    }
}

impl Plan {
    /// Whether an island is of distances and bends alone, of which each particle has several: then integration, which microsteps have more of, is the
    /// smaller part.
    fn is_cloth(&self, island: &Island) -> bool {
        let mut constraints = 0;
        let mut groups = self.groups[island.groups.clone()].iter();
        let suit = groups.all(|group| {
            constraints += group.range.len();
            let first = self.constraints.get(group.range.start);
            group.kind != GroupKind::Constraints
                || first.is_some_and(|first| {
                    matches!(first.kind, ConstraintKind::Bend(_) | ConstraintKind::Hinge(_))
                })
        });
        suit && constraints > 2 * island.members.len()
    }
}

/// What taking microsteps needs. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct MicrostepScratch {
    /// Where each particle was when the substep began.
    start: Vec<Vec4>,
    /// The places of pinned particles that are led, and where to.
    led: Vec<(usize, Vec4)>,
}

/// Solves an island through a substep of which the first microstep has been predicted: whole, and returns what is to be taken off when its velocities are
/// derived, as [`solve`] does; or in its microsteps, and then that is done.
pub(super) fn solve_substep(
    common: Common,
    number: usize,
    bodies: (&mut Places, &mut Motion),
    multipliers: &mut MultiplierSlice,
    normal_impulses: &mut NormalImpulses,
    report: &mut IslandReport,
    sweeper: impl Sweeper,
    out: (&mut [Vec4], &mut MicrostepScratch),
) -> Option<MomentumDrift> {
    if common.plan.islands.list[number].takes_microsteps() {
        take_microsteps(common, number, bodies, multipliers, normal_impulses, report, sweeper, out);
        return None;
    }
    solve(common, number, bodies.0, multipliers, normal_impulses, report, sweeper)
}

/// Takes an island, whose first microstep has been predicted, through all of them: its velocities are derived, and have bounced. If they are to be derived
/// once more, after contacts between bodies, what is to be taken off of each row then is written to `later`, which is empty otherwise.
fn take_microsteps(
    common: Common,
    number: usize,
    (places, motion): (&mut Places, &mut Motion),
    multipliers: &mut MultiplierSlice,
    normal_impulses: &mut NormalImpulses,
    report: &mut IslandReport,
    mut sweeper: impl Sweeper,
    (later, scratch): (&mut [Vec4], &mut MicrostepScratch),
) {
    let Common { plan, execution, .. } = common;
    let island = &plan.islands.list[number];
    let members = &plan.islands.members[island.members.clone()];
    let rows = members[0]..members[0] + members.len() as u32;
    let span = places.at(rows.start)..places.at(rows.start) + members.len();
    let of = island.microsteps;
    let h = common.h / of as f32;
    scratch.begin(places, span.clone(), !later.is_empty());
    let mut sweeps = 0;
    for number_of_step in 0..of {
        if number_of_step > 0 {
            let columns = [&mut *places.position, &mut *places.start, &mut *places.velocity];
            predict_all(motion.predict(columns, span.clone(), h), execution);
        }
        scratch.lead(places, of - number_of_step);
        let microstep = Microstep { number: number_of_step, of };
        let common = Common { h, lag: h, microstep, ..common };
        let drift =
            solve(common, number, places, multipliers, normal_impulses, report, &mut sweeper);
        sweeps += report.last_sweeps;
        let all = Derive {
            position: &places.position[span.clone()],
            start: &places.start[span.clone()],
            velocity: &mut places.velocity[span.clone()],
            momentum_drift: &[],
            h,
            lag: h,
        };
        derive(all, execution);
        if let Some(drift) = drift {
            drift.take_off(places, members);
        }
        common.bounce(places, normal_impulses, rows.clone());
    }
    report.last_sweeps = sweeps;
    report.most_sweeps = report.most_sweeps.max(sweeps);
    if !later.is_empty() {
        scratch.join(places, span, common.h, later);
    }
}

impl MicrostepScratch {
    fn begin(&mut self, places: &Places, span: Range<usize>, keeps_start: bool) {
        let Self { start, led } = self;
        start.clear();
        if keeps_start {
            start.extend_from_slice(&places.start[span.clone()]);
        }
        led.clear();
        led.extend(span.filter_map(|i| {
            let end = places.position[i];
            (end.w == 0.0 && end != places.start[i]).then_some((i, end))
        }));
    }

    /// Leads pinned particles by one of so many equal parts of what they have left.
    fn lead(&self, places: &mut Places, remaining: u32) {
        for &(i, end) in &self.led {
            let from = places.start[i];
            places.position[i] =
                if remaining > 1 { from + (end - from) / remaining as f32 } else { end };
        }
    }

    /// Makes one step of `h` seconds of all microsteps: from where the first began, at the mean velocity.
    fn join(&self, places: &mut Places, span: Range<usize>, h: f32, later: &mut [Vec4]) {
        let per_second = 1.0 / h;
        for (i, start) in span.zip(&self.start) {
            let own = places.velocity[i];
            let mean = ((places.position[i] - *start) * per_second).truncate();
            later[i] = (mean - own.truncate()).extend(0.0);
            places.velocity[i] = mean.extend(own.w);
            places.start[i] = *start;
        }
    }
}

/// Lists rows that are left of a task by the microsteps they take, counted from the first row of the task.
pub(super) fn list_step_rows(
    plan: &Plan,
    first: u32,
    remaining: &Remaining,
    step_rows: &mut Vec<StepRows>,
) {
    step_rows.clear();
    let mut divided = remaining.islands.iter().cloned().flatten().filter_map(|number| {
        let island = &plan.islands.list[number];
        let rows = island.takes_microsteps().then(|| plan.stretch(island)).flatten()?;
        Some((rows, island.microsteps))
    });
    let mut next = divided.next();
    let mut push = |rows: Range<usize>, microsteps: u32| {
        if !rows.is_empty() {
            let rows = rows.start - first as usize..rows.end - first as usize;
            step_rows.push(StepRows { rows, microsteps });
        }
    };
    for rows in &remaining.rows {
        let mut rows = rows.start as usize..rows.end as usize;
        while let Some((own, microsteps)) = next.take_if(|(own, _)| own.start < rows.end) {
            push(rows.start..own.start, 1);
            push(own.clone(), microsteps);
            rows.start = own.end;
            next = divided.next();
        }
        push(rows, 1);
    }
}

/// Derives the velocities of rows that have taken a substep whole. Of others they are derived.
pub(super) fn derive_whole_steps(places: &mut Places, step_rows: &[StepRows], common: Common) {
    let Common { h, lag, execution, .. } = common;
    for rows in step_rows.iter().filter(|rows| rows.microsteps == 1).map(|all| all.rows.clone()) {
        let derive = Derive {
            position: &places.position[rows.clone()],
            start: &places.start[rows.clone()],
            velocity: &mut places.velocity[rows],
            momentum_drift: &[],
            h,
            lag,
        };
        with(execution.instructions, derive);
    }
}
