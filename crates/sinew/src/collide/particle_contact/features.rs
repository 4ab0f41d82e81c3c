//! Edges and triangles against colliders ([`features`](crate::collide::features)): what is between the particles of a body that collides by its surface.
//!
//! They are projected with the particles of their island, after them. Planes and rooms have no part in this, since nothing of them fits in between particles; of
//! meshes and heightfields their [ridges](crate::collide::shape::Ridge) have. Sensors, contact events and restitution are seen to by the particles.

use core::ops::Range;

use glam::Vec3;

use super::super::features::{
    Corners, Features, Reach, ShapeBeside, is_blunt, ridge_box, rounding,
};
use super::super::frame::Frame;
use super::super::nearby;
use super::super::recovery::{limit_depth, split_depth};
use super::super::shape::{Kind, Shape};
use super::super::surface_point::{SupportPlane, SurfacePoint, each};
use super::super::world::World;
use super::surface::{ContactSurface, SurfaceForm};
use super::{InstantInterval, ParticleContact, ParticleContacts};
use crate::lanes::Vector;
use crate::particles::{Particles, Places};

/// The features that may touch a collider in a step. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct FeatureCandidates {
    /// Island by island, in each by surface and then by feature.
    list: Vec<FeatureCandidate>,
    /// For each island its range in the list; empty if there are none.
    of_island: Vec<Range<u32>>,
    ridge_boxes: Vec<RidgeBox>,
    corners: Corners,
}

/// The box that stands for a ridge, and its frame in that of its surface.
#[derive(Clone, Debug)]
struct RidgeBox {
    shape: Shape,
    frame: Frame,
}

/// A feature that may touch a surface in this step.
#[derive(Clone, Copy, Debug)]
struct FeatureCandidate {
    island: u32,
    surface: u32,
    /// The box of the surface that it may touch, if the surface is not convex.
    ridge_box: Option<u32>,
    /// Where the search begins: its middle, or the point of it that was nearest when the step began.
    point: SurfacePoint,
    /// A plane between the two, as the step began; where its corners were then, from the origin of the first of them; and the square of the distance that all of
    /// them may move from there before it could touch, m².
    plane: SupportPlane,
    corners: [Vec3; 3],
    free: f32,
    friction: f32,
}

impl FeatureCandidate {
    /// Whether its corners are too near to where they were when the step began for it to touch.
    #[inline(always)]
    fn stays_away(&self, corners: [Vec3; 3]) -> bool {
        let [a, b, c] = self.corners;
        let farthest = corners[0].distance_squared(a).max(corners[1].distance_squared(b));
        farthest.max(corners[2].distance_squared(c)) < self.free
    }
}

impl FeatureCandidates {
    pub(super) fn clear(&mut self) {
        self.list.clear();
        self.of_island.clear();
        self.ridge_boxes.clear();
    }

    /// Whether an island has candidates.
    pub(super) fn has(&self, island: usize) -> bool {
        self.of_island.get(island).is_some_and(|range| !range.is_empty())
    }

    fn of(&self, island: usize) -> &[FeatureCandidate] {
        let range = self.of_island.get(island).cloned().unwrap_or_default();
        &self.list[range.start as usize..range.end as usize]
    }
}

impl ParticleContacts {
    /// Finds the features that may touch a surface in this step, once it is known how far each row may move.
    pub(super) fn find_features(
        &mut self,
        particles: &Particles,
        world: &World,
        features: &Features,
    ) {
        let mut found = core::mem::take(&mut self.features);
        found.clear();
        let reach = |row: u32| {
            let speed = particles.velocity[row as usize].truncate().length();
            let likely = nearby::reach(speed, world.g(), world.dt);
            Reach { most: self.reference[row as usize].w.sqrt(), likely }
        };
        let is_sharp = |surface: &ContactSurface| match &surface.form {
            SurfaceForm::Shape(shape) => {
                !surface.sensor && (rounding(shape).is_some() || has_ridges(shape))
            }
            _ => false,
        };
        if self.surfaces.iter().any(is_sharp) {
            for body in features.bodies() {
                features.collect(body, particles, reach, &mut found.corners);
                for (number, surface) in self.surfaces.iter().enumerate() {
                    let SurfaceForm::Shape(shape) = &surface.form else { continue };
                    if !(is_sharp(surface) && surface.may_touch(world.filter, body)) {
                        continue;
                    }
                    let of_body = (features, body);
                    if !has_ridges(shape) {
                        self.find_beside(particles, world, of_body, (number, None), &mut found);
                        continue;
                    }
                    for i in self.find_ridges(particles, world, of_body, number, &mut found) {
                        let part = (number, Some(i));
                        self.find_beside(particles, world, of_body, part, &mut found);
                    }
                }
            }
        }
        if !found.list.is_empty() {
            // Those of one island stay in the order of bodies, surfaces, ridges and features.
            if !found.list.is_sorted_by_key(|candidate| candidate.island) {
                found.list.sort_by_key(|candidate| candidate.island);
            }
            found.of_island.resize(world.islands.list.len(), 0..0);
            let mut begin = 0;
            for own in found.list.chunk_by(|one, next| one.island == next.island) {
                let end = begin + own.len() as u32;
                found.of_island[own[0].island as usize] = begin..end;
                begin = end;
            }
        }
        self.features = found;
    }

