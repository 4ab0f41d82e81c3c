//! Eight constraints of one kind, side by side: in which form they are kept, and how they are projected.

use core::slice::ChunksMut;

use super::compliance::{Asks, PackedCompliance, Shares, compliance};
use super::particle_access::{GatheredParticles, ParticleAccess};
use super::{each, less, load_sums, store_sums};
use crate::constraints::{Constraint, SubstepContext, Wide};
use crate::lanes::{LANES, Lanes, Vector, Work};
use crate::particles::Places;

/// One to eight constraints. Where there are fewer, the first stands there again: it computes the same and writes the same.
#[derive(Clone, Debug)]
pub(super) struct ConstraintBatch<W, const N: usize> {
    rows: [[u32; LANES]; N],
    pub(super) eight: WideConstraint<W>,
}

/// Eight constraints but for their particles.
#[derive(Clone, Debug)]
pub(super) struct WideConstraint<W> {
    kind: W,
    compliance: [f32; LANES],
    /// Which packed compliance they have.
    pub(super) packed_compliance: u32,
}

impl<W: Wide<N>, const N: usize> ConstraintBatch<W, N> {
    /// `None` if the kind of one is another, or has another kernel.
    pub(super) fn of(
        constraints: &[Constraint],
        compliances: &mut Vec<PackedCompliance>,
    ) -> Option<Self> {
        let mut eight = [&constraints[0]; LANES];
        let mut rows = [[0; LANES]; N];
        for (lane, one) in eight.iter_mut().enumerate() {
            *one = constraints.get(lane).unwrap_or(&constraints[0]);
            for (to, row) in rows.iter_mut().zip(W::rows(one)) {
                to[lane] = row;
            }
        }
        let (eight, packed_compliance) = WideConstraint::of(eight)?;
        let eight = WideConstraint {
            packed_compliance: super::number(compliances, packed_compliance),
            ..eight
        };
        Some(Self { rows, eight })
    }
}

impl<W> WideConstraint<W> {
    /// Eight constraints, and their packed compliance, which has no number yet.
    pub(super) fn of<const N: usize>(
        eight: [&Constraint; LANES],
    ) -> Option<(Self, PackedCompliance)>
    where
        W: Wide<N>,
    {
        let kind = W::of(eight)?;
        let (compliance, packed_compliance) = compliances_of(eight);
        Some((Self { kind, compliance, packed_compliance: 0 }, packed_compliance))
    }
}

/// What eight constraints of whatever kind yield by. Compiled once, not for each kind.
fn compliances_of(eight: [&Constraint; LANES]) -> ([f32; LANES], PackedCompliance) {
    let softness = eight.map(|c| c.kind.equation().softness());
    let bound = eight.map(|c| c.kind.equation().bound());
    (softness.map(compliance), PackedCompliance::of(softness, bound))
}

/// Projects blocks once, in their order; returns the largest error found, metres, of soft ones how far they moved. Without multipliers it measures:
/// nothing is moved, and what is returned is the largest error of the hard ones.
pub(super) struct SweepBatch<'a, 'b, W, const N: usize> {
    pub(super) blocks: &'a [ConstraintBatch<W, N>],
    pub(super) compliances: &'a [PackedCompliance],
    pub(super) places: &'a mut Places<'b>,
    /// Cut to a block each.
    pub(super) multipliers: Option<ChunksMut<'a, f32>>,
    pub(super) substep_context: SubstepContext,
}

