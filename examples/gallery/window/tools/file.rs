//! Everything saved and loaded: the whole state of the simulation, as text.

use std::fs;
use std::path::Path;

use bevy::prelude::*;
use bevy_sinew::{
    AttachmentOf, ConstraintOf, JointOf, MouseDrag, PartOf, ParticleOf, SinewSnapshot,
};
use sinew_panel::{Recording, Selection};
use sinew_scenes::InScene;

use super::{Tools, work};

/// Writes the file, and says how that went.
pub(super) fn save(world: &mut World) -> String {
    let path = world.resource::<Tools>().path.clone();
    let text = SinewSnapshot::capture(world).to_ron(world).map_err(|fault| fault.to_string());
    let saved = text.and_then(|text| {
        let size = text.len();
        fs::write(&path, text).map_err(|fault| fault.to_string()).map(|()| size)
    });
    match saved {
        Ok(size) => format!("Saved {} ({} kB).", told(&path), size.div_ceil(1000)),
        Err(fault) => format!("Not saved: {fault}."),
    }
}

/// Reads the file, and says how that went. Where that goes wrong nothing has changed.
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
    // What stands by itself goes with the scene; all else goes with what it is of.
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
    // None of what was held, selected or recorded is there any more.
    work::take_first(world);
    world.resource_mut::<MouseDrag>().grabbed = None;
    world.resource_mut::<Recording>().clear();
    world.resource_mut::<Selection>().clear();
    format!("Loaded {}.", told(&path))
}

/// The name of the file first: of a long line that is what is seen.
fn told(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy());
    let folder = path.parent().unwrap_or(Path::new("."));
    format!("{} in {}", name.unwrap_or_default(), folder.display())
}
