//! P3: one long rope, and many short ones.

use sinew::glam::Vec3;
use sinew::recipes::{RopeSpec, rope};
use sinew::{Simulation, SolverSettings};

use super::{cloth, empty};
use crate::measure::{Effort, Ours, Race};
use crate::naive::Naive;
use crate::peers;
use crate::row::{Row, Unit};

/// Segments of the long rope.
const LONG: u32 = 1000;

/// Segments of a short rope.
const SHORT: u32 = 32;

/// Number of short ropes.
const MANY: u32 = 1000;

/// Substeps in a tick, of one sweep each.
const SUBSTEPS: u32 = 10;

/// P3.
pub fn run(effort: &Effort) -> Vec<Row> {
    let spec = RopeSpec {
        segments: LONG,
        to: Vec3::X * cloth::CELL * LONG as f32,
        pin_start: true,
        ..Default::default()
    };
    let long = cloth::world(&rope(&spec).expect("the rope is sound"), SUBSTEPS, 1);
    let note = "one sweep a substep propagates a pull by a few segments only, so long ropes stretch in every solver";
    let held = "with long-range tethers to the pins, once a substep, as by default; the naive reference has none";
    vec![
        race(effort, format!("1 rope of {LONG}"), long).noted(note),
        race(effort, format!("{MANY} ropes of {SHORT}"), many(MANY, SUBSTEPS, 1)).noted(held),
    ]
}

/// Ropes side by side, each pinned at one end and released horizontally.
pub fn many(count: u32, substeps: u32, sweeps: u32) -> Simulation {
    let settings =
        SolverSettings { substeps, max_sweeps: sweeps, tolerance: 0.0, ..Default::default() };
    let mut world = empty(settings);
    for n in 0..count {
        let from = Vec3::Z * (0.5 * n as f32);
        let to = from + Vec3::X * cloth::CELL * SHORT as f32;
        let spec = RopeSpec { from, to, segments: SHORT, pin_start: true, ..Default::default() };
        let rope = rope(&spec).expect("the rope is sound");
        rope.build(&mut world).expect("the recipe is sound");
    }
    world
}

fn race(effort: &Effort, scene: String, world: Simulation) -> Row {
    let constraints = world.distances().len();
    let race = Race::between(Ours(world.clone()), Naive::of(&world));
    let race = race.against(peers::soft(effort, &world));
    let row = Row::new("P3", scene, Unit::Projection).sized(constraints, SUBSTEPS, 1);
    race.run(effort, constraints * SUBSTEPS as usize, row)
}
