//! What contacts remember goes from the parts to the solver before a tick, and back after it.

use bevy::prelude::*;

use crate::components::ContactCache;
use crate::world::SinewWorld;

/// Tells the solver what each part remembers.
pub(crate) fn gather_contact_cache(mut world: ResMut<SinewWorld>, memories: Query<&ContactCache>) {
    let SinewWorld { simulation, tables } = &mut *world;
    simulation.contact_cache.clear();
    for (number, &part) in tables.parts.iter().enumerate() {
        if let (Some(solid), Ok(own)) =
            (simulation.body_colliders().get(number), memories.get(part))
        {
            let id = solid.id;
            simulation.contact_cache.add(id, &own.0);
        }
    }
}

/// Keeps what each part is to remember.
pub(crate) fn keep_contact_cache(world: Res<SinewWorld>, mut memories: Query<&mut ContactCache>) {
    let SinewWorld { simulation, tables } = &*world;
    for (solid, &part) in simulation.body_colliders().iter().zip(&tables.parts) {
        let now = simulation.contact_cache.of(solid.id);
        let Ok(mut own) = memories.get_mut(part) else { continue };
        if own.0 != now {
            own.0.clear();
            own.0.extend_from_slice(now);
        }
    }
}
