//! One island: particles that constraints connect, solved until they hold or the sweeps are spent, whatever happens elsewhere.

use core::ops::Range;
use std::time::Instant;

use super::constraint_ref::{ConstraintRef, Local, SolveMode};
use super::instances::{LaneCompaction, LaneParticles, MOST};
use super::microsteps::{Microstep, MicrostepScratch};
use super::momentum::MomentumDrift;
use super::multipliers::MultiplierSlice;
use super::plan::{GroupKind, Plan, Task};
use super::remaining::Remaining;
use super::wavefront::Wavefront;
use super::{IslandReport, gauss_seidel, jacobi, most_violated_first};
use crate::collide::{InstantSpan, NormalImpulses, ParticleContacts, recovery};
use crate::constraints::{GradientAt, SubstepContext};
use crate::integrate::StepRows;
use crate::islands::Island;
use glam::Vec4;

use crate::lanes::Columns;
use crate::particles::Places;
use crate::settings::Order;
use crate::threads::ExecutionContext;

/// What a thread needs while it solves. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct ThreadScratch {
    pub(super) local: Local,
    pub(super) columns: Columns,
    /// Where the pins of an island are that has tethers.
    pub(super) pins: Vec<Vec4>,
    constraint_refs: Vec<ConstraintRef>,
    asked: jacobi::Asked,
    queue: most_violated_first::Queue,
    pub(super) lane_compaction: LaneCompaction,
    /// Of measuring them.
    pub(super) lane_particles: Vec<LaneParticles>,
    /// What is left of a task beside its instance batches.
    pub(super) remaining: Remaining,
    /// Where a large island is meanwhile.
    pub(super) wavefront: Wavefront,
    /// Rows of a task by how they step.
    pub(super) step_rows: Vec<StepRows>,
    pub(super) microsteps: MicrostepScratch,
    /// Islands whose corrections gave them what has to be taken off again.
    pub(super) momentum_drifts: Vec<(u32, MomentumDrift)>,
}

impl ThreadScratch {
    /// For looking at constraints one by one.
    pub(super) fn constraints(&mut self) -> (&mut Local, &mut Vec<ConstraintRef>) {
        (&mut self.local, &mut self.constraint_refs)
    }

    /// Begins with a task.
    pub(super) fn begin(&mut self, task: &Task) {
        self.remaining.reset(task);
        self.momentum_drifts.clear();
    }
}

/// What solving needs to know, the same for all islands.
#[derive(Clone, Copy)]
pub(crate) struct Common<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) contacts: &'a ParticleContacts,
    /// Length of the substep, seconds.
    pub(crate) h: f32,
    /// How much of it a derived velocity is the mean of, seconds.
    pub(crate) lag: f32,
    /// Magnitude of gravity, m/s².
    pub(crate) gravity: f32,
    /// Which substep of the step it is, counted from 0.
    pub(crate) substep: u32,
    /// Which part of it.
    pub(crate) microstep: Microstep,
    pub(crate) execution: ExecutionContext<'a>,
}

impl Common<'_> {
    /// From when to when surfaces move in it.
    pub(super) fn span(&self) -> InstantSpan {
        let Microstep { number, of } = self.microstep;
        self.contacts.span(self.substep, number, of)
    }

    /// The same, for one worker alone.
    pub(super) fn by_one(self) -> Self {
        Self { execution: ExecutionContext { workers: None, ..self.execution }, ..self }
    }

    /// Bounces rows off what they touched, when their velocities have been derived.
    pub(super) fn bounce(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        rows: Range<u32>,
    ) {
        if self.contacts.bounces() {
            self.contacts.bounce(places, normal_impulses, rows, (self.h, self.gravity));
        }
    }
}

/// What makes one sweep over an island, and returns the largest error that it found, metres.
pub(super) trait Sweeper {
    fn sweep(
        &mut self,
        places: &mut Places,
        multipliers: &mut MultiplierSlice,
        mode: SolveMode,
    ) -> f32;
}

