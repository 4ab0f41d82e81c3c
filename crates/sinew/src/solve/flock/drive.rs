//! Driving flocks: through the solving of one substep, or through all substeps of a step.

use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};

use glam::{Vec3, Vec4};

use super::pen::{gather, scatter};
use super::solve::solve;
use super::{Flock, Pen};
use crate::constraints::Plane;
use crate::lanes::{LANES, Lanes, Work};
use crate::particles::ground;
use crate::solve::island::{Common, Room};
use crate::solve::plan::Task;
use crate::solve::{IslandReport, Order};

/// The flocks of a task, to be driven. What cannot be in lanes in this step is left to others, and noted in the room's [`Rest`].
pub(crate) struct Drive<'a> {
    pub(crate) common: Common<'a>,
    pub(crate) task: &'a Task,
    /// Columns from the task's first row on.
    pub(crate) position: &'a mut [Vec4],
    pub(crate) motion: Motion<'a>,
    pub(crate) origin: &'a [Vec3],
    pub(crate) radius: &'a [f32],
    pub(crate) reports: &'a mut [IslandReport],
    pub(crate) room: &'a mut Room,
}

/// How far they are driven.
pub(crate) enum Motion<'a> {
    /// Through the solving of a substep that has been predicted; velocities are not derived, and excesses noted in the room.
    Substep { start: &'a [Vec4], velocity: &'a [Vec4] },
    /// Through all substeps of a step.
    Step(Whole<'a>),
}

/// What there is through the substeps of a step.
pub(crate) struct Whole<'a> {
    pub(crate) start: &'a mut [Vec4],
    pub(crate) velocity: &'a mut [Vec4],
    pub(crate) rounding: &'a mut [Vec4],
    /// 1/s; may have one number for all.
    pub(crate) damping: &'a [f32],
    /// The same, of all besides.
    pub(crate) air: f32,
    /// Acceleration of all, m/s².
    pub(crate) common: Vec3,
    /// The most sweeps in each substep.
    pub(crate) most: &'a [AtomicU32],
}

/// What is left of a task beside the flocks that were driven.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rest {
    pub(crate) islands: Vec<Range<usize>>,
    pub(crate) rows: Vec<Range<u32>>,
}

impl Rest {
    /// All of a task.
    pub(crate) fn reset(&mut self, task: &Task) {
        self.islands.clear();
        self.rows.clear();
        self.islands.push(task.islands.clone());
        self.rows.push(task.rows.clone());
    }

    /// Whether nothing is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.islands.iter().all(Range::is_empty) && self.rows.iter().all(Range::is_empty)
    }

    /// Less a flock, which lies behind all that went before.
    fn leave(&mut self, flock: &Flock) {
        cut(&mut self.islands, flock.islands.clone());
        cut(&mut self.rows, flock.rows());
    }
}

/// Cuts a range out of the last of some ranges.
fn cut<T: Copy>(ranges: &mut Vec<Range<T>>, out: Range<T>) {
    if let Some(last) = ranges.last_mut() {
        let after = out.end..core::mem::replace(&mut last.end, out.start);
        ranges.push(after);
    }
}

impl Work for Drive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let plan = self.common.plan;
        let contacts = self.common.contacts;
        let mut pen = core::mem::take(&mut self.room.pen);
        for flock in &plan.flocks.all[self.task.flocks.clone()] {
            let Some(planes) = contacts.planes_alone(flock.rows()) else { continue };
            if self.is_ready(flock, planes) {
                self.room.rest.leave(flock);
                self.drive::<L>(flock, planes, &mut pen);
            }
        }
        self.room.pen = pen;
    }
}

