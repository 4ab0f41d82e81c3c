//! P13: allocations in a warm tick, on the stepping thread only; worker threads are not counted.

use sinew::Simulation;

use super::{bending, bodies, charges, cloth, ropes};
use crate::measure::{Effort, Ours, World};
use crate::row::{Row, Unit};

/// Ticks before counting starts: long enough for boxes to land and for buffers to have grown to their final size.
const WARM: usize = 60;

/// Ticks that are counted.
const COUNTED: usize = 60;

/// P13.
pub(super) fn run(_: &Effort) -> Vec<Row> {
    let scenes: [(&str, Simulation); 6] = [
        ("a cloth", cloth::world(&cloth::sheet(32), 4, 1)),
        ("20 ropes", ropes::many(20, 4, 1)),
        ("a cloth with bends", bending::world(16, bending::Bending::Isometric, 4, 1)),
        ("16 boxes on the ground", bodies::boxes(4)),
        ("16 ragdolls that fall", bodies::dolls(4).0),
        ("3000 charges, by the tree", charges::cloud(3000, 0)),
    ];
    scenes.map(|(scene, world)| row(scene, &mut Ours(world))).into()
}

/// Mean number of allocations in a tick of a scene.
pub(super) fn row(scene: &str, world: &mut dyn World) -> Row {
    (0..WARM).for_each(|_| world.tick());
    let counted =
        allocation_counter::measure(|| (0..COUNTED).for_each(|_| world.tick())).count_total;
    let ours = Some(counted as f64 / COUNTED as f64);
    Row { ours, ..Row::new("P13", format!("a warm tick of {scene}"), Unit::Allocations) }
}
