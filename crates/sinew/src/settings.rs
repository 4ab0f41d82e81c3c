//! Configuration of the solver: for a world, and for single bodies in it.

use crate::constraints::GradientAt;
use crate::integrate::Integrator;

/// How the solver goes through the constraints of an island.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// Gauss–Seidel: one after the other, colour by colour, again and again; the lectures' cascade. The default.
    #[default]
    GaussSeidel,
    /// Always the one that is violated most. A heap finds it, which pays below some 200 constraints.
    MostViolatedFirst,
    /// All from the same positions, and each particle to the mean of what its constraints ask. The order does not matter, and it converges slowly.
    Jacobi,
}

/// How hard the solver tries. Every number has a documented range and is clamped to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings {
    /// Substeps in a step, 1 to 256, default 10. At equal work many substeps with few sweeps beat one step with many.
    ///
    /// What counts is how many there are in a second: the default is meant for ticks of 1/60 s, and at 240 ticks a second 3 do as well. Positions
    /// are rounded to some 3e-8 of their distance from the body's origin, and what they are rounded by in a substep is a speed: a cloth of 1 m
    /// that hangs at rest has 0.1 mm/s of that at 600 substeps a second, and 2 mm/s at 2400.
    ///
    /// Boxes and ragdolls do with 4 at 60 ticks a second, in two thirds to three quarters of the time: a thousand boxes of 1 m poured between walls are as
    /// fast, the deepest corner 8 mm in another box instead of 1.5; of ragdolls on stairs, bones yield by 4.4 % at worst instead of 0.9.
    pub substeps: u32,
    /// The most sweeps over all constraints in a substep (the lectures' `N_MAX`), 1 to 1000, default 4. Large cloth takes them as
    /// [`microsteps`](Self::microsteps).
    pub max_sweeps: u32,
    /// Error in metres at which an island stops being swept early in a substep, 0 or more, default 1e-4. A negative or non-finite one counts as 0.
    pub tolerance: f32,
    /// Along which gradients hard distances and rigid shapes are corrected. Default [`GradientAt::Current`].
    pub gradient_at: GradientAt,
    /// In which order constraints are enforced. Default [`Order::GaussSeidel`].
    pub order: Order,
    /// How a step through time is made. Default [`Integrator::Verlet`].
    pub integrator: Integrator,
    /// The most that anything may move at, m/s, default 500: what a step leaves faster is slowed down to it, and the
    /// [report](crate::SolverReport::too_fast) names it. What cannot be met, such as a short rod between two particles that are far apart, flings things, and
    /// this bounds how far. Zero, a negative or a non-finite one is no limit.
    pub max_speed: f32,
    /// Whether what nothing outside holds keeps its angular momentum though its corrections do not: those to the nearest point bleed spin, and a skin
    /// under pressure even makes some. Default so; without it the lectures' loop is as it is. Linear momentum is always kept.
    pub keep_spin: bool,
    /// Whether hard distances are also held over long ranges, before they are swept: a sweep hands a pull on by some rods, and these by all of them at once,
    /// so that cloth and ropes keep their length however seldom they are swept. What is solved to the end is the same without. Default so. Three of them:
    ///
    /// - **long range attachments** (tethers): what hangs on a pin through many rods is no farther from it than these allow together;
    /// - **spans**: in a grid that takes [`microsteps`](Self::microsteps), particles four rods or more apart in a row or a column are no farther from each
    ///   other than those rods are long, so that a jerk goes through it at once;
    /// - **chains**: rods one behind the other, as in a rope, are solved at once as one tridiagonal system (a direct solver), pinned or not: a rope keeps its
    ///   length in one sweep, whatever hangs on it. Cloth, boxes and bones have none within.
    ///
    /// Only where corrections are along [`GradientAt::Current`] and in [`Order::GaussSeidel`], and in islands of more than three particles.
    pub long_range: bool,
    /// Whether large cloth takes its sweeps as smaller substeps of its own (microsteps, or multirate integration): half as many of one sweep each, down to 1/2500
    /// s, which hold it as well at half of the work. Only where corrections are along [`GradientAt::Current`] and in [`Order::GaussSeidel`], by Verlet, in
    /// islands of more than 64 particles with more than two constraints for each particle, which are distances, bends, joints and ties, and no springs. What is tied to
    /// the cloth, a crate or a figure, steps as that does, and has its own sweeps in each sweep of the cloth. Forces are those of the
    /// substep; between integration and solving, positions are what the first microstep has predicted. And where something holds it, and nothing that moves may
    /// touch it, such an island ends a step with three sweeps in which each rod takes a part of its error, so that those that contradict each other share what none of
    /// them can have (under-relaxation), and, where it does not collide with itself and moves by 2 cm/s or more, with rods that are off by more than 3 % brought within
    /// that (strain limiting); both change positions, and no velocity. Default so.
    pub microsteps: bool,
    /// Whether velocities are forgotten in every substep, so that the state walks to rest (the lectures' statics, physics.md F9). Default not.
    pub statics: bool,
    /// Whether the time that each island takes is measured, for the report. It never changes a result. Default not.
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

