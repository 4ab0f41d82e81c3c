//! Particle contacts: single particles against planes, boxes and colliders.
//!
//! Each particle is a sphere of its radius. In a substep it goes from where it was to where it was predicted and its constraints moved it; seen from
//! a collider, which may itself move, that is a way from one point to another ([`Shape::touch`]). Where it overlaps at the end of the way, or passed
//! through, it is put just outside, on the side that it came from, and the friction that goes with it takes its share of the sliding. Nothing gets
//! through, however fast and however thin the shape is.
//!
//! Which particles may come near which collider is found once a step (`broad_phase`), with a margin of what the fastest of an island may cover. What
//! has gone further all the same, flung by something, is tried against every collider.

mod batches;
mod broad_phase;
mod inside;
mod normal_impulse;
mod reach;
mod restitution;
mod surface;

use glam::{Vec3, Vec4};

use super::body_classes::BodyClasses;
use super::bounds::{Bounds, ClassBounds};
use super::frame::Frame;
use super::friction::friction;
use super::material::CombinedMaterial;
use super::recovery::{recovered, recovered_way};
use super::shape::ShapeTouch;
use super::world::World;
use crate::constraints::{PlanarDrag, Plane};
use crate::particles::{Particles, Places};

pub(crate) use normal_impulse::{NormalImpulse, NormalImpulses};

use batches::CandidateBatches;
use inside::InsideRow;
use surface::{ContactSurface, SurfaceForm};

/// Everything that single particles touch, for one step. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct ParticleContacts {
    classes: BodyClasses,
    bounds: Bounds,
    surfaces: Vec<ContactSurface>,
    /// What becomes of the materials of each surface and each class of bodies, surface by surface; `None` where the one is no surface to the other.
    materials: Vec<Option<CombinedMaterial>>,
    /// Where each surface is when each substep begins, at so many instants in it, and when the last one ends: all surfaces of one instant one after the
    /// other.
    frames: Vec<Frame>,
    /// Instants in a substep: the most microsteps that any island takes.
    instants: u32,
    /// The first candidate of each row, and their number; empty where there are no surfaces.
    first: Vec<u32>,
    candidates: Vec<SurfaceCandidate>,
    /// Where each row was when it was looked for, from its origin, and the square of how far it may go from there, m².
    last_seen: Vec<Vec4>,
    /// Whether a row does not collide by itself: it belongs to a solid, which does in its place, or its body touches nothing. May be shorter than the
    /// rows.
    solid: Vec<bool>,
    /// Whether contacts of each body are to be reported; empty if none's are.
    reported: Vec<bool>,
    /// Where the rows of each island that may touch anything are in the list of those, which is island by island.
    reaches: Vec<core::ops::Range<usize>>,
    touching: Vec<u32>,
    /// Whether each row may come to a plane or a box that holds every particle; true of all in a world in 2D.
    bounded: Vec<bool>,
    batches: CandidateBatches,
    /// How much of an overlap is recovered in a substep, and how much of one may turn into speed, metres.
    recover: f32,
    max_depenetration: f32,
    /// Rows that were inside of something when the step began.
    inside: Vec<InsideRow>,
    sort: broad_phase::CandidateSort,
}

/// From which of the instants of a step to which others surfaces move meanwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InstantInterval {
    begin: u32,
    end: u32,
}

/// What bodies in lanes may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BatchContacts<'a> {
    /// All of them, side by side.
    pub(crate) planes: &'a [Plane],
    /// Whether there are surfaces besides, which each row touches by itself.
    pub(crate) surfaces: bool,
}

/// A surface that a row may touch in this step.
#[derive(Clone, Copy, Debug, Default)]
struct SurfaceCandidate {
    surface: u32,
    friction: f32,
    restitution: f32,
    drag: PlanarDrag,
}

