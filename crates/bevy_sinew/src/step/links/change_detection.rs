//! Change detection: what was added, changed or removed among the components of one type since the last look; one by one, as long as they are few.

use bevy::ecs::query::ArchetypeFilter;
use bevy::prelude::*;

use crate::changes::ChangeTicks;

/// Of more than these it is as well to compile everything.
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
    many: bool,
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
        let (mut count, mut many) = (0, false);
        let mut note = |entity| match self.added.len() {
            MOST => many = true,
            _ => self.added.push(entity),
        };
        match all.contiguous_iter() {
            Ok(tables) => tables.for_each(|(entities, column)| {
                let change_ticks = ChangeTicks::of(&column);
                count += entities.len();
                if change_ticks.any_changed() {
                    change_ticks.changed().for_each(|place| note(entities[place]));
                }
            }),
            // A component that is kept in a sparse set has no column.
            Err(_) => all.iter().for_each(|(entity, component)| {
                count += 1;
                if component.is_changed() {
                    note(entity);
                }
            }),
        }
        for entity in gone.filter(|&entity| !all.contains(entity)) {
            match self.gone.len() {
                MOST => many = true,
                _ => self.gone.push(entity),
            }
        }
        self.many = many;
        self.grown = count as isize - self.count as isize;
        self.count = count;
    }

    /// Whether there is any.
    pub(super) fn is_any(&self) -> bool {
        self.many || self.grown != 0 || !self.added.is_empty()
    }

    /// Whether each can be named.
    pub(super) fn is_few(&self) -> bool {
        !self.many
    }
}
