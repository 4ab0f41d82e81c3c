//! The distance constraint between two points that are combinations of particles.

use bevy::prelude::*;
use sinew::constraints::{Anchor, AnchorDistance};
use sinew::{Bound, ConstraintKind};

use crate::components::{CreationOrder, ParticleConstraint, Softness};

/// Keeps two points at a distance from each other; a distance of 0 is a ball joint. [`AttachTo`](super::AttachTo) spawns these constraints, and a game may
/// spawn its own.
///
/// A point is a combination `Σ wᵢ xᵢ` of particles, with weights that add up to 1 ([`affine_weights`](sinew::constraints::affine_weights) computes them): any
/// point of a rigid body, inside or outside of it, the middle of a patch of cloth, or a single particle.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::AnchorConstraint;
/// # fn example(mut commands: Commands) {
/// // The middle of a rod hangs 1 m below a nail.
/// let [a, b] = [-0.5, 0.5].map(|x| commands.spawn(Particle::at(Vec3::new(x, 0.0, 0.0))).id());
/// commands.spawn(DistanceConstraint::new(a, b, 1.0));
/// let nail = commands.spawn((Particle::at(Vec3::Y), Pinned::HERE)).id();
/// commands.spawn(AnchorConstraint {
///     particles: vec![a, b, nail],
///     first: 2,
///     weights: vec![0.5, 0.5, 1.0],
///     rest: 1.0,
///     ..default()
/// });
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct AnchorConstraint {
    /// The particles of the first point, followed by those of the second, each once.
    #[entities]
    pub particles: Vec<Entity>,
    /// How many of the particles belong to the first point.
    pub first: usize,
    /// The weight of each particle; the weights of each point add up to 1.
    pub weights: Vec<f32>,
    /// For each point, whether its particles form a rigid body, which is then pulled at the point as a rigid body. Default false.
    pub rigid: [bool; 2],
    /// The distance, metres, 0 or more. Default 0.
    pub rest: f32,
    /// How hard the constraint is. Default hard.
    pub softness: Softness,
}

impl AnchorConstraint {
    fn distance(&self) -> AnchorDistance {
        let (a, b) = self.weights.split_at(self.first.min(self.weights.len()));
        let [a, b] = [(a, self.rigid[0]), (b, self.rigid[1])]
            .map(|(weights, rigid)| Anchor { weights: weights.into(), rigid });
        let (rest, bound, softness) = (self.rest, Bound::Equal, self.softness.into());
        AnchorDistance { a, b, rest, bound, softness }
    }
}

impl ParticleConstraint for AnchorConstraint {
    fn particles(&self) -> &[Entity] {
        &self.particles
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::Anchors(self.distance())
    }
}
