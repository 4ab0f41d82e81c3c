//! Microsteps (multirate integration): a large soft island replaces the sweeps of a substep by shorter steps of its own, with fewer sweeps in each.
//!
//! A thread of N pieces under an acceleration `a` is stretched by about `N a h²/s` after `s` sweeps in a substep of `h`: twice the sweeps halve that, half the
//! substep quarters it (Macklin et al., *Small Steps in Physics Simulation*, 2019). So an island with four sweeps goes through its substep in two microsteps of
//! one sweep: half of the projections, at the same strain. External influences are those of the substep: forces are the same in all microsteps, kinematic pins
//! move in equal parts, and moving colliders are at their interpolated positions.
//!
//! For the other islands a substep remains one step. Contacts between bodies that follow act on a particle that moved from its position at the beginning of the
//! substep to its present one. After them it continues with the velocity of its last microstep plus what the contacts changed.
//!
//! Microsteps are not used for small islands; for ropes and other islands with few constraints for each particle, where integration would cost more than is
//! gained; for islands that keep a volume or move as an explicit rigid body; where springs pull, whose forces change along the way; and where
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

/// Number of sweeps of a substep that are replaced by one microstep with one sweep.
const SWEEPS_PER_MICROSTEP: u32 = 2;

/// An island with more contiguous ranges of rows than this takes no microsteps.
const MAX_RUNS: usize = 32;

/// Least length of a microstep, seconds: positions are rounded to about 3e-8 m, and in a shorter step that becomes a noticeable velocity.
const MIN_STEP: f32 = 1.0 / 2500.0;

/// Decides how island `number` goes through substeps of `h` seconds. Its settings are those of its bodies; `most` are the settings of the body to which most of
/// the island belongs. Where bodies tied to cloth require more sweeps than the cloth, they get several sweeps in each sweep of the cloth.
pub(crate) fn divide(plan: &mut Plan, number: usize, h: f32, most: SolverSettings) {
    let island = &plan.islands.list[number];
    let settings = &island.settings;
    let eligible = settings.microsteps
        && !island.is_small()
        && !(island.rigid || island.has_springs || island.measured)
        && plan.is_cloth(island)
        && settings.order == Order::GaussSeidel
        && settings.gradient_at == GradientAt::Current
        && settings.integrator == Integrator::Verlet
        && !settings.statics
        && plan.runs(island).take(MAX_RUNS + 1).count() <= MAX_RUNS;
    let parts_apart = eligible && plan.is_mostly_in_columns(island);
    let island = &mut plan.islands.list[number];
    island.tie_sweeps = 1;
    if parts_apart && most.max_sweeps < island.settings.max_sweeps {
        island.tie_sweeps = island.settings.max_sweeps.div_ceil(most.max_sweeps);
        island.settings.max_sweeps = most.max_sweeps;
    }
    let sweeps = island.settings.max_sweeps;
    // A power of two, so that the instants of islands with few microsteps are among the instants of those with many.
    let most = (sweeps / SWEEPS_PER_MICROSTEP).min((h / MIN_STEP) as u32).max(1).ilog2();
    island.microsteps = if eligible { 1 << most } else { 1 };
    if island.microsteps > 1 {
        island.settings.max_sweeps = (sweeps / (SWEEPS_PER_MICROSTEP * island.microsteps)).max(1);
    }
}

impl Plan {
    /// The rows of an island that takes microsteps.
    pub(crate) fn step_rows(&self, island: &Island) -> impl Iterator<Item = StepRows> {
        let microsteps = island.microsteps;
        self.runs(island)
            .map(move |run| StepRows { rows: run.start as usize..run.end as usize, microsteps })
    }

    /// Whether an island is cloth with what is tied to it: each particle has several constraints, so that integration, which microsteps multiply, is the
    /// smaller part, and no constraint keeps a volume, an area or a rigid shape.
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

/// Whether a constraint is a bend, a joint or a tie.
fn bends_or_ties(kind: &ConstraintKind) -> bool {
    use ConstraintKind::{Anchors, Angle, Bend, Cone, Hinge};
    matches!(kind, Anchors(_) | Angle(_) | Bend(_) | Cone(_) | Hinge(_))
}

impl TaskSlice<'_> {
    /// Solves an island through a substep of which the first microstep has been predicted. Either as a whole, and returns the momentum drift to be removed when
    /// its velocities are derived, as [`solve`] does; or in microsteps, which derive the velocities themselves.
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

