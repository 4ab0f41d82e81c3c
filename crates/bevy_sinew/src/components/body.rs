//! Bodies: which particles belong together, and what is extracted from them.

use bevy::ecs::component::component_clone_via_clone;
use bevy::ecs::entity::{ComponentCloneCtx, SourceComponent};
use bevy::prelude::*;

use super::collide::ResolvedShape;
use super::order::CreationOrder;
use crate::rows::ResolvedRows;
use crate::same::same_variants;

/// A body: an entity to which particles, springs and constraints belong. They are despawned with it.
///
/// The body is built at its `Transform`, on top of those of its parents, and its sizes are scaled as the entity is. Afterwards the use of the transform depends
/// on the body: a rigid body has a [`RigidPose`], which writes it; for cloth and ropes it remains the frame in which the mesh is written. In either case, if
/// the game moves the body or a parent of it, the particles are teleported along. If the game scales it, the body is rebuilt in its new size at its
/// `Transform`, and keeps its velocities.
///
/// The simulation itself runs in world coordinates. A body that falls in the frame of a parent falls as it does without one; a parent that moves carries it
/// along in every tick by as much as the parent moved. (So a crate that is a child of a lift moves with it even in the air; to have it carried by contact
/// alone, do not make it a child.) An unevenly scaled parent would shear a rotating child, so a rigid body there is refused
/// ([`Refusal::Sheared`](crate::Refusal::Sheared)).
///
/// A [`LinearVelocity`] and an [`AngularVelocity`] that are spawned with the body are its initial motion.
///
/// A body with Bevy's `Disabled` leaves the simulation in the next tick: the plugin disables its particles, constraints, parts and attachments, too, ends its
/// contacts, and keeps its velocities. When `Disabled` is removed, all of that comes back in the next tick, at the body's `Transform`, and awake. What the game had
/// disabled by itself, such as a single constraint, stays disabled. What was attached to the body is free in the meantime; a hard tie whose ends are far apart by
/// then jerks them together, as one that is made there does. Children in Bevy's sense, such as a model on a limb, are neither disabled nor hidden with the body:
/// Bevy's `insert_recursive::<Children>(Disabled)` does that.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
#[require(Transform, ExtractedTransform, ResolvedRows<BodyParticles>)]
#[require(LinearVelocity, AngularVelocity, ExtractedVelocity, WorldCenterOfMass, Inertia)]
#[require(ResolvedShape)]
pub struct ParticleBody;

/// Relationship from a particle to the body that it belongs to. The particle is despawned with the body.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = BodyParticles)]
pub struct ParticleOf(#[entities] pub Entity);

/// The particles of a body, in the order in which they were added to it. Kept by Bevy, from [`ParticleOf`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::BodyParticles;
/// /// The lowest point of each cloth.
/// fn lowest(cloths: Query<&BodyParticles, With<Cloth>>, particles: Query<&Particle>) {
///     for members in &cloths {
///         let heights = members.iter().filter_map(|p| particles.get(p).ok()).map(|p| p.position.y);
///         println!("{} m", heights.fold(f32::INFINITY, f32::min));
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = ParticleOf, linked_spawn)]
pub struct BodyParticles(Vec<Entity>);

/// Relationship from a spring or a constraint to the body that it belongs to. It is despawned with the body.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = BodyConstraints)]
pub struct ConstraintOf(#[entities] pub Entity);

/// The springs and constraints of a body. Kept by Bevy, from [`ConstraintOf`].
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = ConstraintOf, linked_spawn)]
pub struct BodyConstraints(Vec<Entity>);

/// Drives this entity's `Transform` by particles: after each tick it is the rotation and translation that best map `rest` onto them.
///
/// The best fit minimises the mass-weighted sum of squared distances (shape matching, [`sinew::pose`]). The scale is not changed.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::RigidPose;
/// # fn example(mut commands: Commands) {
/// // The transform of a rod that lies along x in its own frame, from the particles at its ends.
/// let ends = [Vec3::ZERO, Vec3::Y];
/// let particles = ends.map(|at| commands.spawn(Particle::at(at)).id());
/// commands.spawn(DistanceConstraint::new(particles[0], particles[1], 1.0));
/// let rest = vec![Vec3::X * -0.5, Vec3::X * 0.5];
/// commands.spawn((RigidPose { particles: particles.into(), rest }, Transform::default()));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default, Clone)]
#[require(Transform, CreationOrder, ResolvedRows<RigidPose>)]
pub struct RigidPose {
    /// The particles that determine the pose.
    #[entities]
    pub particles: Vec<Entity>,
    /// The position of each particle in this entity's own frame, metres; as many as `particles`.
    pub rest: Vec<Vec3>,
}

