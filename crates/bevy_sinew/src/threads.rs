//! Threads for the solver: Bevy's own pool, or whatever a game lends.

use std::sync::{Arc, OnceLock};

use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, available_parallelism};
use sinew::Workers;

use crate::config::SolverConfig;
use crate::world::SinewWorld;

/// Who helps the solver, while [`SolverConfig::threads`] says so. Not part of the state: any number of threads gives the same bits.
///
/// By default [`ComputePool`], or nobody on a machine with one processor. Put anything else that is [`Workers`] here, such as a pool of the game's
/// own.
#[derive(Resource, Clone, Debug)]
pub struct SinewWorkers(pub Option<Arc<dyn Workers>>);

impl Default for SinewWorkers {
    fn default() -> Self {
        let several = processors() > 1;
        Self(several.then(|| Arc::new(ComputePool) as Arc<dyn Workers>))
    }
}

/// The threads of Bevy's [`ComputeTaskPool`], and the one that the tick runs on. Where there is no pool, that one alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct ComputePool;

impl Workers for ComputePool {
    fn run(&self, work: &(dyn Fn() + Sync)) {
        let Some(pool) = ComputeTaskPool::try_get() else { return work() };
        pool.scope(|scope| {
            (0..pool.thread_num()).for_each(|_| scope.spawn(async move { work() }));
            // Not handed to the scope: this thread begins at once, and what the others have not taken by the end is nothing.
            work();
        });
    }

    fn threads(&self) -> usize {
        let there = ComputeTaskPool::try_get().map_or(0, |pool| pool.thread_num());
        (there + 1).min(processors())
    }
}

/// How many threads the machine runs side by side. To ask that reads files of the system, which takes tens of microseconds: once is enough.
fn processors() -> usize {
    static PROCESSORS: OnceLock<usize> = OnceLock::new();
    *PROCESSORS.get_or_init(available_parallelism)
}

/// Lends the solver its helpers, or takes them back.
pub(crate) fn lend(
    mut world: ResMut<SinewWorld>,
    config: Res<SolverConfig>,
    workers: Res<SinewWorkers>,
) {
    let lent = workers.0.as_ref().filter(|_| config.threads);
    let has = world.simulation.workers.as_ref();
    let same = match (has, lent) {
        (Some(has), Some(lent)) => Arc::ptr_eq(has, lent),
        (None, None) => true,
        _ => false,
    };
    if !same {
        world.simulation.workers = lent.cloned();
    }
}
