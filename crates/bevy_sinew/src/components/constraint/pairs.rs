//! What holds pairs of particles together: distances, which hold exactly, and springs, which pull.

use bevy::prelude::*;

use super::super::order::CreationOrder;
use super::super::softness::Softness;
use crate::same::same_variants;

/// Which way a distance is enforced.
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

/// Two particles stay a fixed distance apart: an entity of its own, to add, change or despawn at run time.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Bound};
/// # fn spawn(mut commands: Commands) {
/// let [a, b] = [0.0, 1.0].map(|x| commands.spawn(Particle::at(Vec3::X * x)).id());
/// // A rod of a metre, and a cord that holds no more than that.
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
    /// Length to keep, metres, 0 and up.
    pub rest: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one.
    pub softness: Softness,
    /// Whether the length is kept both ways.
    pub bound: Bound,
}

impl DistanceConstraint {
    /// A hard rod of `rest` metres between two particles.
    pub fn new(a: Entity, b: Entity, rest: f32) -> Self {
        Self { a, b, rest, softness: Softness::Hard, bound: Bound::Equal }
    }

    /// The same with a compliance, m/N.
    pub fn with_compliance(self, compliance: f32) -> Self {
        self.with_softness(sinew::Softness::compliant(compliance).into())
    }

    /// The same, as hard as that.
    pub fn with_softness(self, softness: Softness) -> Self {
        Self { softness, ..self }
    }

    /// The same as an inequality.
    pub fn with_bound(self, bound: Bound) -> Self {
        Self { bound, ..self }
    }
}

/// A damped spring between two particles: an entity of its own.
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
    /// Length at which it exerts no force, metres.
    pub rest: f32,
    /// Stiffness, N/m.
    pub stiffness: f32,
    /// Damping along the spring, N·s/m; critical is `2√(kμ)` with `1/μ = 1/m_a + 1/m_b`.
    pub damping: f32,
}

impl Spring {
    /// An undamped spring of the given rest length (m) and stiffness (N/m).
    pub fn new(a: Entity, b: Entity, rest: f32, stiffness: f32) -> Self {
        Self { a, b, rest, stiffness, damping: 0.0 }
    }

    /// The same with a damping, N·s/m.
    pub fn with_damping(self, damping: f32) -> Self {
        Self { damping, ..self }
    }
}

same_variants!(Bound, sinew::Bound { Equal, AtMost, AtLeast });
