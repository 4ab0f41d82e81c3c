//! Softness: how stiff a constraint is, in parameters that mean the same at any number of sweeps and substeps.

/// How stiffly a constraint is enforced.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Softness {
    /// Rigid, as far as the sweeps converge. The default.
    #[default]
    Hard,
    /// A damped spring with the energy `½ C²/α`, stable at any stiffness and step (Macklin et al., *XPBD*, 2016).
    Compliant {
        /// α, inverse stiffness: metres per newton where the constraint's value is a length; in general the value's unit squared per joule. Zero is hard. A
        /// spring of stiffness k has `1/k`.
        compliance: f32,
        /// β: force per rate of change of the value, N·s/m where that is a length. Zero is undamped.
        damping: f32,
    },
    /// A damped spring of a given frequency, whatever the masses: stiffness `μω²`, damping `2ζμω`, where μ is the effective mass of the constraint.
    Frequency {
        /// Undamped frequency `ω/2π`, Hz, more than zero.
        hertz: f32,
        /// Damping ratio ζ: 0 is undamped, 1 critical.
        ratio: f32,
    },
    /// Stiffness as in classic PBD: the share k of the error, 0 to 1, that a substep removes. Unlike the others it depends on the substep length, but not on
    /// the number of sweeps: each of n sweeps removes `1 - (1-k)^(1/n)`.
    Share(f32),
}

impl Softness {
    /// A compliance of `compliance` m/N without damping; hard if it is zero.
    pub fn compliant(compliance: f32) -> Self {
        if compliance == 0.0 { Self::Hard } else { Self::Compliant { compliance, damping: 0.0 } }
    }

    /// A spring of `stiffness` N/m and `damping` N·s/m.
    pub fn spring(stiffness: f32, damping: f32) -> Self {
        Self::Compliant { compliance: 1.0 / stiffness, damping }
    }

    /// A spring of `hertz` Hz and damping ratio `ratio`.
    pub fn frequency(hertz: f32, ratio: f32) -> Self {
        Self::Frequency { hertz, ratio }
    }

    /// Whether the constraint is fully hard.
    pub fn is_hard(self) -> bool {
        match self {
            Self::Hard => true,
            Self::Compliant { compliance, .. } => compliance == 0.0,
            Self::Frequency { .. } => false,
            Self::Share(share) => share == 1.0,
        }
    }

    /// Whether every number is finite and in range.
    pub fn is_valid(self) -> bool {
        let amount = |x: f32| x.is_finite() && x >= 0.0;
        match self {
            Self::Hard => true,
            Self::Compliant { compliance, damping } => amount(compliance) && amount(damping),
            Self::Frequency { hertz, ratio } => amount(hertz) && hertz > 0.0 && amount(ratio),
            Self::Share(share) => (0.0..=1.0).contains(&share),
        }
    }

    /// Energy stored at the constraint value `value`, J: `½ C²/α`; 0 for kinds without an energy. `weights` is `Σ w‖∇C‖²`.
    pub(crate) fn energy(self, value: f32, weights: f32) -> f32 {
        let stiffness = match self {
            Self::Hard | Self::Share(_) => 0.0,
            Self::Compliant { compliance, .. } if compliance > 0.0 => 1.0 / compliance,
            Self::Compliant { .. } => 0.0,
            Self::Frequency { hertz, .. } if weights > 0.0 => {
                let omega = core::f32::consts::TAU * hertz;
                omega * omega / weights
            }
            Self::Frequency { .. } => 0.0,
        };
        0.5 * stiffness * value * value
    }
}

/// The substep for which a softness is evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SubstepContext {
    /// Length of the substep, s.
    pub(crate) h: f32,
    /// Maximum number of sweeps in it.
    pub(crate) sweeps: u32,
}

