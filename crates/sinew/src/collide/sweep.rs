//! Shape casts along a straight line, and contacts of a shape where it is.
//!
//! The distance of two convex shapes is a convex function of how far one of them has moved, so its tangent lies below it. The shape can advance to where the
//! tangent reaches the clearance, and the distance is computed again there. This is conservative advancement (Mirtich, 1996) with Newton's steps: it never
//! passes through anything, however fast or thin, converges to the first contact from its near side, and takes one step on a flat face. Concave shapes are cast
//! against triangle by triangle.
//!
//! All computations are in the coordinates of the other shape, so that no digits are lost far from the origin.

use glam::{DVec3, Vec3};
use parry3d::math::Pose;
use parry3d::query;
use parry3d::shape as parry;

use super::frame::Frame;
use super::manifold::{ManifoldScratch, collide};
use super::shape::Shape;
use super::shape::convert::{pose, to_parry};
use super::shape::gap::{Gap, Relative, RoundedCore};

/// What a cast shape can hit, in world coordinates, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Obstacle<'a> {
    /// A shape at a frame.
    Shape(&'a Shape, Frame),
    /// A ball: centre and radius.
    Ball(Vec3, f32),
    /// A two-sided triangle.
    Triangle([Vec3; 3]),
}

/// A hit of a cast shape, or a contact of a shape with an obstacle. World coordinates, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SweepHit {
    /// How far the shape can move until the hit; for a contact, the distance of the two, negative where they overlap.
    pub(crate) distance: f32,
    /// The same in double precision and extrapolated to the exact clearance: below 0 where the shape starts closer than that.
    root: f64,
    /// Point on the obstacle.
    pub(crate) point: DVec3,
    /// Unit normal of the obstacle there, pointing out of it.
    pub(crate) normal: DVec3,
}

/// The motion of a cast shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweepMotion<'a> {
    /// Unit vector.
    pub(crate) direction: Vec3,
    /// Length of the cast, metres.
    pub(crate) length: f32,
    /// Distance that the shape keeps from all obstacles, metres, 0 or more.
    pub(crate) clearance: f32,
    /// Treatment of obstacles that are closer than that at the start.
    pub(crate) start: AtStart,
    /// Contacts that the shape moves along or away from. Parts that do not rise above their planes are ignored.
    pub(crate) along: &'a [SweepHit],
}

/// Which of the obstacles within the clearance at the start of a cast count as hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AtStart {
    /// All that overlap the shape, and those that it moves into.
    Overlapped,
    /// Those that the shape moves into.
    Entered,
    /// None.
    Passed,
}

impl Obstacle<'_> {
    /// Its AABB.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Self::Shape(shape, frame) => shape.bounds_in(frame),
            Self::Ball(centre, radius) => (*centre - *radius, *centre + *radius),
            Self::Triangle([a, b, c]) => (a.min(*b).min(*c), a.max(*b).max(*c)),
        }
    }
}

impl Shape {
    /// Whether the shape can be cast: it is convex and bounded.
    pub(crate) fn is_convex(&self) -> bool {
        RoundedCore::of(self).is_some()
    }

    /// Casts this shape at `frame` against an obstacle. `None` if it hits nothing, or if the shape cannot be cast (half-spaces, meshes, heightfields). The
    /// shape stops at the [clearance](SweepMotion::clearance); an obstacle that it would approach to no less than 98 % of that is not hit. Of several parts hit
    /// at the same distance, one behind the plane of another does not count.
    pub(crate) fn sweep(
        &self,
        frame: &Frame,
        motion: &SweepMotion,
        other: &Obstacle,
    ) -> Option<SweepHit> {
        let own = RoundedCore::of(self)?;
        if !(frame.is_valid() && motion.direction.is_finite() && motion.length >= 0.0) {
            return None;
        }
        let (mut first, mut inside): (Option<SweepHit>, _) = (None, false);
        self.pieces(frame, motion, other, &mut |piece, at| {
            if motion.is_behind_plane(&piece, at) {
                return;
            }
            match (Cast { own, piece, frame, at, motion }.first()) {
                SweepOutcome::Nothing => {}
                SweepOutcome::Inside => inside = true,
                SweepOutcome::At(hit) => {
                    let nearest =
                        first.map_or(hit.distance, |first| first.distance.min(hit.distance));
                    if first.is_none_or(|first| hit.is_before(&first, motion)) {
                        first = Some(hit);
                    }
                    first = first.map(|first| SweepHit { distance: nearest, ..first });
                }
            }
        });
        if inside && let Some(hit) = self.nearest_contact(frame, 0.0, other) {
            let hit = SweepHit { distance: 0.0, ..hit };
            let met = match motion.start {
                AtStart::Overlapped => true,
                AtStart::Entered => hit.normal.dot(motion.direction.as_dvec3()) < 0.0,
                AtStart::Passed => false,
            };
            return if met { Some(hit) } else { first };
        }
        first
    }

