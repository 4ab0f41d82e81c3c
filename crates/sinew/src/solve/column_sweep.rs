//! A sweep over large cloth with its particles in columns (`SoA`) from beginning to end: a run of its rows, and the [parts](super::parts) that are tied to them.

use core::ops::Range;

use glam::Vec4;

use super::constraint_ref::SolveMode;
use super::gauss_seidel::sweep_columns;
use super::mixed_places::MixedPlaces;
use super::multipliers::MultiplierSlice;
use super::parts::Parts;
use super::plan::Plan;
use super::sweep_scratch::SweepScratch;
use super::tethers::IslandTethers;
use crate::islands::Island;
use crate::particles::Places;

/// Sweeps an island with a run of its rows in columns.
pub(super) struct ColumnSweep<'a> {
    plan: &'a Plan,
    island: &'a Island,
    run: &'a Range<u32>,
    mode: SolveMode,
}

impl<'a> ColumnSweep<'a> {
    pub(super) fn of(
        plan: &'a Plan,
        island: &'a Island,
        run: &'a Range<u32>,
        mode: SolveMode,
    ) -> Self {
        Self { plan, island, run, mode }
    }

    /// Projects tethers and chains, and sweeps the island once. Returns the largest error found, metres.
    pub(super) fn sweep(
        &self,
        places: &mut Places,
        multipliers: &mut MultiplierSlice,
        scratch: &mut SweepScratch,
    ) -> f32 {
        let Self { plan, island, run, mode } = *self;
        let mut columns = core::mem::take(&mut scratch.island_columns);
        let (rows, instructions) = (places.at(run.start)..places.at(run.end), mode.instructions);
        columns.reset(plan.rods.half());
        columns.transpose_in(0, &places.position[rows.clone()], instructions);
        // The last block of eight tethers also reads lanes beyond the rows, which still hold the island that was in these columns before.
        columns.blank(rows.len());
        let tethers = plan.tethers.of(island).filter(|_| mode.project_tethers);
        if let Some(tethers) = tethers {
            // Pins do not move during a sweep.
            scratch.pins.clear();
            scratch.pins.extend(tethers.pins(places.position, places.first));
        }
        let at = &mut MixedPlaces { columns: Some((&mut columns, run)), places };
        let mut worst = self.project_tethers(tethers, at, &scratch.pins);
        if island.has_chains() && mode.relaxation.is_none() {
            worst = worst.max(self.sweep_chains(at, scratch));
        }
        let parts = Parts { plan, island, mode };
        let cluster_batches = plan.cluster_batches[island.cluster_batches.clone()].iter();
        for cluster_batch in cluster_batches.filter(|it| mode.takes(it)) {
            let found = match &mut at.columns {
                Some((columns, _)) if cluster_batch.is_within(run) => {
                    sweep_columns(columns, plan, cluster_batch, run.start, multipliers, mode)
                }
                _ => parts.sweep(cluster_batch, at, multipliers, scratch),
            };
            worst = worst.max(found);
        }
        parts.sweep_again(at, multipliers, scratch);
        if let Some(spans) = plan.tethers.spans_of(island).filter(|_| mode.project_tethers) {
            self.project_tethers(tethers, at, &scratch.pins);
            spans.project_columns(&mut columns, run.start, instructions);
        }
        columns.transpose_out(0, &mut places.position[rows], instructions);
        scratch.island_columns = columns;
        worst
    }

    /// Projects all particles into the range of their tethers. Returns how far outside the farthest was, metres.
    fn project_tethers(
        &self,
        tethers: Option<&IslandTethers>,
        at: &mut MixedPlaces,
        pins: &[Vec4],
    ) -> f32 {
        let (Some(tethers), Some((columns, _))) = (tethers, &mut at.columns) else { return 0.0 };
        let (island, instructions) = (self.island, self.mode.instructions);
        let (position, first) = (&mut *at.places.position, at.places.first);
        let own = island.contiguous.start - island.members.start
            ..island.contiguous.end - island.members.start;
        let others = tethers.project_others(position, first, &own, pins, instructions);
        others.max(tethers.project_columns(columns, own.start, &own, pins, instructions))
    }

    /// Solves ropes that are chains directly.
    fn sweep_chains(&self, at: &mut MixedPlaces, scratch: &mut SweepScratch) -> f32 {
        let Self { plan, island, run, mode } = *self;
        let links = || island.chains.clone().flat_map(|chain| plan.chains.links(chain));
        let shared = || links().flat_map(|link| link.rows).filter(|row| run.contains(row));
        at.copy_out(shared());
        let all = (&mut *at.places.position, at.places.first);
        let found = plan.chains.project(island, all, &mut scratch.chains, mode.instructions);
        at.copy_in(shared());
        mode.of_chains(found)
    }
}
