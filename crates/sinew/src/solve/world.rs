//! All islands: dealt out to the workers, and reported together.

use core::sync::atomic::AtomicU32;

use glam::Vec4;

use super::flock::{Drive, Motion};
use super::island::{Common, InOrder, Room, Sweeper, solve};
use super::item::Manner;
use super::momentum::Note;
use super::plan::{Island, Plan, Task};
use super::sums::{Multipliers, Sums};
use super::{IslandReport, Order, SolverReport, cascade};
use crate::collide::{Pressed, Presses};
use crate::integrate::{Derive, derive};
use crate::lanes::{InstructionSet, with};
use crate::particles::{Particles, Places};
use crate::threads::{Pool, Workers, each};

/// What solving needs and nobody saves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    multipliers: Multipliers,
    rooms: Pool<Room>,
    /// What particles have to have taken off when their velocities are derived, m/s, where that is done later; one for each row then.
    excess: Vec<Vec4>,
    /// The most sweeps in each substep of a whole step.
    most: Most,
}

/// Counters; a copy has nothing to keep.
#[derive(Debug, Default)]
struct Most(Vec<AtomicU32>);

impl Clone for Most {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Scratch {
    pub(super) fn parts(&mut self) -> (&mut Multipliers, &Pool<Room>, &mut Vec<AtomicU32>) {
        (&mut self.multipliers, &self.rooms, &mut self.most.0)
    }
}

/// What the machine lends.
#[derive(Clone, Copy)]
pub(crate) struct Machine<'a> {
    pub(crate) instructions: InstructionSet,
    pub(crate) workers: Option<&'a dyn Workers>,
}

/// Sweeps each island until the largest error met in it is within its tolerance, at most `max_sweeps` times; then derives the velocities, unless that
/// is `open`: contacts between islands come first, and [`settle_all`] after them. Adds to the report.
pub(crate) fn solve_all(
    particles: &mut Particles,
    presses: &mut [Pressed],
    common: Common,
    open: bool,
    scratch: &mut Scratch,
    report: &mut SolverReport,
) {
    let Scratch { multipliers, rooms, excess, .. } = scratch;
    let Common { plan, machine, .. } = common;
    multipliers.resize(plan.distances.len(), plan.constraints.len());
    excess.clear();
    excess.resize(if open { particles.len() } else { 0 }, Vec4::ZERO);
    let mut left = Some((
        Places::all(particles),
        multipliers.all(),
        Presses::all(presses),
        &mut report.islands[..],
        &mut excess[..],
    ));
    let shares = plan.tasks(machine.workers.is_none()).filter_map(|task| {
        let (places, sums, presses, reports, excess) = left.take()?;
        let (own, places) = places.split_at(task.rows.end);
        let (own_sums, sums) = sums.split(Some(task.distances.end), Some(task.constraints.end));
        let (own_presses, presses) = common.contacts.split(presses, task.rows.end);
        let (own_reports, reports) = reports.split_at_mut(task.islands.len());
        let (own_excess, excess) = excess.split_at_mut(own.position.len().min(excess.len()));
        left = Some((places, sums, presses, reports, excess));
        Some(Share {
            common,
            task,
            places: own,
            sums: own_sums,
            presses: own_presses,
            reports: own_reports,
            excess: own_excess,
        })
    });
    let splits = |share: &Share| {
        let order = plan.islands[share.task.islands.start].settings.order;
        share.task.large && machine.workers.is_some() && order == Order::Cascade
    };
    let mut large = smallvec::SmallVec::<[Share; 4]>::new();
    let small = shares.filter_map(|share| {
        if splits(&share) {
            large.push(share);
            return None;
        }
        Some(share)
    });
    each(machine.workers, small, |mut share| {
        rooms.with(|room| {
            room.begin(&share.task);
            if !share.task.flocks.is_empty() {
                share.flocks(room).run();
            }
            share.one_by_one(room);
        });
    });
    for share in large {
        share.by_all(rooms);
    }
    let most = report.islands.iter().map(|island| island.last_sweeps).max().unwrap_or(0);
    report.sweeps += most;
    report.most_sweeps = report.most_sweeps.max(most);
    report.converged &= report.islands.iter().all(|island| island.converged);
}

/// Derives the velocities after an `open` [`solve_all`].
pub(crate) fn settle_all(
    particles: &mut Particles,
    presses: &mut [Pressed],
    common: Common,
    scratch: &mut Scratch,
) {
    let rows = 0..particles.len() as u32;
    let mut places = Places::all(particles);
    let (Places { position, start, velocity, .. }, excess) = (&mut places, &scratch.excess[..]);
    let Common { h, lag, machine, .. } = common;
    derive(Derive { position, start, velocity, excess, h, lag }, machine);
    if common.contacts.bounces() {
        let mut presses = Presses::all(presses);
        common.contacts.bounce(&mut places, &mut presses, rows, (h, common.gravity));
    }
}

