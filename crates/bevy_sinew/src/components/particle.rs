//! A particle and its properties.

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::math::DVec3;
use bevy::prelude::*;
use sinew::{ParticleState, Particles};

use super::order::{CreationOrder, mark_topology};
use crate::same::same_fields;

/// A point mass: its position and velocity in world coordinates, which are the whole state of the Verlet integrator.
///
/// Textbook Verlet stores the current and the previous position. This component stores the same information as a position, the mean velocity of the last
/// substep, and the length of that substep: `previous = position - velocity * lag`. This form keeps its precision far from the origin, starts exactly, and
/// allows the time step to change ([`sinew::particles`] explains why).
///
/// It can be edited at any time: [`teleport`](Self::teleport) and [`displace`](Self::displace) move the particle and keep its velocity,
/// [`set_velocity`](Self::set_velocity) and [`add_impulse`](Self::add_impulse) change the velocity, [`reverse`](Self::reverse) reverses the motion. These are
/// plain arithmetic; the numbers are validated at the beginning of the next tick. To edit whole bodies, with validation, use
/// [`BodyCommandsExt`](crate::BodyCommandsExt).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let ball = Particle::at(Vec3::Y * 2.0).with_velocity(Vec3::X * 3.0);
/// commands.spawn((ball, Mass(0.2), Radius(0.1)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Mass, CreationOrder, ParticleRow)]
#[component(on_add = mark_topology, on_remove = leave)]
pub struct Particle {
    /// Position in the world, metres.
    pub position: Vec3,
    /// The part of the position that `f32` cannot represent, metres (5 km from the origin, adjacent values are 0.5 mm apart). Written together with `position`;
    /// leave it alone, or set it to zero.
    pub remainder: Vec3,
    /// Mean velocity over the last `lag` seconds, m/s.
    pub velocity: Vec3,
    /// Length of the substep over which `velocity` is the mean, seconds; 0 if the velocity is that of this instant.
    pub lag: f32,
}

// What rounding took from a velocity within a tick is not kept beyond it, so that a world that is saved and one that goes on are the same.
same_fields!(Particle, ParticleState { position, remainder, velocity, lag } other { rounding: Vec3::ZERO });

impl Particle {
    /// A particle at rest at `position` (metres).
    pub fn at(position: Vec3) -> Self {
        Self { position, ..default() }
    }

    /// Returns the same particle with a velocity, m/s.
    pub fn with_velocity(self, velocity: Vec3) -> Self {
        Self { velocity, lag: 0.0, ..self }
    }

    /// The position one substep ago, metres: Verlet's previous position.
    pub fn previous(&self) -> Vec3 {
        self.position - self.velocity * self.lag
    }

    /// The velocity at the instant of the position, m/s, from the acceleration (m/s²) of the last substep, which is gravity for a particle in free fall.
    ///
    /// [`LinearVelocity`](super::LinearVelocity) is corrected in the same way, by the actual accelerations.
    pub fn velocity_now(&self, acceleration: Vec3) -> Vec3 {
        self.velocity + acceleration * (0.5 * self.lag)
    }

    /// Moves the particle to a point, metres, and keeps its velocity.
    pub fn teleport(&mut self, to: Vec3) {
        self.position = to;
        self.remainder = Vec3::ZERO;
    }

    /// Moves the particle by a displacement, metres, and keeps its velocity. The part that `f32` cannot represent is added to the remainder.
    pub fn displace(&mut self, by: Vec3) {
        self.place(self.exact() + by.as_dvec3());
    }

    /// Sets the velocity at this instant, m/s.
    pub fn set_velocity(&mut self, velocity: Vec3) {
        self.velocity = velocity;
        self.lag = 0.0;
    }

    /// Applies an impulse, N·s, to a particle of this mass: its momentum changes by exactly the impulse.
    pub fn add_impulse(&mut self, impulse: Vec3, mass: Mass) {
        self.velocity += impulse / mass.0;
    }

    /// Reverses the motion by swapping Verlet's two positions: undamped, unconstrained motion runs backwards from here.
    ///
    /// The reversal itself goes back by one substep: after N substeps, N - 1 more lead back to the start.
    pub fn reverse(&mut self) {
        self.displace(-self.velocity * self.lag);
        self.velocity = -self.velocity;
    }

    /// The exact position, metres.
    pub(crate) fn exact(&self) -> DVec3 {
        self.position.as_dvec3() + self.remainder.as_dvec3()
    }

    /// Sets the exact position, metres.
    pub(crate) fn place(&mut self, exact: DVec3) {
        self.position = exact.as_vec3();
        self.remainder = (exact - self.position.as_dvec3()).as_vec3();
    }
}

/// Hook: resets the row of an entity that loses its particle.
fn leave(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut row) = world.get_mut::<ParticleRow>(context.entity) {
        *row = ParticleRow::default();
    }
    mark_topology(world, context);
}

