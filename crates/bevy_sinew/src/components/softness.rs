//! How hard a constraint is: the solver's own type, with reflection.

use bevy::prelude::*;

use crate::same::same_variants;

/// How hard a constraint is enforced; the same at any number of sweeps and substeps.
///
/// ```
/// # use bevy_sinew::prelude::*;
/// # use bevy::prelude::*;
/// # fn soften(mut rods: Query<&mut DistanceConstraint>) {
/// for mut rod in &mut rods {
///     // Swings four times a second, and comes to rest without overshooting.
///     rod.softness = Softness::frequency(4.0, 1.0);
/// }
/// # }
/// ```
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Softness {
    /// Exactly, as far as the sweeps go. The default.
    #[default]
    Hard,
    /// As a damped spring with the energy `½ C²/compliance`: the lectures' spring of stiffness k has the compliance `1/k`.
    Compliant {
        /// Inverse stiffness, m/N where the constraint's value is a length; 0 is hard.
        compliance: f32,
        /// Force per rate of change, N·s/m where the value is a length.
        damping: f32,
    },
    /// As a damped spring of its own frequency, whatever the masses.
    Frequency {
        /// Undamped frequency, Hz, more than zero.
        hertz: f32,
        /// Damping ratio: 0 swings on, 1 is critical.
        ratio: f32,
    },
    /// The share of the error that a substep takes away, 0 to 1, in however many sweeps.
    Share(f32),
}

impl Softness {
    /// A spring of `hertz` Hz and damping ratio `ratio`.
    pub fn frequency(hertz: f32, ratio: f32) -> Self {
        Self::Frequency { hertz, ratio }
    }

    /// A compliance, m/N, without damping.
    pub fn compliant(compliance: f32) -> Self {
        sinew::Softness::compliant(compliance).into()
    }
}

same_variants!(Softness, sinew::Softness {
    Hard, Compliant { compliance, damping }, Frequency { hertz, ratio }, Share(share),
});