impl<W: Wide<N>, const N: usize> Work for SweepBatch<'_, '_, W, N> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Self { blocks, compliances, places, mut multipliers, substep_context } = self;
        let mut shares = Shares::new(substep_context.sweeps);
        let mut worst = L::zero();
        for block in blocks {
            let multipliers = multipliers.as_mut().and_then(Iterator::next);
            let packed_compliance = &compliances[block.eight.packed_compliance as usize];
            let each = shares.of(block.eight.packed_compliance, packed_compliance);
            let mut room = [[0; LANES]; N];
            let rows = less(&block.rows, places.first, &mut room);
            let (position, start) = (&mut *places.position, &*places.start);
            let mut particles = GatheredParticles { rows, position, start };
            let context = (packed_compliance, each, substep_context.h, L::zero());
            worst =
                project::<L, W, N>(&block.eight, context, &mut particles, multipliers).max(worst);
        }
        worst.largest(0.0)
    }
}

/// What the equation says of eight constraints.
struct WideEvaluation<L, const N: usize> {
    value: L,
    /// Zero where there is nothing to be done.
    gradients: [Vector<L>; N],
    /// `Σ w‖∇C‖²`.
    weights: L,
    /// The value as a length, metres.
    error: L,
    /// Where there is something to be done, and can be.
    active: L,
}

/// Values, gradients and what follows: as `solve` in `equation.rs`.
///
/// Weights that are finite come of finite gradients; pinned particles alone leave zero, and nothing to be done.
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
    let error = if W::IS_LENGTH {
        size
    } else {
        L::splat(core::f32::consts::SQRT_2) * size / steepness.sqrt()
    };
    WideEvaluation { value, gradients, weights, error, active }
}

/// Where the particles are, and their inverse masses.
#[inline(always)]
fn load<L: Lanes, const N: usize>(particles: &impl ParticleAccess<N>) -> ([Vector<L>; N], [L; N]) {
    let mut points = [Vector::new(L::zero(), L::zero(), L::zero()); N];
    let mut inverse = [L::zero(); N];
    each!(i of N {
        (points[i], inverse[i]) = Vector::of(particles.now::<L>(i));
    });
    (points, inverse)
}

/// Eight constraints once, with their packed compliance, what each share is, the substep, seconds, and a mask of those of which nothing is asked:
/// what becomes of them does not matter. Returns the errors found; without multipliers those of the hard ones, and nothing is moved.
#[inline(always)]
pub(super) fn project<L: Lanes, W: Wide<N>, const N: usize>(
    eight: &WideConstraint<W>,
    (packed_compliance, each, h, aside): (&PackedCompliance, &[f32; LANES], f32, L),
    particles: &mut impl ParticleAccess<N>,
    multipliers: Option<&mut [f32]>,
) -> L {
    let (points, inverse) = load::<L, N>(particles);
    if W::IS_LIMIT && eight.kind.is_kept(&points).or(aside).all() {
        return L::zero();
    }
    let found = solve::<L, W, N>(&eight.kind, &points, &inverse);
    let WideEvaluation { value, gradients, weights, error, active } = found;
    // Limits are kept more often than not.
    if !aside.select(L::zero(), active).any() {
        return L::zero();
    }
    let Some(multipliers) = multipliers else {
        return packed_compliance.hard::<L>().and(active).and(error);
    };
    let zero = L::zero();
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
        let sum = load_sums::<L>(multipliers);
        let asks = Asks { value, weights, moved, sum };
        let (change, summed) = packed_compliance.change(&asks, &eight.compliance, each, h);
        let sound = active.and(change.abs().le(L::splat(f32::MAX)));
        store_sums(sound.select(summed, sum), multipliers);
        change
    };
    let change = active.and(change.abs().le(L::splat(f32::MAX))).and(change);
    let mut farthest = zero;
    // Backwards: a row that stands twice moves at its first place alone, which has the last word.
    each!(i of N backwards {
        let step = gradients[i] * (inverse[i] * change);
        particles.put(i, (points[i] - step).with(inverse[i]));
        farthest = step.length_squared().max(farthest);
    });
    // A soft one is not meant to be kept. It asks for another sweep as long as sweeps still move it.
    let error = if packed_compliance.all_hard {
        error
    } else {
        packed_compliance.hard::<L>().select(error, farthest.sqrt())
    };
    active.and(error)
}