    /// Adds the boxes of the ridges of a surface that are near a body and sharp beside its features; returns their numbers.
    fn find_ridges(
        &self,
        particles: &Particles,
        world: &World,
        (features, body): (&Features, u32),
        number: usize,
        found: &mut FeatureCandidates,
    ) -> Range<u32> {
        let FeatureCandidates { ridge_boxes, corners, .. } = found;
        let begin = ridge_boxes.len() as u32;
        let surface = &self.surfaces[number];
        if let SurfaceForm::Shape(shape) = &surface.form {
            let frames = [0.0, 1.0].map(|share| surface.frame_at(share));
            let [start, end] = frames.map(|frame| bounds_within(&frame, corners.bounds()));
            let around = if surface.moves { carried(shape, frames) } else { 0.0 };
            let near = (start.0.min(end.0) - around, start.1.max(end.1) + around);
            let motion = (corners.motion() + around) / world.substeps.max(1) as f32;
            let thickness = corners.thickness();
            let longest = features.longest(body, particles, corners);
            shape.ridges_near(near, |ridge| {
                if !is_blunt(ridge, longest, thickness) {
                    let of_body = (longest, thickness);
                    let (shape, frame) = ridge_box((ridge, shape), of_body, motion);
                    ridge_boxes.push(RidgeBox { shape, frame });
                }
            });
        }
        begin..ridge_boxes.len() as u32
    }

    /// Finds the features of a body that may touch one surface, or one ridge of it.
    fn find_beside(
        &self,
        particles: &Particles,
        world: &World,
        (features, body): (&Features, u32),
        (number, ridge_box): (usize, Option<u32>),
        found: &mut FeatureCandidates,
    ) {
        let islands = world.islands;
        let surface = &self.surfaces[number];
        let first = features.first_row(body);
        let Some(material) = self.material(number, self.classes.of(first)) else { return };
        let Some((shape, part)) = convex_part(surface, &found.ridge_boxes, ridge_box) else {
            return;
        };
        let (shape, part) = (&shape.clone(), part.copied());
        let part = part.as_ref();
        let frames = [0.0, 1.0].map(|share| surface.frame_at(share).of_part(part));
        let carried = if surface.moves { carried(shape, frames) } else { 0.0 };
        // Far from the world's origin, coordinates lose their digits.
        let origin = particles.origin[first as usize];
        let beside = ShapeBeside {
            shape,
            bounds: self.swept_bounds(number, shape, part),
            frame: frames[0].seen_from(origin),
            origin,
            reach: Reach { most: carried, likely: carried },
        };
        // What is pinned in the solid that a ridge belongs to is attached to it, however deep.
        let is_attached = |&row: &u32| match &surface.form {
            SurfaceForm::Shape(whole) if ridge_box.is_some() => {
                let (position, i) = (particles.position[row as usize], row as usize);
                let frame = surface.frame_at(0.0).seen_from(particles.origin[i]);
                let is_within = || {
                    whole.nearest(frame.local(position.truncate())).distance < particles.radius[i]
                };
                position.w == 0.0 && is_within()
            }
            _ => false,
        };
        let FeatureCandidates { list, corners, .. } = found;
        features.find_beside(body, &beside, particles, corners, |feature, reach| {
            let rows = feature.rows();
            let island = islands.of[rows[0] as usize];
            let takes_part = rows
                .iter()
                .all(|&row| !self.is_excluded(row) && islands.of[row as usize] == island);
            let moves = rows.iter().any(|&row| particles.position[row as usize].w != 0.0);
            let is_awake = !islands.list[island as usize].asleep;
            if takes_part && moves && is_awake && !rows.iter().any(is_attached) {
                let mut point = feature.middle();
                let corners = point.corners(&particles.position, &particles.origin, 0);
                let radius = point.radius(&particles.radius, 0);
                let local = each(corners, |at| beside.frame.local(at));
                let plane = point.begin(shape, local, radius);
                if plane.distance(local) > reach + radius {
                    return;
                }
                let free = (SurfacePoint::free_way(&plane, local, radius) - carried).max(0.0);
                list.push(FeatureCandidate {
                    island,
                    surface: number as u32,
                    ridge_box,
                    point,
                    plane,
                    corners,
                    free: free * free,
                    friction: material.friction,
                });
            }
        });
    }