/// How the rigid parts of a body move within a step. Their particles are the state either way, current between any two phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Representation {
    /// A [rigid part](crate::BodyCollider) that only its own rods hold, each particle tied to each as long as the collider has them apart, is integrated
    /// as one rigid body through the substeps, contacts included, and its particles follow: the same motion (discrete Moser–Veselov) without a sweep.
    ///
    /// It moves as particles while one of them is pinned or asleep, another constraint holds one of them, a load of a rod is measured, the island
    /// does not keep spin ([`SolverSettings::keep_spin`], [`GradientAt::StepStart`]), the integrator is not Verlet, or it turns by more than half a radian in a
    /// substep; for the rest of a step in which a position or a velocity of one was set between two phases; and in worlds in 2D. The default.
    #[default]
    Auto,
    /// As particles that rods hold together: the lectures' boxes.
    Particles,
}

/// What one body asks of the solver, where that differs from its world. What is `None` is as in the world.
///
/// Bodies that constraints connect are solved together: with the most sweeps and the smallest tolerance that any of them asks for, along the start
/// of the step if all of them do, in the order that the first of them wants, and with their spin if any of them keeps it.
///
/// # Tolerance as a speed
///
/// What a substep leaves undone, `e`, the next one finds as a speed, `e/h`. So a tolerance in metres is looser the more substeps there are: of half
/// a millimetre joints twitch by 0.3 m/s at 600 substeps a second and by 0.13 at 240, where they are swept more than twice as often to be that
/// quiet. [`tolerance_speed`](Self::tolerance_speed) asks for the same at any number of them. Ragdolls do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodySettings {
    /// The most sweeps in a substep, 1 to 1000.
    pub max_sweeps: Option<u32>,
    /// Substeps shorter than this, seconds, are swept once, whatever `max_sweeps` are: for what yields so much that a neighbour hardly moves it in so short a time. Jelly
    /// asks for it ([`SoftLatticeSpec::stiffness`](crate::recipes::SoftLatticeSpec::stiffness)). Not positive or NaN: none are.
    pub single_sweep_below: Option<f32>,
    /// Error in metres at which sweeping stops early, 0 or more.
    pub tolerance: Option<f32>,
    /// The same as a speed, m/s, 0 or more: the error may be as large as what that goes in a substep. Where there is a `tolerance`, that counts.
    pub tolerance_speed: Option<f32>,
    /// Along which gradients it is corrected.
    pub gradient_at: Option<GradientAt>,
    /// In which order its constraints are enforced.
    pub order: Option<Order>,
    /// Whether it is given back the spin that sweeps take from it or give to it ([`SolverSettings::keep_spin`]).
    pub keep_spin: Option<bool>,
    /// How fast what its particles do against each other dies away, 1/s, 0 and up, default 0: friction in its joints, or in its stuff. What all of it
    /// does together, as a rigid body would, stays: it falls, flies and spins as without (Müller et al., *Position Based Dynamics*, 2007, section
    /// 3.5). A negative or non-finite one counts as 0.
    pub damping: f32,
    /// How its rigid parts move within a step; default [`Representation::Auto`].
    pub representation: Representation,
}

impl BodySettings {
    /// The world's settings with this body's own in their place, every number inside its range; for substeps of `h` seconds.
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
