//! Threads: what a simulation needs in order to use several of them.
//!
//! A simulation starts no threads. It is given [`Workers`], for instance the task pool of an engine, and cuts a step into tasks that share nothing they write
//! to. Which worker runs which task, and in what order, does not change a bit of the result. There is no barrier within a set of tasks: a worker takes tasks
//! until none is left, so a single worker, or one that starts late, is fine. A task may wait for one that was taken before it, and for no other.

use core::fmt::Debug;
use core::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use smallvec::SmallVec;

use crate::lanes::InstructionSet;

/// Threads that work for a simulation.
///
/// ```
/// use sinew::{Simulation, Workers};
///
/// /// Starts another thread for each call. A task pool does the same in a tenth of the time.
/// #[derive(Debug)]
/// struct Two;
///
/// impl Workers for Two {
///     fn run(&self, work: &(dyn Fn() + Sync)) {
///         std::thread::scope(|scope| {
///             scope.spawn(work);
///             work();
///         });
///     }
/// }
///
/// let mut world = Simulation::default();
/// world.workers = Some(std::sync::Arc::new(Two));
/// ```
pub trait Workers: Send + Sync + Debug {
    /// Calls `work` on this thread and, at the same time, on as many others as there are, and returns when all calls have returned. `work` returns when no
    /// tasks are left, so calling it less often, even once, is also correct.
    fn run(&self, work: &(dyn Fn() + Sync));

    /// Approximate number of threads that [`run`](Self::run) uses, this one included. A single large body is cut into as many parts. It does not change a bit
    /// of the result. Default 2.
    fn threads(&self) -> usize {
        2
    }
}

/// The execution context: an instruction set, and workers if there are any.
#[derive(Clone, Copy)]
pub(crate) struct ExecutionContext<'a> {
    pub(crate) instructions: InstructionSet,
    pub(crate) workers: Option<&'a dyn Workers>,
}

/// Largest number of tasks that something is cut into: enough for a few threads to end at nearly the same time, and few enough to be listed without a heap
/// allocation.
pub(crate) const TASKS: usize = 64;

/// Tasks that share nothing they write to.
pub(crate) type Tasks<T> = SmallVec<[Mutex<Option<T>>; TASKS]>;

/// Runs all tasks, on all workers if there are any.
pub(crate) fn each<T: Send>(
    workers: Option<&dyn Workers>,
    tasks: impl Iterator<Item = T>,
    work: impl Fn(T) + Sync,
) {
    let Some(workers) = workers else {
        tasks.for_each(work);
        return;
    };
    let tasks: Tasks<T> = tasks.map(|task| Mutex::new(Some(task))).collect();
    if tasks.len() < 2 {
        tasks.into_iter().filter_map(|task| task.into_inner().ok().flatten()).for_each(work);
        return;
    }
    let next = AtomicUsize::new(0);
    workers.run(&|| {
        while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
            // Each task is taken once. A worker that panicked has taken its task with it, and its panic propagates where the workers are joined.
            let task = task.lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(task) = task {
                work(task);
            }
        }
    });
}

/// Runs `work` on chunks of at least `size` items, on all workers if there are any. It gets the number of a chunk's first item, the chunk, and a result that it
/// overwrites, which may be in any state. Returns the results in order. They must not depend on where chunks begin: there is a single one without workers.
pub(crate) fn each_chunk<'r, I: Sync, R: Default + Send>(
    workers: Option<&dyn Workers>,
    items: &[I],
    size: usize,
    results: &'r mut Vec<R>,
    work: impl Fn(usize, &[I], &mut R) + Sync,
) -> &'r mut [R] {
    let all = items.len().max(1);
    let size = workers.map_or(all, |_| size.max(items.len().div_ceil(TASKS)));
    let count = items.len().div_ceil(size);
    if results.len() < count {
        results.resize_with(count, R::default);
    }
    let chunks = items.chunks(size).enumerate().zip(&mut results[..count]);
    each(workers, chunks, |((number, chunk), result)| work(number * size, chunk, result));
    &mut results[..count]
}

/// A pool of scratch objects. A task borrows one while it runs; they are kept for their memory.
#[derive(Debug, Default)]
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T: Default> Pool<T> {
    /// Calls a function with one of the objects, or with a new one if all are in use.
    pub(crate) fn with<R>(&self, use_it: impl FnOnce(&mut T) -> R) -> R {
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut one = free().pop().unwrap_or_default();
        let result = use_it(&mut one);
        free().push(one);
        result
    }
}

/// A clone starts empty: there is nothing to keep.
impl<T> Clone for Pool<T> {
    fn clone(&self) -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// This many threads, started anew for each call.
    #[derive(Debug)]
    pub(crate) struct Threads(pub(crate) usize);

    impl Workers for Threads {
        fn run(&self, work: &(dyn Fn() + Sync)) {
            std::thread::scope(|scope| (0..self.0).for_each(|_| drop(scope.spawn(work))));
        }
    }

    #[test]
    fn every_task_is_done_once_by_any_number_of_workers() {
        for workers in [1, 2, 3, 8] {
            let mut numbers = vec![0_u32; 1000];
            let chunks = numbers.chunks_mut(17).enumerate();
            each(Some(&Threads(workers)), chunks, |(number, chunk)| {
                chunk.iter_mut().for_each(|n| *n += number as u32 + 1);
            });
            assert!(numbers.iter().enumerate().all(|(i, &n)| n == i as u32 / 17 + 1), "{workers}");
        }
    }

    #[test]
    fn chunks_cover_all_items_in_order_for_any_number_of_workers() {
        let items: Vec<usize> = (0..1000).collect();
        for workers in [None, Some(Threads(1)), Some(Threads(3))] {
            let workers = workers.as_ref().map(|workers| workers as &dyn Workers);
            // Results of an earlier call are overwritten.
            let mut results = vec![vec![7]; 99];
            for (count, size) in [(1000, 1), (1000, 60), (10, 60), (0, 60)] {
                let found = each_chunk(
                    workers,
                    &items[..count],
                    size,
                    &mut results,
                    |first, chunk, result| {
                        assert_eq!(chunk[0], first);
                        result.clear();
                        result.extend_from_slice(chunk);
                    },
                );
                assert!(workers.is_some() || found.len() <= 1, "{}", found.len());
                assert!(workers.is_none() || found.len() == count.div_ceil(size.max(16)));
                assert_eq!(found.concat(), items[..count]);
            }
        }
    }

    #[test]
    fn what_is_lent_out_comes_back() {
        let pool = Pool::<Vec<u8>>::default();
        pool.with(|list| list.push(7));
        pool.with(|list| assert_eq!(list, &[7]));
    }
}
