//! Accelerations that do not depend on mass: uniform gravity, and attracting points.

use bevy::prelude::*;

use crate::components::CreationOrder;

/// Gravitational acceleration, m/s². Default `(0, -9.81, 0)`. [`GravityScale`](crate::GravityScale) scales it for a body or a particle.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins));
/// // On the moon.
/// app.insert_resource(Gravity(Vec3::NEG_Y * 1.62)).insert_resource(AirDrag(0.0));
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, Default, Clone)]
pub struct Gravity(pub Vec3);

impl Default for Gravity {
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}

/// A point that attracts every particle: a planet, a black hole. It is at the position of the entity, and is not attracted itself.
///
/// The acceleration at the distance `r` is `strength · r / (r² + softening²)^{3/2}`, times the particle's [`GravityScale`](crate::GravityScale). It is added to
/// [`Gravity`]; for a scene in space, set that to zero.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::{Attractor};
/// # fn spawn(mut commands: Commands) {
/// commands.insert_resource(Gravity(Vec3::ZERO));
/// commands.spawn((Attractor::new(20.0).with_softening(0.1), Transform::from_xyz(0.0, 2.0, 0.0)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Transform, CreationOrder)]
pub struct Attractor {
    /// Gravitational parameter `GM`, m³/s²; negative values repel. Default 100: 1 m/s² at 10 m.
    pub strength: f32,
    /// Softening length, metres, 0 or more: the attraction does not increase at smaller distances. Default 0.1; keep it above the distance that a particle
    /// moves in a substep.
    pub softening: f32,
}

impl Default for Attractor {
    fn default() -> Self {
        Self::new(100.0)
    }
}

impl Attractor {
    /// A point that attracts with the gravitational parameter `strength`, m³/s², softened over 0.1 m.
    pub fn new(strength: f32) -> Self {
        let softening = sinew::Attractor::new(Vec3::ZERO, strength).softening;
        Self { strength, softening }
    }

    /// Returns the same attractor with another softening length, metres.
    pub fn with_softening(self, softening: f32) -> Self {
        Self { softening, ..self }
    }

    /// The solver's attractor, at a point of the world.
    pub(crate) fn at(self, position: Vec3) -> sinew::Attractor {
        let Self { strength, softening } = self;
        sinew::Attractor { position, strength, softening }
    }
}
