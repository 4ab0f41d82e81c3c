//! All islands: dealt out to the workers, and reported together.

use core::sync::atomic::AtomicU32;

use super::island::{Common, InOrder, Room, Sweeper, solve};
use super::item::Manner;
use super::plan::{Island, Plan, Task};
use super::sums::{Multipliers, Sums};
use super::{IslandReport, Order, SolverReport, cascade};
use crate::constraints::Contacts;
use crate::integrate::{Derive, derive};
use crate::lanes::{InstructionSet, Lanes, Work, with};
use crate::particles::{Particles, Places};
use crate::threads::{Pool, Workers, each};

/// What solving needs and nobody saves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    multipliers: Multipliers,
    rooms: Pool<Room>,
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

/// Sweeps each island until the largest error met in it is within its tolerance, at most `max_sweeps` times; then derives the velocities, which are to be
/// means over `lag` seconds. Adds to the report.
pub(crate) fn solve_all(
    particles: &mut Particles,
    contacts: &Contacts,
    plan: &Plan,
    (h, lag): (f32, f32),
    machine: Machine,
    scratch: &mut Scratch,
    report: &mut SolverReport,
) {
    let Scratch { multipliers, rooms, .. } = scratch;
    multipliers.resize(plan.distances.len(), plan.constraints.len());
    let common = Common { plan, contacts, h };
    let mut left = Some((Places::all(particles), multipliers.all(), &mut report.islands[..]));
    let shares = plan.tasks.iter().filter_map(|task| {
        let (places, sums, reports) = left.take()?;
        let (own, places) = places.split_at(task.rows.end);
        let (own_sums, sums) = sums.split(Some(task.distances.end), Some(task.constraints.end));
        let (own_reports, reports) = reports.split_at_mut(task.islands.len());
        left = Some((places, sums, reports));
        Some(Share { common, lag, task, places: own, sums: own_sums, reports: own_reports })
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
    each(machine.workers, small, |share| {
        rooms.with(|room| with(machine.instructions, InLanes { share, room }));
    });
    for share in large {
        share.by_all(machine, rooms);
    }
    let most = report.islands.iter().map(|island| island.last_sweeps).max().unwrap_or(0);
    report.sweeps += most;
    report.most_sweeps = report.most_sweeps.max(most);
    report.converged &= report.islands.iter().all(|island| island.converged);
}

/// A task, and what is its alone.
struct Share<'a> {
    common: Common<'a>,
    lag: f32,
    task: &'a Task,
    places: Places<'a>,
    sums: Sums<'a>,
    reports: &'a mut [IslandReport],
}

/// One by one, by one worker.
struct InLanes<'a, 'b> {
    share: Share<'a>,
    room: &'b mut Room,
}

impl Work for InLanes<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { share: Share { common, lag, task, mut places, mut sums, reports }, room } = self;
        let plan = common.plan;
        room.excesses.clear();
        for (number, report) in task.islands.clone().zip(reports) {
            let island = &plan.islands[number];
            let sweeper = InOrder::<L>::new(plan, island, room);
            let excess = solve(common, island, &mut places, &mut sums, report, sweeper);
            room.excesses.extend(excess.map(|excess| (number as u32, excess)));
        }
        let Places { position, start, velocity, .. } = &mut places;
        Derive { position, start, velocity, h: common.h, lag }.run::<L>();
        for (number, excess) in room.excesses.drain(..) {
            let members = plan.islands[number as usize].members.clone();
            excess.take_off(&mut places, &plan.members[members]);
        }
    }
}

impl Share<'_> {
    /// A single large island, by all workers.
    fn by_all(self, machine: Machine, rooms: &Pool<Room>) {
        let Self { common, lag, task, mut places, mut sums, reports } = self;
        let (plan, Some(report)) = (common.plan, reports.first_mut()) else { return };
        let island = &plan.islands[task.islands.start];
        let sweeper = Shared { plan, island, machine, rooms };
        let excess = solve(common, island, &mut places, &mut sums, report, sweeper);
        let Places { position, start, velocity, .. } = &mut places;
        derive(Derive { position, start, velocity, h: common.h, lag }, machine);
        if let Some(excess) = excess {
            excess.take_off(&mut places, &plan.members[island.members.clone()]);
        }
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
