//! The one place where a scene is given threads.

use std::sync::Arc;

use rayon::{ThreadPool, ThreadPoolBuilder};
use sinew::{Simulation, Workers};

use crate::measure::{Ours, World};

/// A world that is stepped by so many threads; `None` where they cannot be had.
pub fn stepped_by(mut world: Simulation, threads: usize) -> Option<Box<dyn World>> {
    if threads > 1 {
        // The thread that steps the world waits meanwhile.
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().ok()?;
        world.workers = Some(Arc::new(Pool(pool)));
    }
    Some(Box::new(Ours(world)))
}

/// Rayon's threads.
#[derive(Debug)]
struct Pool(ThreadPool);

impl Workers for Pool {
    fn run(&self, work: &(dyn Fn() + Sync)) {
        self.0.broadcast(|_| work());
    }
}
