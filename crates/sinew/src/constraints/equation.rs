//! One equation between the positions of some particles: what every constraint but the distance is, a game's own included (physics.md C11).

use glam::{Vec3, Vec4};

use super::correction::GradientAt;
use super::softness::{Softness, SubstepContext, multiplier};

/// A constraint of any kind: a value that is to be zero, and how it changes with each particle.
///
/// The solver moves the particles by `dᵢ = -wᵢ ∇ᵢC · C / Σ wⱼ‖∇ⱼC‖²`, the least mass-weighted displacement that makes a linear `C` vanish, and
/// one Newton step towards it otherwise. That conserves momentum if `C` does not change when all particles move together (the gradients sum to
/// zero), and angular momentum if it does not change when they turn together. Check both, and the gradient against finite differences: a wrong
/// sign pushes the wrong way and blows up.
///
/// ```
/// use sinew::glam::Vec3;
/// use sinew::{Constraint, Equation, ConstraintKind, ParticleSeed, Points, Simulation};
///
/// /// A bead on a round wire in the xy plane: `C = √(x² + y²) - r`. The wire stands in the world, so no momentum is kept.
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
    /// The value `C` where the particles are now, and its gradient by each of them. Both may be in any unit.
    ///
    /// `gradients` has as many entries as `points`, all zero; what is left at zero is not moved by this constraint. Where `C` has no gradient (a
    /// distance of coincident points, say), return what is to be done there, or a value of zero for nothing. Values and gradients that are not
    /// finite are taken for nothing.
    fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32;

    /// Whether the value is to be zero (the default), zero or less, or zero or more.
    fn bound(&self) -> Bound {
        Bound::Equal
    }

    /// How hard it is; hard by default.
    fn softness(&self) -> Softness {
        Softness::Hard
    }

    /// Whether the value is a length in metres. If not (the default), the solver compares `√2 |C|/‖∇C‖` with its tolerance, which is a length
    /// whatever the unit of `C`, and for two particles the way that they have to go together.
    fn is_length(&self) -> bool {
        false
    }

    /// Whether it acts between its own particles alone, as a rod does: its value stays what it is where all of them are moved and turned together, so that it keeps their
    /// momentum. Where that holds of all constraints of an island, the solver gives back what round-off takes of its momenta. Not by default, which is right of anything:
    /// an equation that ties particles to a place in the world must not say so, or what it stops would keep its velocity.
    fn is_internal(&self) -> bool {
        false
    }
}

/// The particles of one constraint, in its own order, as an [`Equation`] sees them.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    pub(crate) now: &'a [Vec4],
    pub(crate) starts: &'a [Vec4],
    pub(crate) origin: Vec3,
    pub(crate) gradient_at: GradientAt,
}

impl Points<'_> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.now.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.now.is_empty()
    }

    /// Where particle `i` of the constraint is, metres from [`origin`](Self::origin). Differences of two are true differences.
    #[inline]
    pub fn at(&self, i: usize) -> Vec3 {
        self.now[i].truncate()
    }

    /// Where it was when the substep began, metres from the origin.
    #[inline]
    pub fn start(&self, i: usize) -> Vec3 {
        self.starts[i].truncate()
    }

    /// Inverse mass of particle `i`, 1/kg; zero if it is pinned.
    #[inline]
    pub fn inverse_mass(&self, i: usize) -> f32 {
        self.now[i].w
    }

    /// The point of the world, in whole metres, that positions are relative to: near the particles, so that their digits are their own.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// `p_i - point` for a point of the world, metres.
    #[inline]
    pub fn relative_to(&self, i: usize, point: Vec3) -> Vec3 {
        (self.origin - point) + self.at(i)
    }

    /// Along which gradients the island is corrected: for equations that know how to use the positions at the start.
    pub fn gradient_at(&self) -> GradientAt {
        self.gradient_at
    }
}

