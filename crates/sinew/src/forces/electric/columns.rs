//! The charges in columns, sixteen side by side: one source acts on as many targets at once, which the compiler turns into vector
//! instructions on every machine.

use glam::{DVec3, Vec3};

use crate::particles::Particles;

/// Targets that are worked on at once.
pub(super) const LANES: usize = 16;

/// Squared distance in m² below which the force falls to zero: a micrometre. Its inverse cube, 1e18, and the squares of charges up to 10⁵ C stay in
/// the range of `f32` together.
pub(super) const NEAR: f32 = 1e-12;

/// One number for each of the targets at hand.
pub(super) type Lanes = [f32; LANES];

/// A charged particle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Where it is in the world, metres.
    pub at: DVec3,
    /// Its charge, C.
    pub charge: f64,
    pub row: u32,
}

/// The particles that take part: those with a charge, up to 10⁵ C, and at most 1e18 m from anywhere.
pub(super) fn charged(particles: &Particles) -> impl Iterator<Item = Item> + '_ {
    let rows = (0..particles.len()).filter(|&i| particles.charge[i] != 0.0);
    let item = |i: usize| Item {
        at: particles.origin[i].as_dvec3() + particles.position[i].truncate().as_dvec3(),
        charge: f64::from(particles.charge[i]),
        row: i as u32,
    };
    // Written so that what is not a number does not.
    rows.map(item).filter(|item| item.at.length_squared() < 1e36 && item.charge.abs() <= 1e5)
}

/// The charges, and the sums of the forces on them. Padded with charges of nothing to a multiple of [`LANES`].
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    local: [Vec<f32>; 3],
    origin: [Vec<f32>; 3],
    /// `√|K| q`: the product of two is symmetric, and neither too large nor too small for `f32`.
    charge: Vec<f32>,
    force: [Vec<f32>; 3],
}

impl Columns {
    /// Takes over the charges in the order of `items`, and forgets the forces.
    pub(super) fn fill(&mut self, particles: &Particles, items: &[Item], constant: f32) {
        let padded = items.len().next_multiple_of(LANES);
        let scale = constant.abs().sqrt();
        for column in self.local.iter_mut().chain(&mut self.origin).chain(&mut self.force) {
            column.clear();
            column.resize(padded, 0.0);
        }
        self.charge.clear();
        self.charge.resize(padded, 0.0);
        for (k, item) in items.iter().enumerate() {
            let i = item.row as usize;
            let (local, origin) = (particles.position[i], particles.origin[i]);
            for axis in 0..3 {
                self.local[axis][k] = local[axis];
                self.origin[axis][k] = origin[axis];
            }
            self.charge[k] = particles.charge[i] * scale;
        }
    }

    /// Number of charges, padding included.
    pub(super) fn len(&self) -> usize {
        self.charge.len()
    }

    /// Force on charge `k`, N, but for the sign of Coulomb's constant.
    pub(super) fn force(&self, k: usize) -> Vec3 {
        Vec3::new(self.force[0][k], self.force[1][k], self.force[2][k])
    }

    /// Adds to the forces on the targets from `first` on.
    #[inline(always)]
    pub(super) fn add(&mut self, first: usize, sum: &[Lanes; 3]) {
        for (column, sum) in self.force.iter_mut().zip(sum) {
            column[first..first + LANES].iter_mut().zip(sum).for_each(|(f, s)| *f += s);
        }
    }

    /// Takes the sum over the targets off the force on source `k`: what it did to them, they do to it.
    #[inline(always)]
    pub(super) fn react(&mut self, k: usize, forces: &[Lanes; 3]) {
        for (column, f) in self.force.iter_mut().zip(forces) {
            let mut four = [0.0_f32; 4];
            for (l, four) in four.iter_mut().enumerate() {
                *four = (f[l] + f[l + 4]) + (f[l + 8] + f[l + 12]);
            }
            column[k] -= (four[0] + four[1]) + (four[2] + four[3]);
        }
    }

    /// The targets from `first` on.
    #[inline(always)]
    pub(super) fn targets(&self, first: usize) -> Targets {
        Targets {
            local: core::array::from_fn(|axis| lanes(&self.local[axis], first)),
            origin: core::array::from_fn(|axis| lanes(&self.origin[axis], first)),
            charge: lanes(&self.charge, first),
        }
    }

    /// `s_a s_b d/(‖d‖² + ε²)^{3/2}`, the force of charge `k` on each target, with `softening` = ε², m².
    ///
    /// Differences are those of [`Particles::separation`]: true to the digits of the charges' own origins. `d` changes its sign exactly when the two
    /// change places, and nothing else does, so action and reaction are the same bits whoever is the target. A target that is the source feels
    /// nothing: `d` is zero.
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "a lane has one index in seven columns")]
    pub(super) fn forces_of(&self, k: usize, targets: &Targets, softening: f32) -> [Lanes; 3] {
        let [x, y, z] = [0, 1, 2].map(|axis| self.local[axis][k]);
        let [ox, oy, oz] = [0, 1, 2].map(|axis| self.origin[axis][k]);
        let charge = self.charge[k];
        let mut forces = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let dx = (targets.local[0][l] - x) + (targets.origin[0][l] - ox);
            let dy = (targets.local[1][l] - y) + (targets.origin[1][l] - oy);
            let dz = (targets.local[2][l] - z) + (targets.origin[2][l] - oz);
            let r2 = dx * dx + dy * dy + dz * dz + softening;
            // Not `max`, which costs more for what it does with NaN.
            let r2 = if r2 > NEAR { r2 } else { NEAR };
            let strength = targets.charge[l] * charge / (r2 * r2.sqrt());
            forces[0][l] = dx * strength;
            forces[1][l] = dy * strength;
            forces[2][l] = dz * strength;
        }
        forces
    }
}

/// The charges on which others act at the moment.
pub(super) struct Targets {
    local: [Lanes; 3],
    origin: [Lanes; 3],
    pub charge: Lanes,
}

#[inline(always)]
fn lanes(column: &[f32], first: usize) -> Lanes {
    core::array::from_fn(|l| column[first + l])
}
