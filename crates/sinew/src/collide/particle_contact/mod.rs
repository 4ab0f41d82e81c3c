//! Particle contacts: single particles against planes, boxes and colliders.
//!
//! Each particle is a sphere of its radius. In a substep it moves from its start position to the one that was predicted and corrected by constraints. In the
//! frame of a collider, which may itself move, that is a segment from one point to another ([`Shape::touch`](crate::collide::Shape::touch)). Where the particle
//! overlaps at the end of the segment, or passed through the shape, it is placed just outside, on the side that it came from, and friction reduces its slip.
//! Nothing gets through, however fast the particle and however thin the shape.
//!
//! The broad phase runs once a step (`broad_phase`), with a margin for the distance that the fastest particle of an island may cover. A particle that
//! nevertheless moves further, flung by something, is tested against every collider (`late`).

mod batches;
mod broad_phase;
mod features;
mod inside;
mod late;
mod normal_impulse;
mod reach;
mod restitution;
mod surface;

use glam::{Vec3, Vec4};

use super::body_classes::BodyClasses;
use super::bounds::{Bounds, ClassBounds, Spheres};
use super::features::Features;
use super::filter::ContactFilter;
use super::frame::Frame;
use super::friction::friction;
use super::material::CombinedMaterial;
use super::recovery::{limit_correction, limit_depth};
use super::shape::{LocalFace, ShapeTouch};
use super::world::World;
use crate::constraints::{PlanarDrag, Plane};
use crate::forces::RowGravity;
use crate::lanes::{Number, Vector};
use crate::not_cloned::NotCloned;
use crate::particles::{Particles, Places};

pub(crate) use normal_impulse::{NormalImpulse, NormalImpulses};

use batches::CandidateBatches;
use features::FeatureCandidates;
use inside::InsideRow;
use late::LateContacts;
use surface::{ContactSurface, SurfaceForm};

/// Everything that single particles collide with in one step. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct ParticleContacts {
    classes: BodyClasses,
    bounds: Bounds,
    surfaces: Vec<ContactSurface>,
    /// Combined material of each surface and each body class, surface by surface; `None` where the class does not collide with the surface, or collides with it
    /// as a plain bound.
    materials: Vec<Option<CombinedMaterial>>,
    /// Pose of each surface at the start of each substep, at `instants` instants in it, and at the end of the last one: all surfaces of one instant in
    /// sequence.
    frames: Vec<Frame>,
    /// Instants per substep: the greatest number of microsteps of any island.
    instants: u32,
    /// Index of the first candidate of each row, followed by the number of candidates; empty where there are no surfaces.
    first: Vec<u32>,
    candidates: Vec<SurfaceCandidate>,
    /// The faces that candidates refer to.
    faces: Vec<LocalFace>,
    /// Rows and numbers of the candidates with a restitution, sensors apart.
    elastic: Vec<[u32; 2]>,
    late: NotCloned<LateContacts>,
    gravity: RowGravity,
    /// Surfaces with the rows whose bodies ignore them; sorted.
    ignored: Vec<[u32; 2]>,
    /// `[x y z d²]`: position of each row when the broad phase ran, from its origin, and the square of the distance that it may move from there, m².
    reference: Vec<Vec4>,
    /// Whether a row does not collide as a particle: it belongs to a body collider, which collides in its place, or contacts of its body are disabled. May be
    /// shorter than the rows.
    pub(super) excluded: Vec<bool>,
    /// Whether contacts of each body are to be reported; empty if those of none are.
    reported: Vec<bool>,
    /// For each island the range in `touching` of its rows that may touch anything.
    reaches: Vec<core::ops::Range<usize>>,
    touching: Vec<u32>,
    /// Whether each row may touch a plane or a box that is a plain bound; true for all rows of a 2D world.
    bounded: Vec<bool>,
    batches: CandidateBatches,
    features: FeatureCandidates,
    /// Maximum depenetration in a substep, and the overlap at the start of a step above which what is recovered must not become velocity, metres.
    recover: f32,
    max_depenetration: f32,
    /// Rows that overlapped something at the start of the step.
    inside: Vec<InsideRow>,
    sort: broad_phase::CandidateSort,
}

