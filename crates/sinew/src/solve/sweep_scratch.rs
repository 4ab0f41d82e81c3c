//! Scratch memory of a sweep over an island, in any order.

use glam::Vec4;

use super::chains::ChainScratch;
use super::constraint_ref::{ConstraintRef, Local};
use super::jacobi::Corrections;
use super::most_violated_first::Queue;
use crate::lanes::Columns;

/// What a thread needs to sweep an island, or to visit its constraints one by one. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct SweepScratch {
    pub(super) local: Local,
    pub(super) columns: Columns,
    /// Columns of a whole island.
    pub(super) island_columns: Columns,
    /// Positions of the pins of an island with tethers.
    pub(super) pins: Vec<Vec4>,
    pub(super) chains: ChainScratch,
    pub(super) constraint_refs: Vec<ConstraintRef>,
    pub(super) corrections: Corrections,
    pub(super) queue: Queue,
}
