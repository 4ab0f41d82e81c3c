//! A sphere against a surface of triangles, which need not be convex.
//!
//! # The rule
//!
//! If the path of the centre crosses triangles, the first crossing counts: the centre is placed in front of that triangle's plane, on the side that it came
//! from, and its motion along the plane is kept. If it crosses none, the nearest triangle within the radius pushes it straight away. Either may push it into
//! another triangle, as in a valley, so the test is repeated for the path from the start to the new position, a few times. If there is still a triangle in
//! between, the centre goes back to where its path met the first triangle, and if even that is beyond another one, to its start. Nothing can pass through: the
//! result can always be reached from the start by a straight path without a crossing.
//!
//! A centre must not lie *in* a triangle, as that of a sphere without a radius would: its side could not be determined in the next substep. So it keeps a
//! distance of at least a few steps of `f32`.

use glam::Vec3;

use super::triangle::{ClosestPoint, Crossing, Feature, Triangle};
use super::{RayHit, ShapeTouch};

/// Triangles with a spatial lookup.
pub(super) trait Surface {
    /// Calls `call` with the index of each triangle that a path crosses or that is within reach of its end, and possibly with others.
    fn visit(&self, path: &SpherePath, call: &mut impl FnMut(u32, &Triangle));

    /// Bounding box.
    fn bounds(&self) -> (Vec3, Vec3);

    /// See [`Shape::cast_ray`](super::Shape::cast_ray).
    fn cast(&self, origin: Vec3, direction: Vec3, max: f32) -> Option<RayHit>
    where
        Self: Sized,
    {
        // No longer than the surface is far, so that the end of the segment is as precise as possible.
        let (low, high) = self.bounds();
        let far = (origin - (low + high) * 0.5).length() + (high - low).length();
        let length = max.min(far);
        let (crossing, triangle) = first_crossing(self, origin, origin + direction * length)?;
        let normal = if crossing.front { triangle.normal } else { -triangle.normal };
        Some(RayHit { distance: crossing.share as f32 * length, normal })
    }

    /// Whether it stops only what comes from the front.
    fn front_only(&self) -> bool;

    /// Whether nothing but triangles is within a distance of a point. A heightfield has sides without.
    fn is_away_from_rim(&self, at: Vec3, distance: f32) -> bool;

    /// Whether a point is inside of the volume that it encloses. `near` is the nearest triangle if there is one within reach.
    fn is_inside(&self, p: Vec3, near: Option<&(u32, ClosestPoint, Triangle)>) -> bool;
}

/// A path, and the ball within reach of its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpherePath {
    pub(super) from: Vec3,
    pub(super) to: Vec3,
    pub(super) reach: f32,
    /// A margin for the rounding of coordinates.
    slack: f32,
    /// The reach plus that margin.
    pub(super) margin: f32,
    /// Bounding box of the path, with a margin.
    low: Vec3,
    high: Vec3,
    /// Middle of the path, and the vector from there to its end.
    middle: Vec3,
    half: Vec3,
}

/// Result of a moving sphere against a surface.
pub(super) enum SphereSlide {
    /// Nothing is in its path.
    Clear,
    /// It ended inside of the enclosed volume and crossed nothing, so it began there.
    Inside,
    /// The correction of its end position.
    Moved(Option<ShapeTouch>),
}

/// Maximum number of pushes. A corner takes one for each wall; where three slopes meet at obtuse angles they push it to and fro for a while.
const ROUNDS: usize = 8;

/// Share of its radius that a sphere keeps at least. Less overlap is what rounding leaves of the last push.
pub(super) const CLEAR: f32 = 1.0 - 1e-5;

/// Minimum distance of a centre from a triangle, as a share of the largest coordinate: 32 steps of `f32`, more than the accumulated rounding of a step.
const SKIN: f32 = 4e-6;

/// Minimum distance of a centre from a surface within a box, metres.
pub(super) fn skin((low, high): (Vec3, Vec3)) -> f32 {
    low.abs().max(high.abs()).max_element() * SKIN
}

/// Whether a path between two finite points may touch a surface with these bounds.
#[inline(always)]
pub(super) fn is_near((low, high): (Vec3, Vec3), from: Vec3, to: Vec3, reach: f32) -> bool {
    let reach = Vec3::splat(reach);
    let overlaps =
        (from.min(to) - reach).cmple(high).all() && (from.max(to) + reach).cmpge(low).all();
    overlaps && from.is_finite() && to.is_finite()
}

/// Slides a sphere whose centre moves from one point to another along the surface.
pub(super) fn slide(surface: &impl Surface, from: Vec3, to: Vec3, reach: f32) -> SphereSlide {
    let mut shift = Vec3::ZERO;
    let mut single = None;
    let mut first: Option<Vec3> = None;
    for round in 0..ROUNDS {
        let place = to + shift;
        let (crossing, near) = first_and_nearest(surface, &SpherePath::new(from, place, reach));
        let (normal, depth) = if let Some((crossing, triangle)) = crossing {
            let normal = if crossing.front { triangle.normal } else { -triangle.normal };
            let met = from + (place - from) * crossing.share as f32 + normal * reach;
            first = first.or(Some(met));
            (normal, reach + normal.dot(triangle.corners[0] - place))
        } else {
            if round == 0 && surface.is_inside(place, near.as_ref()) {
                return SphereSlide::Inside;
            }
            let Some((_, close, triangle)) = near else { break };
            let away = close.square.sqrt();
            if away >= reach * CLEAR {
                break;
            }
            (direction(place, from, &close, &triangle, away), reach - away)
        };
        single = if round == 0 { ShapeTouch::new(normal, depth) } else { None };
        shift += normal * depth;
        if round == ROUNDS - 1 {
            shift = last_resort(surface, from, to, shift, first);
        }
    }
    if shift == Vec3::ZERO {
        return SphereSlide::Clear;
    }
    SphereSlide::Moved(single.or_else(|| ShapeTouch::between(Vec3::ZERO, shift)))
}

