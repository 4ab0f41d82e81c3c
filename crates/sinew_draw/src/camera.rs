//! The eye: which point lands where on the picture, and the way back.

use glam::{Vec3, Vec4};

/// A perspective camera; up is +Y.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Where it stands.
    pub eye: Vec3,
    /// What it looks at. The distance also sets the scale of the ground's squares and of its fading.
    pub target: Vec3,
    /// Vertical angle of view, in radians.
    pub fov: f32,
}

/// A camera made ready for one picture size.
///
/// Depth is reversed (`near / distance`, so far is 0): with 32-bit floats that keeps precision over the whole range.
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
    /// Half the picture's height, at distance 1, is this fraction of 1; the same for the width.
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

    /// What `x` and `y` (-1 to 1, up) look along: the eye plus this times a distance along the view is a world point.
    #[inline]
    pub(crate) fn ray(&self, x: f32, y: f32) -> Vec3 {
        self.forward + self.right * (x * self.scale[0]) + self.up * (y * self.scale[1])
    }

    /// A direction as the eye has it: to the right, up, and away.
    pub(crate) fn turned(&self, direction: Vec3) -> Vec3 {
        Vec3::new(direction.dot(self.right), direction.dot(self.up), direction.dot(self.forward))
    }

    /// Half the picture's height at distance 1.
    pub(crate) fn half_height(&self) -> f32 {
        self.scale[1]
    }

    /// Distance along the view of a world point.
    #[inline]
    pub(crate) fn depth(&self, point: Vec3) -> f32 {
        (point - self.eye).dot(self.forward)
    }

    /// Size in the world of one pixel, at distance 1, in a picture with this many rows.
    pub(crate) fn pixel(&self, rows: usize) -> f32 {
        2.0 * self.scale[1] / rows.max(1) as f32
    }
}