/// The instants of a step between which surfaces move in a microstep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InstantInterval {
    begin: u32,
    end: u32,
}

/// What the bodies of an instance batch may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BatchContacts<'a> {
    /// Planes, solved in lanes.
    pub(crate) planes: &'a [Plane],
    /// Whether there are other surfaces as well, which are solved row by row.
    pub(crate) surfaces: bool,
}

/// A surface that a row may touch in this step, with the combined material of the two.
#[derive(Clone, Copy, Debug, Default)]
struct SurfaceCandidate {
    surface: u32,
    friction: f32,
    restitution: f32,
    drag: PlanarDrag,
    /// Magnitude of the gravity on the row, m/s².
    gravity: f32,
    /// Number of the only face of the surface that the row may meet, or [`NO_FACE`].
    face: u32,
}

/// Stands for a candidate that may meet any part of its surface.
const NO_FACE: u32 = u32::MAX;

impl SurfaceCandidate {
    /// Gravity in m/s².
    fn new(surface: usize, material: CombinedMaterial, gravity: f32) -> Self {
        let CombinedMaterial { friction, restitution, drag } = material;
        let face = NO_FACE;
        Self { surface: surface as u32, friction, restitution, drag, gravity, face }
    }
}

impl ParticleContacts {
    /// Begins a step: takes the valid surfaces and finds the candidates of each row, except rows that do not collide as particles: those of body colliders, marked
    /// in `solid`, and those of bodies whose contacts are disabled.
    pub(super) fn begin(
        &mut self,
        particles: &Particles,
        world: &World,
        (solid, features): (&[bool], &Features),
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
        self.mark_excluded(particles, world.filter, solid);
        self.gravity.clone_from(world.row_gravity);
        self.broad_phase(particles, world, features, normal_impulses);
    }

    /// Marks the rows that do not collide as particles.
    fn mark_excluded(&mut self, particles: &Particles, filter: &ContactFilter, solid: &[bool]) {
        let Self { excluded, .. } = self;
        excluded.clear();
        excluded.extend_from_slice(solid);
        if filter.bodies().iter().any(|body| body.disabled) {
            excluded.resize(particles.len(), false);
            let disabled = particles.body.iter().map(|&body| filter.body(body).disabled);
            excluded
                .iter_mut()
                .zip(disabled)
                .for_each(|(excluded, disabled)| *excluded |= disabled);
        }
    }

    /// The instants of microstep `microstep` of `of` in a substep.
    pub(crate) fn interval(&self, substep: u32, microstep: u32, of: u32) -> InstantInterval {
        let (begin, each) = (substep * self.instants, self.instants / of);
        InstantInterval { begin: begin + microstep * each, end: begin + (microstep + 1) * each }
    }

    /// Maximum depenetration in an interval, metres: the same speed however a substep is divided.
    fn recover_in(&self, interval: InstantInterval) -> f32 {
        self.recover * ((interval.end - interval.begin) as f32 / self.instants as f32)
    }

    /// Whether there is nothing to collide with.
    pub(crate) fn is_empty(&self) -> bool {
        self.bounds.is_empty() && self.surfaces.is_empty()
    }

    /// Whether the world is 2D: a plane constraint holds all particles.
    pub(crate) fn holds_in_plane(&self) -> bool {
        self.bounds.has_plane_constraint()
    }