    /// Calls `call` with each convex part of an obstacle that this shape at `frame` may hit on its way, and the frame of that part.
    fn pieces(
        &self,
        frame: &Frame,
        motion: &SweepMotion,
        other: &Obstacle,
        call: &mut dyn FnMut(ConvexPiece, &Frame),
    ) {
        match *other {
            Obstacle::Ball(centre, radius) => {
                call(ConvexPiece::Convex(RoundedCore::ball(radius)), &Frame::at(centre));
            }
            Obstacle::Triangle(corners) => {
                let (local, at) = relative_to_first(&corners);
                call(ConvexPiece::Convex(RoundedCore::triangle(local)), &at);
            }
            Obstacle::Shape(shape, at) => {
                let swept = SweptBox::new(self, &frame.from_within(&at), &at, motion);
                let triangle =
                    &mut |corners| call(ConvexPiece::Convex(RoundedCore::triangle(corners)), &at);
                let keep = |low, high| swept.overlaps(low, high);
                if shape.is_unbounded() {
                    shape
                        .half_spaces()
                        .for_each(|wall| call(ConvexPiece::HalfSpace, &at.of(&wall)));
                } else if !shape.triangles_near(swept.bounds(), &keep, triangle) {
                    let (low, high) = shape.bounds();
                    let convex = RoundedCore::of(shape).filter(|_| keep(low, high));
                    convex.into_iter().for_each(|convex| call(ConvexPiece::Convex(convex), &at));
                }
            }
        }
    }

    /// Calls `call` with each contact of this shape at `frame` with an obstacle no farther than `reach` metres. The hit's distance is that between the two,
    /// negative where they overlap. There is one contact for each convex part; or, where the shape is deep inside one of them, one for each manifold of the
    /// narrow phase.
    pub(crate) fn contacts(
        &self,
        frame: &Frame,
        reach: f32,
        other: &Obstacle,
        call: &mut dyn FnMut(&SweepHit),
    ) {
        let Some(own) = RoundedCore::of(self).filter(|_| frame.is_valid()) else { return };
        let motion = SweepMotion {
            direction: Vec3::Y,
            length: 0.0,
            clearance: reach,
            start: AtStart::Overlapped,
            along: &[],
        };
        let mut inside = false;
        let mut found: Vec<SweepHit> = Vec::new();
        self.pieces(frame, &motion, other, &mut |piece, at| {
            let cast = Cast { own, piece, frame, at, motion: &motion };
            match cast.gap_at(frame.translation) {
                Some(near) => found.extend((near.hit.distance <= reach).then_some(near.hit)),
                None => inside = true,
            }
        });
        match other {
            Obstacle::Shape(shape, at) if inside => {
                self.manifolds(frame, reach, shape, at, call);
            }
            Obstacle::Ball(centre, radius) if inside => {
                let nearest = self.nearest(frame.local(*centre));
                let (distance, normal) = (nearest.distance - radius, -frame.turn(nearest.normal));
                call(&SweepHit::near(distance, *centre + normal * *radius, normal));
            }
            Obstacle::Triangle(corners) if inside => {
                let (local, at) = relative_to_first(corners);
                let (relative, triangle) =
                    (Relative::new(frame, &at), RoundedCore::triangle(local));
                if let Some(out) = own.separation(&relative, &triangle) {
                    call(&WorldGap::new(&out, &at).hit);
                }
            }
            _ => found.iter().for_each(call),
        }
    }

