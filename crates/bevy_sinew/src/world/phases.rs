//! What is noted of the phases of a tick where somebody watches them. Nobody does in a usual tick, and each phase asks once.

use core::time::Duration;
use std::time::Instant;

use super::SinewWorld;

/// Phases that are watched.
#[derive(Debug, Default)]
pub(crate) struct PhaseWatch {
    /// When the last phase ended, on the wall.
    since: Option<Instant>,
    /// How long each phase took, summed over the substeps.
    pub(crate) took: [Duration; 6],
}

impl SinewWorld {
    /// Notes that a substep begins.
    pub(crate) fn begin_phases(&mut self) {
        if let Some(watch) = &mut self.tables.watch {
            watch.since = Some(Instant::now());
        }
    }

    /// Notes that a phase has ended.
    pub(crate) fn end_phase(&mut self, phase: usize) {
        let Some(watch) = &mut self.tables.watch else { return };
        let now = Instant::now();
        watch.took[phase] += watch.since.map_or(Duration::ZERO, |since| now - since);
        watch.since = Some(now);
    }
}
