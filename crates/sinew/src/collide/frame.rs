//! Position and rotation of a rigid object: an orthonormal frame, in plain arithmetic that gives the same bits on every machine.

use glam::{Mat3, Quat, Vec3};

/// A rotation, then a translation: from local coordinates, such as those of a shape, to world coordinates, metres. Default: the identity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Position of the local origin, metres.
    pub translation: Vec3,
    /// Rotation matrix: its columns are the frame's axes, orthonormal and right-handed.
    pub rotation: Mat3,
}

impl Frame {
    /// At the origin, without rotation.
    pub const IDENTITY: Self = Self { translation: Vec3::ZERO, rotation: Mat3::IDENTITY };

    /// A frame at a position, without rotation.
    pub const fn at(translation: Vec3) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    /// A frame at a position with a rotation. The quaternion is normalised here, term by term, because the order of terms in glam differs between processors.
    /// One that cannot be normalised gives a frame that is not [valid](Self::is_valid).
    pub fn new(translation: Vec3, q: Quat) -> Self {
        let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
        let unit = Quat::from_xyzw(q.x / length, q.y / length, q.z / length, q.w / length);
        let rotation = if length.is_finite() && length > 0.0 {
            Mat3::from_quat(unit)
        } else {
            Mat3::from_diagonal(Vec3::NAN)
        };
        Self { translation, rotation }
    }

    /// Transforms a point from local to world coordinates.
    #[inline(always)]
    pub fn point(&self, local: Vec3) -> Vec3 {
        self.rotation * local + self.translation
    }

    /// Transforms a direction from local to world coordinates.
    #[inline(always)]
    pub fn turn(&self, local: Vec3) -> Vec3 {
        self.rotation * local
    }

    /// Transforms a point from world to local coordinates.
    #[inline(always)]
    pub fn local(&self, point: Vec3) -> Vec3 {
        self.turn_back(point - self.translation)
    }

    /// Transforms a direction from world to local coordinates.
    #[inline(always)]
    pub fn turn_back(&self, direction: Vec3) -> Vec3 {
        let Self { rotation: r, .. } = self;
        Vec3::new(r.x_axis.dot(direction), r.y_axis.dot(direction), r.z_axis.dot(direction))
    }

    /// The same frame relative to an origin, metres.
    #[inline(always)]
    pub fn seen_from(&self, origin: Vec3) -> Self {
        Self { translation: self.translation - origin, ..*self }
    }

    /// The world frame of an object that is at `inner` in this frame's coordinates: `self ∘ inner`.
    pub(crate) fn of(&self, inner: &Self) -> Self {
        let r = &inner.rotation;
        let rotation =
            Mat3::from_cols(self.turn(r.x_axis), self.turn(r.y_axis), self.turn(r.z_axis));
        Self { translation: self.point(inner.translation), rotation }
    }

    /// The world frame of a part of this object, which may have a frame of its own in it.
    #[inline(always)]
    pub(crate) fn of_part(&self, part: Option<&Self>) -> Self {
        part.map_or(*self, |part| self.of(part))
    }

    /// This frame in the coordinates of another: `other ∘ result = self`.
    #[inline(always)]
    pub fn from_within(&self, other: &Self) -> Self {
        let r = &self.rotation;
        let [x, y, z] = [r.x_axis, r.y_axis, r.z_axis];
        let rotation = Mat3::from_cols(other.turn_back(x), other.turn_back(y), other.turn_back(z));
        Self { translation: other.local(self.translation), rotation }
    }

    /// Whether all numbers are finite and the axes are orthonormal and right-handed, within 1e-3.
    pub fn is_valid(&self) -> bool {
        let Self { translation, rotation: r } = self;
        let near = |x: f32, y: f32| (x - y).abs() < 1e-3;
        translation.is_finite()
            && near(r.x_axis.length_squared(), 1.0)
            && near(r.y_axis.length_squared(), 1.0)
            && (r.x_axis.cross(r.y_axis) - r.z_axis).length_squared() < 1e-6
            && near(r.x_axis.dot(r.y_axis), 0.0)
    }
}

impl Default for Frame {
    fn default() -> Self {
        Self::IDENTITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_where_it_was() {
        let frame = Frame::new(Vec3::new(3.0, -4.0, 5.0), Quat::from_xyzw(1.0, -2.0, 0.5, 3.0));
        assert!(frame.is_valid());
        let point = Vec3::new(0.3, 0.2, -0.7);
        assert!((frame.local(frame.point(point)) - point).length() < 1e-5);
        let other = Frame::new(Vec3::ONE, Quat::from_xyzw(0.3, 0.1, -0.4, 1.0));
        let seen = frame.from_within(&other);
        assert!((other.point(seen.point(point)) - frame.point(point)).length() < 1e-5);
        let again = other.of(&seen);
        assert!(again.is_valid() && (again.point(point) - frame.point(point)).length() < 1e-5);
    }

    #[test]
    fn invalid_rotations_and_positions_are_detected() {
        assert!(!Frame::new(Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)).is_valid());
        assert!(!Frame::new(Vec3::NAN, Quat::IDENTITY).is_valid());
        let mirrored =
            Frame { rotation: Mat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0)), ..Frame::IDENTITY };
        assert!(!mirrored.is_valid());
    }
}
