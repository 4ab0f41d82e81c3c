//! What it costs.

use std::time::Instant;

use glam::Vec3;

use super::{DT, Sheet, asks, body, empty, particle};
use crate::collide::BodyContacts;
use crate::particles::ParticleSeed;
use crate::simulation::Simulation;

/// A sheet of 4 cm cells with a third as many marbles as it has particles, which lie on it.
fn laden(surface: bool, with_itself: bool, cells: usize) -> Simulation {
    let mut world = empty(9.81);
    world.forces.drag = 0.5;
    let contacts = BodyContacts { surface, ..asks(with_itself) };
    let sheet = Sheet { contacts, radius: 0.01, ..Sheet::flat(cells, 0.04, 0.0) };
    sheet.build(&mut world, |i, j| (i == 0 || i == cells) && (j == 0 || j == cells));
    let own = body(&mut world, BodyContacts { surface: false, ..asks(false) });
    let marbles = cells * 4 / 7;
    for k in 0..marbles * marbles {
        let at = [k % marbles, k / marbles].map(|i| (i as f32 + 0.5) * 0.07 - 0.02 * cells as f32);
        let seed = ParticleSeed::at(Vec3::new(at[0], 0.03, at[1])).with_mass(0.005);
        particle(&mut world, seed.with_radius(0.015), own);
    }
    world
}

#[test]
#[ignore = "a measurement: run it alone, in release"]
fn a_laden_sheet_is_timed() {
    for cells in [30, 60] {
        for (surface, with_itself) in [(false, false), (false, true), (true, false), (true, true)] {
            let mut world = laden(surface, with_itself, cells);
            for _ in 0..60 {
                world.step(DT).unwrap();
            }
            let count = world.particles.len() as f64;
            let mut best = f64::MAX;
            for _ in 0..30 {
                let begin = Instant::now();
                world.step(DT).unwrap();
                best = best.min(begin.elapsed().as_secs_f64());
            }
            println!(
                "{count} particles, triangles {surface}, with itself {with_itself}: {:.0} ns a particle and step",
                best / count * 1e9,
            );
        }
    }
}
