//! Particle physics for Bevy: Verlet particles, springs and positional constraints as plain ECS data, which become boxes, ropes, ragdolls
//! and cloth.
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_sinew::prelude::*;
//!
//! fn main() {
//!     let mut app = App::new();
//!     app.add_plugins((MinimalPlugins, SinewPlugins)).add_systems(Startup, setup);
//!     # app.finish();
//!     app.update();
//! }
//!
//! fn setup(mut commands: Commands) {
//!     commands.spawn(Ground);
//!     commands.spawn((RigidBox::new(Vec3::ONE), Transform::from_xyz(0.0, 3.0, 0.0)));
//! }
//! ```
//!
//! # What a game touches
//!
//! - A **particle** is an entity with [`Particle`] and [`Mass`]; [`Pinned`], [`PinnedTo`], [`Radius`], [`Charge`], [`Drag`] and [`ExternalForce`] say
//!   more.
//! - A **spring** or a **constraint** is an entity: [`Spring`], [`DistanceConstraint`], [`AngleConstraint`], [`VolumeConstraint`], … and those of a
//!   game's own ([`ParticleConstraint`]). Add, change or despawn one and the next tick knows.
//! - A **body** is an entity with a recipe: [`RigidBox`], [`RigidMesh`], [`Rope`], [`Cloth`], [`SoftBody`], [`Articulated`], [`Ragdoll`]. It builds
//!   its particles, and takes them with it.
//! - What **moves a body** is its velocity ([`LinearVelocity`], [`AngularVelocity`]: spawned with it, or written at any time), a force
//!   ([`ExternalForce`], [`ExternalTorque`], [`ControlForce`] for one at a point), an impulse ([`ExternalImpulse`]), or a command for any of them and for
//!   teleports ([`BodyCommandsExt`]). [`Mass`], [`Radius`], [`Charge`] and [`Drag`] on a body mean the body, and are shared out onto its particles.
//! - The **surroundings** are [`Gravity`], [`AirDrag`], [`Electric`] (resources), [`Wind`], [`AirFlow`], [`Fluid`], [`ElectricField`] (entities,
//!   everywhere or in a [`Region`]), [`Attractor`] and, for a world in 2D, [`Flatland`]. A body [`Floats`] by its shape.
//! - A **collider** is an entity with a shape, [`Collider`], that stands still or that the game moves by its `Transform`; [`Ground`] and [`BoundingBox`] are names for two of them. [`SurfaceMaterial`],
//!   [`CollisionLayers`] and [`Sensor`] say more. Whatever a recipe builds meets colliders and all other bodies: rigid ones by their shape, others by
//!   what of them lets nothing through ([`ContactShape::Auto`]). [`BodyContacts`] says it otherwise, [`ContactsDisabled`] takes a body out.
//! - A **parent** is honoured: bodies, colliders and regions stand where Bevy would draw them ([`ParticleBody`] says what holds for one that moves).
//! - **Time** has a pause, single steps and a speed of its own: [`SinewControl`]. [`Relax`] and [`RelaxWorld`] bring a body or everything to rest without
//!   waiting for it.
//! - **Questions** to the world are asked through [`SinewQuery`]: rays, shapes on their way, overlaps, the nearest particle, and where a character comes to
//!   ([`SinewWorld::move_and_slide`]).
//!   [`Weighs`] has what the game moves press on what it stands on.
//! - **Read back** are `Transform` ([`RigidPose`]), meshes ([`MeshFollow`], [`TubeMesh`]), [`LinearVelocity`], [`AngularVelocity`], [`WorldCenterOfMass`],
//!   [`Inertia`]; [`SinewWorld::report`] says how the solver fared, and [`Refused`] messages what it set aside.
//!
//! SI units throughout: metres, seconds, kilograms, newtons.
//!
//! # How a tick flows
//!
//! ```text
//! components --Gather--> columns --[ phases ] x substeps--> columns --Scatter--> components --Extract--> Transform, velocities
//!                                                                                                  \--> meshes, once a frame
//! ```
//!
//! One tick is the schedule [`SinewTick`], which one system runs in `FixedPostUpdate`; its sets are [`SinewSystems`]:
//!
//! 1. **Build**: new or changed recipes become particles and constraints, in world coordinates, where their `Transform` is.
//! 2. **Gather**: every particle is copied into its row of the solver's columns; bad ones are set aside, each with one message. Rows follow the
//!    order of creation ([`CreationOrder`]). Constraints are compiled again only if something came, went or changed. A `Transform` that somebody
//!    else moved teleports its body, here and nowhere else.
//! 3. **Substeps**: [`SubstepSchedule`] runs [`SolverConfig::substeps`] times, if there are particles; each phase is a system in its own set of
//!    [`PhaseSystems`].
//! 4. **Scatter**: the columns go back into [`Particle`].
//! 5. **Extract**: transforms and velocities are read off.
//!
//! # The ECS is the state
//!
//! What is not in a component or a resource does not survive a tick, and [`SinewWorld`] is scratch. Which types are state stands in one list,
//! [`StateTypes`]: components of the simulation, its clock, its configuration, the counter of creation, and what a game adds by
//! [`register_particle_constraint`](RegisterParticleConstraint::register_particle_constraint) and [`RegisterState`].
//!
//! - [`SinewSnapshot::capture`] takes all of it out of a world; [`SinewSnapshot::restore`] makes a world what it was, in place or in another app. The
//!   simulation goes on bit for bit, and [`SinewSnapshot::hash`] proves it. Recipes are part of it: one that did not change builds nothing anew.
//! - With the feature `serialize` a snapshot goes to RON or to bytes and back (`to_ron`, `to_bytes`, `from_ron`, `from_bytes`): `examples/save_load.rs`.
//! - With the feature `ggrs` there is `SinewRollbackPlugin`, for netcode by `bevy_ggrs` 0.22: `examples/rollback.rs`.
//!
//! Not part of it are what is drawn (meshes, materials, easing between ticks) and messages. A body that is restored into another app has no `Mesh3d` there
//! until the game gives it one, except for ropes, whose tubes are made anew.
//!
//! # The order of messages
//!
//! Within a tick, messages and events come in this order, the same in every run: it follows from the order of creation ([`CreationOrder`]), never from
//! archetypes, queries or what entities are called.
//!
//! 1. **Build** and **Gather**: [`Refused`], part by part; where several bodies ask for the same thing ([`ExternalImpulse`], waiting commands), in the
//!    order of creation. Then [`RelaxFinished`], the world first, then bodies in the order of creation.
//! 2. **Scatter**: [`Refused`] for what went non-finite, row by row. Then contacts, one after the other of those with [`ContactEvents`], in the order of
//!    creation: for each, what ended ([`ContactEnded`]), what began ([`ContactStarted`]), and what there is ([`ContactImpulse`]), each list by whom it
//!    touches: bodies, loose particles, colliders, in the order of creation.
//!
//! Observers run when the commands of the system that sends are applied, in that same order. At a [speed](SinewControl::relative_speed) of 2, two whole ticks
//! follow one another. What is despawned in between ends its contacts at once.
//!
//! # Threads
//!
//! A tick runs on one thread, the one that runs `FixedPostUpdate`; within it, the solver shares out what is worth it among the threads of
//! [`SinewWorkers`]: by default those of Bevy's compute pool. They never change a bit of the result; [`SolverConfig::threads`] switches them off.
//!
//! # A force of one's own
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sinew::prelude::*;
//! use bevy_sinew::{ParticleRow, PhaseSystems, SubstepSchedule};
//!
//! #[derive(Component)]
//! struct Rocket;
//!
//! fn thrust(mut world: ResMut<SinewWorld>, rockets: Query<&ParticleRow, With<Rocket>>) {
//!     for row in &rockets {
//!         if let Some(i) = row.get() {
//!             world.particles_mut().add_force(i, Vec3::Y * 20.0);
//!         }
//!     }
//! }
//!
//! # let mut app = App::new();
//! # app.add_plugins((MinimalPlugins, SinewPlugins));
//! app.add_systems(SubstepSchedule, thrust.in_set(PhaseSystems::AccumulateForces));
//! ```
//!
//! # A constraint of one's own
//!
//! A component that implements [`ParticleConstraint`], which says what must hold, marks its particles `#[entities]`, and one line,
//! [`register_particle_constraint`](RegisterParticleConstraint::register_particle_constraint): `examples/custom_constraint.rs` is all of it. The
//! constraints that come with the plugin come in by the same door.
//!
//! # Beside Avian
//!
//! Avian is a rigid-body engine; both may run in one app, each with its own bodies. Eight names of the two preludes are the same. An explicit import wins
//! over both globs, so one list settles it (`tests/beside-avian` compiles it):
//!
//! ```ignore
//! use avian3d::prelude::*;
//! use bevy_sinew::prelude::*;
//! use avian3d::prelude::{
//!     AngularVelocity, Collider, CollisionLayers, Gravity, GravityScale, LinearVelocity, Mass, Sensor,
//! };
//! use bevy_sinew::{
//!     AngularVelocity as SinewAngularVelocity, Collider as SinewCollider, CollisionLayers as SinewLayers, Gravity as SinewGravity,
//!     GravityScale as SinewGravityScale, LinearVelocity as SinewLinearVelocity, Mass as SinewMass, Sensor as SinewSensor,
//! };
//! ```
//!
//! | Avian 0.7 | here | why it differs |
//! |---|---|---|
//! | `PhysicsPlugins` | [`SinewPlugins`] | |
//! | `RigidBody::Dynamic` and `Collider` | a recipe: [`RigidBox`], [`RigidMesh`], … | a body is made of particles; the recipe brings mass, inertia and shape |
//! | `RigidBody::Static`, `Kinematic` and `Collider` | [`Collider`] alone | what has no particles is moved by its `Transform` or stands |
//! | `Friction`, `Restitution` | [`SurfaceMaterial`] | one component, with the lectures' planar friction in it |
//! | `CollisionLayers { memberships, filters }` | the same, 32 bits each | |
//! | `Sensor`, `CollisionStart`, `CollisionEnd`, `CollidingEntities` | [`Sensor`], [`ContactStarted`], [`ContactEnded`], [`Touching`] | asked for by [`ContactEvents`]; messages and entity events |
//! | `LinearVelocity`, `AngularVelocity`, `Mass` | the same | sums over the body's particles; writing them changes the body |
//! | `ComputedCenterOfMass` | [`WorldCenterOfMass`] | in the world, since a soft body has no fixed frame |
//! | `ConstantForce`, `Forces` | [`ExternalForce`], [`ControlForce`], [`BodyCommandsExt`] | |
//! | `DistanceJoint`, `SphericalJoint`, `RevoluteJoint`, `FixedJoint` | [`DistanceConstraint`], [`ConeConstraint`], [`HingeConstraint`], [`Articulated`] | constraints name particles; a shared particle is a ball joint |
//! | `JointDamping`, compliance | [`Softness`] | compliance, frequency with damping, or share |
//! | `SpatialQuery`, `MoveAndSlide` | [`SinewQuery`] | one parameter for all questions; its [`move_and_slide`](SinewWorld::move_and_slide) knows a floor from a wall |
//! | `Sleeping`, `SleepingDisabled` | [`Sleep`], [`SleepingDisabled`] | |
//! | `SubstepCount`, `SolverConfig` | [`SolverConfig`], [`BodySolver`] | a body may ask for its own |
//! | `Position`, `Rotation` | `Transform` | extracted once a tick, and read again only where a game changed it |
//! | `PhysicsSchedule`, `SubstepSchedule` | [`SinewTick`], [`SubstepSchedule`] | every phase is a set of [`PhaseSystems`] |
//! | `PhysicsInterpolationPlugin` | [`Interpolate`] | the same crate behind it |
//!
//! # Features
//!
//! | feature | default | what it brings |
//! |---|---|---|
//! | `gizmos` | yes | particles and constraints as lines |
//! | `drag` | yes | [`MouseDragPlugin`] |
//! | `interpolation` | yes | [`Interpolate`], through `bevy_transform_interpolation` |
//! | `serialize` | no | snapshots of the whole state to RON and to bytes, and back |
//! | `ggrs` | no | `SinewRollbackPlugin`: rollback netcode by `bevy_ggrs` 0.22 |
//!
//! # The map
//!
//! | folder | what it holds |
//! |---|---|
//! | [`guide`] | how the method works and how to use it, chapter by chapter |
//! | `attach` | what ties bodies to each other and to what a game moves: [`AttachTo`] |
//! | `bevy_version` | what Bevy names differently from version to version |
//! | `breaking` | constraints that break at a force or a strain: [`BreakAt`] |
//! | `carry` | taking particles along with what is moved |
//! | `changes` | whether anything in a table changed |
//! | `commands` | impulses, velocities, teleports and reversal of whole bodies |
//! | `components` | what a game spawns, edits and reads: the state |
//! | `frames` | where entities are in the world, on top of their parents |
//! | `rows` | which rows a list of particles stands in |
//! | `recipes` | bodies that build themselves |
//! | `query` | questions to the world: rays, shapes on their way, what is near |
//! | `move_and_slide` | the question of a character controller: how far, and along what |
//! | `schedule` | the sets, the phases, the driver of the substeps, and how fast time passes |
//! | `threads` | who helps the solver: [`SinewWorkers`] |
//! | `step` | layout, gather, links, representation, scatter, extract: components to columns and back |
//! | `world` | the columns and tables, scratch of a tick |
//! | `drag` | dragging bodies with the mouse: [`MouseDragPlugin`], to be added beside [`SinewPlugins`] |
//! | `state` | which types are state; snapshots, files, rollback |
//! | `show` | meshes, tubes and gizmos: nothing there is read back |
//! | `messages` | what is said when something is wrong |
//!
//! Everything physical is in the crate [`sinew`], which knows no engine.

