//! Which rows a list of particles stands in, resolved once per layout: extraction looks up no entity in a warm tick.

use core::marker::PhantomData;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

/// Which row each particle has.
#[derive(Default)]
pub(crate) struct Layout {
    /// Counts the layouts, so that whoever resolved entities into rows knows when to do so again.
    pub(crate) number: u64,
    /// So many rows, from the first on, have the particles that they had in the layout before this one.
    pub(crate) same: usize,
    /// The row of each particle: for rebuilding what names particles; never read in a tick without changes.
    pub(crate) row_of: EntityHashMap<u32>,
}

impl Layout {
    /// How many rows, from the first on, have the particles that they had in the layout of a number, as far as that is known.
    pub(crate) fn same_since(&self, number: u64) -> usize {
        match self.number.wrapping_sub(number) {
            0 => usize::MAX,
            1 => self.same,
            _ => 0,
        }
    }
}

/// The rows of the particles that the component `T` of the same entity names, in its order. Scratch.
#[derive(Component)]
pub(crate) struct Rows<T: Send + Sync + 'static> {
    layout: u64,
    rows: Vec<u32>,
    /// The tick that was last drawn from these rows, for those that draw; counted from 1.
    pub(crate) drawn: u64,
    /// Whether all particles are there, and each once; `None` until somebody asked.
    plain: Option<bool>,
    /// Which of the solver's body colliders they are, if it was told of them.
    pub(crate) collider: Option<u32>,
    of: PhantomData<fn() -> T>,
}

/// Stands where a particle is gone.
pub(crate) const GONE: u32 = u32::MAX;

impl<T: Send + Sync + 'static> Default for Rows<T> {
    fn default() -> Self {
        Self { layout: 0, rows: Vec::new(), drawn: 0, plain: None, collider: None, of: PhantomData }
    }
}

impl<T: Send + Sync + 'static> Rows<T> {
    /// The rows, resolved afresh if `named` changed or one of the particles stands in another row. [`GONE`] for what is no particle (any more).
    pub(crate) fn resolve(
        &mut self,
        layout: &Layout,
        changed: bool,
        named: impl Iterator<Item = Entity>,
    ) -> &[u32] {
        let is_old = self.layout != layout.number;
        let same = layout.same_since(core::mem::replace(&mut self.layout, layout.number));
        if changed || is_old && self.rows.iter().any(|&row| row as usize >= same) {
            self.plain = None;
            self.rows.clear();
            self.rows.extend(named.map(|entity| *layout.row_of.get(&entity).unwrap_or(&GONE)));
        }
        &self.rows
    }

    /// The rows, if they were resolved in this layout; none otherwise.
    pub(crate) fn current(&self, layout: &Layout) -> &[u32] {
        if self.layout == layout.number { &self.rows } else { &[] }
    }

    /// The rows as they were last resolved.
    pub(crate) fn get(&self) -> &[u32] {
        &self.rows
    }

    /// Whether all particles are there, and each is named once; found out once per layout.
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
