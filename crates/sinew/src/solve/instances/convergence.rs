//! Convergence masks: which of eight bodies have converged in a substep.

use crate::lanes::LANES;
use crate::solve::report::IslandReport;

/// A bit for each body, and sweeps.
#[derive(Clone, Debug)]
pub(super) struct ConvergenceMask {
    /// Neither holds nor has spent its sweeps.
    pub(super) going: u32,
    pub(super) converged: u32,
    /// Went back to the nearest point.
    pub(super) fell_back: u32,
    /// Touched a plane.
    pub(super) touched: u32,
    /// Where more was violated when the substep began than may be recovered in it.
    pub(super) violated: u32,
    pub(super) sweeps: [f32; LANES],
}

/// All before their first sweep.
impl Default for ConvergenceMask {
    fn default() -> Self {
        Self::all_but(0)
    }
}

impl ConvergenceMask {
    /// All before their first sweep but those of a mask, which have none.
    pub(super) fn all_but(aside: u32) -> Self {
        let going = ((1 << LANES) - 1) & !aside;
        Self { going, converged: 0, fell_back: 0, touched: 0, violated: 0, sweeps: [0.0; LANES] }
    }

    /// Whether a body is to be swept again.
    pub(super) fn is_going(&self, lane: usize) -> bool {
        self.going >> lane & 1 != 0
    }

    /// Takes how it goes with one of other bodies.
    pub(super) fn take(&mut self, lane: usize, other: &Self, from: usize) {
        let copy = |to: &mut u32, bits: u32| {
            *to = *to & !(1 << lane) | (bits >> from & 1) << lane;
        };
        copy(&mut self.going, other.going);
        copy(&mut self.converged, other.converged);
        copy(&mut self.fell_back, other.fell_back);
        copy(&mut self.touched, other.touched);
        copy(&mut self.violated, other.violated);
        self.sweeps[lane] = other.sweeps[from];
    }

    /// Adds it to the reports of the islands but those `asleep`; returns the most sweeps.
    pub(super) fn report(&self, reports: &mut [IslandReport], asleep: u32) -> u32 {
        let mut most = 0;
        let awake = |lane: usize| asleep >> lane & 1 == 0;
        for (lane, report) in reports.iter_mut().enumerate().filter(|(lane, _)| awake(*lane)) {
            let sweeps = self.sweeps[lane] as u32;
            report.sweeps += sweeps;
            report.most_sweeps = report.most_sweeps.max(sweeps);
            report.last_sweeps = sweeps;
            report.converged &= self.converged >> lane & 1 != 0;
            report.violated = self.violated >> lane & 1 != 0;
            report.fallbacks += self.fell_back >> lane & 1;
            most = most.max(sweeps);
        }
        most
    }
}