impl ParticleContacts {
    /// Begins a step: takes what is valid, and finds what each row may touch, but for those that do not collide by themselves. Keeps its memory.
    pub(crate) fn begin(
        &mut self,
        particles: &Particles,
        world: &World,
        solid: &[bool],
        normal_impulses: &mut Vec<NormalImpulse>,
    ) {
        self.classes.update(world.filter, particles);
        let reported = || world.filter.bodies().iter().map(|body| body.events);
        self.reported.clear();
        if reported().any(|events| events) {
            self.reported.extend(reported());
        }
        let Self { classes, bounds, surfaces, materials, .. } = self;
        surface::list(world, classes, bounds, surfaces, materials);
        let microsteps = world.islands.list.iter().map(|island| island.microsteps).max();
        self.instants = microsteps.unwrap_or(1).max(1);
        self.frames.clear();
        let instants = world.substeps * self.instants;
        for instant in 0..=instants {
            let share = instant as f32 / instants as f32;
            self.frames.extend(self.surfaces.iter().map(|surface| surface.frame_at(share)));
        }
        self.solid.clear();
        self.solid.extend_from_slice(solid);
        self.broad_phase(particles, world, normal_impulses);
    }

    /// From when to when a microstep of a substep goes, of which there are so many.
    pub(crate) fn interval(&self, substep: u32, microstep: u32, of: u32) -> InstantInterval {
        let (begin, each) = (substep * self.instants, self.instants / of);
        InstantInterval { begin: begin + microstep * each, end: begin + (microstep + 1) * each }
    }

    /// How much of an overlap is recovered meanwhile, metres: at one speed, however a substep is divided.
    fn recover_in(&self, interval: InstantInterval) -> f32 {
        self.recover * ((interval.end - interval.begin) as f32 / self.instants as f32)
    }

    /// Whether there is nothing to touch.
    pub(crate) fn is_empty(&self) -> bool {
        self.bounds.is_empty() && self.surfaces.is_empty()
    }

    /// Whether all particles are held in a plane: the world is in 2D.
    pub(crate) fn holds_in_plane(&self) -> bool {
        self.bounds.has_plane_constraint()
    }