/// The first triangle that a path crosses; of several at the same point, that with the lowest index.
pub(super) fn first_crossing(
    surface: &impl Surface,
    from: Vec3,
    to: Vec3,
) -> Option<(Crossing, Triangle)> {
    first_and_nearest(surface, &SpherePath::new(from, to, 0.0)).0
}

type CrossingAndNearest = (Option<(Crossing, Triangle)>, Option<(u32, ClosestPoint, Triangle)>);

/// The first triangle that a path crosses, and the one nearest to its end within reach.
fn first_and_nearest(surface: &impl Surface, path: &SpherePath) -> CrossingAndNearest {
    let mut crossing: Option<(u32, Crossing, Triangle)> = None;
    let mut near: Option<(u32, ClosestPoint, Triangle)> = None;
    let within = path.reach * path.reach;
    let front_only = surface.front_only();
    surface.visit(path, &mut |number, triangle| {
        let (from, to) = (path.from - triangle.corners[0], path.to - triangle.corners[0]);
        let (before, after) = (triangle.normal.dot(from), triangle.normal.dot(to));
        // Rounding grows with the distances that are computed with.
        let slack = path.slack + from.abs().max(to.abs()).max_element() * 1e-6;
        // A path that stays on one side by more than that crosses nothing.
        let one_sided = before * after > 0.0 && before.abs().min(after.abs()) > slack;
        let found =
            if one_sided { None } else { triangle.crossing(path.from, path.to, front_only) };
        if let Some(found) = found {
            let sooner = crossing.as_ref().is_none_or(|(other, best, _)| {
                found.share < best.share || (found.share == best.share && number < *other)
            });
            if sooner {
                crossing = Some((number, found, *triangle));
            }
        }
        // The distance from its plane is a lower bound of the distance from a triangle.
        let most = near.as_ref().map_or(within, |(_, best, _)| best.square);
        let least = (after.abs() - slack).max(0.0);
        if least * least > most {
            return;
        }
        let close = triangle.closest(path.to);
        let nearer = near.as_ref().map_or(close.square < within, |(other, best, _)| {
            close.square < best.square || (close.square == best.square && number < *other)
        });
        if nearer {
            near = Some((number, close, *triangle));
        }
    });
    (crossing.map(|(_, crossing, triangle)| (crossing, triangle)), near)
}

/// The direction away from the nearest point of a triangle.
fn direction(
    place: Vec3,
    from: Vec3,
    close: &ClosestPoint,
    triangle: &Triangle,
    away: f32,
) -> Vec3 {
    let tolerance = place.abs().max_element() * f32::EPSILON;
    let side = |p: Vec3| triangle.normal.dot(p - triangle.corners[0]);
    if away > tolerance && close.feature != Feature::Face {
        return (place - close.point) / away;
    }
    // On the triangle, the start determines the side.
    let height = if away > tolerance { side(place) } else { side(from) };
    if height < 0.0 { -triangle.normal } else { triangle.normal }
}

/// The shift, unless it ends beyond a triangle; else the one to where the first triangle was met; else the one back to the start.
fn last_resort(
    surface: &impl Surface,
    from: Vec3,
    to: Vec3,
    shift: Vec3,
    met: Option<Vec3>,
) -> Vec3 {
    let free = |place: Vec3| first_crossing(surface, from, place).is_none();
    if free(to + shift) {
        return shift;
    }
    met.filter(|&place| free(place)).unwrap_or(from) - to
}

impl SpherePath {
    /// The path between two points.
    pub(super) fn new(from: Vec3, to: Vec3, reach: f32) -> Self {
        // Rounding of coordinates must not separate what touches.
        let slack = from.abs().max(to.abs()).max_element() * 1e-6;
        let (middle, half, margin) = ((from + to) * 0.5, (to - from) * 0.5, reach + slack);
        let (low, high) = (from.min(to) - Vec3::splat(slack), from.max(to) + Vec3::splat(slack));
        Self { from, to, reach, slack, margin, low, high, middle, half }
    }

    /// Whether a box may be within reach of the end, or the path may intersect it: a separating axis test with the axes of the box, and their cross products
    /// with the path.
    #[inline(always)]
    pub(super) fn may_overlap(&self, low: Vec3, high: Vec3) -> bool {
        let off = self.to - self.to.max(low).min(high);
        if off.length_squared() <= self.margin * self.margin {
            return true;
        }
        if !(self.low.cmple(high).all() && self.high.cmpge(low).all()) {
            return false;
        }
        let (w, v) = (self.half, self.half.abs());
        let h = (high - low) * 0.5 + Vec3::splat(self.slack);
        let m = self.middle - (low + high) * 0.5;
        let span = Vec3::new(h.y * v.z + h.z * v.y, h.x * v.z + h.z * v.x, h.x * v.y + h.y * v.x);
        w.cross(m).abs().cmple(span * (1.0 + 1e-5)).all()
    }
}
