//! Driving flocks: through the solving of one substep, or through all substeps of a step.

use core::sync::atomic::{AtomicU32, Ordering};

use glam::{Vec3, Vec4};

use super::excess::{Derive, Take};
use super::motion::Predict;
use super::pen::{gather, scatter};
use super::{Flock, Herd, How, Pen};
use crate::constraints::Plane;
use crate::lanes::{LANES, with};
use crate::particles::ground;
use crate::solve::island::{Common, Room};
use crate::solve::plan::Task;
use crate::solve::{IslandReport, Order};

/// Particles of the bodies side by side in the pens of a herd, at most: with all that belongs to them they fit into a core's second cache.
const HERD: usize = 512;

/// The flocks of a task, to be driven. What cannot be in lanes in this step is left to others, and noted in the room's
/// [`Rest`](crate::solve::rest::Rest).
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
    /// Through the solving of a substep that has been predicted. Velocities are not derived: what has to be taken off then is noted for each
    /// particle, m/s, or where there is no place for that, for each island in the room.
    Substep { start: &'a [Vec4], velocity: &'a [Vec4], excess: &'a mut [Vec4] },
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

impl<'a> Drive<'a> {
    /// Drives them.
    pub(crate) fn run(mut self) {
        let plan = self.common.plan;
        let flocks = &plan.flocks.all[self.task.flocks.clone()];
        let mut herd = core::mem::take(&mut self.room.herd);
        let (mut begin, mut found) = (0, flocks.first().and_then(|first| self.planes(first)));
        while begin < flocks.len() {
            let (first, planes) = (&flocks[begin], found);
            // Where each has but one sweep nobody waits for anybody.
            let sweeps = plan.islands[first.islands.start].settings.max_sweeps;
            let most = if sweeps > 1 { HERD / first.members as usize } else { 1 };
            let mut end = begin + 1;
            while let Some(flock) = flocks.get(end) {
                found = self.planes(flock);
                if found != planes || end - begin >= most || !self.is_kin(first, flock) {
                    break;
                }
                end += 1;
            }
            if let Some(planes) = planes {
                flocks[begin..end]
                    .iter()
                    .for_each(|flock| self.room.rest.leave(flock.islands.clone(), flock.rows()));
                self.drive(&flocks[begin..end], planes, &mut herd);
            }
            begin = end;
        }
        self.room.herd = herd;
    }

    /// The planes that a flock touches, if its bodies can go through this step together.
    fn planes(&self, flock: &Flock) -> Option<&'a [Plane]> {
        let islands = &self.common.plan.islands[flock.islands.clone()];
        let settings = &islands[0].settings;
        let planes = self.common.contacts.planes_alone(flock.rows())?;
        let apart = || {
            let place = |row: u32| (row - self.task.rows.start) as usize;
            let rows = place(flock.rows().start)..place(flock.rows().end);
            let mut bodies = self.origin[rows].chunks(flock.members as usize);
            bodies.any(|origins| origins.iter().any(|origin| *origin != origins[0]))
        };
        let ready = settings.order == Order::Cascade
            && !settings.timed
            && islands.iter().all(|island| island.settings == *settings)
            && !islands.iter().any(|island| island.rigid || island.asleep)
            // A body whose particles have more than one origin has more than one height above a plane.
            && (planes.is_empty() || !apart());
        ready.then_some(planes)
    }

    /// Whether two flocks are of the same bodies, which are to be solved in the same way.
    fn is_kin(&self, one: &Flock, other: &Flock) -> bool {
        let settings = |flock: &Flock| self.common.plan.islands[flock.islands.start].settings;
        one.is_kin(other) && settings(one) == settings(other)
    }

    fn drive(&mut self, flocks: &[Flock], planes: &[Plane], herd: &mut Herd) {
        let Common { plan, h, machine, .. } = self.common;
        let instructions = machine.instructions;
        let settings = &plan.islands[flocks[0].islands.start].settings;
        let how =
            How { flocks: &plan.flocks, flock: &flocks[0], settings, planes, h, instructions };
        herd.make_room(flocks.len());
        for (flock, pen) in flocks.iter().zip(herd.pens()) {
            self.load(flock, planes, pen);
        }
        let substeps = if let Motion::Step(whole) = &self.motion { whole.most.len() } else { 1 };
        for substep in 0..substeps {
            if let Motion::Step(whole) = &self.motion {
                for pen in herd.pens() {
                    // The last step may have been of another length, or none, but this one's substeps are alike.
                    if substep < 2 {
                        pen.note_losses(h);
                    }
                    with(instructions, Predict { pen, a: whole.common, h });
                }
            }
            herd.solve(&how);
            for (flock, pen) in flocks.iter().zip(herd.pens()) {
                let from = flock.islands.start - self.task.islands.start;
                let reports = &mut self.reports[from..from + flock.islands.len()];
                let sweeps = pen.course.report(reports);
                if let Motion::Step(whole) = &self.motion {
                    whole.most[substep].fetch_max(sweeps, Ordering::Relaxed);
                    let (free, keeps_angular) = (pen.left(), how.keeps_spin(pen));
                    with(instructions, Derive { pen, h, free, keeps_angular });
                }
            }
        }
        for (flock, pen) in flocks.iter().zip(herd.pens()) {
            self.give_back(&how, flock, pen);
        }
    }

    /// Takes a flock into a pen.
    fn load(&self, flock: &Flock, planes: &[Plane], pen: &mut Pen) {
        let (begin, islands) = (self.task.rows.start, &self.common.plan.islands);
        let islands = &islands[flock.islands.clone()];
        self.note_heights(flock, planes, pen);
        // In the lanes that are left, too, the last body is what it is: they write the same as its own.
        let is_free = |lane: usize| islands[lane.min(islands.len() - 1)].free;
        pen.free = (0..LANES).fold(0, |free, lane| free | u32::from(is_free(lane)) << lane);
        let start = match &self.motion {
            Motion::Substep { start, .. } => *start,
            Motion::Step(whole) => &*whole.start,
        };
        let instructions = self.common.machine.instructions;
        pen.load(flock, begin, self.position, start, instructions);
        if let Motion::Step(whole) = &self.motion {
            gather(&mut pen.velocity, flock, begin, whole.velocity, instructions);
            gather(&mut pen.rounding, flock, begin, whole.rounding, instructions);
            note_rates(flock, begin, whole, pen);
        }
        if pen.free != 0 {
            pen.note_masses();
        }
    }

    /// Writes what has become of a flock.
    fn give_back(&mut self, how: &How, flock: &Flock, pen: &mut Pen) {
        let (begin, instructions) = (self.task.rows.start, how.instructions);
        scatter(&pen.now, flock, begin, self.position, instructions);
        match &mut self.motion {
            Motion::Substep { velocity, excess, .. } => {
                let left = pen.left();
                if left == 0 {
                    return;
                }
                gather(&mut pen.velocity, flock, begin, velocity, instructions);
                let (turning, parted) = (left & how.keeps_spin(pen), !excess.is_empty());
                let excesses = with(instructions, Take { pen, h: how.h, turning, left, parted });
                if parted {
                    scatter(&pen.velocity, flock, begin, excess, instructions);
                    return;
                }
                // No more of them than there are bodies.
                let own = excesses.each(left & pen.mask());
                let own = own.map(|(lane, one)| ((flock.islands.start + lane) as u32, one));
                self.room.excesses.extend(own);
            }
            Motion::Step(whole) => {
                scatter(&pen.start, flock, begin, whole.start, instructions);
                scatter(&pen.velocity, flock, begin, whole.velocity, instructions);
                scatter(&pen.rounding, flock, begin, whole.rounding, instructions);
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
