//! Colliders: static or kinematic shapes, which particles and body colliders cannot enter.

use glam::{Mat3, Vec3};

use super::frame::Frame;
use super::material::{Layers, Material};
use super::shape::Shape;

/// A static or kinematic shape in the world: only the game moves it. It pushes what touches it and is not pushed back.
/// ```
/// use sinew::glam::Vec3;
/// use sinew::{Collider, Frame, Shape, Simulation};
///
/// let mut world = Simulation::default();
/// // A lift that rises by 1 cm in each step.
/// let lift = Collider::fixed(Shape::cuboid(Vec3::ONE)?, Frame::IDENTITY);
/// world.colliders.push(lift.moving_to(Frame::at(Vec3::Y * 0.01)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// Its shape, in its own frame.
    pub shape: Shape,
    /// Its pose at the start of the step.
    pub start: Frame,
    /// Its pose at the end of the step; equal to `start` for a static collider. In between it moves at constant velocity, and friction carries along what lies
    /// on it.
    pub end: Frame,
    /// Its surface: friction, restitution, drag.
    pub material: Material,
    /// Its collision layers.
    pub layers: Layers,
    /// Whether it is a sensor: it lets everything through, and reports what overlaps it or meets it within the step, however fast that is. What is wholly
    /// inside a closed mesh overlaps it. Default false.
    pub sensor: bool,
    /// Whether its contacts are listed in the report. Default false.
    pub events: bool,
    /// Its identity in the contact cache ([`ContactCache`](super::ContactCache)). Must ascend in the list of colliders, whichever are added or removed. Default
    /// 0, which stands for its index in that list.
    pub id: u64,
}

impl Collider {
    /// A static collider.
    pub fn fixed(shape: Shape, frame: Frame) -> Self {
        Self {
            shape,
            start: frame,
            end: frame,
            material: Material::default(),
            layers: Layers::default(),
            sensor: false,
            events: false,
            id: 0,
        }
    }

    /// The same collider, moving to pose `end` during the step.
    pub fn moving_to(self, end: Frame) -> Self {
        Self { end, ..self }
    }

    /// The same collider with another material.
    pub fn with_material(self, material: Material) -> Self {
        Self { material, ..self }
    }

    /// Whether its frames and its material are valid. Colliders that are not are skipped.
    pub fn is_valid(&self) -> bool {
        self.start.is_valid() && self.end.is_valid() && self.material.is_valid()
    }

    /// Its pose at a fraction `share` of the step, 0 to 1: constant linear velocity, constant angular velocity about one axis.
    pub fn frame_at(&self, share: f32) -> Frame {
        interpolate_frame(&self.start, &self.end, share)
    }
}

/// The pose at a fraction of the way from one frame to another, at constant linear and angular velocity.
pub(super) fn interpolate_frame(start: &Frame, end: &Frame, share: f32) -> Frame {
    if start == end || share >= 1.0 {
        return *end;
    }
    let translation = start.translation + (end.translation - start.translation) * share;
    Frame { translation, rotation: interpolate(&start.rotation, &end.rotation, share) }
}

/// The rotation at a fraction of the way from one rotation to another.
///
/// `E Sᵀ` turns by `θ` about `n`, where `sinθ n` is half of its antisymmetric part and `1 + 2 cosθ` its trace. For a turn of π the antisymmetric part vanishes
/// and gives no axis: the rotation then stays at the start and jumps at the end.
fn interpolate(start: &Mat3, end: &Mat3, share: f32) -> Mat3 {
    let turn = *end * start.transpose();
    let (x, y, z) = (turn.x_axis, turn.y_axis, turn.z_axis);
    let sine = Vec3::new(y.z - z.y, z.x - x.z, x.y - y.x) * 0.5;
    let (length, cosine) = (sine.length(), 0.5 * (x.x + y.y + z.z - 1.0));
    if length <= 1e-7 {
        return *start;
    }
    let angle = libm::atan2f(length, cosine) * share;
    let (s, c, n) = (libm::sinf(angle), libm::cosf(angle), sine / length);
    let column = |v: Vec3| v * c + n.cross(v) * s + n * (n.dot(v) * (1.0 - c));
    Mat3::from_cols(column(start.x_axis), column(start.y_axis), column(start.z_axis))
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    #[test]
    fn it_goes_and_turns_evenly() {
        let end = Frame::new(Vec3::X * 4.0, Quat::from_xyzw(0.0, 1.0, 0.0, 1.0));
        let shape = Shape::sphere(1.0).unwrap();
        let collider = Collider::fixed(shape, Frame::IDENTITY).moving_to(end);
        let half = collider.frame_at(0.5);
        assert!((half.translation - Vec3::X * 2.0).length() < 1e-6);
        let eighth = core::f32::consts::FRAC_PI_8;
        let expected = Vec3::new(libm::cosf(2.0 * eighth), 0.0, -libm::sinf(2.0 * eighth));
        assert!((half.turn(Vec3::X) - expected).length() < 1e-6, "{}", half.turn(Vec3::X));
        assert!(half.is_valid());
        assert_eq!(collider.frame_at(1.0), end);
        assert_eq!(collider.frame_at(0.0), Frame::IDENTITY);
    }
}
