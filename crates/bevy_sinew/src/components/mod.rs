//! The components and resources that a game spawns, edits and reads: plain data, the whole state of the simulation.

mod body;
mod collide;
mod constraint;
mod control;
mod disabled;
mod environment;
mod order;
mod particle;
mod sleep;
mod softness;

pub use body::{
    AngularVelocity, BodyConstraints, BodyPart, BodyParticles, BodyParts, BodyReport, BuiltBody,
    ConstraintOf, ExtractedTransform, ExtractedVelocity, GravityScale, Inertia, Interpolate,
    LinearVelocity, MeshFollow, PartOf, ParticleBody, ParticleOf, Representation, RigidIntegrator,
    RigidPose, TubeMesh, WindSurface, WorldCenterOfMass,
};
pub use collide::{
    BodyContacts, Collider, ColliderFault, ColliderMotion, ColliderShape, CollisionLayer,
    CollisionLayers, Combine, ContactCache, ContactEnded, ContactEvents, ContactShape,
    ContactStarted, ContactsDisabled, GroundDrag, RestPlace, Sensor, SurfaceMaterial, Touching,
};
pub use collide::{ContactImpulse, WatchedContacts, Weighs};
pub use constraint::*;
pub use control::{ControlForce, ExternalImpulse, ExternalTorque, TickForces};
pub use environment::*;
pub use order::CreationOrder;
pub use particle::{
    Charge, Drag, ExternalForce, Mass, Particle, ParticleRow, Pinned, PinnedTo, Radius,
};

pub use sleep::{Sleep, SleepingDisabled};
pub use softness::Softness;

pub(crate) use body::DrawnTransform;
pub(crate) use collide::end_contacts;
pub(crate) use collide::{Orphans, PlacedCollider, ResolvedShape};
pub(crate) use control::ResolvedTarget;
pub(crate) use disabled::{DisabledWithBody, LeftAt, Toggled};
pub(crate) use order::{CreationCounter, TopologyChanged, fill_sorted};
