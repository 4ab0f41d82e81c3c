//! The cascade: constraints enforced one after the other, colour by colour (Gauss–Seidel). The order never changes from substep to substep, because
//! alternating it pumps energy.

use super::item::{Local, Manner, project_constraint, project_distance};
use super::plan::{Island, Kind, Plan};
use super::rods::Columns;
use crate::constraints::Direction;
use crate::lanes::Lanes;
use crate::particles::Places;

/// Projects every constraint of an island once and returns the largest error found, metres; of soft ones, how far they moved.
#[inline(always)]
pub(super) fn sweep<L: Lanes>(
    places: &mut Places,
    plan: &mut Plan,
    island: &Island,
    manner: Manner,
    local: &mut Local,
    columns: &mut Columns,
) -> f32 {
    let mut worst = 0.0_f32;
    let Plan { bundles, groups, rods, distances, lambdas, constraints, multipliers, .. } = plan;
    for bundle in &bundles[island.bundles.clone()] {
        let groups = &groups[bundle.groups.clone()];
        if bundle.columns && manner.direction == Direction::Nearest {
            let each = groups.iter().map(|group| (&group.runs, &group.blocks));
            let rows = bundle.rows.clone();
            worst = worst.max(rods.sweep_columns::<L>(places, each, rows, columns));
            continue;
        }
        for group in groups {
            let range = group.range.clone();
            let found = match group.kind {
                Kind::Rods => {
                    let (runs, blocks) = (group.runs.clone(), group.blocks.clone());
                    rods.sweep::<L>(places, runs, blocks, manner.direction)
                }
                Kind::Distances => {
                    let each = distances[range.clone()].iter().zip(&mut lambdas[range]);
                    each.map(|(d, lambda)| project_distance(places, d, manner.pace, lambda))
                        .fold(0.0, f32::max)
                }
                Kind::Constraints => {
                    let each = constraints[range.clone()].iter().zip(&mut multipliers[range]);
                    each.map(|(c, lambda)| project_constraint(places, c, manner, lambda, local))
                        .fold(0.0, f32::max)
                }
            };
            worst = worst.max(found);
        }
    }
    worst
}