/// Which way a constraint is enforced, such as a distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Bound {
    /// Exactly the rest length: a rod.
    #[default]
    Equal,
    /// The rest length or less: a rope or a tether.
    AtMost,
    /// The rest length or more: a strut.
    AtLeast,
}

impl Bound {
    /// Whether the constraint asks for nothing when its value (length less rest length) is `value`.
    #[inline]
    pub(crate) fn holds(self, value: f32) -> bool {
        match self {
            Bound::Equal => false,
            Bound::AtMost => value <= 0.0,
            Bound::AtLeast => value >= 0.0,
        }
    }
}

/// Projects one equation: moves `points.now` (returned through `moved`) and returns how far it was from being kept, metres; of a soft one,
/// how far it moved the particle that it moved most.
///
/// `gradients` is scratch of the same length.
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
    let (softness, bound) = (equation.softness(), equation.bound());
    if *lambda == 0.0 && bound.holds(value) {
        return 0.0;
    }
    if weights == 0.0 {
        return 0.0;
    }
    let way = match softness {
        Softness::Hard | Softness::Share(_) => 0.0,
        _ => (0..points.len()).map(|i| gradients[i].dot(points.at(i) - points.start(i))).sum(),
    };
    let asks = (value, weights, way);
    let change = change((softness, bound), substep_context, asks, lambda);
    let mut farthest = 0.0_f32;
    for (i, gradient) in gradients.iter().enumerate() {
        let step = *gradient * (-points.inverse_mass(i) * change);
        farthest = farthest.max(step.length());
        moved(i, step);
    }
    match (softness.is_hard(), bound.holds(value)) {
        (true, true) => 0.0,
        (true, false) => error,
        // A soft one is not meant to be kept. It asks for another sweep as long as sweeps still move it.
        (false, _) => farthest,
    }
}

/// The change of the multiplier that one projection makes of a value, its weights and how far it has [moved](multiplier); the sum is kept in `lambda`. An
/// inequality only ever pushes one way, so its sum is held on that side of zero.
#[inline]
pub(super) fn change(
    (softness, bound): (Softness, Bound),
    substep_context: SubstepContext,
    (value, weights, moved): (f32, f32, f32),
    lambda: &mut f32,
) -> f32 {
    let unit = softness.unit(weights);
    let asked = multiplier(softness, substep_context, value, weights, moved, *lambda) * unit;
    let change = match bound {
        Bound::Equal => asked,
        Bound::AtMost => (asked + *lambda).max(0.0) - *lambda,
        Bound::AtLeast => (asked + *lambda).min(0.0) - *lambda,
    };
    // The sum matters to soft constraints alone; a hard inequality projects afresh in each sweep.
    *lambda = if softness.remembers() { *lambda + change } else { 0.0 };
    change / unit
}

/// How far a hard equation is from being kept, metres, moving nothing.
pub(crate) fn error(equation: &dyn Equation, points: &Points, gradients: &mut [Vec3]) -> f32 {
    match solve(equation, points, gradients) {
        Some(found) if equation.softness().is_hard() && !equation.bound().holds(found.value) => {
            found.error
        }
        _ => 0.0,
    }
}

/// Energy that a soft equation stores, J.
pub(crate) fn energy(equation: &dyn Equation, points: &Points, gradients: &mut [Vec3]) -> f32 {
    match solve(equation, points, gradients) {
        Some(found) if !equation.bound().holds(found.value) => {
            equation.softness().energy(found.value, found.weights)
        }
        _ => 0.0,
    }
}

/// What an equation says where the particles are: not zero.
pub(crate) struct Solved {
    pub(crate) value: f32,
    /// `Σ w‖∇C‖²`.
    pub(crate) weights: f32,
    /// The value as a length, metres.
    pub(crate) error: f32,
}

/// Evaluates; `None` where nothing is to be done or can be.
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
    // Weights that are finite come of finite gradients; pinned particles alone leave zero, and nothing to be done.
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