    /// Takes an island, whose first microstep has been predicted, through all microsteps, including velocities and restitution. If velocities are to be derived
    /// again, after contacts between bodies, the correction of each row that is then needed is recorded.
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
            scratch.move_kinematic(&mut self.places, of - number_of_step);
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
                drift.subtract_from(places, members);
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
        self.report(number).note_substep(sweeps);
        if !self.momentum_drift.is_empty() {
            scratch.join(&mut self.places, &runs, substep.h, self.momentum_drift);
        }
        scratch.runs = runs;
    }
}

/// Scratch for microsteps.
#[derive(Clone, Debug, Default)]
pub(super) struct MicrostepScratch {
    /// Ranges of the island's particles among the places.
    runs: Vec<Range<usize>>,
    /// Position of each particle at the beginning of the substep.
    start: Vec<Vec4>,
    /// Indices of kinematic pins, and their target positions.
    kinematic: Vec<(usize, Vec4)>,
    /// Displacement of each particle by relaxation.
    moved: Vec<Vec4>,
    strain: StrainScratch,
    /// Inverse masses of the particles that relaxation treats as pinned, 1/kg.
    masses: Vec<f32>,
    /// Rows of a task that take microsteps.
    pub(super) divided_rows: Vec<StepRows>,
}

impl MicrostepScratch {
    fn begin(&mut self, places: &Places, runs: &[Range<usize>], keeps_start: bool) {
        let Self { start, kinematic, .. } = self;
        start.clear();
        kinematic.clear();
        for run in runs.iter().cloned() {
            if keeps_start {
                start.extend_from_slice(&places.start[run.clone()]);
            }
            let all = places.position[run.clone()].chunks(2 * LANES);
            for (begin, some) in run.step_by(2 * LANES).zip(all) {
                // Few particles are pinned, so several are tested at once.
                if some.iter().fold(false, |pinned, end| pinned | (end.w == 0.0)) {
                    let each = (begin..).zip(some);
                    let moves = each.filter(|(i, end)| end.w == 0.0 && **end != places.start[*i]);
                    kinematic.extend(moves.map(|(i, end)| (i, *end)));
                }
            }
        }
    }

    /// Moves kinematic pins by one of `remaining` equal parts of the rest of their way.
    fn move_kinematic(&self, places: &mut Places, remaining: u32) {
        for &(i, end) in &self.kinematic {
            let from = places.start[i];
            places.position[i] =
                if remaining > 1 { from + (end - from) / remaining as f32 } else { end };
        }
    }

    /// Combines all microsteps into one step of `h` seconds: from the first position, at the mean velocity. Stores in `later` the velocity that [`resume`]
    /// restores.
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

/// Restores to rows whose microsteps have been [joined](MicrostepScratch::join) the velocities after the last of them, plus what contacts between bodies have
/// moved them by since, in a substep of `h` seconds. Particles that have not been moved get their own velocity back bit by bit, so contacts elsewhere do not
/// affect them.
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

/// The mean velocity from one position to another within `1/per_second` seconds, m/s. One function, because [`resume`] relies on the same result bit by bit.
#[inline(always)]
fn mean_velocity(to: Vec4, from: Vec4, per_second: f32) -> Vec3 {
    ((to - from) * per_second).truncate()
}

/// Lists the remaining rows of a task by the microsteps that they take, counted from the first row of the task. `divided` is scratch.
pub(super) fn list_step_rows(
    plan: &Plan,
    first: u32,
    remaining: &Remaining,
    step_rows: &mut Vec<StepRows>,
    divided: &mut Vec<StepRows>,
) {
    step_rows.clear();
    divided.clear();
    let islands = remaining.islands.iter().cloned().flatten();
    let islands = islands.map(|number| &plan.islands.list[number]);
    for island in islands.filter(|island| island.takes_microsteps()) {
        divided.extend(plan.step_rows(island));
    }
    divided.sort_unstable_by_key(|own| own.rows.start);
    let mut divided = divided.iter().cloned().peekable();
    let first = first as usize;
    for rows in &remaining.rows {
        StepRows::split(rows.start as usize..rows.end as usize, &mut divided, |mut own| {
            own.rows = own.rows.start - first..own.rows.end - first;
            step_rows.push(own);
        });
    }
}

/// Derives the velocities of rows that took the substep as a whole. Those of the others have been derived.
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
