//! Settings of the solver: a resource for the world, and a component for single bodies. Both may be edited at any time.

use bevy::prelude::*;
use sinew::{BodySettings, SolverSettings};

use crate::same::{same_fields, same_variants};

/// Settings of the solver for the whole world. Values outside their range are clamped.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins));
/// app.insert_resource(SolverConfig { substeps: 20, ..default() });
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct SolverConfig {
    /// Substeps in a tick, 1 to 256. More of them make everything stiffer and more accurate, and are preferable to more sweeps. Default 10, which is meant for
    /// cloth, ropes and soft bodies. Boxes and ragdolls need only 4, in two thirds to three quarters of the time; [`SolverSettings::substeps`] lists what that
    /// costs in accuracy.
    pub substeps: u32,
    /// The maximum number of sweeps (passes over all constraints) in a substep, 1 to 1000. Default 4. Large cloth uses them as
    /// [`microsteps`](Self::microsteps), and solid soft bodies that are soft enough are swept once ([`BodySolver::single_sweep_below`]).
    pub max_sweeps: u32,
    /// Error, metres, at which a substep stops sweeping early, 0 or more. Default 1e-4.
    pub tolerance: f32,
    /// At which positions the gradients of hard distances and rigid shapes are evaluated. Default [`GradientAt::Current`].
    pub gradient_at: GradientAt,
    /// In which order constraints are solved. Default [`Order::GaussSeidel`].
    pub order: Order,
    /// How particles are integrated. Default [`Integrator::Verlet`].
    pub integrator: Integrator,
    /// Maximum speed, m/s: a particle that is faster after a tick is slowed down to it. Default 500; zero is no limit.
    pub max_speed: f32,
    /// Whether bodies that nothing else holds keep their angular momentum, and those that hang on one or two pinned particles keep swinging, although corrections
    /// with [`GradientAt::Current`] lose some. Default true.
    pub keep_spin: bool,
    /// Whether hard distances are also solved over long ranges ([`SolverSettings::long_range`](sinew::SolverSettings::long_range)): by long range attachments
    /// to pins, by spans within large grid cloth, and in ropes by a direct solver. Cloth and ropes then do not stretch under their weight, in a wind, or under
    /// a load. Default true.
    pub long_range: bool,
    /// Whether large cloth uses its sweeps as smaller substeps of its own ([`SolverSettings::microsteps`](sinew::SolverSettings::microsteps)), which is as
    /// accurate at half the cost. Default true.
    pub microsteps: bool,
    /// Whether velocities are set to zero in every substep, so that everything moves to its rest state. Default false. To find a rest state once, use
    /// [`Relax`](crate::Relax).
    pub statics: bool,
    /// Whether the time that each body takes is measured, for its [`BodyReport`](crate::BodyReport). Default false.
    pub timed: bool,
    /// Whether the threads of [`SinewWorkers`](crate::SinewWorkers) are used. They never change a result. Default true.
    pub threads: bool,
}

