//! The list of every component and resource of this crate that is state. A missing type is found by a test that reads the source of this crate
//! (`tests/state_list.rs`, which lists the types that are not state with the reason).

use bevy::ecs::entity_disabling::Disabled;
use bevy::prelude::*;

use super::eased::tick_end;
use super::types;
use super::values::{Options, StateRole, empty, join, join_listed, kind, put_resource, supply};
use crate::attach::{
    AnchorConstraint, AttachTo, Attached, AttachmentJoints, AttachmentOf, BodyAttachments, JointOf,
};
use crate::commands::{PendingEdits, Relax};
use crate::components::{
    AirDrag, AirFlow, AngularVelocity, Attractor, BodyConstraints, BodyContacts, BodyPart,
    BodyParticles, BodyParts, BodyReport, BoundingBox, BreakAt, BuiltBody, Charge, Collider,
    ColliderMotion, CollisionLayers, ConstraintOf, ContactCache, ContactEvents, ContactsDisabled,
    ControlForce, CreationCounter, CreationOrder, DisabledWithBody, DistanceConstraint, Drag,
    Electric, ElectricField, ExternalForce, ExternalImpulse, ExternalTorque, ExtractedTransform,
    ExtractedVelocity, Flatland, Floats, Fluid, Gravity, GravityScale, Ground, Inertia,
    Interpolate, LinearVelocity, Mass, MeshFollow, Orphans, PartOf, Particle, ParticleBody,
    ParticleOf, Pinned, PinnedTo, Radius, Region, Representation, RestPlace, RigidPose, Sensor,
    Sleep, SleepingDisabled, Spring, SurfaceMaterial, TickForces, Touching, TubeMesh, Weighs, Wind,
    WindSurface, WorldCenterOfMass, for_each_constraint,
};
use crate::config::{BodySolver, SolverConfig};
use crate::recipes::{
    Articulated, AwaitsMesh, AwaitsPlace, Built, Cloth, MadeFrom, Ragdoll, Rescaled, RigidBox,
    RigidMesh, Rope, SoftBody, TiedEnd,
};
use crate::schedule::{SinewClock, SinewControl};

/// Plain components that make their entity part of the simulation.
macro_rules! components {
    ($app:ident: $($component:ty,)*) => {$(
        $app.register_type::<$component>();
        types::add($app.world_mut(), kind(Options::<$component>::reflected()));
    )*};
}

/// Recipes, with what they were built from.
macro_rules! recipes {
    ($app:ident: $($recipe:ty,)*) => {$(
        components!($app: $recipe,);
        $app.register_type::<Built<$recipe>>();
        let built = Options::<Built<$recipe>>::reflected();
        let (role, on_foreign) = (StateRole::Carried, Some(Built::forget_mesh as fn(&mut Built<$recipe>)));
        types::add($app.world_mut(), kind(Options { role, on_foreign, ..built }));
        let awaits = Options::<AwaitsMesh<$recipe>>::plain();
        types::add($app.world_mut(), kind(Options { role: StateRole::Local, hashed: false, ..awaits }));
    )*};
}

/// Relationships, and the lists of related entities in the order in which they were added.
macro_rules! relationships {
    ($app:ident: $($relationship:ty => $list:ty,)*) => {$(
        $app.register_type::<$relationship>().register_type::<$list>();
        let joined = Options::<$relationship>::with(join::<$relationship>).viewed();
        types::add($app.world_mut(), kind(joined));
        let list = Options::<$list>::reflected();
        let disconnect = Some(empty::<$list> as fn(&mut World, Entity));
        types::add($app.world_mut(), kind(Options { disconnect, lists: true, ..list }));
    )*};
}

macro_rules! resources {
    ($app:ident: $($resource:ty,)*) => {$(
        $app.register_type::<$resource>();
        let options = Options::<$resource>::with(put_resource::<$resource>).viewed();
        types::add($app.world_mut(), kind(Options { role: StateRole::Resource, ..options }));
    )*};
}

