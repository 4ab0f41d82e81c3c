//! Pipelined wavefront: several threads take one large island through a step, each through some of its substeps.
//!
//! Each thread runs its substeps over the island as a wavefront of its own, and gives back the particles behind it. There the next thread continues with the
//! substeps that follow, while the first is still in progress. A thread waits only where it has caught up with the previous one. A particle passes between two
//! threads once, in the state that a step would store, so the bits are those of a single thread, which are those of running stage after stage.

use core::mem::take;
use core::ops::Range;
use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use smallvec::SmallVec;

use super::stages::{Stages, TILE};
use super::{Store, SweepCounts, Wavefront, run_substeps};
use crate::integrate::{Predict, StepConstants};
use crate::solve::context::SolveContext;
use crate::solve::report::IslandReport;
use crate::solve::task_slice::TaskSlice;
use crate::threads::{Pool, TASKS, Workers, each};

/// One item for each stage range or each chunk, without heap allocation.
type Few<T> = SmallVec<[T; TASKS]>;

/// Takes the one large island of a task through all substeps with several threads. Returns false, with nothing changed, if it cannot be run as a wavefront, or
/// has several sweeps in a substep: whether another sweep follows is known only after each one, so nothing can be passed on earlier.
pub(in crate::solve) fn pipelined_wavefront(
    island_step: &mut TaskSlice,
    scratches: &Pool<impl AsMut<Wavefront> + Default + Send>,
    iteration_counts: &[AtomicU32],
) -> bool {
    let SolveContext { plan, execution, .. } = island_step.context;
    let number = island_step.task.islands.start;
    let settings = &plan.islands.list[number].settings;
    if !island_step.task.large || execution.workers.is_none() || settings.max_sweeps > 1 {
        return false;
    }
    let rows = island_step.task.rows.len();
    let counts = SweepCounts::new(plan.islands.list[number].microsteps, iteration_counts);
    let iteration_counts = counts.each();
    let threads = execution.workers.map_or(1, Workers::threads);
    let found = scratches.with(|scratch| {
        stage_ranges(
            island_step,
            number,
            threads,
            iteration_counts.len(),
            &mut scratch.as_mut().stages,
        )
    });
    let Some((step, substeps)) = found else { return false };

    let began = settings.timed.then(Instant::now);
    let mut pins = scratches.with(|scratch| take(&mut scratch.as_mut().pins));
    island_step.gather_pins(number, &mut pins);
    let chunk = rows.div_ceil(TASKS).next_multiple_of(TILE);
    let chunks: Few<_> = island_step.predict(0..rows).chunks(chunk).map(Mutex::new).collect();
    let settled: Few<_> = iteration_counts.chunks(substeps).map(|_| AtomicUsize::new(0)).collect();
    let mut reports: Few<_> = settled.iter().map(|_| IslandReport::default()).collect();
    let stage_ranges = reports.iter_mut().zip(iteration_counts.chunks(substeps)).enumerate();
    each(execution.workers, stage_ranges, |(range, (report, iteration_counts))| {
        let before = range.checked_sub(1).map(|range| &settled[range]);
        let mut worker =
            PipelineWorker { chunks: &chunks, chunk, held: None, before, own: &settled[range] };
        scratches.with(|scratch| {
            let wavefront = scratch.as_mut();
            wavefront.stages.begin(plan, &plan.islands.list[number]);
            wavefront.pins.clone_from(&pins);
            let iteration_counts = (iteration_counts, range + 1 == settled.len());
            run_substeps(
                &mut worker,
                (plan, number),
                step,
                wavefront,
                report,
                iteration_counts,
                execution.instructions,
            );
        });
    });
    drop(chunks);
    scratches.with(|scratch| scratch.as_mut().pins = pins);
    let whole = &mut island_step.reports[0];
    for report in reports {
        whole.append(&report);
    }
    counts.join(whole);
    whole.seconds += began.map_or(0.0, |began| began.elapsed().as_secs_f64());
    true
}

/// The step constants of the island, and the number of substeps of each stage range. There are no more ranges than threads, and few enough that the last begins
/// before the first ends: each begins one wavefront behind the previous one.
fn stage_ranges(
    island_step: &TaskSlice,
    number: usize,
    threads: usize,
    substeps: usize,
    stages: &mut Stages,
) -> Option<(StepConstants, usize)> {
    let (plan, rows) = (island_step.context.plan, &island_step.task.rows);
    let limit = threads.clamp(1, substeps.clamp(1, TASKS));
    (1..=limit).rev().find_map(|stage_ranges| {
        let each = substeps.div_ceil(stage_ranges);
        let step = island_step.step(number, each, stages)?;
        let behind = (stage_ranges - 1) * stages.window(each, plan, rows.start, rows.len());
        (behind <= rows.len()).then_some((step, each))
    })
}

/// A thread's access to the island: it holds one chunk of rows at a time, while it reads or writes them.
struct PipelineWorker<'a, 'b> {
    chunks: &'a [Mutex<Predict<'b>>],
    /// Number of rows of each chunk.
    chunk: usize,
    held: Option<MutexGuard<'a, Predict<'b>>>,
    /// The row up to which the previous stage range is settled, if there is one.
    before: Option<&'a AtomicUsize>,
    /// The same for this stage range.
    own: &'a AtomicUsize,
}

impl Store for PipelineWorker<'_, '_> {
    fn wait(&mut self, end: usize) {
        let Some(before) = self.before else { return };
        // Usually the rows are ready already. On oversubscribed cores the previous thread may not be running at all, so the wait yields.
        let mut spins = 0;
        while before.load(Ordering::Acquire) < end {
            spins += 1;
            if spins % 64 == 0 { std::thread::yield_now() } else { core::hint::spin_loop() }
        }
    }

    fn slice(&mut self, rows: Range<usize>) -> Predict<'_> {
        let (number, first) = (rows.start / self.chunk, rows.start / self.chunk * self.chunk);
        let chunk = self.chunks[number].lock().unwrap_or_else(PoisonError::into_inner);
        self.held.insert(chunk).slice(rows.start - first..rows.end - first)
    }

    fn put_back(&mut self, settled: Option<usize>) {
        self.held = None;
        if let Some(end) = settled {
            self.own.store(end, Ordering::Release);
        }
    }
}

/// Releases the waiting threads even if this one panics.
impl Drop for PipelineWorker<'_, '_> {
    fn drop(&mut self) {
        self.own.store(usize::MAX, Ordering::Release);
    }
}
