//! One island: particles that constraints connect, solved until they hold or the sweeps are spent, whatever happens elsewhere.

use std::time::Instant;

use super::constraint_ref::{SolveMode, list_constraint_refs};
use super::context::SolveContext;
use super::gauss_seidel::{self, sweep_turned};
use super::instances::MOST;
use super::momentum::MomentumDrift;
use super::multipliers::MultiplierSlice;
use super::plan::{GroupKind, Plan};
use super::rods::COS_SQUARED;
use super::scratch::ThreadScratch;
use super::task_slice::IslandSlice;
use super::{jacobi, most_violated_first};
use crate::collide::{NormalImpulses, recovery};
use crate::constraints::{GradientAt, SubstepContext};
use crate::islands::Island;
use crate::particles::Places;
use crate::settings::Order;
use crate::threads::ExecutionContext;

/// A sweep over an island by one worker, in whatever order the island asks for. As every sweep it returns the largest error that it found, metres.
#[inline]
pub(super) fn sweep_in_order(
    plan: &Plan,
    island: &Island,
    thread_scratch: &mut ThreadScratch,
) -> impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32 {
    let order = island.settings.order;
    if order != Order::GaussSeidel {
        list_constraint_refs(plan, island, &mut thread_scratch.constraint_refs);
    }
    let in_columns = if island.has_chains() { None } else { plan.fits_columns(island) };
    move |places, multipliers, mode| match order {
        Order::GaussSeidel => {
            if let Some(rows) = in_columns.filter(|_| mode.gradient_at == GradientAt::Current) {
                let scratch = &mut *thread_scratch;
                return sweep_in_columns(plan, island, rows, places, multipliers, mode, scratch);
            }
            let alone = ExecutionContext { instructions: mode.instructions, workers: None };
            let out = hold_at_once(plan, island, places, mode, alone, thread_scratch);
            let batches = island.cluster_batches.clone();
            out.max(gauss_seidel::sweep(places, plan, batches, multipliers, mode, thread_scratch))
        }
        Order::Jacobi => jacobi::sweep(places, plan, island, multipliers, mode, thread_scratch),
        Order::MostViolatedFirst => {
            most_violated_first::sweep(places, plan, island, multipliers, mode, thread_scratch)
        }
    }
}

