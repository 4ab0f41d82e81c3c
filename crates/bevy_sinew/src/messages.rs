//! What the simulation says when something is wrong: one message, once, that names the entity.

use std::collections::BTreeMap;

use bevy::prelude::*;
use sinew::recipes::RecipeFault;
use sinew::{ConstraintFault, DistanceFault, HullFault, ParticleFault, SpringFault};

use crate::components::ColliderFault;
use crate::frames::Misplaced;

/// Something was set aside, or put back. The rest of the simulation goes on as if it were not there.
///
/// Sent once when it happens, and again only after it was mended and broke anew. It is logged as a warning as well.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::Refused;
/// /// What is wrong with a level, where its author sees it.
/// fn complain(mut refused: MessageReader<Refused>) {
///     for refused in refused.read() {
///         eprintln!("{} {}", refused.entity, refused.reason);
///     }
/// }
/// ```
#[derive(Message, Reflect, Clone, Debug, PartialEq)]
#[reflect(Clone, PartialEq)]
pub struct Refused {
    /// The particle, spring, constraint or body.
    pub entity: Entity,
    /// What is wrong with it.
    pub reason: Refusal,
}

/// Why something was refused. Its text reads on after the name of the entity.
#[derive(Reflect, Clone, Debug, PartialEq, thiserror::Error)]
#[reflect(opaque, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Refusal {
    /// A particle with a bad number; it is left out until the number is mended.
    #[error("is set aside: {0}")]
    Particle(ParticleFault),
    /// A body whose [`Mass`](crate::Mass), [`Radius`](crate::Radius), [`Charge`](crate::Charge) or [`Drag`](crate::Drag) is a bad number; its particles stay as
    /// they are.
    #[error("leaves its particles as they are: {0}")]
    Body(ParticleFault),
    /// A particle that turned non-finite during a tick; it is put back to where the tick began, at rest.
    #[error("turned non-finite and was put back to where the tick began, at rest")]
    Diverged,
    /// A distance constraint that cannot be enforced; it is left out until it is mended.
    #[error("is set aside: {0}")]
    Distance(DistanceFault),
    /// A spring that cannot act; it is left out until it is mended.
    #[error("is set aside: {0}")]
    Spring(SpringFault),
    /// Any other constraint that cannot be enforced; it is left out until it is mended.
    #[error("is set aside: {0}")]
    Constraint(ConstraintFault),
    /// A particle pinned to an entity that is gone: it was let go.
    #[error("was let go: the entity it is pinned to, {0}, is gone or has no transform")]
    PinTarget(Entity),
    /// An [`AttachTo`](crate::AttachTo) whose other entity is gone: it let go.
    #[error("let go: the entity it was attached to, {0}, is gone")]
    AttachTarget(Entity),
    /// An [`AttachTo`](crate::AttachTo) that cannot take hold; it ties nothing until it is mended.
    #[error("is not attached: {0}")]
    Attach(AttachFault),
    /// A field, an attractor or the like with a number (of its transform, of its [`Region`](crate::Region)) that is none, or out
    /// of range; it does nothing until that is mended.
    #[error("does nothing: a number of it or of its transform is not finite or out of range")]
    Surroundings,
    /// A resource of the surroundings ([`Gravity`](crate::Gravity), [`AirDrag`](crate::AirDrag), [`Electric`](crate::Electric)) with a number that is
    /// none, or out of range; it does nothing until that is mended. The entity is the one that Bevy keeps the resource on.
    #[error("is the resource {0}, and does nothing: a number of it is not finite or out of range")]
    Resource(&'static str),
    /// A body with [`Floats`](crate::Floats) but without a shape to float by; its particles float as balls until that is mended.
    #[error("floats as the balls of its particles: {0}")]
    Hull(HullFault),
    /// A body with a [`GravityScale`](crate::GravityScale) that is not finite; it falls as without one.
    #[error("falls as without a GravityScale: that is not finite")]
    GravityScale,
    /// A body that is to be rigid but has no [`RigidPose`](crate::RigidPose), such as cloth; it goes on as particles.
    #[error("goes on as particles: only a body with a RigidPose can be rigid")]
    Representation,
    /// A collider with a broken number, or of no shape; it is left out until it is mended.
    #[error("is set aside: {0}")]
    Collider(ColliderFault),
    /// A body or a particle whose [`SurfaceMaterial`](crate::SurfaceMaterial) has a number that is not finite or out of range; it is as without one
    /// until that is mended.
    #[error("is as without a SurfaceMaterial: a number of that is not finite or out of range")]
    Material,
    /// A collider whose [`Weighs`](crate::Weighs) has a number that is not finite or is negative; it presses on nothing until that is mended.
    #[error("presses on nothing: a number of its Weighs is not finite or is negative")]
    Weight,
    /// A rigid part that cannot collide by its [`Collider`](crate::Collider), such as one that is a mesh; it collides by its particles.
    #[error("collides by its particles: {0}")]
    Part(sinew::BodyColliderFault),
    /// A body that is to collide as a solid but has no rigid part with a [`Collider`](crate::Collider); it collides by its particles.
    #[error("collides by its particles: it has no rigid part with a Collider")]
    NotSolid,
    /// A body that is to collide by its triangles but has no [`WindSurface`](crate::WindSurface) that lists any; it collides by its particles.
    #[error("collides by its particles: it has no WindSurface with triangles")]
    NoTriangles,
    /// A body that is to collide by its segments but has no [`DistanceConstraint`](crate::DistanceConstraint) between two of its particles that have
    /// a [`Radius`](crate::Radius); it collides by its particles.
    #[error("collides by its particles: it has no rod between two that have a radius")]
    NoSegments,
    /// A command on a body or a particle that cannot be done; nothing changed.
    #[error("is left as it is: {0}")]
    Edit(EditFault),
    /// A control force that cannot act; it does nothing until it is mended.
    #[error("does nothing: {0}")]
    Control(EditFault),
    /// A pin that leads nowhere; the particle is held where it is.
    #[error("is held where it is: the point it is pinned to is not finite")]
    PinPoint,
    /// A body whose recipe asks for the impossible; it has no particles.
    #[error("cannot be built: {0}")]
    Recipe(#[from] RecipeFault),
    /// A body, a collider or a field that is turned within a parent whose scale is not the same in all directions, which would shear it; or a rigid body
    /// within any such parent, because it will turn. It is left out until that is mended.
    #[error("is left out: a parent that is scaled unevenly would shear it")]
    Sheared,
    /// A body or a region that is round, or a figure, and is scaled differently in different directions. It is left out until that is mended.
    #[error("is left out: it cannot be scaled differently in different directions")]
    UnevenScale,
    /// A body whose transform is not finite or has no size: its particles would have nowhere to be.
    #[error("cannot be built: its transform is not finite, or has no size")]
    Transform,
    /// A body from a mesh, without `Mesh3d`.
    #[error("cannot be built: it is to be made from a mesh, but has no Mesh3d")]
    NoMesh,
    /// A body from a mesh that has no readable positions or triangles.
    #[error("cannot be built: its mesh has no positions and triangles that the CPU can read")]
    UnreadableMesh,
    /// A mesh that does not have as many vertices as its `MeshFollow` has entries.
    #[error("is not deformed: its mesh and its MeshFollow differ in the number of vertices")]
    VertexCount,
    /// A mesh that failed to load.
    #[error("cannot be built: its mesh failed to load")]
    MeshLoad,
}

impl From<Misplaced> for Refusal {
    fn from(misplaced: Misplaced) -> Self {
        match misplaced {
            Misplaced::Sheared => Self::Sheared,
            Misplaced::Uneven => Self::UnevenScale,
        }
    }
}

/// Why a command or a control force has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EditFault {
    /// A number that it was given is NaN or infinite, or a rotation is none; or what comes of it is.
    #[error("a number of what is asked of it is not finite, or would not be")]
    NotFinite,
    /// It is neither a body nor a rigid part nor a particle, or is gone.
    #[error("it is neither a body nor a particle")]
    NoParticles,
    /// A body to be teleported that has no `Transform`, or one that is no place.
    #[error("its Transform, from which it would be moved, is missing or not finite")]
    NoTransform,
    /// A body that waits for its particles with more edits than [`PendingEdits::MOST`](crate::PendingEdits::MOST), or for its tick with more forces at
    /// points than [`TickForces::MOST`](crate::TickForces::MOST).
    #[error("too many edits wait for its particles, or for the next tick")]
    TooMany,
}

