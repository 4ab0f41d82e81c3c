//! The frame rate does not matter: the same tick has the same bits at 24, 30, 60, 144 and 240 frames a second, with jitter, and after a stall.

use core::time::Duration;
use std::collections::BTreeMap;

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_sinew::SinewClock;
use bevy_sinew::prelude::*;

use crate::support::{app, busy_scene, hash};

/// The hash after each tick, recorded within the fixed schedule itself.
#[derive(Resource, Default)]
struct Hashes(BTreeMap<u64, u64>);

fn record(world: &mut World) {
    let tick = world.resource::<SinewClock>().tick;
    let mut all: Vec<_> = world
        .query::<(&bevy_sinew::CreationOrder, &Particle)>()
        .iter(world)
        .map(|(order, particle)| (*order, *particle))
        .collect();
    all.sort_by_key(|(order, _)| *order);
    let hash =
        crate::support::fnv(all.iter().flat_map(|(_, particle)| crate::support::bits(particle)));
    world.resource_mut::<Hashes>().0.insert(tick, hash);
}

/// Runs 240 ticks in frames of the given lengths, in seconds.
fn run(mut frame: impl FnMut(u64) -> f64) -> BTreeMap<u64, u64> {
    let mut app = app();
    app.init_resource::<Hashes>().add_systems(FixedLast, record);
    busy_scene(&mut app);
    for number in 0.. {
        let length = Duration::from_secs_f64(frame(number));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(length));
        app.update();
        if app.world().resource::<SinewClock>().tick >= 240 {
            break;
        }
    }
    assert_ne!(hash(&mut app), 0);
    let mut hashes = core::mem::take(&mut app.world_mut().resource_mut::<Hashes>().0);
    hashes.retain(|tick, _| *tick <= 240);
    assert_eq!(hashes.len(), 240, "every tick was recorded");
    hashes
}

/// Pseudo-random numbers between 0 and 1.
fn noise(i: u64) -> f64 {
    let mixed = (i ^ 0x9e37).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f64 / (1 << 24) as f64
}

#[test]
fn every_tick_has_the_same_bits_at_every_frame_rate() {
    let reference = run(|_| 1.0 / 60.0);
    for rate in [24.0, 30.0, 144.0, 240.0] {
        assert!(run(|_| 1.0 / rate) == reference, "{rate} frames a second");
    }
}

#[test]
fn jitter_and_a_stall_of_ten_seconds_change_nothing() {
    let reference = run(|_| 1.0 / 60.0);
    for rate in [24.0, 60.0, 144.0] {
        let jittered = run(|i| (0.2 + 1.6 * noise(i)) / rate);
        assert!(jittered == reference, "{rate} frames a second with jitter");
    }
    let stalled = run(|i| if i == 40 { 10.0 } else { 1.0 / 60.0 });
    assert!(stalled == reference, "a stall");
}
