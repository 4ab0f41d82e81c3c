//! Ranges of the numbers that recipes accept.

use std::ops::RangeInclusive;

/// Lengths that a recipe accepts, metres. Their squares, volumes and inverses are well within the range of `f32`.
pub(super) const LENGTHS: RangeInclusive<f32> = 1e-6..=1e6;

/// Masses that a recipe accepts for a whole body, kg: from a pollen grain to a mountain. Even shared among the maximum number of particles, each particle's
/// inverse mass is a normal number.
pub(super) const MASSES: RangeInclusive<f32> = 1e-9..=1e12;

/// Maximum number of particles that a recipe makes: the largest up to which `f32` represents all integers.
pub(super) const MAX_PARTICLES: u64 = 1 << 24;

/// Whether `x` is a valid compliance: m/N, 0 for a hard constraint.
pub(super) fn is_compliance(x: f32) -> bool {
    x.is_finite() && x >= 0.0
}
