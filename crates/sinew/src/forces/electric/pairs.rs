//! All pairs of charges: exact, and in time that grows with the square of their number.
//!
//! Each pair is worked out once and counts for both, as the same bits with two signs: what the forces add up to is the round-off of the
//! sums, some 1e-6 of the largest force, and nothing else.

use super::columns::{Columns, Item, LANES};

/// Adds the force of every charge on every other.
pub(super) fn sum(columns: &mut Columns, softening: f32) {
    for first in (0..columns.len()).step_by(LANES) {
        let targets = columns.targets(first);
        let mut total = [[0.0; LANES]; 3];
        // Among themselves from both sides, since each of them is a target.
        for k in first..first + LANES {
            let forces = columns.forces_of(k, &targets, softening);
            add(&mut total, &forces);
        }
        for k in first + LANES..columns.len() {
            let forces = columns.forces_of(k, &targets, softening);
            add(&mut total, &forces);
            columns.react(k, &forces);
        }
        columns.add(first, &total);
    }
}

/// `Σ q_a q_b/√(‖d‖² + ε²)` over all pairs, C²/m. Charges at the same point without softening are left out.
pub(super) fn potential(items: &[Item], softening: f32) -> f64 {
    let softening = f64::from(softening) * f64::from(softening);
    let mut sum = 0.0;
    for (k, a) in items.iter().enumerate() {
        for b in &items[k + 1..] {
            let r2 = (a.at - b.at).length_squared() + softening;
            if r2 > 0.0 {
                sum += a.charge * b.charge / r2.sqrt();
            }
        }
    }
    sum
}

#[inline(always)]
pub(super) fn add(total: &mut [[f32; LANES]; 3], forces: &[[f32; LANES]; 3]) {
    // By index: an iterator over all at once is not turned into vector instructions.
    for axis in 0..3 {
        for l in 0..LANES {
            total[axis][l] += forces[axis][l];
        }
    }
}
