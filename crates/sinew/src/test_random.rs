//! Reproducible random numbers for tests.

use glam::Vec3;

/// A generator with the same numbers on every run: a 64-bit linear congruential generator (Knuth's constants), of which the upper bits are used.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 24 bits.
    fn bits(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 40
    }

    /// A number in 0..1.
    pub(crate) fn fraction(&mut self) -> f32 {
        self.bits() as f32 / (1 << 24) as f32
    }

    /// A number in -1..1.
    pub(crate) fn number(&mut self) -> f32 {
        self.bits() as f32 / (1 << 23) as f32 - 1.0
    }

    /// A whole number below `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.bits() as usize % end
    }

    /// A vector in the cube from -1 to 1.
    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// `count` points in that cube.
    pub(crate) fn positions(&mut self, count: usize) -> Vec<Vec3> {
        (0..count).map(|_| self.vector()).collect()
    }

    /// `count` masses from 0.25 to 4 kg, uniform in their logarithm.
    pub(crate) fn masses(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| libm::exp2f(2.0 * self.number())).collect()
    }
}