impl<S: Sweeper> Sweeper for &mut S {
    fn sweep(
        &mut self,
        places: &mut Places,
        multipliers: &mut MultiplierSlice,
        mode: SolveMode,
    ) -> f32 {
        (**self).sweep(places, multipliers, mode)
    }
}

/// One worker, in whatever order the island asks for.
pub(super) struct InOrder<'a> {
    plan: &'a Plan,
    island: &'a Island,
    thread_scratch: &'a mut ThreadScratch,
}

impl<'a> InOrder<'a> {
    #[inline]
    pub(super) fn new(
        plan: &'a Plan,
        island: &'a Island,
        thread_scratch: &'a mut ThreadScratch,
    ) -> Self {
        if island.settings.order != Order::GaussSeidel {
            list_constraint_refs(plan, island, &mut thread_scratch.constraint_refs);
        }
        Self { plan, island, thread_scratch }
    }
}

impl Sweeper for InOrder<'_> {
    fn sweep(
        &mut self,
        places: &mut Places,
        multipliers: &mut MultiplierSlice,
        mode: SolveMode,
    ) -> f32 {
        let Self { plan, island, thread_scratch } = self;
        if island.settings.order == Order::GaussSeidel {
            let cluster_batches = island.cluster_batches.clone();
            let alone = ExecutionContext { instructions: mode.instructions, workers: None };
            let out = hold_tethers(plan, island, places, mode, alone, thread_scratch);
            let found = gauss_seidel::sweep(
                places,
                plan,
                cluster_batches,
                multipliers,
                mode,
                thread_scratch,
            );
            return out.max(found);
        }
        let ThreadScratch { local, constraint_refs, asked, queue, .. } = *thread_scratch;
        if island.settings.order == Order::Jacobi {
            return jacobi::sweep(
                places,
                plan,
                multipliers,
                island,
                constraint_refs,
                mode,
                local,
                asked,
            );
        }
        let tolerance = island.settings.tolerance;
        most_violated_first::sweep(
            places,
            plan,
            multipliers,
            island,
            constraint_refs,
            mode,
            local,
            queue,
            tolerance,
        )
    }
}

/// Solves the island of a number; returns what its corrections gave it and should not have.
///
/// Constraints come first, contacts last: what must not be seen to fail, a foot in the ground, has the last word. A sweep's error is what it
/// *found*, before it corrected it: reaching the tolerance therefore costs no extra pass, and is never claimed too early.
pub(super) fn solve(
    common: Common,
    number: usize,
    places: &mut Places,
    multipliers: &mut MultiplierSlice,
    normal_impulses: &mut NormalImpulses,
    report: &mut IslandReport,
    mut sweeper: impl Sweeper,
) -> Option<MomentumDrift> {
    let Common { plan, h, execution, .. } = common;
    let island = &plan.islands.list[number];
    let (settings, rows) = (&island.settings, &plan.islands.members[island.members.clone()]);
    let began = settings.timed.then(Instant::now);
    let mut gradient_at = settings.gradient_at;
    if gradient_at == GradientAt::StepStart && turns_too_fast(places, plan, island) {
        gradient_at = GradientAt::Current;
        report.fallbacks += 1;
    }
    reset_multipliers(plan, island, multipliers);
    let sweeps = settings.max_sweeps * common.microstep.of;
    let substep_context = SubstepContext { h, sweeps };
    let most = recovery(h, common.gravity);
    let (mut sweeps, mut converged, mut touched) = (0, false, false);
    while sweeps < settings.max_sweeps && !converged {
        let (tethers, instructions) = (sweeps == 0 || rows.len() > MOST, execution.instructions);
        let mode = SolveMode { substep_context, gradient_at, tethers, instructions };
        let found =
            if island.groups.is_empty() { 0.0 } else { sweeper.sweep(places, multipliers, mode) };
        report.violated = if sweeps == 0 { found > most } else { report.violated };
        let depth = project_contacts(common, places, normal_impulses, (number, rows));
        touched |= depth > 0.0;
        sweeps += 1;
        converged = found.max(depth) <= settings.tolerance;
    }
    report.sweeps += sweeps;
    report.most_sweeps = report.most_sweeps.max(sweeps);
    report.last_sweeps = sweeps;
    report.converged &= converged;
    let keeps_angular = gradient_at == GradientAt::StepStart || settings.keep_spin;
    let free = island.free && !touched;
    let momentum_drift =
        if free { MomentumDrift::of(places, rows, h, keeps_angular) } else { None };
    report.seconds += began.map_or(0.0, |began| began.elapsed().as_secs_f64());
    momentum_drift
}

