//! Eight bodies, swept until each holds or its sweeps are spent: as [`solve`](crate::solve::island) does with one.

use super::{Course, Flock, Flocks, Part, Pen, rods, touch};
use crate::constraints::{Direction, Pace, Plane};
use crate::lanes::Lanes;
use crate::solve::SolverSettings;
use crate::solve::island::COS_SQUARED;

/// What solving needs to know beside the pen.
#[derive(Clone, Copy)]
pub(super) struct How<'a> {
    pub(super) flocks: &'a Flocks,
    /// One whose constraints those in the pen have.
    pub(super) flock: &'a Flock,
    pub(super) settings: &'a SolverSettings,
    pub(super) planes: &'a [Plane],
    /// Length of the substep, seconds.
    pub(super) h: f32,
}

impl How<'_> {
    /// Begins a substep: none has been swept.
    #[inline(always)]
    pub(super) fn begin<L: Lanes>(&self, pen: &mut Pen) {
        pen.course = Course::default();
        pen.sums.fill([0.0; _]);
        if self.settings.direction == Direction::StepStart {
            let mut fell_back = L::zero();
            for part in &self.flocks.parts[self.flock.parts.clone()] {
                if let Part::Rods(range) = part {
                    let rods = &self.flocks.rods[range.clone()];
                    let spots = (&pen.now[..], &pen.start[..]);
                    let fast = rods::turns_too_fast::<L>(rods, spots, COS_SQUARED);
                    fell_back = fell_back.or(fast);
                }
            }
            pen.course.fell_back = fell_back.bits();
        }
    }

    /// A bit for each body of a pen whose corrections keep its angular momentum, or have to.
    pub(super) fn keeps_spin(&self, pen: &Pen) -> u32 {
        if self.settings.keep_spin { u32::MAX } else { self.along_start(pen) }
    }

    /// A bit for each body of a pen that is corrected along the start of the substep.
    fn along_start(&self, pen: &Pen) -> u32 {
        if self.settings.direction == Direction::StepStart { !pen.course.fell_back } else { 0 }
    }

    /// Sweeps until no more bodies than `few` go on.
    #[inline(always)]
    pub(super) fn sweep<L: Lanes>(&self, pen: &mut Pen, few: u32) {
        let Self { flocks, flock, settings, planes, h } = *self;
        let (none, one) = (L::zero(), L::splat(1.0));
        let all = none.same(none);
        let pace = Pace { h, sweeps: settings.max_sweeps };
        let most = L::splat(settings.max_sweeps as f32);
        let tolerance = L::splat(settings.tolerance);
        let from_start = L::mask(self.along_start(pen));
        let any_from_start = from_start.any();
        let (mut going, mut converged) = (L::mask(pen.course.going), L::mask(pen.course.converged));
        let mut touched = L::mask(pen.course.touched);
        let (mut sweeps, mut kept) = (L::load(&pen.course.sweeps), none);
        let mut over = none;
        while (going.bits() & pen.mask()).count_ones() > few {
            if over.any() {
                pen.keep(over);
                kept = kept.or(over);
            }
            let (mut worst, aside) = (none, going.select(none, all));
            for part in &flocks.parts[flock.parts.clone()] {
                worst = match part {
                    Part::Rods(range) => {
                        let rods = &flocks.rods[range.clone()];
                        let spots = (&mut pen.now[..], &pen.start[..]);
                        let masks = (from_start, aside);
                        if any_from_start {
                            rods::sweep::<L, true>(rods, spots, masks, worst)
                        } else {
                            rods::sweep::<L, false>(rods, spots, masks, worst)
                        }
                    }
                    Part::Laws(part) => flocks.alike.sweep::<L>(part, pen, pace, (aside, worst)),
                };
            }
            if !planes.is_empty() {
                let depth = touch::touch::<L>(planes, pen, going);
                touched = touched.or(going.and(none.lt(depth)));
                worst = depth.max(worst);
            }
            let good = going.and(worst.le(tolerance));
            sweeps = going.select(sweeps + one, sweeps);
            over = good.or(going.and(most.le(sweeps)));
            (converged, going) = (converged.or(good), over.select(none, going));
        }
        if kept.any() {
            pen.put_back(kept);
        }
        let course = &mut pen.course;
        (course.going, course.converged) = (going.bits(), converged.bits());
        course.touched = touched.bits();
        sweeps.store(&mut pen.course.sweeps);
    }
}
