//! Angle constraints between particles: elbows, hinges, and cones.

use bevy::prelude::*;
use sinew::constraints::{Angle, Cone, Hinge};

use super::super::order::CreationOrder;
use super::super::softness::Softness;

/// Keeps the angle at a joint of three particles between two limits.
///
/// The angle has no sign: a straight elbow may bend in any direction. For a joint that bends in one direction only, use a [`HingeConstraint`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::AngleConstraint;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let at = [Vec3::X, Vec3::ZERO, Vec3::Y];
/// let arm = at.map(|at| commands.spawn(Particle::at(at)).id());
/// // Between 30 and 170 degrees.
/// commands.spawn(AngleConstraint::new(arm, 0.52, 2.97));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct AngleConstraint {
    /// `[end, joint, end]`.
    #[entities]
    pub particles: [Entity; 3],
    /// Smallest angle, radians, 0 to `max`.
    pub min: f32,
    /// Largest angle, radians, from `min` (which fixes the angle) to π (a straight joint).
    pub max: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in rad²/J.
    pub softness: Softness,
}

impl AngleConstraint {
    /// Hard limits, radians, for the angle at `b` of `[a, b, c]`.
    pub fn new(particles: [Entity; 3], min: f32, max: f32) -> Self {
        Self { particles, min, max, softness: Softness::Hard }
    }

    /// A constraint from the solver's kind: [`Angle::rest`] keeps an angle as it is.
    pub fn from_kind(particles: [Entity; 3], kind: &Angle) -> Self {
        Self { particles, min: kind.min, max: kind.max, softness: kind.softness.into() }
    }
}

solved_as!(AngleConstraint, |this| Angle { min: this.min, max: this.max });

/// Keeps the signed angle about an axis of two particles between two limits: from the half-plane of `a` to the half-plane of `c`, about `h0 → h1`.
///
/// The angle is positive if a right hand that turns `a` towards `c` has its thumb along `h0 → h1`. It serves as
///
/// - **a hinge**, an elbow or a knee, with `h0` and `h1` along its pin and `a` and `c` on the two bones: a straight one has the angle π, so one that closes by
///   150° and never bends backward has the limits 30° and 180°, or 180° and 330° if it closes the other way;
/// - **a twist limit**: `[a reference in the parent, the joint, the child's far end, a reference in the child]`, so that the axis is the bone;
/// - **a bend** by the dihedral angle of two triangles with the common edge `h0 h1`; flat is π. [`BendConstraint`](super::BendConstraint) is cheaper.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::HingeConstraint;
/// # use bevy_sinew::prelude::*;
/// # let mut world = World::new();
/// # let [hand, shoulder, pin, end] = [(); 4].map(|()| world.spawn_empty().id());
/// let elbow = HingeConstraint::new([shoulder, pin, end, hand], 30_f32.to_radians(), 180_f32.to_radians());
/// assert_eq!(elbow.softness, Softness::Hard);
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct HingeConstraint {
    /// `[a, h0, h1, c]`: the axis is in the middle.
    #[entities]
    pub particles: [Entity; 4],
    /// Smallest angle, radians, -2π to 2π: a range around π extends beyond it (170° to 190°).
    pub min: f32,
    /// Largest angle, radians, from `min` (which fixes the angle) to 2π, and at most 2π above `min`.
    pub max: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in rad²/J.
    pub softness: Softness,
}

impl HingeConstraint {
    /// Hard limits, radians, about the axis `h0 → h1` of `[a, h0, h1, c]`.
    pub fn new(particles: [Entity; 4], min: f32, max: f32) -> Self {
        Self { particles, min, max, softness: Softness::Hard }
    }

    /// A constraint from the solver's kind: [`Hinge::rest`] keeps an angle as it is.
    pub fn from_kind(particles: [Entity; 4], kind: &Hinge) -> Self {
        Self { particles, min: kind.min, max: kind.max, softness: kind.softness.into() }
    }
}

solved_as!(HingeConstraint, |this| Hinge { min: this.min, max: this.max });

/// Keeps a bone in a cone about an axis that is fixed in its parent: a shoulder or a hip. It does not limit twist.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{ConeConstraint};
/// # fn spawn(mut commands: Commands) {
/// let at = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_Y];
/// let rows = at.map(|at| commands.spawn(Particle::at(at)).id());
/// // The joint, two more particles of the parent, and the tip of the bone.
/// commands.spawn(ConeConstraint::new(rows, Vec3::NEG_Y, 0.8));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct ConeConstraint {
    /// `[o, x, y, c, d]`: three particles of the parent, then the ends of the bone; or `[o, x, y, d]` for a bone that begins at `o`.
    #[entities]
    pub particles: Vec<Entity>,
    /// The axis is `axis.x (x - o) + axis.y (y - o) + axis.z (x - o)×(y - o)`; not zero, of any length. [`Cone::about`] computes it.
    pub axis: Vec3,
    /// Largest angle between the axis and the bone, radians, 0 to π (no limit).
    pub max: f32,
    /// How hard it is; [`new`](Self::new) makes a hard one. A compliance is in rad²/J.
    pub softness: Softness,
}

impl ConeConstraint {
    /// A hard cone of `max` radians for `[o, x, y, c, d]` or `[o, x, y, d]`.
    pub fn new(particles: impl Into<Vec<Entity>>, axis: Vec3, max: f32) -> Self {
        Self { particles: particles.into(), axis, max, softness: Softness::Hard }
    }

    /// A constraint from the solver's kind: [`Cone::about`] makes one about a direction in the world.
    pub fn from_kind(particles: impl Into<Vec<Entity>>, kind: &Cone) -> Self {
        Self::new(particles, kind.axis, kind.max).with_softness(kind.softness.into())
    }
}

solved_as!(ConeConstraint, |this| Cone { axis: this.axis, max: this.max });
