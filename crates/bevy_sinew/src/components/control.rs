//! Forces that a game steers: engines, thrusters, hands.

use bevy::prelude::*;

use super::order::CreationOrder;
use crate::rows::Rows;

/// A force and a torque of the game's own, on a body as a whole or on one particle, in every substep until they are changed or removed.
///
/// It stands on the body itself, or (so that there may be several) on an entity of its own; Bevy's `Name` on that entity is the force's name. One on
/// its own stays when the body goes, and does nothing then: add [`ConstraintOf`](super::ConstraintOf) to have it go too.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::ControlForce;
/// # use bevy_sinew::prelude::*;
/// fn launch(mut commands: Commands) {
///     let rocket = commands.spawn(RigidBox::new(Vec3::new(0.3, 2.0, 0.3))).id();
///     // A nozzle at the bottom, which turns with the rocket.
///     let thrust = ControlForce::new(Vec3::Y * 30.0).on(rocket).at(Vec3::NEG_Y).local();
///     commands.spawn((Name::new("main engine"), thrust));
/// }
/// ```
///
/// The body feels the force at its barycentre (`F = m a`), or at a point, with its lever; the torque is spread as a rigid body would take it.
/// Pinned particles do not notice. One with a number that is not finite is refused once, and does nothing until it is mended.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder, Rows<ControlForce>, ResolvedTarget)]
pub struct ControlForce {
    /// The body, the part of a ragdoll (or whatever else has a [`RigidPose`](super::RigidPose)) or the particle it acts on. Default `None`: the
    /// entity that it stands on.
    #[entities]
    pub on: Option<Entity>,
    /// The force on all of it together, N. Default zero.
    pub force: Vec3,
    /// The torque on all of it together, N·m. Default zero. What would turn a line about itself, or a single particle, is lost.
    pub torque: Vec3,
    /// Where the force acts, metres. Default `None`: at the barycentre, so that it turns nothing.
    pub point: Option<Vec3>,
    /// Whether `force`, `torque` and `point` are in the frame of the body's `Transform`, as it is when the tick begins, and not in the world's.
    /// Default not. A particle has no frame; that of cloth and ropes does not turn with them.
    pub local: bool,
}

impl ControlForce {
    /// A force at the barycentre, N.
    pub fn new(force: Vec3) -> Self {
        Self { force, ..default() }
    }

    /// A torque, N·m.
    pub fn torque(torque: Vec3) -> Self {
        Self { torque, ..default() }
    }

    /// The same on a body or a particle other than the entity that it stands on.
    pub fn on(self, target: Entity) -> Self {
        Self { on: Some(target), ..self }
    }

    /// The same with the force at a point, metres.
    pub fn at(self, point: Vec3) -> Self {
        Self { point: Some(point), ..self }
    }

    /// The same in the frame of the body.
    pub fn local(self) -> Self {
        Self { local: true, ..self }
    }
}

/// A torque in N·m, along the world's axes, that the game exerts on a body or on a rigid part of one in every substep, until it is changed or removed.
/// A torque at a point is the same; for one in the body's own frame there is [`ControlForce`]. What would turn a line about itself is lost.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A fan.
/// commands.spawn((RigidBox::new(Vec3::new(1.0, 0.1, 0.1)), ExternalTorque(Vec3::Y * 0.5)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ExternalTorque(pub Vec3);

/// An impulse on a body, a rigid part of one or a particle: it acts once, when the next tick begins, and is zero again. The same as
/// [`apply_impulse`](crate::BodyCommandsExt::apply_impulse) and its like, for who writes components rather than commands. On a body that is not built yet
/// it waits. A number that is not finite is refused and dropped.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn kick(mut balls: Query<&mut ExternalImpulse>) {
///     for mut impulse in &mut balls {
///         *impulse = ExternalImpulse::new(Vec3::new(0.0, 1.0, -3.0));
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ExternalImpulse {
    /// The impulse, N·s.
    pub impulse: Vec3,
    /// The angular impulse about the barycentre, N·m·s.
    pub angular_impulse: Vec3,
    /// The point of the world where `impulse` acts, metres. Default `None`: at the barycentre, so that it turns nothing.
    pub point: Option<Vec3>,
}

impl ExternalImpulse {
    /// An impulse at the barycentre, N·s.
    pub fn new(impulse: Vec3) -> Self {
        Self { impulse, ..default() }
    }

    /// An angular impulse, N·m·s.
    pub fn angular(angular_impulse: Vec3) -> Self {
        Self { angular_impulse, ..default() }
    }

    /// The same with the impulse at a point of the world, metres.
    pub fn at(self, point: Vec3) -> Self {
        Self { point: Some(point), ..self }
    }
}

/// Forces that act for one tick: what [`apply_force`](crate::BodyCommandsExt::apply_force) and its like have summed up since the last one. Part of the
/// state.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct TickForces {
    /// At the barycentre, N.
    pub force: Vec3,
    /// N·m.
    pub torque: Vec3,
    /// Forces, N, and the points of the world where they act, metres.
    pub at_points: Vec<(Vec3, Vec3)>,
}

impl TickForces {
    /// How many forces at points one entity takes in a tick: more than these in a game that is paused would fill its memory.
    pub const MOST: usize = 64;
}

/// Whose rows a control was last resolved into: changing a force every tick must not look them up every tick. Scratch.
#[derive(Component, Clone, Copy, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ResolvedTarget(pub(crate) Option<Entity>);
