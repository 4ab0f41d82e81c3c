//! Packed compliance: the softness of eight constraints, each of any kind, in one formula.

use crate::constraints::{Bound, Softness};
use crate::lanes::{LANES, Lanes};

/// The softness of eight constraints, without their compliance. Compliances mostly differ from constraint to constraint (that of a bend depends on its
/// triangles) and are stored with the constraints.
///
/// # One formula for every softness
///
/// `multiplier` in `softness.rs` has four formulas. Let `W` = `Σ w‖∇C‖²`, and let `U` be `W` for a frequency and 1 otherwise. With `Λ = U λ` as the sum over
/// the sweeps, all four are
///
/// ```text
/// Δλ = k (C - s Λ + γ ∇C·(q - p)) / ((1 + γ) W + s U)        ΔΛ = U Δλ
///
///                s                γ              k                  U
/// hard           0                0              1                  1
/// compliance     α/h²             αβ/h           1                  1
/// frequency      1/(2πf h)²       2ζ/(2πf h)     1                  W
/// share          0                0              1 - (1-k)^(1/n)    1
/// ```
///
/// The first two columns are numbers of the constraint over `h²` and `h`: its compliance (m/N, or s²) and its damping (s). Only a share needs a power, which is
/// computed once for consecutive batches with the same packed compliance.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PackedCompliance {
    /// αβ or 2ζ/(2πf), s.
    damping: [f32; LANES],
    /// The share of the error that a substep removes; 1 for other kinds of softness.
    share: [f32; LANES],
    /// 1 where `U` is `W`.
    by_weights: [f32; LANES],
    /// 1 where the multiplier is accumulated over the sweeps.
    accumulates: [f32; LANES],
    /// 1 for hard constraints.
    hard: [f32; LANES],
    /// 1 for ropes.
    at_most: [f32; LANES],
    /// 1 for struts.
    at_least: [f32; LANES],
    /// 1 for ranges, which are limits on both sides.
    range: [f32; LANES],
    /// All are hard and accumulate nothing: the formula is `C/W`.
    pub(super) plain: bool,
    /// All are hard.
    pub(super) all_hard: bool,
    /// Some are hard.
    pub(super) some_hard: bool,
    /// Some are damped and need their displacement since the start of the substep.
    pub(super) damped: bool,
    /// Some are frequencies.
    frequencies: bool,
    /// Some are shares.
    pub(super) shares: bool,
    /// Some are inequalities or ranges.
    pub(super) limited: bool,
}

/// The numerator of `s`: the compliance, m/N, or for a frequency 1/(2πf)², s²; see [`PackedCompliance`]. Zero for hard constraints and shares.
pub(super) fn compliance(softness: Softness) -> f32 {
    match softness {
        Softness::Compliant { compliance, .. } => compliance,
        Softness::Frequency { hertz, .. } => {
            let omega = core::f32::consts::TAU * hertz;
            1.0 / (omega * omega)
        }
        Softness::Hard | Softness::Share(_) => 0.0,
    }
}

fn damping(softness: Softness) -> f32 {
    match softness {
        Softness::Compliant { compliance, damping } => compliance * damping,
        Softness::Frequency { hertz, ratio } => 2.0 * ratio / (core::f32::consts::TAU * hertz),
        Softness::Hard | Softness::Share(_) => 0.0,
    }
}

fn is_frequency(softness: Softness) -> bool {
    matches!(softness, Softness::Frequency { .. })
}

/// The share of the error that each of eight constraints removes in a single sweep; kept as long as the packed compliance is the same.
pub(super) struct Shares {
    each: [f32; LANES],
    number: u32,
    sweeps: u32,
}

impl Shares {
    /// For a number of sweeps in a substep.
    #[inline(always)]
    pub(super) fn new(sweeps: u32) -> Self {
        Self { each: [1.0; LANES], number: u32::MAX, sweeps }
    }

    /// The shares of a packed compliance, given with its number.
    #[inline(always)]
    pub(super) fn of(&mut self, number: u32, packed: &PackedCompliance) -> &[f32; LANES] {
        if number != self.number {
            self.each = if packed.shares { packed.each(self.sweeps) } else { [1.0; LANES] };
            self.number = number;
        }
        &self.each
    }
}

