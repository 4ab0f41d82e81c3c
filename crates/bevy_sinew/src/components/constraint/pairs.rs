//! Constraints between two particles: distances, which are positional constraints, and springs, which are forces.

use bevy::prelude::*;

use super::super::order::CreationOrder;
use super::super::softness::Softness;
use crate::same::same_variants;

/// In which direction a distance is enforced.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum Bound {
    /// Exactly the rest length: a rod. The default.
    #[default]
    Equal,
    /// The rest length or less: a rope or a tether.
    AtMost,
    /// The rest length or more: a strut.
    AtLeast,
}

/// Keeps two particles at a distance from each other: an entity of its own, which can be added, changed or despawned at run time.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Bound};
/// # fn spawn(mut commands: Commands) {
/// let [a, b] = [0.0, 1.0].map(|x| commands.spawn(Particle::at(Vec3::X * x)).id());
/// // A rod of 1 m, and a cord of at most 1.5 m.
/// commands.spawn(DistanceConstraint::new(a, b, 1.0));
/// commands.spawn(DistanceConstraint::new(a, b, 1.5).with_bound(Bound::AtMost));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct DistanceConstraint {
    /// One particle.
    #[entities]
    pub a: Entity,
    /// The other particle.
    #[entities]
    pub b: Entity,
    /// Rest length, metres, 0 or more.
    pub rest: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one.
    pub softness: Softness,
    /// Whether the distance is enforced in both directions, or in one.
    pub bound: Bound,
}

impl DistanceConstraint {
    /// A hard rod of `rest` metres between two particles.
    pub fn new(a: Entity, b: Entity, rest: f32) -> Self {
        Self { a, b, rest, softness: Softness::Hard, bound: Bound::Equal }
    }

    /// Returns the same constraint with a compliance, m/N.
    pub fn with_compliance(self, compliance: f32) -> Self {
        self.with_softness(sinew::Softness::compliant(compliance).into())
    }

    /// Returns the same constraint with this softness.
    pub fn with_softness(self, softness: Softness) -> Self {
        Self { softness, ..self }
    }

    /// Returns the same constraint as an inequality.
    pub fn with_bound(self, bound: Bound) -> Self {
        Self { bound, ..self }
    }
}

/// A damped spring between two particles: an entity of its own. It is a force, not a constraint, so a stiff one requires short substeps; a soft
/// [`DistanceConstraint`] does not.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let hook = commands.spawn((Particle::at(Vec3::Y), Pinned::default())).id();
/// let weight = commands.spawn((Particle::at(Vec3::ZERO), Mass(0.5))).id();
/// commands.spawn(Spring::new(hook, weight, 0.8, 50.0).with_damping(0.5));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct Spring {
    /// One particle.
    #[entities]
    pub a: Entity,
    /// The other particle.
    #[entities]
    pub b: Entity,
    /// Rest length, at which the spring exerts no force, metres.
    pub rest: f32,
    /// Stiffness, N/m.
    pub stiffness: f32,
    /// Damping along the spring, N·s/m; critical damping is `2√(kμ)` with `1/μ = 1/m_a + 1/m_b`.
    pub damping: f32,
}

impl Spring {
    /// An undamped spring with this rest length (m) and stiffness (N/m).
    pub fn new(a: Entity, b: Entity, rest: f32, stiffness: f32) -> Self {
        Self { a, b, rest, stiffness, damping: 0.0 }
    }

    /// Returns the same spring with a damping, N·s/m.
    pub fn with_damping(self, damping: f32) -> Self {
        Self { damping, ..self }
    }
}

same_variants!(Bound, sinew::Bound { Equal, AtMost, AtLeast });
