//! Configuration of the solver: for a world, and for single bodies in it.

use crate::constraints::GradientAt;
use crate::integrate::Integrator;

/// In which order the solver enforces the constraints of an island.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// Gauss–Seidel: one constraint after the other, colour by colour, in repeated sweeps; the lectures' cascade. The default.
    #[default]
    GaussSeidel,
    /// The most violated constraint first, each time. A heap finds it, which pays below some 200 constraints.
    MostViolatedFirst,
    /// Jacobi: all constraints are evaluated at the same positions, and each particle moves by the mean of its corrections. The order does not matter; it
    /// converges slowly.
    Jacobi,
}

/// Configuration of the solver. Every number has a documented range and is clamped to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings {
    /// Substeps in a step, 1 to 256, default 10. At equal work many substeps with few sweeps are more accurate than one step with many.
    ///
    /// What matters is their number per second: the default is meant for ticks of 1/60 s, and at 240 ticks a second 3 do as well. More are not always better:
    /// positions are rounded to some 3e-8 of their distance from the body's origin, and a rounding error per substep is a speed. A cloth of 1 m that hangs at
    /// rest has 0.1 mm/s of it at 600 substeps a second, and 2 mm/s at 2400.
    ///
    /// For boxes and ragdolls 4 at 60 ticks a second are enough, in two thirds to three quarters of the time. A thousand boxes of 1 m poured between walls are
    /// then as fast, with the deepest overlap of two boxes 8 mm instead of 1.5; in ragdolls on stairs, bones stretch by 4.4 % at worst instead of 0.9.
    pub substeps: u32,
    /// Most sweeps over all constraints in a substep (the lectures' `N_MAX`), 1 to 1000, default 4. Large cloth takes them as [`microsteps`](Self::microsteps).
    pub max_sweeps: u32,
    /// Largest constraint error in metres at which sweeping an island stops early in a substep, 0 or more, default 1e-4. A negative or non-finite value counts
    /// as 0.
    pub tolerance: f32,
    /// At which positions the gradients of hard distances and rigid shapes are taken. Default [`GradientAt::Current`].
    pub gradient_at: GradientAt,
    /// In which order the constraints of an island are enforced. Default [`Order::GaussSeidel`].
    pub order: Order,
    /// Time integrator. Default [`Integrator::Verlet`].
    pub integrator: Integrator,
    /// Maximum speed of a particle, m/s, default 500. A particle that ends a step faster is slowed down to it, and listed in the
    /// [report](crate::SolverReport::too_fast). Constraints that cannot be satisfied, such as a short rod between two particles that are far apart, fling
    /// particles, and this bounds how far. Zero, a negative value, NaN and infinity mean no limit.
    pub max_speed: f32,
    /// Whether islands that nothing outside holds keep their angular momentum, and those that hang on one or two pinned particles theirs about that point or
    /// axis, default true. Corrections along the current gradients lose spin, and a skin under pressure even gains some; with this, what was lost or gained is
    /// restored, and a pendulum swings on. Without it the loop is the lectures'. Linear momentum is always kept.
    ///
    /// About pins it applies to islands of at most 64 particles and to ropes of any length, until they touch something.
    pub keep_spin: bool,
    /// Whether hard distances are also enforced over long ranges before they are swept, default true. A sweep carries a pull only a few rods far; these act
    /// across many rods at once, so that cloth and ropes keep their length with few sweeps. The converged solution is the same without. There are three kinds:
    ///
    /// - **long range attachments** (tethers): a particle that hangs on a pin through many rods is no farther from the pin than the sum of their lengths;
    /// - **spans**: in a grid that takes [`microsteps`](Self::microsteps), particles four rods or more apart in a row or a column are no farther from each
    ///   other than the sum of those rods, so that a jerk crosses the grid at once;
    /// - **chains**: consecutive rods, as in a rope, are solved at once as one tridiagonal system (a direct solver), pinned or not: a rope keeps its length in
    ///   one sweep, whatever load it carries. Cloth, boxes and bones contain none.
    ///
    /// They act only with [`GradientAt::Current`] and [`Order::GaussSeidel`], in islands of more than three particles.
    pub long_range: bool,
    /// Whether large cloth takes its sweeps as smaller substeps of its own (microsteps, or multirate integration), default true: half as many microsteps as it
    /// has sweeps, of one sweep each and no shorter than 1/2500 s, which keep its shape as well at half of the work.
    ///
    /// This applies with [`GradientAt::Current`], [`Order::GaussSeidel`] and the Verlet integrator, to islands of more than 64 particles with more than two
    /// constraints per particle, all of them distances, bends, joints and ties, and without springs. A crate or a figure tied to the cloth takes the same
    /// microsteps, and its own number of sweeps in each sweep of the cloth. Forces are those of the substep; between `integrate` and `solve_constraints`,
    /// positions are those predicted by the first microstep.
    ///
    /// Where something holds such an island and no moving body may touch it, two corrections end the step; both change positions, and no velocity. Three sweeps
    /// in which each rod takes a part of its error distribute what contradicting rods cannot all satisfy (under-relaxation). And where it does not collide with
    /// itself and moves by 2 cm/s or more, rods that are off by more than 3 % are brought within that (strain limiting).
    pub microsteps: bool,
    /// Whether velocities are set to zero in every substep, so that the state walks to rest (the lectures' statics, physics.md F9). Default false.
    pub statics: bool,
    /// Whether the time that each island takes is measured, for the report. It never changes a result. Default false.
    pub timed: bool,
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self {
            substeps: 10,
            max_sweeps: 4,
            tolerance: 1e-4,
            gradient_at: GradientAt::Current,
            order: Order::GaussSeidel,
            integrator: Integrator::Verlet,
            max_speed: 500.0,
            keep_spin: true,
            long_range: true,
            microsteps: true,
            statics: false,
            timed: false,
        }
    }
}

