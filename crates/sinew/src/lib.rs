//! Verlet particles, springs and positional constraints, without an engine.
//!
//! A server, a test or another engine can use this crate alone:
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
//! # The story of one step
//!
//! The method is that of a series of game-physics lectures (M. Tarini: Verlet integration and *Position Based Dynamics*), corrected where they are
//! loose. A step of `dt` seconds is cut into substeps of `h`; each runs six phases, which are methods of [`Simulation`] with these names:
//!
//! 1. **`accumulate_forces`**: gravity, the game's own forces, controls and springs are summed up into an acceleration per particle.
//! 2. **`apply_wind`**, 3. **`apply_buoyancy`**, 4. **`apply_electric`** add theirs.
//! 5. **`integrate`**: Verlet predicts where every particle would go if it were alone ([`integrate`]).
//! 6. **`solve_constraints`**: what must hold, holds: rods keep their length, nothing sinks into the ground. The solver moves the
//!    *positions* ([`constraints`], [`solve`]); the velocities follow from them, and so do spin, collision and friction, which nobody wrote down.
//!
//! A box or a ball that collides by its shape and that nothing but its own rods ties goes through the step as one rigid body, without a sweep, and its
//! particles follow ([`Representation`]).
//!
//! Where nothing but gravity acts from outside, [`step`](Simulation::step) takes all substeps of an island at once, while its particles are in a
//! core's cache.
//!
//! # How it is fast
//!
//! Constraints are compiled into a plan when they change. Within an island no two of a **colour** share a particle, so eight of them are solved at
//! once ([`InstructionSet`] says by which instructions; the bits are the same). Rods between rows that are a constant **stride** apart, as in a cloth
//! numbered row by row, need no gathering. Large islands are swept **cluster** by cluster, each as much as a core's first cache holds, and several
//! [`Workers`] may each take some clusters, or some of the substeps. Where a few constraints are added or removed, the plan is updated incrementally,
//! to what compiling it would give; and of several bodies those before the first that changed stay compiled. A column that nothing wrote to is not read. A warm step allocates nothing.
//!
//! # The map
//!
//! | file | what it owns |
//! |---|---|
//! | [`particles`] | the columns: position, velocity, inverse mass, …; impulses and teleports |
//! | [`simulation`] | particles + forces + constraints + plan; one method a phase; statics |
//! | [`integrate`] | Verlet, leapfrog and the Eulers: formulas, derivation, properties |
//! | [`forces`] | gravity, controls, springs, wind and air, fluids and hulls, charges and fields: a room each |
//! | [`constraints`] | distances, angles, areas, volumes, bending, shapes, bounds, a game's own: data, value, gradient, kernel, a file each |
//! | `settings` | how hard to try: for a world, and for single bodies in it |
//! | `islands` | which particles constraints connect |
//! | [`collide`] | contacts: colliders, particles among each other and against triangles, compounds as solids, friction and restitution |
//! | [`solve`] | the plan (clusters, colours), three orders of a sweep, two directions of a correction, kernels for eight at a time, the report |
//! | `lanes` | eight numbers side by side, on whatever instructions there are, to the same bits; the only `unsafe` |
//! | `threads` | tasks, and the [`Workers`] that a caller may lend |
//! | `convex_hull` | the smallest body without dents around points |
//! | `hash` | one number for many |
//! | `kept` | scratch that copies do without |
//! | `same_place` | which vertices of a mesh are one |
//! | `tracked` | lists that are known to be equal without a look at what is in them: [`Tracked`] |
//! | `union_find` | which of many belong together: islands, sleepers, zones, pieces of a mesh |
//! | [`pose`] | transform, velocity, spin and inertia out of particles |
//! | [`rigid`] | explicit rigid bodies, and the swap to particles and back |
//! | [`recipes`] | box, rope, cloth, ragdoll: shape in, particles and constraints out |
//! | [`ledger`] | energy and momentum |
//!
//! Arrows point one way: `recipes` and `simulation` know `solve`, `rigid` and `forces`, which know `constraints`, which know `particles`; nothing
//! points back. (`rigid` reads a whole simulation when a compound becomes a body; `particles` and `solve` use the sums of `pose`.)
//!
//! # Units and rules
//!
//! SI throughout: metres, seconds, kilograms, newtons, coulombs, radians. A bad argument is refused with an error or clamped as documented, and
//! changes nothing; inside a step nothing panics and nothing divides by zero. Results depend on the input alone: no unordered iteration, no
//! platform maths, no fused operations.

pub mod collide;
pub mod constraints;
pub(crate) mod convex_hull;
pub mod forces;
pub(crate) mod hash;
pub mod integrate;
pub(crate) mod islands;
pub(crate) mod kept;
pub(crate) mod lanes;
pub mod ledger;
pub mod particles;
pub mod pose;
pub mod recipes;
pub mod rigid;
pub(crate) mod same_place;
pub(crate) mod settings;
pub mod simulation;
pub mod solve;
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
