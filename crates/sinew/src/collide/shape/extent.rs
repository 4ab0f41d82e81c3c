//! Axis-aligned bounding boxes of a shape, in its own frame and in the world.

use glam::Vec3;

use super::convex::Convex as _;
use super::surface::Surface as _;
use super::{Form, Shape};
use crate::collide::frame::Frame;

impl Shape {
    /// The axis-aligned bounding box in its own frame: lowest and highest coordinates, metres. A half-space is bounded at y = 0 only, and the outside of a box
    /// not at all.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let half = match &self.form {
            Form::HalfSpace => return (-Vec3::INFINITY, Vec3::INFINITY.with_y(0.0)),
            Form::InsideBox(_) => return (-Vec3::INFINITY, Vec3::INFINITY),
            Form::Hull(hull) => return around(&hull.points),
            Form::Mesh(mesh) => return mesh.bounds(),
            Form::Heights(heights) => return heights.bounds(),
            Form::Ball(ball) => Vec3::splat(ball.radius),
            Form::Capsule(c) => Vec3::new(c.radius, c.radius + c.half_height, c.radius),
            Form::Cuboid(cuboid) => cuboid.half_size,
            Form::Cylinder(c) => Vec3::new(c.radius, c.half_height, c.radius),
        };
        (-half, half)
    }

    /// The axis-aligned bounding box in the world of the shape in pose `frame`, metres; the smallest one except for meshes and heightfields.
    pub fn bounds_in(&self, frame: &Frame) -> (Vec3, Vec3) {
        let up = frame.rotation.y_axis;
        let half = match &self.form {
            Form::HalfSpace => return half_space(frame),
            Form::InsideBox(_) => return (-Vec3::INFINITY, Vec3::INFINITY),
            Form::Hull(hull) => {
                let mut hull = hull.points.iter().map(|&p| frame.point(p));
                let first = hull.next().unwrap_or(frame.translation);
                return hull.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
            }
            Form::Ball(ball) => Vec3::splat(ball.radius),
            Form::Capsule(c) => up.abs() * c.half_height + Vec3::splat(c.radius),
            Form::Cylinder(c) => {
                // Along a world axis the extent of a disc is its radius times the sine of the angle between the two axes.
                let sine = (Vec3::ONE - up * up).max(Vec3::ZERO).map(f32::sqrt);
                up.abs() * c.half_height + sine * c.radius
            }
            Form::Cuboid(_) | Form::Mesh(_) | Form::Heights(_) => {
                let (low, high) = self.bounds();
                let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
                let [x, y, z] = [frame.rotation.x_axis, up, frame.rotation.z_axis];
                let half = x.abs() * half.x + y.abs() * half.y + z.abs() * half.z;
                let middle = frame.point(middle);
                return (middle - half, middle + half);
            }
        };
        (frame.translation - half, frame.translation + half)
    }

    /// Whether a point is inside of the shape or on its surface. A sheet has no inside.
    pub fn contains(&self, point: Vec3) -> bool {
        match &self.form {
            Form::HalfSpace => point.y <= 0.0,
            Form::Ball(ball) => ball.nearest(point).distance <= 0.0,
            _ => self.nearest(point).distance <= 0.0,
        }
    }
}

/// The bounding box of points; zeros if there are none.
pub(super) fn around(points: &[Vec3]) -> (Vec3, Vec3) {
    let first = points.first().copied().unwrap_or(Vec3::ZERO);
    points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)))
}

/// A half-space is bounded only along a world axis that its surface is exactly perpendicular to.
fn half_space(frame: &Frame) -> (Vec3, Vec3) {
    let (mut low, mut high) = (-Vec3::INFINITY, Vec3::INFINITY);
    let up = frame.rotation.y_axis;
    for axis in 0..3 {
        if up.abs()[axis] == up.abs().element_sum() {
            let end = if up[axis] > 0.0 { &mut high } else { &mut low };
            end[axis] = frame.translation[axis];
        }
    }
    (low, high)
}