    /// What these rows may touch by themselves, if bodies in lanes can be put out of it. Those of solids touch nothing.
    pub(crate) fn of_batch(&self, rows: core::ops::Range<u32>) -> Option<BatchContacts<'_>> {
        // What is beyond the list is not of a solid.
        let listed = &self.solid[(rows.start as usize).min(self.solid.len())..];
        let listed = &listed[..rows.len().min(listed.len())];
        let solid = listed.iter().filter(|&&solid| solid).count();
        if solid == 0 {
            let class = self.classes.of_all(rows)?;
            let surface = |number: usize| self.material(number, class).is_some();
            let surfaces = (0..self.surfaces.len()).any(surface);
            let planes = self.bounds.planes_alone(class)?;
            return Some(BatchContacts { planes, surfaces });
        }
        let nowhere = solid == rows.len() && !self.bounds.has_plane_constraint();
        nowhere.then_some(BatchContacts { planes: &[], surfaces: false })
    }

    /// What becomes of the materials of a surface and of a class of bodies; `None` where it is no surface to those.
    #[inline]
    fn material(&self, surface: usize, class: usize) -> Option<&CombinedMaterial> {
        self.materials.get(surface * self.classes.all().len() + class)?.as_ref()
    }

    /// Slows down what touches a plane with a drag, before a substep of `h` seconds is predicted.
    pub(crate) fn drag(&self, particles: &mut Particles, h: f32) {
        self.bounds.drag(particles, &self.solid, h);
    }

    /// Puts a row on the right side of everything, once, with friction; returns how far out it was, metres. One without
    /// `bounds` is far from all planes and boxes that hold it.
    #[inline]
    fn project(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        (row, bounds): (u32, Option<&ClassBounds>),
        interval: InstantInterval,
    ) -> f32 {
        let mut worst = 0.0_f32;
        if let Some(bounds) = bounds {
            worst = self.project_to_bounds(places, row, bounds, interval);
        }
        worst = worst.max(self.project_row(places, normal_impulses, row, interval));
        worst.max(self.project_into_plane(places, row))
    }

    /// Puts a row on the right side of the planes and boxes that hold it; returns how far out it was, metres.
    #[inline]
    fn project_to_bounds(
        &self,
        places: &mut Places,
        row: u32,
        bounds: &ClassBounds,
        interval: InstantInterval,
    ) -> f32 {
        if self.is_solid(row) || places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        bounds.project(places, row, self.recover_in(interval))
    }

    /// Puts a row into the plane of a world in 2D; returns how far off it was, metres.
    #[inline]
    fn project_into_plane(&self, places: &mut Places, row: u32) -> f32 {
        if places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        self.bounds.project_to_plane(places, row)
    }

    /// As [`Bounds::flatten`] has it.
    pub(super) fn flatten(&self, particles: &mut Particles, moving: bool) {
        self.bounds.flatten(particles, moving);
    }

    /// How far out a row is at the end of a step, metres, moving nothing.
    #[inline]
    fn error(&self, places: &Places, row: u32, bounds: Option<&ClassBounds>) -> f32 {
        if self.is_solid(row) || places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        self.deepest(places, row, bounds)
    }

    fn deepest(&self, places: &Places, row: u32, bounds: Option<&ClassBounds>) -> f32 {
        let Some(last) = self.frames.len().checked_sub(self.surfaces.len()) else { return 0.0 };
        let mut worst = bounds.map_or(0.0, |bounds| {
            bounds.error(places, row).max(self.bounds.out_of_plane(places, row))
        });
        for candidate in self.of(row).map(|i| &self.candidates[i as usize]) {
            let number = candidate.surface as usize;
            let (surface, frame) = (&self.surfaces[number], &self.frames[last + number]);
            if !surface.sensor {
                let overlap = surface.overlap(places, row, frame);
                worst = overlap.map_or(worst, |overlap| worst.max(overlap.depth));
            }
        }
        worst
    }

    /// The presses of the rows before one, and the others.
    pub(crate) fn split<'a>(
        &self,
        normal_impulses: NormalImpulses<'a>,
        row: u32,
    ) -> (NormalImpulses<'a>, NormalImpulses<'a>) {
        let number = self.first.get(row as usize).map_or(0, |&first| first);
        normal_impulses.split_at(number)
    }

    /// Numbers of the candidates of a row.
    #[inline]
    fn of(&self, row: u32) -> core::ops::Range<u32> {
        let row = row as usize;
        if row + 1 < self.first.len() { self.first[row]..self.first[row + 1] } else { 0..0 }
    }

    #[inline]
    fn is_solid(&self, row: u32) -> bool {
        self.solid.get(row as usize).is_some_and(|&solid| solid)
    }

    /// Puts a row outside of the surfaces near it; returns how far out it was, metres.
    #[inline]
    pub(super) fn project_to_surfaces(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        row: u32,
        interval: InstantInterval,
    ) -> f32 {
        let mut worst = 0.0_f32;
        if self.first.is_empty() {
            return worst;
        }
        if self.exceeds_skin(places, row) {
            return self.project_to_all_surfaces(places, row, interval);
        }
        for number in self.of(row) {
            worst =
                worst.max(self.project_candidate(places, normal_impulses, (row, number), interval));
        }
        worst
    }

    /// Puts a row outside of the surface of one of its candidates; returns how far out it was, metres.
    #[inline(never)]
    fn project_candidate(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        (row, number): (u32, u32),
        interval: InstantInterval,
    ) -> f32 {
        let surface = self.candidates[number as usize].surface as usize;
        let Some(contact) = self.contact(places, row, surface, interval) else { return 0.0 };
        self.take_contact(places, normal_impulses, (row, number), &contact)
    }

    /// Notes a contact of a candidate and resolves it; returns how far out the row was, metres.
    #[inline]
    fn take_contact(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        (row, number): (u32, u32),
        contact: &ParticleContact,
    ) -> f32 {
        normal_impulses.at(number).take(places, row, contact);
        let candidate = &self.candidates[number as usize];
        if self.surfaces[candidate.surface as usize].sensor {
            return 0.0;
        }
        contact.resolve(places, row, candidate.friction);
        contact.depth
    }

    /// The same of any surface, for what was flung further than was foreseen.
    #[cold]
    fn project_to_all_surfaces(
        &self,
        places: &mut Places,
        row: u32,
        interval: InstantInterval,
    ) -> f32 {
        let mut worst = 0.0_f32;
        for (number, surface) in self.surfaces.iter().enumerate() {
            let material = self.material(number, self.classes.of(row));
            let Some(material) = material.filter(|_| !surface.sensor) else { continue };
            if let Some(contact) = self.contact(places, row, number, interval) {
                worst = worst.max(contact.depth);
                contact.resolve(places, row, material.friction);
            }
        }
        worst
    }

    /// How a row touches a surface in a substep, if it does.
    #[inline]
    fn contact(
        &self,
        places: &Places,
        row: u32,
        number: usize,
        interval: InstantInterval,
    ) -> Option<ParticleContact> {
        let i = places.at(row);
        let (start, q, origin) = (places.start[i], places.position[i], places.origin[i]);
        let radius = places.radius[i];
        let surface = &self.surfaces[number];
        match &surface.form {
            SurfaceForm::Plane(plane) => {
                self.along(plane.correction(places, row), (start, q), interval)
            }
            SurfaceForm::BoundingBox(room) => {
                self.along(room.correction(places, row), (start, q), interval)
            }
            SurfaceForm::Shape(shape) => {
                let (was, is) = self.frames_of(number, interval, origin);
                let (from, to) = (was.local(start.truncate()), is.local(q.truncate()));
                let mut touched = shape.touch(from, to, radius)?;
                if !surface.sensor {
                    let way = (from, to, radius);
                    touched = recovered(touched, shape, way, self.recover_in(interval))?;
                }
                Some(ParticleContact::of(&touched, to, &[was, is], surface.moves))
            }
        }
    }

    /// Of a correction of a row that went from one place to another.
    fn along(
        &self,
        correction: Vec3,
        (start, q): (Vec4, Vec4),
        interval: InstantInterval,
    ) -> Option<ParticleContact> {
        let moved = (q - start).truncate();
        ParticleContact::along(recovered_way(correction, moved, self.recover_in(interval)))
    }

    /// Where a surface is when an interval begins and when it ends, seen from an origin of rows, which keeps the digits far out.
    #[inline]
    fn frames_of(&self, number: usize, interval: InstantInterval, origin: Vec3) -> (Frame, Frame) {
        let frame = |instant: u32| &self.frames[instant as usize * self.surfaces.len() + number];
        let seen = |instant: u32| frame(instant).seen_from(origin);
        let is = seen(interval.end);
        // Most stand still, and then there is but one frame, and nothing is carried.
        let was = if self.surfaces[number].moves { seen(interval.begin) } else { is };
        (was, is)
    }
}

