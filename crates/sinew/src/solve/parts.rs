//! What is tied to large cloth: ropes that it hangs on, a crate that hangs on it, a figure that wears it.
//!
//! Those parts are of few constraints, which are no good in columns. They are swept where particles lie as they are; of what they share with a cloth whose particles are
//! in [columns](super::column_sweep), the few that it is tied by, each reads the places from there, and writes them back. So a tie costs what it is, and not the
//! columns of all of the cloth, to the bits of one cluster batch after the other.
//!
//! They may ask for more sweeps than cloth does, a figure for ten times as many: where the cloth has one sweep they have several, until they hold; and so have the
//! [`tie_rods`](super::tie_rods) of the cloth.

use super::constraint_ref::SolveMode;
use super::gauss_seidel::sweep_cluster_batch;
use super::multipliers::MultiplierSlice;
use super::plan::{ClusterBatch, Plan};
use super::sweep_scratch::SweepScratch;
use super::tie_rods::TieRods;
use super::turned_places::TurnedPlaces;
use crate::islands::Island;

/// How the parts of an island are swept.
#[derive(Clone, Copy)]
pub(super) struct Parts<'a> {
    pub(super) plan: &'a Plan,
    pub(super) island: &'a Island,
    pub(super) mode: SolveMode,
}

impl Parts<'_> {
    /// Sweeps one once, which is not in the columns. Returns the largest error found, metres.
    pub(super) fn sweep(
        &self,
        part: &ClusterBatch,
        at: &mut TurnedPlaces,
        multipliers: &mut MultiplierSlice,
        scratch: &mut SweepScratch,
    ) -> f32 {
        let Self { plan, mode, .. } = *self;
        let shared = plan.shared_rows[part.shared_rows.clone()].iter().copied();
        at.turn_out(shared.clone());
        let found = sweep_cluster_batch(at.places, plan, part, multipliers, mode, scratch);
        at.turn_in(shared);
        found
    }

    /// Sweeps all of them, and the tie rods of the cloth, after a sweep of the cloth: as often as they ask for, until they hold.
    pub(super) fn sweep_again(
        &self,
        at: &mut TurnedPlaces,
        multipliers: &mut MultiplierSlice,
        scratch: &mut SweepScratch,
    ) {
        let Self { plan, island, mode } = *self;
        let tie_rods = plan.tethers.tie_rods_of(island);
        let of_tie_rods = tie_rods.map_or(0, TieRods::sweeps);
        let of_parts = island.sweeps_of_parts.saturating_sub(1) as usize;
        if mode.relaxed.is_some() || of_tie_rods.max(of_parts) == 0 {
            return;
        }
        let run = plan.run(island);
        let parts = plan.cluster_batches[island.cluster_batches.clone()].iter();
        let parts = parts.filter(|it| !it.is_within(&run));
        for sweep in 0..of_parts.max(of_tie_rods) {
            let mut found = 0.0_f32;
            for part in parts.clone().filter(|_| sweep < of_parts) {
                found = found.max(self.sweep(part, at, multipliers, scratch));
            }
            if let Some(tie_rods) = tie_rods.filter(|_| sweep < of_tie_rods) {
                found = found.max(tie_rods.project(at, sweep % 2 == 1));
            }
            if found <= island.settings.tolerance {
                break;
            }
        }
    }
}
