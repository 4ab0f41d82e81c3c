//! Solves instance batches: either the constraints of one predicted substep, or all substeps of a step.

use core::sync::atomic::{AtomicU32, Ordering};

use glam::{Vec3, Vec4};

use super::lane_compaction::LaneCompaction;
use super::lane_storage::{LaneStorage, gather, scatter};
use super::momentum_drift::{derive_lanes, take_drift};
use super::motion::{note_masses, predict_lanes};
use super::solve::BatchContext;
use super::surfaces::SurfaceContext;
use crate::collide::{BatchContacts, NormalImpulses, recovery};
use crate::constraints::Plane;
use crate::lanes::{LANES, SetLanes, advance};
use crate::particles::{Places, ground};
use crate::settings::Order;
use crate::solve::context::{SolveContext, SubstepParameters};
use crate::solve::lane_particles::LaneParticles;
use crate::solve::momentum::MomentumDrift;
use crate::solve::plan::Task;
use crate::solve::plan::instance_batches::InstanceBatch;
use crate::solve::remaining::Remaining;
use crate::solve::report::IslandReport;
use crate::solve::sweep_scratch::SweepScratch;
use crate::solve::tethers::IslandTethers;

/// Limit on the particles per lane, summed over all lane storages that are solved together. This many, with everything stored beside them, fit into a core's L2
/// cache.
const STORED_PARTICLES: usize = 512;

/// Solves the instance batches of a task. Batches that cannot be solved in lanes in this step stay in [remaining](BatchScratch::remaining).
pub(crate) struct BatchSolve<'a> {
    pub(crate) context: SolveContext<'a>,
    pub(crate) task: &'a Task,
    /// Positions and inverse masses, from the task's first row on; the other columns likewise.
    pub(crate) position: &'a mut [Vec4],
    pub(crate) motion: BatchMotion<'a>,
    pub(crate) origin: &'a [Vec3],
    pub(crate) radius: &'a [f32],
    pub(crate) normal_impulses: NormalImpulses<'a>,
    pub(crate) reports: &'a mut [IslandReport],
    pub(crate) scratch: BatchScratch<'a>,
}

/// The thread scratch that a batch solve uses.
pub(crate) struct BatchScratch<'a> {
    pub(crate) sweep: &'a mut SweepScratch,
    pub(crate) lane_compaction: &'a mut LaneCompaction,
    /// The islands and rows of the task that are not solved in batches; those that are solved are removed from it.
    pub(crate) remaining: &'a mut Remaining,
    /// Islands with corrections that added momentum, which has to be removed once their velocities are derived.
    pub(crate) momentum_drifts: &'a mut Vec<(u32, MomentumDrift)>,
}

/// Which part of a step is solved.
pub(crate) enum BatchMotion<'a> {
    /// One substep that has already been predicted. Velocities are not derived. The velocity to be removed from each particle later, m/s, is written to
    /// `momentum_drift`; if that is empty, the drift of each island goes into [`BatchScratch::momentum_drifts`].
    Substep { start: &'a [Vec4], velocity: &'a [Vec4], momentum_drift: &'a mut [Vec4] },
    /// All substeps of a step, prediction and velocities included.
    Step(WholeStep<'a>),
}

/// What solving all substeps of a step needs in addition.
pub(crate) struct WholeStep<'a> {
    pub(crate) start: &'a mut [Vec4],
    pub(crate) velocity: &'a mut [Vec4],
    pub(crate) rounding: &'a mut [Vec4],
    /// Damping rates, 1/s: one for each row, or a single one for all rows.
    pub(crate) damping: &'a [f32],
    /// Damping rate that is added to that of every particle, 1/s.
    pub(crate) uniform_damping: f32,
    /// Acceleration of all particles, m/s².
    pub(crate) uniform_acceleration: Vec3,
    /// For each substep, the largest sweep count of any island.
    pub(crate) iteration_counts: &'a [AtomicU32],
}

