//! Whole steps in one go: where nothing but gravity acts from outside, no island needs to know of another between two substeps. So a task takes its islands through all
//! substeps of a step, while their particles lie in a core's own cache, and threads meet once a step instead of thrice a substep. The bits are those of phase after phase.

use core::sync::atomic::{AtomicU32, Ordering};

use glam::{Vec3, Vec4};

use super::island::{Common, InOrder, Room, solve};
use super::plan::Task;
use super::sums::Sums;
use super::world::{Machine, Scratch};
use super::{IslandReport, Plan, SolverReport};
use crate::constraints::Contacts;
use crate::integrate::{Derive, Predict};
use crate::lanes::{Lanes, Work, with};
use crate::particles::{Particles, Places};
use crate::threads::each;

/// Predicts, solves and derives, so many substeps of `h` seconds. Forces have been summed up, and are the same in all of them.
pub(crate) fn advance_all(
    particles: &mut Particles,
    contacts: &Contacts,
    plan: &Plan,
    (h, substeps): (f32, u32),
    machine: Machine,
    scratch: &mut Scratch,
    report: &mut SolverReport,
) {
    let (multipliers, rooms, most) = scratch.parts();
    multipliers.resize(plan.distances.len(), plan.constraints.len());
    most.clear();
    most.resize_with(substeps as usize, AtomicU32::default);
    let common = Common { plan, contacts, h };
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
        &mut report.islands[..],
    ));
    let (origins, radii) = (&particles.origin, &particles.radius);
    let shares = plan.tasks.iter().filter_map(|task| {
        let (position, start, velocity, rounding, sums, reports) = left.take()?;
        let rows = task.rows.start as usize..task.rows.end as usize;
        let (position, positions) = position.split_at_mut(rows.len());
        let (start, starts) = start.split_at_mut(rows.len());
        let (velocity, velocities) = velocity.split_at_mut(rows.len());
        let (rounding, roundings) = rounding.split_at_mut(rows.len());
        let (own_sums, sums) = sums.split(Some(task.distances.end), Some(task.constraints.end));
        let (own_reports, reports) = reports.split_at_mut(task.islands.len());
        left = Some((positions, starts, velocities, roundings, sums, reports));
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
            reports: own_reports,
        })
    });
    let most = &*most;
    each(machine.workers, shares, |alone| {
        rooms.with(|room| with(machine.instructions, Substeps { alone, room, most }));
    });
    for most in most {
        let most = most.load(Ordering::Relaxed);
        report.sweeps += most;
        report.most_sweeps = report.most_sweeps.max(most);
    }
    report.converged &= report.islands.iter().all(|island| island.converged);
}

/// What acts on all particles alike.
#[derive(Clone, Copy)]
struct Outside {
    /// Acceleration, m/s².
    common: Vec3,
    /// Damping, 1/s.
    air: f32,
}

/// A task, and what is its alone.
struct Alone<'a> {
    common: Common<'a>,
    outside: Outside,
    task: &'a Task,
    position: &'a mut [Vec4],
    start: &'a mut [Vec4],
    velocity: &'a mut [Vec4],
    rounding: &'a mut [Vec4],
    damping: &'a [f32],
    origin: &'a [Vec3],
    radius: &'a [f32],
    sums: Sums<'a>,
    reports: &'a mut [IslandReport],
}

struct Substeps<'a, 'b> {
    alone: Alone<'a>,
    room: &'b mut Room,
    /// The most sweeps in each substep.
    most: &'b [AtomicU32],
}

impl Work for Substeps<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { alone, room, most } = self;
        let Alone { common, outside, task, position, start, velocity, rounding, .. } = alone;
        let (plan, h, mut sums, reports) = (common.plan, common.h, alone.sums, alone.reports);
        for most in most {
            let predict = Predict {
                position,
                start,
                velocity,
                rounding,
                acceleration: &[],
                damping: alone.damping,
                medium: &[],
                common: outside.common.extend(0.0),
                air: outside.air,
                h,
            };
            predict.run::<L>();
            let mut places = Places {
                first: task.rows.start,
                position,
                start,
                origin: alone.origin,
                radius: alone.radius,
                velocity,
            };
            room.excesses.clear();
            let mut sweeps = 0;
            for (number, report) in task.islands.clone().zip(reports.iter_mut()) {
                let island = &plan.islands[number];
                let sweeper = InOrder::<L>::new(plan, island, room);
                let excess = solve(common, island, &mut places, &mut sums, report, sweeper);
                room.excesses.extend(excess.map(|excess| (number as u32, excess)));
                sweeps = sweeps.max(report.last_sweeps);
            }
            most.fetch_max(sweeps, Ordering::Relaxed);
            let Places { position, start, velocity, .. } = &mut places;
            Derive { position, start, velocity, h, lag: h }.run::<L>();
            for (number, excess) in room.excesses.drain(..) {
                let members = plan.islands[number as usize].members.clone();
                excess.take_off(&mut places, &plan.members[members]);
            }
        }
    }
}
