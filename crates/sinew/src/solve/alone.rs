//! Whole steps in one go: where nothing but gravity acts from outside, no island needs to know of another between two substeps. So a task takes its
//! islands through all substeps of a step, while their particles lie in a core's own cache, and threads meet once a step instead of thrice a substep.
//! The bits are those of phase after phase.

use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};

use glam::{Vec3, Vec4};
use smallvec::SmallVec;

use super::flock::{Drive, Motion, Whole};
use super::island::{Common, InOrder, Room, solve};
use super::plan::Task;
use super::sums::Sums;
use super::wave::{relay, roll_waves};
use super::world::{Machine, Scratch, Share};
use super::{IslandReport, SolverReport};
use crate::collide::{Pressed, Presses};
use crate::integrate::{Derive, Predict, predict_all};
use crate::lanes::with;
use crate::particles::{Particles, Places};
use crate::threads::{Pool, each};

/// Predicts, solves and derives, so many substeps of `h` seconds. Forces have been summed up, and are the same in all of them.
pub(crate) fn advance_all(
    particles: &mut Particles,
    presses: &mut [Pressed],
    common: Common,
    substeps: u32,
    scratch: &mut Scratch,
    report: &mut SolverReport,
) {
    let (multipliers, rooms, most) = scratch.parts();
    let Common { plan, machine, .. } = common;
    multipliers.resize(plan.distances.len(), plan.constraints.len());
    most.clear();
    most.resize_with(substeps as usize, AtomicU32::default);
    let outside = Outside { common: particles.common, air: particles.air };
    let damping = match &particles.survey.damping {
        Some(all) => core::slice::from_ref(all),
        None => particles.damping.as_slice(),
    };
    let mut left = Some((
        particles.position.as_mut_slice(),
        particles.start.as_mut_slice(),
        particles.velocity.as_mut_slice(),
        particles.rounding.as_mut_slice(),
        multipliers.all(),
        Presses::all(presses),
        &mut report.islands[..],
    ));
    let (origins, radii) = (&particles.origin, &particles.radius);
    let shares = plan.tasks(machine.workers.is_none()).filter_map(|task| {
        let (position, start, velocity, rounding, sums, presses, reports) = left.take()?;
        let rows = task.rows.start as usize..task.rows.end as usize;
        let (position, positions) = position.split_at_mut(rows.len());
        let (start, starts) = start.split_at_mut(rows.len());
        let (velocity, velocities) = velocity.split_at_mut(rows.len());
        let (rounding, roundings) = rounding.split_at_mut(rows.len());
        let (own_sums, sums) = sums.split(Some(task.distances.end), Some(task.constraints.end));
        let (own_presses, presses) = common.contacts.split(presses, task.rows.end);
        let (own_reports, reports) = reports.split_at_mut(task.islands.len());
        left = Some((positions, starts, velocities, roundings, sums, presses, reports));
        Some(Alone {
            common,
            outside,
            task,
            position,
            start,
            velocity,
            rounding,
            damping: if damping.len() < 2 { damping } else { &damping[rows.clone()] },
            origin: &origins[rows.clone()],
            radius: &radii[rows],
            sums: own_sums,
            presses: own_presses,
            reports: own_reports,
        })
    });
    let most = &*most;
    let mut large = SmallVec::<[Alone; 4]>::new();
    let small = shares.filter_map(|alone| {
        if alone.task.large && machine.workers.is_some() {
            large.push(alone);
            return None;
        }
        Some(alone)
    });
    each(machine.workers, small, |mut alone| {
        rooms.with(|room| {
            room.begin(&alone.task);
            if !alone.task.flocks.is_empty() {
                alone.flocks(room, most).run();
            }
            roll_waves(&mut alone, room, most);
            if !room.rest.is_empty() {
                alone.one_by_one(room, most);
            }
        });
    });
    for mut alone in large {
        if !relay(&mut alone, rooms, most) {
            alone.by_all(rooms, most);
        }
    }
    for most in most {
        let most = most.load(Ordering::Relaxed);
        report.sweeps += most;
        report.most_sweeps = report.most_sweeps.max(most);
    }
    report.converged &= report.islands.iter().all(|island| island.converged);
}

/// What acts on all particles alike.
#[derive(Clone, Copy)]
pub(super) struct Outside {
    /// Acceleration, m/s².
    pub(super) common: Vec3,
    /// Damping, 1/s.
    pub(super) air: f32,
}

/// A task, and what is its alone.
pub(super) struct Alone<'a> {
    pub(super) common: Common<'a>,
    pub(super) outside: Outside,
    pub(super) task: Task,
    position: &'a mut [Vec4],
    start: &'a mut [Vec4],
    velocity: &'a mut [Vec4],
    rounding: &'a mut [Vec4],
    /// One number for all, or one for each.
    pub(super) damping: &'a [f32],
    origin: &'a [Vec3],
    radius: &'a [f32],
    sums: Sums<'a>,
    presses: Presses<'a>,
    pub(super) reports: &'a mut [IslandReport],
}

