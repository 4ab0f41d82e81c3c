//! Bodies that rest.

use bevy::prelude::*;

/// Lets a body sleep: once it and all that touches it have been still for half a second, it is left out of the simulation, until something that moves
/// comes near, it is pushed, or what surrounds it changes. Meanwhile nothing of it is written, and Bevy sees no change of it. Part of the state: save and
/// restore it with the rest.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// for i in 0..10 {
///     let at = Transform::from_xyz(0.0, 0.5 + i as f32, 0.0);
///     commands.spawn((RigidBox::default(), Sleep::default(), at));
/// }
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Sleep {
    /// What is slower than this is still, m/s, 0 and up. Default 0.02.
    pub speed: f32,
    /// For how long it has been still, seconds.
    pub still: f32,
    /// Whether it sleeps. To wake it by hand, take [`Sleep::default`].
    pub asleep: bool,
    /// What surrounded it when that was last looked at: a number made of gravity and of all colliders, winds and fluids, which wake it when
    /// they change. Default 0, when it has not been looked at.
    pub around: u64,
}

impl Default for Sleep {
    fn default() -> Self {
        let sinew::Sleep { speed, still, asleep, .. } = sinew::Sleep::default();
        Self { speed, still, asleep, around: 0 }
    }
}

impl Sleep {
    /// Wakes it.
    pub fn wake(&mut self) {
        (self.still, self.asleep) = (0.0, false);
    }
}
