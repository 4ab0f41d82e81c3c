//! What a game spawns, edits and reads: plain data, the whole state of the simulation.

mod body;
mod constraint;
mod environment;
mod order;
mod particle;

pub use body::{
    AngularVelocity, Barycenter, BodyConstraints, BodyParticles, ConstraintOf, ExtractedTransform,
    Interpolate, LinearVelocity, MeshFollow, ParticleBody, ParticleOf, RigidPose, TubeMesh,
    WindSurface,
};
pub use constraint::{Bound, DistanceConstraint, Spring};
pub use environment::{AirDrag, BoundingBox, Electric, Fluid, Gravity, Ground, Wind};
pub use order::CreationOrder;
pub use particle::{
    Charge, Drag, ExternalForce, Mass, Particle, ParticleRow, Pinned, PinnedTo, Radius,
};

pub(crate) use order::{CreationCounter, TopologyChanged};

use bevy::prelude::*;

/// Registers every component for reflection, for apps that do not register types by themselves.
pub(crate) fn register(app: &mut App) {
    app.register_type::<Particle>()
        .register_type::<Mass>()
        .register_type::<Pinned>()
        .register_type::<PinnedTo>()
        .register_type::<Radius>()
        .register_type::<Charge>()
        .register_type::<Drag>()
        .register_type::<ExternalForce>()
        .register_type::<CreationOrder>()
        .register_type::<DistanceConstraint>()
        .register_type::<Spring>()
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
        .register_type::<LinearVelocity>()
        .register_type::<AngularVelocity>()
        .register_type::<Barycenter>()
        .register_type::<Gravity>()
        .register_type::<AirDrag>()
        .register_type::<Electric>()
        .register_type::<Wind>()
        .register_type::<Fluid>()
        .register_type::<Ground>()
        .register_type::<BoundingBox>();
}
