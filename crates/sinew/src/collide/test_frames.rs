//! Reproducible random frames for the tests of contacts.

use glam::Quat;

use super::Frame;
use crate::test_random::Random;

impl Random {
    /// A frame with a uniformly distributed rotation.
    pub(super) fn frame(&mut self, spread: f32) -> Frame {
        loop {
            let q = Quat::from_xyzw(self.number(), self.number(), self.number(), self.number());
            let square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
            if square < 1.0 && square > 0.01 {
                return Frame::new(self.vector() * spread, q);
            }
        }
    }
}
