//! Large cloth goes through a substep in microsteps, with no visible difference from outside: it falls, follows pins, is carried, compressed and bounced like
//! cloth that takes whole substeps.

use sinew::glam::{Quat, Vec3};
use sinew::recipes::{BoxSpec, ClothMaterial, ClothSpec, box_3d, cloth_grid};
use sinew::{
    BodyContacts, Collider, Frame, Material, Pin, Plane, Shape, Simulation, SolverSettings, Spring,
    Wind,
};

const DT: f32 = 1.0 / 60.0;

/// Cells along a side of a sheet: 441 particles, many more than an island needs to use microsteps.
const CELLS: u32 = 20;

/// A sheet of 1 m at a height, level or upright.
fn sheet(world: &mut Simulation, height: f32, level: bool, contacts: BodyContacts) {
    let material = ClothMaterial { radius: 0.01, drag: 0.0, ..Default::default() };
    let spec = ClothSpec { columns: CELLS, rows: CELLS, material, ..Default::default() };
    let turn = if level { Quat::from_xyzw(1.0, 0.0, 0.0, -1.0) } else { Quat::IDENTITY };
    let cloth = cloth_grid(&spec).unwrap().transformed(turn, Vec3::Y * height);
    cloth.build_colliding(world, contacts).unwrap();
}

/// A brick on its own ground far away, so that the world has contacts between bodies.
fn brick_elsewhere(world: &mut Simulation) {
    let at = Frame::at(Vec3::new(50.0, -1.0, 0.0));
    world.colliders.push(Collider::fixed(Shape::cuboid(Vec3::new(4.0, 2.0, 4.0)).unwrap(), at));
    let spec = BoxSpec { size: Vec3::ONE, mass: 2.0, ..Default::default() };
    for height in [0.5, 1.5] {
        let brick =
            box_3d(&spec).unwrap().transformed(Quat::IDENTITY, Vec3::new(50.0, height, 0.0));
        let contacts = BodyContacts { with_bodies: true, ..Default::default() };
        brick.build_colliding(world, contacts).unwrap();
    }
}

fn run(world: &mut Simulation, ticks: std::ops::Range<u32>) {
    for _ in ticks {
        world.step(DT).unwrap();
    }
}

fn pin(world: &mut Simulation, row: usize) {
    let seed = world.particles.seed(row).pinned();
    world.particles.set(row, seed).unwrap();
}

fn of_sheet() -> std::ops::Range<usize> {
    0..(CELLS as usize + 1).pow(2)
}

fn mean(of: impl Fn(usize) -> Vec3) -> Vec3 {
    of_sheet().map(of).sum::<Vec3>() / of_sheet().len() as f32
}

/// Mean strain of the distances, relative to their rest lengths.
fn strain(world: &Simulation) -> f32 {
    let strains = world.distances().iter().map(|d| {
        let apart = world.particles.separation(d.a as usize, d.b as usize).length();
        (apart / d.rest - 1.0).abs()
    });
    strains.sum::<f32>() / world.distances().len() as f32
}

#[test]
fn it_hangs_as_straight_as_by_twice_the_substeps_at_half_of_the_sweeps() {
    let hung = |substeps: u32, max_sweeps: u32| {
        let mut world = Simulation::default();
        world.settings = SolverSettings { substeps, max_sweeps, ..Default::default() };
        sheet(&mut world, 0.0, false, BodyContacts::default());
        for row in [0, CELLS as usize] {
            pin(&mut world, row);
        }
        run(&mut world, 0..240);
        (strain(&world), world.report().islands[0].sweeps)
    };
    let ((own, sweeps), (fine, _), (coarse, _)) = (hung(10, 4), hung(20, 1), hung(10, 1));
    println!("{own:.2e} in {sweeps} sweeps, {fine:.2e} at 20 × 1, {coarse:.2e} at 10 × 1");
    assert_eq!(sweeps, 20, "ten substeps of two microsteps");
    assert!(own < 1.1 * fine && own < 0.6 * coarse, "{own} {fine} {coarse}");
}

