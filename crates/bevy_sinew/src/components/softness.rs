//! Softness of a constraint: the solver's type, with reflection.

use bevy::prelude::*;

use crate::same::same_variants;

/// How hard a constraint is enforced. All but [`Share`](Self::Share) mean the same at any number of sweeps and substeps.
///
/// ```
/// # use bevy_sinew::prelude::*;
/// # use bevy::prelude::*;
/// # fn soften(mut rods: Query<&mut DistanceConstraint>) {
/// for mut rod in &mut rods {
///     // A frequency of 4 Hz, critically damped: it returns without overshooting.
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
    /// As a damped spring with the energy `½ C²/compliance`, where `C` is the constraint's error. Stable at any stiffness and time step (XPBD). A spring of
    /// stiffness k has the compliance `1/k`.
    Compliant {
        /// Inverse stiffness, m/N if the constraint's value is a length; 0 is hard.
        compliance: f32,
        /// Damping: force per rate of change of the value, N·s/m if it is a length.
        damping: f32,
    },
    /// As a damped spring with a given frequency, whatever the masses.
    Frequency {
        /// Undamped frequency, Hz, greater than zero.
        hertz: f32,
        /// Damping ratio: 0 is undamped, 1 is critical.
        ratio: f32,
    },
    /// The fraction of the error that is corrected in a substep, 0 to 1, at any number of sweeps. Unlike the others it depends on the number of substeps: more
    /// of them make it stiffer.
    Share(f32),
}

impl Softness {
    /// A spring with a frequency, Hz, and a damping ratio.
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