    /// Projects the features of an island out of the surfaces near them once, with friction; returns the greatest depth, metres.
    pub(super) fn project_features(
        &self,
        places: &mut Places,
        number: usize,
        interval: InstantInterval,
    ) -> f32 {
        let depths = self.features.of(number).iter().map(|candidate| {
            let Some((point, contact)) = self.feature_contact(places, candidate, interval) else {
                return 0.0;
            };
            contact.resolve_point(places, &point, candidate.friction)
        });
        depths.fold(0.0, f32::max)
    }

    /// The contact of a feature in an interval, and the point of it that touches.
    #[inline(never)]
    fn feature_contact(
        &self,
        places: &Places,
        candidate: &FeatureCandidate,
        interval: InstantInterval,
    ) -> Option<(SurfacePoint, ParticleContact)> {
        let FeatureCandidate { surface: number, ridge_box, mut point, mut plane, .. } = *candidate;
        let (start, now) = (
            point.corners(places.start, places.origin, places.first),
            point.corners(places.position, places.origin, places.first),
        );
        if candidate.stays_away(start) && candidate.stays_away(now) {
            return None;
        }
        let surface = &self.surfaces[number as usize];
        let (shape, part) = convex_part(surface, &self.features.ridge_boxes, ridge_box)?;
        let origin = places.origin[places.at(point.first())];
        let (was, is) = self.frames_of(number as usize, interval, origin);
        let (was, is) = (was.of_part(part), is.of_part(part));
        let (from, to) = (each(start, |at| was.local(at)), each(now, |at| is.local(at)));
        let radius = point.radius(places.radius, places.first);
        if !point.approach((shape, &mut plane), [from, to], radius) {
            return None;
        }
        let corners = [from, to];
        let (from, to) = (point.of(from), point.of(to));
        let thickness = point.thickness(radius, from.distance(to));
        let touched = point.touch_collider(shape, corners, thickness)?;
        let way = (from, to, thickness);
        let touched = limit_depth(touched, shape, way, self.recover_in(interval))?;
        Some((point, ParticleContact::of(&touched, to, [&was, &is], surface.moves)))
    }
}

/// Whether a shape is not convex, and its ridges collide in its place.
fn has_ridges(shape: &Shape) -> bool {
    matches!(shape.kind(), Kind::Mesh | Kind::HeightField)
}

/// A surface that is convex, or one of its ridges as a box; with its frame in that of the surface.
#[inline]
fn convex_part<'a>(
    surface: &'a ContactSurface,
    ridge_boxes: &'a [RidgeBox],
    ridge_box: Option<u32>,
) -> Option<(&'a Shape, Option<&'a Frame>)> {
    match (ridge_box, &surface.form) {
        (Some(i), _) => ridge_boxes.get(i as usize).map(|part| (&part.shape, Some(&part.frame))),
        (None, SurfaceForm::Shape(shape)) => Some((shape, None)),
        (None, _) => None,
    }
}

/// An AABB in a frame about one in the world, metres.
fn bounds_within(frame: &Frame, (low, high): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let (middle, half) = (frame.local((low + high) * 0.5), (high - low) * 0.5);
    let r = frame.rotation.transpose();
    let half = r.x_axis.abs() * half.x + r.y_axis.abs() * half.y + r.z_axis.abs() * half.z;
    (middle - half, middle + half)
}

/// How far a point of a shape moves between two frames at the most, metres.
fn carried(shape: &Shape, [start, end]: [Frame; 2]) -> f32 {
    let (low, high) = shape.bounds();
    let corners = (0..8_u32).map(|i| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { 0.0 };
        low + (high - low) * Vec3::new(side(0), side(1), side(2))
    });
    corners.map(|corner| start.point(corner).distance(end.point(corner))).fold(0.0, f32::max)
}

impl ParticleContact {
    /// Projects the point of a feature out, with friction; returns the depth, metres. What is recovered of an old overlap is no velocity.
    fn resolve_point(mut self, places: &mut Places, point: &SurfacePoint, coefficient: f32) -> f32 {
        let w = point.inverse_mass(places);
        if w <= 0.0 {
            return self.depth;
        }
        let place =
            |column, places: &Places| point.of(point.corners(column, places.origin, places.first));
        let moved = place(places.position, places) - place(places.start, places);
        let (depth, moved) = (self.depth, Vector::from(moved));
        let (new, old) = split_depth(depth, (self.carried - moved).dot(self.normal));
        if old > 0.0 {
            point.shift(places, (self.normal * old).into());
            self.depth = new;
        }
        if self.depth > 0.0 {
            point.apply_impulse(places, Vec3::from(self.displacement(moved, coefficient)) / w);
        }
        depth
    }
}
