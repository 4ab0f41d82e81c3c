//! Rollback netcode: the state is saved and loaded when `bevy_ggrs` requests it.
//!
//! One snapshot per frame holds the whole state, instead of a store for each type: bodies with thousands of entities need no marker on each, despawned entities
//! are restored with their relationships, and no type of the state can be forgotten.

use std::collections::VecDeque;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy_ggrs::{
    ChecksumFlag, ChecksumPart, ConfirmedFrameCount, LoadWorld, LoadWorldSystems,
    RollbackEntityMap, RollbackFrameCount, SaveWorld, SaveWorldSystems,
};

use super::SinewSnapshot;

/// Rolls the simulation back with [`bevy_ggrs`]: all types in [`StateTypes`](crate::StateTypes), including a game's registered constraints and whatever else it
/// [registers](crate::RegisterState). The hash of the state is part of the checksum of each frame, by which desyncs are detected.
///
/// The simulation runs in [`GgrsSchedule`](bevy_ggrs::GgrsSchedule). Entities of the simulation need no `Rollback` marker; a game may add it to have components
/// of its own rolled back by `bevy_ggrs`. Components that refer to entities are mapped by its `update_component_with_map_entities` if a body had to be spawned
/// again.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_ggrs::{GgrsConfig, GgrsPlugin, GgrsSchedule};
/// # use bevy_sinew::{SinewPlugin, SinewRollbackPlugin};
/// let mut app = App::new();
/// app.add_plugins((
///     MinimalPlugins,
///     GgrsPlugin::<GgrsConfig<u8>>::default(),
///     SinewPlugin::in_schedule(GgrsSchedule),
///     SinewRollbackPlugin,
/// ));
/// ```
pub struct SinewRollbackPlugin;

impl Plugin for SinewRollbackPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RollbackHistory>()
            .add_systems(SaveWorld, save.in_set(SaveWorldSystems::Checksum))
            .add_systems(LoadWorld, load.in_set(LoadWorldSystems::Data));
    }
}

/// The snapshots of the frames to which the game may still roll back.
#[derive(Resource, Default)]
pub struct RollbackHistory {
    /// The oldest frame first.
    frames: VecDeque<(i32, SinewSnapshot)>,
    /// The entity with the checksum.
    checksum_entity: Option<Entity>,
}

/// Maximum number of frames: more than any prediction window.
const MAX_FRAMES: usize = 256;

impl RollbackHistory {
    /// The state at the beginning of a frame, if it is still stored.
    pub fn at(&self, frame: i32) -> Option<&SinewSnapshot> {
        self.frames.iter().find(|(saved, _)| *saved == frame).map(|(_, snapshot)| snapshot)
    }

    /// Adds a frame. Later frames have been undone, and frames before the confirmed one are not needed any more.
    fn push(&mut self, frame: i32, confirmed: i32, snapshot: SinewSnapshot) {
        self.frames.retain(|&(saved, _)| saved < frame && saved >= confirmed);
        self.frames.push_back((frame, snapshot));
        if self.frames.len() > MAX_FRAMES {
            self.frames.pop_front();
        }
    }
}

fn save(world: &mut World) {
    let frame = world.get_resource::<RollbackFrameCount>().map_or(0, |frame| frame.0);
    let confirmed = world.get_resource::<ConfirmedFrameCount>().map_or(i32::MIN, |frame| frame.0);
    let snapshot = SinewSnapshot::capture(world);
    let sum = u128::from(snapshot.hash());
    let mut history = world.resource_mut::<RollbackHistory>();
    history.push(frame, confirmed, snapshot);
    let known = history.checksum_entity;
    if let Some(mut checksum_entity) =
        known.and_then(|checksum_entity| world.get_mut::<ChecksumPart>(checksum_entity))
    {
        checksum_entity.0 = sum;
        return;
    }
    let checksum_entity =
        world.spawn((ChecksumPart(sum), ChecksumFlag::<SinewSnapshot>::default())).id();
    world.resource_mut::<RollbackHistory>().checksum_entity = Some(checksum_entity);
}

fn load(world: &mut World) {
    let frame = world.get_resource::<RollbackFrameCount>().map_or(0, |frame| frame.0);
    let Some(snapshot) = world.resource::<RollbackHistory>().at(frame).cloned() else {
        error!("sinew: frame {frame} was not saved, so the simulation cannot be rolled back to it");
        return;
    };
    // An entity that `bevy_ggrs` has already spawned again is not spawned twice.
    let known = world.get_resource::<RollbackEntityMap>();
    let mut known: EntityHashMap<Entity> =
        known.into_iter().flat_map(RollbackEntityMap::iter).collect();
    let moved = match snapshot.restore_onto(world, &known) {
        Ok(map) => map.into_iter().filter(|(old, new)| old != new),
        Err(fault) => {
            error!("sinew: frame {frame} cannot be restored: {fault}");
            return;
        }
    };
    let moved: EntityHashMap<Entity> = moved.collect();
    if moved.is_empty() {
        return;
    }
    for (_, snapshot) in &mut world.resource_mut::<RollbackHistory>().frames {
        snapshot.rename(&moved);
    }
    known.extend(moved);
    world.insert_resource(RollbackEntityMap::from(known));
}