/// Why an [`AttachTo`](crate::AttachTo) does not take hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AttachFault {
    /// What is to be tied has no particles.
    #[error("it stands on nothing that has particles, nor is it the attachment of such")]
    NoParticles,
    /// A part of the body that it does not have: a vertex beyond the last, a bone of another name, a region without particles, a corner of what is no box,
    /// an end of what is no rope.
    #[error("the body has no such part")]
    NoSuchPart,
    /// The same on the other entity.
    #[error("the entity that it is to be attached to has no such anchor")]
    NoSuchAnchor,
    /// The other entity has neither particles nor a transform, or a parent shears it.
    #[error("the entity that it is to be attached to has no place")]
    NoPlace,
    /// It would be tied to itself.
    #[error("it would be attached to itself")]
    Itself,
    /// A number that is not finite, or a softness out of range.
    #[error("one of its numbers is not finite or out of range")]
    Number,
}

/// What is set aside and why, by entity and by the number of which of its links: so that each is reported once.
pub(crate) type ReportedErrors = BTreeMap<(Entity, usize), Refusal>;

/// Logs a refusal and sends it.
pub(crate) fn refuse(messages: &mut MessageWriter<Refused>, entity: Entity, reason: Refusal) {
    warn!("sinew: entity {entity} {reason}");
    messages.write(Refused { entity, reason });
}
