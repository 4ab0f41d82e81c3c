//! Random operations on a world, and steps of unusual lengths: the world stays valid whatever a game does.

use sinew::glam::Vec3;
use sinew::recipes::{ClothSpec, cloth_grid};
use sinew::{Bound, Distance, Electric, Fluid, InsideBox, ParticleSeed, Pin, Plane};
use sinew::{Simulation, SolverSettings, Spring, Wind};

use crate::constraints;
use crate::contacts;
use crate::input::Input;

/// Enough for colours and islands to appear, and few enough that a scenario takes less than a millisecond.
const MAX_PARTICLES: usize = 40;
const MAX_LINKS: usize = 80;
const MAX_OTHERS: usize = 4;
const MAX_STEPS: u32 = 12;
const MAX_SWEEPS_OF_A_SHEET: u32 = 8;

/// Runs a scenario. Panics if the solver breaks a guarantee.
pub fn step(data: &[u8]) {
    let mut input = Input::new(data);
    let mut world = Simulation::default();
    let settings = settings(&mut input);
    if input.rarely(4) {
        sheet(&mut world, &mut input);
    }
    set(&mut world, settings);
    let mut steps = 0;
    while !input.is_spent() && steps < MAX_STEPS {
        if input.rarely(6) {
            steps += 1;
            let dt = input.mostly(|input| input.positive() / 64.0);
            take_step(&mut world, dt);
        } else {
            operate(&mut world, &mut input);
        }
    }
    take_step(&mut world, 1.0 / 60.0);
}

/// A sheet of nine by nine particles: enough for microsteps, tethers, spans, and strain limiting.
fn sheet(world: &mut Simulation, input: &mut Input) {
    let spec = ClothSpec { columns: 8, rows: 8, shear: input.flag(), ..ClothSpec::default() };
    let mut cloth = cloth_grid(&spec).expect("a sheet of ordinary numbers");
    for _ in 0..input.below(4) {
        cloth.pin(input.below(81)).expect("it has so many particles");
    }
    cloth.build(world).expect("an empty world has room for it");
}

/// The solver's settings: extreme in one number only, because in both they make a quarter of a million sweeps.
fn settings(input: &mut Input) -> SolverSettings {
    let (substeps, max_sweeps) = match input.below(12) {
        0 => (u32::MAX, input.below(3)),
        1 => (input.below(3), u32::MAX),
        _ => (input.below(5), input.below(6)),
    };
    let tolerance = input.mostly(|_| 1e-4);
    constraints::choices(
        input,
        SolverSettings { substeps, max_sweeps, tolerance, ..Default::default() },
    )
}

/// Sets the settings of a world, with unlimited sweeps only if particles are few. A thousand sweeps over a sheet, most violated first, take a minute with a
/// sanitizer, which the fuzzer reports as a hang.
fn set(world: &mut Simulation, settings: SolverSettings) {
    let few = world.particles.len() <= MAX_PARTICLES;
    let most = if few { u32::MAX } else { MAX_SWEEPS_OF_A_SHEET };
    world.settings = SolverSettings { max_sweeps: settings.max_sweeps.min(most), ..settings };
}

