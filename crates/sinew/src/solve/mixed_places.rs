//! Access to single particles of an island, whether they are in memory or in columns.

use core::ops::Range;

use glam::Vec4;

use crate::lanes::Columns;
use crate::particles::Places;

/// Positions of an island, of which a run of rows may be in columns.
pub(super) struct MixedPlaces<'a, 'b> {
    pub(super) columns: Option<(&'a mut Columns, &'a Range<u32>)>,
    pub(super) places: &'a mut Places<'b>,
}

impl MixedPlaces<'_, '_> {
    pub(super) fn get(&self, row: u32) -> Vec4 {
        match &self.columns {
            Some((columns, run)) if run.contains(&row) => columns.get(columns.at(row - run.start)),
            _ => self.places.position[self.places.at(row)],
        }
    }

    pub(super) fn set(&mut self, row: u32, place: Vec4) {
        match &mut self.columns {
            Some((columns, run)) if run.contains(&row) => {
                columns.set(columns.at(row - run.start), place);
            }
            _ => self.places.position[self.places.at(row)] = place,
        }
    }

    /// Copies some rows of the run from the columns to memory.
    pub(super) fn copy_out(&mut self, rows: impl Iterator<Item = u32>) {
        if self.columns.is_some() {
            rows.for_each(|row| self.places.position[self.places.at(row)] = self.get(row));
        }
    }

    /// Copies them back.
    pub(super) fn copy_in(&mut self, rows: impl Iterator<Item = u32>) {
        if self.columns.is_some() {
            rows.for_each(|row| self.set(row, self.places.position[self.places.at(row)]));
        }
    }
}
