//! Solves one island, particles connected by constraints, until its constraints are satisfied or its sweeps are used up, independently of all other islands.

use std::time::Instant;

use glam::Vec4;

use super::column_sweep::ColumnSweep;
use super::constraint_ref::{SolveMode, list_constraint_refs};
use super::context::{SolveContext, SubstepParameters};
use super::gauss_seidel;
use super::mixed_places::MixedPlaces;
use super::momentum::MomentumDrift;
use super::multipliers::MultiplierSlice;
use super::parts::Parts;
use super::plan::{GroupKind, Plan};
use super::rods::COS_SQUARED;
use super::sweep_scratch::SweepScratch;
use super::task_slice::IslandSlice;
use super::{jacobi, most_violated_first};
use crate::collide::{NormalImpulses, recovery};
use crate::constraints::{GradientAt, SubstepContext};
use crate::islands::Island;
use crate::particles::Places;
use crate::settings::Order;
use crate::threads::ExecutionContext;

/// A sweep over an island by one worker, in the order that its settings require. Like every sweep it returns the largest error found, metres.
#[inline]
pub(super) fn sweep_in_order(
    plan: &Plan,
    island: &Island,
    scratch: &mut SweepScratch,
) -> impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32 {
    let order = island.settings.order;
    if order != Order::GaussSeidel {
        list_constraint_refs(plan, island, &mut scratch.constraint_refs);
    }
    let in_columns = plan.fits_columns(island);
    move |places, multipliers, mode| match order {
        Order::GaussSeidel => {
            let run = in_columns.as_ref().filter(|_| mode.gradient_at == GradientAt::Current);
            if let Some(run) = run {
                let sweep = ColumnSweep::of(plan, island, run, mode);
                return sweep.sweep(places, multipliers, scratch);
            }
            let alone = ExecutionContext { instructions: mode.instructions, workers: None };
            let out = project_tethers_and_chains(plan, island, places, mode, scratch);
            let batches = island.cluster_batches.clone();
            let found = gauss_seidel::sweep(places, plan, batches, multipliers, mode, scratch);
            let at = &mut MixedPlaces { columns: None, places };
            Parts { plan, island, mode }.sweep_again(at, multipliers, scratch);
            project_tethers_and_spans(plan, island, places, mode, alone, scratch);
            out.max(found)
        }
        Order::Jacobi => {
            let SweepScratch { local, constraint_refs, corrections, .. } = scratch;
            let all = (local, &constraint_refs[..]);
            jacobi::sweep(places, plan, island, multipliers, mode, all, corrections)
        }
        Order::MostViolatedFirst => {
            let SweepScratch { local, constraint_refs, queue, .. } = scratch;
            let all = (local, &constraint_refs[..]);
            most_violated_first::sweep(places, plan, island, multipliers, mode, all, queue)
        }
    }
}

/// Solves island `number` by repeated calls of `sweep`. Returns the momentum that its corrections must not have added.
///
/// Constraints come first and contacts last, so that an error that remains is not a visible penetration such as a foot in the ground. The error of a sweep is
/// the one *found*, before it was corrected. So reaching the tolerance costs no extra pass, and convergence is never reported too early.
pub(super) fn solve(
    context: SolveContext,
    number: usize,
    own: IslandSlice,
    sweep: impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32,
) -> Option<MomentumDrift> {
    let IslandSlice { mut places, mut multipliers, mut normal_impulses, report } = own;
    let (plan, h) = (context.plan, context.substep.h);
    let island = &plan.islands.list[number];
    let (settings, rows) = (&island.settings, plan.members(number));
    let began = settings.timed.then(Instant::now);
    let mut gradient_at = settings.gradient_at;
    if gradient_at == GradientAt::StepStart && turns_too_fast(&places, plan, island) {
        gradient_at = GradientAt::Current;
        report.fallbacks += 1;
    }
    reset_multipliers(plan, island, &mut multipliers);
    let columns = (&mut places, &mut multipliers, &mut normal_impulses);
    let SweepResult { sweeps, converged, touched, violated } =
        sweep_until_converged(context, number, gradient_at, columns, sweep);
    report.violated = violated;
    // Only sweeps over constraints count; an island without any was only projected out of contacts.
    let sweeps = if island.groups.is_empty() { 0 } else { sweeps };
    report.note(sweeps, converged);
    let keeps_angular = gradient_at == GradientAt::StepStart || settings.keep_spin;
    let momentum_drift =
        if touched { None } else { MomentumDrift::of(&places, (island, rows), h, keeps_angular) };
    report.seconds += began.map_or(0.0, |began| began.elapsed().as_secs_f64());
    momentum_drift
}

