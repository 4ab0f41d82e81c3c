//! A scalar equation between the positions of some particles: the base of every constraint but the distance, user-defined ones included (physics.md C11).

use glam::{Vec3, Vec4};

use super::correction::GradientAt;
use super::softness::{Softness, SubstepContext, multiplier};

/// A constraint of any kind: a scalar value that is driven to zero, and its gradient by each particle.
///
/// The solver moves the particles by `dᵢ = -wᵢ ∇ᵢC · C / Σ wⱼ‖∇ⱼC‖²`. For a linear `C` this is the least mass-weighted displacement that makes it zero;
/// otherwise it is one Newton step. Momentum is conserved if `C` does not change when all particles are translated together (the gradients sum to zero), and
/// angular momentum if `C` does not change when they are rotated together. Test both, and test the gradient against finite differences: a wrong sign pushes the
/// wrong way and the simulation blows up.
///
/// ```
/// use sinew::glam::Vec3;
/// use sinew::{Constraint, Equation, ConstraintKind, ParticleSeed, Points, Simulation};
///
/// /// A bead on a round wire in the xy plane: `C = √(x² + y²) - r`. The wire is fixed in the world, so no momentum is kept.
/// #[derive(Debug)]
/// struct Wire {
///     centre: Vec3,
///     radius: f32,
/// }
///
/// impl Equation for Wire {
///     fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
///         let from_centre = points.relative_to(0, self.centre) * Vec3::new(1.0, 1.0, 0.0);
///         gradients[0] = from_centre.normalize_or_zero();
///         from_centre.length() - self.radius
///     }
/// }
///
/// let mut world = Simulation::default();
/// let bead = world.particles.push(ParticleSeed::at(Vec3::X))?;
/// let wire = Wire { centre: Vec3::ZERO, radius: 1.0 };
/// world.constraints_mut().push(Constraint::new([bead], ConstraintKind::custom(wire)));
/// for _ in 0..30 {
///     world.step(1.0 / 60.0)?;
/// }
/// assert!((world.particles.position(0).length() - 1.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Equation: Send + Sync + core::fmt::Debug {
    /// Returns the value `C` at the current positions and writes its gradient by each particle. The value may have any unit.
    ///
    /// `gradients` has as many entries as `points`, all zero; a particle whose gradient is left at zero is not moved by this constraint. Where `C` has no
    /// gradient (a distance of coincident points, say), write the direction in which to move, or return zero to do nothing. Values and gradients that are not
    /// finite are ignored.
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32;

    /// Whether the value must be zero (the default), zero or less, or zero or more.
    fn bound(&self) -> Bound {
        Bound::Equal
    }

    /// Whether the value is zero within a range and beyond it is the distance from its nearer end: a limit on each side (default false). An end only pushes back
    /// into the range. Where this is false, the damping of a soft limit also pulls at what leaves it.
    fn is_range(&self) -> bool {
        false
    }

    /// How stiff the constraint is; hard by default.
    fn softness(&self) -> Softness {
        Softness::Hard
    }

    /// Whether the value is a length in metres. If not (the default), the solver compares `√2 |C|/‖∇C‖` with its tolerance. That is a length whatever the unit
    /// of `C`; for two particles it is the change of their distance.
    fn is_length(&self) -> bool {
        false
    }

    /// Whether the constraint acts between its own particles alone, as a rod does: its value does not change when all of them are translated and rotated
    /// together, so it keeps their momentum and angular momentum. Default false, which is always safe. If it is true for all constraints of an island, the
    /// solver restores the momenta that the island loses by round-off. An equation that ties particles to a place in the world must return false; otherwise
    /// what it stops would keep its velocity.
    fn is_internal(&self) -> bool {
        false
    }
}

/// The particles of one constraint, in its own order, as passed to an [`Equation`].
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    pub(crate) now: &'a [Vec4],
    pub(crate) starts: &'a [Vec4],
    pub(crate) origin: Vec3,
    pub(crate) gradient_at: GradientAt,
}

impl Points<'_> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.now.len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.now.is_empty()
    }

    /// Position of particle `i` of the constraint, metres from [`origin`](Self::origin). Differences of two positions need no origin.
    #[inline]
    pub fn at(&self, i: usize) -> Vec3 {
        self.now[i].truncate()
    }

    /// Its position at the start of the substep, metres from the origin.
    #[inline]
    pub fn start(&self, i: usize) -> Vec3 {
        self.starts[i].truncate()
    }

    /// Inverse mass of particle `i`, 1/kg; zero if it is pinned.
    #[inline]
    pub fn inverse_mass(&self, i: usize) -> f32 {
        self.now[i].w
    }

    /// The point of the world, in whole metres, to which positions are relative. It is near the particles, so that positions keep full f32 precision far from
    /// the world's origin.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// `p_i - point` for a point in world space, metres.
    #[inline]
    pub fn relative_to(&self, i: usize, point: Vec3) -> Vec3 {
        (self.origin - point) + self.at(i)
    }

    /// Where the island takes its gradients, for equations that can use the positions at the start of the substep.
    pub fn gradient_at(&self) -> GradientAt {
        self.gradient_at
    }
}

/// Which side of a constraint is enforced: an equality, or an upper or lower limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Bound {
    /// Equality: exactly the rest length, a rod.
    #[default]
    Equal,
    /// Upper limit: the rest length or less, a rope or a tether.
    AtMost,
    /// Lower limit: the rest length or more, a strut.
    AtLeast,
}

