//! All pairs of charges: exact, in quadratic time.
//!
//! Each pair is computed once and applied to both charges, with the same bits and opposite signs. So the forces add up to zero but for the round-off of the
//! sums, some 1e-6 of the largest force.
//!
//! # The order of the sums
//!
//! A source acts on eight targets, and the reaction on the source is the sum of eight lanes. Summing the lanes for every eight pairs would cost as much as the
//! forces. So each source of a block keeps eight sums, whose lanes are added when the block is done. The block size is such that sources and sums fit into the
//! L1 cache. The remaining latency is one root and one division for eight pairs.

use glam::{Vec3, Vec4};

use super::columns::{ChargeColumns, ChargedParticle, Targets, add};
use crate::lanes::{LANES, Lanes, Vector, kernel};

/// Sources in a block: 128 of them with their sums take 16 KiB, half of a common L1 cache.
const BLOCK: usize = 128;

/// `Σ q_a q_b/√(‖d‖² + ε²)` over all pairs, C²/m. Coincident charges without softening are left out.
pub(super) fn potential(items: &[ChargedParticle], softening: f32) -> f64 {
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

kernel!(
    /// Adds the force of every charge on every other.
    pub(super) fn sum<L: Lanes>(columns: &mut ChargeColumns, softening: f32) {
        let ChargeColumns { charges, origins, forces } = columns;
        let nothing = Vector::<L>::splat(Vec3::ZERO);
        let none = Source { charge: Vec4::ZERO, origin: Vec4::ZERO, back: nothing };
        let mut block = [none; BLOCK];
        for start in (0..charges.len()).step_by(BLOCK) {
            let end = (start + BLOCK).min(charges.len());
            let rows = charges[start..end].iter().zip(&origins[start..end]);
            for (source, (&charge, &origin)) in block.iter_mut().zip(rows) {
                *source = Source { charge, origin, back: nothing };
            }
            for first in (0..end).step_by(LANES) {
                let targets = Targets::<L>::of(charges, origins, first, softening);
                let mut total = nothing;
                // Pairs within the eight are computed from both sides, since each of them is a target.
                let own = if first < start { 0..0 } else { first - start..first - start + LANES };
                for source in &block[own.clone()] {
                    total += targets.forces_of(&source.charge, &source.origin);
                }
                for source in &mut block[own.end..end - start] {
                    let force = targets.forces_of(&source.charge, &source.origin);
                    total += force;
                    source.back -= force;
                }
                add(forces, first, total);
            }
            for (force, Source { back, .. }) in forces[start..end].iter_mut().zip(&block) {
                *force += Vec4::new(sum_of(back.x), sum_of(back.y), sum_of(back.z), 0.0);
            }
        }
    }
);

/// A source with the reaction accumulated on it, stored together. As separate columns they took up to twice the time, depending on their alignment in memory.
#[derive(Clone, Copy)]
struct Source<L> {
    charge: Vec4,
    origin: Vec4,
    /// Reaction of its targets on it, in eight sums.
    back: Vector<L>,
}

/// Sums the eight lanes, halves first.
#[inline(always)]
fn sum_of<L: Lanes>(lanes: L) -> f32 {
    let [a, b, c, d, e, f, g, h] = lanes.array();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
