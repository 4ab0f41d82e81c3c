//! The event of a body that has been built: from then on a game can attach to a particle, a bone or a vertex.

use bevy::prelude::*;

use crate::components::{BuiltBody, CreationOrder};

/// A body was built from its recipe, for the first time or again: a message, and an event that can be observed on the body or globally.
///
/// It is sent at the end of [`SinewSystems::Build`](crate::SinewSystems::Build), when all bodies of the tick have been built, in the order in which the bodies
/// were created. All of them have their particles, parts and constraints then, and [`BuiltBody`]. Entities that an observer spawns or attaches take part in the
/// same tick. Bodies are also built, and send the event, while the simulation is paused.
///
/// A body that a game restores together with its recipe and its particles is not built, and sends no event; neither does one that the game assembles from
/// particles itself.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sinew::prelude::*;
/// # use bevy_sinew::BodyParticles;
/// fn spawn(mut commands: Commands) {
///     commands.spawn(Rope::default()).observe(
///         |built: On<BodyBuilt>, ropes: Query<&BodyParticles>, mut commands: Commands| {
///             // The last particle of the rope carries a weight.
///             if let Some(end) = ropes.get(built.entity).ok().and_then(|all| all.iter().last()) {
///                 commands.entity(end).insert(Mass(2.0));
///             }
///         },
///     );
/// }
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, SinewPlugins)).add_systems(Startup, spawn);
/// # app.finish();
/// # (0..3).for_each(|_| { std::thread::sleep(core::time::Duration::from_millis(20)); app.update() });
/// # let world = app.world_mut();
/// # assert!(world.query::<&Mass>().iter(world).any(|mass| mass.0 == 2.0));
/// ```
#[derive(Message, EntityEvent, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyBuilt {
    /// The body.
    pub entity: Entity,
    /// Whether it had been built before: its particles, parts and constraints are new entities then.
    pub again: bool,
}

/// The bodies that were built in this tick, until their events are sent.
#[derive(Resource, Default)]
pub(crate) struct JustBuilt(pub(crate) Vec<Entity>);

/// Marks the bodies that were built in this tick, and sends their events.
pub(crate) fn send_built(world: &mut World) {
    let Some(mut built) = world.get_resource_mut::<JustBuilt>().filter(|built| !built.0.is_empty())
    else {
        return;
    };
    let mut built = core::mem::take(&mut built.0);
    built.sort_unstable_by_key(|&body| (world.get::<CreationOrder>(body).copied(), body));
    built.dedup();
    let mut events = Vec::with_capacity(built.len());
    for entity in built {
        let Ok(mut body) = world.get_entity_mut(entity) else { continue };
        let builds = body.get::<BuiltBody>().map_or(0, |known| known.builds).saturating_add(1);
        body.insert(BuiltBody { builds });
        events.push(BodyBuilt { entity, again: builds > 1 });
    }
    for event in events {
        // An observer of an earlier body may have despawned this one.
        if world.get_entity(event.entity).is_ok() {
            world.write_message(event);
            world.trigger(event);
            world.flush();
        }
    }
}
