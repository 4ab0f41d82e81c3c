//! Eight constraints of one kind: how they are stored, and how they are projected.

use super::compliance::{KernelInput, PackedCompliance, compliance};
use super::particle_access::ParticleAccess;
use super::{KernelContext, WideKernel, each, load_multipliers, store_multipliers};
use crate::constraints::{Constraint, FromKind, Wide};
use crate::lanes::{LANES, Lanes, Vector};

/// Eight constraints without their particles.
#[derive(Clone, Debug)]
pub(super) struct WideConstraint<W> {
    kind: W,
    compliance: [f32; LANES],
}

impl<W> WideConstraint<W> {
    /// Eight constraints, and their packed compliance; `None` if their kinds differ.
    pub(super) fn of<const N: usize>(
        eight: [&Constraint; LANES],
    ) -> Option<(Self, PackedCompliance)>
    where
        W: Wide<N, Kind: FromKind>,
    {
        let mut kinds = [W::Kind::from_kind(&eight[0].kind)?; LANES];
        for (to, one) in kinds.iter_mut().zip(eight) {
            *to = W::Kind::from_kind(&one.kind)?;
        }
        let kind = W::of(kinds, eight.map(|c| c.rows.len()));
        let (compliance, packed_compliance) = compliances_of(eight);
        Some((Self { kind, compliance }, packed_compliance))
    }
}

/// The compliances of eight constraints of any kind. Not generic, so that it is compiled once rather than for each kind.
fn compliances_of(eight: [&Constraint; LANES]) -> ([f32; LANES], PackedCompliance) {
    let softness = eight.map(|c| c.kind.equation().softness());
    let bound = eight.map(|c| c.kind.equation().bound());
    let range = eight.map(|c| c.kind.equation().is_range());
    (softness.map(compliance), PackedCompliance::of(softness, bound, range))
}

/// The values and gradients of eight constraints, with sums derived from them.
struct WideEvaluation<L, const N: usize> {
    value: L,
    /// Zero in inactive lanes.
    gradients: [Vector<L>; N],
    /// `Σ w‖∇C‖²`.
    weights: L,
    /// `Σ ‖∇C‖²`.
    steepness: L,
    /// Mask of the lanes in which a correction is needed and possible.
    active: L,
}

impl<L: Lanes, const N: usize> WideEvaluation<L, N> {
    /// The values as lengths, metres.
    #[inline(always)]
    fn error<W: Wide<N>>(&self) -> L {
        let size = self.value.abs();
        if W::IS_LENGTH {
            size
        } else {
            L::splat(core::f32::consts::SQRT_2) * size / self.steepness.sqrt()
        }
    }
}

/// Evaluates eight constraints, as `solve` in `equation.rs` does for one.
///
/// Finite weights imply finite gradients. If all particles are pinned, the weights are zero and the lane is inactive.
#[inline(always)]
fn solve<L: Lanes, W: Wide<N>, const N: usize>(
    kind: &W,
    points: &[Vector<L>; N],
    inverse: &[L; N],
) -> WideEvaluation<L, N> {
    let (value, mut gradients) = kind.evaluate(points);
    let (zero, most) = (L::zero(), L::splat(f32::MAX));
    let (mut weights, mut steepness) = (zero, zero);
    each!(i of N {
        let square = gradients[i].length_squared();
        steepness = steepness + square;
        weights = weights + inverse[i] * square;
    });
    let size = value.abs();
    let sound = zero.lt(size).and(size.le(most));
    let active = sound.and(zero.lt(weights)).and(weights.le(most));
    if !active.all() {
        each!(i of N {
            let Vector { x, y, z } = gradients[i];
            gradients[i] = Vector::new(active.and(x), active.and(y), active.and(z));
        });
    }
    WideEvaluation { value, gradients, weights, steepness, active }
}

/// Positions and inverse masses.
#[inline(always)]
fn load<L: Lanes, const N: usize>(particles: &impl ParticleAccess<N>) -> ([Vector<L>; N], [L; N]) {
    let mut points = [Vector::new(L::zero(), L::zero(), L::zero()); N];
    let mut inverse = [L::zero(); N];
    each!(i of N {
        (points[i], inverse[i]) = Vector::of(particles.now::<L>(i));
    });
    (points, inverse)
}

impl<W: Wide<N>, const N: usize> WideKernel<N> for WideConstraint<W> {
    #[inline(always)]
    fn project<L: Lanes>(
        &self,
        (packed_compliance, each, h, inactive): KernelContext<L>,
        particles: &mut impl ParticleAccess<N>,
        multipliers: Option<&mut [f32]>,
    ) -> (L, L) {
        let zero = L::zero();
        let (points, inverse) = load::<L, N>(particles);
        if W::IS_LIMIT && self.kind.is_kept(&points).or(inactive).all() {
            return (zero, zero);
        }
        let found = solve::<L, W, N>(&self.kind, &points, &inverse);
        let WideEvaluation { value, gradients, weights, active, .. } = found;
        // Limits are satisfied most of the time.
        if !inactive.select(zero, active).any() {
            return (zero, zero);
        }
        let Some(multipliers) = multipliers else {
            let error = found.error::<W>();
            return (packed_compliance.hard::<L>().and(active).and(error), zero);
        };
        let change = if packed_compliance.plain {
            value / weights
        } else {
            let mut moved = zero;
            if packed_compliance.damped {
                each!(i of N {
                    let (start, _) = Vector::of(particles.start::<L>(i));
                    moved = moved + gradients[i].dot(points[i] - start);
                });
            }
            let multiplier = load_multipliers::<L>(multipliers);
            let input = KernelInput { value, weights, moved, multiplier };
            let (change, summed) = packed_compliance.change(&input, &self.compliance, each, h);
            let sound = active.and(change.abs().le(L::splat(f32::MAX)));
            store_multipliers(sound.select(summed, multiplier), multipliers);
            change
        };
        let change = active.and(change.abs().le(L::splat(f32::MAX))).and(change);
        let mut farthest = zero;
        // Backwards: where a row occurs twice, the write at its first place comes last and is the one that counts.
        each!(i of N backwards {
            let step = gradients[i] * (inverse[i] * change);
            particles.put(i, (points[i] - step).with(inverse[i]));
            farthest = step.length_squared().max(farthest);
        });
        let error = if packed_compliance.all_hard {
            found.error::<W>()
        } else if packed_compliance.some_hard || packed_compliance.shares {
            let error = found.error::<W>();
            let soft = packed_compliance.unfinished(error, farthest.sqrt());
            packed_compliance.hard::<L>().select(error, soft)
        } else {
            farthest.sqrt()
        };
        (active.and(error), zero)
    }
}