impl Alone<'_> {
    /// Some of its particles, to be predicted; counted from its first row on.
    #[inline(always)]
    pub(super) fn predict(&mut self, rows: Range<usize>) -> Predict<'_> {
        let damping = self.damping;
        Predict {
            position: &mut self.position[rows.clone()],
            start: &mut self.start[rows.clone()],
            velocity: &mut self.velocity[rows.clone()],
            rounding: &mut self.rounding[rows.clone()],
            acceleration: &[],
            damping: if damping.len() < 2 { damping } else { &damping[rows] },
            medium: &[],
            common: self.outside.common.extend(0.0),
            air: self.outside.air,
            h: self.common.h,
        }
    }

    /// The flocks in it.
    fn flocks<'b>(&'b mut self, room: &'b mut Room, most: &'b [AtomicU32]) -> Drive<'b> {
        Drive {
            common: self.common,
            task: &self.task,
            position: self.position,
            origin: self.origin,
            radius: self.radius,
            reports: self.reports,
            motion: Motion::Step(Whole {
                start: self.start,
                velocity: self.velocity,
                rounding: self.rounding,
                damping: self.damping,
                air: self.outside.air,
                common: self.outside.common,
                most,
            }),
            room,
        }
    }
}

impl Alone<'_> {
    /// A single large island, by all workers, who meet after each stage of each sweep.
    fn by_all(mut self, rooms: &Pool<Room>, most: &[AtomicU32]) {
        let (rows, machine) = (self.task.rows.len(), self.common.machine);
        for (number, most) in most.iter().enumerate() {
            predict_all(self.predict(0..rows), machine);
            let share = Share {
                common: Common { substep: self.common.substep + number as u32, ..self.common },
                task: self.task.clone(),
                places: Places {
                    first: self.task.rows.start,
                    position: self.position,
                    start: self.start,
                    origin: self.origin,
                    radius: self.radius,
                    velocity: self.velocity,
                },
                sums: self.sums.lend(),
                presses: self.presses.lend(),
                reports: self.reports,
                excess: &mut [],
            };
            share.by_all(rooms);
            most.fetch_max(self.reports[0].last_sweeps, Ordering::Relaxed);
        }
    }
}

impl Alone<'_> {
    /// Its islands one after the other through all substeps. `most` are the most sweeps in each.
    fn one_by_one(self, room: &mut Room, most: &[AtomicU32]) {
        let Self { common, outside, task, position, start, velocity, rounding, .. } = self;
        let (mut sums, mut presses, reports) = (self.sums, self.presses, self.reports);
        let Common { plan, h, machine: Machine { instructions, .. }, .. } = common;
        let rest = core::mem::take(&mut room.rest);
        let in_task = |rows: &Range<u32>| {
            (rows.start - task.rows.start) as usize..(rows.end - task.rows.start) as usize
        };
        let islands = || rest.islands.iter().cloned().flatten();
        for (number, most) in most.iter().enumerate() {
            let common = Common { substep: common.substep + number as u32, ..common };
            for rows in rest.rows.iter().map(in_task) {
                let damping = self.damping;
                let predict = Predict {
                    position: &mut position[rows.clone()],
                    start: &mut start[rows.clone()],
                    velocity: &mut velocity[rows.clone()],
                    rounding: &mut rounding[rows.clone()],
                    acceleration: &[],
                    damping: if damping.len() < 2 { damping } else { &damping[rows] },
                    medium: &[],
                    common: outside.common.extend(0.0),
                    air: outside.air,
                    h,
                };
                with(instructions, predict);
            }
            let mut places = Places {
                first: task.rows.start,
                position,
                start,
                origin: self.origin,
                radius: self.radius,
                velocity,
            };
            room.excesses.clear();
            let mut sweeps = 0;
            for number in islands() {
                let report = &mut reports[number - task.islands.start];
                let island = &plan.islands[number];
                if island.asleep {
                    continue;
                }
                let sweeper = InOrder::new(plan, island, room);
                let excess =
                    solve(common, island, &mut places, &mut sums, &mut presses, report, sweeper);
                room.excesses.extend(excess.map(|excess| (number as u32, excess)));
                sweeps = sweeps.max(report.last_sweeps);
            }
            most.fetch_max(sweeps, Ordering::Relaxed);
            for rows in rest.rows.iter().map(in_task) {
                let (position, start) =
                    (&places.position[rows.clone()], &places.start[rows.clone()]);
                let velocity = &mut places.velocity[rows];
                let derive = Derive { position, start, velocity, excess: &[], h, lag: h };
                with(instructions, derive);
            }
            for (number, excess) in room.excesses.drain(..) {
                let members = plan.islands[number as usize].members.clone();
                excess.take_off(&mut places, &plan.members[members]);
            }
            if common.contacts.bounces() {
                let moment = (h, common.gravity);
                common.contacts.bounce(&mut places, &mut presses, task.rows.clone(), moment);
            }
        }
        room.rest = rest;
    }
}
