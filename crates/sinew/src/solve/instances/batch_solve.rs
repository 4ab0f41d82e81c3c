//! Solves instance batches: through the solving of one substep, or through all substeps of a step.

use core::sync::atomic::{AtomicU32, Ordering};

use glam::{Vec3, Vec4};

use super::lane_compaction::LaneCompaction;
use super::lane_storage::{LaneStorage, gather, next, scatter};
use super::momentum_drift::{derive_lanes, take_drift};
use super::motion::{note_masses, predict_lanes};
use super::solve::BatchContext;
use super::surfaces::SurfaceContext;
use crate::collide::{BatchContacts, NormalImpulses, recovery};
use crate::constraints::Plane;
use crate::lanes::LANES;
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

/// Particles of the bodies side by side in all storage that is solved together, at most: with all that belongs to them they fit into a core's second
/// cache.
const STORED_PARTICLES: usize = 512;

/// The instance batches of a task, to be solved. What cannot be in lanes in this step is left to others, and noted as
/// [remaining](BatchScratch::remaining).
pub(crate) struct BatchSolve<'a> {
    pub(crate) context: SolveContext<'a>,
    pub(crate) task: &'a Task,
    /// Columns from the task's first row on.
    pub(crate) position: &'a mut [Vec4],
    pub(crate) motion: BatchMotion<'a>,
    pub(crate) origin: &'a [Vec3],
    pub(crate) radius: &'a [f32],
    pub(crate) normal_impulses: NormalImpulses<'a>,
    pub(crate) reports: &'a mut [IslandReport],
    pub(crate) scratch: BatchScratch<'a>,
}

/// What solving them needs of a thread's scratch.
pub(crate) struct BatchScratch<'a> {
    pub(crate) sweep: &'a mut SweepScratch,
    pub(crate) lane_compaction: &'a mut LaneCompaction,
    /// What is not solved is left here.
    pub(crate) remaining: &'a mut Remaining,
    /// Islands whose corrections gave them what has to be taken off again.
    pub(crate) momentum_drifts: &'a mut Vec<(u32, MomentumDrift)>,
}

/// How far they are solved.
pub(crate) enum BatchMotion<'a> {
    /// Through the solving of a substep that has been predicted. Velocities are not derived: what has to be taken off then is noted for each
    /// particle, m/s, or where there is no place for that, for each island in the scratch.
    Substep { start: &'a [Vec4], velocity: &'a [Vec4], momentum_drift: &'a mut [Vec4] },
    /// Through all substeps of a step.
    Step(WholeStep<'a>),
}

/// What there is through the substeps of a step.
pub(crate) struct WholeStep<'a> {
    pub(crate) start: &'a mut [Vec4],
    pub(crate) velocity: &'a mut [Vec4],
    pub(crate) rounding: &'a mut [Vec4],
    /// 1/s; may have one number for all.
    pub(crate) damping: &'a [f32],
    /// The same, of all besides.
    pub(crate) air: f32,
    /// Acceleration of all, m/s².
    pub(crate) common: Vec3,
    /// The most sweeps in each substep.
    pub(crate) iteration_counts: &'a [AtomicU32],
}

