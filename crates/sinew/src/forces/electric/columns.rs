//! Charges in packed columns, nodes of a tree over them, and Coulomb's law in eight lanes: one source acts on eight targets at once.

use glam::{DVec3, Vec3, Vec4};

use crate::lanes::{LANES, Lanes, Vector};
use crate::particles::Particles;

/// Squared distance, m², below which the force falls to zero: a micrometre. The product of its inverse cube, 1e18, and the squares of charges up to 10⁵ C is
/// still within the range of `f32`.
pub(super) const NEAR: f32 = 1e-12;

/// Charges in a leaf of the tree: one for each lane. The number of packed charges is a multiple of it.
pub(super) const LEAF: usize = LANES;

/// A charged particle.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChargedParticle {
    /// Position in world space, metres.
    pub at: DVec3,
    /// Its charge, C.
    pub charge: f64,
    pub row: u32,
}

/// The charged particles that take part: those with a charge of at most 10⁵ C, within 1e18 m of the world's origin.
pub(super) fn charged(particles: &Particles) -> impl Iterator<Item = ChargedParticle> + '_ {
    let rows = (0..particles.len()).filter(|&i| particles.charge[i] != 0.0);
    let item = |i: usize| ChargedParticle {
        at: particles.origin[i].as_dvec3() + particles.position[i].truncate().as_dvec3(),
        charge: f64::from(particles.charge[i]),
        row: i as u32,
    };
    // Written so that a NaN is excluded.
    rows.map(item).filter(|item| item.at.length_squared() < 1e36 && item.charge.abs() <= 1e5)
}

/// The charges, and the accumulated forces on them. Padded with zero charges to a multiple of [`LEAF`].
#[derive(Clone, Debug, Default)]
pub(super) struct ChargeColumns {
    /// `[x y z s]`: metres from the particle's origin, and s = `√|K| q`. The product of two is symmetric and stays within the range of `f32`.
    pub charges: Vec<Vec4>,
    /// `[x y z 0]`, metres.
    pub origins: Vec<Vec4>,
    /// `[x y z 0]`, N, without the sign of Coulomb's constant.
    pub forces: Vec<Vec4>,
}

impl ChargeColumns {
    /// Loads the charges in the order of `items`, and clears the forces.
    pub(super) fn fill(&mut self, particles: &Particles, items: &[ChargedParticle], constant: f32) {
        let scale = constant.abs().sqrt();
        let rows = || items.iter().map(|item| item.row as usize);
        let padded = items.len().next_multiple_of(LEAF);
        self.charges.clear();
        self.charges
            .extend(rows().map(|i| particles.position[i].with_w(particles.charge[i] * scale)));
        self.charges.resize(padded, Vec4::ZERO);
        self.origins.clear();
        self.origins.extend(rows().map(|i| particles.origin[i].extend(0.0)));
        self.origins.resize(padded, Vec4::ZERO);
        self.forces.clear();
        self.forces.resize(padded, Vec4::ZERO);
    }

    /// Force on charge `k`, N, without the sign of Coulomb's constant.
    pub(super) fn force(&self, k: usize) -> Vec3 {
        self.forces[k].truncate()
    }
}

/// The eight charges on which forces are being computed.
#[derive(Clone, Copy)]
pub(super) struct Targets<L> {
    local: Vector<L>,
    origin: Vector<L>,
    pub charge: L,
    softening: L,
}

impl<L: Lanes> Targets<L> {
    /// The targets from row `first` on, with `softening` = ε², m².
    #[inline(always)]
    pub(super) fn of(charges: &[Vec4], origins: &[Vec4], first: usize, softening: f32) -> Self {
        let (local, charge) = Vector::of(L::run(charges, first));
        let (origin, _) = Vector::of(L::run(origins, first));
        Self { local, origin, charge, softening: L::splat(softening) }
    }

