//! Jacobi: every constraint is projected from the same positions, and each particle moves by the mean of its constraints' corrections.
//!
//! Plain averaging loses momentum where two particles have different numbers of constraints. So the mass of a particle is first split among its n constraints
//! (Tonge et al., *Mass splitting for jitter-free parallel rigid body simulation*, 2012): each uses the inverse mass `n w`, and the mean of the n corrections
//! keeps the barycentre of every constraint where it was.

use glam::Vec3;

use super::constraint_ref::{ConstraintRef, Local, SolveMode};
use super::multipliers::MultiplierSlice;
use super::plan::Plan;
use crate::islands::Island;
use crate::particles::Places;

/// The sum and the number of the corrections of each particle. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Corrections {
    sum: Vec<Vec3>,
    count: Vec<u32>,
}

/// Projects every constraint of an island once, from the same positions. Returns the largest error found, metres; for compliant ones the largest correction.
pub(super) fn sweep(
    places: &mut Places,
    plan: &Plan,
    island: &Island,
    multipliers: &mut MultiplierSlice,
    mode: SolveMode,
    (local, constraint_refs): (&mut Local, &[ConstraintRef]),
    corrections: &mut Corrections,
) -> f32 {
    corrections.sum.resize(plan.rows, Vec3::ZERO);
    corrections.count.resize(plan.rows, 0);
    let members = &plan.islands.members[island.members.clone()];
    for &row in members {
        corrections.sum[row as usize] = Vec3::ZERO;
        corrections.count[row as usize] = 0;
    }
    let mut pair = [0; 2];
    for constraint in constraint_refs {
        for &row in constraint.rows(plan, &mut pair) {
            corrections.count[row as usize] += 1;
        }
    }
    let mut worst = 0.0_f32;
    for constraint in constraint_refs {
        let rows = constraint.rows(plan, &mut pair);
        local.take(places, rows);
        for (point, &row) in local.now.iter_mut().zip(rows) {
            point.w *= corrections.count[row as usize] as f32;
        }
        let origin = places.origin[places.at(rows[0])];
        worst = worst.max(constraint.project_local(plan, multipliers, mode, origin, local));
        for (point, &row) in local.now.iter().zip(rows) {
            let moved = point.truncate() - places.position[places.at(row)].truncate();
            corrections.sum[row as usize] += moved;
        }
    }
    for &row in members {
        let count = corrections.count[row as usize];
        if count > 0 {
            places.displace(row, corrections.sum[row as usize] / count as f32);
        }
    }
    worst
}
