//! The weight of what a game moves by itself.

use bevy::prelude::*;

/// Has a [`Collider`](super::Collider) that the game moves press on what it stands on, with the weight of its mass in [`Gravity`](crate::Gravity): a player
/// bends the planks of a rope bridge and tips a seesaw. Without it, a collider weighs nothing, however it is moved.
///
/// It presses on bodies, cloth and particles that are right below it, as a plate on springs does: where it touches them in several points, these share its
/// weight. It does not fall by that, and nothing else of it acts: a leap gives no more than its weight. A [`Sensor`](super::Sensor) presses on nothing. One
/// with a number that is not finite or is negative does nothing, and is refused once.
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
    /// Mass whose weight it is, kg, 0 and up. Default 80.
    pub mass: f32,
    /// How far below it something may be to carry it, metres, 0 and up: more than the gap that the game keeps. Default 0.05.
    pub reach: f32,
}

impl Default for Weighs {
    fn default() -> Self {
        Self { mass: 80.0, reach: 0.05 }
    }
}

impl Weighs {
    /// The weight of a mass, kg.
    pub fn new(mass: f32) -> Self {
        Self { mass, ..Self::default() }
    }

    /// Whether its numbers are in their ranges.
    pub(crate) fn is_valid(&self) -> bool {
        let sound = |x: f32| x.is_finite() && x >= 0.0;
        sound(self.mass) && sound(self.reach)
    }
}
