//! Gauss–Seidel (the lectures' cascade): constraints are projected one after the other, colour by colour. The order is the same in every substep, because
//! alternating it pumps energy.

use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};

use super::constraint_ref::{SolveMode, project_constraint};
use super::multipliers::MultiplierSlice;
use super::plan::{ClusterBatch, ConstraintGroup, GroupKind, Plan};
use super::sweep_scratch::SweepScratch;
use super::wide::sweep_loose;
use crate::constraints::GradientAt;
use crate::lanes::Columns;
use crate::particles::Places;
use crate::threads::{ExecutionContext, Pool, TASKS, each};

/// Projects every constraint of some cluster batches once. Returns the largest error found, metres; for compliant ones the largest correction.
pub(super) fn sweep(
    places: &mut Places,
    plan: &Plan,
    cluster_batches: Range<usize>,
    multipliers: &mut MultiplierSlice,
    mode: SolveMode,
    scratch: &mut SweepScratch,
) -> f32 {
    let mut worst = 0.0_f32;
    for cluster_batch in plan.cluster_batches[cluster_batches].iter().filter(|it| mode.takes(it)) {
        worst =
            worst.max(sweep_cluster_batch(places, plan, cluster_batch, multipliers, mode, scratch));
    }
    worst
}

pub(super) fn sweep_cluster_batch(
    places: &mut Places,
    plan: &Plan,
    cluster_batch: &ClusterBatch,
    multipliers: &mut MultiplierSlice,
    mode: SolveMode,
    scratch: &mut SweepScratch,
) -> f32 {
    let groups = &plan.groups[cluster_batch.groups.clone()];
    let (Plan { rods, constraints, .. }, instructions) = (plan, mode.instructions);
    // Compliant distances in columns are undamped and do not read the start of the substep, which columns do not store.
    let current = cluster_batch.kind != GroupKind::Rods || mode.gradient_at == GradientAt::Current;
    if cluster_batch.columns && current {
        let (columns, rows) = (&mut scratch.columns, cluster_batch.rows.clone());
        let range = places.at(rows.start)..places.at(rows.end);
        columns.reset(rods.half());
        columns.transpose_in(0, &places.position[range.clone()], instructions);
        let worst = sweep_columns(columns, plan, cluster_batch, rows.start, multipliers, mode);
        columns.transpose_out(0, &mut places.position[range], instructions);
        return worst;
    }
    let mut worst = 0.0_f32;
    for group in groups {
        let range = group.range.clone();
        let found = match group.kind {
            GroupKind::Rods => {
                let (mut runs, blocks) = (group.runs.clone(), group.blocks.clone());
                if cluster_batch.columns {
                    let strided_batches = core::mem::replace(&mut runs, 0..0);
                    let found = rods.sweep_strided_from_start(
                        places,
                        strided_batches,
                        &cluster_batch.rows,
                        instructions,
                    );
                    worst = worst.max(found);
                }
                let how = (mode.gradient_at, mode.relaxation);
                rods.sweep(places, runs, blocks, how, instructions)
            }
            GroupKind::Distances | GroupKind::Constraints => {
                let lambdas = match group.kind {
                    GroupKind::Distances => multipliers.of_distances(range.clone()),
                    _ => multipliers.of_constraints(range.clone()),
                };
                if let Some(which) = &group.wide {
                    plan.constraint_batches.sweep(
                        places,
                        which,
                        lambdas,
                        mode.substep_context,
                        instructions,
                    )
                } else {
                    let (each, local) =
                        (constraints[range].iter().zip(lambdas), &mut scratch.local);
                    each.map(|(c, lambda)| project_constraint(places, c, mode, lambda, local))
                        .fold(0.0, f32::max)
                }
            }
        };
        worst = worst.max(found);
    }
    worst
}

/// The same for a cluster batch that is swept in columns; these begin with row `first`.
pub(super) fn sweep_columns(
    columns: &mut Columns,
    plan: &Plan,
    cluster_batch: &ClusterBatch,
    first: u32,
    multipliers: &mut MultiplierSlice,
    mode: SolveMode,
) -> f32 {
    let groups = &plan.groups[cluster_batch.groups.clone()];
    let (rows, instructions) = ((cluster_batch.rows.start, first), mode.instructions);
    if cluster_batch.kind == GroupKind::Rods {
        let each = groups.iter().map(ConstraintGroup::rods);
        return plan.rods.sweep_columns(columns, each, rows, mode.relaxation, instructions);
    }
    let (mut worst, how) = (0.0_f32, (mode.substep_context, instructions));
    for ConstraintGroup { range, runs, blocks, .. } in groups {
        let sums = multipliers.of_distances(range.clone());
        let kept = if mode.single_sweep { &mut [] } else { &mut *sums };
        let (found, count) = plan.rods.sweep_soft(columns, runs.clone(), rows, kept, how);
        worst = worst.max(found);
        if !blocks.is_empty() {
            let (loose, blocks, from) = (&plan.loose_distances, blocks.clone(), rows.0 - rows.1);
            let sums = &mut sums[count..];
            let found = sweep_loose(loose, columns, blocks, from, sums, how.0, instructions);
            worst = worst.max(found);
        }
    }
    worst
}

/// The same for one large island by several workers: stage by stage, and within a stage the clusters, which share no particle, in parallel.
pub(super) fn sweep_shared(
    mut places: Places,
    plan: &Plan,
    cluster_batches: Range<usize>,
    mut multipliers: MultiplierSlice,
    mode: SolveMode,
    execution: ExecutionContext,
    scratches: &Pool<impl AsMut<SweepScratch> + Default + Send>,
) -> f32 {
    // Errors are not negative, and the bits of such numbers have the same order as the numbers.
    let worst = AtomicU32::new(0);
    let mut number = cluster_batches.start;
    for stage in
        plan.cluster_batches[cluster_batches].chunk_by(|one, other| one.stage == other.stage)
    {
        let mut left = Some((places.reborrow(), multipliers.reborrow()));
        let tasks = stage.chunks(stage.len().div_ceil(TASKS)).filter_map(|some| {
            let begin = number;
            number += some.len();
            let (places, multipliers) = split_off(&mut left, plan, some)?;
            Some((places, multipliers, begin..number))
        });
        each(execution.workers, tasks, |(mut places, mut multipliers, cluster_batches)| {
            let found = scratches.with(|scratch| {
                let scratch = scratch.as_mut();
                sweep(&mut places, plan, cluster_batches, &mut multipliers, mode, scratch)
            });
            worst.fetch_max(found.to_bits(), Ordering::Relaxed);
        });
    }
    f32::from_bits(worst.into_inner())
}

/// Splits the rows and the multipliers of some cluster batches of one stage off what is left.
fn split_off<'a>(
    left: &mut Option<(Places<'a>, MultiplierSlice<'a>)>,
    plan: &Plan,
    cluster_batches: &[ClusterBatch],
) -> Option<(Places<'a>, MultiplierSlice<'a>)> {
    let (places, multipliers) = left.take()?;
    let (first, last) = (cluster_batches.first()?, cluster_batches.last()?);
    let (_, places) = places.split_at(first.rows.start);
    let (own, places) = places.split_at(last.rows.end);
    let end = &plan.groups[last.groups.end - 1];
    let (own_multipliers, multipliers) = match end.kind {
        GroupKind::Constraints => multipliers.split(None, Some(end.range.end)),
        _ => multipliers.split(Some(end.range.end), None),
    };
    *left = Some((places, multipliers));
    Some((own, own_multipliers))
}
