//! The camera: projection of points to the image, and rays back into the world.

use glam::{Vec3, Vec4};

/// A perspective camera; up is +Y.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Position of the camera.
    pub eye: Vec3,
    /// The point that it is directed at. The distance to it also sets the scale of the ground's squares and of its fading.
    pub target: Vec3,
    /// Vertical angle of view, in radians.
    pub fov: f32,
}

/// A camera with the values derived for one image size.
///
/// Depth is reversed (`near / distance`, so infinitely far is 0): with 32-bit floats that keeps precision over the whole range.
pub(crate) struct View {
    pub(crate) eye: Vec3,
    pub(crate) target: Vec3,
    /// From the eye to the target.
    pub(crate) distance: f32,
    /// Closest distance, along the view, that is drawn.
    pub(crate) near: f32,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half the width and half the height of the image plane at distance 1.
    scale: [f32; 2],
}

impl View {
    pub(crate) fn new(camera: &Camera, aspect: f32) -> Self {
        let forward = (camera.target - camera.eye).try_normalize().unwrap_or(Vec3::NEG_Z);
        let right = forward.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X);
        let distance = camera.eye.distance(camera.target).max(1e-3);
        let tangent = (camera.fov.clamp(0.01, 3.0) * 0.5).tan();
        Self {
            eye: camera.eye,
            target: camera.target,
            distance,
            near: distance * 0.01,
            right,
            up: right.cross(forward),
            forward,
            scale: [tangent * aspect, tangent],
        }
    }

    /// Clip coordinates of a world point; `w` is its distance along the view.
    #[inline]
    pub(crate) fn clip(&self, point: Vec3) -> Vec4 {
        let p = point - self.eye;
        let [sx, sy] = self.scale;
        Vec4::new(p.dot(self.right) / sx, p.dot(self.up) / sy, self.near, p.dot(self.forward))
    }

    /// Ray through the image position `x`, `y` (−1 to 1, y up): the eye plus this times a distance along the view direction is a world point.
    #[inline]
    pub(crate) fn ray(&self, x: f32, y: f32) -> Vec3 {
        self.forward + self.right * (x * self.scale[0]) + self.up * (y * self.scale[1])
    }

    /// A direction in view space: right, up, and away from the eye.
    pub(crate) fn turned(&self, direction: Vec3) -> Vec3 {
        Vec3::new(direction.dot(self.right), direction.dot(self.up), direction.dot(self.forward))
    }

    /// Half the height of the image plane at distance 1.
    pub(crate) fn half_height(&self) -> f32 {
        self.scale[1]
    }

    /// Distance along the view of a world point.
    #[inline]
    pub(crate) fn depth(&self, point: Vec3) -> f32 {
        (point - self.eye).dot(self.forward)
    }

    /// Size of one pixel in the world at distance 1, for an image with this many rows.
    pub(crate) fn pixel(&self, rows: usize) -> f32 {
        2.0 * self.scale[1] / rows.max(1) as f32
    }
}
