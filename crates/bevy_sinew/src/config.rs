//! How hard the solver tries: configuration, as a resource that may be edited live, and what single bodies ask for beside it.

use bevy::prelude::*;
use sinew::{BodySettings, SolverSettings};

use crate::same::{same_fields, same_variants};

/// Settings of the solver for the whole world. Values outside their range are clamped to it.
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
    /// Substeps in a tick, 1 to 256. Default 10, which is meant for all that is soft. Boxes and ragdolls do with 4, in half the time;
    /// [`SolverSettings::substeps`] says what that costs.
    pub substeps: u32,
    /// The most sweeps over all constraints in a substep, 1 to 1000. Default 4. Large cloth takes them as [`microsteps`](Self::microsteps), and
    /// solid soft bodies that yield enough take one ([`BodySolver::single_sweep_below`]).
    pub max_sweeps: u32,
    /// Error in metres at which a substep stops sweeping early, 0 or more. Default 1e-4.
    pub tolerance: f32,
    /// Along which gradients hard distances and rigid shapes are corrected. Default to the nearest point.
    pub gradient_at: GradientAt,
    /// In which order constraints are enforced. Default one after the other.
    pub order: Order,
    /// How a step through time is made. Default Verlet.
    pub integrator: Integrator,
    /// The most that anything may move at, m/s: what is faster after a tick is slowed down to it. Default 500; zero is no limit.
    pub max_speed: f32,
    /// Whether what nothing outside holds keeps its angular momentum though corrections to the nearest point do not. Default so.
    pub keep_spin: bool,
    /// Whether hard distances are also held over long ranges ([`SolverSettings::long_range`](sinew::SolverSettings::long_range)): by long range attachments to
    /// pins, within large grid cloth, and in ropes by a direct solver. Cloth and ropes then do not stretch under their weight, in a wind, or by what hangs
    /// on them. Default so.
    pub long_range: bool,
    /// Whether large cloth takes its sweeps as smaller substeps of its own ([`SolverSettings::microsteps`](sinew::SolverSettings::microsteps)), which holds it
    /// as well at half of the work. Default so.
    pub microsteps: bool,
    /// Whether velocities are forgotten in every substep, so that everything walks to rest: the lectures' statics. Default not.
    pub statics: bool,
    /// Whether the time that each body takes is measured, for its [`BodyReport`](crate::BodyReport). Default not.
    pub timed: bool,
    /// Whether the threads of [`SinewWorkers`](crate::SinewWorkers) help. They never change a result. Default so.
    pub threads: bool,
}

/// What one body asks of the solver, where that differs from [`SolverConfig`]: put it onto the body. What is `None` is as in the world.
///
/// Bodies that constraints connect are solved together: with the most sweeps and the smallest tolerance that any of them asks for, along the start
/// of the step if all of them do, in the order that the first of them wants, and with their spin if any of them keeps it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{BodySolver};
/// # fn spawn(mut commands: Commands) {
/// // Stiffer than the rest of the world.
/// let solver = BodySolver { max_sweeps: Some(40), ..default() };
/// commands.spawn((Cloth::grid(1.0, 1.0, 16, 16), solver));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct BodySolver {
    /// The most sweeps in a substep, 1 to 1000.
    pub max_sweeps: Option<u32>,
    /// Substeps shorter than this, seconds, are swept once, whatever `max_sweeps` are: for what yields so much that a neighbour hardly moves it in so short a time. Solid
    /// soft bodies ask for it. Not positive or NaN: none are.
    pub single_sweep_below: Option<f32>,
    /// Error in metres at which sweeping stops early, 0 or more.
    pub tolerance: Option<f32>,
    /// The same as a speed, m/s, 0 or more: the error may be as large as what that goes in a substep, so that a body is as quiet with many substeps
    /// as with few ([`BodySettings`](sinew::BodySettings) says why). Where there is a `tolerance`, that counts.
    pub tolerance_speed: Option<f32>,
    /// Along which gradients it is corrected.
    pub gradient_at: Option<GradientAt>,
    /// In which order its constraints are enforced.
    pub order: Option<Order>,
    /// Whether it is given back the spin that sweeps take from it or give to it ([`SolverConfig::keep_spin`]).
    pub keep_spin: Option<bool>,
    /// How fast what its particles do against each other dies away, 1/s, 0 and up: friction in its joints, or in its stuff. It falls, flies and spins
    /// as without. A negative or non-finite one counts as 0. Default 0; recipes may ask for some.
    pub damping: f32,
}

/// Along which gradient a hard distance or a rigid shape is corrected.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum GradientAt {
    /// To the nearest point. Robust; bleeds spin. The default.
    #[default]
    Current,
    /// Along the gradient at the start of the substep (SHAKE): keeps spin and energy. Boxes ask for it.
    StepStart,
}

/// How the solver goes through the constraints of a body.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Order {
    /// One after the other, again and again (Gauss–Seidel). The default.
    #[default]
    GaussSeidel,
    /// Always the one that is violated most; pays below some 200 constraints.
    MostViolatedFirst,
    /// All from the same positions, each particle to the mean of what is asked of it; converges slowly.
    Jacobi,
}

/// How a world steps through time. [`sinew::integrate`] compares them.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Integrator {
    /// Order 2, keeps energy. The default.
    #[default]
    Verlet,
    /// Order 2: kick, drift, kick.
    Leapfrog,
    /// Order 1, bounded energy.
    SemiImplicitEuler,
    /// Order 1, gains energy on what swings. To compare with.
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
            // Set from the component of that name.
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