    /// What these rows and islands may touch as particles, if the batch solve supports it; `None` otherwise. Rows of body colliders touch nothing.
    pub(crate) fn of_batch(
        &self,
        rows: core::ops::Range<u32>,
        mut islands: core::ops::Range<usize>,
    ) -> Option<BatchContacts<'_>> {
        if islands.any(|island| self.features.has(island)) {
            return None;
        }
        // Rows beyond the end of the list belong to no body collider.
        let listed = &self.excluded[(rows.start as usize).min(self.excluded.len())..];
        let listed = &listed[..rows.len().min(listed.len())];
        let excluded = listed.iter().filter(|&&excluded| excluded).count();
        if excluded == 0 {
            let class = self.classes.of_all(rows)?;
            let surface = |number: usize| self.material(number, class).is_some();
            let surfaces = (0..self.surfaces.len()).any(surface);
            let planes = self.bounds.only_planes(class)?;
            return Some(BatchContacts { planes, surfaces });
        }
        let nowhere = excluded == rows.len() && !self.bounds.has_plane_constraint();
        nowhere.then_some(BatchContacts { planes: &[], surfaces: false })
    }

    /// Combined material of a surface and a body class; `None` where the surface does not apply to the class.
    #[inline]
    fn material(&self, surface: usize, class: usize) -> Option<&CombinedMaterial> {
        self.materials.get(surface * self.classes.all().len() + class)?.as_ref()
    }

    /// Applies the drag of planes to the rows that touch them, before a substep of `h` seconds is predicted.
    pub(crate) fn drag(&self, particles: &mut Particles, h: f32) {
        self.bounds.drag(particles, &self.excluded, h);
    }

    /// Projects a row out of everything once, with friction; returns the greatest depth, metres. `bounds` is `None` for a row that is far from all plain
    /// bounds.
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

    /// Projects a row out of its plain bounds; returns the greatest depth, metres.
    #[inline]
    fn project_to_bounds(
        &self,
        places: &mut Places,
        row: u32,
        bounds: &ClassBounds,
        interval: InstantInterval,
    ) -> f32 {
        if self.is_excluded(row) || places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        let mut sphere = Spheres::of(places, row);
        let depth = bounds.project(&mut sphere, self.recover_in(interval));
        if depth > 0.0 {
            let here = &mut places.position[places.at(row)];
            *here = Vec3::from(sphere.position).extend(here.w);
        }
        depth
    }

    /// Projects a row into the plane of a 2D world; returns its distance from it, metres.
    #[inline]
    fn project_into_plane(&self, places: &mut Places, row: u32) -> f32 {
        if places.position[places.at(row)].w == 0.0 {
            return 0.0;
        }
        self.bounds.project_to_plane(places, row)
    }

    /// See [`Bounds::flatten`].
    pub(super) fn flatten(&self, particles: &mut Particles, moving: bool) {
        self.bounds.flatten(particles, moving);
    }

    /// Depth of a row at the end of a step, metres. Moves nothing.
    #[inline]
    fn error(&self, places: &Places, row: u32, bounds: Option<&ClassBounds>) -> f32 {
        if self.is_excluded(row) || places.position[places.at(row)].w == 0.0 {
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
                let overlap = surface.overlap(places, row, frame, self.face_of(candidate));
                worst = overlap.map_or(worst, |overlap| worst.max(overlap.depth));
            }
        }
        worst
    }

    /// Splits the impulses into those of the rows before `row` and the others.
    pub(crate) fn split<'a>(
        &self,
        normal_impulses: NormalImpulses<'a>,
        row: u32,
    ) -> (NormalImpulses<'a>, NormalImpulses<'a>) {
        let number = self.first.get(row as usize).map_or(0, |&first| first);
        normal_impulses.split_at(number)
    }

    /// Indices of the candidates of a row.
    #[inline]
    fn of(&self, row: u32) -> core::ops::Range<u32> {
        let row = row as usize;
        if row + 1 < self.first.len() { self.first[row]..self.first[row + 1] } else { 0..0 }
    }

    /// Whether a row does not collide as a particle.
    #[inline]
    pub(super) fn is_excluded(&self, row: u32) -> bool {
        self.excluded.get(row as usize) == Some(&true)
    }

    /// Projects a row out of the surfaces near it; returns the greatest depth, metres.
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

    /// Projects a row out of the surface of one of its candidates; returns its depth, metres.
    #[inline(never)]
    fn project_candidate(
        &self,
        places: &mut Places,
        normal_impulses: &mut NormalImpulses,
        (row, number): (u32, u32),
        interval: InstantInterval,
    ) -> f32 {
        let candidate = &self.candidates[number as usize];
        let surface = (candidate.surface as usize, self.face_of(candidate));
        let Some(contact) = self.contact(places, row, surface, interval) else { return 0.0 };
        self.resolve(places, normal_impulses.at(number), (row, candidate), &contact)
    }

    /// Records a contact and resolves it; returns the depth, metres.
    #[inline(always)]
    fn resolve(
        &self,
        places: &mut Places,
        impulse: &mut NormalImpulse,
        (row, candidate): (u32, &SurfaceCandidate),
        contact: &ParticleContact,
    ) -> f32 {
        impulse.record(places, row, contact);
        if self.surfaces[candidate.surface as usize].sensor {
            return 0.0;
        }
        contact.resolve(places, row, candidate.friction);
        contact.depth
    }

    /// Whether the body of a row ignores a surface.
    fn ignores(&self, row: u32, surface: usize) -> bool {
        !self.ignored.is_empty() && self.ignored.binary_search(&[surface as u32, row]).is_ok()
    }

    /// The only face that a candidate's row may meet, if there is one.
    #[inline]
    fn face_of(&self, candidate: &SurfaceCandidate) -> Option<&LocalFace> {
        self.faces.get(candidate.face as usize)
    }

    /// The contact of a row with a surface in a substep, if they touch. `face` is the only face that the row may meet, if it stays near where the step began.
    #[inline]
    fn contact(
        &self,
        places: &Places,
        row: u32,
        (number, face): (usize, Option<&LocalFace>),
        interval: InstantInterval,
    ) -> Option<ParticleContact> {
        let i = places.at(row);
        let (start, q, origin) = (places.start[i], places.position[i], places.origin[i]);
        let radius = places.radius[i];
        let surface = &self.surfaces[number];
        match &surface.form {
            SurfaceForm::Plane(plane) => {
                let sphere = Spheres::of(places, row);
                self.along(sphere.plane_correction(plane), &sphere, interval)
            }
            SurfaceForm::BoundingBox(room) => {
                let sphere = Spheres::of(places, row);
                self.along(sphere.box_correction(room), &sphere, interval)
            }
            SurfaceForm::Shape(shape) => {
                let (was, is) = self.frames_of(number, interval, origin);
                let (from, to) = (was.local(start.truncate()), is.local(q.truncate()));
                let mut touched = shape.touch_at(face, (from, to, radius))?;
                if !surface.sensor {
                    let way = (from, to, radius);
                    touched = limit_depth(touched, shape, way, self.recover_in(interval))?;
                }
                Some(ParticleContact::of(&touched, to, [&was, &is], surface.moves))
            }
        }
    }

    /// The contact for a correction of a sphere.
    fn along(
        &self,
        correction: Vector<f32>,
        sphere: &Spheres<f32>,
        interval: InstantInterval,
    ) -> Option<ParticleContact> {
        let moved = sphere.position - sphere.start;
        let limited = limit_correction(correction, moved, self.recover_in(interval));
        ParticleContact::along(limited.into())
    }

    /// Poses of a surface at the start and end of an interval relative to an origin of rows, which keeps precision far from the world origin.
    #[inline]
    fn frames_of(&self, number: usize, interval: InstantInterval, origin: Vec3) -> (Frame, Frame) {
        let frame = |instant: u32| &self.frames[instant as usize * self.surfaces.len() + number];
        let relative = |instant: u32| frame(instant).seen_from(origin);
        let is = relative(interval.end);
        // Most surfaces are static: then there is only one pose, and nothing is carried along.
        let was = if self.surfaces[number].moves { relative(interval.begin) } else { is };
        (was, is)
    }
}