/// Mass in kilograms, positive. Default 1.
///
/// On a body it is the total mass, which overrides that of the recipe: the masses of its particles are scaled to it when it is added or changed.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// commands.spawn((Particle::at(Vec3::Y), Mass(0.2)));
/// // A body with a total mass of 40 kg.
/// commands.spawn((RigidBox::new(Vec3::ONE), Mass(40.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, PartialOrd)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Mass(pub f32);

impl Default for Mass {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Pins a particle: it has infinite mass for everything else, and moves only as its pin says.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // One particle that is held where it is, and one that is moved to a point.
/// commands.spawn((Particle::at(Vec3::Y), Pinned::default()));
/// commands.spawn((Particle::at(Vec3::ZERO), Pinned::at(Vec3::X)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Pinned {
    /// The point, metres, to which the particle is moved over the next tick; `None` (the default) holds it where it is.
    pub target: Option<Vec3>,
}

impl Pinned {
    /// Held where it is.
    pub const HERE: Self = Self { target: None };

    /// Moved to `point` (metres) over the next tick, and held there.
    pub fn at(point: Vec3) -> Self {
        Self { target: Some(point) }
    }
}

/// Pins a particle to a point of another entity, which may move: the end of a rope in a hand. To pin parts of bodies, and to attach to simulated bodies, use
/// [`AttachTo`](crate::AttachTo).
///
/// Removing it, or despawning the other entity, releases the particle; the latter with a [`Refused`](crate::Refused) message.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// let hand = commands.spawn(Transform::from_xyz(0.0, 1.5, 0.0)).id();
/// let offset = Vec3::NEG_Y * 0.1;
/// commands.spawn((Particle::at(Vec3::Y), PinnedTo { entity: hand, offset }));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
pub struct PinnedTo {
    /// The entity whose world transform the particle follows.
    #[entities]
    pub entity: Entity,
    /// The point in the entity's own coordinates.
    pub offset: Vec3,
}

/// Radius of a particle in metres, 0 or more: of the ball by which it collides, floats and is subject to an [`AirFlow`](super::AirFlow). Default 0, as without
/// the component: a point.
///
/// On a body it is the radius of each of its particles, which overrides that of the recipe.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// // A marble, and a thick rope.
/// commands.spawn((Particle::at(Vec3::Y), Radius(0.01)));
/// commands.spawn((Rope::between(Vec3::ZERO, Vec3::X * 3.0), Radius(0.05)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Radius(pub f32);

/// Electric charge in coulombs. Default 0, as without the component.
///
/// On a body it is the total charge, distributed in proportion to the masses of the particles, so that a uniform field exerts no torque.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Charge};
/// # fn spawn(mut commands: Commands) {
/// for (x, charge) in [(-0.5, 2e-6), (0.5, -2e-6)] {
///     commands.spawn((Particle::at(Vec3::X * x), Mass(0.1), Charge(charge)));
/// }
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Charge(pub f32);

/// Damping of a particle: the fraction of its velocity that it loses per second, 0 to 1. It is added to [`AirDrag`](super::AirDrag) and to the drag of a fluid.
/// Default 0, as without the component.
///
/// On a body it is the damping of each of its particles, which overrides that of the recipe.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Drag};
/// # fn spawn(mut commands: Commands) {
/// // A feather and a stone.
/// commands.spawn((Particle::at(Vec3::Y), Mass(0.01), Drag(0.9)));
/// commands.spawn((Particle::at(Vec3::X + Vec3::Y), Mass(1.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Drag(pub f32);

/// A force in newtons, along the world's axes, that the game applies in every substep, until it is changed or removed: to a particle, or to a body or a rigid
/// part of one, at the centre of mass. For a force at a point, or in the body's own frame, use [`ControlForce`](super::ControlForce).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A balloon.
/// let balloon = RigidBox::new(Vec3::splat(0.3)).with_mass(0.1);
/// commands.spawn((balloon, ExternalForce(Vec3::Y * 1.5)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct ExternalForce(pub Vec3);

/// The row of the solver's columns that holds this particle. Scratch: assigned again whenever particles are added or removed.
///
/// A custom force system reads it to find the particle in [`SinewWorld`](crate::SinewWorld).
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(clone_behavior = Ignore)]
pub struct ParticleRow(pub(crate) u32);

impl ParticleRow {
    /// The row, or `None` before the particle's first tick.
    pub fn get(self) -> Option<usize> {
        (self.0 != u32::MAX).then_some(self.0 as usize)
    }

    /// The row, if the columns have it.
    pub(crate) fn within(self, particles: &Particles) -> Option<usize> {
        self.get().filter(|&row| row < particles.len())
    }
}

impl Default for ParticleRow {
    fn default() -> Self {
        Self(u32::MAX)
    }
}
