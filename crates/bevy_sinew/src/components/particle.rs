//! A particle and its properties.

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::math::DVec3;
use bevy::prelude::*;
use sinew::ParticleState;

use super::order::{CreationOrder, mark_topology};
use crate::same::same_fields;

/// A point mass: the whole state of Verlet, in world coordinates.
///
/// The lectures keep the position and the previous one. This component keeps the same as a position, the mean velocity of the last
/// substep, and that substep's length: `previous = position - velocity * lag`. That loses no digits far from the origin, starts exactly,
/// and survives a change of the time step ([`sinew::particles`] says why).
///
/// Edit it at any time: [`teleport`](Self::teleport) and [`displace`](Self::displace) move it and leave the velocity,
/// [`set_velocity`](Self::set_velocity) and [`add_impulse`](Self::add_impulse) change the velocity, [`reverse`](Self::reverse) sends it back.
/// These are plain arithmetic: whether the numbers are any good is looked at when the next tick begins. What edits whole bodies, and refuses, is
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
    /// Where it is, metres.
    pub position: Vec3,
    /// What `position` leaves out because `f32` has no digits for it, metres: 5 km from the origin they are 0.5 mm apart. Written with it; leave it
    /// alone, or at zero.
    pub remainder: Vec3,
    /// Mean velocity over the last `lag` seconds, m/s.
    pub velocity: Vec3,
    /// Length of the substep over which `velocity` is the mean, seconds; 0 says that the velocity is true now.
    pub lag: f32,
}

same_fields!(Particle, ParticleState { position, remainder, velocity, lag });

impl Particle {
    /// A particle at rest at `position` (metres).
    pub fn at(position: Vec3) -> Self {
        Self { position, ..default() }
    }

    /// The same with a velocity, m/s.
    pub fn with_velocity(self, velocity: Vec3) -> Self {
        Self { velocity, lag: 0.0, ..self }
    }

    /// Where it was one substep ago, metres: Verlet's previous position.
    pub fn previous(&self) -> Vec3 {
        self.position - self.velocity * self.lag
    }

    /// The velocity at the instant of the position, m/s, under the acceleration (m/s²) of the last substep: gravity, for what falls freely.
    ///
    /// [`LinearVelocity`](super::LinearVelocity) knows the acceleration of a body's particles by itself.
    pub fn velocity_now(&self, acceleration: Vec3) -> Vec3 {
        self.velocity + acceleration * (0.5 * self.lag)
    }

    /// Moves it to a point, metres, and leaves its velocity: in the lectures, both positions move by the same.
    pub fn teleport(&mut self, to: Vec3) {
        self.position = to;
        self.remainder = Vec3::ZERO;
    }

    /// Moves it by so many metres and leaves its velocity. What `f32` has no digits for goes into the remainder.
    pub fn displace(&mut self, by: Vec3) {
        self.place(self.exact() + by.as_dvec3());
    }

    /// Sets the velocity, m/s, true at this instant.
    pub fn set_velocity(&mut self, velocity: Vec3) {
        self.velocity = velocity;
        self.lag = 0.0;
    }

    /// Adds an impulse, N·s, to a particle of the given mass: its momentum changes by exactly that.
    pub fn add_impulse(&mut self, impulse: Vec3, mass: Mass) {
        self.velocity += impulse / mass.0;
    }

    /// Swaps the two positions of Verlet: undamped, unconstrained motion runs backwards from here.
    ///
    /// That goes back by one substep at once: after N substeps, N - 1 more lead back to the start.
    pub fn reverse(&mut self) {
        self.displace(-self.velocity * self.lag);
        self.velocity = -self.velocity;
    }

    /// Where it is, to the last digit, metres.
    pub(crate) fn exact(&self) -> DVec3 {
        self.position.as_dvec3() + self.remainder.as_dvec3()
    }

    /// Puts it there, metres.
    pub(crate) fn place(&mut self, exact: DVec3) {
        self.position = exact.as_vec3();
        self.remainder = (exact - self.position.as_dvec3()).as_vec3();
    }
}

/// Takes the row from an entity that is no particle any more.
fn leave(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut row) = world.get_mut::<ParticleRow>(context.entity) {
        *row = ParticleRow::default();
    }
    mark_topology(world, context);
}

/// Mass in kilograms, positive. Default 1.
///
/// On a body it is that of all its particles together, whatever its recipe says: they are scaled to it, when it comes or changes, and keep their shares.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// commands.spawn((Particle::at(Vec3::Y), Mass(0.2)));
/// // A body of 40 kg, all of it together.
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

/// Holds a particle: it has infinite mass for everything else, and only its pin moves it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // One stays where it is, and one goes where the game leads it.
/// commands.spawn((Particle::at(Vec3::Y), Pinned::default()));
/// commands.spawn((Particle::at(Vec3::ZERO), Pinned::at(Vec3::X)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Pinned {
    /// The point it is led to over the next tick, metres; `None` (the default) holds it where it is.
    pub target: Option<Vec3>,
}

impl Pinned {
    /// Held where it is.
    pub const HERE: Self = Self { target: None };

    /// Led to `point` (metres) over the next tick, and held there.
    pub fn at(point: Vec3) -> Self {
        Self { target: Some(point) }
    }
}

/// Holds a particle at a point of another entity, which may move: the end of a rope in a hand.
///
/// Removing it (or despawning the other entity) lets go of the particle.
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
    /// The entity whose `GlobalTransform` leads the particle.
    #[entities]
    pub entity: Entity,
    /// Where on it, in its own coordinates.
    pub offset: Vec3,
}

/// Radius in metres, 0 and up: how far from the ground the particle's centre stays, how big a ball floats, and how big it is for what it touches.
/// Without it, 0.
///
/// On a body it is that of each of its particles, whatever its recipe says.
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

/// Electric charge in coulombs. Without it, 0.
///
/// On a body it is that of all its particles together, spread as their masses are, so that a uniform field turns nothing.
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

/// Share of its velocity that the particle loses per second, 0 to 1. Adds to [`AirDrag`](super::AirDrag) and to a fluid's. Without it, 0.
///
/// On a body it is that of each of its particles, whatever its recipe says.
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

/// A force in newtons, along the world's axes, that the game exerts in every substep, until it is changed or removed: on a particle, or on a body or a
/// rigid part of one as a whole, at the barycentre. [`ControlForce`](super::ControlForce) acts at a point, or in the body's own frame.
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

/// Which row of the solver's columns holds this particle. Scratch: it is given anew whenever particles come or go.
///
/// A force system of a game's own reads it to find the particle in [`SinewWorld`](crate::SinewWorld).
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(clone_behavior = Ignore)]
pub struct ParticleRow(pub(crate) u32);

impl ParticleRow {
    /// The row, or `None` before the particle's first tick.
    pub fn get(self) -> Option<usize> {
        (self.0 != u32::MAX).then_some(self.0 as usize)
    }
}

impl Default for ParticleRow {
    fn default() -> Self {
        Self(u32::MAX)
    }
}
