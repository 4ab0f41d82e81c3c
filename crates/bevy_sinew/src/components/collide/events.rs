//! Contact events: which entities touch, and when that began and ended.

use bevy::ecs::entity::MapEntities;
use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

/// Enables contact events for this body or collider: [`ContactStarted`] and [`ContactEnded`], which are messages and events that can be observed on this
/// entity, and the list [`Touching`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::ContactImpulse;
/// fn spawn(mut commands: Commands) {
///     // A scale: it prints the force on it in every tick.
///     let scale = (Collider::cuboid(Vec3::ONE), ContactEvents::Every);
///     commands.spawn(scale).observe(|on: On<ContactImpulse>, time: Res<Time<Fixed>>| {
///         println!("{} N", on.impulse / time.timestep().as_secs_f32());
///     });
/// }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Touching)]
#[component(on_remove = end_all)]
pub enum ContactEvents {
    /// When contacts begin and when they end. The default.
    #[default]
    Changes,
    /// Additionally, in every tick, each contact with its impulse, as [`ContactImpulse`].
    Every,
}

/// The entities that this one touched in the last tick: bodies, then loose particles, then colliders, each in the order of creation. Kept by the plugin on
/// every entity with [`ContactEvents`]. Part of the state: save and restore it with the rest, or contacts that continue are reported as new. When it or
/// `ContactEvents` is removed, for instance with its entity, its contacts end.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::Touching;
/// /// Whether a player with [`ContactEvents`] touches anything.
/// fn on_something(touching: &Touching) -> bool {
///     !touching.0.is_empty()
/// }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[component(clone_behavior = Ignore, on_remove = end_all)]
pub struct Touching(#[entities] pub Vec<Entity>);

/// Lists contacts in the [report](crate::SinewWorld::report) for entities without [`ContactEvents`], for debugging tools. No events are sent, and neither the
/// state nor the motion changes.
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
    /// A body or loose particle whose contacts are listed. Default none.
    pub body: Option<Entity>,
    /// Whether the contacts of all entities are listed. Default false.
    pub all: bool,
}

/// A contact of an entity with [`ContactEvents`] that began in this tick.
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
    /// The entity with [`ContactEvents`].
    pub entity: Entity,
    /// The other entity: a body, a loose particle or a collider.
    pub other: Entity,
    /// The contact point, metres; of several points the one with the greatest impulse.
    pub point: Vec3,
    /// Unit normal at the point, from the other entity to this one.
    pub normal: Vec3,
    /// Total normal impulse on this entity in this tick, N·s; zero if one of the two is a [`Sensor`](super::Sensor).
    pub impulse: f32,
    /// Whether one of the two is a sensor.
    pub sensor: bool,
}

/// A contact of an entity with [`ContactEvents::Every`] in this tick, new contacts included.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::ContactImpulse;
/// /// The largest impulse of this tick, N·s.
/// fn hardest(mut impulses: MessageReader<ContactImpulse>, mut most: Local<f32>) {
///     *most = impulses.read().map(|contact| contact.impulse).fold(0.0, f32::max);
/// }
/// ```
#[derive(Message, EntityEvent, Reflect, Clone, Copy, Debug, PartialEq)]
pub struct ContactImpulse {
    /// The entity with [`ContactEvents`].
    pub entity: Entity,
    /// The other entity: a body, a loose particle or a collider.
    pub other: Entity,
    /// The contact point, metres; of several points the one with the greatest impulse.
    pub point: Vec3,
    /// Unit normal at the point, from the other entity to this one.
    pub normal: Vec3,
    /// Total normal impulse on this entity in this tick, N·s; divided by the length of the tick, the mean force. Zero if one of the two is a
    /// [`Sensor`](super::Sensor), and for a sleeping body.
    pub impulse: f32,
    /// Whether one of the two is a sensor.
    pub sensor: bool,
}

/// A contact of an entity with [`ContactEvents`] that existed in the last tick and has ended. The other entity may have been despawned, and so may this one.
/// The contacts of a body also end when it is rebuilt in another size or gets another parent; those that still exist begin again.
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
    /// The entity with [`ContactEvents`].
    pub entity: Entity,
    /// The entity that it touched.
    pub other: Entity,
}

/// Hook: ends the contacts of an entity that loses one of the components.
fn end_all(world: DeferredWorld, context: HookContext) {
    end_contacts(world, context.entity);
}

/// Ends all contacts of an entity with [`ContactEvents`].
pub(crate) fn end_contacts(mut world: DeferredWorld, entity: Entity) {
    let Some(mut touching) = world.get_mut::<Touching>(entity) else { return };
    for other in core::mem::take(&mut touching.0) {
        let event = ContactEnded { entity, other };
        world.write_message(event);
        world.trigger(event);
    }
}

/// The entities that lost their parent since the last tick. Part of the state.
#[derive(Resource, MapEntities, Reflect, Clone, Debug, Default)]
pub(crate) struct Orphans(#[entities] pub(crate) Vec<Entity>);
