//! Particle physics without an engine: Verlet particles, springs and positional constraints, solved by substepped position-based dynamics (XPBD).
//!
//! Boxes, ropes, ragdolls, cloth and soft bodies are all made of particles and the constraints between them. The crate needs `glam` and `parry3d` and no game
//! engine, so a server, a test or another engine can use it alone; `bevy_sinew` is the plugin for Bevy.
//!
//! ```
//! use sinew::glam::Vec3;
//! use sinew::{Distance, ParticleSeed, Simulation};
//!
//! let mut world = Simulation::default();
//! let hook = world.particles.push(ParticleSeed::at(Vec3::Y * 2.0).pinned())?;
//! let bob = world.particles.push(ParticleSeed::at(Vec3::new(1.0, 2.0, 0.0)))?;
//! world.distances_mut().push(Distance::new(hook, bob, 1.0));
//! for _ in 0..60 {
//!     world.step(1.0 / 60.0)?;
//! }
//! assert!((world.particles.position(1).distance(Vec3::Y * 2.0) - 1.0).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Terms
//!
//! | term | meaning, in the words of other engines |
//! |---|---|
//! | [`Simulation`] | the world |
//! | particle, row | a point mass with a position and a velocity, without an orientation; its row is its index in [`Particles`] |
//! | body | a set of particles with common settings ([`BodySettings`], [`BodyContacts`], [`Sleep`]): a box, a ragdoll, a sheet of cloth |
//! | [`Distance`] (a rod where it is hard), [`Constraint`] | the joints, and what gives a body its shape |
//! | [`Collider`] | a static or kinematic collision shape |
//! | [`BodyCollider`] | a collision shape of a dynamic body: it moves with some of the body's particles |
//! | [`Boundaries`] | planes, boxes and pins that hold particles one by one |
//! | [`Compound`] | particles that move as one explicit rigid body |
//! | pinned | of infinite mass (inverse mass 0), moved by the game alone |
//! | island | particles that constraints connect; each island is solved by itself |
//! | sweep | one Gauss–Seidel pass over the constraints of an island |
//! | recipe | a function that builds the particles and constraints of a body ([`recipes`]) |
//!
//! # One step
//!
//! The method follows a series of game-physics lectures (M. Tarini: Verlet integration and *Position Based Dynamics*), corrected where they are loose; "the
//! lectures" in these docs are those, and "physics.md" is `docs/physics.md` in the repository, which lists the formulas.
//!
//! [`step`](Simulation::step) begins with what is done once: it updates the plan if constraints changed, puts islands to sleep or wakes them, and runs the
//! broad phase, which finds the pairs that may touch within the step. Then it cuts the step of `dt` seconds into substeps of `h`. Each substep runs six phases,
//! which are methods of [`Simulation`] with these names:
//!
//! 1. **`accumulate_forces`** sums gravity, the game's own forces, controls and springs into an acceleration per particle.
//! 2. **`apply_wind`** adds the pressure of winds, and the drag and lift of the air.
//! 3. **`apply_buoyancy`** adds the buoyancy and drag of fluids.
//! 4. **`apply_electric`** adds the forces between charges, and of electric fields.
//! 5. **`integrate`** predicts the next position of every particle from its velocity and acceleration, without constraints ([`integrate`]).
//! 6. **`solve_constraints`** corrects the predicted *positions* until distances, joints and contacts hold ([`constraints`], [`solve`], [`collide`]), and
//!    derives the velocities from the corrected positions. So spin and friction need no formulas of their own in velocities; restitution is applied last.
//!
//! A box or a ball that collides by its shape, and that no constraint but its own rods holds, goes through the step as one rigid state, without a sweep, and
//! its particles follow ([`Representation`]).
//!
//! Where no external force but gravity acts, [`step`](Simulation::step) runs all substeps of an island at once, while its particles are in a core's cache.
//!
//! # How it is fast
//!
//! - **Graph colouring.** Constraints are compiled into a plan when they change. Within an island no two constraints of a **colour** share a particle, so eight
//!   of them are solved at once in SIMD lanes ([`InstructionSet`] names the instructions; all give the same bits).
//! - **Strides.** Rods between rows that are a constant **stride** apart, as in a cloth numbered row by row, are loaded without gathering.
//! - **Clusters and threads.** A large island is swept **cluster** by cluster, each small enough for a core's first-level cache, and several [`Workers`] may
//!   each take some clusters, or some of the substeps.
//! - **Incremental updates.** Where a few constraints are added or removed, the plan is updated to what compiling it would give. Where whole bodies change, the
//!   bodies before the first changed one stay compiled.
//! - **No idle work.** A column that was not written to is not read, and a warm step allocates nothing.
//!
//! # The map
//!
//! | module | what it holds |
//! |---|---|
//! | [`particles`] | the columns: position, velocity, inverse mass, …; impulses and teleports |
//! | [`simulation`] | particles + forces + constraints + plan; one method a phase; sleep, queries, statics |
//! | [`integrate`] | Verlet, leapfrog and the Euler integrators: formulas, derivation, properties |
//! | [`forces`] | gravity, controls, springs, wind and air, fluids and hulls, charges and fields: a file or folder each |
//! | [`constraints`] | distances, angles, areas, volumes, bending, shapes, bounds, user-defined: data, value, gradient, kernel, a file each |
//! | [`collide`] | contacts: shapes, broad phase, narrow phase, contact cache, friction and restitution, for particles, triangles and body colliders |
//! | [`solve`] | the plan (clusters, colours), three orders of a sweep, two directions of a correction, the wide kernels, the report |
//! | [`pose`] | transform, velocity, spin and inertia extracted from particles (shape matching) |
//! | [`rigid`] | explicit rigid bodies, and the swap to particles and back |
//! | [`recipes`] | box, rope, cloth, ragdoll, soft body: shape in, particles and constraints out |
//! | [`ledger`] | energy and momentum |
//! | `settings` | configuration of the solver: for a world, and for single bodies in it |
//! | `islands` | which particles constraints connect |
//! | `lanes` | SIMD: eight numbers side by side, with the same bits on every instruction set; the only `unsafe` |
//! | `threads` | tasks, and the [`Workers`] that a caller may lend |
//! | `coincident` | vertices of a mesh that coincide |
//! | `convex_hull` | the convex hull of points |
//! | `hash` | FNV-1a |
//! | `not_cloned` | scratch memory that is not copied with its owner |
//! | `tracked` | change tracking: [`Tracked`] lists, equal by their revision without a comparison of their elements |
//! | `union_find` | disjoint sets: islands, sleeping groups, zones, pieces of a mesh |
//!
//! Dependencies point one way: `recipes` uses `simulation`, which uses `solve` and `rigid`; `solve` uses `collide`, which uses `forces`; all of these use
//! `constraints`, which uses `particles`, and that `pose` and `lanes`. None points back.
//!
//! # Units and rules
//!
//! SI throughout: metres, seconds, kilograms, newtons, coulombs, radians. A bad argument is refused with an error or clamped as documented, and changes
//! nothing; inside a step nothing panics and nothing divides by zero. Results depend on the input alone: no unordered iteration, no platform maths, no fused
//! operations.

