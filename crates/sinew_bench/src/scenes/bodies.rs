//! P5: boxes, and P6: ragdolls, each at default settings; nothing sleeps.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{BoxSpec, RagdollSpec, box_3d, ragdoll};
use sinew::{BodyContacts, Collider, Frame, Plane, Shape, Simulation};

use super::calm;
use crate::measure::{Effort, Ours, Race, World};
use crate::naive::Naive;
use crate::peers;
use crate::places::{places, stacked, stairs};
use crate::row::{Row, Unit};

/// Boxes along a side of their square: about as many as in P5's heap.
const BOXES: u32 = 32;

/// Boxes along an edge of the heap: the thousand of P5.
const HEAP: u32 = 10;

/// Boxes along an edge of the block in free flight.
const FLIGHT: u32 = 16;

/// Ragdolls along a side of their square.
const DOLLS: u32 = 10;

/// P5.
pub fn side_by_side(effort: &Effort) -> Vec<Row> {
    let world = boxes(BOXES);
    let settings = world.settings;
    let race = Race::between(Ours(world.clone()), Naive::of(&world));
    let race = race.against(peers::boxes(effort, BOXES));
    let scene = format!("{} boxes at rest side by side", BOXES * BOXES);
    let sized = Row::new("P5", scene, Unit::Tick).sized(
        world.distances().len(),
        settings.substeps,
        settings.max_sweeps,
    );
    let row = race.run(effort, 1, sized);
    let note = "default settings of each: 10 substeps of at most 8 sweeps, rapier 4 substeps, sleeping off";
    let equal = "the same number of substeps for both; sleeping off";
    let heaped = |ours, theirs, note| heaped(effort, [ours, theirs], note);
    vec![
        row.noted(note),
        in_flight(effort),
        heaped(10, peers::SUBSTEPS, note),
        heaped(4, 4, equal),
        heaped(10, 10, equal),
        calm::heaps(effort, (heap(HEAP), HEAP), 4),
        calm::heaps(effort, (heap(HEAP), HEAP), 10),
    ]
}

/// Rotating boxes in free flight that touch nothing, with their collision shapes.
fn in_flight(effort: &Effort) -> Row {
    let world = flying(FLIGHT);
    let (count, settings) = (world.distances().len(), world.settings);
    let row = Row::new("P5", format!("{} boxes in free flight", FLIGHT.pow(3)), Unit::Tick);
    let row = row.sized(count, settings.substeps, settings.max_sweeps);
    Race::alone(Ours(world)).run(effort, 1, row).noted("default settings; goal: 2 ms")
}

/// The heap with numbers of substeps for Sinew and for the other engine.
fn heaped(effort: &Effort, [substeps, theirs]: [u32; 2], note: &str) -> Row {
    let mut world = heap(HEAP);
    world.settings.substeps = substeps;
    let boxes = HEAP * HEAP * HEAP;
    let scene =
        format!("{boxes} boxes fall into a heap and collide, {substeps} substeps to {theirs}");
    let (count, sweeps) = (world.distances().len(), world.settings.max_sweeps);
    let race = Race::alone(Ours(world)).against(peers::heap(effort, HEAP, theirs));
    race.run(effort, 1, Row::new("P5", scene, Unit::Tick).sized(count, substeps, sweeps))
        .noted(note)
}

/// P6.
pub fn ragdolls(effort: &Effort) -> Vec<Row> {
    let floor = "default settings of each; no naive reference; limbs touch the floor with their joint particles only";
    let stairs = "default settings of each; bones collide with the stairs, with other ragdolls, and with bones not connected by a joint";
    let equal = "the same number of substeps for both; rapier's stretch is the opening of joints relative to the bone";
    let on_stairs = |ours, theirs, note: &str| {
        let (mut world, sweeps) = dolls_on_stairs(DOLLS);
        world.settings.substeps = ours;
        let onto = format!("stairs, {ours} substeps to {theirs}");
        let peer = peers::on_stairs(effort, DOLLS, theirs);
        falling(effort, &onto, (world, sweeps), peer).noted(note)
    };
    vec![
        falling(effort, "a floor", dolls(DOLLS), peers::ragdolls(effort, DOLLS)).noted(floor),
        on_stairs(10, peers::SUBSTEPS, stairs),
        on_stairs(4, 4, equal),
        on_stairs(10, 10, equal),
    ]
}