/// Whether an island can be swept once more after contacts between bodies. All its constraints must be hard and act on particles alone. The multiplier of a
/// compliant one restarts at zero, so it would push twice in a substep; and each sweep of a chain transmits the whole load that a contact carries.
fn can_propagate(plan: &Plan, island: &Island) -> bool {
    let settings = &island.settings;
    let suits = settings.order == Order::GaussSeidel
        && settings.gradient_at == GradientAt::Current
        && !(settings.statics || island.is_skipped() || island.takes_microsteps());
    suits
        && !(island.rigid || island.external || island.measured || island.has_chains())
        && plan.is_hard(island)
}

/// Sweeps island `number` once more in a substep in which a contact between bodies has suddenly stopped a part of it. Returns the momentum that its corrections
/// must not have added. `before` is scratch.
pub(super) fn propagate_impact(
    context: SolveContext,
    number: usize,
    own: IslandSlice,
    sweep: impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32,
    before: &mut Vec<Vec4>,
) -> Option<MomentumDrift> {
    let IslandSlice { mut places, mut multipliers, mut normal_impulses, report } = own;
    let (plan, h) = (context.plan, context.substep.h);
    let island = &plan.islands.list[number];
    if !can_propagate(plan, island) {
        return None;
    }
    let rows = plan.members(number);
    before.clear();
    before.extend(rows.iter().map(|&row| places.position[places.at(row)]));
    let columns = (&mut places, &mut multipliers, &mut normal_impulses);
    let SweepResult { sweeps, touched, .. } =
        sweep_until_converged(context, number, GradientAt::Current, columns, sweep);
    report.sweeps += sweeps;
    if touched {
        return None;
    }
    MomentumDrift::since(&places, (island, rows, before), h, island.settings.keep_spin)
}

/// The result of sweeping an island.
struct SweepResult {
    sweeps: u32,
    converged: bool,
    /// Whether one of its particles touched static or kinematic geometry.
    touched: bool,
    /// Whether the first error found was more than is recovered in a substep.
    violated: bool,
}

/// Sweeps until the largest error found is within the tolerance, or the sweeps are used up.
#[inline]
fn sweep_until_converged(
    context: SolveContext,
    number: usize,
    gradient_at: GradientAt,
    columns: (&mut Places, &mut MultiplierSlice, &mut NormalImpulses),
    mut sweep: impl FnMut(&mut Places, &mut MultiplierSlice, SolveMode) -> f32,
) -> SweepResult {
    let (places, multipliers, normal_impulses) = columns;
    let SolveContext { plan, substep: SubstepParameters { h, gravity, .. }, execution, .. } =
        context;
    let island = &plan.islands.list[number];
    let (settings, rows) = (&island.settings, plan.members(number));
    let sweeps = settings.max_sweeps * context.microstep.of;
    let substep_context = SubstepContext { h, sweeps };
    let most = recovery(h, gravity);
    let mut swept = SweepResult { sweeps: 0, converged: false, touched: false, violated: false };
    while swept.sweeps < settings.max_sweeps && !swept.converged {
        let (project_tethers, instructions) =
            (swept.sweeps == 0 || !island.is_small(), execution.instructions);
        let single_sweep = settings.max_sweeps == 1;
        let mode = SolveMode {
            substep_context,
            gradient_at,
            project_tethers,
            relaxation: None,
            single_sweep,
            violation: most,
            instructions,
        };
        let found = if island.groups.is_empty() { 0.0 } else { sweep(places, multipliers, mode) };
        swept.violated = if swept.sweeps == 0 { found > most } else { swept.violated };
        let depth = project_contacts(context, places, normal_impulses, (number, rows));
        swept.touched |= depth > 0.0;
        swept.sweeps += 1;
        swept.converged = found.max(depth) <= settings.tolerance;
    }
    swept
}