impl<'a> BatchSolve<'a> {
    /// Solves all batches that can be solved in lanes, groups of batches with the same topology together.
    pub(crate) fn run(mut self) {
        let plan = self.context.plan;
        let instance_batches = &plan.instance_batches.all[self.task.instance_batches.clone()];
        let mut lane_compaction = core::mem::take(self.scratch.lane_compaction);
        let (mut begin, mut found) =
            (0, instance_batches.first().and_then(|first| self.contacts(first)));
        while begin < instance_batches.len() {
            let (first, contacts) = (&instance_batches[begin], found);
            // Bodies that take a single sweep all finish at once: there are no lanes to compact, so each batch is solved by itself.
            let sweeps = plan.islands.list[first.islands.start].settings.max_sweeps;
            let limit = if sweeps > 1 { STORED_PARTICLES / first.members as usize } else { 1 };
            let mut end = begin + 1;
            while let Some(batch) = instance_batches.get(end) {
                found = self.contacts(batch);
                if found != contacts
                    || end - begin >= limit
                    || !self.has_same_topology(first, batch)
                {
                    break;
                }
                end += 1;
            }
            if let Some(contacts) = contacts {
                instance_batches[begin..end].iter().for_each(|batch| {
                    self.scratch.remaining.remove(batch.islands.clone(), batch.rows());
                });
                self.solve_batches(&instance_batches[begin..end], contacts, &mut lane_compaction);
            }
            begin = end;
        }
        *self.scratch.lane_compaction = lane_compaction;
    }