fn falling(
    effort: &Effort,
    onto: &str,
    (world, sweeps): (Simulation, u32),
    peer: Option<Box<dyn World>>,
) -> Row {
    let constraints = world.distances().len() + world.constraints().len();
    let scene = format!("{} ragdolls of 11 bones fall on {onto}", DOLLS * DOLLS);
    let row = Row::new("P6", scene, Unit::Tick).sized(constraints, world.settings.substeps, sweeps);
    Race::alone(Ours(world)).against(peer).run(effort, 1, row)
}

/// `side × side` cubes of 1 m and 1 kg at rest on the ground, 2 m apart.
pub fn boxes(side: u32) -> Simulation {
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(0.0));
    let cube = box_3d(&BoxSpec::default()).expect("the box is sound");
    for place in places(side) {
        let cube = cube.transformed(Quat::IDENTITY, place + Vec3::Y * 0.5);
        cube.build(&mut world).expect("the recipe is sound");
    }
    world
}

/// `edge³` cubes of 1 m and 1 kg, a little apart and out of line, above the ground.
pub fn heap(edge: u32) -> Simulation {
    let mut world = Simulation::default();
    world.colliders.push(Collider::fixed(Shape::half_space(), Frame::IDENTITY));
    let cube = box_3d(&BoxSpec::default()).expect("the box is sound");
    let contacts = BodyContacts { with_bodies: true, ..Default::default() };
    for place in stacked(edge) {
        let cube = cube.transformed(Quat::IDENTITY, place);
        cube.build_colliding(&mut world, contacts).expect("the recipe is sound");
    }
    world
}

/// `edge³` cubes of 1 m and 1 kg, 3 m apart, that fly upwards and rotate.
pub fn flying(edge: u32) -> Simulation {
    let mut world = Simulation::default();
    let cube = box_3d(&BoxSpec::default()).expect("the box is sound");
    let spin = Vec3::new(1.0, 2.0, 0.5);
    for place in stacked(edge) {
        let cube = cube.transformed(Quat::IDENTITY, place * 3.0);
        let rows = cube.build_colliding(&mut world, BodyContacts::default());
        for i in rows.expect("the recipe is sound") {
            let arm = world.particles.position(i) - place * 3.0;
            world.particles.set_velocity(i, Vec3::Y * 5.0 + spin.cross(arm));
        }
    }
    world
}

/// `side × side` ragdolls that fall from 1 m, and the maximum number of sweeps of the recipe.
pub fn dolls(side: u32) -> (Simulation, u32) {
    let mut world = Simulation::default();
    world.boundaries.planes.push(Plane::ground(0.0));
    let doll = ragdoll(&RagdollSpec::default()).expect("the ragdoll is sound");
    for place in places(side) {
        let doll = doll.transformed(Quat::IDENTITY, place + Vec3::Y);
        doll.build(&mut world).expect("the recipe is sound");
    }
    let sweeps = doll.settings.max_sweeps.unwrap_or(world.settings.max_sweeps);
    (world, sweeps)
}

/// The same above stairs, with collisions of the bones.
pub fn dolls_on_stairs(side: u32) -> (Simulation, u32) {
    let mut world = Simulation::default();
    for (half, place) in stairs(side) {
        let stair = Shape::cuboid(half * 2.0).expect("a stair is a box");
        world.colliders.push(Collider::fixed(stair, Frame::at(place)));
    }
    let doll = ragdoll(&RagdollSpec::default()).expect("the ragdoll is sound");
    let contacts = BodyContacts { with_bodies: true, with_itself: true, ..BodyContacts::default() };
    for place in places(side) {
        let doll = doll.transformed(Quat::IDENTITY, place + Vec3::Y);
        doll.build_colliding(&mut world, contacts).expect("the recipe is sound");
    }
    let sweeps = doll.settings.max_sweeps.unwrap_or(world.settings.max_sweeps);
    (world, sweeps)
}
