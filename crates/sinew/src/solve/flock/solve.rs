//! Eight bodies, swept until each holds or its sweeps are spent: as [`solve`](crate::solve::island) does with one.

use super::{Flock, Flocks, Part, Pen, rods, touch};
use crate::constraints::{Direction, Pace, Plane};
use crate::lanes::{LANES, Lanes};
use crate::solve::island::COS_SQUARED;
use crate::solve::{IslandReport, SolverSettings};

/// How it went with each body: masks, and numbers of sweeps.
pub(super) struct Solved<L> {
    sweeps: [u32; LANES],
    converged: u32,
    /// Went back to the nearest point.
    fell_back: u32,
    /// Corrected along the start of the substep.
    pub(super) from_start: L,
    /// Touched a plane.
    pub(super) touched: L,
}

/// Solves a flock.
#[inline(always)]
pub(super) fn solve<L: Lanes>(
    flocks: &Flocks,
    flock: &Flock,
    settings: &SolverSettings,
    planes: &[Plane],
    h: f32,
    pen: &mut Pen,
) -> Solved<L> {
    let parts = &flocks.parts[flock.parts.clone()];
    let (none, all) = (L::zero(), L::zero().same(L::zero()));
    let (mut from_start, mut fell_back) = (none, none);
    if settings.direction == Direction::StepStart {
        for part in parts {
            if let Part::Rods(range) = part {
                let rods = &flocks.rods[range.clone()];
                fell_back = fell_back.or(rods::turns_too_fast::<L>(
                    rods,
                    (&pen.now, &pen.start),
                    COS_SQUARED,
                ));
            }
        }
        from_start = fell_back.select(none, all);
    }
    pen.sums.fill([0.0; LANES]);
    let pace = Pace { h, sweeps: settings.max_sweeps };
    let (mut done, mut converged, mut touched, mut kept) = (none, none, none, none);
    let mut sweeps = none;
    let any_from_start = from_start.any();
    for sweep in 1..=settings.max_sweeps {
        let mut worst = none;
        for part in parts {
            worst = match part {
                Part::Rods(range) => {
                    let rods = &flocks.rods[range.clone()];
                    let spots = (&mut pen.now[..], &pen.start[..]);
                    if any_from_start {
                        rods::sweep::<L, true>(rods, spots, from_start, worst)
                    } else {
                        rods::sweep::<L, false>(rods, spots, from_start, worst)
                    }
                }
                Part::Laws(part) => flocks.alike.sweep::<L>(part, pen, pace, worst),
            };
        }
        if !planes.is_empty() {
            let depth = touch::touch::<L>(planes, pen);
            touched = touched.or(done.select(none, none.lt(depth)));
            worst = depth.max(worst);
        }
        let good = done.select(none, worst.le(L::splat(settings.tolerance)));
        sweeps = done.select(sweeps, L::splat(sweep as f32));
        (done, converged) = (done.or(good), converged.or(good));
        if done.all() || sweep == settings.max_sweeps {
            break;
        }
        if good.any() {
            pen.keep(good);
            kept = kept.or(good);
        }
    }
    if kept.any() {
        pen.put_back(kept);
    }
    let (converged, fell_back) = (converged.bits(), fell_back.bits());
    let sweeps = sweeps.array().map(|sweeps| sweeps as u32);
    Solved { sweeps, converged, fell_back, from_start, touched }
}

impl<L> Solved<L> {
    /// Tells it the reports of the islands; returns the most sweeps.
    pub(super) fn report(&self, reports: &mut [IslandReport]) -> u32 {
        let mut most = 0;
        for (lane, report) in reports.iter_mut().enumerate() {
            let sweeps = self.sweeps[lane];
            report.sweeps += sweeps;
            report.most_sweeps = report.most_sweeps.max(sweeps);
            report.last_sweeps = sweeps;
            report.converged &= self.converged >> lane & 1 != 0;
            report.fallbacks += self.fell_back >> lane & 1;
            most = most.max(sweeps);
        }
        most
    }
}
