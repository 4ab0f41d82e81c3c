//! What a shape meets on a straight way, and what it touches where it is.
//!
//! The distance of two convex shapes is a convex function of how far one of them has gone, so its tangent lies below it: where the tangent comes down to what is
//! kept clear, the shape may go, and there it looks again. That is conservative advancement (Mirtich, 1996) as Newton's method has it: it never goes through
//! anything, however fast and however thin, comes to the first contact from its near side, and ends on a flat one in its first round. What has dents is met
//! triangle by triangle.
//!
//! All of it happens in the coordinates of the other shape, so that no digit is lost far from the origin.

use glam::{DVec3, Vec3};
use parry3d::math::Pose;
use parry3d::query;
use parry3d::shape as parry;

use super::frame::Frame;
use super::manifold::{ManifoldScratch, collide};
use super::shape::Shape;
use super::shape::convert::{pose, theirs};
use super::shape::gap::{Gap, Relative, RoundedCore};

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

/// Where a shape that goes somewhere meets another one, or is near to it. Coordinates of the world, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SweepHit {
    /// How far it may go to there; of what is only near, how far they are apart, negative where they overlap.
    pub(crate) distance: f32,
    /// The same before rounding and to where it was looked for: below 0 where it begins nearer than that.
    root: f64,
    /// Where on the other one.
    pub(crate) point: DVec3,
    /// Unit vector out of the other one there.
    pub(crate) normal: DVec3,
}

/// How a shape goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SweepMotion<'a> {
    /// Unit vector.
    pub(crate) direction: Vec3,
    /// How far, metres.
    pub(crate) length: f32,
    /// How far it keeps off everything, metres, 0 and up.
    pub(crate) clearance: f32,
    /// What becomes of what is nearer than that from the start on.
    pub(crate) start: AtStart,
    /// What it touches and goes along or away from. What is no higher than the planes of these is not in its way.
    pub(crate) along: &'a [SweepHit],
}

/// What is met of what is too near at the start of a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AtStart {
    /// All that it overlaps.
    Overlapped,
    /// All that it goes into.
    Entered,
    /// Nothing.
    Passed,
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
}

impl Shape {
    /// Whether it may go somewhere: it has no dents and an end.
    pub(crate) fn is_convex(&self) -> bool {
        RoundedCore::of(self).is_some()
    }

    /// What this one at `frame` meets of another one on its way; `None` if nothing, and of those that cannot move against each other (half-spaces, meshes,
    /// landscapes). It goes no farther than the [clearance](SweepMotion::clearance) allows; less than a fiftieth of that is not yet in its way. Of several parts that
    /// are met at once, none counts that is behind the plane of another.
    pub(crate) fn sweep(
        &self,
        frame: &Frame,
        way: &SweepMotion,
        other: &Obstacle,
    ) -> Option<SweepHit> {
        let own = RoundedCore::of(self)?;
        if !(frame.is_valid() && way.direction.is_finite() && way.length >= 0.0) {
            return None;
        }
        let (mut first, mut inside): (Option<SweepHit>, _) = (None, false);
        self.pieces(frame, way, other, &mut |piece, at| {
            if way.goes_along(&piece, at) {
                return;
            }
            match (Cast { own, piece, frame, at, way }.first()) {
                SweepOutcome::Nothing => {}
                SweepOutcome::Inside => inside = true,
                SweepOutcome::At(hit) => {
                    let nearest =
                        first.map_or(hit.distance, |first| first.distance.min(hit.distance));
                    if first.is_none_or(|first| hit.is_before(&first, way)) {
                        first = Some(hit);
                    }
                    first = first.map(|first| SweepHit { distance: nearest, ..first });
                }
            }
        });
        if inside && let Some(hit) = self.nearest_contact(frame, 0.0, other) {
            let hit = SweepHit { distance: 0.0, ..hit };
            let met = match way.start {
                AtStart::Overlapped => true,
                AtStart::Entered => hit.normal.dot(way.direction.as_dvec3()) < 0.0,
                AtStart::Passed => false,
            };
            return if met { Some(hit) } else { first };
        }
        first
    }