pub(crate) mod coincident;
pub mod collide;
pub mod constraints;
pub(crate) mod convex_hull;
pub mod forces;
pub(crate) mod hash;
pub mod integrate;
pub(crate) mod islands;
pub(crate) mod lanes;
pub mod ledger;
pub(crate) mod not_cloned;
pub mod particles;
pub mod pose;
pub mod recipes;
pub mod rigid;
pub(crate) mod settings;
pub mod simulation;
pub mod solve;
#[cfg(test)]
pub(crate) mod test_random;
pub(crate) mod threads;
mod tracked;
pub(crate) mod union_find;

pub use glam;

pub use collide::{
    BodyCollider, BodyColliderFault, BodyContacts, CachedManifold, Collider, Combine,
    CombinedMaterial, ContactCache, ContactParticipant, Frame, Impact, Layers, Material, Nearest,
    RayHit, Shape, ShapeFault,
};
pub use constraints::{
    Bound, Boundaries, Constraint, ConstraintFault, ConstraintKind, Distance, DistanceFault,
    Equation, GradientAt, InsideBox, Pin, PlanarDrag, Plane, Points, Softness,
};
pub use forces::{
    AirFlow, Attractor, Control, Electric, ElectricField, Extent, Fluid, Forces, Hull, HullFault,
    Region, Skin, Spring, SpringFault, Wind,
};
pub use integrate::Integrator;
pub use lanes::InstructionSet;
pub use ledger::Ledger;
pub use particles::{ParticleFault, ParticleSeed, ParticleState, Particles};
pub use rigid::{Compound, RigidBody, RigidFault, RigidIntegrator};
pub use settings::{BodySettings, Order, Representation, SolverSettings};
pub use simulation::{
    Filter, Hit, Relaxed, Simulation, Sleep, SlideConfig, SlideOutput, StepFault, Substep,
};
pub use solve::{IslandReport, SolverReport};
pub use threads::Workers;
pub use tracked::Tracked;
