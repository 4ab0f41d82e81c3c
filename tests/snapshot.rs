//! Saving and putting back the simulation: what several suites do with it.

use bevy::prelude::*;
use bevy_sinew::{CreationOrder, SinewSnapshot};

use crate::support::{hash, tick};

/// Despawns everything that is part of the simulation now.
pub(crate) fn clear(world: &mut World) {
    let all: Vec<Entity> =
        world.query_filtered::<Entity, With<CreationOrder>>().iter(world).collect();
    for entity in all {
        world.try_despawn(entity).ok();
    }
}

/// Hash after each of the next `count` ticks.
pub(crate) fn hashes(app: &mut App, count: u64) -> Vec<u64> {
    (0..count)
        .map(|_| {
            tick(app, 1);
            hash(app)
        })
        .collect()
}

/// What a sync test of a rollback plugin does: in each of so many ticks back by seven, forward again, compare.
pub(crate) fn roll_back_in_every_tick(app: &mut App, ticks: usize) {
    let mut ring: Vec<(SinewSnapshot, u64)> = Vec::new();
    // In the first tick there may be nothing to hash yet.
    tick(app, 1);
    for _ in 0..ticks {
        let saved = SinewSnapshot::capture(app.world());
        let now = saved.hash();
        ring.push((saved, now));
        tick(app, 1);
        if ring.len() > 8 {
            let back = ring.len() - 7;
            ring[back].0.restore(app.world_mut()).unwrap();
            for (_, expected) in &ring[back..] {
                assert_eq!(SinewSnapshot::capture(app.world()).hash(), *expected);
                tick(app, 1);
            }
        }
    }
}
