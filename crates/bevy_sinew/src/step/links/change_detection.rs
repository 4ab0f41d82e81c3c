//! Change detection: what was added, changed or removed among the components of one type since the last look.

use bevy::ecs::query::ArchetypeFilter;
use bevy::prelude::*;

use crate::changes::ChangeTicks;

/// More than these are not taken into account one by one.
const MOST: usize = 16;

/// Keeps an eye on all components of one type. No hook and no observer does, which are the game's; besides, a body comes and goes with tens of
/// thousands of them.
#[derive(Default)]
pub(crate) struct ChangeDetector {
    count: usize,
    /// What was added or changed.
    pub(super) added: Vec<Entity>,
    /// What is said to have gone. Bevy tells that for two frames, when a tick may be farther away, so that it may not be all.
    pub(super) gone: Vec<Entity>,
    /// By how many more there are.
    pub(super) grown: isize,
}

impl ChangeDetector {
    /// Looks at all there are; `gone` are those that Bevy knows to have gone.
    pub(super) fn detect<T: Component, F: ArchetypeFilter>(
        &mut self,
        all: &Query<(Entity, Ref<T>), F>,
        gone: impl Iterator<Item = Entity>,
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
        self.gone.extend(gone.filter(|&entity| !all.contains(entity)));
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