mod attach;
mod bevy_version;
mod breaking;
mod carry;
mod changes;
mod commands;
mod components;
mod config;
#[cfg(feature = "drag")]
mod drag;
mod frames;
pub mod guide;
mod messages;
mod move_and_slide;
mod plugin;
mod query;
mod recipes;
mod rows;
mod same;
mod schedule;
mod show;
mod state;
mod step;
mod threads;
mod world;

pub use attach::{
    Anchor, AnchorConstraint, AttachTo, Attached, AttachmentJoints, AttachmentOf, BodyAttachments,
    JointOf, RopeEnd,
};
pub use breaking::Broke;
pub use commands::{BodyCommandsExt, BodyEdit, PendingEdits};
pub use commands::{Relax, RelaxFinished, RelaxWorld, SinewCommandsExt};
pub use components::{
    AirDrag, AngularVelocity, BodyConstraints, BodyParticles, BodyReport, Bound, BoundingBox,
    Charge, ConstraintOf, CreationOrder, DistanceConstraint, Drag, Electric, ExternalForce,
    ExtractedTransform, ExtractedVelocity, Fluid, Gravity, GravityScale, Ground, GroundDrag,
    Interpolate, LinearVelocity, Mass, MeshFollow, Particle, ParticleBody, ParticleOf, ParticleRow,
    Pinned, PinnedTo, Radius, Representation, RigidIntegrator, RigidPose, Softness, Spring,
    TubeMesh, Wind, WindSurface, WorldCenterOfMass,
};
pub use components::{
    AirFlow, Attractor, ElectricField, Flatland, Floats, HullShape, Region, RegionShape,
};
pub use components::{
    AngleConstraint, AnyConstraint, AreaConstraint, BendConstraint, CollinearConstraint,
    ConeConstraint, CoplanarConstraint, HingeConstraint, ParticleConstraint, PatchConstraint,
    RigidConstraint, SizeCorrection, TetrahedronConstraint, VolumeConstraint,
};
pub use components::{
    BodyContacts, Collider, ColliderFault, ColliderMotion, ColliderShape, CollisionLayer,
    CollisionLayers, Combine, ContactCache, ContactEnded, ContactEvents, ContactShape,
    ContactStarted, ContactsDisabled, RestPlace, Sensor, Sleep, SleepingDisabled, SurfaceMaterial,
    Touching,
};
pub use components::{BodyPart, BodyParts, BreakAt, BuiltBody, PartOf};
pub use components::{ContactImpulse, WatchedContacts, Weighs};
pub use components::{ControlForce, ExternalImpulse, ExternalTorque, Inertia, TickForces};
pub use config::{BodySolver, GradientAt, Integrator, Order, SolverConfig};
#[cfg(feature = "drag")]
pub use drag::{Grab, MouseDrag, MouseDragPlugin};
pub use messages::{AttachFault, EditFault, Refusal, Refused};
pub use move_and_slide::{MoveAndSlideConfig, MoveAndSlideOutput};
#[cfg(feature = "interpolation")]
pub use plugin::EasePlugin;
pub use plugin::{SinewPlugin, SinewPlugins};
pub use query::SinewQuery;
pub use query::{QueryFilter, QueryHit};
pub use recipes::{
    Articulated, Bone, BoneJoint, BoxParticles, Bulk, Cloth, ClothPins, ClothShape, Ragdoll,
    RigidBox, RigidMesh, RigidParticles, RigidShape, Rope, SoftBody, SoftShape,
};
pub use recipes::{BodyBuilt, RopePoint, RopeTie};
pub use schedule::{
    PhaseStep, PhaseSteps, PhaseSystems, SinewClock, SinewControl, SinewSystems, SinewTick,
    SubstepSchedule, TickTime,
};
#[cfg(feature = "gizmos")]
pub use show::{SinewGizmoConfigGroup, SinewGizmoPlugin};
pub use sinew;
pub use sinew_derive::CollisionLayer;
#[cfg(feature = "serialize")]
pub use state::{LoadFault, SaveFault};
pub use state::{RegisterState, RestoreFault, SinewSnapshot, StateRole, StateType, StateTypes};
#[cfg(feature = "ggrs")]
pub use state::{RollbackHistory, SinewRollbackPlugin};
pub use step::RegisterParticleConstraint;
pub use threads::{ComputePool, SinewWorkers};
pub use world::{ParticlesMut, SinewWorld};

