//! Shape constraints: unbent, flat, straight, or rigid.

use bevy::prelude::*;
use sinew::constraints::{Bend, Collinear, Coplanar, Rigid};

use super::super::order::CreationOrder;
use super::super::softness::Softness;

/// Keeps two triangles with a common edge from bending: isometric bending, which is cheaper and more stable than a dihedral angle, but does not distinguish the
/// two directions of a fold.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::BendConstraint;
/// use bevy_sinew::sinew::constraints::Bend;
/// # fn example(mut commands: Commands) {
/// // Two triangles on either side of an edge, which stay as flat as they are.
/// let at = [Vec3::ZERO, Vec3::Z, Vec3::NEG_X, Vec3::X];
/// let corners = at.map(|at| commands.spawn(Particle::at(at)).id());
/// if let Some(flat) = Bend::of(at) {
///     commands.spawn(BendConstraint::from_kind(corners, &flat));
/// }
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct BendConstraint {
    /// `[e0, e1, a, b]`: the edge, then the two opposite corners.
    #[entities]
    pub particles: [Entity; 4],
    /// Weights of the particles, which add up to zero. [`Bend::of`] computes them.
    pub weights: [f32; 4],
    /// Length of the weighted sum at rest, metres, 0 (a flat shape) or more.
    pub rest: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m/N.
    pub softness: Softness,
}

impl BendConstraint {
    /// A hard constraint with these weights and `rest` metres.
    pub fn new(particles: [Entity; 4], weights: [f32; 4], rest: f32) -> Self {
        Self { particles, weights, rest, softness: Softness::Hard }
    }

    /// A constraint from the solver's kind: [`Bend::of`] and [`Bend::stiff`] keep a fold as it is.
    pub fn from_kind(particles: [Entity; 4], kind: &Bend) -> Self {
        Self::new(particles, kind.weights, kind.rest).with_softness(kind.softness.into())
    }
}

solved_as!(BendConstraint, |this| Bend { weights: this.weights, rest: this.rest });

/// Keeps particles in one plane, wherever that is.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{CoplanarConstraint};
/// # fn spawn(mut commands: Commands) {
/// let at = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(1.0, 0.1, 1.0)];
/// let corners = at.map(|at| commands.spawn(Particle::at(at)).id());
/// commands.spawn(CoplanarConstraint::new(corners));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct CoplanarConstraint {
    /// The particles, each once; four or more.
    #[entities]
    pub particles: Vec<Entity>,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m/N.
    pub softness: Softness,
}

impl CoplanarConstraint {
    /// A hard constraint.
    pub fn new(particles: impl Into<Vec<Entity>>) -> Self {
        Self { particles: particles.into(), softness: Softness::Hard }
    }
}

solved_as!(CoplanarConstraint, |this| Coplanar {});

/// Keeps particles on one line, wherever that is. Their order and their distances are free.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{CollinearConstraint};
/// # fn spawn(mut commands: Commands) {
/// let beads = [0.0, 0.5, 1.0].map(|x| commands.spawn(Particle::at(Vec3::X * x)).id());
/// commands.spawn(CollinearConstraint::new(beads));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct CollinearConstraint {
    /// The particles, each once; three or more.
    #[entities]
    pub particles: Vec<Entity>,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m/N.
    pub softness: Softness,
}

impl CollinearConstraint {
    /// A hard constraint.
    pub fn new(particles: impl Into<Vec<Entity>>) -> Self {
        Self { particles: particles.into(), softness: Softness::Hard }
    }
}

solved_as!(CollinearConstraint, |this| Collinear {});

/// Keeps particles in a rigid shape, all at once (shape matching), wherever it is and however it is turned.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{RigidConstraint};
/// # fn spawn(mut commands: Commands) {
/// let rest = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
/// let corners = rest.map(|at| commands.spawn(Particle::at(at)).id());
/// commands.spawn(RigidConstraint::new(corners, rest));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct RigidConstraint {
    /// The particles, each once.
    #[entities]
    pub particles: Vec<Entity>,
    /// The position of each particle in the shape's own frame, metres; as many as `particles`. World positions are valid, too.
    pub rest: Vec<Vec3>,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m/N.
    pub softness: Softness,
}

impl RigidConstraint {
    /// A hard constraint with the shape `rest`, metres.
    pub fn new(particles: impl Into<Vec<Entity>>, rest: impl Into<Vec<Vec3>>) -> Self {
        Self { particles: particles.into(), rest: rest.into(), softness: Softness::Hard }
    }

    /// A constraint from the solver's kind.
    pub fn from_kind(particles: impl Into<Vec<Entity>>, kind: &Rigid) -> Self {
        Self::new(particles, kind.rest.to_vec()).with_softness(kind.softness.into())
    }
}

solved_as!(RigidConstraint, |this| Rigid { rest: this.rest.as_slice().into() });
