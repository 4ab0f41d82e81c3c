//! P7: one cloth of a million particles, and P8: many small ones; on one thread and on two.

use sinew::Simulation;
use sinew::glam::{Quat, Vec3};

use super::cloth;
use crate::measure::{Effort, Ours, Race};
use crate::naive::Naive;
use crate::row::{Row, Unit};
use crate::threads::stepped_by;

/// Particles along a side of the large cloth.
const SIDE: u32 = 1024;

/// Substeps of the large cloth, of one sweep each.
const SUBSTEPS: u32 = 4;

/// Timed ticks of the large cloth: in the naive reference each takes a third of a second.
const SHORT: usize = 20;

/// Number of small cloths, and particles along a side of each.
const SMALL: (u32, u32) = (64, 32);

/// Note of a row that compares two threads with one.
const AGAINST_ONE: &str = "\"naive\" is Sinew with 1 thread";

/// P7.
pub(super) fn million(effort: &Effort) -> Vec<Row> {
    let world = cloth::world(&cloth::sheet(SIDE), SUBSTEPS, 1);
    let constraints = world.distances().len();
    let row = |scene: &str, unit| {
        let scene = format!("{SIDE}×{SIDE} cloth, {scene}");
        Row::new("P7", scene, unit).sized(constraints, SUBSTEPS, 1)
    };
    let race = Race::between(Ours(world.clone()), Naive::of(&world)).short(SHORT);
    let each = race.run(effort, constraints * SUBSTEPS as usize, row("1 thread", Unit::Projection));
    let projections = (constraints as u32 * SUBSTEPS) as f64;
    let whole = |x: Option<f64>| x.map(|x| x * projections);
    let tick =
        Row { ours: whole(each.ours), naive: whole(each.naive), ..row("1 thread", Unit::Tick) };
    let two = row("2 threads", Unit::WallTick);
    let race = Race { ours: Some(stepped_by(world, 2)), naive: None, peer: None, most: SHORT };
    let two = Row { naive: tick.ours, ..race.run(effort, 1, two) };
    vec![each, tick, two.noted(AGAINST_ONE)]
}

/// P8.
pub(super) fn many(effort: &Effort) -> Vec<Row> {
    let world = small();
    let scene = format!("{} cloths of {}×{}, 2 threads against 1", SMALL.0, SMALL.1, SMALL.1);
    let row = Row::new("P8", scene, Unit::WallTick).sized(world.distances().len(), 10, 1);
    let [two, one] = [2, 1].map(|threads| Some(stepped_by(world.clone(), threads)));
    let race = Race { ours: two, naive: one, peer: None, most: usize::MAX };
    vec![race.run(effort, 1, row).noted(AGAINST_ONE)]
}

fn small() -> Simulation {
    let sheet = cloth::sheet(SMALL.1);
    let mut world = cloth::world(&sheet, 10, 1);
    for n in 1..SMALL.0 {
        let sheet =
            sheet.transformed(Quat::IDENTITY, Vec3::X * (2.0 * cloth::CELL * (SMALL.1 * n) as f32));
        sheet.build(&mut world).expect("the recipe is sound");
    }
    world
}
