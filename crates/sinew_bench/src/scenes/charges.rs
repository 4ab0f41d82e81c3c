//! P9: charges that attract and repel each other, over all pairs and by the tree.

use sinew::glam::Vec3;
use sinew::{ParticleSeed, Simulation, SolverSettings};

use super::cloth::shuffle;
use super::empty;
use crate::measure::{Effort, Ours, Race, TICK};
use crate::naive::charges::Charges;
use crate::row::{Row, Unit};

/// Number of charges for the sum over all pairs.
const FEW: usize = 4096;

/// Number of charges for the tree.
const MANY: usize = 65_536;

/// Number of charges over which the error is measured; fewer than all, because the exact sum for each one runs over all others.
const SAMPLES: usize = 256;

/// P9.
pub fn run(effort: &Effort) -> Vec<Row> {
    let world = cloud(FEW, FEW as u32);
    let scene = format!("{FEW} charges, all pairs");
    let row = Row::new("P9", scene, Unit::Pair).sized(FEW * (FEW - 1) / 2, 1, 0);
    let race = Race::between(Ours(world.clone()), Charges::of(&world)).short(24);
    let pairs = race.run(effort, FEW * (FEW - 1) / 2, row);
    let world = cloud(MANY, 0);
    let error = error(&world);
    let row = Row::new("P9", format!("{MANY} charges, by the tree"), Unit::Tick).sized(MANY, 1, 0);
    let tree = Race::alone(Ours(world)).short(8).run(effort, 1, row);
    vec![pairs, tree.noted(format!("error of the forces {:.2} %, root mean square", 100.0 * error))]
}

/// Charges of both signs, a microcoulomb each, at shuffled positions in a cube of 10 m: each coordinate value occurs once.
pub fn cloud(count: usize, all_pairs_up_to: u32) -> Simulation {
    let settings = SolverSettings { substeps: 1, ..SolverSettings::default() };
    let mut world = empty(settings);
    world.forces.gravity = Vec3::ZERO;
    world.forces.electric.all_pairs_up_to = all_pairs_up_to;
    let (once, again) = (shuffle(count), shuffle(count + 1));
    let along = |n: u32| 10.0 * (n as f32 / count as f32 - 0.5);
    for n in 0..count {
        let place = Vec3::new(along(n as u32), along(once[n]), along(again[n]));
        let charge = if n % 2 == 0 { 1e-6 } else { -1e-6 };
        let seed = ParticleSeed::at(place).with_charge(charge);
        world.particles.push(seed).expect("the charge is sound");
    }
    world
}

/// Root mean square error of the forces, relative to the root mean square of the forces.
fn error(world: &Simulation) -> f64 {
    let mut world = world.clone();
    let exact = Charges::of(&world);
    world.begin_step(TICK).expect("a sixtieth of a second can be stepped");
    world.begin_substep();
    world.apply_electric();
    let (mut wrong, mut whole) = (0.0, 0.0);
    for n in 0..SAMPLES {
        let i = n * (world.particles.len() / SAMPLES);
        let force = exact.force_on(i);
        // Each has 1 kg, so the acceleration is the force.
        wrong += (world.particles.acceleration(i).as_dvec3() - force).length_squared();
        whole += force.length_squared();
    }
    (wrong / whole).sqrt()
}