    /// Whether the shape touches a triangle.
    pub(crate) fn overlaps_triangle(&self, frame: &Frame, corners: &[Vec3; 3]) -> bool {
        if self.is_convex() {
            let mut overlaps = false;
            self.contacts(frame, 0.0, &Obstacle::Triangle(*corners), &mut |_| overlaps = true);
            return overlaps;
        }
        if self.is_unbounded() {
            let below = |wall: Frame| corners.iter().any(|&c| frame.of(&wall).local(c).y <= 0.0);
            return self.half_spaces().any(below);
        }
        let (local, at) = relative_to_first(corners);
        let [a, b, c] = local.map(to_parry);
        let (triangle, relative) = (parry::Triangle::new(a, b, c), pose(&frame.from_within(&at)));
        let overlaps =
            query::intersection_test(&Pose::IDENTITY, &triangle, &relative, self.parry());
        frame.is_valid() && at.is_valid() && overlaps.is_ok_and(|overlaps| overlaps.intersecting)
    }

    /// The nearest of the [contacts](Self::contacts).
    pub(crate) fn nearest_contact(
        &self,
        frame: &Frame,
        reach: f32,
        other: &Obstacle,
    ) -> Option<SweepHit> {
        let mut nearest: Option<SweepHit> = None;
        self.contacts(frame, reach, other, &mut |hit| {
            if nearest.is_none_or(|nearest| hit.distance < nearest.distance) {
                nearest = Some(*hit);
            }
        });
        nearest
    }

    fn manifolds(
        &self,
        frame: &Frame,
        reach: f32,
        other: &Self,
        at: &Frame,
        call: &mut dyn FnMut(&SweepHit),
    ) {
        let (relative, scratch) = (frame.from_within(at), &mut ManifoldScratch::default());
        collide(self, other, &relative, reach, scratch, &mut |manifold| {
            let points = manifold.points();
            let Some(first) = points.first() else { return };
            let deepest = points
                .iter()
                .fold(first, |most, one| if one.distance < most.distance { one } else { most });
            let (point, normal) = (at.point(deepest.on_b), at.turn(manifold.normal));
            call(&SweepHit::near(deepest.distance, point, normal));
        });
    }
}

impl SweepHit {
    /// A contact of two nearby shapes.
    fn near(distance: f32, point: Vec3, normal: Vec3) -> Self {
        let (point, normal) = (point.as_dvec3(), normal.as_dvec3());
        Self { distance, root: f64::from(distance), point, normal }
    }

    /// Whether this hit comes before another in a cast. Of hits at the same distance one may hide the other: what lies behind the plane of a face is an edge of
    /// that face or of a neighbouring one, on which the shape would only get stuck.
    pub(crate) fn is_before(&self, other: &Self, motion: &SweepMotion) -> bool {
        if (self.distance - other.distance).abs() <= motion.tie_tolerance() {
            let ahead = |one: &Self, other: &Self| (one.point - other.point).dot(other.normal);
            let (own, theirs) = (ahead(self, other), ahead(other, self));
            if own.min(theirs) < COPLANAR && (own - theirs).abs() > 1e-8 {
                return own > theirs;
            }
        }
        self.root < other.root
    }
}