impl Bound {
    /// Whether a constraint with this value (length less rest length) holds as an inequality and needs no correction.
    #[inline]
    pub(crate) fn holds(self, value: f32) -> bool {
        match self {
            Bound::Equal => false,
            Bound::AtMost => value <= 0.0,
            Bound::AtLeast => value >= 0.0,
        }
    }
}

/// Projects one equation: passes the displacement of each particle to `moved` and returns the error before the projection, metres. For a soft equation it
/// returns the largest displacement of a particle.
///
/// `gradients` is scratch of the same length as `points`.
pub(crate) fn project(
    equation: &dyn Equation,
    points: &Points,
    gradients: &mut [Vec3],
    substep_context: SubstepContext,
    lambda: &mut f32,
    mut moved: impl FnMut(usize, Vec3),
) -> f32 {
    let Some(Solved { value, weights, error }) = solve(equation, points, gradients) else {
        return 0.0;
    };
    let softness = equation.softness();
    let bound = if equation.is_range() {
        if value > 0.0 { Bound::AtMost } else { Bound::AtLeast }
    } else {
        equation.bound()
    };
    if *lambda == 0.0 && bound.holds(value) {
        return 0.0;
    }
    if weights == 0.0 {
        return 0.0;
    }
    let moved_by = match softness {
        Softness::Hard | Softness::Share(_) => 0.0,
        _ => (0..points.len()).map(|i| gradients[i].dot(points.at(i) - points.start(i))).sum(),
    };
    let terms = (value, weights, moved_by);
    let change = change((softness, bound), substep_context, terms, lambda);
    let mut farthest = 0.0_f32;
    for (i, gradient) in gradients.iter().enumerate() {
        let step = *gradient * (-points.inverse_mass(i) * change);
        farthest = farthest.max(step.length());
        moved(i, step);
    }
    match (softness.is_hard(), bound.holds(value)) {
        (true, true) => 0.0,
        (true, false) => error,
        (false, _) => unfinished(softness, error, farthest),
    }
}

/// What a soft constraint counts as among the errors of a sweep, metres. It is not expected to reach zero error, and requests another sweep as long as sweeps
/// still move it, by `moved`. A share requests all sweeps until what a substep is to remove of its error is within the tolerance, since each sweep removes a
/// part of that which depends on their number.
#[inline]
pub(super) fn unfinished(softness: Softness, error: f32, moved: f32) -> f32 {
    if let Softness::Share(share) = softness { share * error } else { moved }
}

/// The change of the multiplier by one projection, from the value, its weights and how far it has [moved](multiplier); the accumulated sum is kept in `lambda`.
/// An inequality only pushes one way, so its sum is clamped to that side of zero.
#[inline]
pub(super) fn change(
    (softness, bound): (Softness, Bound),
    substep_context: SubstepContext,
    (value, weights, moved): (f32, f32, f32),
    lambda: &mut f32,
) -> f32 {
    let unit = softness.unit(weights);
    let unclamped = multiplier(softness, substep_context, value, weights, moved, *lambda) * unit;
    let change = match bound {
        Bound::Equal => unclamped,
        Bound::AtMost => (unclamped + *lambda).max(0.0) - *lambda,
        Bound::AtLeast => (unclamped + *lambda).min(0.0) - *lambda,
    };
    // Only soft constraints use the sum; a hard inequality starts afresh in each sweep.
    *lambda = if softness.accumulates() { *lambda + change } else { 0.0 };
    change / unit
}

/// Error of a hard equation, metres. Moves nothing.
pub(crate) fn error(equation: &dyn Equation, points: &Points, gradients: &mut [Vec3]) -> f32 {
    match solve(equation, points, gradients) {
        Some(found) if equation.softness().is_hard() && !equation.bound().holds(found.value) => {
            found.error
        }
        _ => 0.0,
    }
}

/// Energy stored in a soft equation, J.
pub(crate) fn energy(equation: &dyn Equation, points: &Points, gradients: &mut [Vec3]) -> f32 {
    match solve(equation, points, gradients) {
        Some(found) if !equation.bound().holds(found.value) => {
            equation.softness().energy(found.value, found.weights)
        }
        _ => 0.0,
    }
}

/// An equation evaluated at the current positions; its value is not zero.
pub(crate) struct Solved {
    pub(crate) value: f32,
    /// `Σ w‖∇C‖²`.
    pub(crate) weights: f32,
    /// The value as a length, metres.
    pub(crate) error: f32,
}

/// Evaluates an equation; `None` where no correction is needed or possible.
pub(crate) fn solve(
    equation: &dyn Equation,
    points: &Points,
    gradients: &mut [Vec3],
) -> Option<Solved> {
    gradients.fill(Vec3::ZERO);
    let value = equation.evaluate(points, gradients);
    let (mut weights, mut steepness) = (0.0, 0.0);
    for (i, gradient) in gradients.iter().enumerate() {
        let square = gradient.length_squared();
        steepness += square;
        weights += points.inverse_mass(i) * square;
    }
    // Finite weights imply finite gradients. If all particles are pinned the weights are zero and nothing can move.
    if value == 0.0 || !value.is_finite() || !(weights.is_finite() && weights > 0.0) {
        return None;
    }
    let error = if equation.is_length() {
        value.abs()
    } else {
        core::f32::consts::SQRT_2 * value.abs() / steepness.sqrt()
    };
    Some(Solved { value, weights, error })
}
