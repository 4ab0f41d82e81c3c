//! Naive reference of Coulomb's law: every pair once, in a plain loop over an array of structs.

use sinew::Simulation;
use sinew::glam::{DVec3, Vec3};

use crate::measure::{TICK, World};
use crate::row::Stretch;

/// A charged particle.
#[derive(Clone, Copy, Debug)]
struct Charge {
    position: Vec3,
    velocity: Vec3,
    force: Vec3,
    charge: f32,
    inverse_mass: f32,
}

/// Charges that attract and repel each other, stepped without substeps.
#[derive(Clone, Debug)]
pub struct Charges {
    charges: Vec<Charge>,
    constant: f32,
}

impl Charges {
    /// The charges of a simulation.
    pub fn of(world: &Simulation) -> Self {
        let charge = |i| Charge {
            position: world.particles.position(i),
            velocity: Vec3::ZERO,
            force: Vec3::ZERO,
            charge: world.particles.charge(i),
            inverse_mass: world.particles.inverse_mass(i),
        };
        let charges = (0..world.particles.len()).map(charge).collect();
        Self { charges, constant: world.forces.electric.constant }
    }

    /// Force on one charge from all others, summed in f64 as the reference value, N.
    pub fn force_on(&self, i: usize) -> DVec3 {
        let here = self.charges[i];
        let others = self.charges.iter().enumerate().filter(|&(j, _)| j != i);
        let sum: DVec3 = others
            .map(|(_, there)| {
                let d = here.position.as_dvec3() - there.position.as_dvec3();
                let square = d.length_squared();
                d * (f64::from(there.charge) / (square * square.sqrt()))
            })
            .sum();
        sum * (f64::from(self.constant) * f64::from(here.charge))
    }

    /// Sums up the forces of all pairs.
    pub fn attract(&mut self) {
        for charge in &mut self.charges {
            charge.force = Vec3::ZERO;
        }
        for i in 0..self.charges.len() {
            let (before, after) = self.charges.split_at_mut(i + 1);
            let here = &mut before[i];
            for there in after {
                let d = here.position - there.position;
                let square = d.length_squared();
                let size = self.constant * here.charge * there.charge / (square * square.sqrt());
                here.force += d * size;
                there.force -= d * size;
            }
        }
    }
}

impl World for Charges {
    fn tick(&mut self) {
        self.attract();
        for charge in &mut self.charges {
            charge.velocity += charge.force * (charge.inverse_mass * TICK);
            charge.position += charge.velocity * TICK;
        }
    }

    fn stretch(&self) -> Option<Stretch> {
        None
    }
}
