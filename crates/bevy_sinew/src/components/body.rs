//! Bodies: which particles belong together, and what is read back from them.

use bevy::prelude::*;

use super::collide::ResolvedShape;
use super::order::CreationOrder;
use crate::rows::Rows;
use crate::same::same_variants;

/// A body made of particles. Despawn it and its particles, springs and constraints go too.
///
/// Its `Transform`, on top of those of its parents, is where the recipe builds it, and how large: its sizes are scaled as the entity is. What the
/// transform does afterwards depends on the body: a rigid one has a [`RigidPose`] that writes it; for cloth and ropes it stays the frame in which the
/// mesh is written. Either way, a game that moves it, or a parent of it, teleports the particles along. One that a game scales is built anew in its
/// new size, where its `Transform` is, and keeps its velocities.
///
/// The simulation itself lives in the world. A body that falls in the frame of a parent falls as it does without; a parent that moves carries it along
/// in every tick, by as much as the parent moved (so a crate that is a child of a lift goes with it even while it is in the air; to have it carried by
/// contact alone, do not make it a child). A parent that is scaled unevenly would shear what turns in it, and a rigid body there is refused
/// ([`Refusal::Sheared`](crate::Refusal::Sheared)).
///
/// [`LinearVelocity`] and [`AngularVelocity`] that are spawned with it are its first motion.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component, Default, Clone)]
#[require(Transform, ExtractedTransform, Rows<BodyParticles>)]
#[require(LinearVelocity, AngularVelocity, ExtractedVelocity, WorldCenterOfMass, Inertia)]
#[require(ResolvedShape)]
pub struct ParticleBody;

/// Says to which body a particle belongs.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = BodyParticles)]
pub struct ParticleOf(#[entities] pub Entity);

/// The particles of a body, in the order in which they joined it.
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

/// Says to which body a spring or a constraint belongs, so that it goes when the body goes.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = BodyConstraints)]
pub struct ConstraintOf(#[entities] pub Entity);

/// The springs and constraints of a body.
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = ConstraintOf, linked_spawn)]
pub struct BodyConstraints(Vec<Entity>);

/// Drives this entity's `Transform` with particles: after each tick it is the rotation and translation that best map `rest` onto them.
///
/// The best is in the sense of least mass-weighted squares ([`sinew::pose`]); the scale is left alone.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::RigidPose;
/// # fn example(mut commands: Commands) {
/// // Two particles at the ends of a rod carry a picture of it, which lies along x in its own frame.
/// let ends = [Vec3::ZERO, Vec3::Y];
/// let particles = ends.map(|at| commands.spawn(Particle::at(at)).id());
/// commands.spawn(DistanceConstraint::new(particles[0], particles[1], 1.0));
/// let rest = vec![Vec3::X * -0.5, Vec3::X * 0.5];
/// commands.spawn((RigidPose { particles: particles.into(), rest }, Transform::default()));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default, Clone)]
#[require(Transform, CreationOrder, Rows<RigidPose>)]
pub struct RigidPose {
    /// The particles that carry it.
    #[entities]
    pub particles: Vec<Entity>,
    /// Where each of them sits in this entity's own frame, metres; as many as `particles`.
    pub rest: Vec<Vec3>,
}

/// Triangles of particles on which [`Wind`](super::Wind) presses, and by which the body that it is on collides if it asks for that
/// ([`ContactShape::Triangles`](super::ContactShape)).
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
#[require(Rows<WindSurface>)]
pub struct WindSurface {
    /// The corners of each triangle.
    #[entities]
    pub triangles: Vec<[Entity; 3]>,
}

/// Drives the vertices of this entity's `Mesh3d` with particles; normals follow.
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
#[require(Transform, Rows<MeshFollow>)]
pub struct MeshFollow {
    /// The particle that each vertex follows, in the order of the mesh's vertices.
    #[entities]
    pub vertices: Vec<Entity>,
}

