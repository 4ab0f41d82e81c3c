//! Error reports: one message for each error, once, which names the entity.

use std::collections::BTreeMap;

use bevy::prelude::*;
use sinew::recipes::RecipeFault;
use sinew::{ConstraintFault, DistanceFault, HullFault, ParticleFault, SpringFault};

use crate::components::ColliderFault;
use crate::frames::Misplaced;

/// Something invalid was set aside, or a command was refused. The rest of the simulation continues as if it did not exist.
///
/// Sent once when the error occurs, and again only if it occurs again after it was corrected. It is logged as a warning as well.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::Refused;
/// /// Prints the errors of a level.
/// fn complain(mut refused: MessageReader<Refused>) {
///     for refused in refused.read() {
///         eprintln!("{} {}", refused.entity, refused.reason);
///     }
/// }
/// ```
#[derive(Message, Reflect, Clone, Debug, PartialEq)]
#[reflect(Clone, PartialEq)]
pub struct Refused {
    /// The particle, spring, constraint, body, collider or field.
    pub entity: Entity,
    /// What is wrong with it.
    pub reason: Refusal,
}

/// Why something was refused. Its text is a predicate: it follows the name of the entity.
#[derive(Reflect, Clone, Debug, PartialEq, thiserror::Error)]
#[reflect(opaque, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// A particle has an invalid number; it is set aside until that is corrected.
    #[error("is set aside: {0}")]
    Particle(ParticleFault),
    /// A body's [`Mass`](crate::Mass), [`Radius`](crate::Radius), [`Charge`](crate::Charge) or [`Drag`](crate::Drag) is invalid; its particles are not changed.
    #[error("has an invalid property, and its particles are not changed: {0}")]
    Body(ParticleFault),
    /// A particle became non-finite during a tick; it is put back to its position at the start of the tick, at rest.
    #[error("became non-finite and is reset to its position at the start of the tick, at rest")]
    Diverged,
    /// A distance constraint is invalid; it is set aside until that is corrected.
    #[error("is set aside: {0}")]
    Distance(DistanceFault),
    /// A spring is invalid; it is set aside until that is corrected.
    #[error("is set aside: {0}")]
    Spring(SpringFault),
    /// A constraint of any other kind is invalid; it is set aside until that is corrected.
    #[error("is set aside: {0}")]
    Constraint(ConstraintFault),
    /// The entity to which a particle was pinned is gone; the particle was released.
    #[error("is released: the entity to which it was pinned, {0}, is gone or has no transform")]
    PinTarget(Entity),
    /// The other entity of an [`AttachTo`](crate::AttachTo) is gone; the attachment was released.
    #[error("is released: the entity to which it was attached, {0}, is gone")]
    AttachTarget(Entity),
    /// An [`AttachTo`](crate::AttachTo) cannot be made; it attaches nothing until that is corrected.
    #[error("is not attached: {0}")]
    Attach(AttachFault),
    /// A field or an attractor has an invalid number, of its own, of its transform or of its [`Region`](crate::Region); it has no effect until that is
    /// corrected.
    #[error("has no effect: a number of it or of its transform is not finite or out of range")]
    Field,
    /// A resource of the environment ([`Gravity`](crate::Gravity), [`AirDrag`](crate::AirDrag), [`Electric`](crate::Electric)) has an invalid number; it has no
    /// effect until that is corrected. The entity is the one on which Bevy stores the resource.
    #[error(
        "is the resource {0}, which has no effect: a number of it is not finite or out of range"
    )]
    Resource(&'static str),
    /// A body with [`Floats`](crate::Floats) has no hull; its particles float as balls until that is corrected.
    #[error("floats as the balls of its particles: {0}")]
    Hull(HullFault),
    /// The [`GravityScale`](crate::GravityScale) of a body is not finite; it counts as 1.
    #[error("falls with unscaled gravity: its GravityScale is not finite")]
    GravityScale,
    /// A body that is to be an explicit rigid body has no [`RigidPose`](crate::RigidPose), such as cloth; it remains particles.
    #[error("remains particles: only a body with a RigidPose can be rigid")]
    Representation,
    /// A collider has an invalid number or shape; it is set aside until that is corrected.
    #[error("is set aside: {0}")]
    Collider(ColliderFault),
    /// The [`SurfaceMaterial`](crate::SurfaceMaterial) of a body or a particle has a number that is not finite or out of range; the default applies until that
    /// is corrected.
    #[error(
        "has the default material: a number of its SurfaceMaterial is not finite or out of range"
    )]
    Material,
    /// The [`Weighs`](crate::Weighs) of a collider has a number that is not finite or negative; it has no effect until that is corrected.
    #[error("has no weight: a number of its Weighs is not finite or is negative")]
    Weight,
    /// A rigid part cannot collide by its [`Collider`](crate::Collider), for instance a mesh; it collides by its particles.
    #[error("collides by its particles: {0}")]
    Part(sinew::BodyColliderFault),
    /// A body that is to collide by its rigid parts has none with a [`Collider`](crate::Collider); it collides by its particles.
    #[error("collides by its particles: it has no rigid part with a Collider")]
    NotSolid,
    /// A body that is to collide by its triangles has no [`WindSurface`](crate::WindSurface) with any; it collides by its particles.
    #[error("collides by its particles: it has no WindSurface with triangles")]
    NoTriangles,
    /// A body that is to collide by its segments has no [`DistanceConstraint`](crate::DistanceConstraint) between two of its particles with a
    /// [`Radius`](crate::Radius); it collides by its particles.
    #[error("collides by its particles: it has no rod between two particles with a radius")]
    NoSegments,
    /// A command on a body or a particle cannot be executed; nothing changed.
    #[error("is not changed: {0}")]
    Edit(EditFault),
    /// A control force cannot act; it has no effect until that is corrected.
    #[error("has no effect: {0}")]
    Control(EditFault),
    /// The target of a pin is not finite; the particle is held where it is.
    #[error("is held where it is: the point it is pinned to is not finite")]
    PinPoint,
    /// The numbers of a recipe are invalid; the body has no particles.
    #[error("cannot be built: {0}")]
    Recipe(#[from] RecipeFault),
    /// A body, a collider or a field is rotated within a parent with a non-uniform scale, which would shear it; or a rigid body, which may rotate, is within
    /// such a parent. It is left out until that is corrected.
    #[error("is left out: a parent with a non-uniform scale would shear it")]
    Sheared,
    /// A body or a region that is round, or a figure, is scaled non-uniformly. It is left out until that is corrected.
    #[error("is left out: it cannot have a non-uniform scale")]
    UnevenScale,
    /// A rigid body in a 2D world ([`Flatland`](crate::Flatland)) is not flat: its rods would contradict the plane. It is left out until the world is no longer
    /// two-dimensional, or the body is changed.
    #[error("is left out: it is not flat, and the world is two-dimensional")]
    NotFlat,
    /// The transform of a body is not finite, or its scale is zero.
    #[error("cannot be built: its transform is not finite, or has no size")]
    Transform,
    /// A body is to be made from a mesh, but has no `Mesh3d`.
    #[error("cannot be built: it is to be made from a mesh, but has no Mesh3d")]
    NoMesh,
    /// The mesh that a body is to be made from has no readable positions or triangles.
    #[error("cannot be built: its mesh has no positions and triangles that the CPU can read")]
    UnreadableMesh,
    /// A mesh does not have as many vertices as its `MeshFollow` has entries.
    #[error("is not deformed: its mesh and its MeshFollow differ in the number of vertices")]
    VertexCount,
    /// The mesh of a body failed to load.
    #[error("cannot be built: its mesh failed to load")]
    MeshLoad,
}

