//! A sphere against a surface of triangles, dents and all.
//!
//! # The rule
//!
//! Where the way of the centre crosses triangles, the first of them counts, and the centre is put in front of its plane, on the side where it came
//! from; what it did along the plane stays. Where it crosses none, the nearest triangle within the radius pushes it straight away. Either may push it
//! into another triangle, as in a valley, so the same is asked again about the way from the start to the new place, a few times; and if there is
//! still one in between, the centre goes back to where its way met the first triangle, and if even that is beyond another, to where it started. There
//! is no way through: what is left in the end is a place that a straight way leads to from the start without crossing.
//!
//! A centre must not come to lie *in* a triangle, as one without a radius would: next time nobody could tell on which side it was. So it keeps off by
//! a few steps of `f32` at least.

use glam::Vec3;

use super::ShapeTouch;
use super::triangle::{Close, Crossing, Feature, Triangle};

/// Triangles that can be looked up by where they are.
pub(super) trait Surface {
    /// Calls with the number of each triangle that a way crosses or that is within reach of its end, and perhaps with others.
    fn visit(&self, sweep: &Sweep, call: &mut impl FnMut(u32, &Triangle));

    /// Whether it holds back what comes from the front only.
    fn front_only(&self) -> bool;

    /// Whether a point is inside of what it encloses. `near` is the nearest triangle if there is one within reach.
    fn is_inside(&self, p: Vec3, near: Option<&(u32, Close, Triangle)>) -> bool;
}

/// A way, and all places within reach of its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweep {
    pub(super) from: Vec3,
    pub(super) to: Vec3,
    pub(super) reach: f32,
    /// More than rounding of coordinates takes.
    room: f32,
    /// The reach and that room.
    pub(super) margin: f32,
    /// The box around the way, and some room.
    low: Vec3,
    high: Vec3,
    /// Of the way: its middle, and from there to its end.
    middle: Vec3,
    half: Vec3,
}

/// What became of a sphere.
pub(super) enum SphereSlide {
    /// Nothing is in its way.
    Clear,
    /// It ended inside of what the surface encloses and crossed nothing, so it began there.
    Inside,
    /// How it must be moved from where it would have gone.
    Moved(Option<ShapeTouch>),
}

/// Pushes in a row at most. A corner takes one for each wall; where three slopes meet at blunt angles they pass it on to each other for a while.
const ROUNDS: usize = 8;

/// Of the largest coordinate: what a centre keeps off a triangle at least. 32 steps of `f32`, which is more than the rounding of a step adds up to.
const SKIN: f32 = 4e-6;

/// What a centre keeps off a surface within a box at least, metres.
pub(super) fn skin((low, high): (Vec3, Vec3)) -> f32 {
    low.abs().max(high.abs()).max_element() * SKIN
}

/// A sphere whose centre goes from one place to another.
pub(super) fn slide(surface: &impl Surface, from: Vec3, to: Vec3, reach: f32) -> SphereSlide {
    let mut shift = Vec3::ZERO;
    let mut single = None;
    let mut first: Option<Vec3> = None;
    for round in 0..ROUNDS {
        let place = to + shift;
        let (crossing, near) = first_and_nearest(surface, &Sweep::new(from, place, reach));
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
            // Less is what rounding leaves of the last push.
            if away >= reach * (1.0 - 1e-5) {
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

/// The first triangle that a way crosses, where it does; of several there, the first.
pub(super) fn first_crossing(
    surface: &impl Surface,
    from: Vec3,
    to: Vec3,
) -> Option<(Crossing, Triangle)> {
    first_and_nearest(surface, &Sweep::new(from, to, 0.0)).0
}

type Found = (Option<(Crossing, Triangle)>, Option<(u32, Close, Triangle)>);

/// The first triangle that a way crosses, and the one nearest to its end within reach.
fn first_and_nearest(surface: &impl Surface, sweep: &Sweep) -> Found {
    let mut crossing: Option<(u32, Crossing, Triangle)> = None;
    let mut near: Option<(u32, Close, Triangle)> = None;
    let within = sweep.reach * sweep.reach;
    let front_only = surface.front_only();
    surface.visit(sweep, &mut |number, triangle| {
        let (from, to) = (sweep.from - triangle.corners[0], sweep.to - triangle.corners[0]);
        let (before, after) = (triangle.normal.dot(from), triangle.normal.dot(to));
        // What rounding takes grows with the distances that it is computed from.
        let room = sweep.room + from.abs().max(to.abs()).max_element() * 1e-6;
        // By more than that on one side from start to end, it crosses nothing.
        let aside = before * after > 0.0 && before.abs().min(after.abs()) > room;
        let found = if aside { None } else { triangle.crossing(sweep.from, sweep.to, front_only) };
        if let Some(found) = found {
            let sooner = crossing.as_ref().is_none_or(|(other, best, _)| {
                found.share < best.share || (found.share == best.share && number < *other)
            });
            if sooner {
                crossing = Some((number, found, *triangle));
            }
        }
        // What is farther from its plane is farther from it.
        let most = near.as_ref().map_or(within, |(_, best, _)| best.square);
        let least = (after.abs() - room).max(0.0);
        if least * least > most {
            return;
        }
        let close = triangle.closest(sweep.to);
        let nearer = near.as_ref().map_or(close.square < within, |(other, best, _)| {
            close.square < best.square || (close.square == best.square && number < *other)
        });
        if nearer {
            near = Some((number, close, *triangle));
        }
    });
    (crossing.map(|(_, crossing, triangle)| (crossing, triangle)), near)
}

/// Away from the nearest place of a triangle.
fn direction(place: Vec3, from: Vec3, close: &Close, triangle: &Triangle, away: f32) -> Vec3 {
    let grain = place.abs().max_element() * f32::EPSILON;
    let side = |p: Vec3| triangle.normal.dot(p - triangle.corners[0]);
    if away > grain && close.feature != Feature::Face {
        return (place - close.point) / away;
    }
    // On it, the start tells the side.
    let height = if away > grain { side(place) } else { side(from) };
    if height < 0.0 { -triangle.normal } else { triangle.normal }
}

/// The shift, if it does not end beyond a triangle; else to where the first one was met; else back to the start.
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

impl Sweep {
    /// The way between two places.
    pub(super) fn new(from: Vec3, to: Vec3, reach: f32) -> Self {
        // Rounding of coordinates must not part what touches.
        let room = from.abs().max(to.abs()).max_element() * 1e-6;
        let (middle, half, margin) = ((from + to) * 0.5, (to - from) * 0.5, reach + room);
        let (low, high) = (from.min(to) - Vec3::splat(room), from.max(to) + Vec3::splat(room));
        Self { from, to, reach, room, margin, low, high, middle, half }
    }

    /// Whether a box may be within reach of the end, or the way may meet it: whether no plane along two axes of the box, or along one of them and the
    /// way, is between the two.
    #[inline(always)]
    pub(super) fn meets(&self, low: Vec3, high: Vec3) -> bool {
        let off = self.to - self.to.max(low).min(high);
        if off.length_squared() <= self.margin * self.margin {
            return true;
        }
        if !(self.low.cmple(high).all() && self.high.cmpge(low).all()) {
            return false;
        }
        let (w, v) = (self.half, self.half.abs());
        let h = (high - low) * 0.5 + Vec3::splat(self.room);
        let m = self.middle - (low + high) * 0.5;
        let span = Vec3::new(h.y * v.z + h.z * v.y, h.x * v.z + h.z * v.x, h.x * v.y + h.y * v.x);
        w.cross(m).abs().cmple(span * (1.0 + 1e-5)).all()
    }
}
