//! Convergence masks: which of eight bodies have converged in a substep.

use crate::lanes::LANES;
use crate::solve::report::IslandReport;

/// One bit for each body, and its sweep count.
#[derive(Clone, Debug)]
pub(super) struct ConvergenceMask {
    /// Has neither converged nor used up its sweeps.
    pub(super) going: u32,
    pub(super) converged: u32,
    /// Turned too fast in this substep to be corrected along the start of the substep, so gradients are taken at the current positions.
    pub(super) fell_back: u32,
    /// Touched a plane or a surface.
    pub(super) touched: u32,
    /// Had a larger violation at the start of the substep than may be recovered in one substep.
    pub(super) violated: u32,
    pub(super) sweeps: [f32; LANES],
}

/// No body has been swept yet.
impl Default for ConvergenceMask {
    fn default() -> Self {
        Self::all_but(0)
    }
}

impl ConvergenceMask {
    /// No body has been swept yet; the bodies in the mask `inactive` are not going to be.
    pub(super) fn all_but(inactive: u32) -> Self {
        let going = ((1 << LANES) - 1) & !inactive;
        Self { going, converged: 0, fell_back: 0, touched: 0, violated: 0, sweeps: [0.0; LANES] }
    }

    /// Whether the body in a lane is to be swept again.
    pub(super) fn is_going(&self, lane: usize) -> bool {
        self.going >> lane & 1 != 0
    }

    /// Copies the state of the body in lane `from` of another mask.
    pub(super) fn copy_lane(&mut self, lane: usize, other: &Self, from: usize) {
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

    /// Adds the state to the reports of the islands, except those `asleep`. Returns the largest sweep count.
    pub(super) fn report(&self, reports: &mut [IslandReport], asleep: u32) -> u32 {
        let mut most = 0;
        let awake = |lane: usize| asleep >> lane & 1 == 0;
        for (lane, report) in reports.iter_mut().enumerate().filter(|(lane, _)| awake(*lane)) {
            let sweeps = self.sweeps[lane] as u32;
            report.note(sweeps, self.converged >> lane & 1 != 0);
            report.violated = self.violated >> lane & 1 != 0;
            report.fallbacks += self.fell_back >> lane & 1;
            most = most.max(sweeps);
        }
        most
    }
}
