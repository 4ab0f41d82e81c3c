//! Threads for the solver: Bevy's pool, or any other that a game provides.

use std::sync::{Arc, OnceLock};

use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, available_parallelism};
use sinew::Workers;

use crate::config::SolverConfig;
use crate::world::SinewWorld;

/// The threads that the solver uses, unless [`SolverConfig::threads`] is false. Not part of the state: the results have the same bits with any number of
/// threads.
///
/// Default [`ComputePool`], or `None` (a single thread) on a machine with one processor. Any other implementation of [`Workers`] may be used, such as a game's
/// own pool.
#[derive(Resource, Clone, Debug)]
pub struct SinewWorkers(pub Option<Arc<dyn Workers>>);

impl Default for SinewWorkers {
    fn default() -> Self {
        let several = processors() > 1;
        Self(several.then(|| Arc::new(ComputePool) as Arc<dyn Workers>))
    }
}

/// The threads of Bevy's [`ComputeTaskPool`], and the thread that runs the tick. Without a pool, that thread alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct ComputePool;

impl Workers for ComputePool {
    fn run(&self, work: &(dyn Fn() + Sync)) {
        let Some(pool) = ComputeTaskPool::try_get() else { return work() };
        pool.scope(|scope| {
            (0..pool.thread_num()).for_each(|_| scope.spawn(async move { work() }));
            // Run here, not by the scope: this thread starts at once, and by its end no work is left for tasks that have not started.
            work();
        });
    }

    fn threads(&self) -> usize {
        let there = ComputeTaskPool::try_get().map_or(0, |pool| pool.thread_num());
        (there + 1).min(processors())
    }
}

/// The number of hardware threads. The query reads system files, which takes tens of microseconds, so the result is cached.
fn processors() -> usize {
    static PROCESSORS: OnceLock<usize> = OnceLock::new();
    *PROCESSORS.get_or_init(available_parallelism)
}

/// Passes the workers to the solver, or removes them.
pub(crate) fn update_workers(
    mut world: ResMut<SinewWorld>,
    config: Res<SolverConfig>,
    workers: Res<SinewWorkers>,
) {
    let wanted = workers.0.as_ref().filter(|_| config.threads);
    let current = world.simulation.workers.as_ref();
    let same = match (current, wanted) {
        (Some(current), Some(wanted)) => Arc::ptr_eq(current, wanted),
        (None, None) => true,
        _ => false,
    };
    if !same {
        world.simulation.workers = wanted.cloned();
    }
}
