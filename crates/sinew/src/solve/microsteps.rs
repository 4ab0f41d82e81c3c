//! Microsteps (multirate integration): a large soft island takes what sweeps it may have in a substep as steps of its own, one sweep in each.
//!
//! A thread of N pieces under an acceleration `a` is stretched by about `N a h²/s` after `s` sweeps in a substep of `h`: twice the sweeps halve that, half the
//! substep quarters it (Macklin et al., *Small Steps in Physics Simulation*, 2019). So an island that may have four sweeps goes through its substep in two
//! microsteps of one: half of the projections, at the same strain. What acts from outside is what the substep has summed up: forces are the same in all
//! microsteps, pins are led in equal parts, moving colliders are where they are at each.
//!
//! Towards everybody else a substep stays one step. Where contacts between bodies follow, they meet a particle that began where the substep began and has
//! come to where it is. After them it goes on as its last microstep left it, and with what they have moved it by.
//!
//! Substeps are taken as they are by small islands; by ropes and what else has few constraints for a particle, where integration would cost more than is
//! gained; by what keeps a volume, or moves as an explicit rigid body; where springs pull, whose forces change with every bit of the way; and where
//! [loads](super::loads) are measured.

use core::ops::Range;

use glam::{Vec3, Vec4};

use super::constraint_ref::SolveMode;
use super::context::{Microstep, SolveContext, SubstepParameters};
use super::island::solve;
use super::momentum::MomentumDrift;
use super::multipliers::MultiplierSlice;
use super::plan::{GroupKind, Plan};
use super::relaxation::{may_relax, relax};
use super::remaining::Remaining;
use super::strain_limit::StrainScratch;
use super::task_slice::TaskSlice;
use crate::constraints::{ConstraintKind, GradientAt};
use crate::integrate::{Derive, Integrator, Predict, StepRows, derive, predict_all};
use crate::islands::Island;
use crate::lanes::{LANES, with};
use crate::particles::Places;
use crate::settings::{Order, SolverSettings};

/// As many sweeps of a substep are worth one microstep with one.
const SWEEPS: u32 = 2;

/// An island whose rows are in more stretches than this takes substeps as they are.
const MOST_RUNS: usize = 32;

/// No microstep is shorter than this, seconds: positions are rounded to some 3e-8 of a metre, and what a step is rounded by is a speed.
const SHORTEST: f32 = 1.0 / 2500.0;

/// Decides how an island of the `plan` goes through substeps of `h` seconds, when its settings are those of its bodies; `most` are those of the body that most of it
/// is of. Of cloth that something else is tied to, which asks for more sweeps, that gets more in each sweep.
pub(crate) fn divide(plan: &mut Plan, number: usize, h: f32, most: SolverSettings) {
    let island = &plan.islands.list[number];
    let settings = &island.settings;
    let suits = settings.microsteps
        && !island.is_small()
        && !(island.rigid || island.has_springs || island.measured)
        && plan.is_cloth(island)
        && settings.order == Order::GaussSeidel
        && settings.gradient_at == GradientAt::Current
        && settings.integrator == Integrator::Verlet
        && !settings.statics
        && plan.runs(island).take(MOST_RUNS + 1).count() <= MOST_RUNS;
    let parts_apart = suits && plan.is_mostly_in_columns(island);
    let island = &mut plan.islands.list[number];
    island.sweeps_of_parts = 1;
    if parts_apart && most.max_sweeps < island.settings.max_sweeps {
        island.sweeps_of_parts = island.settings.max_sweeps.div_ceil(most.max_sweeps);
        island.settings.max_sweeps = most.max_sweeps;
    }
    let sweeps = island.settings.max_sweeps;
    // A power of two: the instants of those that take few are among the instants of those that take many.
    let most = (sweeps / SWEEPS).min((h / SHORTEST) as u32).max(1).ilog2();
    island.microsteps = if suits { 1 << most } else { 1 };
    if island.microsteps > 1 {
        island.settings.max_sweeps = (sweeps / (SWEEPS * island.microsteps)).max(1);
    }
}

impl Plan {
    /// The rows of an island that takes microsteps.
    pub(crate) fn step_rows(&self, island: &Island) -> impl Iterator<Item = StepRows> {
        let microsteps = island.microsteps;
        self.runs(island)
            .map(move |run| StepRows { rows: run.start as usize..run.end as usize, microsteps })
    }