/// Triangles between particles: the surface on which [`Wind`](super::Wind) presses and [`AirFlow`](super::AirFlow) acts, and by which its body collides if it
/// does so by triangles ([`ContactShape::Triangles`](super::ContactShape)). Cloth and soft bodies come with one.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{BodyBuilt, BodyParticles, WindSurface};
/// /// A kite: the four corners of a flat box.
/// fn on_built(built: On<BodyBuilt>, bodies: Query<&BodyParticles>, mut commands: Commands) {
///     let Ok(particles) = bodies.get(built.entity) else { return };
///     if let [a, b, c, d] = particles.iter().collect::<Vec<_>>()[..] {
///         let triangles = vec![[a, b, c], [a, c, d]];
///         commands.entity(built.entity).insert(WindSurface { triangles });
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default, Clone)]
#[require(ResolvedRows<WindSurface>)]
pub struct WindSurface {
    /// The corners of each triangle. Counter-clockwise seen from outside, if the surface is closed.
    #[entities]
    pub triangles: Vec<[Entity; 3]>,
}

/// Drives the vertices of this entity's `Mesh3d` by particles; the normals are recomputed.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::MeshFollow;
/// # fn example(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
/// // A triangle of three particles.
/// let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// let vertices = [a, b, c].map(|at| commands.spawn(Particle::at(at)).id()).to_vec();
/// commands.spawn((MeshFollow { vertices }, Mesh3d(meshes.add(Triangle3d::new(a, b, c)))));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default, Clone)]
#[require(Transform, ResolvedRows<MeshFollow>)]
pub struct MeshFollow {
    /// The particle that each vertex follows, in the order of the mesh's vertices.
    #[entities]
    pub vertices: Vec<Entity>,
}

/// Draws a chain of particles as a tube: adds a `Mesh3d` to this entity and updates it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{TubeMesh};
/// # fn spawn(mut commands: Commands) {
/// let chain: Vec<Entity> = (0..5).map(|i| {
///     commands.spawn(Particle::at(Vec3::X * 0.2 * i as f32)).id()
/// }).collect();
/// for pair in chain.windows(2) {
///     commands.spawn(DistanceConstraint::new(pair[0], pair[1], 0.2));
/// }
/// commands.spawn(TubeMesh { particles: chain, radius: 0.02, sides: 8 });
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug)]
#[reflect(Component, Default, Clone)]
#[require(Transform, ResolvedRows<TubeMesh>)]
pub struct TubeMesh {
    /// The particles along the centre line of the tube.
    #[entities]
    pub particles: Vec<Entity>,
    /// Radius of the tube, metres. Default 0.02.
    pub radius: f32,
    /// Number of edges of the cross-section, 3 to 64. Default 8.
    pub sides: u32,
}

impl Default for TubeMesh {
    fn default() -> Self {
        Self { particles: Vec::new(), radius: 0.02, sides: 8 }
    }
}

/// Interpolates what is drawn of this body, or of this loose particle, between two ticks: its transform and those of its parts (through
/// `bevy_transform_interpolation`), and its mesh. It may be added and removed at any time. Needs the feature `interpolation` for transforms.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((RigidBox::default(), Interpolate));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
pub struct Interpolate;

/// Where an entity is drawn between two ticks, if its transform is interpolated, and its transform at the end of the last tick; `None` within the fixed
/// schedules. Scratch.
#[derive(Component, Clone, Copy, Debug, Default)]
#[component(clone_behavior = Ignore)]
pub(crate) struct DrawnTransform(pub(crate) Option<(Transform, Transform)>);

impl DrawnTransform {
    /// What is meant by the transform `now`: that at the end of the last tick, unless the game has changed it since.
    pub(crate) fn actual(&self, now: Transform) -> Transform {
        self.0.filter(|(drawn, _)| *drawn == now).map_or(now, |(_, at_end)| at_end)
    }
}

/// The world transform at which the simulation last left the entity. If its `Transform` and those of its parents differ from it, the game moved the entity, and
/// its particles are moved along. Part of the state: save and restore it together with `Transform`.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ExtractedTransform(pub Option<Transform>);