impl From<Misplaced> for Refusal {
    fn from(misplaced: Misplaced) -> Self {
        match misplaced {
            Misplaced::Sheared => Self::Sheared,
            Misplaced::NonUniform => Self::UnevenScale,
        }
    }
}

/// Why a command or a control force has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EditFault {
    /// One of its numbers is NaN or infinite, or a rotation has no length; or the result would be.
    #[error("a number is not finite, or would not be in the result")]
    NotFinite,
    /// The entity is neither a body nor a rigid part nor a particle, or is gone.
    #[error("it is neither a body nor a particle")]
    NoParticles,
    /// The body to be teleported has no `Transform`, or an invalid one.
    #[error("its Transform is missing or not finite, so it cannot be moved")]
    NoTransform,
    /// More edits wait for the body's particles than [`PendingEdits::MAX`](crate::PendingEdits::MAX), or more forces at points wait for the next tick than
    /// [`TickForces::MAX`](crate::TickForces::MAX).
    #[error("too many edits wait for its particles, or for the next tick")]
    TooMany,
}

/// Why an [`AttachTo`](crate::AttachTo) cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AttachFault {
    /// The entity to be attached has no particles.
    #[error("the entity that is to be attached has no particles")]
    NoParticles,
    /// The body has no such part: a vertex beyond the last, a bone of another name, a region without particles, a corner of what is not a box, an end of what
    /// is not a rope.
    #[error("the body has no such part")]
    NoSuchPart,
    /// The other entity has no such place.
    #[error("the entity to which it is to be attached has no such anchor")]
    NoSuchAnchor,
    /// The other entity has neither particles nor a transform, or a parent shears it.
    #[error("the entity to which it is to be attached has neither particles nor a valid transform")]
    NoPlace,
    /// The body would be attached to itself.
    #[error("it would be attached to itself")]
    Itself,
    /// A number is not finite, or the softness is out of range.
    #[error("one of its numbers is not finite or out of range")]
    Number,
}

/// The errors that were reported, by entity and kind of constraint, so that each is reported once.
pub(crate) type ReportedErrors = BTreeMap<(Entity, usize), Refusal>;

/// Logs an error and sends the message.
pub(crate) fn refuse(messages: &mut MessageWriter<Refused>, entity: Entity, reason: Refusal) {
    messages.write(logged(entity, reason));
}

/// As [`refuse`], with exclusive access to the world.
pub(crate) fn refuse_in(world: &mut World, entity: Entity, reason: Refusal) {
    world.write_message(logged(entity, reason));
}

fn logged(entity: Entity, reason: Refusal) -> Refused {
    warn!("sinew: entity {entity} {reason}");
    Refused { entity, reason }
}