    /// Whether an island is cloth, and what is tied to it: of which each particle has several constraints, so that integration, which microsteps have more
    /// of, is the smaller part, and none keeps a volume, an area or a rigid shape.
    fn is_cloth(&self, island: &Island) -> bool {
        let mut constraints = 0;
        let mut groups = self.groups[island.groups.clone()].iter();
        let suit = groups.all(|group| {
            constraints += group.range.len();
            let first = self.constraints.get(group.range.start);
            group.kind != GroupKind::Constraints
                || first.is_some_and(|one| bends_or_ties(&one.kind))
        });
        suit && constraints > 2 * island.members.len()
    }
}

/// Whether it is a bend, a joint or a tie.
fn bends_or_ties(kind: &ConstraintKind) -> bool {
    use ConstraintKind::{Anchors, Angle, Bend, Cone, Hinge};
    matches!(kind, Anchors(_) | Angle(_) | Bend(_) | Cone(_) | Hinge(_))
}

impl TaskSlice<'_> {
    /// Solves an island through a substep of which the first microstep has been predicted: whole, and returns what is to be taken off when its velocities are
    /// derived, as [`solve`] does; or in its microsteps, and then that is done.
    pub(super) fn solve_substep(
        &mut self,
        number: usize,
        sweep: impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32,
        scratch: &mut MicrostepScratch,
    ) -> Option<MomentumDrift> {
        if self.context.plan.islands.list[number].takes_microsteps() {
            self.take_microsteps(number, sweep, scratch);
            return None;
        }
        solve(self.context, number, self.island(number), sweep)
    }

    /// Takes an island, whose first microstep has been predicted, through all of them: its velocities are derived, and have bounced. If they are to be derived
    /// once more, after contacts between bodies, what is to be taken off of each row then is noted.
    fn take_microsteps(
        &mut self,
        number: usize,
        mut sweep: impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32,
        scratch: &mut MicrostepScratch,
    ) {
        let SolveContext { plan, execution, .. } = self.context;
        let island = &plan.islands.list[number];
        let members = &plan.islands.members[island.members.clone()];
        let of = island.microsteps;
        let places_of = |run: Range<u32>| self.places.at(run.start)..self.places.at(run.end);
        let mut runs = core::mem::take(&mut scratch.runs);
        runs.clear();
        runs.extend(plan.runs(island).map(places_of));
        let substep = self.context.substep;
        let h = substep.h / of as f32;
        scratch.begin(&self.places, &runs, !self.momentum_drift.is_empty());
        let ends_step = substep.number + 1 == substep.of;
        let mut sweeps = 0;
        for number_of_step in 0..of {
            if number_of_step > 0 {
                for run in &runs {
                    predict_all(Predict { h, ..self.predict(run.clone()) }, execution);
                }
            }
            scratch.lead(&mut self.places, of - number_of_step);
            let microstep = Microstep { number: number_of_step, of };
            let context = self.context.divided(microstep, h);
            let drift = solve(context, number, self.island(number), &mut sweep);
            sweeps += self.report(number).last_sweeps;
            let places = &mut self.places;
            for run in &runs {
                let all = Derive {
                    position: &places.position[run.clone()],
                    start: &places.start[run.clone()],
                    velocity: &mut places.velocity[run.clone()],
                    momentum_drift: &[],
                    h,
                    lag: h,
                };
                derive(all, execution);
            }
            let is_held = drift.is_none();
            if let Some(drift) = drift {
                drift.take_off(places, members);
            }
            for run in plan.runs(island) {
                context.bounce(places, &mut self.normal_impulses, run);
            }
            if is_held
                && ends_step
                && number_of_step + 1 == of
                && may_relax(plan, island)
                && let [run] = &runs[..]
            {
                let MicrostepScratch { start, moved, strain, masses, .. } = &mut *scratch;
                let scratch = (&mut *moved, strain, masses);
                relax(context, number, self.island(number), run.clone(), &mut sweep, scratch);
                start.iter_mut().zip(moved).for_each(|(start, moved)| *start += *moved);
            }
        }
        let report = self.report(number);
        report.last_sweeps = sweeps;
        report.most_sweeps = report.most_sweeps.max(sweeps);
        if !self.momentum_drift.is_empty() {
            scratch.join(&mut self.places, &runs, substep.h, self.momentum_drift);
        }
        scratch.runs = runs;
    }
}

/// What taking microsteps needs. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct MicrostepScratch {
    /// Where the particles of the island are among the places, stretch by stretch.
    runs: Vec<Range<usize>>,
    /// Where each particle was when the substep began.
    start: Vec<Vec4>,
    /// The places of pinned particles that are led, and where to.
    led: Vec<(usize, Vec4)>,
    /// How far a relaxation moved each particle.
    moved: Vec<Vec4>,
    strain: StrainScratch,
    /// Inverse masses of what a relaxation held, 1/kg.
    masses: Vec<f32>,
    /// Rows of a task that take microsteps.
    pub(super) apart: Vec<StepRows>,
}