/// Projects, before the rods are swept, what they would only reach over many sweeps: tethers, and chains by a direct solve. Returns how far outside its tether
/// the farthest particle was, metres. For a chain only a violation counts, since its rods then have next to no error left. Small islands have their tethers
/// projected in the first sweep of a substep only, after which little is left.
pub(super) fn project_tethers_and_chains(
    plan: &Plan,
    island: &Island,
    places: &mut Places,
    mode: SolveMode,
    scratch: &mut SweepScratch,
) -> f32 {
    if mode.relaxation.is_some() {
        return 0.0;
    }
    let mut worst = 0.0_f32;
    if mode.project_tethers {
        worst = project_tethers(plan, island, places, mode, scratch);
    }
    if island.has_chains() {
        let columns = (&mut *places.position, places.first);
        let scratch = &mut scratch.chains;
        let found = plan.chains.project(island, columns, scratch, mode.instructions);
        worst = worst.max(mode.of_chains(found));
    }
    worst
}

/// Projects large cloth again after its rods: tethers to its pins, and spans, which bound distances between free particles. Rods leave the largest errors where
/// they were swept last, so spans come after them: with spans first, cloth was stretched by a seventh more at its worst, and a flag by a quarter more at the
/// corner that all of it hangs on. The errors of spans are not measured here, since the rods between their ends find them in the next sweep.
pub(super) fn project_tethers_and_spans(
    plan: &Plan,
    island: &Island,
    places: &mut Places,
    mode: SolveMode,
    execution: ExecutionContext,
    scratch: &mut SweepScratch,
) {
    let Some(spans) = plan.tethers.spans_of(island) else { return };
    if mode.project_tethers {
        project_tethers(plan, island, places, mode, scratch);
        spans.project(places.position, places.first, execution);
    }
}

/// Projects particles into the range of their tethers. Returns how far outside the farthest was, metres.
fn project_tethers(
    plan: &Plan,
    island: &Island,
    places: &mut Places,
    mode: SolveMode,
    scratch: &mut SweepScratch,
) -> f32 {
    let Some(tethers) = plan.tethers.of(island) else { return 0.0 };
    let pins = &mut scratch.pins;
    pins.clear();
    pins.extend(tethers.pins(places.position, places.first));
    tethers.project(places.position, places.first, pins, mode.instructions)
}

/// Sets the multipliers of an island to zero.
fn reset_multipliers(plan: &Plan, island: &Island, multipliers: &mut MultiplierSlice) {
    for group in &plan.groups[island.groups.clone()] {
        match group.kind {
            // Hard rods do not accumulate multipliers.
            GroupKind::Rods => {}
            GroupKind::Distances => multipliers.of_distances(group.range.clone()).fill(0.0),
            GroupKind::Constraints => multipliers.of_constraints(group.range.clone()).fill(0.0),
        }
    }
}

/// Whether a rod of the island turns so far in this substep that its direction at the start is a poor guess of the direction it needs.
///
/// A rod that turns by θ is corrected along a line that is off by θ, with a gain of 1/cos θ: harmless at 20°, unbounded at 90°. Where one rod of an island
/// fails its neighbours follow, so the whole island falls back.
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

