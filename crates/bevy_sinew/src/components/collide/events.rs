//! What a game hears of contacts: who touches whom, and when that began and ended.

use bevy::ecs::entity::MapEntities;
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

/// Asks for the contacts of this body or collider to be told: as [`ContactStarted`] and [`ContactEnded`], which are messages to be read and events to
/// be observed on this very entity, and as a list, [`Touching`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::ContactImpulse;
/// fn spawn(mut commands: Commands) {
///     // A scale: what presses on it, in every tick.
///     let scale = (Collider::cuboid(Vec3::ONE), ContactEvents::Every);
///     commands.spawn(scale).observe(|on: On<ContactImpulse>, time: Res<Time<Fixed>>| {
///         println!("{} N", on.impulse / time.timestep().as_secs_f32());
///     });
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Touching)]
pub enum ContactEvents {
    /// When they begin and when they end. The default.
    #[default]
    Changes,
    /// That, and in every tick each one that there is, with what it does, as [`ContactImpulse`].
    Every,
}

/// Whom it touches, as of the last tick: bodies, loose particles and colliders, each in the order of creation. Kept by the plugin on whatever has [`ContactEvents`]. Part of the state:
/// save and restore it with the rest, or contacts that go on begin anew. Where it goes, because the entity does, its contacts end.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::Touching;
/// /// Whether a player, who has [`ContactEvents`], stands on anything.
/// fn on_something(touching: &Touching) -> bool {
///     !touching.0.is_empty()
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(on_remove = end_all)]
pub struct Touching(#[entities] pub Vec<Entity>);

/// Whose contacts the [report](crate::SinewWorld::report) lists although they have no [`ContactEvents`]: for tools that show them. Nothing is sent, and nothing
/// of the state or of the motion changes.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::WatchedContacts;
/// fn touches(watched: Res<WatchedContacts>, world: Res<SinewWorld>) {
///     for impact in &world.report().impacts {
///         let two = [impact.first, impact.second].map(|one| world.entity_of(one));
///         if two.contains(&watched.body) {
///             println!("{} N·s at {}", impact.impulse, impact.point);
///         }
///     }
/// }
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, PartialEq)]
pub struct WatchedContacts {
    /// Of one body or loose particle. Default none.
    pub body: Option<Entity>,
    /// Of all. Default not.
    pub all: bool,
}

/// A contact that began in this tick, of an entity with [`ContactEvents`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # fn example(mut commands: Commands) {
/// commands.spawn((RigidBox::new(Vec3::ONE), ContactEvents::Changes)).observe(
///     |hit: On<ContactStarted>| println!("{} hits {} with {} N·s", hit.entity, hit.other, hit.impulse),
/// );
/// # }
/// ```
#[derive(Message, EntityEvent, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Clone, PartialEq)]
pub struct ContactStarted {
    /// Who asked.
    pub entity: Entity,
    /// Whom it touches: a body, a loose particle or a collider.
    pub other: Entity,
    /// Where, metres; of several places the one with the greatest impulse.
    pub point: Vec3,
    /// Unit vector there, from the other one to the one who asked.
    pub normal: Vec3,
    /// What the one who asked got along the normals in this tick, N·s; zero where one of them is a [`Sensor`](super::Sensor).
    pub impulse: f32,
    /// Whether one of them is a sensor.
    pub sensor: bool,
}

/// A contact that there is in this tick, the first one included, of an entity with [`ContactEvents::Every`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::ContactImpulse;
/// /// The hardest press of this tick, N·s.
/// fn hardest(mut impulses: MessageReader<ContactImpulse>, mut most: Local<f32>) {
///     *most = impulses.read().map(|contact| contact.impulse).fold(0.0, f32::max);
/// }
/// ```
#[derive(Message, EntityEvent, Reflect, Clone, Copy, Debug, PartialEq)]
pub struct ContactImpulse {
    /// Who asked.
    pub entity: Entity,
    /// Whom it touches: a body, a loose particle or a collider.
    pub other: Entity,
    /// Where, metres; of several places the one with the greatest impulse.
    pub point: Vec3,
    /// Unit vector there, from the other one to the one who asked.
    pub normal: Vec3,
    /// What the one who asked got along the normals in this tick, N·s: over the length of the tick, the mean force. Zero where one of them is a
    /// [`Sensor`](super::Sensor), and of what sleeps.
    pub impulse: f32,
    /// Whether one of them is a sensor.
    pub sensor: bool,
}

/// A contact that was there in the last tick and is not any more, of an entity with [`ContactEvents`]. The other one may be gone, and so may be the
/// entity. The contacts of a body end, too, when it is built anew in another size or gets another parent; those that it has all the same begin again.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// fn listen(mut ended: MessageReader<ContactEnded>) {
///     for end in ended.read() {
///         println!("{} lets go of {}", end.entity, end.other);
///     }
/// }
/// ```
#[derive(Message, EntityEvent, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Clone, PartialEq)]
pub struct ContactEnded {
    /// Who asked.
    pub entity: Entity,
    /// Whom it touched.
    pub other: Entity,
}

/// Ends the contacts of an entity that has none any more.
fn end_all(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    let Some(mut touching) = world.get_mut::<Touching>(entity) else { return };
    for other in core::mem::take(&mut touching.0) {
        let event = ContactEnded { entity, other };
        world.write_message(event);
        world.trigger(event);
    }
}

/// What lost its parent since the last tick. Part of the state.
#[derive(Resource, MapEntities, Reflect, Clone, Debug, Default)]
pub(crate) struct Orphans(#[entities] pub(crate) Vec<Entity>);
