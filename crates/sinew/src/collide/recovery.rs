//! Maximum depenetration of a particle in a substep. The motion into the shape during the substep is corrected in full; an overlap from before is corrected at
//! a bounded speed, because a particle that is moved by a length in a substep leaves with the velocity length / h.

use glam::Vec3;

use super::shape::{Shape, ShapeTouch};
use crate::lanes::{Number, Vector};

/// Limit of the depenetration in a substep: this multiple of g h² (what gravity adds to an overlap), plus this speed times h, m/s.
const MAX_RECOVERY: (f32, f32) = (20.0, 2.0);
/// The part of that which may become velocity; same units. What rests on particles causes as much.
pub(super) const MAX_DEPENETRATION: (f32, f32) = (20.0, 0.1);

/// Maximum depenetration of a particle in a substep of `h` seconds, metres; `g` is the magnitude of gravity, m/s².
pub(crate) fn recovery(h: f32, g: f32) -> f32 {
    in_substep(MAX_RECOVERY, h, g)
}

/// A limit of depenetration, given as a multiple of g h² and a speed in m/s, for a substep of `h` seconds, metres.
pub(super) fn in_substep((falls, speed): (f32, f32), h: f32, g: f32) -> f32 {
    falls * g * h * h + speed * h
}

/// The contact of a sphere that moved `from` one point `to` another, with its depth limited to the approach of this substep plus `recover` metres. `None` if
/// nothing is left to correct.
#[inline]
pub(super) fn limit_depth(
    touched: ShapeTouch,
    shape: &Shape,
    (from, to, radius): (Vec3, Vec3, f32),
    recover: f32,
) -> Option<ShapeTouch> {
    let depth = limited(touched.depth, touched.normal.dot(from - to), recover);
    // On a curved surface the start may lie behind the tangent plane of this contact and yet outside the shape: then it was no overlap before, and all of it is
    // corrected.
    if depth == touched.depth || !is_inside(shape, from, radius, recover) {
        return Some(touched);
    }
    (depth > 0.0).then_some(ShapeTouch { depth, ..touched })
}

/// A depth as the approach of this substep and an overlap from before, metres.
///
/// What is between the particles of a surface is moved out of an old overlap without velocity: what is found late, deep in a shape, would be flung out.
#[inline]
pub(super) fn split_depth(depth: f32, approach: f32) -> (f32, f32) {
    let new = depth.min(approach.max(0.0));
    (new, depth - new)
}

/// The part of a depth that is corrected in a substep with the given approach, metres.
#[inline(always)]
fn limited<N: Number>(depth: N, approach: N, recover: N) -> N {
    let allowed = approach + recover;
    recover.max(allowed).lt(depth).select(allowed.max(N::zero()), depth)
}

#[cold]
fn is_inside(shape: &Shape, at: Vec3, radius: f32, recover: f32) -> bool {
    shape.touch(at, at, radius).is_some_and(|touched| touched.depth > recover)
}

/// As [`limit_depth`], for corrections `out` by planes and boxes of what has `moved` since the substep began, metres.
#[inline(always)]
pub(super) fn limit_correction<N: Number>(
    out: Vector<N>,
    moved: Vector<N>,
    recover: N,
) -> Vector<N> {
    let depth = out.length();
    if !recover.lt(depth).any() {
        return out;
    }
    let kept = limited(depth, -out.dot(moved) / depth, recover);
    (out * (kept / depth)).or_else(kept.lt(depth), out)
}
