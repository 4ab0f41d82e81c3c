//! Edges and triangles against colliders ([`features`](crate::collide::features)): what is between the particles of a body that collides by its surface.
//!
//! They are projected with the particles of their island, after them. Planes and rooms have no part in this, since nothing of them fits in between particles;
//! meshes and heightfields, which are not convex, have not; and neither have sensors, contact events and restitution, which particles see to.

use core::ops::Range;

use glam::Vec3;

use super::super::features::{
    Corners, Features, Reach, ShapeBeside, SupportPlane, SurfacePoint, rounding,
};
use super::super::frame::Frame;
use super::super::nearby;
use super::super::recovery::{limit_depth, split_depth};
use super::super::shape::Shape;
use super::super::world::World;
use super::surface::{ContactSurface, SurfaceForm};
use super::{InstantInterval, ParticleContact, ParticleContacts};
use crate::particles::{Particles, Places};

/// The features that may touch a collider in a step. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct FeatureCandidates {
    /// Island by island, in each by surface and then by feature.
    list: Vec<FeatureCandidate>,
    /// For each island its range in the list; empty if there are none.
    of_island: Vec<Range<u32>>,
    corners: Corners,
}

/// A feature that may touch a surface in this step.
#[derive(Clone, Copy, Debug)]
struct FeatureCandidate {
    island: u32,
    surface: u32,
    /// Where the search begins: its middle, or the point of it that was nearest when the step began.
    point: SurfacePoint,
    /// A plane between the two, as the step began.
    plane: SupportPlane,
    friction: f32,
}

impl FeatureCandidates {
    pub(super) fn clear(&mut self) {
        self.list.clear();
        self.of_island.clear();
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
            SurfaceForm::Shape(shape) => !surface.sensor && rounding(shape).is_some(),
            _ => false,
        };
        if self.surfaces.iter().any(is_sharp) {
            for body in features.bodies() {
                features.collect(body, particles, reach, &mut found.corners);
                for (number, surface) in self.surfaces.iter().enumerate() {
                    if is_sharp(surface) && surface.may_touch(world.filter, body) {
                        self.find_beside(particles, world, (features, body), number, &mut found);
                    }
                }
            }
        }
        if !found.list.is_empty() {
            found.list.sort_unstable_by_key(|candidate| {
                (candidate.island, candidate.surface, candidate.point.order())
            });
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

    /// Finds the features of a body that may touch one surface.
    fn find_beside(
        &self,
        particles: &Particles,
        world: &World,
        (features, body): (&Features, u32),
        number: usize,
        found: &mut FeatureCandidates,
    ) {
        let islands = world.islands;
        let surface = &self.surfaces[number];
        let SurfaceForm::Shape(shape) = &surface.form else { return };
        let first = features.first_row(body);
        let Some(material) = self.material(number, self.classes.of(first)) else { return };
        let frames = [0.0, 1.0].map(|share| surface.frame_at(share));
        let carried = if surface.moves { carried(shape, frames) } else { 0.0 };
        // Far from the world's origin, coordinates lose their digits.
        let origin = particles.origin[first as usize];
        let beside = ShapeBeside {
            shape,
            bounds: self.bounds_of_surface(number),
            frame: frames[0].seen_from(origin),
            origin,
            reach: Reach { most: carried, likely: carried },
        };
        let FeatureCandidates { list, corners, .. } = found;
        features.find_beside(body, &beside, particles, corners, |feature| {
            let rows = feature.rows();
            let island = islands.of[rows[0] as usize];
            let takes_part = rows
                .iter()
                .all(|&row| !self.is_excluded(row) && islands.of[row as usize] == island);
            let moves = rows.iter().any(|&row| particles.position[row as usize].w != 0.0);
            if takes_part && moves && !islands.list[island as usize].asleep {
                let mut point = feature.middle();
                let corners = point.corners(&particles.position, &particles.origin, 0);
                let radius = point.radius(&particles.radius, 0);
                let plane = point.begin(shape, corners.map(|at| beside.frame.local(at)), radius);
                let surface = number as u32;
                let friction = material.friction;
                list.push(FeatureCandidate { island, surface, point, plane, friction });
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
        let FeatureCandidate { surface: number, mut point, mut plane, .. } = *candidate;
        let surface = &self.surfaces[number as usize];
        let SurfaceForm::Shape(shape) = &surface.form else { return None };
        let (start, now) = (
            point.corners(places.start, places.origin, places.first),
            point.corners(places.position, places.origin, places.first),
        );
        let origin = places.origin[places.at(point.first())];
        let (was, is) = self.frames_of(number as usize, interval, origin);
        let (from, to) = (start.map(|at| was.local(at)), now.map(|at| is.local(at)));
        let radius = point.radius(places.radius, places.first);
        if !point.approach((shape, &mut plane), [from, to], radius) {
            return None;
        }
        let (from, to) = (point.of(from), point.of(to));
        let thickness = point.thickness(radius, from.distance(to));
        let touched = shape.touch(from, to, thickness)?;
        let way = (from, to, thickness);
        let touched = limit_depth(touched, shape, way, self.recover_in(interval))?;
        Some((point, ParticleContact::of(&touched, to, &[was, is], surface.moves)))
    }
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
        let depth = self.depth;
        let (new, old) = split_depth(depth, (self.carried - moved).dot(self.normal));
        if old > 0.0 {
            point.shift(places, self.normal * old);
            self.depth = new;
        }
        if self.depth > 0.0 {
            point.apply_impulse(places, self.displacement(moved, coefficient) / w);
        }
        depth
    }
}
