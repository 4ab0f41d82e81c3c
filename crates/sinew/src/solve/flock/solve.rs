//! Eight bodies, swept until each holds or its sweeps are spent: as [`solve`](crate::solve::island) does with one.

use super::touch::Touch;
use super::{Course, Flock, Flocks, Part, Pen, rods};
use crate::constraints::{Direction, Pace, Plane};
use crate::lanes::{InstructionSet, LANES, with};
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
    pub(super) instructions: InstructionSet,
}

impl How<'_> {
    /// Begins a substep: none has been swept.
    pub(super) fn begin(&self, pen: &mut Pen) {
        pen.course = Course::default();
        pen.sums.fill([0.0; _]);
        if self.settings.direction == Direction::StepStart {
            let mut fell_back = 0;
            for part in &self.flocks.parts[self.flock.parts.clone()] {
                if let Part::Rods(range) = part {
                    let rods = &self.flocks.rods[range.clone()];
                    let (now, start, cos_squared) = (&pen.now[..], &pen.start[..], COS_SQUARED);
                    let work = rods::TurnTooFast { rods, now, start, cos_squared };
                    fell_back |= with(self.instructions, work);
                }
            }
            pen.course.fell_back = fell_back;
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
    pub(super) fn sweep(&self, pen: &mut Pen, few: u32) {
        let Self { settings, planes, .. } = *self;
        let most = settings.max_sweeps as f32;
        let (mut kept, mut over) = (0, 0);
        while (pen.course.going & pen.mask()).count_ones() > few {
            if over != 0 {
                pen.keep(over);
                kept |= over;
            }
            let mut worst = self.once(pen);
            let going = pen.course.going;
            if !planes.is_empty() {
                let depth = with(self.instructions, Touch { planes, pen, going });
                pen.course.touched |= going & bits(depth, |depth| 0.0 < depth);
                for (worst, depth) in worst.iter_mut().zip(depth) {
                    *worst = if *worst < depth { depth } else { *worst };
                }
            }
            let course = &mut pen.course;
            let good = going & bits(worst, |worst| worst <= settings.tolerance);
            for (lane, sweeps) in course.sweeps.iter_mut().enumerate() {
                *sweeps += (going >> lane & 1) as f32;
            }
            over = good | going & bits(course.sweeps, |sweeps| most <= sweeps);
            course.converged |= good;
            course.going &= !over;
        }
        if kept != 0 {
            pen.put_back(kept);
        }
    }

    /// Projects all constraints once; returns the largest error found in each body, metres.
    fn once(&self, pen: &mut Pen) -> [f32; LANES] {
        let Self { flocks, flock, settings, h, instructions, .. } = *self;
        let pace = Pace { h, sweeps: settings.max_sweeps };
        let (may, aside) = (self.along_start(pen), !pen.course.going);
        let mut worst = [0.0; LANES];
        for part in &flocks.parts[flock.parts.clone()] {
            worst = match part {
                Part::Rods(range) => {
                    let rods = &flocks.rods[range.clone()];
                    let (now, start) = (&mut pen.now[..], &pen.start[..]);
                    if may == 0 {
                        let work = rods::Sweep::<false> { rods, now, start, may, aside, worst };
                        with(instructions, work)
                    } else {
                        let work = rods::Sweep::<true> { rods, now, start, may, aside, worst };
                        with(instructions, work)
                    }
                }
                Part::Laws(part) => {
                    flocks.alike.sweep(part, pen, pace, (aside, worst), instructions)
                }
            };
        }
        worst
    }
}

/// A bit for each number of which something holds.
fn bits(numbers: [f32; LANES], holds: impl Fn(f32) -> bool) -> u32 {
    numbers.iter().enumerate().fold(0, |bits, (lane, &x)| bits | u32::from(holds(x)) << lane)
}
