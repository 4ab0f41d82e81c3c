//! The ledger: energy and momentum of a world, so that each claim about their conservation can be one test.

use glam::{DVec3, Vec3};

use crate::forces::{self, Forces};
use crate::particles::Particles;

/// Energies in joules and momenta of all particles of finite mass, summed in `f64`; pinned particles are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// `Σ ½ m v²`, J, with the velocity at the instant of the position as the forces alone carry it there. So a particle that constraints hold at rest counts
    /// with the velocity of half a substep's free fall.
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

/// Sums up the ledger. The accelerations of the particles must be those of their present positions; `soft` is the energy stored in soft distances and
/// constraints, J.
pub(crate) fn sum(particles: &Particles, forces: &Forces, soft: f64) -> Ledger {
    let mut ledger = Ledger::default();
    for i in 0..particles.len() {
        let w = particles.inverse_mass(i);
        if w == 0.0 {
            continue;
        }
        let m = 1.0 / f64::from(w);
        let x = particles.origin[i].as_dvec3() + particles.position[i].truncate().as_dvec3();
        // The velocity under the forces alone: internal forces cancel in the sums only if each body gets its full share of them.
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
