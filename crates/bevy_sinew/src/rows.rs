//! The mapping from particle entities to rows, resolved once per layout, so that a warm tick looks up no entity during extraction.

use core::marker::PhantomData;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

/// The row of each particle.
#[derive(Default)]
pub(crate) struct Layout {
    /// A counter of layouts, by which cached rows are recognised as outdated.
    pub(crate) number: u64,
    /// The number of leading rows whose particles are the same as in the previous layout.
    pub(crate) same: usize,
    /// The row of each particle: for resolving entities; not read in a tick without changes.
    pub(crate) row_of: EntityHashMap<u32>,
}

impl Layout {
    /// The number of leading rows whose particles are the same as in the layout `number`, as far as that is known.
    pub(crate) fn same_since(&self, number: u64) -> usize {
        match self.number.wrapping_sub(number) {
            0 => usize::MAX,
            1 => self.same,
            _ => 0,
        }
    }
}

/// The rows of the particles that the component `T` of the same entity lists, in its order. Scratch.
#[derive(Component)]
pub(crate) struct ResolvedRows<T: Send + Sync + 'static> {
    layout: u64,
    rows: Vec<u32>,
    /// The last tick that was drawn from these rows, for components that draw; counted from 1.
    pub(crate) drawn: u64,
    /// Whether all particles exist, and each is listed once; `None` if that has not been computed.
    plain: Option<bool>,
    /// The index of the solver's body collider of these rows, if there is one.
    pub(crate) collider: Option<u32>,
    of: PhantomData<fn() -> T>,
}

/// The row of a particle that is gone.
pub(crate) const GONE: u32 = u32::MAX;

impl<T: Send + Sync + 'static> Default for ResolvedRows<T> {
    fn default() -> Self {
        Self { layout: 0, rows: Vec::new(), drawn: 0, plain: None, collider: None, of: PhantomData }
    }
}

impl<T: Send + Sync + 'static> ResolvedRows<T> {
    /// The rows, resolved again if the list of entities `changed` or one of its particles has another row. [`GONE`] for an entity that is not a particle (any
    /// more).
    pub(crate) fn resolve(
        &mut self,
        layout: &Layout,
        changed: bool,
        named: impl Iterator<Item = Entity>,
    ) -> &[u32] {
        // The list may have come before what it is resolved for, as the mesh of a body that was loaded from a file.
        let is_first = self.layout == 0;
        let is_old = self.layout != layout.number;
        let same = layout.same_since(core::mem::replace(&mut self.layout, layout.number));
        if changed || is_first || is_old && self.rows.iter().any(|&row| row as usize >= same) {
            self.plain = None;
            self.rows.clear();
            self.rows.extend(named.map(|entity| *layout.row_of.get(&entity).unwrap_or(&GONE)));
        }
        &self.rows
    }

    /// The rows, if they were resolved in this layout; empty otherwise.
    pub(crate) fn current(&self, layout: &Layout) -> &[u32] {
        if self.layout == layout.number { &self.rows } else { &[] }
    }

    /// The rows as they were last resolved.
    pub(crate) fn get(&self) -> &[u32] {
        &self.rows
    }

    /// Whether all particles exist, and each is listed once; computed once per layout.
    pub(crate) fn are_plain(&mut self) -> bool {
        let rows = &self.rows;
        *self.plain.get_or_insert_with(|| {
            let mut sorted = rows.clone();
            sorted.sort_unstable();
            let once = sorted.windows(2).all(|pair| pair[0] < pair[1]);
            once && sorted.last() != Some(&GONE)
        })
    }
}