    /// The planes and surfaces that the batch may touch, or `None` if its bodies cannot be solved in lanes in this step.
    fn contacts(&self, batch: &InstanceBatch) -> Option<BatchContacts<'a>> {
        let islands = &self.context.plan.islands.list[batch.islands.clone()];
        if islands.iter().any(|island| island.rigid || island.measured || island.is_rigid_state) {
            return None;
        }
        let awake = islands.iter().filter(|island| !island.asleep).count();
        if !batch.is_worthwhile(awake) {
            return None;
        }
        let settings = &islands[0].settings;
        let contacts = self.context.contacts.of_batch(batch.rows(), batch.islands.clone())?;
        let ready = settings.order == Order::GaussSeidel
            && !settings.timed
            && islands.iter().all(|island| island.settings == *settings)
            // Heights above planes are stored per body, so all particles of a body need one origin.
            && (contacts.planes.is_empty() || islands.iter().all(|island| island.one_origin));
        ready.then_some(contacts)
    }

    /// Whether the bodies of two batches are identical and have the same settings.
    fn has_same_topology(&self, one: &InstanceBatch, other: &InstanceBatch) -> bool {
        let settings =
            |batch: &InstanceBatch| self.context.plan.islands.list[batch.islands.start].settings;
        one.has_same_topology(other) && settings(one) == settings(other)
    }

    fn solve_batches(
        &mut self,
        instance_batches: &[InstanceBatch],
        BatchContacts { planes, surfaces }: BatchContacts,
        lane_compaction: &mut LaneCompaction,
    ) {
        let SolveContext { plan, substep: SubstepParameters { h, gravity, .. }, execution, .. } =
            self.context;
        let instructions = execution.instructions;
        let settings = &plan.islands.list[instance_batches[0].islands.start].settings;
        let (begin, origin, radius) = (self.task.rows.start, self.origin, self.radius);
        let velocity = match &self.motion {
            BatchMotion::Substep { velocity, .. } => Some(*velocity),
            BatchMotion::Step(_) => None,
        };
        let of_surfaces = SurfaceContext { context: self.context, begin, origin, radius, velocity };
        let mut context = BatchContext {
            instance_batches: &plan.instance_batches,
            batch: &instance_batches[0],
            settings,
            planes,
            recover: self.context.contacts.recover(),
            violation: recovery(h, gravity),
            surfaces: surfaces.then_some(of_surfaces),
            chained: plan.islands.list[instance_batches[0].islands.start].has_chains(),
            h,
            instructions,
        };
        lane_compaction.make_room(instance_batches.len());
        for (batch, storage) in instance_batches.iter().zip(lane_compaction.storages()) {
            self.load(batch, (planes, surfaces), storage);
        }
        self.load_tethers(instance_batches, lane_compaction.storages());
        let substeps = if let BatchMotion::Step(whole) = &self.motion {
            whole.iteration_counts.len()
        } else {
            1
        };
        if let BatchMotion::Step(whole) = &self.motion {
            for storage in lane_compaction.storages() {
                storage.note_losses(h);
                predict_lanes(storage, whole.uniform_acceleration, h, instructions);
            }
        }
        for substep in 0..substeps {
            lane_compaction.solve(&context, &mut self.normal_impulses);
            for (batch, storage) in instance_batches.iter().zip(lane_compaction.storages()) {
                let from = batch.islands.start - self.task.islands.start;
                let reports = &mut self.reports[from..from + batch.islands.len()];
                let sweeps = storage.convergence.report(reports, storage.asleep);
                if let BatchMotion::Step(whole) = &self.motion {
                    whole.iteration_counts[substep].fetch_max(sweeps, Ordering::Relaxed);
                    let keeps_momenta = context.keeps_momenta(storage);
                    let next = (substep + 1 < substeps).then_some(whole.uniform_acceleration);
                    if substep == 0 && next.is_some() {
                        // The lags of the first substep come from the previous step, which may have had another length. From here on they are all `h`.
                        storage.note_losses(h);
                    }
                    let violated = storage.convergence.violated & storage.mask();
                    if context.surfaces.is_none() && violated == 0 {
                        derive_lanes(storage, h, keeps_momenta, next, instructions);
                        continue;
                    }
                    derive_lanes(storage, h, keeps_momenta, None, instructions);
                    if let Some(surfaces) = &context.surfaces {
                        surfaces.bounce(storage, &mut self.normal_impulses);
                    }
                    for lane in SetLanes(violated) {
                        let one = (batch.islands.start + lane, lane);
                        limit_recovery(self.context, one, storage, reports, self.scratch.sweep);
                    }
                    if let Some(a) = next {
                        predict_lanes(storage, a, h, instructions);
                    }
                }
            }
            if let Some(surfaces) = &mut context.surfaces {
                surfaces.context = surfaces.context.later(1);
            }
        }
        for (batch, storage) in instance_batches.iter().zip(lane_compaction.storages()) {
            self.scatter_results(&context, batch, storage);
        }
    }

    /// Loads an instance batch into a lane storage.
    fn load(
        &self,
        batch: &InstanceBatch,
        (planes, surfaces): (&[Plane], bool),
        storage: &mut LaneStorage,
    ) {
        let (begin, islands) = (self.task.rows.start, &self.context.plan.islands.list);
        let islands = &islands[batch.islands.clone()];
        self.note_heights(batch, planes, storage);
        // Unused lanes repeat the last body: they compute and write the same values.
        let last = islands.len() - 1;
        (storage.free, storage.pivoted, storage.asleep) = (0, 0, 0);
        let places = batch.places(0, 0);
        for lane in 0..LANES {
            let own = &islands[lane.min(last)];
            if let Some(pivot) = own.pivot.filter(|_| !own.asleep) {
                let pivot = pivot.map(|row| row - places[lane]);
                if storage.pivoted == 0 {
                    // For lanes without a pivot: where all eight are the same particles, they are read at once.
                    storage.pivots = [pivot; LANES];
                }
                storage.pivoted |= 1 << lane;
                storage.pivots[lane] = pivot;
            }
            storage.islands[lane] = (batch.islands.start + lane.min(last)) as u32;
            storage.free |= u32::from(own.free && !own.asleep) << lane;
            storage.asleep |= u32::from(own.asleep) << lane;
        }
        let start = match &self.motion {
            BatchMotion::Substep { start, .. } => Some(*start),
            BatchMotion::Step(_) => None,
        };
        let instructions = self.context.execution.instructions;
        storage.load(batch, begin, self.position, start, instructions);
        storage.reference.clear();
        if surfaces {
            let reference = self.context.contacts.reference();
            gather(&mut storage.reference, batch, 0, reference, instructions);
        }
        if let BatchMotion::Step(whole) = &self.motion {
            gather(&mut storage.velocity, batch, begin, whole.velocity, instructions);
            gather(&mut storage.rounding, batch, begin, whole.rounding, instructions);
            note_rates(batch, begin, whole, storage);
        }
        if storage.free != 0 {
            note_masses(storage, instructions);
        }
    }

    /// Loads the tethers of instance batches that are solved together. Pins are static, or have been moved kinematically before, so they are read once.
    fn load_tethers(&self, instance_batches: &[InstanceBatch], storages: &mut [LaneStorage]) {
        const NONE: Vec4 = Vec4::new(0.0, 0.0, 0.0, f32::INFINITY);
        let (plan, begin) = (self.context.plan, self.task.rows.start);
        let of = |number: usize| plan.tethers.of(&plan.islands.list[number]);
        let islands = || instance_batches.iter().flat_map(|batch| batch.islands.clone());
        let mut are_there = [false; 2];
        for own in islands().filter_map(of).map(IslandTethers::has_tethers) {
            are_there = [are_there[0] || own[0], are_there[1] || own[1]];
        }
        for (batch, storage) in instance_batches.iter().zip(storages) {
            for (column, is_there) in storage.tethers.iter_mut().zip(are_there) {
                // Every entry is overwritten below.
                column
                    .resize(if is_there { batch.members as usize } else { 0 }, LaneParticles::ZERO);
            }
            if are_there == [false; 2] {
                continue;
            }
            let [one, others @ ..] = &storage.islands;
            if let Some(one) = of(*one as usize)
                && others.iter().all(|&other| of(other as usize).is_some_and(|o| o.is_same_as(one)))
            {
                self.load_same_tethers(one, storage, of);
                continue;
            }
            for (lane, &number) in storage.islands.iter().enumerate() {
                let own = of(number as usize);
                for member in 0..batch.members as usize {
                    let each =
                        own.map_or([NONE; 2], |own| own.of_member(member, self.position, begin));
                    for (column, tether) in storage.tethers.iter_mut().zip(each) {
                        if let Some(entry) = column.get_mut(member) {
                            entry.set_lane_whole(lane, tether);
                        }
                    }
                }
            }
        }
    }

    /// Loads tethers that are the same in all eight bodies but for the positions of their pins.
    fn load_same_tethers<'p>(
        &self,
        one: &IslandTethers,
        storage: &mut LaneStorage,
        of: impl Fn(usize) -> Option<&'p IslandTethers>,
    ) {
        for pin in 0..one.pin_rows().len() {
            let mut place = LaneParticles::ZERO;
            for (lane, &number) in storage.islands.iter().enumerate() {
                let row = of(number as usize).map(|own| own.pin_rows()[pin]);
                let row = row.unwrap_or(self.task.rows.start) - self.task.rows.start;
                place.set_lane_whole(lane, self.position[row as usize]);
            }
            for (which, column) in storage.tethers.iter_mut().enumerate() {
                for (entry, each) in column.iter_mut().zip(one.each()) {
                    let (to, length) = each[which];
                    if to as usize == pin {
                        *entry = place.with_fourths(length);
                    }
                }
            }
        }
    }

    /// Scatters the results of an instance batch.
    fn scatter_results(
        &mut self,
        context: &BatchContext,
        batch: &InstanceBatch,
        storage: &mut LaneStorage,
    ) {
        let (begin, instructions) = (self.task.rows.start, context.instructions);
        scatter(&storage.now, batch, begin, self.position, instructions);
        match &mut self.motion {
            BatchMotion::Substep { velocity, momentum_drift, .. } => {
                let keeps_momenta = context.keeps_momenta(storage);
                let (any, per_particle) = (keeps_momenta.any(), !momentum_drift.is_empty());
                if any == 0 {
                    return;
                }
                gather(&mut storage.velocity, batch, begin, velocity, instructions);
                let momentum_drifts =
                    take_drift(storage, context.h, keeps_momenta, per_particle, instructions);
                if per_particle {
                    scatter(&storage.velocity, batch, begin, momentum_drift, instructions);
                    return;
                }
                // At most one entry for each body.
                let own = momentum_drifts.each(any & storage.mask());
                let own = own.map(|(lane, one)| ((batch.islands.start + lane) as u32, one));
                self.scratch.momentum_drifts.extend(own);
            }
            BatchMotion::Step(whole) => {
                scatter(&storage.start, batch, begin, whole.start, instructions);
                scatter(&storage.velocity, batch, begin, whole.velocity, instructions);
                scatter(&storage.rounding, batch, begin, whole.rounding, instructions);
            }
        }
    }

    /// Stores the radii, and the height of each body's origin above each plane.
    fn note_heights(&self, batch: &InstanceBatch, planes: &[Plane], storage: &mut LaneStorage) {
        storage.ground.clear();
        storage.radius.clear();
        if planes.is_empty() {
            return;
        }
        let begin = self.task.rows.start;
        let mut places = batch.places(begin, 0);
        // Loops instead of `array::map`, which would be a call for each lane in each substep.
        for plane in planes {
            let mut heights = [0.0; LANES];
            for (lane, place) in places.into_iter().enumerate() {
                heights[lane] = ground(self.origin[place as usize], plane.normal, plane.offset);
            }
            storage.ground.push(heights);
        }
        // Most bodies have a single radius.
        let rows = batch.rows();
        let radii = &self.radius[(rows.start - begin) as usize..(rows.end - begin) as usize];
        let (first, mut uniform) = (radii.first().copied().unwrap_or(0.0), true);
        for radius in radii {
            uniform &= *radius == first;
        }
        if uniform {
            storage.radius.resize(batch.members as usize, [first; LANES]);
            return;
        }
        for _ in 0..batch.members {
            let mut radii = [0.0; LANES];
            for (lane, place) in places.into_iter().enumerate() {
                radii[lane] = self.radius[place as usize];
            }
            storage.radius.push(radii);
            advance(&mut places);
        }
    }
}

