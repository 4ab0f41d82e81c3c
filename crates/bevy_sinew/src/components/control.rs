//! Forces, torques and impulses that a game applies: engines, thrusters, kicks.

use bevy::prelude::*;

use super::order::CreationOrder;
use crate::rows::ResolvedRows;

/// A force and a torque that the game applies to a body as a whole, or to one particle, in every substep until they are changed or removed.
///
/// Put it on the body itself, or on an entity of its own, so that a body may have several; Bevy's `Name` on that entity is the name of the force. A force on an
/// entity of its own outlives the body, and then has no effect: add [`ConstraintOf`](super::ConstraintOf) to have it despawned with the body.
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
/// The force acts at the centre of mass (`F = m a`), or at a point, with its lever; the torque is distributed as in a rigid body. Pinned particles are not
/// affected. A component with a number that is not finite is refused once, and has no effect until it is corrected.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder, ResolvedRows<ControlForce>, ResolvedTarget)]
pub struct ControlForce {
    /// The body, the rigid part (any entity with a [`RigidPose`](super::RigidPose)) or the particle on which it acts. Default `None`: the entity that has this
    /// component.
    #[entities]
    pub on: Option<Entity>,
    /// The total force, N. Default zero.
    pub force: Vec3,
    /// The total torque, N·m. Default zero. A part that would turn a line about itself, or a single particle, has no effect.
    pub torque: Vec3,
    /// Where the force acts, metres. Default `None`: at the centre of mass, where it exerts no torque.
    pub point: Option<Vec3>,
    /// Whether `force`, `torque` and `point` are in the frame of the body's `Transform` at the beginning of the tick, instead of the world's. Default false. A
    /// particle has no frame; that of cloth and ropes does not turn with them.
    pub local: bool,
}

impl ControlForce {
    /// A force at the centre of mass, N.
    pub fn new(force: Vec3) -> Self {
        Self { force, ..default() }
    }

    /// A torque, N·m.
    pub fn torque(torque: Vec3) -> Self {
        Self { torque, ..default() }
    }

    /// Returns the same force on another body or particle than the entity that has the component.
    pub fn on(self, target: Entity) -> Self {
        Self { on: Some(target), ..self }
    }

    /// Returns the same control force, acting at a point, metres.
    pub fn at(self, point: Vec3) -> Self {
        Self { point: Some(point), ..self }
    }

    /// Returns the same force in the frame of the body.
    pub fn local(self) -> Self {
        Self { local: true, ..self }
    }
}

/// A torque in N·m, along the world's axes, that the game applies to a body or to a rigid part of one in every substep, until it is changed or removed. For a
/// torque in the body's own frame use [`ControlForce`]. A part that would turn a line about itself has no effect.
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

/// An impulse on a body, a rigid part of one or a particle: it is applied once, at the beginning of the next tick, and then reset to zero. The same as
/// [`apply_impulse`](crate::BodyCommandsExt::apply_impulse) and related commands, as a component. On a body that is not built yet it waits. A number that is
/// not finite is refused, and the impulse is dropped.
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
    /// The angular impulse about the centre of mass, N·m·s.
    pub angular_impulse: Vec3,
    /// The point of the world where `impulse` acts, metres. Default `None`: at the centre of mass, where it causes no spin.
    pub point: Option<Vec3>,
}

impl ExternalImpulse {
    /// An impulse at the centre of mass, N·s.
    pub fn new(impulse: Vec3) -> Self {
        Self { impulse, ..default() }
    }

    /// An angular impulse, N·m·s.
    pub fn angular(angular_impulse: Vec3) -> Self {
        Self { angular_impulse, ..default() }
    }

    /// Returns the same impulse, acting at a point of the world, metres.
    pub fn at(self, point: Vec3) -> Self {
        Self { point: Some(point), ..self }
    }
}

/// Forces that act for one tick: the sum of [`apply_force`](crate::BodyCommandsExt::apply_force) and related commands since the last one. Part of the state.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct TickForces {
    /// Force at the centre of mass, N.
    pub force: Vec3,
    /// Torque, N·m.
    pub torque: Vec3,
    /// Forces, N, and the points of the world where they act, metres.
    pub at_points: Vec<(Vec3, Vec3)>,
}

impl TickForces {
    /// How many forces at points one entity may have in a tick; a further one is refused. Without a limit, a game that is paused could fill the memory.
    pub const MAX: usize = 64;
}

/// The target whose rows a control force was last resolved into, so that changing a force in every tick needs no look-up. Scratch.
#[derive(Component, Clone, Copy, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ResolvedTarget(pub(crate) Option<Entity>);