    /// Calls with each convex part of another one that this one at `frame` may meet on its way, and with where it is.
    fn pieces(
        &self,
        frame: &Frame,
        way: &SweepMotion,
        other: &Obstacle,
        call: &mut dyn FnMut(ConvexPiece, &Frame),
    ) {
        match *other {
            Obstacle::Ball(centre, radius) => {
                call(ConvexPiece::Convex(RoundedCore::ball(radius)), &Frame::at(centre));
            }
            Obstacle::Triangle(corners) => {
                let (local, at) = about_first(&corners);
                call(ConvexPiece::Convex(RoundedCore::triangle(local)), &at);
            }
            Obstacle::Shape(shape, at) => {
                let swept = SweptBox::new(self, &frame.from_within(&at), &at, way);
                let triangle =
                    &mut |corners| call(ConvexPiece::Convex(RoundedCore::triangle(corners)), &at);
                let keep = |low, high| swept.meets(low, high);
                if shape.is_endless() {
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

    /// Calls with each place where this one at `frame` is no farther than `reach` metres from another one, as a hit whose distance is that between the two,
    /// negative where they overlap: one for each convex part, or where it is deep in one of them, one for each contact that solids would have.
    pub(crate) fn contacts(
        &self,
        frame: &Frame,
        reach: f32,
        other: &Obstacle,
        call: &mut dyn FnMut(&SweepHit),
    ) {
        let Some(own) = RoundedCore::of(self).filter(|_| frame.is_valid()) else { return };
        let way = SweepMotion {
            direction: Vec3::Y,
            length: 0.0,
            clearance: reach,
            start: AtStart::Overlapped,
            along: &[],
        };
        let mut inside = false;
        let mut found: Vec<SweepHit> = Vec::new();
        self.pieces(frame, &way, other, &mut |piece, at| {
            let cast = Cast { own, piece, frame, at, way: &way };
            match cast.near_at(frame.translation) {
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
                let (local, at) = about_first(corners);
                let (seen, triangle) = (Relative::new(frame, &at), RoundedCore::triangle(local));
                if let Some(out) = own.way_out(&seen, &triangle) {
                    call(&Near::new(&out, &at).hit);
                }
            }
            _ => found.iter().for_each(call),
        }
    }

    /// Whether it touches a triangle.
    pub(crate) fn meets_triangle(&self, frame: &Frame, corners: &[Vec3; 3]) -> bool {
        if self.is_convex() {
            let mut meets = false;
            self.contacts(frame, 0.0, &Obstacle::Triangle(*corners), &mut |_| meets = true);
            return meets;
        }
        if self.is_endless() {
            let below = |wall: Frame| corners.iter().any(|&c| frame.of(&wall).local(c).y <= 0.0);
            return self.half_spaces().any(below);
        }
        let (local, at) = about_first(corners);
        let [a, b, c] = local.map(theirs);
        let (triangle, seen) = (parry::Triangle::new(a, b, c), pose(&frame.from_within(&at)));
        let meets = query::intersection_test(&Pose::IDENTITY, &triangle, &seen, self.parry());
        frame.is_valid() && at.is_valid() && meets.is_ok_and(|meets| meets.intersecting)
    }

    /// The nearest one of [contacts](Self::contacts).
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
        let (seen, scratch) = (frame.from_within(at), &mut ManifoldScratch::default());
        collide(self, other, &seen, reach, scratch, &mut |manifold| {
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
    /// One of two that are near each other.
    fn near(distance: f32, point: Vec3, normal: Vec3) -> Self {
        let (point, normal) = (point.as_dvec3(), normal.as_dvec3());
        Self { distance, root: f64::from(distance), point, normal }
    }

    /// Whether it comes before another one on a way. Of those that come at once one may hide the other: what lies behind the plane of a face is an edge of that
    /// face or of one beside it, and would only be stumbled over.
    pub(crate) fn is_before(&self, other: &Self, way: &SweepMotion) -> bool {
        if (self.distance - other.distance).abs() <= way.at_once() {
            let ahead = |one: &Self, other: &Self| (one.point - other.point).dot(other.normal);
            let (own, theirs) = (ahead(self, other), ahead(other, self));
            if own.min(theirs) < LEVEL && (own - theirs).abs() > 1e-8 {
                return own > theirs;
            }
        }
        self.root < other.root
    }
}

impl SweepMotion<'_> {
    /// Hits that are no farther than this from each other come at once, metres.
    pub(crate) fn at_once(&self) -> f32 {
        0.02 * self.clearance
    }

    /// Whether a part is behind a plane that it goes along, so that it comes no nearer to it than to that.
    fn goes_along(&self, piece: &ConvexPiece, at: &Frame) -> bool {
        let ConvexPiece::Convex(convex) = piece else { return false };
        self.along.iter().any(|plane| {
            let sinks = -plane.normal.dot(self.direction.as_dvec3()) * f64::from(self.length);
            if sinks > f64::from(0.5 * DEEPER * self.clearance) {
                return false;
            }
            let rotation = at.rotation.as_dmat3();
            let highest = convex.farthest(rotation.transpose() * plane.normal);
            let there = rotation * highest + at.translation.as_dvec3();
            (there - plane.point).dot(plane.normal) < LEVEL
        })
    }

    /// How near to where it must stop it may stop, metres.
    fn tolerance(&self) -> f32 {
        if self.clearance > 0.0 { 1e-4 * self.clearance } else { 1e-6 }
    }
}

/// A convex part of an obstacle, in coordinates of its own.
#[derive(Clone, Copy, Debug)]
enum ConvexPiece<'a> {
    /// Below y = 0.
    HalfSpace,
    Convex(RoundedCore<'a>),
}

/// What a way leads to.
enum SweepOutcome {
    Nothing,
    /// It begins deep in it.
    Inside,
    At(SweepHit),
}

/// What is between two that do not overlap, in coordinates of the world.
#[derive(Clone, Copy)]
struct Near {
    hit: SweepHit,
    /// How far they are apart, metres.
    distance: f64,
    /// How far what is not round of them is apart, metres.
    cores: f64,
}

/// One shape on its way, and one part of another.
#[derive(Clone, Copy)]
struct Cast<'a> {
    own: RoundedCore<'a>,
    piece: ConvexPiece<'a>,
    frame: &'a Frame,
    at: &'a Frame,
    way: &'a SweepMotion<'a>,
}

/// What is ahead of a plane by less than this lies in it, metres.
const LEVEL: f64 = 1e-6;
/// Rounds at most. On a face it takes one, along what is round some ten.
const ROUNDS: usize = 40;
/// What is less in the way than that is gone along, as the sine of an angle.
const GRAZING: f32 = 1e-4;
/// By which part of the clearance more than that it must come near to something to meet it, and more of that where it is nearer from the start on.
const DEEPER: f32 = 0.02;

impl Cast<'_> {
    fn first(&self) -> SweepOutcome {
        let clearance = self.way.clearance;
        // What it only comes near to, as rounding has it, is not in its way: an edge within a floor is not.
        match self.down_to(clearance * (1.0 - DEEPER)) {
            SweepOutcome::At(near) if clearance > 0.0 => match self.down_to(clearance) {
                SweepOutcome::At(hit) if hit.distance <= near.distance => SweepOutcome::At(hit),
                _ => SweepOutcome::At(near),
            },
            met => met,
        }
    }

    /// Where on the way the gap has come down to so many metres.
    fn down_to(&self, mut least: f32) -> SweepOutcome {
        let SweepMotion { direction, length, clearance, start, .. } = *self.way;
        let mut gone = 0.0_f32;
        let mut last: Option<Near> = None;
        for _ in 0..ROUNDS {
            let place = self.frame.translation + direction * gone;
            let Some(near) = self.near_at(place) else {
                return last.map_or(SweepOutcome::Inside, |last| {
                    SweepOutcome::At(last.after(gone, gone.into()))
                });
            };
            let rate = -near.hit.normal.dot(direction.as_dvec3());
            // Less than rounding of the place adds.
            let grain = 4.0 * f32::EPSILON * (place.abs().max_element() + gone);
            let left = near.distance - f64::from(least);
            if left <= f64::from(self.way.tolerance() + grain) {
                let root = f64::from(gone) + left / rate.max(f64::from(GRAZING));
                if gone > 0.0 {
                    // Between corners and edges that nearly touch there is no direction any more.
                    let known = last.filter(|_| near.cores < 1e-3);
                    return SweepOutcome::At(known.unwrap_or(near).after(gone, root));
                }
                if start == AtStart::Passed {
                    return SweepOutcome::Nothing;
                }
                let overlapped = near.distance < 0.0 && start == AtStart::Overlapped;
                let least_rate = if clearance > 0.0 { GRAZING } else { 0.0 };
                if overlapped || rate > f64::from(least_rate) {
                    return SweepOutcome::At(near.after(0.0, root));
                }
                least = near.distance as f32 - 0.5 * DEEPER * clearance;
            }
            // RoundedCore, it comes no nearer ever.
            if rate <= 0.0 {
                return SweepOutcome::Nothing;
            }
            let step = ((near.distance - f64::from(least)) / rate) as f32 - grain;
            if step.is_nan() || gone + step > length {
                return SweepOutcome::Nothing;
            }
            last = Some(near);
            if gone + step <= gone {
                break;
            }
            gone += step;
        }
        last.map_or(SweepOutcome::Nothing, |last| SweepOutcome::At(last.after(gone, gone.into())))
    }

    /// What is between the two with the first one's origin at a place; `None` where they overlap.
    fn near_at(&self, place: Vec3) -> Option<Near> {
        let Self { own, piece, frame, at, .. } = self;
        let seen = Relative::new(&Frame { translation: place, ..**frame }, at);
        let gap = match piece {
            ConvexPiece::HalfSpace => own.above_plane(&seen),
            ConvexPiece::Convex(other) => own.gap(&seen, other)?,
        };
        let near = Near::new(&gap, at);
        near.hit.point.is_finite().then_some(near)
    }
}

impl Near {
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

    /// As a hit so far along a way.
    fn after(&self, distance: f32, root: f64) -> SweepHit {
        SweepHit { distance, root, ..self.hit }
    }
}

/// The corners of a triangle as seen from the first one, for the digits, and where that is.
fn about_first(corners: &[Vec3; 3]) -> ([Vec3; 3], Frame) {
    (corners.map(|corner| corner - corners[0]), Frame::at(corners[0]))
}

/// A box that goes somewhere, in coordinates of an obstacle.
#[derive(Clone, Copy, Debug)]
struct SweptBox {
    low: Vec3,
    high: Vec3,
    by: Vec3,
}

impl SweptBox {
    /// The box around a shape and what it keeps clear, with some room for rounding.
    fn new(shape: &Shape, seen: &Frame, at: &Frame, way: &SweepMotion) -> Self {
        let (low, high) = shape.bounds_in(seen);
        let by = at.turn_back(way.direction) * way.length;
        let largest = low.abs().max(high.abs()).max(by.abs()).max_element();
        let room = 1.01 * way.clearance + 1e-5 + 4e-6 * largest;
        Self { low: low - room, high: high + room, by }
    }

    /// All of the way.
    fn bounds(&self) -> (Vec3, Vec3) {
        (self.low.min(self.low + self.by), self.high.max(self.high + self.by))
    }

    /// Whether it meets a box that stands still: on each axis it does so for a while, and those have something in common.
    fn meets(&self, low: Vec3, high: Vec3) -> bool {
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
