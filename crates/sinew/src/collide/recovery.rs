//! How much of an overlap that a substep began with a particle is put out by in it: what it approached by in the substep is stopped exactly, and the rest comes
//! at a bounded speed, since what is moved out by a length in a substep leaves with that length by the time of one.

use glam::Vec3;

use super::shape::{Shape, ShapeTouch};

/// How much of an overlap is recovered in a substep: so many times what gravity adds to it, and what this speed is, m/s.
const RECOVERED: (f32, f32) = (20.0, 2.0);

/// How much of an overlap of a particle is recovered in a substep of `h` seconds, metres.
pub(crate) fn recovery(h: f32, g: f32) -> f32 {
    in_substep(RECOVERED, h, g)
}

/// How far it is in a substep of `h` seconds, metres: so many times what gravity adds to an overlap in it, and what a speed is, m/s.
pub(super) fn in_substep((falls, speed): (f32, f32), h: f32, g: f32) -> f32 {
    falls * g * h * h + speed * h
}

/// How far a sphere that came from one point to another is put out of a shape in a substep in which so much of an overlap is recovered, metres. `None` if it is
/// not.
#[inline]
pub(super) fn recovered(
    touched: ShapeTouch,
    shape: &Shape,
    (from, to, radius): (Vec3, Vec3, f32),
    recover: f32,
) -> Option<ShapeTouch> {
    let most = touched.normal.dot(from - to) + recover;
    // Round a bend it may have begun behind the plane that it touches now, and yet outside.
    if touched.depth <= recover.max(most) || !is_inside(shape, from, radius, recover) {
        return Some(touched);
    }
    (most > 0.0).then_some(ShapeTouch { depth: most, ..touched })
}

#[cold]
fn is_inside(shape: &Shape, at: Vec3, radius: f32, recover: f32) -> bool {
    shape.touch(at, at, radius).is_some_and(|touched| touched.depth > recover)
}

/// The same of a way out of planes and boxes.
#[inline]
pub(super) fn recovered_way(out: Vec3, moved: Vec3, recover: f32) -> Vec3 {
    let depth = out.length();
    if depth <= recover {
        return out;
    }
    let most = recover - out.dot(moved) / depth;
    if most < depth { out * (most.max(0.0) / depth) } else { out }
}
