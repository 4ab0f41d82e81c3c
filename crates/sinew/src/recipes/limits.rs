//! What numbers recipes accept.

use std::ops::RangeInclusive;

/// Lengths that a recipe accepts, metres. Squares, volumes and their inverses then stay inside `f32` with room to spare.
pub(super) const LENGTHS: RangeInclusive<f32> = 1e-6..=1e6;

/// Masses that a recipe accepts for a whole body, kilograms: a pollen grain to a mountain. Shared among as many particles as
/// there may be, each keeps an inverse that is an ordinary number.
pub(super) const MASSES: RangeInclusive<f32> = 1e-9..=1e12;

/// Most particles that a recipe makes: as far as `f32` counts without gaps.
pub(super) const MOST_PARTICLES: u64 = 1 << 24;

/// Whether `x` may be a compliance: metres per newton, 0 for a hard constraint.
pub(super) fn is_compliance(x: f32) -> bool {
    x.is_finite() && x >= 0.0
}
