//! Shapes that particles keep: unbent, flat, straight, or rigid.

use bevy::prelude::*;
use sinew::constraints::{Bend, Collinear, Coplanar, Rigid};

use super::super::order::CreationOrder;
use super::super::softness::Softness;

/// Two triangles that share an edge do not bend: isometric bending, cheaper and calmer than an angle, but blind to the side of a fold.
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
    /// Weights of the particles, which sum to zero. [`Bend::of`] finds them.
    pub weights: [f32; 4],
    /// Length of the weighted sum at rest, metres, 0 (a flat shape) and up.
    pub rest: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m/N.
    pub softness: Softness,
}

impl BendConstraint {
    /// A hard one with those weights and `rest` metres.
    pub fn new(particles: [Entity; 4], weights: [f32; 4], rest: f32) -> Self {
        Self { particles, weights, rest, softness: Softness::Hard }
    }

    /// A kind of constraint of the solver between some particles: [`Bend::of`] and [`Bend::stiff`] keep a fold as it is.
    pub fn from_kind(particles: [Entity; 4], kind: &Bend) -> Self {
        Self::new(particles, kind.weights, kind.rest).with_softness(kind.softness.into())
    }
}

solved_as!(BendConstraint, |this| Bend { weights: this.weights, rest: this.rest });

/// Particles stay in one plane, wherever that is.
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
    /// A hard one.
    pub fn new(particles: impl Into<Vec<Entity>>) -> Self {
        Self { particles: particles.into(), softness: Softness::Hard }
    }
}

solved_as!(CoplanarConstraint, |this| Coplanar {});

/// Particles stay on one line, wherever that is. It keeps neither their order nor their distances.
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
    /// A hard one.
    pub fn new(particles: impl Into<Vec<Entity>>) -> Self {
        Self { particles: particles.into(), softness: Softness::Hard }
    }
}

solved_as!(CollinearConstraint, |this| Collinear {});

/// Particles keep a rigid shape, all at once, wherever it is and however it is turned.
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
    /// Where each of them sits in the shape's own frame, metres; as many as `particles`. World positions will do.
    pub rest: Vec<Vec3>,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in m/N.
    pub softness: Softness,
}

impl RigidConstraint {
    /// A hard one in the shape `rest`, metres.
    pub fn new(particles: impl Into<Vec<Entity>>, rest: impl Into<Vec<Vec3>>) -> Self {
        Self { particles: particles.into(), rest: rest.into(), softness: Softness::Hard }
    }

    /// A kind of constraint of the solver between some particles.
    pub fn from_kind(particles: impl Into<Vec<Entity>>, kind: &Rigid) -> Self {
        Self::new(particles, kind.rest.to_vec()).with_softness(kind.softness.into())
    }
}

solved_as!(RigidConstraint, |this| Rigid { rest: this.rest.as_slice().into() });
