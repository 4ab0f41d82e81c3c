//! Particles that lie as they are, but for a run of rows that has been turned into columns: for what asks for single ones, wherever they are.

use core::ops::Range;

use glam::Vec4;

use crate::lanes::Columns;
use crate::particles::Places;

/// Positions of an island, of which those of a run of rows may be in columns.
pub(super) struct TurnedPlaces<'a, 'b> {
    pub(super) columns: Option<(&'a mut Columns, &'a Range<u32>)>,
    pub(super) places: &'a mut Places<'b>,
}

impl TurnedPlaces<'_, '_> {
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

    /// Has places have what columns have of some rows of the run.
    pub(super) fn turn_out(&mut self, rows: impl Iterator<Item = u32>) {
        if self.columns.is_some() {
            rows.for_each(|row| self.places.position[self.places.at(row)] = self.get(row));
        }
    }

    /// And the other way round.
    pub(super) fn turn_in(&mut self, rows: impl Iterator<Item = u32>) {
        if self.columns.is_some() {
            rows.for_each(|row| self.set(row, self.places.position[self.places.at(row)]));
        }
    }
}
