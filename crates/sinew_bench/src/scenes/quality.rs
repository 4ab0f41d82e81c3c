//! P14: stretch of a cloth at equal work. Every constraint is projected twenty times a frame, split into substeps and sweeps.

use super::cloth;
use crate::measure::{Effort, Ours, Race, TICKS, World};
use crate::naive::Naive;
use crate::row::{Row, Unit};

/// Particles along a side.
const SIDE: u32 = 40;

/// The ways to split twenty projections into substeps and sweeps.
const SPLITS: [[u32; 2]; 6] = [[20, 1], [10, 2], [5, 4], [4, 5], [2, 10], [1, 20]];

/// P14.
pub(super) fn run(effort: &Effort) -> Vec<Row> {
    let ticks = if effort.quick { TICKS / 10 } else { TICKS };
    let sheet = cloth::sheet(SIDE);
    let mean = |world: &mut dyn World| {
        (0..ticks).for_each(|_| world.tick());
        world.stretch().map_or(f64::INFINITY, |s| s.mean)
    };
    let mut splits = SPLITS.map(|[substeps, sweeps]| {
        let mean = mean(&mut Ours(cloth::world(&sheet, substeps, sweeps)));
        (mean, [substeps, sweeps])
    });
    splits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [substeps, sweeps] = splits[0].1;
    let world = cloth::world(&sheet, substeps, sweeps);
    let naive = Naive::of(&cloth::world(&sheet, 1, 20));
    let scene = format!(
        "{SIDE}×{SIDE} cloth, 20 projections a frame: {substeps}×{sweeps} against naive 1×20"
    );
    let row =
        Row::new("P14", scene, Unit::Percent).sized(world.distances().len(), substeps, sweeps);
    let row = Race::between(Ours(world), naive).run(effort, 1, row);
    let percent = |s: Option<crate::row::Stretch>| s.map(|s| 100.0 * s.mean);
    let all = splits.map(|(mean, [a, b])| format!("{a}×{b} {:.3} %", 100.0 * mean)).join(", ");
    let times = (row.naive.unwrap_or(0.0) / 1e6, row.ours.unwrap_or(0.0) / 1e6);
    let note = format!("ours: {all}; {:.2} ms a tick, naive {:.2}", times.1, times.0);
    let (ours, naive) = (percent(row.stretch), percent(row.naive_stretch));
    vec![Row { ours, naive, ..row }.noted(note)]
}
