//! The ledger: energy and momentum of a world, so that every claim about them is one test.

use glam::{DVec3, Vec3};

use crate::forces::{self, Forces};
use crate::particles::Particles;

/// Energies in joules and momenta of all particles of finite mass, summed in `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// `Σ ½ m v²`, J, with the velocity at the instant of the position, of what is free: what is held is taken to fall for half a substep.
    pub kinetic: f64,
    /// `-Σ m g · x`, J, zero at the origin, and `-Σ GM m/√(r² + ε²)` of the attractors, zero far from them.
    pub gravitational: f64,
    /// `Σ ½ k (‖d‖ - L)²` of the springs and `Σ ½ C²/α` of the soft distances and constraints, J.
    pub elastic: f64,
    /// `Σ K q_a q_b / ‖d‖` of the charges, J, and `-q E·x` of those that can move in the fields that fill the world, zero at the origin.
    pub electric: f64,
    /// `Σ m v`, kg·m/s.
    pub momentum: DVec3,
    /// `Σ m x × v` about the origin, kg·m²/s.
    pub angular_momentum: DVec3,
}

impl Ledger {
    /// Sum of the four energies, J.
    pub fn energy(&self) -> f64 {
        self.kinetic + self.gravitational + self.elastic + self.electric
    }
}

/// Sums up the ledger of particles whose accelerations are those of their present positions; `soft` is what soft distances and constraints store, J.
pub(crate) fn take(particles: &Particles, forces: &Forces, soft: f64) -> Ledger {
    let mut ledger = Ledger::default();
    for i in 0..particles.len() {
        let w = particles.inverse_mass(i);
        if w == 0.0 {
            continue;
        }
        let m = 1.0 / f64::from(w);
        let x = particles.origin[i].as_dvec3() + particles.position[i].truncate().as_dvec3();
        // As the forces alone have it: what bodies do to each other sums up to nothing only where nothing is left out of one of them.
        let v: Vec3 = particles.free_velocity_now(i);
        let v = v.as_dvec3();
        ledger.kinetic += 0.5 * m * v.length_squared();
        ledger.gravitational += forces::gravity_energy(particles, forces, i, m);
        ledger.momentum += m * v;
        ledger.angular_momentum += m * x.cross(v);
    }
    ledger.elastic = forces.springs.iter().map(|s| f64::from(s.energy(particles))).sum();
    ledger.elastic += soft;
    ledger.electric = forces::electric_energy(particles, forces);
    ledger
}