/// A contact of a particle with a surface, or of eight.
#[derive(Clone, Copy, Debug)]
struct ContactOf<N> {
    /// Unit vector to the allowed side.
    normal: Vector<N>,
    /// Penetration depth, metres.
    depth: N,
    /// Displacement of the surface at the contact since the start of the substep, metres.
    carried: Vector<N>,
}

type ParticleContact = ContactOf<f32>;

impl ParticleContact {
    /// The contact of a particle at `to`, in the frame of the shape, which moved from the first pose to the second.
    #[inline(always)]
    fn of(touched: &ShapeTouch, to: Vec3, [was, is]: [&Frame; 2], moves: bool) -> Self {
        let frames = [&FrameOf::of(was), &FrameOf::of(is)];
        Self::at(touched.normal.into(), touched.depth, to.into(), (frames, moves))
    }

    /// The contact for a correction by something static.
    fn along(correction: Vec3) -> Option<Self> {
        let depth = correction.length();
        let normal = (correction / depth).into();
        (depth > 0.0).then(|| Self { normal, depth, carried: Vector::zero() })
    }

    /// Projects a row out, with friction.
    #[inline(always)]
    fn resolve(&self, places: &mut Places, row: u32, coefficient: f32) {
        let i = places.at(row);
        let moved = (places.position[i] - places.start[i]).truncate();
        places.displace(row, self.displacement(moved.into(), coefficient).into());
    }
}