impl Drive<'_> {
    /// Whether the bodies of a flock can go through this step together.
    fn is_ready(&self, flock: &Flock, planes: &[Plane]) -> bool {
        let islands = &self.common.plan.islands[flock.islands.clone()];
        let settings = &islands[0].settings;
        let apart = || {
            let place = |row: u32| (row - self.task.rows.start) as usize;
            let rows = place(flock.rows().start)..place(flock.rows().end);
            let mut bodies = self.origin[rows].chunks(flock.members as usize);
            bodies.any(|origins| origins.iter().any(|origin| *origin != origins[0]))
        };
        settings.order == Order::Cascade
            && !settings.timed
            && islands.iter().all(|island| island.settings == *settings)
            && !islands.iter().any(|island| island.rigid || island.asleep)
            // A body whose particles have more than one origin has more than one height above a plane.
            && (planes.is_empty() || !apart())
    }

    #[inline(always)]
    fn drive<L: Lanes>(&mut self, flock: &Flock, planes: &[Plane], pen: &mut Pen) {
        let Common { plan, h, .. } = self.common;
        let (flocks, begin) = (&plan.flocks, self.task.rows.start);
        let settings = &plan.islands[flock.islands.start].settings;
        let from = flock.islands.start - self.task.islands.start;
        self.note_heights(flock, planes, pen);
        let (none, all) = (L::zero(), L::zero().same(L::zero()));
        let keeps_all = if settings.keep_spin { all } else { none };
        let mut keeps = none;
        let islands = &plan.islands[flock.islands.clone()];
        // In the lanes that are left, too, the last body is what it is: they write the same as its own.
        let is_free = |lane: usize| islands[lane.min(islands.len() - 1)].free;
        let free = (0..LANES).fold(0, |free, lane| free | u32::from(is_free(lane)) << lane);
        let reports = &mut self.reports[from..from + flock.islands.len()];
        let begun = match &self.motion {
            Motion::Substep { start, .. } => *start,
            Motion::Step(whole) => &*whole.start,
        };
        pen.load::<L>(flock, begin, self.position, begun);
        let mut free = L::mask(free);
        let mut substeps = 1;
        if let Motion::Step(whole) = &self.motion {
            substeps = whole.most.len();
            gather::<L>(&mut pen.velocity, flock, begin, whole.velocity);
            gather::<L>(&mut pen.rounding, flock, begin, whole.rounding);
            note_rates(flock, begin, whole, pen);
        }
        if free.any() {
            pen.note_masses();
        }
        for substep in 0..substeps {
            if let Motion::Step(whole) = &self.motion {
                // The last step may have been of another length, or none, but this one's substeps are alike.
                if substep < 2 {
                    pen.note_losses(h);
                }
                pen.predict::<L>(whole.common, h);
            }
            let solved = solve::<L>(flocks, flock, settings, planes, h, pen);
            let sweeps = solved.report(reports);
            let left = solved.touched.select(none, free);
            keeps = keeps_all.or(solved.from_start);
            if let Motion::Step(whole) = &self.motion {
                whole.most[substep].fetch_max(sweeps, Ordering::Relaxed);
                pen.derive::<L>(h, left, keeps);
            } else {
                free = left;
            }
        }
        scatter::<L>(&pen.now, flock, begin, self.position);
        match &mut self.motion {
            Motion::Substep { velocity, .. } => {
                if !free.any() {
                    return;
                }
                gather::<L>(&mut pen.velocity, flock, begin, velocity);
                let excesses = pen.excesses::<L>(h, free.bits() & keeps.bits());
                // No more of them than there are bodies.
                let bodies = free.bits() & ((1 << islands.len()) - 1);
                let own = excesses.each(bodies);
                let own = own.map(|(lane, one)| ((flock.islands.start + lane) as u32, one));
                self.room.excesses.extend(own);
            }
            Motion::Step(whole) => {
                scatter::<L>(&pen.start, flock, begin, whole.start);
                scatter::<L>(&pen.velocity, flock, begin, whole.velocity);
                scatter::<L>(&pen.rounding, flock, begin, whole.rounding);
            }
        }
    }

    /// Notes radii, and how high the origin of each body is above each plane.
    fn note_heights(&self, flock: &Flock, planes: &[Plane], pen: &mut Pen) {
        pen.ground.clear();
        pen.radius.clear();
        if planes.is_empty() {
            return;
        }
        let places = |i: u32| flock.places(self.task.rows.start, i).map(|place| place as usize);
        let origins = places(0).map(|place| self.origin[place]);
        let heights =
            |plane: &Plane| origins.map(|origin| ground(origin, plane.normal, plane.offset));
        pen.ground.extend(planes.iter().map(heights));
        let radii = |i: u32| places(i).map(|place| self.radius[place]);
        pen.radius.extend((0..flock.members).map(radii));
    }
}

/// Notes at which rates velocities are lost.
fn note_rates(flock: &Flock, begin: u32, whole: &Whole, pen: &mut Pen) {
    let own = |place: u32| match whole.damping {
        [all] => *all,
        each => each.get(place as usize).copied().unwrap_or(0.0),
    };
    let rates = |i: u32| flock.places(begin, i).map(|place| own(place) + (whole.air + 0.0));
    pen.rate.clear();
    pen.rate.extend((0..flock.members).map(rates));
    pen.lost.resize(pen.rate.len(), [0.0; LANES]);
}