/// One operation of a game.
fn operate(world: &mut Simulation, input: &mut Input) {
    let count = world.particles.len();
    match input.below(31) {
        26..=30 => contacts::operate(world, input, MAX_PARTICLES),
        20..=25 => constraints::operate(world, input, row),
        0..=4 => push(world, input),
        5 if count > 0 => {
            let (row, seed) = (input.below(count as u32) as usize, seed(input));
            let before = state(world);
            if world.particles.set(row, seed).is_err() {
                assert_eq!(state(world), before, "a refused seed changed something");
            }
        }
        6..=8 => {
            let distance = distance(input, count);
            if world.distances().len() < MAX_LINKS {
                let k = input.below(world.distances().len() as u32 + 1) as usize;
                world.insert_distance(k, distance);
            }
        }
        9 if !world.distances().is_empty() => {
            let k = input.below(world.distances().len() as u32) as usize;
            match input.below(4) {
                0 => world.remove_distance(k),
                1 => world.replace_distance(k, distance(input, count)),
                2 => world.distances_mut().swap_remove(k),
                _ => core::mem::replace(&mut world.distances_mut()[k], distance(input, count)),
            };
        }
        10 => keep(&mut world.forces.springs, spring(input, count), MAX_LINKS),
        11 => keep(&mut world.forces.surfaces, [0; 3].map(|_| row(input, count)), MAX_LINKS),
        12 => {
            let wind = wind(input);
            check_gusts(&wind, input.vector(), world.time);
            keep(&mut world.forces.winds, wind, MAX_OTHERS);
        }
        13 => keep(&mut world.forces.fluids, fluid(input), MAX_OTHERS),
        14 => surroundings(world, input),
        15 => {
            let pin = Pin { particle: row(input, count), target: input.vector() };
            keep(&mut world.boundaries.pins, pin, MAX_LINKS);
        }
        16 => {
            let settings = settings(input);
            set(world, settings);
        }
        17 if input.rarely(4) => {
            let len = input.below(count as u32 + 4) as usize;
            world.particles.resize(len.min(MAX_PARTICLES));
        }
        18 if count > 0 => {
            let i = input.below(count as u32) as usize;
            match input.below(4) {
                0 => world.particles.set_position(i, input.vector()),
                1 => world.particles.set_velocity(i, input.vector()),
                2 => world.particles.set_external_force(i, input.vector()),
                _ => world.particles.add_impulse(i, input.vector()),
            }
        }
        19 => {
            let mut numbers = || (0..input.below(4)).map(|_| input.below(400) as usize).collect();
            let [strains, distances, constraints]: [Vec<usize>; 3] = [(); 3].map(|()| numbers());
            world.measure_strains(strains);
            world.measure_loads(distances, constraints);
        }
        _ => {
            world.ledger();
        }
    }
}

fn push(world: &mut Simulation, input: &mut Input) {
    let (seed, count) = (seed(input), world.particles.len());
    if count < MAX_PARTICLES {
        let pushed = world.particles.push(seed);
        assert_eq!(pushed.err(), seed.fault());
        assert_eq!(world.particles.len(), count + usize::from(pushed.is_ok()));
    }
}

/// Adds to a list, or replaces its last entry if the list is full.
fn keep<T>(list: &mut Vec<T>, item: T, most: usize) {
    list.truncate(most - 1);
    list.push(item);
}

fn seed(input: &mut Input) -> ParticleSeed {
    let seed = ParticleSeed::at(input.vector())
        .with_velocity(input.vector())
        .with_mass(input.mostly(Input::positive))
        .with_radius(input.mostly(|input| if input.flag() { input.positive() } else { 0.0 }))
        .with_charge(input.mostly(|input| input.ordinary() * 1e-6))
        .with_drag(input.mostly(|input| input.positive() / 64.0));
    let lag = input.mostly(|input| if input.flag() { 0.01 } else { 0.0 });
    if input.rarely(8) { seed.pinned() } else { ParticleSeed { lag, ..seed } }
}

/// A row that exists in most cases.
fn row(input: &mut Input, count: usize) -> u32 {
    if input.rarely(16) { input.bits() } else { input.below(count as u32) }
}

fn distance(input: &mut Input, count: usize) -> Distance {
    let (a, b) = (row(input, count), row(input, count));
    let bound = [Bound::Equal, Bound::AtMost, Bound::AtLeast][input.below(3) as usize];
    let compliance = input.mostly(|input| if input.flag() { 0.0 } else { input.positive() });
    Distance::new(a, b, input.mostly(Input::positive)).with_compliance(compliance).with_bound(bound)
}

fn spring(input: &mut Input, count: usize) -> Spring {
    Spring {
        a: row(input, count),
        b: row(input, count),
        rest: input.mostly(Input::positive),
        stiffness: input.mostly(|input| input.positive() * 100.0),
        damping: input.mostly(Input::positive),
    }
}

fn wind(input: &mut Input) -> Wind {
    Wind {
        pressure: input.vector(),
        gusts: input.mostly(Input::positive),
        gust_length: input.mostly(Input::positive),
        gust_period: input.mostly(Input::positive),
        ..Wind::steady(Vec3::ZERO)
    }
}