#[test]
fn it_falls_on_the_exact_parabola_whether_or_not_bodies_touch_elsewhere() {
    for elsewhere in [false, true] {
        let mut world = Simulation::default();
        sheet(&mut world, 0.0, true, BodyContacts::default());
        if elsewhere {
            brick_elsewhere(&mut world);
        }
        for i in of_sheet() {
            world.particles.set_velocity(i, Vec3::new(1.0, 3.0, 0.0));
        }
        run(&mut world, 0..60);
        let at = mean(|i| world.particles.position(i));
        let wanted = Vec3::new(1.0, 3.0 - 0.5 * 9.81, 0.0);
        assert!((at - wanted).length() < 2e-4, "{elsewhere}: {at} {wanted}");
        let v = mean(|i| world.velocity_now(i));
        assert!((v - Vec3::new(1.0, 3.0 - 9.81, 0.0)).length() < 2e-3, "{elsewhere}: {v}");
        assert!(strain(&world) < 1e-5, "{elsewhere}: {}", strain(&world));
    }
}

#[test]
fn moving_pins_move_evenly_and_arrive() {
    for elsewhere in [false, true] {
        let mut world = Simulation::default();
        world.forces.drag = 0.5;
        sheet(&mut world, 0.0, false, BodyContacts::default());
        if elsewhere {
            brick_elsewhere(&mut world);
        }
        let velocity = Vec3::new(2.0, 0.5, 0.0);
        let edge = 0..CELLS as usize + 1;
        let began: Vec<_> = edge.clone().map(|i| world.particles.position(i)).collect();
        edge.clone().for_each(|i| pin(&mut world, i));
        for tick in 1..=120 {
            let by = velocity * (tick as f32 * DT);
            let target = |i: usize| Pin { particle: i as u32, target: began[i] + by };
            world.boundaries.pins = edge.clone().map(target).collect();
            world.step(DT).unwrap();
            for i in edge.clone() {
                let (at, v) = (world.particles.position(i), world.particles.velocity(i));
                assert!((at - began[i] - by).length() < 1e-5, "{elsewhere}, tick {tick}: {at}");
                assert!((v - velocity).length() < 1e-2, "{elsewhere}, tick {tick}: {v}");
            }
        }
        // It trails behind, and stays connected.
        assert!(strain(&world) < 0.01, "{elsewhere}: {}", strain(&world));
    }
}

#[test]
fn what_it_lies_on_carries_it_along_and_feels_its_weight() {
    for elsewhere in [false, true] {
        let mut world = Simulation::default();
        let rise = |t: f32| Frame::at(Vec3::new(0.4 * t, 0.2 * t, 0.0));
        let table = Shape::cuboid(Vec3::new(4.0, 1.0, 4.0)).unwrap();
        world.colliders.push(Collider { events: true, ..Collider::fixed(table, rise(0.0)) });
        sheet(&mut world, 0.51, true, BodyContacts::default());
        if elsewhere {
            brick_elsewhere(&mut world);
        }
        let start = mean(|i| world.particles.position(i));
        let mass: f32 = of_sheet().map(|i| 1.0 / world.particles.inverse_mass(i)).sum();
        for tick in 0..120 {
            let now = tick as f32 * DT;
            world.colliders[0].start = rise(now);
            world.colliders[0].end = rise(now + DT);
            world.step(DT).unwrap();
        }
        let at = mean(|i| world.particles.position(i)) - start;
        // Lifted abruptly to 0.2 m/s, with half of that as friction, it slides until it is as fast as its support: v²/2μg.
        let lag = (0.4_f32 - 0.1).powi(2) / (2.0 * 0.5 * 9.81);
        assert!((at - Vec3::new(0.8 - lag, 0.4, 0.0)).length() < 6e-3, "{elsewhere}: {at} {lag}");
        let impulse: f32 = world.report().impacts.iter().map(|impact| impact.impulse).sum();
        assert!((impulse / (mass * 9.81 * DT) - 1.0).abs() < 0.02, "{elsewhere}: {impulse}");
    }
}

