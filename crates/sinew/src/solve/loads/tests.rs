//! Loads compared with known weights.

use glam::Vec3;

use crate::recipes::{ClothSpec, RopeSpec, cloth_grid, rope};
use crate::{Distance, ParticleSeed, Simulation};

const G: f32 = 9.81;
const TICK: f32 = 1.0 / 60.0;

/// A rope of 1 m and 0.5 kg that hangs from its start.
fn hung(segments: u32, substeps: u32, sweeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::NEG_Y * G;
    (world.settings.substeps, world.settings.max_sweeps) = (substeps, sweeps);
    let spec = RopeSpec { segments, mass: 0.5, pin_start: true, ..RopeSpec::default() };
    rope(&spec).unwrap().build(&mut world).unwrap();
    world
}

fn steps(world: &mut Simulation, count: u32) {
    for _ in 0..count {
        world.step(TICK).unwrap();
    }
}

#[test]
fn a_rope_pulls_with_the_weight_below_from_the_first_step_on_at_any_substeps_and_sweeps() {
    for segments in [5, 20, 100] {
        for (substeps, sweeps) in [(1, 1), (1, 10), (4, 4), (10, 4), (20, 1)] {
            let mut world = hung(segments, substeps, sweeps);
            let (top, middle) = (0, segments as usize / 2);
            world.measure_loads([top, middle], []);
            for tick in 0..200 {
                world.step(TICK).unwrap();
                for number in [top, middle] {
                    let lower = world.distances()[number].b as usize..world.particles.len();
                    let mass: f32 = lower.map(|i| 1.0 / world.particles.inverse_mass(i)).sum();
                    let load = world.distance_load(number).unwrap();
                    // A particle that was set at rest falls by ½ g h² in its first substep, and only that has to be held there.
                    let first = if tick == 0 { 1.0 - 0.5 / substeps as f32 } else { 1.0 };
                    let off = load / (first * mass * G) - 1.0;
                    assert!(
                        off.abs() < 0.02,
                        "{segments} pieces, {substeps} substeps, {sweeps} sweeps, tick {tick}, \
                         number {number}: {load} N, off by {off}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_rods_of_a_cloth_at_its_edge_carry_its_weight_together() {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::NEG_Y * G;
    let spec = ClothSpec { width: 1.0, height: 1.0, columns: 12, rows: 12, ..ClothSpec::default() };
    let mut cloth = cloth_grid(&spec).unwrap();
    let top = |p: &ParticleSeed| p.position.y > 0.499;
    let pins: Vec<u32> =
        (0..).zip(&cloth.particles).filter(|(_, p)| top(p)).map(|(i, _)| i).collect();
    pins.iter().for_each(|&pin| cloth.pin(pin).unwrap());
    cloth.build(&mut world).unwrap();
    let at_edge = |d: &Distance| pins.contains(&d.a) != pins.contains(&d.b);
    let numbered = world.distances().iter().enumerate();
    let rods: Vec<usize> = numbered.filter(|(_, d)| at_edge(d)).map(|(i, _)| i).collect();
    world.measure_loads(rods.iter().copied(), []);
    steps(&mut world, 300);
    let free = (0..world.particles.len()).filter(|&i| world.particles.inverse_mass(i) > 0.0);
    let weight: f32 = free.map(|i| G / world.particles.inverse_mass(i)).sum();
    // Bends reach from the edge to the second row, and carry none of it.
    let up: f32 = rods
        .iter()
        .map(|&i| {
            let d = world.distances()[i];
            let along = world.particles.separation(d.a as usize, d.b as usize).normalize().y.abs();
            world.distance_load(i).unwrap() * along
        })
        .sum();
    assert!((up / weight - 1.0).abs() < 0.03, "{up} N of {weight} N");
}

#[test]
fn what_is_not_measured_keeps_its_bits_and_a_free_pair_its_momentum() {
    let world = |measured: bool| {
        let mut world = hung(20, 10, 4);
        let spec = RopeSpec { from: Vec3::X, to: Vec3::new(2.0, 0.3, 0.0), ..RopeSpec::default() };
        rope(&spec).unwrap().build(&mut world).unwrap();
        let at = |x: f32| ParticleSeed { velocity: Vec3::Y * x, ..ParticleSeed::at(Vec3::X * x) };
        let a = world.particles.push(at(5.0)).unwrap();
        let b = world.particles.push(at(6.0)).unwrap();
        world.distances_mut().push(Distance::new(a, b, 1.0));
        if measured {
            world.measure_loads([0, 40], []);
        }
        steps(&mut world, 100);
        world
    };
    let (with, without) = (world(true), world(false));
    for i in 21..42 {
        assert_eq!(with.particles.position(i), without.particles.position(i), "particle {i}");
        assert_eq!(with.particles.velocity(i), without.particles.velocity(i));
    }
    let spin = |world: &Simulation| {
        let v = world.particles.velocity(43) - world.particles.velocity(42);
        world.particles.separation(43, 42).cross(v).z
    };
    // 1 kg each, a metre apart, 1 m/s relative to each other.
    assert!((spin(&with) - 1.0).abs() < 1e-3, "{}", spin(&with));
    let tension = with.distance_load(40).unwrap();
    assert!((tension - 0.5).abs() < 0.01, "m v²/r of 1 kg on half a metre: {tension}");
}

#[test]
fn a_torn_piece_is_let_go_of_by_its_tethers_in_the_same_step() {
    for measured in [false, true] {
        let mut world = hung(100, 10, 4);
        if measured {
            world.measure_loads(0..100, []);
        }
        steps(&mut world, 30);
        let before = world.particles.position(100).y;
        world.remove_distance(50);
        if measured {
            world.measure_loads(0..99, []);
        }
        world.step(TICK).unwrap();
        let fell = before - world.particles.position(100).y;
        let free = 0.5 * G * TICK * TICK;
        assert!((fell / free - 1.0).abs() < 0.15, "{fell} m, not {free}");
        if measured {
            let half = (1..=50).map(|i| 1.0 / world.particles.inverse_mass(i)).sum::<f32>() * G;
            let load = world.distance_load(0).unwrap();
            assert!((load / half - 1.0).abs() < 0.02, "{load} N of {half} N");
        }
    }
}

/// A weight of 1 kg on a line whose first piece, of 3 m, is on the drum of a winch; the others are 10 cm long and weigh 10 g.
fn winch(segments: u32, substeps: u32) -> Simulation {
    let mut world = Simulation::default();
    world.forces.gravity = Vec3::NEG_Y * G;
    world.settings.substeps = substeps;
    let mut above = world.particles.push(ParticleSeed::at(Vec3::ZERO).pinned()).unwrap();
    let mut depth = 0.0;
    for i in 1..=segments {
        let mass = if i == segments { 1.0 } else { 0.01 };
        let length = if i == 1 { 3.0 } else { 0.1 };
        depth += length;
        let seed = ParticleSeed::at(Vec3::NEG_Y * depth).with_mass(mass);
        let row = world.particles.push(seed).unwrap();
        world.distances_mut().push(Distance::new(above, row, length));
        above = row;
    }
    world.measure_loads([0], []);
    world
}

/// What recovery took off a correction was left in the load: at 0.25 m/s the weight read 20 N instead of 9.8.
#[test]
fn a_winch_reads_the_weight_that_it_hoists_at_any_speed() {
    for segments in [1, 10] {
        for substeps in [4, 10, 40] {
            for speed in [0.0, 0.1, 0.25, 0.5, 1.0] {
                let mut world = winch(segments, substeps);
                let weight = G * (1.0 + 0.01 * (segments - 1) as f32);
                for tick in 0..60 {
                    world.distances_mut()[0].rest -= speed * TICK;
                    world.step(TICK).unwrap();
                    let load = world.distance_load(0).unwrap();
                    assert!(
                        tick < 31 || (load / weight - 1.0).abs() < 0.06,
                        "{segments} pieces, {substeps} substeps, {speed} m/s, tick {tick}: {load} N"
                    );
                }
            }
        }
    }
}
