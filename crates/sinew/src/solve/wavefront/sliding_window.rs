//! The sliding window: the particles of an island that are currently in columns, from the first one not settled yet to the last one begun.
//!
//! In a [wavefront](super) that is a small part of a large island, and stays in a core's L2 cache.

use core::ops::Range;

use crate::integrate::{MovingColumns, Predict};
use crate::lanes::InstructionSet;

/// Rows count from the first row of the island.
#[derive(Clone, Debug, Default)]
pub(super) struct SlidingWindow {
    pub(super) moving: MovingColumns,
    /// Range of rows. The first is a multiple of 32.
    pub(super) rows: Range<usize>,
    half: usize,
}

impl SlidingWindow {
    /// Number of rows that fit where odd rows begin at `half`.
    pub(super) fn capacity(half: usize) -> usize {
        2 * half - 64
    }

    /// Resets the window to begin with row 0.
    pub(super) fn begin(&mut self, half: usize) {
        (self.rows, self.half) = (0..0, half);
        for columns in self.moving.each() {
            columns.reset(half);
        }
    }

    /// Extends the window to row `end`; rows before `settled` may be dropped.
    pub(super) fn admit(&mut self, end: usize, settled: usize) {
        if end - self.rows.start > Self::capacity(self.half) {
            let first = settled / 32 * 32;
            debug_assert!(end - first <= Self::capacity(self.half), "a wave too long");
            let kept = first - self.rows.start..self.rows.end - self.rows.start;
            for columns in self.moving.each() {
                columns.keep(kept.clone());
            }
            self.rows.start = first;
        }
        self.rows.end = end;
        for columns in self.moving.each() {
            columns.blank(end - self.rows.start);
        }
    }

    /// Transposes rows into the columns.
    pub(super) fn transpose_in(
        &mut self,
        row: usize,
        packed: &Predict,
        instructions: InstructionSet,
    ) {
        let row = row - self.rows.start;
        let MovingColumns { position, velocity, rounding, .. } = &mut self.moving;
        position.transpose_in(row, packed.position, instructions);
        velocity.transpose_in(row, packed.velocity, instructions);
        rounding.transpose_in(row, packed.motion.rounding, instructions);
    }

    /// Transposes rows back.
    pub(super) fn transpose_out(
        &mut self,
        row: usize,
        packed: Predict,
        instructions: InstructionSet,
    ) {
        let row = row - self.rows.start;
        let MovingColumns { position, start, velocity, rounding } = &mut self.moving;
        position.transpose_out(row, packed.position, instructions);
        start.transpose_out(row, packed.start, instructions);
        velocity.transpose_out(row, packed.velocity, instructions);
        rounding.transpose_out(row, packed.motion.rounding, instructions);
    }

    /// The lanes of some rows, of which the first is a multiple of 32.
    pub(super) fn lanes(&self, rows: Range<usize>) -> [Range<usize>; 2] {
        let (first, end) = (rows.start - self.rows.start, rows.end - self.rows.start);
        let even = first / 2..end.div_ceil(2);
        [even.clone(), self.half + even.start..self.half + even.end]
    }
}
