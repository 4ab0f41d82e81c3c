//! Helpers of several suites for saving and restoring the simulation.

use bevy::prelude::*;
use bevy_sinew::{CreationOrder, SinewSnapshot};

use crate::support::{hash, tick};

/// Despawns everything that is part of the simulation.
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

/// Like a sync test of a rollback plugin: in each of `ticks` ticks it goes back by seven, simulates them again and compares the hashes.
pub(crate) fn roll_back_in_every_tick(app: &mut App, ticks: usize) {
    let mut ring: Vec<(SinewSnapshot, u64)> = Vec::new();
    // Before the first tick there may be nothing to hash.
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