/// Solves the island of a number by a `sweep`; returns what its corrections gave it and should not have.
///
/// Constraints come first, contacts last: what must not be seen to fail, a foot in the ground, has the last word. A sweep's error is what it
/// *found*, before it corrected it: reaching the tolerance therefore costs no extra pass, and is never claimed too early.
pub(super) fn solve(
    context: SolveContext,
    number: usize,
    own: IslandSlice,
    mut sweep: impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32,
) -> Option<MomentumDrift> {
    let IslandSlice { places, multipliers, normal_impulses, report } = own;
    let (mut places, mut multipliers, mut normal_impulses) = (places, multipliers, normal_impulses);
    let (places, multipliers) = (&mut places, &mut multipliers);
    let SolveContext { plan, h, execution, .. } = context;
    let island = &plan.islands.list[number];
    let (settings, rows) = (&island.settings, &plan.islands.members[island.members.clone()]);
    let began = settings.timed.then(Instant::now);
    let mut gradient_at = settings.gradient_at;
    if gradient_at == GradientAt::StepStart && turns_too_fast(places, plan, island) {
        gradient_at = GradientAt::Current;
        report.fallbacks += 1;
    }
    reset_multipliers(plan, island, multipliers);
    let sweeps = settings.max_sweeps * context.microstep.of;
    let substep_context = SubstepContext { h, sweeps };
    let most = recovery(h, context.gravity);
    let (mut sweeps, mut converged, mut touched) = (0, false, false);
    while sweeps < settings.max_sweeps && !converged {
        let (tethers, instructions) = (sweeps == 0 || rows.len() > MOST, execution.instructions);
        let single_sweep = settings.max_sweeps == 1;
        let mode = SolveMode {
            substep_context,
            gradient_at,
            tethers,
            single_sweep,
            violation: most,
            instructions,
        };
        let found = if island.groups.is_empty() { 0.0 } else { sweep(places, multipliers, mode) };
        report.violated = if sweeps == 0 { found > most } else { report.violated };
        let depth = project_contacts(context, places, &mut normal_impulses, (number, rows));
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

/// Holds at once what rods hold one after the other, before they have their say: what hangs on pins to what it may be away from them, particles of large
/// cloth to what they may be away from each other, and chains. Returns how far out the farthest from its pin was, metres; of a chain, whose rods have next
/// to nothing left to find, only what is a violation. Where corrections are to keep energy, along the start of the substep, there is none of it; and small
/// islands have tethers in the first sweep of a substep alone, after which little is left to hold.
pub(super) fn hold_at_once(
    plan: &Plan,
    island: &Island,
    places: &mut Places,
    mode: SolveMode,
    execution: ExecutionContext,
    thread_scratch: &mut ThreadScratch,
) -> f32 {
    if mode.gradient_at == GradientAt::StepStart {
        return 0.0;
    }
    let mut worst = 0.0_f32;
    if mode.tethers {
        if let Some(tethers) = plan.tethers.of(island) {
            let pins = &mut thread_scratch.pins;
            pins.clear();
            pins.extend(tethers.pins(places.position, places.first));
            worst = tethers.project(places.position, places.first, pins, mode.instructions);
        }
        // How far out spans are, the rods between their ends find.
        if let Some(spans) = plan.tethers.spans_of(island) {
            spans.project(places.position, places.first, execution);
        }
    }
    if island.has_chains() {
        let columns = (&mut *places.position, places.first);
        let scratch = &mut thread_scratch.chains;
        let found = plan.chains.project(island, columns, scratch, mode.instructions);
        worst = worst.max(mode.of_chains(found));
    }
    worst
}

/// Holds at once what is to be, and sweeps an island once, with all of its particles in columns meanwhile: rows from a first one on. To the bits of one after
/// the other.
fn sweep_in_columns(
    plan: &Plan,
    island: &Island,
    (first, count): (u32, usize),
    places: &mut Places,
    multipliers: &mut MultiplierSlice,
    mode: SolveMode,
    thread_scratch: &mut ThreadScratch,
) -> f32 {
    let ThreadScratch { columns, pins, .. } = thread_scratch;
    let (rows, instructions) = (places.at(first)..places.at(first) + count, mode.instructions);
    columns.reset(plan.rods.half());
    columns.turn_in(0, &places.position[rows.clone()], instructions);
    let mut worst = 0.0_f32;
    if mode.tethers {
        if let Some(tethers) = plan.tethers.of(island) {
            pins.clear();
            pins.extend(tethers.pins(places.position, places.first));
            worst = tethers.project_columns(columns, 0, &(0..count), pins, instructions);
        }
        if let Some(spans) = plan.tethers.spans_of(island) {
            spans.project_columns(columns, first, instructions);
        }
    }
    for cluster_batch in &plan.cluster_batches[island.cluster_batches.clone()] {
        let found = sweep_turned(columns, plan, cluster_batch, first, multipliers, mode);
        worst = worst.max(found);
    }
    columns.turn_out(0, &mut places.position[rows], instructions);
    worst
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
    context: SolveContext,
    places: &mut Places,
    normal_impulses: &mut NormalImpulses,
    island: (usize, &[u32]),
) -> f32 {
    let SolveContext { contacts, execution, .. } = context;
    if contacts.is_empty() {
        return 0.0;
    }
    let with = (context.interval(), execution.instructions);
    contacts.project_island(places, normal_impulses, island, with)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Simulation;
    use crate::lanes::InstructionSet;
    use crate::recipes::{ClothSpec, cloth_grid};
    use crate::solve::multipliers::Multipliers;

    /// Pinned cloth that is being shaken: its tethers, spans, soft ties and rods do to the bit the same in columns as one cluster batch after the other.
    #[test]
    fn cloth_in_columns_has_the_bits_of_its_cluster_batches_one_by_one() {
        for (columns, rows) in [(20, 20), (63, 63), (90, 31)] {
            let spec = ClothSpec { columns, rows, ..Default::default() };
            let mut cloth = cloth_grid(&spec).unwrap();
            spec.corners()[..2].iter().for_each(|&corner| cloth.pin(corner).unwrap());
            let mut world = Simulation::default();
            cloth.build(&mut world).unwrap();
            for i in 0..world.particles.len() {
                let shaken = glam::Vec3::new((i % 7) as f32, (i % 5) as f32, (i % 11) as f32);
                world.particles.set_velocity(i, shaken * 0.3);
            }
            for _ in 0..3 {
                world.step(1.0 / 60.0).unwrap();
            }
            let (plan, particles) = (world.plan(), &world.particles);
            let island = &plan.islands.list[0];
            let mode = SolveMode {
                substep_context: SubstepContext { h: 1.0 / 1200.0, sweeps: 2 },
                gradient_at: GradientAt::Current,
                tethers: true,
                single_sweep: false,
                violation: f32::INFINITY,
                instructions: InstructionSet::best(),
            };
            let (mut own, mut other) = (particles.clone(), particles.clone());
            let (mut scratch, mut multipliers) = (ThreadScratch::default(), Multipliers::default());
            multipliers.resize(plan.distances.len(), plan.constraints.len());
            let (all, sums) = (plan.fits_columns(island).unwrap(), &mut multipliers.all());
            let places = &mut Places::all(&mut own);
            let found = sweep_in_columns(plan, island, all, places, sums, mode, &mut scratch);
            multipliers = Multipliers::default();
            multipliers.resize(plan.distances.len(), plan.constraints.len());
            let (places, sums) = (&mut Places::all(&mut other), &mut multipliers.all());
            let alone = ExecutionContext { instructions: mode.instructions, workers: None };
            let out = hold_at_once(plan, island, places, mode, alone, &mut scratch);
            let batches = island.cluster_batches.clone();
            let same = gauss_seidel::sweep(places, plan, batches, sums, mode, &mut scratch);
            assert_eq!(found, out.max(same), "{columns} × {rows}");
            assert!(own.position == other.position, "{columns} × {rows}");
            assert!(own.position != particles.position && plan.tethers.spans_of(island).is_some());
        }
    }
}
