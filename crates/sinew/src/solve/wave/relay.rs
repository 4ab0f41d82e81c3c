//! Relays: several threads take one large island through a step, each through some of its substeps.
//!
//! Each rolls its substeps over the island as a wave of its own, and gives back the particles behind it; there the next one takes them up for the
//! substeps that follow, while the first is still on its way. It waits where it has caught up, and nowhere else. Between two threads a particle
//! changes hands once, by what a step would keep of it: so the bits are those of one thread, which are those of pass after pass.

use core::ops::Range;
use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use smallvec::SmallVec;

use super::passes::{PIECE, Passes};
use super::{Store, drive};
use crate::integrate::{Course, Predict};
use crate::solve::IslandReport;
use crate::solve::alone::Alone;
use crate::solve::island::{Common, Room};
use crate::threads::{Pool, TASKS, Workers, each};

/// A list of what there is one of for each leg or each lot, without a heap.
type Few<T> = SmallVec<[T; TASKS]>;

/// From so many rows on, threads that meet after each stage of each sweep are faster than one alone that keeps the particles in columns. Two of them
/// have two thirds of its speed at 16 thousand, and 1.2 times as much at 65 thousand.
const MEET: usize = 32_768;

/// Takes the one large island of a task through all substeps, if it can go as a wave; false if it is left as it was.
pub(in crate::solve) fn relay(alone: &mut Alone, rooms: &Pool<Room>, most: &[AtomicU32]) -> bool {
    let Common { plan, machine, .. } = alone.common;
    let number = alone.task.islands.start;
    let settings = &plan.islands[number].settings;
    let rows = alone.task.rows.len();
    let threads = match settings.max_sweeps {
        1 => machine.workers.map_or(1, Workers::threads),
        // Whether another sweep follows is known when one is done: there is nothing to hand on.
        _ if rows < MEET => 1,
        _ => return false,
    };
    let found = rooms.with(|room| legs(alone, number, threads, most.len(), &mut room.wave.passes));
    let Some((course, substeps)) = found else { return false };

    let began = settings.timed.then(Instant::now);
    let lot = rows.div_ceil(TASKS).next_multiple_of(PIECE);
    let lots: Few<_> = alone.predict(0..rows).chunks(lot).map(Mutex::new).collect();
    let settled: Few<_> = most.chunks(substeps).map(|_| AtomicUsize::new(0)).collect();
    let mut reports: Few<_> = settled.iter().map(|_| IslandReport::default()).collect();
    let legs = reports.iter_mut().zip(most.chunks(substeps)).enumerate();
    each(machine.workers, legs, |(leg, (report, most))| {
        let before = leg.checked_sub(1).map(|leg| &settled[leg]);
        let mut runner = Runner { lots: &lots, lot, held: None, before, own: &settled[leg] };
        rooms.with(|room| {
            let (wave, bundles) = (&mut room.wave, plan.islands[number].bundles.clone());
            wave.passes.begin(&plan.bundles[bundles.clone()], bundles.start);
            let most = (most, leg + 1 == settled.len());
            drive(&mut runner, (plan, number), course, wave, report, most, machine.instructions);
        });
    });
    drop(lots);
    let whole = &mut alone.reports[0];
    for report in reports {
        whole.sweeps += report.sweeps;
        whole.most_sweeps = whole.most_sweeps.max(report.most_sweeps);
        whole.last_sweeps = report.last_sweeps;
        whole.converged &= report.converged;
        (whole.error, whole.strain) = (report.error, report.strain);
        whole.measured = report.measured;
    }
    whole.seconds += began.map_or(0.0, |began| began.elapsed().as_secs_f64());
    true
}

/// How the island would go, and how many substeps each leg has. There are no more legs than threads, and so few that the last begins before the first
/// ends: each begins one wave behind the one before it.
fn legs(
    alone: &Alone,
    number: usize,
    threads: usize,
    substeps: usize,
    passes: &mut Passes,
) -> Option<(Course, usize)> {
    let (plan, rows) = (alone.common.plan, &alone.task.rows);
    let most = threads.clamp(1, substeps.clamp(1, TASKS));
    (1..=most).rev().find_map(|legs| {
        let each = substeps.div_ceil(legs);
        let course = alone.course(number, each, passes)?;
        let behind = (legs - 1) * passes.span(each, plan, rows.start, rows.len());
        (behind <= rows.len()).then_some((course, each))
    })
}

/// What a thread has of the island: a lot of its rows at a time, while it takes them up or gives them back.
struct Runner<'a, 'b> {
    lots: &'a [Mutex<Predict<'b>>],
    /// Rows in each.
    lot: usize,
    held: Option<MutexGuard<'a, Predict<'b>>>,
    /// Before which row all is settled of the leg before, if there is one.
    before: Option<&'a AtomicUsize>,
    /// And of this one.
    own: &'a AtomicUsize,
}

impl Store for Runner<'_, '_> {
    fn wait(&mut self, end: usize) {
        let Some(before) = self.before else { return };
        // Mostly it is there already. On shared cores the one that is waited for may not be running at all: let it.
        let mut spins = 0;
        while before.load(Ordering::Acquire) < end {
            spins += 1;
            if spins % 64 == 0 { std::thread::yield_now() } else { core::hint::spin_loop() }
        }
    }

    fn lend(&mut self, rows: Range<usize>) -> Predict<'_> {
        let (number, first) = (rows.start / self.lot, rows.start / self.lot * self.lot);
        let lot = self.lots[number].lock().unwrap_or_else(PoisonError::into_inner);
        self.held.insert(lot).lend(rows.start - first..rows.end - first)
    }

    fn put_back(&mut self, settled: Option<usize>) {
        self.held = None;
        if let Some(end) = settled {
            self.own.store(end, Ordering::Release);
        }
    }
}

/// Whatever becomes of a thread, nobody waits for it forever.
impl Drop for Runner<'_, '_> {
    fn drop(&mut self) {
        self.own.store(usize::MAX, Ordering::Release);
    }
}
