//! Converts bytes to numbers: mostly ordinary ones, so that a scenario makes progress, and often enough extreme ones.

use arbitrary::Unstructured;
use sinew::glam::Vec3;

/// Extreme values that validation has to handle.
const EXTREME: [f32; 20] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    -1e-45,
    0.0,
    -0.0,
    -1.0,
    1e30,
    -1e30,
    1e-30,
    1e18,
    1e-18,
    1e6,
    1e-6,
    16_777_216.0,
    1.0,
];

/// The bytes of a scenario. When they run out, all values are 0 and every list ends.
pub(crate) struct Input<'a>(Unstructured<'a>);

impl<'a> Input<'a> {
    pub(crate) fn new(data: &'a [u8]) -> Self {
        Self(Unstructured::new(data))
    }

    /// Whether no bytes are left.
    pub(crate) fn is_spent(&self) -> bool {
        self.0.is_empty()
    }

    /// One of `0..n`.
    pub(crate) fn below(&mut self, n: u32) -> u32 {
        self.0.int_in_range(0..=n.max(1) - 1).unwrap_or(0)
    }

    /// Any 32 bits.
    pub(crate) fn bits(&mut self) -> u32 {
        self.0.arbitrary().unwrap_or(0)
    }

    /// A random flag.
    pub(crate) fn flag(&mut self) -> bool {
        self.below(2) == 1
    }

    /// True once in `n`.
    pub(crate) fn rarely(&mut self, n: u32) -> bool {
        self.below(n) == n - 1
    }

    /// A number between -32 and 32 in steps of 1/1024, so that coincidences occur.
    pub(crate) fn ordinary(&mut self) -> f32 {
        f32::from(self.0.arbitrary::<i16>().unwrap_or(0)) / 1024.0
    }

    /// Ordinary and positive.
    pub(crate) fn positive(&mut self) -> f32 {
        (f32::from(self.0.arbitrary::<u16>().unwrap_or(0)) + 1.0) / 1024.0
    }

    /// Any number: ordinary, extreme, or any bits.
    pub(crate) fn any(&mut self) -> f32 {
        match self.below(16) {
            0..=9 => self.ordinary(),
            10..=13 => EXTREME[self.below(EXTREME.len() as u32) as usize],
            _ => f32::from_bits(self.bits()),
        }
    }

    /// A number from `good`, or, once in 16, any number.
    pub(crate) fn mostly(&mut self, good: impl FnOnce(&mut Self) -> f32) -> f32 {
        if self.rarely(16) { self.any() } else { good(self) }
    }

    /// Three ordinary numbers, or, once in 16, any three.
    pub(crate) fn vector(&mut self) -> Vec3 {
        if self.rarely(16) {
            Vec3::new(self.any(), self.any(), self.any())
        } else {
            Vec3::new(self.ordinary(), self.ordinary(), self.ordinary())
        }
    }
}
