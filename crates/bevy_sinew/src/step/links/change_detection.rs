//! Change detection: what was added, changed or removed among the components of one type since the last look.

use bevy::ecs::lifecycle::RemovedComponentEntity;
use bevy::ecs::message::MessageCursor;
use bevy::ecs::query::ArchetypeFilter;
use bevy::prelude::*;

use crate::changes::ChangeTicks;

/// More than these are not taken into account one by one.
const MOST: usize = 16;

/// How many are noted to have gone until the next look, at most: a game may be paused, and go on without end.
const NOTED: usize = 1 << 16;

/// Keeps an eye on all components of one type. No hook and no observer does, which are the game's; besides, a body comes and goes with tens of
/// thousands of them.
#[derive(Default)]
pub(crate) struct ChangeDetector {
    count: usize,
    /// What was added or changed.
    pub(super) added: Vec<Entity>,
    /// What is said to have gone. It may not be all.
    pub(super) gone: Vec<Entity>,
    /// What has gone since the last look, as far as it was noted, and up to where Bevy's messages were read.
    noted: Vec<Entity>,
    cursor: MessageCursor<RemovedComponentEntity>,
    /// By how many more there are.
    pub(super) grown: isize,
}

impl ChangeDetector {
    /// Notes what has gone. Bevy tells that for two frames, when a tick may be farther away.
    pub(super) fn note_gone(&mut self, removed: Option<&Messages<RemovedComponentEntity>>) {
        let gone = removed.map(|removed| self.cursor.read(removed)).into_iter().flatten();
        let room = NOTED.saturating_sub(self.noted.len());
        self.noted.extend(gone.cloned().map(Entity::from).take(room));
    }

    /// Looks at all there are, and at what was noted.
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
            // A component that is kept in a sparse set has no column.
            Err(_) => all.iter().for_each(|(entity, component)| {
                count += 1;
                if component.is_changed() {
                    added.push(entity);
                }
            }),
        }
        self.gone.extend(self.noted.drain(..).filter(|&entity| !all.contains(entity)));
        self.grown = count as isize - self.count as isize;
        self.count = count;
    }

    /// Whether there is any.
    pub(super) fn is_any(&self) -> bool {
        self.grown != 0 || !self.added.is_empty()
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Whether it is worth taking each into account by itself.
    pub(super) fn is_few(&self) -> bool {
        self.added.len().max(self.gone.len()) <= MOST
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
