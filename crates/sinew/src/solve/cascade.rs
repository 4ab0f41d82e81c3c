//! The cascade: constraints enforced one after the other, colour by colour (Gauss–Seidel). The order never changes from substep to substep, because
//! alternating it pumps energy.

use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};

use super::island::Room;
use super::item::{Manner, project_constraint};
use super::plan::{Bundle, Group, Kind, Plan};
use super::sums::Sums;
use super::world::Machine;
use crate::constraints::Direction;
use crate::particles::Places;
use crate::threads::{Pool, TASKS, each};

/// Projects every constraint of some bundles once and returns the largest error found, metres; of soft ones, how far they moved.
pub(super) fn sweep(
    places: &mut Places,
    plan: &Plan,
    bundles: Range<usize>,
    sums: &mut Sums,
    manner: Manner,
    room: &mut Room,
) -> f32 {
    let mut worst = 0.0_f32;
    for bundle in &plan.bundles[bundles] {
        worst = worst.max(sweep_bundle(places, plan, bundle, sums, manner, room));
    }
    worst
}

fn sweep_bundle(
    places: &mut Places,
    plan: &Plan,
    bundle: &Bundle,
    sums: &mut Sums,
    manner: Manner,
    room: &mut Room,
) -> f32 {
    let groups = &plan.groups[bundle.groups.clone()];
    let (Plan { rods, constraints, .. }, instructions) = (plan, manner.instructions);
    if bundle.columns && manner.direction == Direction::Nearest {
        let (each, rows) = (groups.iter().map(Group::rods), bundle.rows.clone());
        return rods.sweep_columns(places, each, rows, &mut room.columns, instructions);
    }
    let mut worst = 0.0_f32;
    for group in groups {
        let range = group.range.clone();
        let found = match group.kind {
            Kind::Rods => {
                let (mut runs, blocks) = (group.runs.clone(), group.blocks.clone());
                if bundle.columns {
                    let strips = core::mem::replace(&mut runs, 0..0);
                    let found =
                        rods.sweep_strips_from_start(places, strips, &bundle.rows, instructions);
                    worst = worst.max(found);
                }
                rods.sweep(places, runs, blocks, manner.direction, instructions)
            }
            Kind::Distances | Kind::Constraints => {
                let multipliers = match group.kind {
                    Kind::Distances => sums.of_distances(range.clone()),
                    _ => sums.of_constraints(range.clone()),
                };
                if let Some(which) = &group.wide {
                    plan.laws.sweep(places, which, multipliers, manner.pace, instructions)
                } else {
                    let (each, local) =
                        (constraints[range].iter().zip(multipliers), &mut room.local);
                    each.map(|(c, lambda)| project_constraint(places, c, manner, lambda, local))
                        .fold(0.0, f32::max)
                }
            }
        };
        worst = worst.max(found);
    }
    worst
}

/// The same of one large island, by several workers: stage after stage, and in each stage clusters that share no particle side by side.
pub(super) fn sweep_shared(
    mut places: Places,
    plan: &Plan,
    bundles: Range<usize>,
    mut sums: Sums,
    manner: Manner,
    machine: Machine,
    rooms: &Pool<Room>,
) -> f32 {
    // Errors are not negative, and the bits of such numbers order as they do.
    let worst = AtomicU32::new(0);
    let mut number = bundles.start;
    for stage in plan.bundles[bundles].chunk_by(|one, other| one.stage == other.stage) {
        let mut left = Some((places.lend(), sums.lend()));
        let tasks = stage.chunks(stage.len().div_ceil(TASKS)).filter_map(|some| {
            let begin = number;
            number += some.len();
            let (places, sums) = take(&mut left, plan, some)?;
            Some((places, sums, begin..number))
        });
        each(machine.workers, tasks, |(mut places, mut sums, bundles)| {
            let found =
                rooms.with(|room| sweep(&mut places, plan, bundles, &mut sums, manner, room));
            worst.fetch_max(found.to_bits(), Ordering::Relaxed);
        });
    }
    f32::from_bits(worst.into_inner())
}

/// Takes the rows and the multipliers of some bundles of one stage from what is left.
fn take<'a>(
    left: &mut Option<(Places<'a>, Sums<'a>)>,
    plan: &Plan,
    bundles: &[Bundle],
) -> Option<(Places<'a>, Sums<'a>)> {
    let (places, sums) = left.take()?;
    let (first, last) = (bundles.first()?, bundles.last()?);
    let (_, places) = places.split_at(first.rows.start);
    let (own, places) = places.split_at(last.rows.end);
    let end = &plan.groups[last.groups.end - 1];
    let (own_sums, sums) = match end.kind {
        Kind::Constraints => sums.split(None, Some(end.range.end)),
        _ => sums.split(Some(end.range.end), None),
    };
    *left = Some((places, sums));
    Some((own, own_sums))
}