#[test]
fn it_bounces_as_high_as_its_restitution_says() {
    for (restitution, elsewhere) in [(0.0_f32, false), (0.5, false), (0.8, false), (0.8, true)] {
        let mut world = Simulation::default();
        let floor = Material::default().with_restitution(restitution);
        let ground = Collider::fixed(Shape::half_space(), Frame::IDENTITY).with_material(floor);
        world.colliders.push(ground);
        let contacts = BodyContacts { material: floor, ..Default::default() };
        sheet(&mut world, 1.01, true, contacts);
        if elsewhere {
            brick_elsewhere(&mut world);
        }
        let (mut highest, mut hit) = (0.0_f32, false);
        for _ in 0..80 {
            world.step(DT).unwrap();
            let (at, v) = (mean(|i| world.particles.position(i)), mean(|i| world.velocity_now(i)));
            hit |= at.y < 0.1;
            if hit && v.y >= 0.0 {
                highest = highest.max(at.y - 0.01);
            }
        }
        let wanted = restitution * restitution;
        println!("{restitution}: {highest}, {wanted} wanted");
        assert!((highest - wanted).abs() < 0.03, "{restitution}, {elsewhere}: {highest} {wanted}");
    }
}

#[test]
fn a_spring_that_pulls_on_it_has_it_take_substeps_whole() {
    let sweeps = |spring: bool| {
        let mut world = Simulation::default();
        world.boundaries.planes.push(Plane::new(Vec3::Y * -3.0, Vec3::Y).unwrap());
        sheet(&mut world, 0.0, false, BodyContacts::default());
        pin(&mut world, 0);
        pin(&mut world, CELLS as usize);
        if spring {
            let (a, b) = (0, of_sheet().end as u32 - 1);
            let spring = Spring { a, b, rest: 0.5, stiffness: 50.0, damping: 0.1 };
            world.forces.springs.push(spring);
        }
        run(&mut world, 0..30);
        world.report().islands[0].most_sweeps
    };
    assert_eq!((sweeps(false), sweeps(true)), (2, 4));
}

#[test]
fn a_jerk_at_its_edge_stretches_it_less_with_spans_and_none_of_its_momentum_is_lost() {
    // The worst strain in a free-floating sheet, one edge of which is thrown outwards. Nothing is pinned, so there are no tethers.
    let jerked = |long_range: bool| {
        let mut world = Simulation::default();
        world.settings.long_range = long_range;
        world.forces.gravity = Vec3::ZERO;
        sheet(&mut world, 0.0, false, BodyContacts::default());
        let edge: Vec<usize> = of_sheet().filter(|i| i % (CELLS as usize + 1) == 20).collect();
        for &i in &edge {
            world.particles.set_velocity(i, Vec3::X * 5.0);
        }
        let momentum = |world: &Simulation| -> Vec3 {
            of_sheet().map(|i| world.velocity_now(i) / world.particles.inverse_mass(i)).sum()
        };
        let (before, mut worst) = (momentum(&world), 0.0_f32);
        for _ in 0..30 {
            world.step(DT).unwrap();
            let strains = world.distances().iter().filter(|d| d.softness.is_hard()).map(|d| {
                let apart = world.particles.separation(d.a as usize, d.b as usize).length();
                apart / d.rest - 1.0
            });
            worst = worst.max(strains.fold(0.0, f32::max));
        }
        let lost = (momentum(&world) - before).length() / before.length();
        assert!(lost < 1e-4, "{long_range}: {lost}");
        worst
    };
    let (with, without) = (jerked(true), jerked(false));
    println!("{with:.3} with, {without:.3} without");
    assert!(with < 0.8 * without, "{with} {without}");
}

/// Largest relative length error of the hard rods.
fn worst_strain(world: &Simulation) -> f32 {
    let rods = world.distances().iter().filter(|d| d.softness.is_hard());
    let strains = rods.map(|d| {
        let apart = world.particles.separation(d.a as usize, d.b as usize).length();
        (apart / d.rest - 1.0).abs()
    });
    strains.fold(0.0, f32::max)
}

#[test]
fn what_the_rods_of_a_flag_cannot_all_have_is_shared_out() {
    // The flag is attached to the upper end of its pole by a few cells, whose diagonals cannot all be satisfied in any fold. One of them was off by 7 % at some
    // moment of each start, and by 4.3 before strains were limited to 3.
    for turned in [0.0, 1e-4] {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::new(9.81 * turned, -9.81, 0.0);
        let wind = Wind::steady(Vec3::new(13.0, 0.0, 3.5)).with_gusts(0.55);
        world.forces.winds.push(Wind { gust_length: 1.1, gust_period: 0.9, ..wind });
        let material = ClothMaterial { density: 0.18, drag: 0.75, ..Default::default() };
        let spec = ClothSpec {
            width: 1.92,
            height: 1.2,
            columns: 48,
            rows: 30,
            material,
            ..Default::default()
        };
        let mut cloth = cloth_grid(&spec).unwrap();
        (0..31).for_each(|row| cloth.pin(49 * row).unwrap());
        cloth.build(&mut world).unwrap();
        let mut worst = 0.0_f32;
        for tick in 0..240 {
            world.step(DT).unwrap();
            worst = if tick < 60 { 0.0 } else { worst.max(worst_strain(&world)) };
        }
        println!("turned by {turned}: {worst:.3}");
        assert!(worst < 0.0301, "{worst}");
    }
}

