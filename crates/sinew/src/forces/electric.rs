//! Electric forces between charged particles, all pairs (physics.md F4).

use glam::Vec3;

use crate::particles::Particles;

/// Coulomb's law between all charged particles: like charges repel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Electric {
    /// Coulomb's constant K, N·m²/C². Default 8.987 552e9, the vacuum's: a microcoulomb is a strong charge on this scale.
    pub constant: f32,
    /// Softening length ε, metres: within it the force falls to zero instead of growing without bound (Plummer). Default 0.
    pub softening: f32,
}

impl Default for Electric {
    fn default() -> Self {
        Self { constant: 8.987_552e9, softening: 0.0 }
    }
}

impl Electric {
    /// Whether both numbers are finite and the softening is not negative. Otherwise charges feel nothing.
    pub fn is_valid(&self) -> bool {
        self.constant.is_finite() && self.softening.is_finite() && self.softening >= 0.0
    }
}

/// Adds `f_a = K q_a q_b d/(‖d‖² + ε²)^{3/2}`, `d = p_a - p_b`, and its opposite for every pair: the forces sum to zero exactly.
///
/// `charged` is scratch for the rows that carry a charge; it keeps its memory between calls. Charges at the same point without
/// softening have no direction and feel nothing from each other.
pub(crate) fn apply(particles: &mut Particles, law: &Electric, charged: &mut Vec<u32>) {
    if !law.is_valid() {
        return;
    }
    charged.clear();
    charged.extend((0..particles.len() as u32).filter(|&i| particles.charge[i as usize] != 0.0));
    for (k, &a) in charged.iter().enumerate() {
        let a = a as usize;
        for &b in &charged[k + 1..] {
            let b = b as usize;
            let d = particles.position(a) - particles.position(b);
            let force = pair_force(law, d, particles.charge[a] * particles.charge[b]);
            particles.add_force(a, force);
            particles.add_force(b, -force);
        }
    }
}

/// Potential energy of all pairs, `Σ K q_a q_b/√(‖d‖² + ε²)`, joules.
pub(crate) fn energy(particles: &Particles, law: &Electric) -> f64 {
    let mut sum = 0.0;
    for a in 0..particles.len() {
        for b in a + 1..particles.len() {
            let charges = particles.charge[a] * particles.charge[b];
            let d = particles.position(a) - particles.position(b);
            let r2 = d.length_squared() + law.softening * law.softening;
            if charges != 0.0 && r2 > 0.0 {
                sum += f64::from(law.constant * charges) / f64::from(r2).sqrt();
            }
        }
    }
    sum
}

#[inline]
fn pair_force(law: &Electric, d: Vec3, charges: f32) -> Vec3 {
    let r2 = d.length_squared() + law.softening * law.softening;
    if r2 > 0.0 {
        // K first: microcoulombs squared alone are close to where f32 loses digits.
        d * (law.constant * charges / (r2 * r2.sqrt()))
    } else {
        Vec3::ZERO
    }
}