impl SolverSettings {
    /// The same with every number inside its range.
    pub fn clamped(self) -> Self {
        Self {
            substeps: self.substeps.clamp(1, 256),
            max_sweeps: self.max_sweeps.clamp(1, 1000),
            tolerance: if self.tolerance.is_finite() { self.tolerance.max(0.0) } else { 0.0 },
            max_speed: if self.max_speed > 0.0 { self.max_speed } else { f32::INFINITY },
            ..self
        }
    }
}

/// How the rigid parts of a body are simulated within a step. Their particles are the state either way, current between any two phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Representation {
    /// A [rigid part](crate::BodyCollider) whose particles are all tied to each other by rods of the collider's own distances, and by nothing else, is
    /// integrated as one rigid body through the substeps, contacts included, and its particles follow: the same motion (discrete Moser–Veselov) without a
    /// sweep. The default.
    ///
    /// It is simulated as particles instead while one of them is pinned or asleep, another constraint holds one of them, the load of a rod is measured, the
    /// island does not keep spin ([`SolverSettings::keep_spin`], [`GradientAt::StepStart`]), the integrator is not Verlet, or it turns by more than half a
    /// radian in a substep; for the rest of a step in which a position or a velocity of one was set between two phases; and in 2D worlds.
    #[default]
    Auto,
    /// As particles tied by rods: the lectures' boxes.
    Particles,
}

/// Solver settings of one body. `None` means the world's setting.
///
/// Bodies that constraints connect are solved together, with merged settings: the most sweeps and the smallest tolerance of any of them, gradients at the start
/// of the step if all of them have that, the order of the first of them, and spin kept if any of them keeps it.
///
/// # Tolerance as a speed
///
/// The error `e` that a substep leaves appears in the next one as a speed, `e/h`. So a tolerance in metres is looser the more substeps there are: with half a
/// millimetre, joints twitch by 0.3 m/s at 600 substeps a second and by 0.13 at 240, where meeting it takes more than twice as many sweeps.
/// [`tolerance_speed`](Self::tolerance_speed) means the same at any number of substeps. Ragdolls use it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodySettings {
    /// Most sweeps in a substep, 1 to 1000.
    pub max_sweeps: Option<u32>,
    /// Substeps shorter than this, seconds, are swept once, whatever `max_sweeps` is. For bodies so soft that the correction of one constraint hardly moves its
    /// neighbours in so short a time: jelly sets it ([`SoftLatticeSpec::stiffness`](crate::recipes::SoftLatticeSpec::stiffness)). Zero, negative or NaN: no
    /// substep is.
    pub single_sweep_below: Option<f32>,
    /// Largest constraint error in metres at which sweeping stops early, 0 or more.
    pub tolerance: Option<f32>,
    /// The tolerance as a speed, m/s, 0 or more: the error may be as large as the way at that speed in a substep. Ignored if `tolerance` is set.
    pub tolerance_speed: Option<f32>,
    /// At which positions gradients are taken.
    pub gradient_at: Option<GradientAt>,
    /// In which order its constraints are enforced.
    pub order: Option<Order>,
    /// Whether the spin that sweeps remove or add is restored ([`SolverSettings::keep_spin`]).
    pub keep_spin: Option<bool>,
    /// Damping rate of the motion of its particles relative to each other, 1/s, 0 and up, default 0: internal friction of joints and material. The motion of
    /// the body as a whole, as a rigid body, is not damped: it falls, flies and spins as without (Müller et al., *Position Based Dynamics*, 2007, section 3.5).
    /// Pieces of a body that neither constraints nor springs connect any more, as after a tear, are damped each by itself. A negative or non-finite value counts
    /// as 0.
    pub damping: f32,
    /// How its rigid parts are simulated within a step. Default [`Representation::Auto`].
    pub representation: Representation,
}

impl BodySettings {
    /// The world's settings with those of this body in their place, each number clamped to its range; for substeps of `h` seconds.
    pub fn over(self, world: SolverSettings, h: f32) -> SolverSettings {
        let tolerance = self.tolerance.or(self.tolerance_speed.map(|speed| speed * h));
        let most = self.max_sweeps.unwrap_or(world.max_sweeps);
        let is_short = self.single_sweep_below.is_some_and(|below| h < below);
        SolverSettings {
            max_sweeps: if is_short { 1 } else { most },
            tolerance: tolerance.unwrap_or(world.tolerance),
            gradient_at: self.gradient_at.unwrap_or(world.gradient_at),
            order: self.order.unwrap_or(world.order),
            keep_spin: self.keep_spin.unwrap_or(world.keep_spin),
            ..world
        }
        .clamped()
    }
}