/// Velocity of a body's centre of mass in the world, m/s: `Σ m v / Σ m`. Written after each tick. Bodies have it; a single [`Particle`](crate::Particle) has
/// one if a game adds it, which is then the particle's velocity.
///
/// Spawned with a body it is the initial velocity. If a game changes it, the body's velocity changes at the beginning of the next tick: that of all particles
/// by the same amount, so that spin and internal motion stay. Pinned particles do not move. A value that is not finite is refused, and the body keeps its
/// velocity.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A box that is thrown, with a spin.
/// let motion = (LinearVelocity(Vec3::new(0.0, 4.0, -8.0)), AngularVelocity(Vec3::X * 6.0));
/// commands.spawn((RigidBox::new(Vec3::splat(0.2)), motion));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ExtractedVelocity)]
pub struct LinearVelocity(pub Vec3);

/// Angular velocity of a body about its centre of mass in the world, rad/s: `I⁻¹ Σ m r×v`. Written after each tick.
///
/// If it is spawned with a body or changed by a game, it sets the body's angular velocity, as [`LinearVelocity`] does; internal motion that is not spin stays.
/// A body whose particles all lie on a line has no spin about it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// // A spinning top, and a function that reads the fastest spin.
/// commands.spawn((RigidBox::new(Vec3::new(0.4, 0.1, 0.4)), AngularVelocity(Vec3::Y * 20.0)));
/// fn fastest(bodies: Query<&AngularVelocity>) -> f32 {
///     bodies.iter().map(|spin| spin.0.length()).fold(0.0, f32::max)
/// }
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct AngularVelocity(pub Vec3);

/// The velocities that the simulation last wrote to [`LinearVelocity`] and [`AngularVelocity`]. Where those differ from it, the game changed them, and they are
/// applied to the body. `None` before the body's first tick. Part of the state: save and restore it with them.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ExtractedVelocity(pub Option<(Vec3, Vec3)>);

/// A body's centre of mass in the world, and its total mass. Written after each tick. A pinned particle counts with its [`Mass`](super::Mass), as if it were
/// not pinned.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::WorldCenterOfMass;
/// # use bevy_sinew::prelude::*;
/// fn watch(bodies: Query<(&Name, &WorldCenterOfMass)>) {
///     for (name, centre) in &bodies {
///         println!("{name} of {} kg is at {}", centre.mass, centre.position);
///     }
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct WorldCenterOfMass {
    /// `Σ m x / Σ m`, metres.
    pub position: Vec3,
    /// `Σ m`, kilograms.
    pub mass: f32,
}

/// Inertia tensor of a body about its centre of mass, kg·m², in the axes of the world, so it turns with the body. Written after each tick.
///
/// It is that of the particles as point masses, `Σ m (r² 1 - r rᵀ)`. For a box with particles at its corners this is three times that of the solid box; for an
/// [equimomental](crate::BoxParticles::Equimomental) box it is that of the solid. Pinned particles count as in [`WorldCenterOfMass`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::Inertia;
/// /// The moment of inertia about the vertical through the centre of mass, kg·m².
/// fn about_y(inertia: &Inertia) -> f32 {
///     inertia.0.y_axis.y
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Inertia(pub Mat3);

impl Default for Inertia {
    /// Zero, as before the first tick.
    fn default() -> Self {
        Self(Mat3::ZERO)
    }
}

/// Statistics of the solver for this body in the last tick. Add it to a body to have it filled; bodies that constraints connect are solved together and share
/// their values.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::BodyReport;
/// # fn example(mut commands: Commands) {
/// commands.spawn((Cloth::grid(2.0, 2.0, 20, 20), BodyReport::default()));
/// fn watch(cloths: Query<&BodyReport, With<Cloth>>) {
///     for report in &cloths {
///         println!("stretched by {:.1} % at the worst", 100.0 * report.strain);
///     }
/// }
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct BodyReport {
    /// Number of sweeps, summed over the substeps.
    pub sweeps: u32,
    /// Whether the tolerance was reached in every substep.
    pub converged: bool,
    /// Substeps in which the body turned too fast for [`GradientAt::StepStart`](crate::GradientAt::StepStart), and was corrected to the nearest point instead.
    pub fallbacks: u32,
    /// Largest remaining error of a hard constraint, metres.
    pub error: f32,
    /// Largest remaining error of a hard distance, as a fraction of its rest length.
    pub strain: f32,
    /// Time that solving took, seconds; zero unless [`SolverConfig::timed`](crate::SolverConfig::timed). Wall-clock time: never part of the state.
    pub seconds: f64,
}

