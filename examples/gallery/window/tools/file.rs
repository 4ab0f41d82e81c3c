//! Saving and loading the whole state of the simulation, as text.

use std::fs;
use std::path::Path;

use bevy::prelude::*;
use bevy_sinew::{
    AttachmentOf, ConstraintOf, JointOf, MouseDrag, PartOf, ParticleOf, SinewSnapshot,
};
use sinew_panel::{Recording, Selection};
use sinew_scenes::InScene;

use super::{Tools, work};

/// Writes the file; returns a message about the result.
pub(super) fn save(world: &mut World) -> String {
    let path = world.resource::<Tools>().path.clone();
    let text = SinewSnapshot::capture(world).to_ron(world).map_err(|fault| fault.to_string());
    let saved = text.and_then(|text| {
        let size = text.len();
        fs::write(&path, text).map_err(|fault| fault.to_string()).map(|()| size)
    });
    match saved {
        Ok(size) => format!("Saved {} ({} kB).", display_path(&path), size.div_ceil(1000)),
        Err(fault) => format!("Not saved: {fault}."),
    }
}

/// Reads the file; returns a message about the result. On an error the world is unchanged.
pub(super) fn load(world: &mut World) -> String {
    let path = world.resource::<Tools>().path.clone();
    let text = fs::read_to_string(&path).map_err(|fault| fault.to_string());
    let read = text
        .and_then(|text| SinewSnapshot::from_ron(&text, world).map_err(|fault| fault.to_string()));
    let entities = read.and_then(|saved| saved.restore(world).map_err(|fault| fault.to_string()));
    let entities: Vec<Entity> = match entities {
        Ok(entities) => entities.values().copied().collect(),
        Err(fault) => return format!("Not loaded, nothing has changed: {fault}."),
    };
    // Root entities are despawned with the scene; all others are despawned with their owner.
    for entity in entities {
        let Ok(mut entity) = world.get_entity_mut(entity) else { continue };
        let is_of_another = entity.contains::<ParticleOf>()
            || entity.contains::<ConstraintOf>()
            || entity.contains::<PartOf>()
            || entity.contains::<AttachmentOf>()
            || entity.contains::<JointOf>();
        if !is_of_another {
            entity.insert(InScene);
        }
    }
    // The entities that were grabbed, selected or recorded no longer exist.
    work::take_first(world);
    world.resource_mut::<MouseDrag>().grabbed = None;
    world.resource_mut::<Recording>().clear();
    world.resource_mut::<Selection>().clear();
    format!("Loaded {}.", display_path(&path))
}

/// The file name first, because a long line is truncated.
fn display_path(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy());
    let folder = path.parent().unwrap_or(Path::new("."));
    format!("{} in {}", name.unwrap_or_default(), folder.display())
}