impl SweepMotion<'_> {
    /// Hits whose distances differ by no more than this count as simultaneous, metres.
    pub(crate) fn tie_tolerance(&self) -> f32 {
        0.02 * self.clearance
    }

    /// Whether a part lies behind one of the planes that the shape moves along, so that the shape comes no nearer to the part than to the plane.
    fn is_behind_plane(&self, piece: &ConvexPiece, at: &Frame) -> bool {
        let ConvexPiece::Convex(convex) = piece else { return false };
        self.along.iter().any(|plane| {
            let sinks = -plane.normal.dot(self.direction.as_dvec3()) * f64::from(self.length);
            if sinks > f64::from(0.5 * MIN_APPROACH * self.clearance) {
                return false;
            }
            let rotation = at.rotation.as_dmat3();
            let highest = convex.farthest(rotation.transpose() * plane.normal);
            let there = rotation * highest + at.translation.as_dvec3();
            (there - plane.point).dot(plane.normal) < COPLANAR
        })
    }

    /// Tolerance of the distance at which the cast stops, metres.
    fn tolerance(&self) -> f32 {
        if self.clearance > 0.0 { 1e-4 * self.clearance } else { 1e-6 }
    }
}

/// A convex part of an obstacle, in its own coordinates.
#[derive(Clone, Copy, Debug)]
enum ConvexPiece<'a> {
    /// Solid below y = 0.
    HalfSpace,
    Convex(RoundedCore<'a>),
}

/// Result of a cast against one part.
enum SweepOutcome {
    Nothing,
    /// The cast starts deep inside the part.
    Inside,
    At(SweepHit),
}

/// The gap of two shapes that do not overlap, in world coordinates.
#[derive(Clone, Copy)]
struct WorldGap {
    hit: SweepHit,
    /// The distance of the shapes, metres.
    distance: f64,
    /// The distance of their cores, without the rounding radii, metres.
    cores: f64,
}

/// A cast of one shape against one part of an obstacle.
#[derive(Clone, Copy)]
struct Cast<'a> {
    own: RoundedCore<'a>,
    piece: ConvexPiece<'a>,
    frame: &'a Frame,
    at: &'a Frame,
    motion: &'a SweepMotion<'a>,
}

/// What is above a plane by less than this counts as lying in it, metres.
const COPLANAR: f64 = 1e-6;
/// Greatest number of steps. A flat face takes one, a round shape some ten.
const ROUNDS: usize = 40;
/// Sine of the angle of approach below which the motion counts as parallel.
const GRAZING: f32 = 1e-4;
/// An obstacle is hit if the shape would come closer than the clearance by this share of it; if it starts closer than that, closer than at the start by half of
/// this.
const MIN_APPROACH: f32 = 0.02;

impl Cast<'_> {
    fn first(&self) -> SweepOutcome {
        let clearance = self.motion.clearance;
        // An obstacle that the shape only approaches to the clearance, within rounding, is not hit: the inner edges of a floor are not.
        match self.advance_to_gap(clearance * (1.0 - MIN_APPROACH)) {
            SweepOutcome::At(near) if clearance > 0.0 => match self.advance_to_gap(clearance) {
                SweepOutcome::At(hit) if hit.distance <= near.distance => SweepOutcome::At(hit),
                _ => SweepOutcome::At(near),
            },
            met => met,
        }
    }

    /// Where on the way the gap has decreased to `least` metres.
    fn advance_to_gap(&self, mut least: f32) -> SweepOutcome {
        let SweepMotion { direction, length, clearance, start, .. } = *self.motion;
        let mut travelled = 0.0_f32;
        let mut last: Option<WorldGap> = None;
        for _ in 0..ROUNDS {
            let place = self.frame.translation + direction * travelled;
            let Some(near) = self.gap_at(place) else {
                return last.map_or(SweepOutcome::Inside, |last| {
                    SweepOutcome::At(last.after(travelled, travelled.into()))
                });
            };
            let rate = -near.hit.normal.dot(direction.as_dvec3());
            // Less than the rounding error of the place.
            let rounding = 4.0 * f32::EPSILON * (place.abs().max_element() + travelled);
            let left = near.distance - f64::from(least);
            if left <= f64::from(self.motion.tolerance() + rounding) {
                let root = f64::from(travelled) + left / rate.max(f64::from(GRAZING));
                if travelled > 0.0 {
                    // Nearly touching corners and edges have no accurate direction; the last one is used.
                    let known = last.filter(|_| near.cores < 1e-3);
                    return SweepOutcome::At(known.unwrap_or(near).after(travelled, root));
                }
                if start == AtStart::Passed {
                    return SweepOutcome::Nothing;
                }
                let overlapped = near.distance < 0.0 && start == AtStart::Overlapped;
                let least_rate = if clearance > 0.0 { GRAZING } else { 0.0 };
                if overlapped || rate > f64::from(least_rate) {
                    return SweepOutcome::At(near.after(0.0, root));
                }
                least = near.distance as f32 - 0.5 * MIN_APPROACH * clearance;
            }
            // Both are convex, so they will come no nearer.
            if rate <= 0.0 {
                return SweepOutcome::Nothing;
            }
            let step = ((near.distance - f64::from(least)) / rate) as f32 - rounding;
            if step.is_nan() || travelled + step > length {
                return SweepOutcome::Nothing;
            }
            last = Some(near);
            if travelled + step <= travelled {
                break;
            }
            travelled += step;
        }
        last.map_or(SweepOutcome::Nothing, |last| {
            SweepOutcome::At(last.after(travelled, travelled.into()))
        })
    }

    /// The gap with the cast shape's origin at a place; `None` where the cores overlap.
    fn gap_at(&self, place: Vec3) -> Option<WorldGap> {
        let Self { own, piece, frame, at, .. } = self;
        let relative = Relative::new(&Frame { translation: place, ..**frame }, at);
        let gap = match piece {
            ConvexPiece::HalfSpace => own.above_plane(&relative),
            ConvexPiece::Convex(other) => own.gap(&relative, other)?,
        };
        let near = WorldGap::new(&gap, at);
        near.hit.point.is_finite().then_some(near)
    }
}

