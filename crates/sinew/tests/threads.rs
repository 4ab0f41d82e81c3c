//! Threads for the tests that vary their number.

use sinew::Workers;

/// Threads that are spawned for each call.
#[derive(Debug)]
pub(crate) struct Threads(pub(crate) usize);

impl Workers for Threads {
    fn run(&self, work: &(dyn Fn() + Sync)) {
        std::thread::scope(|scope| {
            (1..self.0).for_each(|_| drop(scope.spawn(work)));
            work();
        });
    }

    fn threads(&self) -> usize {
        self.0
    }
}
