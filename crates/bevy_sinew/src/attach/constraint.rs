//! The constraint between two points that particles carry.

use bevy::prelude::*;
use sinew::constraints::{Anchor, AnchorDistance};
use sinew::{Bound, ConstraintKind};

use crate::components::{CreationOrder, ParticleConstraint, Softness};

/// Two points that particles carry stay a distance apart; with none it is a ball joint. [`AttachTo`](super::AttachTo) makes them, and so may a game.
///
/// A point is `Σ wᵢ xᵢ` of some particles, the weights of which add up to 1 ([`affine_weights`](sinew::constraints::affine_weights) finds them): any point of a
/// rigid body, in it or outside, the middle of a patch of cloth, or a single particle.
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
    /// The particles of one point, and then those of the other, each once.
    #[entities]
    pub particles: Vec<Entity>,
    /// How many of them are the first point's.
    pub first: usize,
    /// The share of each.
    pub weights: Vec<f32>,
    /// Of either point, whether its particles are a rigid body, which is pulled at the point as one. Default not.
    pub rigid: [bool; 2],
    /// The distance, metres, 0 and up. Default 0.
    pub rest: f32,
    /// How hard it is. Default hard.
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