/// Registers all state types of this crate.
pub(crate) fn add(app: &mut App) {
    // The order of creation first, so that components that require it find it.
    components!(app:
        CreationOrder,
        // Particles and constraints.
        Particle, Mass, Pinned, PinnedTo, Radius, Charge, Drag, ExternalForce, RestPlace,
        DistanceConstraint, Spring,
    );
    for_each_constraint!(components!(app:));
    components!(app:
        AnchorConstraint, BreakAt, AttachTo, Attached, TiedEnd,
        // Bodies.
        ParticleBody, BuiltBody, RigidPose, BodyPart, WindSurface, MeshFollow, TubeMesh, Interpolate,
        ExtractedTransform, LinearVelocity, AngularVelocity, ExtractedVelocity, WorldCenterOfMass, Inertia,
        ControlForce, ExternalTorque, ExternalImpulse, TickForces, PendingEdits, Relax,
        GravityScale, BodySolver, Representation, Sleep, SleepingDisabled, Floats,
        // Environment.
        Wind, AirFlow, Fluid, Region, Attractor, ElectricField, Flatland, Ground, BoundingBox,
        // Contacts.
        Collider, ColliderMotion, ContactCache, SurfaceMaterial, CollisionLayers, Sensor, BodyContacts,
        ContactsDisabled, ContactEvents, Weighs,
    );
    recipes!(app: RigidBox, Rope, Cloth, Ragdoll, RigidMesh, SoftBody, Articulated,);
    relationships!(app:
        ParticleOf => BodyParticles,
        ConstraintOf => BodyConstraints,
        PartOf => BodyParts,
        AttachmentOf => BodyAttachments,
        JointOf => AttachmentJoints,
    );
    resources!(app:
        SolverConfig, SinewClock, SinewControl, Gravity, AirDrag, Electric, CreationCounter, Orphans,
    );
    add_special(app);
}

/// Registers the types with special options.
fn add_special(app: &mut App) {
    app.register_type::<(Touching, BodyReport, Transform, Name, ChildOf)>();
    app.register_type::<(Disabled, DisabledWithBody)>();
    // Contacts that are cleared by a restore must not send events.
    let disconnect: Option<fn(&mut World, Entity)> = Some(|world, entity| {
        if let Some(mut touching) = world.get_mut::<Touching>(entity) {
            touching.0.clear();
        }
    });
    let touching = Options { disconnect, ..Options::<Touching>::reflected() };
    // Added by tools, and with wall-clock times, so it is not hashed.
    let report = Options { hashed: false, ..Options::<BodyReport>::reflected() };
    let role = StateRole::Carried;
    let transform = Options::<Transform>::reflected();
    let transform = Options { role, pruned: false, on_capture: Some(tick_end), ..transform };
    let name = Options { role, pruned: false, ..Options::<Name>::reflected() };
    let disabled = Options { role, ..Options::<Disabled>::reflected() };
    let with_body = Options { role, ..Options::<DisabledWithBody>::reflected() };
    let parent = Options { role, ..Options::<ChildOf>::with(join_listed::<ChildOf>).viewed() };
    // Handles and markers that are valid in their own world only.
    let role = StateRole::Local;
    let (pruned, hashed) = (false, false);
    let mesh = Options::<Mesh3d>::with(supply::<Mesh3d>);
    let made = Options::<MadeFrom>::with(supply::<MadeFrom>);
    let rescaled = Options { role, hashed, ..Options::<Rescaled>::plain() };
    let place = Options { role, hashed, ..Options::<AwaitsPlace>::plain() };
    let world = app.world_mut();
    types::add(world, kind(touching));
    types::add(world, kind(report));
    types::add(world, kind(transform));
    types::add(world, kind(name));
    types::add(world, kind(parent));
    types::add(world, kind(disabled));
    types::add(world, kind(with_body));
    types::add(world, kind(Options { role, pruned, hashed, ..mesh }));
    types::add(world, kind(Options { role, pruned, hashed, ..made }));
    types::add(world, kind(rescaled));
    types::add(world, kind(place));
}