/// Holds what hangs on pins to what it may be away from them, and particles of large cloth to what they may be away from each other, once, before the rods
/// have their say: returns how far out the farthest from its pin was, metres. Where corrections are to keep energy, along the start of the substep, there
/// are none; and small islands are held so in the first sweep of a substep alone, after which little is left to hold.
pub(super) fn hold_tethers(
    plan: &Plan,
    island: &Island,
    places: &mut Places,
    mode: SolveMode,
    execution: ExecutionContext,
    thread_scratch: &mut ThreadScratch,
) -> f32 {
    if mode.gradient_at == GradientAt::StepStart || !mode.tethers {
        return 0.0;
    }
    let out = plan.tethers.of(island).map_or(0.0, |tethers| {
        let pins = &mut thread_scratch.pins;
        pins.clear();
        pins.extend(tethers.pins(places.position, places.first));
        tethers.project(places.position, places.first, pins, mode.instructions)
    });
    // How far out spans are, the rods between their ends find.
    if let Some(spans) = plan.tethers.spans_of(island) {
        spans.project(places.position, places.first, execution);
    }
    out
}

/// Starts the multipliers of an island afresh.
fn reset_multipliers(plan: &Plan, island: &Island, multipliers: &mut MultiplierSlice) {
    for group in &plan.groups[island.groups.clone()] {
        match group.kind {
            // Hard rods have none that matter.
            GroupKind::Rods => {}
            GroupKind::Distances => multipliers.of_distances(group.range.clone()).fill(0.0),
            GroupKind::Constraints => multipliers.of_constraints(group.range.clone()).fill(0.0),
        }
    }
}

/// Lists the constraints of an island in solving order.
pub(super) fn list_constraint_refs(
    plan: &Plan,
    island: &Island,
    constraint_refs: &mut Vec<ConstraintRef>,
) {
    constraint_refs.clear();
    for group in &plan.groups[island.groups.clone()] {
        constraint_refs.extend(
            group.range.clone().map(|n| ConstraintRef { kind: group.kind, number: n as u32 }),
        );
    }
}

/// cos² of 0.35 rad.
pub(super) const COS_SQUARED: f32 = 0.882_43;

/// Whether a rod of the island turns so far in this substep that the direction that it had at the start says little about the one it needs.
///
/// A bond that turns by θ is corrected along a line that is off by θ, with a gain of 1/cos θ: harmless at 20°, without bound at 90°. And where one
/// bond of an island goes wrong its neighbours follow, so all of it goes back.
fn turns_too_fast(places: &Places, plan: &Plan, island: &Island) -> bool {
    let mut rods = plan.groups[island.groups.clone()]
        .iter()
        .filter(|group| group.kind == GroupKind::Rods)
        .flat_map(|group| &plan.distances[group.range.clone()]);
    rods.any(|d| {
        let (a, b) = (places.at(d.a), places.at(d.b));
        let now = (places.position[b] - places.position[a]).truncate();
        let start = (places.start[b] - places.start[a]).truncate();
        let along = now.dot(start);
        let squares = now.length_squared() * start.length_squared();
        along < 0.0 || along * along < COS_SQUARED * squares
    })
}

/// Projects the particles of an island out of whatever stands in the world once; returns the deepest it found, metres.
#[inline]
fn project_contacts(
    common: Common,
    places: &mut Places,
    normal_impulses: &mut NormalImpulses,
    island: (usize, &[u32]),
) -> f32 {
    let Common { contacts, execution, .. } = common;
    if contacts.is_empty() {
        return 0.0;
    }
    let with = (common.span(), execution.instructions);
    contacts.project_island(places, normal_impulses, island, with)
}
