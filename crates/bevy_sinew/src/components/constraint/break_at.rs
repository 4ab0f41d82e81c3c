//! Limits at which a constraint breaks.

use bevy::prelude::*;

/// Breaks a constraint, a spring or an attachment when its load or its strain exceeds a limit: a chain that a weight tears, a cloth that rips, a hook that
/// gives way.
///
/// Put it on a [`DistanceConstraint`](crate::DistanceConstraint), a [`Spring`](crate::Spring) or any other constraint, which is despawned when it breaks; on an
/// [`AttachTo`](crate::AttachTo), which is then released; or on a body, where it applies to each of its constraints (and to an attachment on the body itself),
/// except for those that have their own. [`Broke`](crate::Broke) events report what broke.
///
/// The force is physical and does not depend on the number of substeps and sweeps: it is the force that the solver applied in a tick, averaged over its
/// substeps, so that a rope at rest pulls at its hook with its weight. Constraints are checked at the end of a tick, and what broke is gone in the next one,
/// together with the [tethers](sinew::SolverSettings::long_range) that ran along it. A limit that is not finite, or negative, never breaks anything.
///
/// Bodies with such constraints are solved more slowly, one constraint after the other ([`measure_loads`](sinew::Simulation::measure_loads)).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn spawn(mut commands: Commands) {
///     // Its own weight is 1 N; it holds 20 N.
///     let rope = Rope { mass: 0.1, ..Rope::between(Vec3::Y * 3.0, Vec3::Y) };
///     commands.spawn((rope, BreakAt::force(20.0))).observe(|broke: On<Broke>| {
///         info!("the rope broke at {} under {} N", broke.point, broke.force);
///     });
/// }
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins)).add_systems(Startup, spawn);
/// # app.finish();
/// # app.update();
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct BreakAt {
    /// The tension at which it breaks, N; for a strut ([`Bound::AtLeast`](crate::Bound)), the compression. For an attachment, the force between the two points;
    /// for any other constraint, the force on the first of its particles that is not pinned. Default infinite: never.
    pub force: f32,
    /// The elongation at which it breaks, as a fraction of the rest length: 0.1 is 10 %. A constraint without a rest length has no strain. Cloth with a strain
    /// limit shows the strains that the solver leaves, while other large cloth has its strain limited to 3 %. Default infinite: never.
    pub strain: f32,
}

impl Default for BreakAt {
    fn default() -> Self {
        Self { force: f32::INFINITY, strain: f32::INFINITY }
    }
}

impl BreakAt {
    /// Breaks at a force, N.
    pub fn force(force: f32) -> Self {
        Self { force, ..default() }
    }

    /// Breaks at a strain, as a fraction of the rest length.
    pub fn strain(strain: f32) -> Self {
        Self { strain, ..default() }
    }
}