/// Checks the bounds of gusts: the waves of each kind add up to at most 1.
fn check_gusts(wind: &Wind, place: Vec3, time: f64) {
    let ordinary = |x: f32| (1e-6..1e6).contains(&x);
    let numbers = [wind.pressure.length(), wind.gusts, wind.gust_length, wind.gust_period];
    if numbers.into_iter().all(ordinary) && place.length() < 1e18 && time.is_finite() {
        let most = wind.pressure.length() * (1.0 + 2.01 * wind.gusts);
        let blows = wind.at(place, time);
        assert!(blows.length() <= most, "{wind:?} blows with {blows} at {place} and {time} s");
    }
}

fn fluid(input: &mut Input) -> Fluid {
    let up = if input.rarely(4) { input.vector() } else { Vec3::Y };
    let drag = input.mostly(|input| input.positive() / 64.0);
    let density = input.mostly(|input| input.positive() * 1000.0);
    let current = if input.rarely(4) { input.vector() } else { Vec3::ZERO };
    Fluid { up, level: input.mostly(Input::ordinary), density, drag, current, ..Fluid::default() }
}

fn surroundings(world: &mut Simulation, input: &mut Input) {
    let friction = input.mostly(Input::positive);
    match input.below(7) {
        0 => world.forces.gravity = input.vector(),
        1 => world.forces.drag = input.mostly(|input| input.positive() / 64.0),
        2 => {
            world.forces.electric = Electric {
                constant: input.any(),
                softening: input.mostly(Input::positive),
                ..Electric::default()
            };
        }
        3 => {
            let plane = Plane {
                normal: input.vector(),
                offset: input.any(),
                friction,
                ..Plane::ground(0.0)
            };
            keep(&mut world.boundaries.planes, plane, MAX_OTHERS);
        }
        4 => {
            if let Some(plane) = Plane::new(input.vector(), input.vector()) {
                assert!(plane.is_valid());
                keep(&mut world.boundaries.planes, plane.with_friction(friction), MAX_OTHERS);
            }
        }
        5 => {
            let (min, max) = (input.vector(), input.vector());
            let room = InsideBox { friction, ..InsideBox::new(min, max) };
            keep(&mut world.boundaries.boxes, room, MAX_OTHERS);
        }
        _ => world.time = f64::from(input.any()),
    }
}

/// Takes a step, and checks its guarantees.
fn take_step(world: &mut Simulation, dt: f32) {
    let before = state(world);
    let mut twin = world.clone();
    if world.step(dt).is_err() {
        assert_eq!(state(world), before, "a refused step changed something");
        return;
    }
    for i in 0..world.particles.len() {
        let p = &world.particles;
        assert!(p.is_finite(i), "particle {i} is at {} with {}", p.position(i), p.velocity(i));
    }
    let report = world.report();
    assert!(
        report.frozen.is_sorted() && report.frozen.iter().all(|&i| (i as usize) < before.len())
    );
    assert!(!report.error.is_nan() && !report.strain.is_nan(), "{report:?}");
    for (i, row) in before.iter().enumerate() {
        assert_eq!(world.particles.inverse_mass(i).to_bits(), row[3], "a step changed a mass");
        let pinned = world.particles.inverse_mass(i) == 0.0;
        let led = world.boundaries.pins.iter().any(|pin| pin.particle as usize == i);
        let was = Vec3::from_array([0, 1, 2].map(|k| f32::from_bits(row[k])));
        if pinned && !led && was.is_finite() {
            assert_eq!(world.particles.position(i), was, "a pinned particle moved");
        }
    }
    // The clone recompiles its plan, while the original may have updated it incrementally.
    twin.distances_mut();
    twin.step(dt).expect("a step was taken once and refused once");
    assert_eq!(state(&twin), state(world), "two runs differ");
}

/// Every bit from which a step starts, one row for each particle. Two NaN are equal if their bits are.
fn state(world: &Simulation) -> Vec<[u32; 8]> {
    let p = &world.particles;
    let row = |i| {
        let (position, velocity) = (p.position(i).to_array(), p.velocity(i).to_array());
        let numbers = [
            position[0],
            position[1],
            position[2],
            p.inverse_mass(i),
            velocity[0],
            velocity[1],
            velocity[2],
            p.lag(i),
        ];
        numbers.map(f32::to_bits)
    };
    (0..p.len()).map(row).collect()
}