impl<'a> BatchSolve<'a> {
    /// Solves them.
    pub(crate) fn run(mut self) {
        let plan = self.context.plan;
        let instance_batches = &plan.instance_batches.all[self.task.instance_batches.clone()];
        let mut lane_compaction = core::mem::take(self.scratch.lane_compaction);
        let (mut begin, mut found) =
            (0, instance_batches.first().and_then(|first| self.contacts(first)));
        while begin < instance_batches.len() {
            let (first, contacts) = (&instance_batches[begin], found);
            // Where each has but one sweep nobody waits for anybody.
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
                    self.scratch.remaining.leave(batch.islands.clone(), batch.rows());
                });
                self.solve_batches(&instance_batches[begin..end], contacts, &mut lane_compaction);
            }
            begin = end;
        }
        *self.scratch.lane_compaction = lane_compaction;
    }

    /// What an instance batch may touch, if its bodies can go through this step together.
    fn contacts(&self, batch: &InstanceBatch) -> Option<BatchContacts<'a>> {
        let islands = &self.context.plan.islands.list[batch.islands.clone()];
        if islands.iter().any(|island| island.rigid || island.measured || island.one_state) {
            return None;
        }
        let awake = islands.iter().filter(|island| !island.asleep).count();
        if !batch.is_worth(awake) {
            return None;
        }
        let settings = &islands[0].settings;
        let contacts = self.context.contacts.of_batch(batch.rows())?;
        let ready = settings.order == Order::GaussSeidel
            && !settings.timed
            && islands.iter().all(|island| island.settings == *settings)
            // A body whose particles have more than one origin has more than one height above a plane.
            && (contacts.planes.is_empty() || islands.iter().all(|island| island.one_origin));
        ready.then_some(contacts)
    }

    /// Whether two instance batches are of the same bodies, which are to be solved in the same way.
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
        for substep in 0..substeps {
            if let BatchMotion::Step(whole) = &self.motion {
                for storage in lane_compaction.storages() {
                    // The last step may have been of another length, or none, but this one's substeps are alike.
                    if substep < 2 {
                        storage.note_losses(h);
                    }
                    predict_lanes(storage, whole.common, h, instructions);
                }
            }
            lane_compaction.solve(&context, &mut self.normal_impulses);
            for (batch, storage) in instance_batches.iter().zip(lane_compaction.storages()) {
                let from = batch.islands.start - self.task.islands.start;
                let reports = &mut self.reports[from..from + batch.islands.len()];
                let sweeps = storage.convergence.report(reports, storage.asleep);
                if let BatchMotion::Step(whole) = &self.motion {
                    whole.iteration_counts[substep].fetch_max(sweeps, Ordering::Relaxed);
                    let (free, keeps_angular) = (storage.left(), context.keeps_spin(storage));
                    derive_lanes(storage, h, free, keeps_angular, instructions);
                    if let Some(surfaces) = &context.surfaces {
                        surfaces.bounce(storage, &mut self.normal_impulses);
                    }
                    let violated = storage.convergence.violated & storage.mask();
                    for lane in (0..LANES).filter(|lane| violated >> lane & 1 != 0) {
                        let one = (batch.islands.start + lane, lane);
                        limit_recovery(self.context, one, storage, reports, self.scratch.sweep);
                    }
                }
            }
            if let Some(surfaces) = &mut context.surfaces {
                surfaces.context = surfaces.context.later(1);
            }
        }
        for (batch, storage) in instance_batches.iter().zip(lane_compaction.storages()) {
            self.give_back(&context, batch, storage);
        }
    }

    /// Takes an instance batch into a lane storage.
    fn load(
        &self,
        batch: &InstanceBatch,
        (planes, surfaces): (&[Plane], bool),
        storage: &mut LaneStorage,
    ) {
        let (begin, islands) = (self.task.rows.start, &self.context.plan.islands.list);
        let islands = &islands[batch.islands.clone()];
        self.note_heights(batch, planes, storage);
        // In the lanes that are left, too, the last body is what it is: they write the same as its own.
        let last = islands.len() - 1;
        (storage.free, storage.asleep) = (0, 0);
        for lane in 0..LANES {
            let own = &islands[lane.min(last)];
            storage.islands[lane] = (batch.islands.start + lane.min(last)) as u32;
            storage.free |= u32::from(own.free && !own.asleep) << lane;
            storage.asleep |= u32::from(own.asleep) << lane;
        }
        let start = match &self.motion {
            BatchMotion::Substep { start, .. } => *start,
            BatchMotion::Step(whole) => &*whole.start,
        };
        let instructions = self.context.execution.instructions;
        storage.load(batch, begin, self.position, start, instructions);
        storage.last_seen.clear();
        if surfaces {
            let last_seen = self.context.contacts.last_seen();
            gather(&mut storage.last_seen, batch, 0, last_seen, instructions);
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

    /// Takes the tethers of instance batches that are solved together. Pins stand, or have been led.
    fn load_tethers(&self, instance_batches: &[InstanceBatch], storages: &mut [LaneStorage]) {
        const NONE: Vec4 = Vec4::new(0.0, 0.0, 0.0, f32::INFINITY);
        let (plan, begin) = (self.context.plan, self.task.rows.start);
        let of = |number: usize| plan.tethers.of(&plan.islands.list[number]);
        let islands = || instance_batches.iter().flat_map(|batch| batch.islands.clone());
        let mut are_there = [false; 2];
        for own in islands().filter_map(of).map(IslandTethers::are_there) {
            are_there = [are_there[0] || own[0], are_there[1] || own[1]];
        }
        for (batch, storage) in instance_batches.iter().zip(storages) {
            for (column, is_there) in storage.tethers.iter_mut().zip(are_there) {
                // Whoever is there is written below.
                column
                    .resize(if is_there { batch.members as usize } else { 0 }, LaneParticles::ZERO);
            }
            if are_there == [false; 2] {
                continue;
            }
            let [one, others @ ..] = &storage.islands;
            if let Some(one) = of(*one as usize)
                && others.iter().all(|&other| of(other as usize).is_some_and(|o| o.are_like(one)))
            {
                self.load_like_tethers(one, storage, of);
                continue;
            }
            for (lane, &number) in storage.islands.iter().enumerate() {
                let own = of(number as usize);
                for member in 0..batch.members as usize {
                    let each =
                        own.map_or([NONE; 2], |own| own.of_member(member, self.position, begin));
                    for (column, tether) in storage.tethers.iter_mut().zip(each) {
                        if let Some(spot) = column.get_mut(member) {
                            spot.set_lane_whole(lane, tether);
                        }
                    }
                }
            }
        }
    }

    /// Takes tethers of bodies that have the same: only their pins are elsewhere.
    fn load_like_tethers<'p>(
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
                for (spot, each) in column.iter_mut().zip(one.each()) {
                    let (to, length) = each[which];
                    if to as usize == pin {
                        *spot = place.with_fourths(length);
                    }
                }
            }
        }
    }

    /// Writes what has become of an instance batch.
    fn give_back(
        &mut self,
        context: &BatchContext,
        batch: &InstanceBatch,
        storage: &mut LaneStorage,
    ) {
        let (begin, instructions) = (self.task.rows.start, context.instructions);
        scatter(&storage.now, batch, begin, self.position, instructions);
        match &mut self.motion {
            BatchMotion::Substep { velocity, momentum_drift, .. } => {
                let left = storage.left();
                if left == 0 {
                    return;
                }
                gather(&mut storage.velocity, batch, begin, velocity, instructions);
                let (turning, parted) =
                    (left & context.keeps_spin(storage), !momentum_drift.is_empty());
                let momentum_drifts =
                    take_drift(storage, context.h, turning, left, parted, instructions);
                if parted {
                    scatter(&storage.velocity, batch, begin, momentum_drift, instructions);
                    return;
                }
                // No more of them than there are bodies.
                let own = momentum_drifts.each(left & storage.mask());
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

    /// Notes radii, and how high the origin of each body is above each plane.
    fn note_heights(&self, batch: &InstanceBatch, planes: &[Plane], storage: &mut LaneStorage) {
        storage.ground.clear();
        storage.radius.clear();
        if planes.is_empty() {
            return;
        }
        let begin = self.task.rows.start;
        let mut places = batch.places(begin, 0);
        // Loops, and no `map` of an array: that is a call for each lane, in each substep.
        for plane in planes {
            let mut heights = [0.0; LANES];
            for (lane, place) in places.into_iter().enumerate() {
                heights[lane] = ground(self.origin[place as usize], plane.normal, plane.offset);
            }
            storage.ground.push(heights);
        }
        // Most bodies have one radius all through.
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
            next(&mut places);
        }
    }
}

/// Takes off the velocities of the body in a lane, of the island of a number, what recovers violations too fast.
#[cold]
fn limit_recovery(
    context: SolveContext,
    (number, lane): (usize, usize),
    storage: &mut LaneStorage,
    reports: &mut [IslandReport],
    scratch: &mut SweepScratch,
) {
    let own = |column: &[LaneParticles]| -> Vec<Vec4> {
        column.iter().map(|spot| spot.lane(lane)).collect()
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
    let end = if lane + 1 == storage.bodies { LANES } else { lane + 1 };
    for (spot, velocity) in storage.velocity.iter_mut().zip(velocity) {
        (lane..end).for_each(|lane| spot.set_lane(lane, velocity.truncate()));
    }
}

/// Notes at which rates velocities are lost.
fn note_rates(batch: &InstanceBatch, begin: u32, whole: &WholeStep, storage: &mut LaneStorage) {
    let air = whole.air + 0.0;
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
            next(&mut places);
        }
    }
    storage.lost.resize(storage.rate.len(), [0.0; LANES]);
}