    /// `s_a s_b d/(‖d‖² + ε²)^{3/2}`, the force of a charge on each target.
    ///
    /// Differences are those of [`Particles::separation`], accurate relative to the charges' own origins. Exchanging the two charges changes exactly the sign
    /// of `d` and nothing else, so action and reaction are bitwise equal. A target that is the source itself gets no force: `d` is zero.
    #[inline(always)]
    pub(super) fn forces_of(&self, source: &Vec4, origin: &Vec4) -> Vector<L> {
        let d = (self.local - Vector::splat(source.truncate()))
            + (self.origin - Vector::splat(origin.truncate()));
        let r2 = (d.length_squared() + self.softening).max(L::splat(NEAR));
        d * (self.charge * L::splat(source.w) / (r2 * r2.sqrt()))
    }

    /// The force of a far group on each target. `place` is the position of the targets in the frame of the group's centre.
    #[inline(always)]
    pub(super) fn forces_of_group(&self, place: Vector<L>, group: &Group) -> Vector<L> {
        let d = place - Vector::splat(group.centre);
        let r2 = (d.length_squared() + self.softening).max(L::splat(NEAR));
        let inverse2 = L::splat(1.0) / r2;
        let strength = (self.charge * inverse2) * (inverse2 * r2.sqrt());
        let dipole = Vector::splat(group.dipole);
        let along = L::splat(group.charge) + L::splat(3.0) * dipole.dot(d) * inverse2;
        (d * along - dipole) * strength
    }
}

/// Adds `sum` to the forces on the eight targets from row `first` on.
#[inline(always)]
pub(super) fn add<L: Lanes>(forces: &mut [Vec4], first: usize, sum: Vector<L>) {
    let (so_far, rest) = Vector::of(L::run(forces, first));
    L::put_run(forces, first, (so_far + sum).with(rest));
}

/// A node of the tree over the charges.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ChargeNode {
    /// Mean position of the charges, weighted by their magnitudes, metres.
    pub centre: DVec3,
    /// Distance of the farthest charge from it, metres; exactly zero where all are at one point.
    pub reach: f64,
    /// Total charge, C.
    pub charge: f64,
    /// Dipole moment about the centre, C·m.
    pub dipole: DVec3,
    /// Centre of the bounding box of the charges, metres; `radius` below is the distance to its corners, metres.
    pub middle: DVec3,
    pub radius: f64,
    /// The first of its leaves; `leaves` below is how many there are.
    pub first: u32,
    pub leaves: u32,
}

impl ChargeNode {
    /// Size of the subtree, this node included.
    #[inline]
    pub(super) fn subtree_len(&self) -> usize {
        2 * self.leaves as usize - 1
    }

    pub(super) fn sum_up(&mut self, items: &[ChargedParticle]) {
        let (mut weight, mut centre) = (0.0, DVec3::ZERO);
        for item in items {
            weight += item.charge.abs();
            centre += (item.at - self.middle) * item.charge.abs();
        }
        self.centre = self.middle;
        if self.radius > 0.0 && weight > 0.0 {
            self.centre += centre / weight;
        }
        let mut reach2 = 0.0_f64;
        for item in items {
            let d = item.at - self.centre;
            self.charge += item.charge;
            self.dipole += d * item.charge;
            reach2 = reach2.max(d.length_squared());
        }
        // Exactly the common point, without the round-off of its mean.
        if self.radius > 0.0 {
            self.reach = reach2.sqrt();
        } else {
            self.centre = items[0].at;
            self.dipole = DVec3::ZERO;
        }
    }

    /// Potential at `point` without Coulomb's constant, C/m. The monopole is reduced by the charge `own`, which is that of the target if the node contains it.
    pub(super) fn potential(&self, point: DVec3, softening: f64, own: f64) -> f64 {
        let d = point - self.centre;
        let s2 = d.length_squared() + softening;
        if s2 == 0.0 {
            return 0.0;
        }
        let s = s2.sqrt();
        (self.charge - own) / s + self.dipole.dot(d) / (s2 * s)
    }
}

/// A far node in the frame of some targets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// Its centre, metres from the middle of the targets.
    pub centre: Vec3,
    pub charge: f32,
    pub dipole: Vec3,
}

impl Group {
    /// `node` relative to `middle`, its charges multiplied by `scale`.
    pub(super) fn of(node: &ChargeNode, middle: DVec3, scale: f64) -> Self {
        Self {
            centre: (node.centre - middle).as_vec3(),
            charge: (node.charge * scale) as f32,
            dipole: (node.dipole * scale).as_vec3(),
        }
    }
}