#[test]
fn what_nothing_holds_keeps_its_spin_though_its_rods_contradict_each_other() {
    // A free-floating, spinning sheet, all diagonals of which are too long. With the residual shared out as in hanging cloth, it lost a sixth of its spin.
    for elsewhere in [false, true] {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::ZERO;
        let spec = ClothSpec { columns: CELLS, rows: CELLS, ..Default::default() };
        let mut cloth = cloth_grid(&spec).unwrap();
        for d in cloth.distances.iter_mut().filter(|d| d.softness.is_hard()) {
            d.rest *= if d.rest > 0.06 { 1.03 } else { 1.0 };
        }
        cloth.build(&mut world).unwrap();
        if elsewhere {
            brick_elsewhere(&mut world);
        }
        let spin = Vec3::new(0.0, 0.0, 0.5);
        for i in of_sheet() {
            let at = world.particles.position(i);
            world.particles.set_velocity(i, spin.cross(at) + Vec3::X * 0.2);
        }
        let mass = |world: &Simulation, i: usize| world.particles.mass(i);
        let total: f32 = of_sheet().map(|i| mass(&world, i)).sum();
        let centre = |world: &Simulation| -> Vec3 {
            of_sheet().map(|i| world.particles.position(i) * mass(world, i)).sum::<Vec3>() / total
        };
        let velocity = |world: &Simulation| -> Vec3 {
            of_sheet().map(|i| world.velocity_now(i) * mass(world, i)).sum::<Vec3>() / total
        };
        let turning = |world: &Simulation| -> Vec3 {
            let (at, v) = (centre(world), velocity(world));
            let arm = |i: usize| world.particles.position(i) - at;
            of_sheet().map(|i| arm(i).cross(world.velocity_now(i) - v) * mass(world, i)).sum()
        };
        let before = turning(&world);
        run(&mut world, 0..240);
        let (at, v) = (centre(&world), velocity(&world));
        assert!((at - Vec3::X * 0.8).length() < 2e-3, "{elsewhere}: {at}");
        assert!((v - Vec3::X * 0.2).length() < 1e-3, "{elsewhere}: {v}");
        let lost = (turning(&world) - before).length() / before.length();
        println!("{elsewhere}: {at}, {v}, {lost:.2e}, strain {}", worst_strain(&world));
        assert!(lost < 2e-3, "{elsewhere}: {lost}");
    }
}

#[test]
fn a_jerk_that_goes_through_a_large_sheet_is_not_seen_as_long_rods() {
    // It swings from two corners in a wind and snaps taut from time to time: rods there were off by 51, 16, 14 and 14 % before strains were limited. The amount
    // depends on the jerk, and that on the last bit of the initial state, so the mean of four runs is checked.
    let worst = [0.0, 1e-4, 2e-4, 3e-4].map(|turned| {
        let mut world = Simulation::default();
        world.forces.gravity = Vec3::new(9.81 * turned, -9.81, 0.0);
        world.forces.winds.push(Wind::steady(Vec3::new(0.0, 0.0, 5.0)));
        let spec =
            ClothSpec { width: 2.0, height: 2.0, columns: 127, rows: 127, ..Default::default() };
        let mut cloth = cloth_grid(&spec).unwrap();
        [0, 127].into_iter().for_each(|row| cloth.pin(row).unwrap());
        cloth.build(&mut world).unwrap();
        let mut worst = 0.0_f32;
        for tick in 0..240 {
            world.step(DT).unwrap();
            worst = if tick < 60 { 0.0 } else { worst.max(worst_strain(&world)) };
        }
        worst
    });
    println!("{worst:.3?}");
    let mean = worst.iter().sum::<f32>() / worst.len() as f32;
    assert!(mean < 0.15, "{mean}: {worst:?}");
}
