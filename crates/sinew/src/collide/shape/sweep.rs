//! What a shape meets on a straight way, and what it touches where it is: the questions that `parry3d` answers about two shapes of any kind.
//!
//! The library is asked in the coordinates of the other shape, so that no digit is lost far from the origin.

use std::sync::LazyLock;

use glam::Vec3;
use parry3d::math::Pose;
use parry3d::query::{self, DefaultQueryDispatcher, QueryDispatcher, ShapeCastOptions};
use parry3d::shape as parry;

use super::convert::{ours, pose, theirs};
use super::{Kind, Shape};
use crate::collide::Frame;

/// What a shape may meet, in coordinates of the world, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Obstacle<'a> {
    /// A shape at a place.
    Shape(&'a Shape, Frame),
    /// A ball: its centre and its radius.
    Ball(Vec3, f32),
    /// A triangle, from both sides.
    Triangle([Vec3; 3]),
}

/// Where a shape that goes somewhere meets another one. Coordinates of the world, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SweepHit {
    /// How far it went.
    pub(crate) distance: f32,
    /// Where on the other one.
    pub(crate) point: Vec3,
    /// Unit vector out of the other one there.
    pub(crate) normal: Vec3,
}

impl SweepHit {
    /// The nearer one of two; of equals the first.
    fn nearer(self, other: Self) -> Self {
        if other.distance < self.distance { other } else { self }
    }
}

/// How a shape goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Unit vector.
    pub(crate) direction: Vec3,
    /// How far, metres.
    pub(crate) length: f32,
}

impl Obstacle<'_> {
    /// The box around it.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Self::Shape(shape, frame) => shape.bounds_in(frame),
            Self::Ball(centre, radius) => (*centre - *radius, *centre + *radius),
            Self::Triangle([a, b, c]) => (a.min(*b).min(*c), a.max(*b).max(*c)),
        }
    }

    /// The half-spaces of what is outside of a box, which is to be asked by them; `None` of anything else.
    fn walls(&self) -> Option<[Self; 6]> {
        let Self::Shape(room, frame) = self else { return None };
        if !matches!(room.kind(), Kind::InsideBox) {
            return None;
        }
        static FLOOR: LazyLock<Shape> = LazyLock::new(Shape::half_space);
        let mut walls = [Self::Shape(&FLOOR, *frame); 6];
        for (wall, own) in walls.iter_mut().zip(room.half_spaces()) {
            *wall = Self::Shape(&FLOOR, frame.of(&own));
        }
        Some(walls)
    }

    /// The same for the library, and the frame in whose coordinates it is given.
    fn with<T>(&self, use_it: impl FnOnce(&dyn parry::Shape, Frame) -> T) -> T {
        match self {
            Self::Shape(shape, frame) => use_it(shape.parry(), *frame),
            Self::Ball(centre, radius) => use_it(&parry::Ball::new(*radius), Frame::at(*centre)),
            Self::Triangle([a, b, c]) => {
                let corners = [Vec3::ZERO, *b - *a, *c - *a].map(theirs);
                use_it(&parry::Triangle::new(corners[0], corners[1], corners[2]), Frame::at(*a))
            }
        }
    }
}

impl Shape {
    /// What this one at `frame` meets of another one on its way; `None` if nothing, and of two that cannot move against each other (half-spaces, meshes,
    /// landscapes).
    pub(crate) fn sweep(&self, frame: &Frame, way: &Way, other: &Obstacle) -> Option<SweepHit> {
        if !(frame.is_valid() && way.direction.is_finite() && way.length >= 0.0) {
            return None;
        }
        if let Some(walls) = other.walls() {
            let hits = walls.iter().filter_map(|wall| self.sweep(frame, way, wall));
            return hits.reduce(SweepHit::nearer);
        }
        let options = ShapeCastOptions {
            max_time_of_impact: way.length,
            target_distance: 0.0,
            stop_at_penetration: true,
            compute_impact_geometry_on_penetration: true,
        };
        other.with(|shape, at| {
            let (seen, along) = (pose(&frame.from_within(&at)), at.turn_back(way.direction));
            let asked = DefaultQueryDispatcher;
            let hit = asked.cast_shapes(&seen, theirs(along), shape, self.parry(), options);
            let hit = hit.ok().flatten()?;
            let (point, normal) = (at.point(ours(hit.witness1)), at.turn(ours(hit.normal1)));
            // Made unit: what the library says of a small gap is not, quite.
            let normal = normal.try_normalize()?;
            let distance = hit.time_of_impact.clamp(0.0, way.length);
            point.is_finite().then_some(SweepHit { distance, point, normal })
        })
    }

    /// Where this one at `frame` is nearest to another one, if no farther than `reach` metres: as a hit whose distance is that between the two, negative
    /// where they overlap.
    pub(crate) fn nearest_contact(
        &self,
        frame: &Frame,
        reach: f32,
        other: &Obstacle,
    ) -> Option<SweepHit> {
        if !frame.is_valid() {
            return None;
        }
        if let Obstacle::Ball(centre, radius) = other {
            let found = self.nearest(frame.local(*centre));
            let (distance, normal) = (found.distance - radius, -frame.turn(found.normal));
            let point = *centre + normal * *radius;
            return (distance <= reach).then_some(SweepHit { distance, point, normal });
        }
        if let Some(walls) = other.walls() {
            let hits = walls.iter().filter_map(|wall| self.nearest_contact(frame, reach, wall));
            return hits.reduce(SweepHit::nearer);
        }
        other.with(|shape, at| {
            let seen = pose(&frame.from_within(&at));
            let found = query::contact(&Pose::IDENTITY, shape, &seen, self.parry(), reach);
            let found = found.ok().flatten()?;
            let (point, normal) = (at.point(ours(found.point1)), at.turn(ours(found.normal1)));
            point.is_finite().then_some(SweepHit { distance: found.dist, point, normal })
        })
    }
}