impl WorldGap {
    fn new(gap: &Gap, at: &Frame) -> Self {
        let Gap { distance, normal, point, cores } = *gap;
        let rotation = at.rotation.as_dmat3();
        let hit = SweepHit {
            distance: distance as f32,
            root: distance,
            point: rotation * point + at.translation.as_dvec3(),
            normal: (rotation * normal).normalize(),
        };
        Self { hit, distance, cores }
    }

    /// As a hit at a distance of the cast.
    fn after(&self, distance: f32, root: f64) -> SweepHit {
        SweepHit { distance, root, ..self.hit }
    }
}

/// The corners of a triangle relative to the first one, for precision, and the frame of that.
fn relative_to_first(corners: &[Vec3; 3]) -> ([Vec3; 3], Frame) {
    (corners.map(|corner| corner - corners[0]), Frame::at(corners[0]))
}

/// A moving AABB, in the coordinates of an obstacle.
#[derive(Clone, Copy, Debug)]
struct SweptBox {
    low: Vec3,
    high: Vec3,
    by: Vec3,
}

impl SweptBox {
    /// The box around a shape and its clearance, with a margin for rounding.
    fn new(shape: &Shape, relative: &Frame, at: &Frame, motion: &SweepMotion) -> Self {
        let (low, high) = shape.bounds_in(relative);
        let by = at.turn_back(motion.direction) * motion.length;
        let largest = low.abs().max(high.abs()).max(by.abs()).max_element();
        let room = 1.01 * motion.clearance + 1e-5 + 4e-6 * largest;
        Self { low: low - room, high: high + room, by }
    }

    /// The AABB of the whole motion.
    fn bounds(&self) -> (Vec3, Vec3) {
        (self.low.min(self.low + self.by), self.high.max(self.high + self.by))
    }

    /// Whether it overlaps a static box at any time: the time intervals of overlap on the three axes have a common part.
    fn overlaps(&self, low: Vec3, high: Vec3) -> bool {
        let (mut from, mut to) = (0.0_f32, 1.0_f32);
        for axis in 0..3 {
            let (near, far) = (low[axis] - self.high[axis], high[axis] - self.low[axis]);
            let by = self.by[axis];
            if by.abs() < 1e-9 {
                if near > 0.0 || far < 0.0 {
                    return false;
                }
            } else {
                let (a, b) = (near / by, far / by);
                from = from.max(a.min(b));
                to = to.min(a.max(b));
            }
        }
        from <= to
    }
}
