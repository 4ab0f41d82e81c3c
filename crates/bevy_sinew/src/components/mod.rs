//! What a game spawns, edits and reads: plain data, the whole state of the simulation.

mod body;
mod collide;
mod constraint;
mod control;
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
pub use constraint::{
    AngleConstraint, AnyConstraint, AreaConstraint, BendConstraint, Bound, BreakAt,
    CollinearConstraint, ConeConstraint, CoplanarConstraint, DistanceConstraint, HingeConstraint,
    ParticleConstraint, PatchConstraint, RigidConstraint, SizeCorrection, Spring,
    TetrahedronConstraint, VolumeConstraint,
};
pub use control::{ControlForce, ExternalImpulse, ExternalTorque, TickForces};
pub use environment::{
    AirDrag, AirFlow, Attractor, BoundingBox, Electric, ElectricField, Flatland, Floats, Fluid,
    Gravity, Ground, HullShape, Region, RegionShape, Wind,
};
pub use order::CreationOrder;
pub use particle::{
    Charge, Drag, ExternalForce, Mass, Particle, ParticleRow, Pinned, PinnedTo, Radius,
};

pub use sleep::{Sleep, SleepingDisabled};
pub use softness::Softness;

pub(crate) use collide::{Orphans, PlacedCollider, ResolvedShape};
pub(crate) use control::ResolvedTarget;
pub(crate) use order::{CreationCounter, TopologyChanged};

use bevy::prelude::*;

/// Registers every component for reflection, for apps that do not register types by themselves.
pub(crate) fn register(app: &mut App) {
    collide::register(app);
    constraint::register(app);
    environment::register(app);
    app.register_type::<Particle>()
        .register_type::<BodyPart>()
        .register_type::<PartOf>()
        .register_type::<BodyParts>()
        .register_type::<BuiltBody>()
        .register_type::<Mass>()
        .register_type::<Pinned>()
        .register_type::<PinnedTo>()
        .register_type::<Radius>()
        .register_type::<Charge>()
        .register_type::<Drag>()
        .register_type::<ExternalForce>()
        .register_type::<CreationOrder>()
        .register_type::<ParticleBody>()
        .register_type::<ParticleOf>()
        .register_type::<BodyParticles>()
        .register_type::<ConstraintOf>()
        .register_type::<BodyConstraints>()
        .register_type::<RigidPose>()
        .register_type::<WindSurface>()
        .register_type::<MeshFollow>()
        .register_type::<TubeMesh>()
        .register_type::<Interpolate>()
        .register_type::<ExtractedTransform>()
        .register_type::<ExtractedVelocity>()
        .register_type::<LinearVelocity>()
        .register_type::<AngularVelocity>()
        .register_type::<WorldCenterOfMass>()
        .register_type::<Inertia>()
        .register_type::<ControlForce>()
        .register_type::<ExternalTorque>()
        .register_type::<ExternalImpulse>()
        .register_type::<TickForces>()
        .register_type::<BodyReport>()
        .register_type::<Representation>()
        .register_type::<GravityScale>()
        .register_type::<Sleep>()
        .register_type::<SleepingDisabled>()
        .register_type::<Softness>();
}
