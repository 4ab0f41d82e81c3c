//! Any kind of constraint between any particles, for constraints without a component of their own.

use bevy::prelude::*;
use sinew::ConstraintKind;

use super::super::order::CreationOrder;
use super::ParticleConstraint;

/// A constraint of the solver, or a custom one, as it is: the short way to a constraint that is neither edited nor inspected nor saved. The custom constraints
/// of a blueprint become this component.
///
/// It is opaque to reflection. A custom component that implements [`ParticleConstraint`] is not.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::AnyConstraint;
/// # use bevy_sinew::sinew::{Equation, ConstraintKind, Points};
/// #[derive(Debug)]
/// struct AboveGround;
///
/// impl Equation for AboveGround {
///     fn evaluate(&self, points: &Points, gradients: &mut [Vec3]) -> f32 {
///         gradients[0] = Vec3::Y;
///         points.relative_to(0, Vec3::ZERO).y.min(0.0)
///     }
/// }
///
/// # let mut world = World::new();
/// # let particle = world.spawn_empty().id();
/// world.spawn(AnyConstraint::new([particle], ConstraintKind::custom(AboveGround)));
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct AnyConstraint {
    /// The particles, each once, in the order that the kind requires.
    #[entities]
    pub particles: Vec<Entity>,
    /// The kind of the constraint, with its numbers.
    pub kind: ConstraintKind,
}

impl AnyConstraint {
    /// A constraint between these particles.
    pub fn new(particles: impl Into<Vec<Entity>>, kind: ConstraintKind) -> Self {
        Self { particles: particles.into(), kind }
    }
}

impl ParticleConstraint for AnyConstraint {
    fn particles(&self) -> &[Entity] {
        &self.particles
    }

    fn kind(&self) -> ConstraintKind {
        self.kind.clone()
    }
}
