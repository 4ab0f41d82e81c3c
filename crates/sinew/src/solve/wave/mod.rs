//! Waves: all substeps of a step rolling through an island one behind the other, while its particles are in columns.
//!
//! One sweep over a large island reads all of it from memory, and the next one again. But what a substep does with a particle depends only on what
//! its neighbours did: the second may begin at one end while the first is still on its way to the other. So the passes of a step, `predict`, each
//! stage of the sweep, `derive` with the next `predict` and so on, follow each other at the distance of a cluster or two, and the particles between
//! the first and the last are a few clusters, which a cache holds.
//!
//! **The bits are those of pass after pass.** A pass takes its pieces in the order of their rows, and a piece waits until all earlier passes are
//! beyond its last row; so whatever touches a particle does so in the same order. What has to know the largest error of a whole sweep, whether
//! another follows, cannot be overtaken; there the passes follow each other, and what is gained is that particles stay in columns.
//!
//! Several threads take a large island through a step as a [relay].

mod passes;
mod relay;
mod window;

use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use super::alone::Alone;
use super::island::Room;
use super::plan::{Bundle, Group, Plan};
use super::{IslandReport, Order};
use crate::constraints::Direction;
use crate::integrate::{Course, Pass, Predict};
use crate::lanes::InstructionSet;
use passes::{Passes, Piece, What};
pub(super) use relay::relay;
use window::Window;

/// What a wave needs. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct Wave {
    window: Window,
    passes: Passes,
    /// The largest error that each substep found, metres.
    worst: Vec<f32>,
    /// What is left at the end of the step: the largest error, metres, and the largest share of a rest length.
    left: (f32, f32),
}

/// Takes the islands of a task through a step that can go as waves, and out of what is left of the task. `most` are the most sweeps in each substep.
pub(super) fn roll_waves(alone: &mut Alone, room: &mut Room, most: &[AtomicU32]) {
    let mut rest = core::mem::take(&mut room.rest);
    let mut wave = core::mem::take(&mut room.wave);
    let begin = alone.task.islands.start;
    for number in alone.task.islands.clone() {
        if !rest.holds(number) {
            continue;
        }
        let course = alone.course(number, most.len(), &mut wave.passes);
        let Some(course) = course else { continue };
        let (plan, mut report) = (alone.common.plan, alone.reports[number - begin]);
        let members = &plan.members[plan.islands[number].members.clone()];
        let first = (members[0] - alone.task.rows.start) as usize;
        let instructions = alone.common.machine.instructions;
        let mut own = Own { alone, first };
        let measured = (most, true);
        drive(&mut own, (plan, number), course, &mut wave, &mut report, measured, instructions);
        alone.reports[number - begin] = report;
        rest.leave(number..number + 1, members[0]..members[0] + members.len() as u32);
    }
    (room.rest, room.wave) = (rest, wave);
}

impl Alone<'_> {
    /// How an island would go through so many substeps, if it can: clusters of rods in columns alone, which nothing but each other holds back.
    fn course(&self, number: usize, substeps: usize, passes: &mut Passes) -> Option<Course> {
        let Self { common, outside, damping, .. } = self;
        let plan = common.plan;
        let island = &plan.islands[number];
        let members = &plan.members[island.members.clone()];
        let (first, last) = (*members.first()?, *members.last()?);
        let fits = |bundle: &Bundle| {
            let from = bundle.rows.start.checked_sub(first);
            bundle.columns && from.is_some_and(|from| from.is_multiple_of(2))
        };
        let bundles = island.bundles.clone();
        let held = island.asleep || island.rigid || island.free || island.groups.is_empty();
        let touches = !common.contacts.is_empty() || common.contacts.bounces();
        let fit = !held
            && !touches
            && island.settings.order == Order::Cascade
            && island.settings.direction == Direction::Nearest
            && members.len() == (last - first) as usize + 1
            && plan.bundles[bundles.clone()].iter().all(fits);
        let rate = match damping {
            [] => 0.0,
            [all] => *all,
            _ => return None,
        };
        let rate = rate + (outside.air + 0.0);
        if !fit {
            return None;
        }
        passes.begin(&plan.bundles[bundles.clone()], bundles.start);
        // All of a small island has room. Of a large one, what is on its way has, unless it is whole sweeps.
        let (rows, room) = (members.len(), Window::room(plan.rods.half()));
        let rolls = island.settings.max_sweeps == 1;
        if rows > room && !(rolls && passes.span(substeps, plan, first, rows) <= room) {
            return None;
        }
        Course::new(outside.common, rate, common.h)
    }
}

/// Where the particles of an island are kept. Rows count from the first of the island.
trait Store {
    /// Returns when all rows before one may be taken up.
    fn wait(&mut self, end: usize);

    /// Some rows, to be read or to be written.
    fn lend(&mut self, rows: Range<usize>) -> Predict<'_>;

    /// They are not needed any more; all rows before `settled` not at all.
    fn put_back(&mut self, settled: Option<usize>);
}

/// In the columns of a task, which nobody else has.
struct Own<'a, 'b> {
    alone: &'a mut Alone<'b>,
    /// The first row of the island in those.
    first: usize,
}

