//! Particle physics for Bevy: rigid bodies, ropes, cloth, soft bodies and ragdolls, all made of particles and constraints that are plain ECS data.
//!
//! The solver uses position-based dynamics (PBD, in its extended form XPBD). It moves *positions* until the constraints between particles hold, and derives the
//! velocities from the motion, so that a stiff rod, or cloth that does not stretch, needs no tiny time step. [`guide::method`] explains the method; the
//! [`guide`] has a chapter for each topic.
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
//! With `DefaultPlugins` instead of `MinimalPlugins`, a camera, a light and a mesh on the box, this draws a box that falls onto the ground. The simulation is
//! the same in both.
//!
//! # Terms
//!
//! | term | meaning |
//! |---|---|
//! | particle | a point mass: a position, a velocity, a mass ([`Particle`]) |
//! | constraint | a condition on particles, such as a distance or a volume, that the solver enforces by moving them; a *rod* is a [`DistanceConstraint`] |
//! | body | particles and constraints that belong to one entity; a *recipe* component, such as [`Cloth`], describes and builds them |
//! | tick, substep | a tick is one step of the simulation, 1/64 s by default; it is divided into substeps (10 by default), each of which predicts positions, corrects them and derives velocities |
//! | sweep | one pass over the constraints within a substep, one after the other (Gauss–Seidel); more sweeps make a body stiffer |
//! | hard, soft | a hard constraint holds exactly, as far as the sweeps go; a soft one has a *compliance*, the inverse of a spring's stiffness ([`Softness`]) |
//! | pinned | a pinned particle has infinite mass for everything else, and moves only as its pin says ([`Pinned`], [`PinnedTo`]) |
//! | static, kinematic | a [`Collider`] without a body is static, or kinematic where the game moves its `Transform`: it pushes bodies, and nothing pushes it |
//! | island | particles that constraints connect, directly or through others: they are solved together |
//! | set aside | an entity with an invalid component is left out of the simulation, and reported once by a [`Refused`] message, until it is corrected |
//! | row, column | where the solver keeps particles: a column (an array) for each property, a row (an index) for each particle |
//! | the lectures | M. Tarini's game-physics lectures on Verlet integration and position-based dynamics, whose method the solver follows |
//!
//! # What a game uses
//!
//! - A **particle** is an entity with [`Particle`] and [`Mass`], and optionally [`Pinned`], [`PinnedTo`], [`Radius`], [`Charge`], [`Drag`] and
//!   [`ExternalForce`].
//! - A **spring** or a **constraint** is an entity of its own: [`Spring`], [`DistanceConstraint`], [`AngleConstraint`], [`VolumeConstraint`], …, or a component
//!   of the game ([`ParticleConstraint`]). Adding, changing or despawning one takes effect in the next tick.
//! - A **body** is an entity with a recipe: [`RigidBox`], [`RigidMesh`], [`Rope`], [`Cloth`], [`SoftBody`], [`Articulated`], [`Ragdoll`]. The recipe builds its
//!   particles, and they are despawned with it.
//! - A body is **moved** by its velocity ([`LinearVelocity`], [`AngularVelocity`]: spawned with it, or written at any time), by a force ([`ExternalForce`],
//!   [`ExternalTorque`], [`ControlForce`] for one at a point), by an impulse ([`ExternalImpulse`]), or by a command for any of these and for teleports
//!   ([`BodyCommandsExt`]). [`Mass`], [`Radius`], [`Charge`] and [`Drag`] on a body apply to the body, and are distributed to its particles.
//! - The **environment** is [`Gravity`], [`AirDrag`] and [`Electric`] (resources), [`Wind`], [`AirFlow`], [`Fluid`] and [`ElectricField`] (entities, which act
//!   everywhere or in a [`Region`]), [`Attractor`] and, for a 2D world, [`Flatland`]. [`Floats`] makes a body float by its own shape.
//! - A **collider** is an entity with a shape, [`Collider`], static or moved by the game through its `Transform`; [`Ground`] and [`BoundingBox`] are shorthands
//!   for two shapes. [`SurfaceMaterial`], [`CollisionLayers`] and [`Sensor`] configure it. Bodies that a recipe builds collide with colliders and with all
//!   other bodies: rigid bodies by their shape, others by the cheapest representation that has no holes ([`ContactShape::Auto`]). [`BodyContacts`] overrides
//!   this, and [`ContactsDisabled`] switches collisions off.
//! - **Parents** are respected: bodies, colliders and regions are where Bevy draws them ([`ParticleBody`] describes moving parents).
//! - **Disabled** entities (Bevy's `Disabled`) leave the simulation until they are enabled again, where the game has put them by then. A body takes its
//!   particles, constraints, parts and attachments along; a constraint to a disabled particle waits. What is pinned to a disabled entity, or is its child, stays.
//! - **Time** can be paused, stepped tick by tick, slowed down or sped up: [`SinewControl`]. [`Relax`] and [`RelaxWorld`] find the rest state of a body, or of
//!   everything, within one tick.
//! - **Queries** go through [`SinewQuery`]: ray casts, shape casts, overlaps, the nearest particle, and a move-and-slide for character controllers
//!   ([`SinewWorld::move_and_slide`]). [`Weighs`] gives a kinematic collider a weight that presses on what it stands on.
//! - **Results** are `Transform` ([`RigidPose`]), meshes ([`MeshFollow`], [`TubeMesh`]), [`LinearVelocity`], [`AngularVelocity`], [`WorldCenterOfMass`],
//!   [`Inertia`]; [`SinewWorld::report`] reports sweeps and errors of the solver, and [`Refused`] messages what was set aside.
//!
//! All units are SI: metres, seconds, kilograms, newtons. One Bevy unit is one metre.
//!
//! # How a tick flows
//!
//! ```text
//! components --Gather--> columns --[ phases ] x substeps--> columns --Scatter--> components --Extract--> Transform, velocities
//!                                                                                                  \--> meshes, once a frame
//! ```
//!
//! One tick is the schedule [`SinewTick`]. A single system in `FixedPostUpdate` runs it. Its sets are [`SinewSystems`]:
//!
//! 1. **Build**: new or changed recipes become particles and constraints, in world coordinates, at the `Transform` of their entity.
//! 2. **Gather**: every particle is copied into its row of the solver's columns; invalid ones are set aside, with one message each. Rows follow the order of
//!    creation ([`CreationOrder`]). Constraints are compiled again only if one was added, removed or changed. A `Transform` that anything but the simulation
//!    changed teleports its body; that happens here, and nowhere else.
//! 3. **Substeps**: [`SubstepSchedule`] runs [`SolverConfig::substeps`] times, if there are particles; each phase is a system in its own set of
//!    [`PhaseSystems`].
//! 4. **Scatter**: the columns are copied back into [`Particle`].
//! 5. **Extract**: transforms and velocities of bodies are computed from their particles.
//!
//! # The ECS is the state
//!
//! Only components and resources survive a tick; [`SinewWorld`] is scratch memory. The types that make up the state are listed in [`StateTypes`]: components of
//! the simulation, its clock, its configuration, the creation counter, and what a game adds with
//! [`register_particle_constraint`](RegisterParticleConstraint::register_particle_constraint) and [`RegisterState`].
//!
//! - [`SinewSnapshot::capture`] copies all of it out of a world; [`SinewSnapshot::restore`] puts it back, in place or into another app. The simulation then
//!   continues bit for bit, and [`SinewSnapshot::hash`] verifies it. Recipes are part of the snapshot: an unchanged recipe does not rebuild its body.
//! - With the feature `serialize` a snapshot is written to RON or to bytes and read back (`to_ron`, `to_bytes`, `from_ron`, `from_bytes`):
//!   `examples/save_load.rs`.
//! - With the feature `ggrs` there is `SinewRollbackPlugin`, for rollback netcode with `bevy_ggrs` 0.22: `examples/rollback.rs`.
//!
//! A snapshot does not hold what is drawn (meshes, materials, interpolation between ticks), nor messages. A body restored into another app has no `Mesh3d`
//! there until the game adds one, except for ropes, whose tubes are generated.
//!
//! # The order of messages
//!
//! Within a tick, messages and events are sent in the following order, which is the same in every run. It follows from the order of creation
//! ([`CreationOrder`]), never from archetypes, query order or entity ids.
//!
//! 1. **Build**: [`Refused`] for recipes, then [`BodyBuilt`], in the order of creation.
//! 2. **Gather**: [`Refused`], system by system; where a system handles several bodies (for [`ExternalImpulse`], or pending commands), in the order of
//!    creation. Then [`RelaxFinished`], for the world first, then for bodies in the order of creation.
//! 3. **Scatter**: [`Refused`] for particles that became non-finite, row by row. Then contacts, for each entity with [`ContactEvents`] in the order of
//!    creation: first those that ended ([`ContactEnded`]), then those that began ([`ContactStarted`]), then all current ones ([`ContactImpulse`]). Each of
//!    these lists has bodies first, then loose particles, then colliders, each in the order of creation. Then [`Broke`], in the order of creation.
//!
//! Observers run when the commands of the sending system are applied, in the same order. At a [speed](SinewControl::relative_speed) of 2, two complete ticks
//! follow one another. Despawning an entity between ticks ends its contacts at once.
//!
//! # Threads
//!
//! A tick runs on the thread that runs `FixedPostUpdate`. Within it, the solver distributes work that is large enough among the threads of [`SinewWorkers`], by
//! default those of Bevy's compute pool. The number of threads never changes a bit of the result; [`SolverConfig::threads`] switches them off.
//!
//! # A custom force
//!
//! A system in [`SubstepSchedule`] adds its own forces, by the row of each particle:
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
//! # A custom constraint
//!
//! Implement [`ParticleConstraint`] for a component: it lists its particles and returns what must hold between them. Mark the particles `#[entities]`, and
//! register the component with [`register_particle_constraint`](RegisterParticleConstraint::register_particle_constraint). `examples/custom_constraint.rs` is
//! complete. The constraints of this crate are registered in the same way.
//!
//! # Beside Avian
//!
//! Avian is a rigid-body engine. Both can run in one app, each with its own bodies. The preludes share eight names. An explicit import takes precedence over a
//! glob, so one list of imports resolves them (`tests/beside-avian` compiles it):
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
//! | Avian 0.7 | here | difference |
//! |---|---|---|
//! | `PhysicsPlugins` | [`SinewPlugins`] | |
//! | `RigidBody::Dynamic` and `Collider` | a recipe: [`RigidBox`], [`RigidMesh`], … | a body is made of particles; the recipe supplies mass, inertia and shape |
//! | `RigidBody::Static`, `Kinematic` and `Collider` | [`Collider`] alone | an entity without particles is static, or kinematic where its `Transform` is written |
//! | `Friction`, `Restitution` | [`SurfaceMaterial`] | one component; besides Coulomb friction it has a planar drag ([`GroundDrag`]) |
//! | `CollisionLayers { memberships, filters }` | the same, 32 bits each | |
//! | `Sensor`, `CollisionStart`, `CollisionEnd`, `CollidingEntities` | [`Sensor`], [`ContactStarted`], [`ContactEnded`], [`Touching`] | enabled by [`ContactEvents`] on an entity; messages and entity events |
//! | `LinearVelocity`, `AngularVelocity`, `Mass` | the same | aggregates of the body's particles; writing one changes the body |
//! | `ComputedCenterOfMass` | [`WorldCenterOfMass`] | in the world, since a soft body has no fixed frame |
//! | `ConstantForce`, `Forces` | [`ExternalForce`], [`ControlForce`], [`BodyCommandsExt`] | |
//! | `DistanceJoint`, `SphericalJoint`, `RevoluteJoint`, `FixedJoint` | [`DistanceConstraint`], [`ConeConstraint`], [`HingeConstraint`], [`Articulated`] | constraints are between particles; a shared particle is a ball joint |
//! | `JointDamping`, compliance | [`Softness`] | a compliance, a frequency with a damping ratio, or a share of the error |
//! | `SpatialQuery`, `MoveAndSlide` | [`SinewQuery`] | one system parameter for all queries; its [`move_and_slide`](SinewWorld::move_and_slide) distinguishes floors from walls |
//! | `Sleeping`, `SleepingDisabled` | [`Sleep`], [`SleepingDisabled`] | |
//! | `SubstepCount`, `SolverConfig` | [`SolverConfig`], [`BodySolver`] | a body may have its own settings |
//! | `Position`, `Rotation` | `Transform` | written once a tick, and read only where the game changed it |
//! | `PhysicsSchedule`, `SubstepSchedule` | [`SinewTick`], [`SubstepSchedule`] | every phase is a set of [`PhaseSystems`] |
//! | `PhysicsInterpolationPlugin` | [`Interpolate`] | both use `bevy_transform_interpolation` |
//!
//! # Features
//!
//! | feature | default | adds |
//! |---|---|---|
//! | `gizmos` | yes | [`SinewGizmoPlugin`]: particles, constraints and contacts drawn as lines |
//! | `drag` | yes | [`MouseDragPlugin`]: dragging bodies with the mouse |
//! | `interpolation` | yes | [`Interpolate`]: transforms interpolated between ticks, through `bevy_transform_interpolation` |
//! | `serialize` | no | snapshots of the whole state to RON and to bytes, and back |
//! | `ggrs` | no | `SinewRollbackPlugin`: rollback netcode with `bevy_ggrs` 0.22 |
//!
//! # Map of the source
//!
//! | module | contents |
//! |---|---|
//! | [`guide`] | how the method works and how to use it, chapter by chapter |
//! | `attach` | attachments of bodies to each other and to entities that the game moves: [`AttachTo`] |
//! | `bevy_version` | names that differ between Bevy versions |
//! | `breaking` | constraints that break at a force or a strain: [`BreakAt`] |
//! | `carry` | rigid motions applied to particles when their body is moved |
//! | `changes` | change detection over whole tables |
//! | `commands` | forces, impulses, velocities, teleports and reversal of whole bodies |
//! | `components` | what a game spawns, edits and reads: the state |
//! | `config` | settings of the solver: [`SolverConfig`], [`BodySolver`] |
//! | `disabling` | entities with Bevy's `Disabled`, which leave the simulation until they are enabled |
//! | `drag` | dragging bodies with the mouse: [`MouseDragPlugin`], added beside [`SinewPlugins`] |
//! | `frames` | world transforms of entities, through their parents |
//! | `mesh` | reading meshes: their positions and triangles |
//! | `messages` | error reports: [`Refused`] |
//! | `move_and_slide` | move-and-slide for character controllers |
//! | `plugin` | the plugins, and the order of all systems |
//! | `query` | ray casts, shape casts, overlaps, the nearest particle |
//! | `recipes` | bodies that build themselves |
//! | `rows` | the mapping from particle entities to rows |
//! | `same` | macros that convert between this crate's types and the solver's |
//! | `schedule` | the sets, the phases, the substep driver, and the speed of time |
//! | `show` | meshes, tubes and gizmos; the simulation never reads them |
//! | `state` | which types are state; snapshots, files, rollback |
//! | `step` | the systems around the substeps: layout, gather, constraints, scatter, extract |
//! | `targets` | the particles of a body, a part or a particle |
//! | `threads` | threads for the solver: [`SinewWorkers`] |
//! | `world` | the solver's columns and the tables beside them, scratch of a tick |
//!
//! The physics itself is in the crate [`sinew`], which does not depend on Bevy.

mod attach;
mod bevy_version;
mod breaking;
mod carry;
mod changes;
mod commands;
mod components;
mod config;
mod disabling;
#[cfg(feature = "drag")]
mod drag;
mod frames;
pub mod guide;
mod mesh;
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
mod targets;
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

/// Functions that the workspace's tests call from outside (unit tests inside the crate would compile it twice). Not part of the public interface.
#[doc(hidden)]
pub mod internals {
    pub use crate::frames::compose;
    pub use crate::recipes::bind;
    pub use crate::step::contact_shape::gap;
}

/// The names that most games need: some fifty, none of which is in Bevy's prelude. Everything else is at the root of the crate: constraints other than rods and
/// springs, phases and custom constraints, regions, and components that override defaults.
///
/// Some of the names are in Avian's prelude, too; the crate docs [list them](crate#beside-avian).
pub mod prelude {
    // The world and its settings.
    pub use crate::{
        AirDrag, BoundingBox, Gravity, Ground, Interpolate, SinewControl, SinewPlugins, SinewWorld,
        SolverConfig,
    };
    // Particles and constraints.
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
    // Time and queries.
    pub use crate::{SinewCommandsExt, SinewQuery};
}
