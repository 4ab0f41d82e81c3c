//! Change detection: which components of one type were added, changed or removed since the last check.

use bevy::ecs::lifecycle::RemovedComponentEntity;
use bevy::ecs::message::MessageCursor;
use bevy::ecs::query::ArchetypeFilter;
use bevy::prelude::*;

use crate::changes::ChangeTicks;

/// Maximum number of changes that are handled one by one.
const MAX_INCREMENTAL: usize = 16;

/// Maximum number of removals that are recorded until the next check: a game may be paused, and continue for any time.
const MAX_RECORDED: usize = 1 << 16;

/// Detects changes of all components of one type. Not by hooks, which a game may need for itself, nor by observers, since a body is spawned and despawned with
/// tens of thousands of components.
#[derive(Default)]
pub(crate) struct ChangeDetector {
    count: usize,
    /// Entities whose component was added or changed.
    pub(super) added: Vec<Entity>,
    /// Entities whose component was removed, as far as recorded.
    pub(super) gone: Vec<Entity>,
    /// Removals recorded since the last check, and the position up to which Bevy's messages were read.
    recorded: Vec<Entity>,
    cursor: MessageCursor<RemovedComponentEntity>,
    /// Increase of the count.
    pub(super) grown: isize,
}

impl ChangeDetector {
    /// Records removals. Bevy keeps them for two frames, while the next tick may be later.
    pub(super) fn note_gone(&mut self, removed: Option<&Messages<RemovedComponentEntity>>) {
        let gone = removed.map(|removed| self.cursor.read(removed)).into_iter().flatten();
        let room = MAX_RECORDED.saturating_sub(self.recorded.len());
        self.recorded.extend(gone.cloned().map(Entity::from).take(room));
    }

    /// Compares all components, and the recorded removals, with the last check.
    pub(super) fn detect<T: Component, F: ArchetypeFilter>(
        &mut self,
        all: &Query<(Entity, Ref<T>), F>,
    ) {
        self.added.clear();
        self.gone.clear();
        let (mut count, added) = (0, &mut self.added);
        match all.contiguous_iter() {
            Ok(tables) => tables.for_each(|(entities, column)| {
                let change_ticks = ChangeTicks::of(&column);
                count += entities.len();
                if change_ticks.any_changed() {
                    added.extend(change_ticks.changed().map(|place| entities[place]));
                }
            }),
            // A component with sparse-set storage has no column.
            Err(_) => all.iter().for_each(|(entity, component)| {
                count += 1;
                if component.is_changed() {
                    added.push(entity);
                }
            }),
        }
        self.gone.extend(self.recorded.drain(..).filter(|&entity| !all.contains(entity)));
        self.grown = count as isize - self.count as isize;
        self.count = count;
    }

    /// Whether anything changed.
    pub(super) fn is_any(&self) -> bool {
        self.grown != 0 || !self.added.is_empty()
    }

    /// The number of components.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Whether the changes are few enough to be handled one by one.
    pub(super) fn is_few(&self) -> bool {
        self.added.len().max(self.gone.len()) <= MAX_INCREMENTAL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Component)]
    struct Rod;

    #[test]
    fn what_goes_between_two_looks_is_known_however_many_frames_lie_between_them() {
        let mut world = World::new();
        let id = world.register_component::<Rod>();
        let rods: Vec<Entity> = (0..4).map(|_| world.spawn(Rod).id()).collect();
        let mut detector = ChangeDetector::default();
        let look = |world: &mut World, detector: &mut ChangeDetector| {
            let mut all = world.query::<(Entity, Ref<Rod>)>();
            detector.note_gone(world.removed_components().get(id));
            detector.detect(&all.query(world));
        };
        look(&mut world, &mut detector);
        assert_eq!((detector.grown, detector.gone.len()), (4, 0));
        world.despawn(rods[1]);
        world.entity_mut(rods[2]).remove::<Rod>().insert(Rod);
        for _ in 0..5 {
            detector.note_gone(world.removed_components().get(id));
            world.clear_trackers();
        }
        look(&mut world, &mut detector);
        assert_eq!((detector.grown, &detector.gone), (-1, &vec![rods[1]]));
        look(&mut world, &mut detector);
        assert_eq!((detector.grown, detector.gone.len()), (0, 0));
    }
}