impl Store for Own<'_, '_> {
    #[inline(always)]
    fn wait(&mut self, _: usize) {}

    #[inline(always)]
    fn lend(&mut self, rows: Range<usize>) -> Predict<'_> {
        self.alone.predict(self.first + rows.start..self.first + rows.end)
    }

    #[inline(always)]
    fn put_back(&mut self, _: Option<usize>) {}
}

/// Takes an island through some substeps: rolling if each has one sweep, or else sweep by sweep. Measures what is left then if those are the last of
/// a step.
fn drive(
    store: &mut impl Store,
    (plan, number): (&Plan, usize),
    course: Course,
    wave: &mut Wave,
    report: &mut IslandReport,
    (most, measures): (&[AtomicU32], bool),
    instructions: InstructionSet,
) {
    let settings = &plan.islands[number].settings;
    let began = settings.timed.then(Instant::now);
    let rolls = settings.max_sweeps == 1;
    wave.window.begin(plan.rods.half());
    wave.left = (0.0, 0.0);
    wave.worst.clear();
    wave.worst.resize(most.len(), 0.0);
    wave.passes.clear();
    let (mut substep, mut sweeps) = (0, 0);
    if rolls {
        wave.passes.push_all(most.len(), measures);
    } else {
        wave.passes.push(What::Begin);
        wave.passes.push_sweep(0);
    }
    loop {
        wave.roll(store, (plan, number), course, most.len(), instructions);
        if rolls {
            for (worst, most) in wave.worst.iter().zip(most) {
                report.note(1, *worst <= settings.tolerance);
                most.fetch_max(1, Ordering::Relaxed);
            }
            break;
        }
        if substep == most.len() {
            break;
        }
        sweeps += 1;
        let converged = wave.worst[substep] <= settings.tolerance;
        wave.passes.clear();
        if sweeps < settings.max_sweeps && !converged {
            wave.worst[substep] = 0.0;
            wave.passes.push_sweep(substep);
            continue;
        }
        report.note(sweeps, converged);
        most[substep].fetch_max(sweeps, Ordering::Relaxed);
        (substep, sweeps) = (substep + 1, 0);
        if substep < most.len() {
            wave.passes.push(What::GoOn(substep));
            wave.passes.push_sweep(substep);
        } else {
            wave.passes.push_end(measures);
        }
    }
    if measures {
        report.note_left(wave.left);
    }
    report.seconds += began.map_or(0.0, |began| began.elapsed().as_secs_f64());
}

impl IslandReport {
    /// Notes how a substep went.
    fn note(&mut self, sweeps: u32, converged: bool) {
        self.sweeps += sweeps;
        self.most_sweeps = self.most_sweeps.max(sweeps);
        self.last_sweeps = sweeps;
        self.converged &= converged;
    }

    /// Notes what is left of it at the end of a step.
    fn note_left(&mut self, (error, strain): (f32, f32)) {
        (self.error, self.strain, self.measured) = (error, strain, true);
    }
}

impl Wave {
    /// Does all passes.
    fn roll(
        &mut self,
        store: &mut impl Store,
        (plan, number): (&Plan, usize),
        course: Course,
        substeps: usize,
        instructions: InstructionSet,
    ) {
        let members = plan.islands[number].members.clone();
        let (first, all) = (plan.members[members.start], members.len());
        let Self { window, passes, worst, left } = self;
        passes.start(all);
        while let Some(Piece { what, rows, bundle, settled }) = passes.next(plan, first, all) {
            match what {
                What::Begin => {
                    window.admit(rows.end, settled);
                    store.wait(rows.end);
                    window.turn_in(rows.start, &store.lend(rows.clone()), instructions);
                    store.put_back(None);
                    let pass = Pass::Begin { last: substeps == 1 };
                    window.moving.pass(pass, window.lanes(rows), course, instructions);
                }
                What::GoOn(substep) => {
                    let pass = Pass::GoOn { last: substep + 1 == substeps };
                    window.moving.pass(pass, window.lanes(rows), course, instructions);
                }
                What::Sweep { substep, .. } => {
                    let bundle = &plan.bundles[bundle];
                    let groups = plan.groups[bundle.groups.clone()].iter().map(Group::rods);
                    let rows = (bundle.rows.start, first + window.rows.start as u32);
                    let columns = &mut window.moving.position;
                    let found = plan.rods.sweep_turned(columns, groups, rows, instructions);
                    worst[substep] = worst[substep].max(found);
                }
                What::Measure { .. } => {
                    let bundle = &plan.bundles[bundle];
                    let groups = plan.groups[bundle.groups.clone()].iter().map(Group::rods);
                    let rows = (bundle.rows.start, first + window.rows.start as u32);
                    let columns = &mut window.moving.position;
                    let (error, strain) =
                        plan.rods.measure_turned(columns, groups, rows, instructions);
                    *left = (left.0.max(error), left.1.max(strain));
                }
                What::Settle => {
                    let lanes = window.lanes(rows.clone());
                    window.moving.pass(Pass::Settle, lanes, course, instructions);
                    window.turn_out(rows.start, store.lend(rows.clone()), instructions);
                    store.put_back(Some(rows.end));
                }
            }
        }
    }
}