/// Removes from the velocities of the body in `lane`, which is island `number`, the part that closes violations too fast.
#[cold]
fn limit_recovery(
    context: SolveContext,
    (number, lane): (usize, usize),
    storage: &mut LaneStorage,
    reports: &mut [IslandReport],
    scratch: &mut SweepScratch,
) {
    let own = |column: &[LaneParticles]| -> Vec<Vec4> {
        column.iter().map(|entry| entry.lane(lane)).collect()
    };
    let (mut position, mut start) = (own(&storage.now), own(&storage.start));
    let mut velocity = own(&storage.velocity);
    let members = &context.plan.islands.list[number].members;
    let mut places = Places {
        first: context.plan.islands.members[members.start],
        position: &mut position,
        start: &mut start,
        origin: &vec![Vec3::ZERO; members.len()],
        radius: &[],
        velocity: &mut velocity,
    };
    context.limit_recovery(number, &mut places, &mut reports[lane], scratch);
    let copies = storage.copies(lane);
    for (entry, velocity) in storage.velocity.iter_mut().zip(velocity) {
        copies.clone().for_each(|lane| entry.set_lane(lane, velocity.truncate()));
    }
}

/// Stores the damping rate of each particle, 1/s.
fn note_rates(batch: &InstanceBatch, begin: u32, whole: &WholeStep, storage: &mut LaneStorage) {
    let air = whole.uniform_damping + 0.0;
    storage.rate.clear();
    if let [all] = whole.damping {
        storage.rate.resize(batch.members as usize, [all + air; LANES]);
    } else {
        let mut places = batch.places(begin, 0);
        for _ in 0..batch.members {
            let mut rates = [0.0; LANES];
            for (lane, place) in places.into_iter().enumerate() {
                rates[lane] = whole.damping.get(place as usize).copied().unwrap_or(0.0) + air;
            }
            storage.rate.push(rates);
            advance(&mut places);
        }
    }
    storage.lost.resize(storage.rate.len(), [0.0; LANES]);
}