/// A task, and what is its alone.
pub(super) struct Share<'a> {
    pub(super) common: Common<'a>,
    pub(super) task: Task,
    pub(super) places: Places<'a>,
    pub(super) sums: Sums<'a>,
    pub(super) presses: Presses<'a>,
    pub(super) reports: &'a mut [IslandReport],
    /// A place for what each particle has to have taken off, if velocities are derived later; none otherwise.
    pub(super) excess: &'a mut [Vec4],
}

impl Share<'_> {
    /// One island after the other, by one worker.
    fn one_by_one(self, room: &mut Room) {
        let Self { common, task, mut places, mut sums, mut presses, reports, excess: later } = self;
        let Common { plan, machine: Machine { instructions, .. }, .. } = common;
        let rest = core::mem::take(&mut room.rest);
        for number in rest.islands.iter().cloned().flatten() {
            let report = &mut reports[number - task.islands.start];
            let island = &plan.islands[number];
            if island.asleep {
                continue;
            }
            let sweeper = InOrder::new(plan, island, room);
            let excess =
                solve(common, island, &mut places, &mut sums, &mut presses, report, sweeper);
            let Some(excess) = excess else { continue };
            if later.is_empty() {
                room.excesses.push((number as u32, excess));
            } else {
                let rows = &plan.members[island.members.clone()];
                with(instructions, Note { excess: &excess, places: &places, rows, to: later });
            }
        }
        room.rest = rest;
        if !later.is_empty() {
            return;
        }
        let (Places { position, start, velocity, .. }, excess) = (&mut places, &[]);
        let (h, lag) = (common.h, common.lag);
        with(instructions, Derive { position, start, velocity, excess, h, lag });
        for (number, excess) in room.excesses.drain(..) {
            let members = plan.islands[number as usize].members.clone();
            excess.take_off(&mut places, &plan.members[members]);
        }
        common.bounce(&mut places, &mut presses, &task);
    }
}

impl Common<'_> {
    fn bounce(&self, places: &mut Places, presses: &mut Presses, task: &Task) {
        if self.contacts.bounces() {
            self.contacts.bounce(places, presses, task.rows.clone(), (self.h, self.gravity));
        }
    }
}

impl Share<'_> {
    /// The flocks in it.
    fn flocks<'b>(&'b mut self, room: &'b mut Room) -> Drive<'b> {
        let Self { places, excess, .. } = self;
        let Places { position, start, velocity, origin, radius, .. } = places;
        Drive {
            common: self.common,
            task: &self.task,
            position,
            motion: Motion::Substep { start, velocity, excess },
            origin,
            radius,
            reports: self.reports,
            room,
        }
    }

    /// A single large island, by all workers.
    pub(super) fn by_all(self, rooms: &Pool<Room>) {
        let Self { common, task, mut places, mut sums, mut presses, reports, excess: later } = self;
        let (Common { plan, machine, .. }, Some(report)) = (common, reports.first_mut()) else {
            return;
        };
        let island = &plan.islands[task.islands.start];
        if island.asleep {
            return;
        }
        let sweeper = Shared { plan, island, machine, rooms };
        let excess = {
            let (places, sums, presses) = (&mut places, &mut sums, &mut presses);
            solve(common, island, places, sums, presses, report, sweeper)
        };
        let rows = &plan.members[island.members.clone()];
        if !later.is_empty() {
            if let Some(excess) = &excess {
                with(machine.instructions, Note { excess, places: &places, rows, to: later });
            }
            return;
        }
        let Places { position, start, velocity, .. } = &mut places;
        let (h, lag) = (common.h, common.lag);
        derive(Derive { position, start, velocity, excess: &[], h, lag }, machine);
        if let Some(excess) = excess {
            excess.take_off(&mut places, rows);
        }
        common.bounce(&mut places, &mut presses, &task);
    }
}

/// All workers together, cluster by cluster.
struct Shared<'a> {
    plan: &'a Plan,
    island: &'a Island,
    machine: Machine<'a>,
    rooms: &'a Pool<Room>,
}

impl Sweeper for Shared<'_> {
    fn sweep(&mut self, places: &mut Places, sums: &mut Sums, manner: Manner) -> f32 {
        let (places, sums, bundles) = (places.lend(), sums.lend(), self.island.bundles.clone());
        cascade::sweep_shared(places, self.plan, bundles, sums, manner, self.machine, self.rooms)
    }
}