impl<N: Number> ContactOf<N> {
    /// Contacts of particles at `to` that touch along `normal`, both in the frame of a shape, which `moves` from the first pose to the second.
    #[inline(always)]
    fn at(
        normal: Vector<N>,
        depth: N,
        to: Vector<N>,
        ([was, is], moves): ([&FrameOf<N>; 2], bool),
    ) -> Self {
        let mut carried = Vector::zero();
        if moves {
            let settled = to + normal * depth;
            carried = is.point(settled) - was.point(settled);
        }
        Self { normal: is.turn(normal), depth, carried }
    }

    /// The displacement out of the contact, with friction, of what has `moved` since the substep began, metres.
    #[inline(always)]
    fn displacement(&self, moved: Vector<N>, coefficient: N) -> Vector<N> {
        let out = self.normal * self.depth;
        let moved = moved + out - self.carried;
        let slid = moved - self.normal * moved.dot(self.normal);
        out + friction(slid, self.depth, coefficient)
    }
}

/// A [`Frame`] for one point, or for eight.
struct FrameOf<N> {
    axes: [Vector<N>; 3],
    translation: Vector<N>,
}

impl<N: Number> FrameOf<N> {
    #[inline(always)]
    fn of(frame: &Frame) -> Self {
        let r = &frame.rotation;
        Self {
            axes: [Vector::splat(r.x_axis), Vector::splat(r.y_axis), Vector::splat(r.z_axis)],
            translation: Vector::splat(frame.translation),
        }
    }

    /// See [`Frame::local`].
    #[inline(always)]
    fn local(&self, point: Vector<N>) -> Vector<N> {
        let direction = point - self.translation;
        let [x, y, z] = &self.axes;
        Vector::new(x.dot(direction), y.dot(direction), z.dot(direction))
    }

    /// See [`Frame::turn`].
    #[inline(always)]
    fn turn(&self, local: Vector<N>) -> Vector<N> {
        let [x, y, z] = self.axes;
        x * local.x + y * local.y + z * local.z
    }

    /// See [`Frame::point`].
    #[inline(always)]
    fn point(&self, local: Vector<N>) -> Vector<N> {
        self.turn(local) + self.translation
    }
}

#[cfg(test)]
mod tests;