/// Multiple of [`Gravity`](super::Gravity) that acts on a body or a particle. Default 1, as without the component. The values of a body and of its particles
/// are multiplied.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A balloon, which falls upwards.
/// commands.spawn((RigidBox::new(Vec3::splat(0.3)), GravityScale(-0.5)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, PartialOrd)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct GravityScale(pub f32);

impl Default for GravityScale {
    fn default() -> Self {
        Self(1.0)
    }
}

/// How a rigid body, that is, a body with a [`RigidPose`] such as a box, is moved by the solver. It can be changed at any time: position, rotation, momentum
/// and angular momentum are kept.
///
/// In each case the particles are the state, and are up to date between any two phases. A body without the component has the default, [`Auto`](Self::Auto).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Representation;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A box whose particles are integrated one by one, and held together by rods.
/// commands.spawn((RigidBox::default(), Representation::Particles));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Representation {
    /// As one rigid state (position, rotation, velocities) through the substeps of a tick, from which the particles are updated, while only its own rods hold
    /// its particles together. As particles otherwise: while one of them is pinned, attached or tied to something else, or asleep, or something in the body can
    /// break ([`sinew::Representation::Auto`] has the complete list). The motion is that of [`Particles`](Self::Particles), without the cost of solving the
    /// constraints. The default.
    #[default]
    Auto,
    /// As particles that constraints hold together, as in the lectures.
    Particles,
    /// As an explicit rigid body. At the beginning of a tick it is computed from its particles, then integrated as a position, a rotation and two velocities,
    /// and written back. A force on one of its particles acts on the body. The distances and constraints inside it are not solved meanwhile.
    Rigid(RigidIntegrator),
}

impl Representation {
    /// The representation in the solver's settings; explicit rigid bodies are listed as compounds instead.
    pub(crate) fn within_a_step(self) -> sinew::Representation {
        match self {
            Self::Auto => sinew::Representation::Auto,
            Self::Particles | Self::Rigid(_) => sinew::Representation::Particles,
        }
    }
}

/// How an explicit rigid body is integrated. [`sinew::rigid`] compares the integrators.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum RigidIntegrator {
    /// Explicit Euler: first order, and its energy drifts. For comparison.
    Euler,
    /// Leapfrog (kick, rotate, kick): second order. The default.
    #[default]
    Leapfrog,
    /// The discrete Moser–Veselov equations: second order, the equivalent of Verlet for rotations.
    Verlet,
}

same_variants!(RigidIntegrator, sinew::RigidIntegrator { Euler, Leapfrog, Verlet });

/// A rigid part of a body, such as a forearm: an entity whose `Transform` follows the particles that determine it ([`RigidPose`]). Its `Name` identifies it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct BodyPart {
    /// Size along the part's own axes, metres. A capsule along y has the diameter `size.x` and the total length `size.y`.
    pub size: Vec3,
}

/// Relationship from a rigid part to the body that it belongs to. The part is despawned with the body.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = BodyParts)]
pub struct PartOf(#[entities] pub Entity);

/// The rigid parts of a body that has several. Kept by Bevy, from [`PartOf`].
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = PartOf, linked_spawn)]
pub struct BodyParts(Vec<Entity>);

/// Marks a body that is built as its recipe describes: its particles, parts and constraints exist. Kept by the plugin; part of the state.
///
/// It changes whenever the body is rebuilt, so that `Changed<BuiltBody>` tells a system the same as [`BodyBuilt`](crate::BodyBuilt), and it is removed where
/// the recipe is refused.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::BuiltBody;
/// /// The number of bodies that are built.
/// fn count(built: Query<(), With<BuiltBody>>) -> usize {
///     built.iter().count()
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(clone_behavior = Custom(clone_with_particles))]
pub struct BuiltBody {
    /// How often the body has been built, 1 or more.
    pub builds: u32,
}

/// A clone without the particles of its original is a new body, which is yet to be built.
fn clone_with_particles(source: &SourceComponent, context: &mut ComponentCloneCtx) {
    if context.linked_cloning() || context.moving() {
        component_clone_via_clone::<BuiltBody>(source, context);
    }
}