/// Projects the particles of an island out of static and kinematic geometry once. Returns the deepest penetration found, metres.
#[inline]
pub(super) fn project_contacts(
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
    use crate::constraints::Distance;
    use crate::lanes::InstructionSet;
    use crate::particles::ParticleSeed;
    use crate::recipes::{BoxSpec, ClothMaterial, ClothSpec, RopeSpec, box_3d, cloth_grid, rope};
    use crate::solve::multipliers::Multipliers;
    use crate::solve::rods::Relaxation;

    const MODE: SolveMode = SolveMode {
        substep_context: SubstepContext { h: 1.0 / 1200.0, sweeps: 2 },
        gradient_at: GradientAt::Current,
        project_tethers: true,
        relaxation: None,
        single_sweep: false,
        violation: f32::INFINITY,
        instructions: InstructionSet::Simd128,
    };

    /// Shaken cloth of a size, pinned at two corners. If `between` is given, its other corners are tied to two ropes, one with rows before the cloth and one
    /// after it, with `between` unrelated particles in between; the second rope carries a box. Returns the world and the number of the cloth's island.
    fn shaken_cloth((columns, rows): (u32, u32), between: Option<usize>) -> (Simulation, usize) {
        let mut world = Simulation::default();
        let others = |world: &mut Simulation, count: usize| {
            for i in 0..count {
                let at = glam::Vec3::new(30.0, i as f32, 0.0);
                world.particles.push(ParticleSeed::at(at)).unwrap();
            }
        };
        let rope = |world: &mut Simulation, from: glam::Vec3| {
            let to = from + glam::Vec3::new(0.3, -1.0, 0.2);
            let spec = RopeSpec { from, to, segments: 10, ..Default::default() };
            rope(&spec).unwrap().build(world).unwrap()
        };
        let spec = ClothSpec { columns, rows, ..Default::default() };
        let corners = spec.corners();
        let mut cloth = cloth_grid(&spec).unwrap();
        corners[..2].iter().for_each(|&corner| cloth.pin(corner).unwrap());
        let place = |corner: usize| cloth.particles[corners[corner] as usize].position;
        let first = between.map(|count| {
            let rows = rope(&mut world, place(2));
            others(&mut world, count);
            rows
        });
        let cloth = cloth.build(&mut world).unwrap();
        if let (Some(count), Some(first)) = (between, first) {
            others(&mut world, count);
            let second = rope(&mut world, place(3));
            others(&mut world, count);
            let spec = BoxSpec { size: glam::Vec3::splat(0.2), mass: 1.0, ..Default::default() };
            let at = world.particles.position(second.end - 1);
            let crate_ = box_3d(&spec).unwrap().transformed(glam::Quat::IDENTITY, at);
            let crate_ = crate_.build(&mut world).unwrap();
            let tie = |a: usize, b: usize, rest| Distance::new(a as u32, b as u32, rest);
            let corner = |corner: usize| cloth.start + corners[corner] as usize;
            let gap = world.particles.position(second.end - 1);
            let gap = gap.distance(world.particles.position(crate_.start));
            world.extend_distances([
                tie(corner(2), first.start, 0.0),
                tie(corner(3), second.start, 0.0),
                tie(second.end - 1, crate_.start, gap),
            ]);
        }
        for i in 0..world.particles.len() {
            let shaken = glam::Vec3::new((i % 7) as f32, (i % 5) as f32, (i % 11) as f32);
            world.particles.set_velocity(i, shaken * 0.3);
        }
        for _ in 0..3 {
            world.step(1.0 / 60.0).unwrap();
        }
        let island = world.island_of(cloth.start).unwrap();
        (world, island as usize)
    }

    /// Tethers, spans, compliant distances, rods and tied parts give the same bits in columns as one cluster batch after the other.
    #[test]
    fn cloth_in_columns_has_the_bits_of_its_cluster_batches_one_by_one() {
        let sizes = [(20, 20), (63, 63), (90, 31)];
        let ways = [None, Some(0), Some(1), Some(6), Some(700)];
        for (size, between) in sizes.into_iter().flat_map(|size| ways.map(|way| (size, way))) {
            let (world, number) = shaken_cloth(size, between);
            let (plan, particles) = (world.plan(), &world.particles);
            let island = &plan.islands.list[number];
            assert_eq!(island.microsteps, 2, "{size:?}, {between:?}");
            let mode = SolveMode { instructions: InstructionSet::best(), ..MODE };
            let (mut own, mut other) = (particles.clone(), particles.clone());
            let (mut scratch, mut multipliers) = (SweepScratch::default(), Multipliers::default());
            multipliers.resize(plan.distances.len(), plan.constraints.len());
            let (run, sums) = (plan.fits_columns(island).unwrap(), &mut multipliers.all());
            let places = &mut Places::all(&mut own);
            let sweep = ColumnSweep::of(plan, island, &run, mode);
            let found = sweep.sweep(places, sums, &mut scratch);
            multipliers = Multipliers::default();
            multipliers.resize(plan.distances.len(), plan.constraints.len());
            let (places, sums) = (&mut Places::all(&mut other), &mut multipliers.all());
            let alone = ExecutionContext { instructions: mode.instructions, workers: None };
            let out = project_tethers_and_chains(plan, island, places, mode, &mut scratch);
            let batches = island.cluster_batches.clone();
            let same = gauss_seidel::sweep(places, plan, batches, sums, mode, &mut scratch);
            let at = &mut MixedPlaces { columns: None, places };
            Parts { plan, island, mode }.sweep_again(at, sums, &mut scratch);
            project_tethers_and_spans(plan, island, places, mode, alone, &mut scratch);
            assert_eq!(found, out.max(same), "{size:?}, {between:?}");
            assert!(own.position == other.position, "{size:?}, {between:?}");
            assert!(own.position != particles.position && plan.tethers.spans_of(island).is_some());
        }
    }

    #[test]
    fn rods_relaxed_by_all_of_their_errors_go_where_they_go_anyway() {
        // In columns, and in an order of rows without regular strides.
        for step in [1, 37] {
            let material = ClothMaterial { bend_compliance: None, ..Default::default() };
            let spec = ClothSpec { material, ..Default::default() };
            let mut cloth = cloth_grid(&spec).unwrap();
            let len = cloth.particles.len() as u32;
            let place = |row: u32| row * step % len;
            let particles = (0..len).map(|row| (place(row), cloth.particles[row as usize]));
            let mut particles: Vec<_> = particles.collect();
            particles.sort_by_key(|(place, _)| *place);
            cloth.particles = particles.into_iter().map(|(_, seed)| seed).collect();
            for d in &mut cloth.distances {
                (d.a, d.b) = (place(d.a), place(d.b));
                d.rest *= 1.0 + 0.001 * (d.a % 7) as f32;
            }
            (cloth.triangles, cloth.vertices) = Default::default();
            let mut world = Simulation::default();
            cloth.build(&mut world).unwrap();
            world.step(1.0 / 60.0).unwrap();
            let (plan, mut scratch) = (world.plan().clone(), SweepScratch::default());
            let island = &plan.islands.list[0];
            let mut swept = |relaxation: Option<Relaxation>| {
                let mut own = world.particles.clone();
                let mut multipliers = Multipliers::default();
                multipliers.resize(plan.distances.len(), plan.constraints.len());
                let instructions = InstructionSet::best();
                let mode = SolveMode { project_tethers: false, relaxation, instructions, ..MODE };
                let sums = &mut multipliers.all();
                sweep_in_order(&plan, island, &mut scratch)(&mut Places::all(&mut own), sums, mode);
                own.position
            };
            let by = |share: f32, tolerance: f32| Some(Relaxation { share, tolerance });
            let (begin, whole) = (&world.particles.position, swept(None));
            assert!(swept(by(1.0, 0.0)) == whole && whole != *begin, "{step}");
            assert!(swept(by(1.0, 0.1)) == *begin, "{step}: no rod is off by a tenth");
            let moved = |to: &[Vec4]| -> f32 {
                let each = to.iter().zip(begin).map(|(to, from)| (*to - *from).length());
                each.sum()
            };
            let [half, all] = [0.01, 0.02].map(|share| moved(&swept(by(share, 0.0))));
            assert!((half / all - 0.5).abs() < 0.03 && all > 0.0, "{step}: {half} of {all}");
        }
    }
}
