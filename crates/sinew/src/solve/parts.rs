//! Parts: what is tied to large cloth, such as ropes that it hangs on, a crate that hangs on it, or a ragdoll that wears it.
//!
//! Parts have too few constraints to be worth columns, so they are swept in memory. If the particles of the cloth are in [columns](super::column_sweep), only
//! the few that are shared with a part are copied out before and back afterwards. So a tie costs in proportion to its own size rather than to that of the
//! cloth, and gives the same bits as one cluster batch after the other.
//!
//! Parts may need more sweeps than cloth, a ragdoll ten times as many. For each sweep of the cloth they are swept several times, until they converge, and so
//! are the [`tie_rods`](super::tie_rods) of the cloth.

use super::constraint_ref::SolveMode;
use super::gauss_seidel::sweep_cluster_batch;
use super::mixed_places::MixedPlaces;
use super::multipliers::MultiplierSlice;
use super::plan::{ClusterBatch, Plan};
use super::sweep_scratch::SweepScratch;
use super::tie_rods::TieRods;
use crate::islands::Island;

/// Sweeps the parts of an island.
#[derive(Clone, Copy)]
pub(super) struct Parts<'a> {
    pub(super) plan: &'a Plan,
    pub(super) island: &'a Island,
    pub(super) mode: SolveMode,
}

impl Parts<'_> {
    /// Sweeps a part, which is not in the columns, once. Returns the largest error found, metres.
    pub(super) fn sweep(
        &self,
        part: &ClusterBatch,
        at: &mut MixedPlaces,
        multipliers: &mut MultiplierSlice,
        scratch: &mut SweepScratch,
    ) -> f32 {
        let Self { plan, mode, .. } = *self;
        let shared = plan.shared_rows[part.shared_rows.clone()].iter().copied();
        at.copy_out(shared.clone());
        let found = sweep_cluster_batch(at.places, plan, part, multipliers, mode, scratch);
        at.copy_in(shared);
        found
    }

    /// Sweeps all parts and the tie rods of the cloth again after a sweep of the cloth, until they converge or have used up their additional sweeps.
    pub(super) fn sweep_again(
        &self,
        at: &mut MixedPlaces,
        multipliers: &mut MultiplierSlice,
        scratch: &mut SweepScratch,
    ) {
        let Self { plan, island, mode } = *self;
        let tie_rods = plan.tethers.tie_rods_of(island);
        let of_tie_rods = tie_rods.map_or(0, TieRods::sweeps);
        let of_parts = island.tie_sweeps.saturating_sub(1) as usize;
        if mode.relaxation.is_some() || of_tie_rods.max(of_parts) == 0 {
            return;
        }
        let run = plan.contiguous_rows(island);
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