impl PackedCompliance {
    pub(super) fn of(
        softness: [Softness; LANES],
        bound: [Bound; LANES],
        range: [bool; LANES],
    ) -> Self {
        let flags = |holds: [bool; LANES]| holds.map(|holds| f32::from(u8::from(holds)));
        let share = softness.map(|softness| match softness {
            Softness::Share(share) => share,
            _ => 1.0,
        });
        let damping = softness.map(damping);
        let all_hard = softness.iter().all(|softness| softness.is_hard());
        Self {
            damping,
            share,
            by_weights: flags(softness.map(is_frequency)),
            frequencies: softness.into_iter().any(is_frequency),
            accumulates: flags(softness.map(Softness::accumulates)),
            hard: flags(softness.map(Softness::is_hard)),
            at_most: flags(bound.map(|bound| bound == Bound::AtMost)),
            at_least: flags(bound.map(|bound| bound == Bound::AtLeast)),
            plain: all_hard && !softness.iter().any(|softness| softness.accumulates()),
            all_hard,
            some_hard: softness.iter().any(|softness| softness.is_hard()),
            damped: damping.iter().any(|&damping| damping != 0.0),
            shares: share.iter().any(|&share| share != 1.0),
            range: flags(range),
            limited: bound.iter().any(|&bound| bound != Bound::Equal) || range.contains(&true),
        }
    }

    /// The same softness, computed by the branches of the formula that another packed compliance takes. A term without effect may still change a result by an
    /// ulp, so a body in a batch must take the branches that it takes alone.
    pub(super) fn with_branches_of(self, other: &Self) -> Self {
        Self {
            frequencies: other.frequencies,
            plain: other.plain,
            all_hard: other.all_hard,
            damped: other.damped,
            shares: other.shares,
            limited: other.limited,
            ..self
        }
    }

    /// `1 - (1-k)^(1/n)` of each.
    #[cold]
    fn each(&self, sweeps: u32) -> [f32; LANES] {
        let mut each = [1.0; LANES];
        for lane in 0..LANES {
            each[lane] = if lane > 0 && self.share[lane] == self.share[lane - 1] {
                each[lane - 1]
            } else {
                1.0 - libm::powf(1.0 - self.share[lane], 1.0 / sweeps as f32)
            };
        }
        each
    }

    /// Mask of the inequalities that are satisfied.
    #[inline(always)]
    pub(super) fn holds<L: Lanes>(&self, value: L) -> L {
        let zero = L::zero();
        let below = flag::<L>(&self.at_most).and(value.le(zero));
        below.or(flag::<L>(&self.at_least).and(zero.le(value)))
    }

    /// What soft constraints count as among the errors of a sweep, metres, as `unfinished` in `equation.rs` does.
    #[inline(always)]
    pub(super) fn unfinished<L: Lanes>(&self, error: L, moved: L) -> L {
        if !self.shares {
            return moved;
        }
        let share = L::load(&self.share);
        share.lt(L::splat(1.0)).select(share * error, moved)
    }

    /// Mask of the hard constraints.
    #[inline(always)]
    pub(super) fn hard<L: Lanes>(&self) -> L {
        flag(&self.hard)
    }

    /// `Δλ` of each constraint, and its new accumulated multiplier. Not for [`plain`](Self::plain) ones: there `Δλ` is `value/weights` and the multiplier stays
    /// zero.
    ///
    /// An inequality only pushes one way, so its accumulated multiplier is clamped to that side of zero.
    #[inline(always)]
    pub(super) fn change<L: Lanes>(
        &self,
        input: &KernelInput<L>,
        compliance: &[f32; LANES],
        each: &[f32; LANES],
        h: f32,
    ) -> (L, L) {
        let KernelInput { value, weights, moved, multiplier } = *input;
        let one = L::splat(1.0);
        let s = L::load(compliance) * L::splat(1.0 / (h * h));
        let gamma = L::load(&self.damping) * L::splat(1.0 / h);
        let mut numerator = value - s * multiplier + gamma * moved;
        let mut unit = one;
        if self.frequencies {
            unit = flag::<L>(&self.by_weights).select(weights, one);
        }
        if self.shares {
            numerator = L::load(each) * numerator;
        }
        let mut change = numerator / ((one + gamma) * weights + s * unit);
        let mut summed = change * unit;
        if self.limited {
            let (zero, all) = (L::zero(), summed + multiplier);
            let range = flag::<L>(&self.range);
            let at_most = flag::<L>(&self.at_most).or(range.and(zero.lt(value)));
            let at_least = flag::<L>(&self.at_least).or(range.and(value.lt(zero)));
            let most = at_most.select(zero.max(all) - multiplier, summed);
            summed = at_least.select(zero.min(all) - multiplier, most);
            change = summed / unit;
        }
        (change, flag::<L>(&self.accumulates).and(multiplier + summed))
    }
}

/// The inputs of the formula at the current positions.
#[derive(Clone, Copy)]
pub(super) struct KernelInput<L> {
    /// `C`.
    pub(super) value: L,
    /// `Σ w‖∇C‖²`.
    pub(super) weights: L,
    /// `∇C·(q - p)`: how much `C` has changed in this substep. Only read for damped constraints.
    pub(super) moved: L,
    /// `Λ`, the multiplier accumulated so far.
    pub(super) multiplier: L,
}

/// Flags that are 1 or 0 as a mask.
#[inline(always)]
fn flag<L: Lanes>(flags: &[f32; LANES]) -> L {
    L::zero().lt(L::load(flags))
}
