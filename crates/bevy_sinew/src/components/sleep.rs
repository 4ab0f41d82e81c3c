//! Sleeping bodies.

use bevy::prelude::*;

/// Allows a body to sleep: once it and everything that it touches have been still for half a second, it is left out of the simulation until something wakes it.
/// Meanwhile none of its components is written, so Bevy detects no change. Part of the state: save and restore it with the rest.
///
/// Rigid bodies, ragdolls, articulated and soft bodies have it by default; add it to cloth and ropes to let them sleep. [`SleepingDisabled`] keeps a body
/// awake.
///
/// A body wakes, together with everything that it touches, when
///
/// - a moving body or [`Collider`](crate::Collider) comes near it, or what it rests or hangs on is gone;
/// - the game moves it, its parent or one of its particles, or applies a velocity, an impulse, a force or a [`ControlForce`](crate::ControlForce);
/// - one of its constraints, springs or attachments is added, changed or removed, a pin is removed, or a mass, a radius, a
///   [`GravityScale`](crate::GravityScale) or the hull by which it [`Floats`](crate::Floats) changes;
/// - the shape, the surface or the layers of a collider next to it change;
/// - something in the environment changes or moves: gravity, air, winds, fluids, fields, attractors, the plane of a [`Flatland`](crate::Flatland). Then all
///   bodies wake;
/// - a custom system adds a force to it within a tick, or moves it ([`ParticlesMut`](crate::SinewWorld::particles_mut)): it wakes in the next tick.
///
/// The following do not sleep: bodies with charges, since the forces between charges change with each of them; bodies with a surface
/// ([`WindSurface`](crate::WindSurface)) while gusts may push them by more than a tenth of their weight; and bodies that touch an entity with
/// [`ContactEvents::Every`](crate::ContactEvents::Every).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn wake_all(mut sleepers: Query<&mut Sleep>) {
///     sleepers.iter_mut().for_each(|mut sleep| sleep.wake());
/// }
///
/// fn cloth_that_sleeps(mut commands: Commands) {
///     commands.spawn((Cloth::grid(1.0, 1.0, 16, 16), Sleep::default()));
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct Sleep {
    /// Speed below which a particle counts as still, m/s, 0 or more. Default 0.02.
    pub speed: f32,
    /// For how long the body has been still, seconds.
    pub still: f32,
    /// Whether the body sleeps. To wake it, call [`wake`](Self::wake).
    pub asleep: bool,
    /// Hash of the body and everything next to it when it fell asleep: positions, masses, constraints, springs, colliders, and what they rested or hung on. If
    /// the current hash differs, it wakes. In the tick before it may fall asleep, of the same without positions. Default 0, otherwise while it is awake.
    pub support_hash: u64,
    /// Hash of the environment when it was last checked: of gravity and of all air, winds, fluids and fields. A change wakes the body. Default 0, before the
    /// first check.
    pub environment_hash: u64,
}

impl Default for Sleep {
    fn default() -> Self {
        let sinew::Sleep { speed, still, asleep, support_hash, .. } = sinew::Sleep::default();
        Self { speed, still, asleep, support_hash, environment_hash: 0 }
    }
}

impl Sleep {
    /// Wakes the body. It may fall asleep again after half a second.
    pub fn wake(&mut self) {
        (self.still, self.asleep) = (0.0, false);
    }
}

/// Keeps a body awake, and with it everything that it touches, however still it is. Adding and removing it takes effect in the next tick.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::SleepingDisabled;
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((Ragdoll::default(), SleepingDisabled));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[doc(alias = "KeepAwake")]
pub struct SleepingDisabled;
