//! What contacts remember goes from the parts to the solver before a tick, and back after it.

use bevy::prelude::*;

use crate::components::ContactMemory;
use crate::world::SinewWorld;

/// Tells the solver what each part remembers.
pub(crate) fn gather_memory(mut world: ResMut<SinewWorld>, memories: Query<&ContactMemory>) {
    let SinewWorld { simulation, tables } = &mut *world;
    simulation.memory.clear();
    for (number, &part) in tables.parts.iter().enumerate() {
        if let (Some(solid), Ok(own)) = (simulation.solids().get(number), memories.get(part)) {
            let id = solid.id;
            simulation.memory.add(id, &own.0);
        }
    }
}

/// Keeps what each part is to remember.
pub(crate) fn keep_memory(world: Res<SinewWorld>, mut memories: Query<&mut ContactMemory>) {
    let SinewWorld { simulation, tables } = &*world;
    for (solid, &part) in simulation.solids().iter().zip(&tables.parts) {
        let now = simulation.memory.of(solid.id);
        let Ok(mut own) = memories.get_mut(part) else { continue };
        if own.0 != now {
            own.0.clear();
            own.0.extend_from_slice(now);
        }
    }
}
