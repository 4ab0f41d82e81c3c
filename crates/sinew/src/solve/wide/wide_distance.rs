//! Eight distances: compliant ones, ropes and struts. Hard equalities are rods, with kernels of their own.

use super::compliance::{KernelInput, PackedCompliance, compliance};
use super::particle_access::ParticleAccess;
use super::{KernelContext, WideKernel, load_multipliers, store_multipliers};
use crate::constraints::{Bound, Distance};
use crate::lanes::{LANES, Lanes, Vector};

/// Eight distances without their particles.
#[derive(Clone, Debug)]
pub(super) struct WideDistance {
    rest: [f32; LANES],
    compliance: [f32; LANES],
    /// For struts, the square of a length that is safely above the rest length, m²; infinite for others.
    satisfied_above: [f32; LANES],
}

impl WideDistance {
    /// Eight distances, and their packed compliance.
    pub(super) fn of(eight: [&Distance; LANES]) -> (Self, PackedCompliance) {
        let packed_compliance =
            PackedCompliance::of(eight.map(|d| d.softness), eight.map(|d| d.bound), [false; LANES]);
        let (rest, compliance) = (eight.map(|d| d.rest), eight.map(|d| compliance(d.softness)));
        (Self { rest, compliance, satisfied_above: eight.map(satisfied_above) }, packed_compliance)
    }
}

/// The square of a length, m², above which a strut is satisfied despite any rounding on the way. At least 1e-30, since smaller squares do not have all their
/// digits.
fn satisfied_above(distance: &Distance) -> f32 {
    match distance.bound {
        Bound::AtLeast => (distance.rest * distance.rest * (1.0 + 1e-5)).max(1e-30),
        _ => f32::INFINITY,
    }
}

/// The scalar counterpart is [`project`](crate::constraints::project). With `n = d/‖d‖`, `d = a - b`, the gradients are `±n`, so `Σ w‖∇C‖² = w_a + w_b`.
/// Coincident ends are pushed apart along the x axis, `a` towards +x.
impl WideKernel<2> for WideDistance {
    #[inline(always)]
    fn project<L: Lanes>(
        &self,
        (packed_compliance, each, h, inactive): KernelContext<L>,
        particles: &mut impl ParticleAccess<2>,
        multipliers: Option<&mut [f32]>,
    ) -> (L, L) {
        let (a, wa) = Vector::of(particles.now::<L>(0));
        let (b, wb) = Vector::of(particles.now::<L>(1));
        let (zero, one, most) = (L::zero(), L::splat(1.0), L::splat(f32::MAX));
        let d = a - b;
        let Some(multipliers) = multipliers else {
            return remaining_errors(self, packed_compliance, d.length(), wa + wb);
        };
        // Struts between limbs are satisfied most of the time, which can be tested without a square root.
        let square = d.length_squared();
        if packed_compliance.plain && L::load(&self.satisfied_above).lt(square).or(inactive).all() {
            return (zero, zero);
        }
        let length = square.sqrt();
        let value = length - L::load(&self.rest);
        let weights = wa + wb;
        let multiplier =
            if packed_compliance.plain { zero } else { load_multipliers::<L>(multipliers) };
        let mut active = zero.lt(weights).and(weights.le(most)).and(value.abs().le(most));
        let mut holds = zero;
        if packed_compliance.limited {
            holds = packed_compliance.holds(value);
            active = multiplier.same(zero).and(holds).select(zero, active);
        }
        if !inactive.select(zero, active).any() {
            return (zero, zero);
        }
        let parted = zero.lt(length);
        let inverse = one / length;
        let n = Vector {
            x: parted.select(d.x * inverse, one),
            y: parted.and(d.y * inverse),
            z: parted.and(d.z * inverse),
        };
        let change = if packed_compliance.plain {
            value / weights
        } else {
            let mut moved = zero;
            if packed_compliance.damped {
                let (from, _) = Vector::of(particles.start::<L>(0));
                let (to, _) = Vector::of(particles.start::<L>(1));
                moved = n.dot(d - (from - to));
            }
            let input = KernelInput { value, weights, moved, multiplier };
            let (change, summed) = packed_compliance.change(&input, &self.compliance, each, h);
            let sound = active.and(change.abs().le(most));
            store_multipliers(sound.select(summed, multiplier), multipliers);
            change
        };
        active = active.and(change.abs().le(most));
        let (to_a, to_b) = (wa * change, wb * change);
        let moved_a = (a - n * to_a).or_else(active, a);
        let moved_b = (b + n * to_b).or_else(active, b);
        particles.put(0, moved_a.with(wa));
        particles.put(1, moved_b.with(wb));
        let mut hard = value.abs();
        if packed_compliance.limited {
            hard = holds.select(zero, hard);
        }
        let soft = packed_compliance.unfinished(value.abs(), (change * weights).abs());
        let error = if packed_compliance.all_hard {
            hard
        } else if packed_compliance.some_hard {
            packed_compliance.hard::<L>().select(hard, soft)
        } else {
            soft
        };
        (active.and(error), zero)
    }
}

/// The errors of the hard ones of eight distances with the current lengths `length`: in metres, and as shares of their rest lengths.
#[inline(always)]
fn remaining_errors<L: Lanes>(
    eight: &WideDistance,
    packed_compliance: &PackedCompliance,
    length: L,
    weights: L,
) -> (L, L) {
    let rest = L::load(&eight.rest);
    let value = length - rest;
    let counted = packed_compliance.hard::<L>().and(L::zero().lt(weights));
    let error = packed_compliance.holds(value).select(L::zero(), value.abs());
    let left = counted.and(error);
    (left, L::zero().lt(rest).and(left / rest))
}
