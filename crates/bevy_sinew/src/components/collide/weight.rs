//! The weight of kinematic colliders.

use bevy::prelude::*;

/// Gives a kinematic [`Collider`](super::Collider) a weight, with which it presses on what it stands on: a player bends the planks of a rope bridge and tips a
/// seesaw. Without it, a collider weighs nothing, however it is moved.
///
/// The weight of `mass` in [`Gravity`](crate::Gravity) presses on bodies, cloth and particles directly below, like a plate on springs: several points of
/// support share it. The collider is not moved by it, and nothing but the weight acts: a landing exerts no more than the weight. A [`Sensor`](super::Sensor)
/// presses on nothing. A component with a number that is not finite or negative has no effect, and is refused once.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::Weighs;
/// # use bevy_sinew::prelude::*;
/// fn spawn(mut commands: Commands) {
///     let player = (Collider::capsule(0.3, 1.2), Weighs::new(80.0));
///     commands.spawn((player, Transform::from_xyz(0.0, 0.91, 0.0)));
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Weighs {
    /// The mass, kg, 0 or more. Default 80.
    pub mass: f32,
    /// How far below the collider something may be to support it, metres, 0 or more; it must exceed the gap that the game keeps. Default 0.05.
    pub reach: f32,
}

impl Default for Weighs {
    fn default() -> Self {
        Self { mass: 80.0, reach: 0.05 }
    }
}

impl Weighs {
    /// The weight of a mass, kg, with the default reach.
    pub fn new(mass: f32) -> Self {
        Self { mass, ..Self::default() }
    }

    /// Whether its numbers are in their ranges.
    pub(crate) fn is_valid(&self) -> bool {
        let valid = |x: f32| x.is_finite() && x >= 0.0;
        valid(self.mass) && valid(self.reach)
    }
}