/// Draws a chain of particles as a tube: gives this entity a `Mesh3d` and keeps it around them.
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
#[require(Transform, Rows<TubeMesh>)]
pub struct TubeMesh {
    /// The particles along the middle of the tube.
    #[entities]
    pub particles: Vec<Entity>,
    /// Radius of the tube, metres. Default 0.02.
    pub radius: f32,
    /// Edges of its cross-section, 3 to 64. Default 8.
    pub sides: u32,
}

impl Default for TubeMesh {
    fn default() -> Self {
        Self { particles: Vec::new(), radius: 0.02, sides: 8 }
    }
}

/// Eases what is drawn of this body, or of this loose particle, between two ticks: its transforms and those of its parts (through
/// `bevy_transform_interpolation`), and its mesh. It may come and go at any time.
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

/// Where in the world the simulation last left the entity. Where its `Transform` and those of its parents put it elsewhere, somebody else moved it, and
/// its particles are moved along. Part of the state: save and restore it together with `Transform`.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ExtractedTransform(pub Option<Transform>);

/// Velocity of a body's barycentre in the world, m/s: `Σ m v / Σ m`. Written after each tick. Bodies come with it; a single [`Particle`](crate::Particle) has one where a game
/// adds it, and then its velocity.
///
/// Spawned with a body it is its first motion; changed by a game, it changes the body's, at the beginning of the next tick: all its particles by the same,
/// so that spin and inner motion stay. Pinned particles do not move. A number that is not finite is refused, and the body goes on as it did.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // Thrown, with a spin.
/// let motion = (LinearVelocity(Vec3::new(0.0, 4.0, -8.0)), AngularVelocity(Vec3::X * 6.0));
/// commands.spawn((RigidBox::new(Vec3::splat(0.2)), motion));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(ExtractedVelocity)]
pub struct LinearVelocity(pub Vec3);

/// Angular velocity of a body about its barycentre in the world, rad/s: `I⁻¹ Σ m r×v`. Written after each tick.
///
/// Spawned with a body, or changed by a game, it sets the body's, as [`LinearVelocity`] does; inner motion that is no spin stays. About a line on which all
/// particles lie there is no spin.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// // A top, and what reads how fast bodies turn.
/// commands.spawn((RigidBox::new(Vec3::new(0.4, 0.1, 0.4)), AngularVelocity(Vec3::Y * 20.0)));
/// fn fastest(bodies: Query<&AngularVelocity>) -> f32 {
///     bodies.iter().map(|spin| spin.0.length()).fold(0.0, f32::max)
/// }
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct AngularVelocity(pub Vec3);

/// The velocities that the simulation last wrote to [`LinearVelocity`] and [`AngularVelocity`]: where those differ, a game changed them, and the body is
/// to have them. `None` before the body's first tick. Part of the state: save and restore it with them.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ExtractedVelocity(pub Option<(Vec3, Vec3)>);

/// A body's centre of mass in the world, metres, and its total mass, kg. Written after each tick. A pinned particle counts with the
/// [`Mass`](super::Mass) that it would have if it were let go.
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

/// Inertia tensor of a body about its barycentre, kg·m², in the axes of the world, so it turns with the body. Written after each tick.
///
/// It is that of the particles as points, `Σ m (r² 1 - r rᵀ)`: for a box with particles at its corners three times the solid's, for an
/// [equimomental](crate::BoxParticles::Equimomental) one the solid's. Pinned particles count as in [`WorldCenterOfMass`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::Inertia;
/// /// How hard a body is to turn about the vertical through its centre, kg·m².
/// fn about_y(inertia: &Inertia) -> f32 {
///     inertia.0.y_axis.y
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Inertia(pub Mat3);

impl Default for Inertia {
    /// None, as before the first tick.
    fn default() -> Self {
        Self(Mat3::ZERO)
    }
}