impl MicrostepScratch {
    fn begin(&mut self, places: &Places, runs: &[Range<usize>], keeps_start: bool) {
        let Self { start, led, .. } = self;
        start.clear();
        led.clear();
        for run in runs.iter().cloned() {
            if keeps_start {
                start.extend_from_slice(&places.start[run.clone()]);
            }
            let all = places.position[run.clone()].chunks(2 * LANES);
            for (begin, some) in run.step_by(2 * LANES).zip(all) {
                // Few are pinned: it is asked of several at once.
                if some.iter().fold(false, |pinned, end| pinned | (end.w == 0.0)) {
                    let each = (begin..).zip(some);
                    let moves = each.filter(|(i, end)| end.w == 0.0 && **end != places.start[*i]);
                    led.extend(moves.map(|(i, end)| (i, *end)));
                }
            }
        }
    }

    /// Leads pinned particles by one of so many equal parts of what they have left.
    fn lead(&self, places: &mut Places, remaining: u32) {
        for &(i, end) in &self.led {
            let from = places.start[i];
            places.position[i] =
                if remaining > 1 { from + (end - from) / remaining as f32 } else { end };
        }
    }

    /// Makes one step of `h` seconds of all microsteps: from where the first began, at the mean velocity. What [`resume`] gives each its own velocity back by
    /// goes to `later`.
    fn join(&self, places: &mut Places, runs: &[Range<usize>], h: f32, later: &mut [Vec4]) {
        for (i, start) in runs.iter().cloned().flatten().zip(&self.start) {
            let own = places.velocity[i];
            let mean = mean_velocity(places.position[i], *start, 1.0 / h);
            later[i] = (-own.truncate()).extend(0.0);
            places.velocity[i] = mean.extend(own.w);
            places.start[i] = *start;
        }
    }
}

/// Gives rows, whose microsteps have been [joined](MicrostepScratch::join), the velocities that they had after the last of them, and what contacts between bodies
/// have moved them by since, in a substep of `h` seconds. Who has not been moved has what it had, bit by bit: it is nothing to it that others touch
/// each other somewhere.
pub(super) fn resume(places: &mut Places, rows: Range<usize>, momentum_drift: &[Vec4], h: f32) {
    let (position, start) = (&places.position[rows.clone()], &places.start[rows.clone()]);
    let drifts = &momentum_drift[rows.clone()];
    let each = position.iter().zip(start).zip(&mut places.velocity[rows]).zip(drifts);
    for (((position, start), velocity), drift) in each {
        let mean = mean_velocity(*position, *start, 1.0 / h);
        let (moved, drift) = (mean - velocity.truncate(), drift.truncate());
        let now = if moved == Vec3::ZERO { -drift } else { moved - drift };
        *velocity = now.extend(velocity.w);
    }
}

/// From one place to another within `1/per_second` seconds, m/s: one formula, for it is asked whether it comes to the same again.
#[inline(always)]
fn mean_velocity(to: Vec4, from: Vec4, per_second: f32) -> Vec3 {
    ((to - from) * per_second).truncate()
}

/// Lists rows that are left of a task by the microsteps they take, counted from the first row of the task. `apart` is scratch.
pub(super) fn list_step_rows(
    plan: &Plan,
    first: u32,
    remaining: &Remaining,
    step_rows: &mut Vec<StepRows>,
    apart: &mut Vec<StepRows>,
) {
    step_rows.clear();
    apart.clear();
    let islands = remaining.islands.iter().cloned().flatten();
    let islands = islands.map(|number| &plan.islands.list[number]);
    for island in islands.filter(|island| island.takes_microsteps()) {
        apart.extend(plan.step_rows(island));
    }
    apart.sort_unstable_by_key(|own| own.rows.start);
    let mut apart = apart.iter().cloned().peekable();
    let first = first as usize;
    for rows in &remaining.rows {
        StepRows::cut(rows.start as usize..rows.end as usize, &mut apart, |mut own| {
            own.rows = own.rows.start - first..own.rows.end - first;
            step_rows.push(own);
        });
    }
}

/// Derives the velocities of rows that have taken a substep whole. Of others they are derived.
pub(super) fn derive_whole_steps(
    places: &mut Places,
    step_rows: &[StepRows],
    context: SolveContext,
) {
    let SolveContext { substep: SubstepParameters { h, lag, .. }, execution, .. } = context;
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
