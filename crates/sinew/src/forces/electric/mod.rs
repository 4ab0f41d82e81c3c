//! Electric forces: between charged particles, and from uniform fields (physics.md F4).
//!
//! Up to [`Electric::all_pairs_up_to`] charges all pairs are summed ([`pairs`]), which conserves momentum. For more charges, far groups act as one ([`tree`]),
//! and momentum is conserved only to the accuracy of that approximation.

mod columns;
mod pairs;
#[cfg(test)]
mod tests;
mod tree;
mod walk;

use glam::Vec3;

use super::Forces;
use super::region::Region;
use crate::lanes::InstructionSet;
use crate::particles::Particles;
use columns::ChargeColumns;

/// Coulomb's law between all charged particles (like charges repel), and a uniform field that acts on all of them.
///
/// Below a distance of a micrometre the force falls to zero in proportion to the distance: charges at one point have no direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Electric {
    /// Coulomb's constant K, N·m²/C². Default 8.987 552e9, that of the vacuum, with which a microcoulomb is a strong charge at game scale.
    pub constant: f32,
    /// Softening length ε, metres (Plummer): the force falls to zero within it instead of growing without bound. Default 0.
    pub softening: f32,
    /// A uniform field everywhere, N/C: the force on a charge is `q E`. Default zero.
    pub field: Vec3,
    /// Up to this many charges all pairs are summed; beyond, far groups act as one. Default 2000.
    ///
    /// The tree is faster from some 1300 on. Up to the default, all pairs take only one or two milliseconds, and conserve momentum to round-off.
    pub all_pairs_up_to: u32,
    /// Opening angle of the tree: how large a group may be, as a share of its distance, to act as one. 0.1 to 1; default 0.45. Smaller values are more accurate
    /// and slower. At the default the error is 0.5 % of the size of the forces (root mean square).
    pub opening: f32,
}

impl Default for Electric {
    fn default() -> Self {
        Self {
            constant: 8.987_552e9,
            softening: 0.0,
            field: Vec3::ZERO,
            all_pairs_up_to: 2000,
            opening: 0.45,
        }
    }
}

impl Electric {
    /// Whether every number is finite and in range. Otherwise there are no forces between charges and none from [`field`](Self::field).
    pub fn is_valid(&self) -> bool {
        self.constant.is_finite()
            && self.softening.is_finite()
            && self.softening >= 0.0
            && self.field.is_finite()
            && (0.1..=1.0).contains(&self.opening)
    }
}

/// A uniform electric field within a region, such as between the plates of a capacitor.
///
/// Where the field fades or ends it has no potential (a real field has fringes there), so a charge that circles in and out may gain energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElectricField {
    /// Force per charge, N/C (equal to V/m). Default zero.
    pub field: Vec3,
    /// Where it acts. Default everywhere.
    pub region: Region,
}

impl ElectricField {
    /// Whether every number is finite and in range. An invalid field does nothing.
    pub fn is_valid(&self) -> bool {
        self.field.is_finite() && self.region.is_valid()
    }
}

/// Scratch of the electric forces; it keeps its allocations between calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct ElectricScratch {
    columns: ChargeColumns,
    tree: tree::ChargeTree,
}

/// Adds the forces of all charges on each other, and of the fields on all charges.
pub(crate) fn apply(
    particles: &mut Particles,
    Forces { electric, electric_fields, .. }: &Forces,
    ElectricScratch { columns, tree }: &mut ElectricScratch,
    instructions: InstructionSet,
) {
    apply_fields(particles, electric, electric_fields);
    if !electric.is_valid() || electric.constant == 0.0 {
        return;
    }
    tree.items.clear();
    tree.items.extend(columns::charged(particles));
    let all_pairs = tree.items.len() <= electric.all_pairs_up_to as usize;
    if !all_pairs {
        tree.build();
    }
    columns.fill(particles, &tree.items, electric.constant);
    let softening = electric.softening * electric.softening;
    if all_pairs {
        pairs::sum(columns, softening, instructions);
    } else {
        tree.sum(columns, electric, instructions);
    }
    let sign = electric.constant.signum();
    for (k, item) in tree.items.iter().enumerate() {
        particles.push_force(item.row as usize, columns.force(k) * sign);
    }
}

fn apply_fields(particles: &mut Particles, electric: &Electric, fields: &[ElectricField]) {
    let everywhere = if electric.is_valid() { electric.field } else { Vec3::ZERO };
    let local = || fields.iter().filter(|f| f.is_valid() && f.field != Vec3::ZERO);
    if everywhere == Vec3::ZERO && local().next().is_none() {
        return;
    }
    for i in 0..particles.len() {
        let charge = particles.charge[i];
        if charge != 0.0 {
            let at = |f: &ElectricField| f.field * f.region.share_of(particles, i);
            let field = local().fold(everywhere, |sum, f| sum + at(f));
            particles.push_force(i, field * charge);
        }
    }
}

/// Potential energy, joules: `Σ K q_a q_b/√(‖d‖² + ε²)` over all pairs, and `-q E·x` (zero at the origin) of the free charges in the fields that fill the
/// world. A field confined to a region is not counted, because it has no potential.
///
/// For many charges the tree is used, as for their forces, so that the energy ledger matches the forces. It costs some three times as much as those.
pub(crate) fn energy(particles: &Particles, forces: &Forces) -> f64 {
    let electric = &forces.electric;
    let mut field = if electric.is_valid() { electric.field.as_dvec3() } else { glam::DVec3::ZERO };
    for other in &forces.electric_fields {
        if other.is_valid() && other.region == Region::default() {
            field += other.field.as_dvec3();
        }
    }
    let in_fields = |i: usize| {
        let x = particles.origin[i].as_dvec3() + particles.position[i].truncate().as_dvec3();
        -f64::from(particles.charge[i]) * field.dot(x)
    };
    let moving = (0..particles.len()).filter(|&i| particles.position[i].w > 0.0);
    let sum: f64 = moving.filter(|&i| particles.charge[i] != 0.0).map(in_fields).sum();
    if electric.is_valid() { sum + between(particles, electric) } else { sum }
}

fn between(particles: &Particles, electric: &Electric) -> f64 {
    let items: Vec<_> = columns::charged(particles).collect();
    let potential = if items.len() <= electric.all_pairs_up_to as usize {
        pairs::potential(&items, electric.softening)
    } else {
        tree::ChargeTree::of(items).potential(electric)
    };
    f64::from(electric.constant) * potential
}
