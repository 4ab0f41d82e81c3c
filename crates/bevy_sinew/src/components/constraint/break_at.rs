//! When a constraint breaks.

use bevy::prelude::*;

/// Breaks a constraint, a spring or an attachment when it has to hold more than this: a chain that a weight tears, a cloth that rips, a hook that gives way.
///
/// It stands on a [`DistanceConstraint`](crate::DistanceConstraint), a [`Spring`](crate::Spring) or any other constraint, which is despawned when it
/// breaks; on an [`AttachTo`](crate::AttachTo), which then lets go; or on a body, and then it is meant for each of its constraints (and for an attachment on the body
/// itself), except for those that have their own. [`Broke`](crate::Broke) says what broke.
///
/// The force is that of the physics, whatever the number of substeps and of sweeps: it is what the solver did in a tick, in the mean over its substeps,
/// so that a rope that hangs at rest pulls at its hook with its weight. Constraints are looked at when a tick ends and what broke is gone in the next one;
/// with it go the [tethers](sinew::SolverSettings::long_range) that ran along it. A number that is not finite, or negative, never breaks anything.
///
/// What bodies with such constraints are solved by is slower, one constraint after the other ([`measure_loads`](sinew::Simulation::measure_loads)).
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
    /// The tension at which it breaks, N, or the pressure where it holds its ends apart ([`Bound::AtLeast`](crate::Bound)). Of an attachment the force
    /// between the two points; of any other constraint that on the first of its particles that is free. Default infinite: never.
    pub force: f32,
    /// How far it may be stretched, as a share of its rest length: 0.1 is by a tenth. What has no rest length has no strain. Cloth with such shows strains
    /// as the solver leaves them, where other large cloth has them limited to 3 %. Default infinite: never.
    pub strain: f32,
}

impl Default for BreakAt {
    fn default() -> Self {
        Self { force: f32::INFINITY, strain: f32::INFINITY }
    }
}

impl BreakAt {
    /// At a force, N.
    pub fn force(force: f32) -> Self {
        Self { force, ..default() }
    }

    /// At a strain, as a share of the rest length.
    pub fn strain(strain: f32) -> Self {
        Self { strain, ..default() }
    }
}