/// Settings of the solver for one body, which override [`SolverConfig`]: put it on the body. A field that is `None` has the value of the world.
///
/// Bodies that constraints connect are solved together. They use the most sweeps and the smallest tolerance of any of them, [`GradientAt::StepStart`] if all of
/// them do, the order of the one that was created first, and `keep_spin` if any of them has it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{BodySolver};
/// # fn spawn(mut commands: Commands) {
/// // Cloth that is solved more accurately than the rest of the world.
/// let solver = BodySolver { max_sweeps: Some(40), ..default() };
/// commands.spawn((Cloth::grid(1.0, 1.0, 16, 16), solver));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct BodySolver {
    /// The maximum number of sweeps in a substep, 1 to 1000.
    pub max_sweeps: Option<u32>,
    /// Substeps shorter than this, seconds, are swept once, whatever `max_sweeps` is: for bodies so soft that a particle is hardly moved by its neighbours in
    /// so short a time. Solid soft bodies set it. If it is not positive or NaN, no substep is affected.
    pub single_sweep_below: Option<f32>,
    /// Error, metres, at which sweeping stops early, 0 or more.
    pub tolerance: Option<f32>,
    /// The tolerance as a speed, m/s, 0 or more: the error may be as large as the distance at that speed in a substep, so that a body is as still with many
    /// substeps as with few ([`BodySettings`](sinew::BodySettings) explains why). A `tolerance` takes precedence.
    pub tolerance_speed: Option<f32>,
    /// At which positions the gradients of its hard distances and rigid shapes are evaluated.
    pub gradient_at: Option<GradientAt>,
    /// In which order its constraints are solved.
    pub order: Option<Order>,
    /// Whether the angular momentum that sweeps take from it or add to it is corrected ([`SolverConfig::keep_spin`]).
    pub keep_spin: Option<bool>,
    /// Damping rate of the motion of its particles relative to each other, 1/s, 0 or more: friction in its joints, or internal friction. Its fall, flight and
    /// spin are not affected. A negative or non-finite value counts as 0. Default 0; some recipes set it.
    pub damping: f32,
}

/// At which positions the gradient of a hard distance or a rigid shape is evaluated: the direction in which it is corrected.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum GradientAt {
    /// At the current positions: a projection to the nearest point. Robust, but loses spin. The default.
    #[default]
    Current,
    /// At the start of the substep (SHAKE): keeps spin and energy. Boxes use it.
    StepStart,
}

/// In which order the constraints of a body are solved.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Order {
    /// One after the other, each from the result of the one before it, in repeated sweeps (Gauss–Seidel). The default.
    #[default]
    GaussSeidel,
    /// Always the constraint with the largest error; faster than the default below about 200 constraints.
    MostViolatedFirst,
    /// All from the same positions; each particle moves to the mean of its corrections. Converges slowly.
    Jacobi,
}

/// How particles are integrated over time. [`sinew::integrate`] compares the integrators.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Integrator {
    /// Second order, keeps energy. The default.
    #[default]
    Verlet,
    /// Second order: kick, drift, kick.
    Leapfrog,
    /// First order, bounded energy.
    SemiImplicitEuler,
    /// First order, gains energy in oscillations. For comparison.
    ExplicitEuler,
}

impl Default for SolverConfig {
    fn default() -> Self {
        SolverSettings::default().into()
    }
}

same_fields!(SolverConfig, SolverSettings {
    substeps, max_sweeps, tolerance, gradient_at, order, integrator, max_speed, keep_spin, long_range, microsteps, statics, timed,
} own { threads: true });
same_variants!(GradientAt, sinew::GradientAt { Current, StepStart });
same_variants!(Order, sinew::Order { GaussSeidel, MostViolatedFirst, Jacobi });
same_variants!(
    Integrator,
    sinew::Integrator { Verlet, Leapfrog, SemiImplicitEuler, ExplicitEuler }
);

impl From<BodySolver> for BodySettings {
    fn from(body: BodySolver) -> Self {
        Self {
            max_sweeps: body.max_sweeps,
            single_sweep_below: body.single_sweep_below,
            tolerance: body.tolerance,
            tolerance_speed: body.tolerance_speed,
            gradient_at: body.gradient_at.map(Into::into),
            order: body.order.map(Into::into),
            keep_spin: body.keep_spin,
            damping: body.damping,
            // Set from the `Representation` component.
            representation: sinew::Representation::default(),
        }
    }
}

impl From<BodySettings> for BodySolver {
    fn from(settings: BodySettings) -> Self {
        Self {
            max_sweeps: settings.max_sweeps,
            single_sweep_below: settings.single_sweep_below,
            tolerance: settings.tolerance,
            tolerance_speed: settings.tolerance_speed,
            gradient_at: settings.gradient_at.map(Into::into),
            order: settings.order.map(Into::into),
            keep_spin: settings.keep_spin,
            damping: settings.damping,
        }
    }
}
