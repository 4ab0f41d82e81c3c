//! Bodies that rest.

use bevy::prelude::*;

/// Lets a body sleep: once it and all that touches it have been still for half a second, it is left out of the simulation until something wakes it.
/// Meanwhile nothing of it is written, and Bevy sees no change of it. Part of the state: save and restore it with the rest.
///
/// Rigid bodies, ragdolls, articulated and soft bodies come with it; cloth and ropes do when a game adds it. [`SleepingDisabled`] keeps a body awake.
///
/// What wakes it, and with it all that touches it:
///
/// - something that moves comes near, be it a body or a [`Collider`](crate::Collider); what it lay on or hung on is gone;
/// - the game moves it, its parent or one of its particles, gives it a velocity, an impulse, a force or a [`ControlForce`](crate::ControlForce);
/// - a constraint, a spring or an attachment of it comes, changes or goes, a pin is drawn, or a mass, a radius or a [`GravityScale`](crate::GravityScale) is
///   another one;
/// - the shape, the surface or the layers of a collider beside it change;
/// - something that fills the world changes or moves: gravity, air, winds, fluids, fields, attractors. Then all wake;
/// - a system of the game's own adds a force to it within a tick, or moves it ([`ParticlesMut`](crate::SinewWorld::particles_mut)): it wakes with the next one.
///
/// What carries charges does not sleep, as what they do to each other changes with each of them; nor does what has a skin
/// ([`WindSurface`](crate::WindSurface)) while gusts may push it by more than a tenth of its weight; nor what touches somebody who asks for
/// [every contact](crate::ContactEvents::Every).
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
    /// What is slower than this is still, m/s, 0 and up. Default 0.02.
    pub speed: f32,
    /// For how long it has been still, seconds.
    pub still: f32,
    /// Whether it sleeps. To wake it by hand, take [`Sleep::default`].
    pub asleep: bool,
    /// Hash of what it and all that it lay beside were made of, lay on and hung on when it fell asleep: places, masses, constraints, springs, colliders. Where that is another
    /// one, it wakes. Default 0, while it is awake.
    pub support_hash: u64,
    /// What surrounded it when that was last looked at: a number made of gravity and of all air, winds, fluids and fields, which wake it when
    /// they change. Default 0, when it has not been looked at.
    pub around: u64,
}

impl Default for Sleep {
    fn default() -> Self {
        let sinew::Sleep { speed, still, asleep, support_hash, .. } = sinew::Sleep::default();
        Self { speed, still, asleep, support_hash, around: 0 }
    }
}

impl Sleep {
    /// Wakes it.
    pub fn wake(&mut self) {
        (self.still, self.asleep) = (0.0, false);
    }
}

/// Keeps a body awake, and with it all that touches it, however still it lies. Takes effect in the next tick, and so does taking it off.
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