/// What the workspace's tests look at from outside and no game can see: tests within would have this crate compiled twice. No part of the interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::frames::compose;
    pub use crate::recipes::bind;
    pub use crate::step::contact_shape::gap;
}

/// What a game's first day wants in scope: some fifty names, none of which is in Bevy's prelude. Everything else is at the root of the crate: other
/// constraints than rods and springs, phases and constraints of a game's own, regions, what says otherwise than the defaults.
///
/// Some of them are in Avian's prelude, too; the crate's [table](crate#beside-avian) says which.
pub mod prelude {
    // What a world is made of.
    pub use crate::{
        AirDrag, BoundingBox, Gravity, Ground, Interpolate, SinewControl, SinewPlugins, SinewWorld,
        SolverConfig,
    };
    // Particles, and what holds them.
    pub use crate::{
        DistanceConstraint, GravityScale, Mass, Particle, Pinned, PinnedTo, Radius, Softness,
        Spring,
    };
    // Bodies.
    pub use crate::{Cloth, ClothPins, Ragdoll, RigidBox, RigidMesh, RigidShape, Rope, SoftBody};
    // Forces and motion.
    pub use crate::{
        AngularVelocity, BodyCommandsExt, ExternalForce, ExternalImpulse, ExternalTorque, Floats,
        Fluid, LinearVelocity, Wind,
    };
    // Contacts.
    pub use crate::{
        Collider, CollisionLayers, ContactEnded, ContactEvents, ContactStarted, Sensor, Sleep,
        SurfaceMaterial,
    };
    // Attachments.
    pub use crate::{Anchor, AttachTo, BodyBuilt, BreakAt, Broke};
    // Time and questions.
    pub use crate::{SinewCommandsExt, SinewQuery};
}
