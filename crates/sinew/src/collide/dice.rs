//! Pseudo-random numbers of the tests, the same in every run: a 64-bit linear congruential generator (Knuth's constants), of which the upper bits are used.

use glam::{Quat, Vec3};

use super::Frame;

/// A generator with its state.
pub(super) struct Dice(pub(super) u64);

impl Dice {
    /// From -1 to 1.
    pub(super) fn roll(&mut self) -> f32 {
        2.0 * self.share() - 1.0
    }

    /// From 0 to 1.
    pub(super) fn share(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    /// A point in the cube from -1 to 1.
    pub(super) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.roll(), self.roll(), self.roll())
    }

    /// A frame with a uniformly distributed rotation.
    pub(super) fn frame(&mut self, spread: f32) -> Frame {
        loop {
            let q = Quat::from_xyzw(self.roll(), self.roll(), self.roll(), self.roll());
            let square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
            if square < 1.0 && square > 0.01 {
                return Frame::new(self.vector() * spread, q);
            }
        }
    }
}