/// A particle that is where it may not be.
#[derive(Clone, Copy, Debug)]
struct ParticleContact {
    /// Unit vector to the allowed side.
    normal: Vec3,
    /// How far in it is, metres.
    depth: f32,
    /// How far the surface has gone there since the substep began, metres.
    carried: Vec3,
}

impl ParticleContact {
    /// Of what touched a shape when it was at `to`, in coordinates of its own, while that went from the first frame to the second.
    #[inline]
    fn of(touched: &ShapeTouch, to: Vec3, [was, is]: &[Frame; 2], moves: bool) -> Self {
        let mut carried = Vec3::ZERO;
        if moves {
            let settled = to + touched.normal * touched.depth;
            carried = is.point(settled) - was.point(settled);
        }
        Self { normal: is.turn(touched.normal), depth: touched.depth, carried }
    }

    /// Of a correction of something that stands still.
    fn along(correction: Vec3) -> Option<Self> {
        let depth = correction.length();
        (depth > 0.0).then(|| Self { normal: correction / depth, depth, carried: Vec3::ZERO })
    }

    /// Puts a row outside, with the friction that goes with it.
    #[inline]
    fn resolve(&self, places: &mut Places, row: u32, coefficient: f32) {
        let i = places.at(row);
        let out = self.normal * self.depth;
        let moved = (places.position[i] - places.start[i]).truncate() + out - self.carried;
        let slid = moved - self.normal * moved.dot(self.normal);
        places.displace(row, out + friction(slid, self.depth, coefficient));
    }
}

#[cfg(test)]
mod tests;