/// The change of the multiplier by one projection.
///
/// XPBD, eqs. 18 and 26, with the sign of λ turned: with `α̃ = α/h²`, `γ = αβ/h` and `W = Σ w‖∇C‖²`,
///
/// ```text
/// Δλ = (C - α̃ λ + γ ∇C·(q - p)) / ((1 + γ) W + α̃)        particles move by -w ∇C Δλ
/// ```
///
/// This is one step of implicit Euler of the damped spring, however many sweeps repeat it within the substep. A frequency is the compliance `W/ω²` with the
/// damping `2ζω/W`, where μ = 1/W is the effective mass. `moved` is `∇C·(q - p)`, the change of `C` in this substep.
///
/// The sum accumulated over the sweeps is λ, or for a frequency `W λ`, the change of `C` that it made: `W` may change from sweep to sweep with the gradients,
/// and a λ accumulated at one `W` is not valid at another. [`Softness::unit`] converts a change of λ to a change of the sum.
#[inline]
pub(crate) fn multiplier(
    softness: Softness,
    substep_context: SubstepContext,
    value: f32,
    weights: f32,
    moved: f32,
    sum: f32,
) -> f32 {
    let (scaled, gamma) = match softness {
        Softness::Hard => return value / weights,
        Softness::Compliant { compliance, damping } => (
            compliance / (substep_context.h * substep_context.h),
            compliance * damping / substep_context.h,
        ),
        Softness::Frequency { hertz, ratio } => {
            let turn = core::f32::consts::TAU * hertz * substep_context.h;
            let (yielding, gamma) = (1.0 / (turn * turn), 2.0 * ratio / turn);
            let change = (value - yielding * sum + gamma * moved) / (1.0 + gamma + yielding);
            return change / weights;
        }
        Softness::Share(share) => {
            let each = 1.0 - libm::powf(1.0 - share, 1.0 / substep_context.sweeps as f32);
            return each * value / weights;
        }
    };
    (value - scaled * sum + gamma * moved) / ((1.0 + gamma) * weights + scaled)
}

impl Softness {
    /// The factor from a change of λ to a change of the accumulated sum: 1, or `W` for a frequency.
    #[inline]
    pub(crate) fn unit(self, weights: f32) -> f32 {
        if let Self::Frequency { .. } = self { weights } else { 1.0 }
    }

    /// Whether the multiplier is accumulated over the sweeps of a substep.
    #[inline]
    pub(crate) fn accumulates(self) -> bool {
        matches!(self, Self::Compliant { .. } | Self::Frequency { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_taken_once_however_many_sweeps_take_it() {
        for sweeps in [1, 4, 20] {
            let substep_context = SubstepContext { h: 0.01, sweeps };
            let mut left = 1.0;
            for _ in 0..sweeps {
                left -= multiplier(Softness::Share(0.7), substep_context, left, 1.0, 0.0, 0.0);
            }
            assert!((left - 0.3_f32).abs() < 1e-5, "{left}");
        }
    }

    #[test]
    fn sweeping_a_soft_constraint_again_changes_nothing() {
        let softness = Softness::Compliant { compliance: 0.01, damping: 3.0 };
        let (substep_context, weights) = (SubstepContext { h: 0.01, sweeps: 9 }, 2.0);
        // Value and displacement are both linear in λ: C = 1 - W λ, moved = 0.4 - W λ.
        let mut lambda = 0.0;
        for _ in 0..3 {
            let (value, moved) = (1.0 - weights * lambda, 0.4 - weights * lambda);
            lambda += multiplier(softness, substep_context, value, weights, moved, lambda);
        }
        let again = multiplier(
            softness,
            substep_context,
            1.0 - weights * lambda,
            weights,
            0.4 - weights * lambda,
            lambda,
        );
        assert!(again.abs() < 1e-7, "{again}");
    }

    #[test]
    fn numbers_out_of_range_are_not_valid() {
        assert!(!Softness::compliant(-1.0).is_valid());
        assert!(!Softness::frequency(0.0, 1.0).is_valid());
        assert!(!Softness::frequency(f32::NAN, 1.0).is_valid());
        assert!(!Softness::Share(1.1).is_valid());
        assert!(Softness::default().is_valid() && Softness::default().is_hard());
    }
}