/// How the last tick of this body went in the solver. Add it to a body to have it filled; bodies that constraints connect share theirs.
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
    /// Sweeps, summed over the substeps.
    pub sweeps: u32,
    /// Whether it met its tolerance in every substep.
    pub converged: bool,
    /// Substeps in which it turned too fast to be corrected along the start of the step.
    pub fallbacks: u32,
    /// Largest error left in a hard constraint, metres.
    pub error: f32,
    /// Largest error left in a hard distance, as a share of its rest length.
    pub strain: f32,
    /// Time that solving it took, seconds; zero unless [`SolverConfig::timed`](crate::SolverConfig::timed). Wall-clock time: never part of the state.
    pub seconds: f64,
}

/// How strongly gravity pulls on a body or a particle, as a multiple of [`Gravity`](super::Gravity). Without it, 1; a body's and its particles'
/// multiply.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A balloon on a string, which falls upwards.
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

/// How a rigid body moves: a body with a [`RigidPose`], such as a box. Change it at any time: position, rotation, momentum and angular momentum stay.
///
/// The particles are the state either way, current between any two phases. A body without the component has the default, [`Auto`](Self::Auto).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Representation;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A box whose particles are moved one by one, and held together by rods.
/// commands.spawn((RigidBox::default(), Representation::Particles));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Representation {
    /// As one rigid state through the substeps of a tick while only its own rods hold its particles, which follow; as particles otherwise: while one
    /// of them is pinned, attached or tied to something else, or asleep, or something in it can break ([`sinew::Representation::Auto`] has the whole list).
    /// The motion is that of [`Particles`](Self::Particles) without solving the constraints. The default.
    #[default]
    Auto,
    /// As particles that constraints hold together: the lectures' boxes.
    Particles,
    /// As an explicit rigid body. It is read off its particles when a tick begins, moved as position, rotation and two velocities, and written back;
    /// whatever pulls at one of its particles pulls at all. The distances and constraints inside it rest meanwhile.
    Rigid(RigidIntegrator),
}

impl Representation {
    /// The solver's own representation of a body; explicit rigid bodies are compounds besides.
    pub(crate) fn within_a_step(self) -> sinew::Representation {
        match self {
            Self::Auto => sinew::Representation::Auto,
            Self::Particles | Self::Rigid(_) => sinew::Representation::Particles,
        }
    }
}

/// How an explicit rigid body steps through time. [`sinew::rigid`] compares them.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Default, Clone, PartialEq)]
pub enum RigidIntegrator {
    /// As the lectures have it: order 1, drifts. To compare with.
    Euler,
    /// Kick, turn, kick: order 2. The default.
    #[default]
    Leapfrog,
    /// The discrete Moser–Veselov equations: order 2, what Verlet is for rotations.
    Verlet,
}

same_variants!(RigidIntegrator, sinew::RigidIntegrator { Euler, Leapfrog, Verlet });

/// A rigid part of a body, such as a forearm: an entity whose `Transform` follows the particles that carry it. Its `Name` says which.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(CreationOrder)]
pub struct BodyPart {
    /// Its size along its own axes, metres: a capsule along y has the diameter `size.x` and the whole length `size.y`.
    pub size: Vec3,
}

/// Says to which body a part belongs.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[relationship(relationship_target = BodyParts)]
pub struct PartOf(#[entities] pub Entity);

/// The rigid parts of a body that has several; they go when it goes.
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component, Default)]
#[relationship_target(relationship = PartOf, linked_spawn)]
pub struct BodyParts(Vec<Entity>);

/// A body that stands as its recipe has it: it has its particles, its parts and its constraints. Kept by the plugin; part of the state.
///
/// It changes whenever the body is built anew, so that `Changed<BuiltBody>` says the same as [`BodyBuilt`](crate::BodyBuilt) to a system, and it goes where the recipe asks
/// for the impossible.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::BuiltBody;
/// /// How many bodies are there by now.
/// fn count(built: Query<(), With<BuiltBody>>) -> usize {
///     built.iter().count()
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct BuiltBody {
    /// How often it has been built, 1 and up.
    pub builds: u32,
}
