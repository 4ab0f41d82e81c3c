//! News: what came, changed or went among the components of one type since it was last looked at; one by one, as long as they are few.

use bevy::ecs::query::ArchetypeFilter;
use bevy::prelude::*;

use crate::step::changes::Ages;

/// Of more than these it is as well to compile everything.
const MOST: usize = 16;

/// Keeps an eye on all components of one type. No hook and no observer does, which are the game's; besides, a body comes and goes with tens of
/// thousands of them.
#[derive(Default)]
pub(crate) struct Watch {
    count: usize,
    /// What came or changed.
    pub(super) came: Vec<Entity>,
    /// What is said to have gone. Bevy tells that for two frames, when a tick may be farther away, so that it may not be all.
    pub(super) gone: Vec<Entity>,
    /// By how many more there are.
    pub(super) grown: isize,
    many: bool,
}

impl Watch {
    /// Looks at all there are; `gone` are those that Bevy knows to have gone.
    pub(super) fn look<T: Component, F: ArchetypeFilter>(
        &mut self,
        all: &Query<(Entity, Ref<T>), F>,
        gone: impl Iterator<Item = Entity>,
    ) {
        self.came.clear();
        self.gone.clear();
        let (mut count, mut many) = (0, false);
        let mut note = |entity| match self.came.len() {
            MOST => many = true,
            _ => self.came.push(entity),
        };
        match all.contiguous_iter() {
            Ok(tables) => tables.for_each(|(entities, column)| {
                let ages = Ages::of(&column);
                count += entities.len();
                if ages.any_changed() {
                    ages.changed().for_each(|place| note(entities[place]));
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
        self.many || self.grown != 0 || !self.came.is_empty()
    }

    /// Whether each can be named.
    pub(super) fn is_few(&self) -> bool {
        !self.many
    }
}
