//! Violations are recovered at a bounded speed, whatever kind of constraint is violated.
//!
//! A hard constraint may be violated at the start of a substep because it was spawned so, or because a contact has pushed harder than it could hold. The sweeps
//! correct that like any other error, but what is moved by a length in a substep gets the velocity of that length over the substep: a short rod between
//! particles far apart flung them at the speed limit, 500 m/s. A satisfied constraint never accelerates particles towards itself. So a violation that is older
//! than the substep may close at the speed at which a penetration is recovered, and no faster. The excess is removed from the velocities of its particles by an
//! impulse along its gradient, which conserves their momenta.
//!
//! Ragdolls that are spawned inside of something are flung by contacts instead, which move limbs at up to 10 m/s at the contact and at a multiple of that at
//! their ends. With this file alone one of 252 reached 151 m/s, and 29 m/s when contacts recovered at most 20 times what gravity adds in a substep;
//! `body_contact` bounds those.
//!
//! It costs time only where a sweep has found a violation of that size. Islands with rods in columns (cloth) and islands that take microsteps are left out.

use glam::Vec3;

use super::constraint_ref::{ConstraintRef, Local, list_constraint_refs};
use super::context::{SolveContext, SubstepParameters};
use super::loads::Loads;
use super::plan::Plan;
use super::report::IslandReport;
use super::sweep_scratch::SweepScratch;
use crate::collide::recovery;
use crate::constraints::{GradientAt, Points, Solved, solve_equation};
use crate::islands::Island;
use crate::particles::{Particles, Places};

/// Rounds over the violated constraints of an island; slowing one down may speed others up.
const ROUNDS: u32 = 4;

impl Plan {
    /// Whether the velocities of an island are bounded after a violation.
    pub(crate) fn bounds_recovery(&self, island: &Island) -> bool {
        let cluster_batches = &self.cluster_batches[island.cluster_batches.clone()];
        !(island.takes_microsteps() || island.is_skipped() || island.rigid)
            && cluster_batches.iter().all(|cluster_batch| !cluster_batch.has_rods_in_columns())
    }
}

/// Removes from the velocities of an island, after a substep of `h` seconds, what recovers violations by more than `most` metres in a substep. `slowed` is called
/// with each constraint that removes some, its gradients, and the impulse along them, N·s.
fn limit_recovery(
    plan: &Plan,
    island: &Island,
    places: &mut Places,
    (h, most): (f32, f32),
    scratch: &mut SweepScratch,
    mut slowed: impl FnMut(&Places, ConstraintRef, &[Vec3], f32),
) {
    let SweepScratch { local, constraint_refs, .. } = scratch;
    list_constraint_refs(plan, island, constraint_refs);
    constraint_refs.retain(|one| {
        one.is_hard(plan) && solved(*one, plan, places, local).is_some_and(|own| most < own.error)
    });
    for _ in 0..ROUNDS {
        let mut changed = false;
        for &one in &*constraint_refs {
            let Some(own) = solved(one, plan, places, local) else { continue };
            let mut pair = [0; 2];
            let rows = one.rows(plan, &mut pair).iter();
            let rates = rows.clone().zip(&local.gradients);
            let velocity = |row: &u32| places.velocity[places.at(*row)].truncate();
            let rate: f32 = rates.map(|(row, by)| by.dot(velocity(row))).sum();
            // Converts an error in metres to a value.
            let unit = own.value.abs() / own.error;
            let excess = -rate * own.value.signum() - most / h * unit;
            if excess.is_nan() || excess <= 0.0 {
                continue;
            }
            changed = true;
            let change = excess * own.value.signum() / own.weights;
            for (row, by) in rows.zip(&local.gradients) {
                let i = places.at(*row);
                let w = places.position[i].w;
                places.velocity[i] += (*by * (w * change)).extend(0.0);
            }
            slowed(places, one, &local.gradients, change);
        }
        if !changed {
            break;
        }
    }
}

impl SolveContext<'_> {
    /// Removes from the derived velocities of island `number` what recovers violations too fast.
    pub(super) fn limit_recovery(
        &self,
        number: usize,
        places: &mut Places,
        report: &mut IslandReport,
        scratch: &mut SweepScratch,
    ) {
        let island = &self.plan.islands.list[number];
        if core::mem::take(&mut report.violated) && self.plan.bounds_recovery(island) {
            let SubstepParameters { h, gravity, .. } = self.substep;
            let bounds = (h, recovery(h, gravity));
            // Loads are measured phase by phase alone.
            limit_recovery(self.plan, island, places, bounds, scratch, |_, _, _, _| {});
        }
    }
}

/// The same for all islands, after substeps that were taken phase by phase. What it removes is part of the measured loads.
pub(crate) fn limit_all_recoveries(
    particles: &mut Particles,
    plan: &Plan,
    (h, g): (f32, f32),
    reports: &mut [IslandReport],
    (scratch, loads): (&mut SweepScratch, &mut Loads),
) {
    let mut places = Places::all(particles);
    for (island, report) in plan.islands.list.iter().zip(reports) {
        if core::mem::take(&mut report.violated) && plan.bounds_recovery(island) {
            let most = recovery(h, g);
            let measured = island.measured;
            let slowed = |places: &Places, one, gradients: &[Vec3], impulse: f32| {
                if measured {
                    loads.add_impulse((plan, places), one, gradients, impulse * h);
                }
            };
            limit_recovery(plan, island, &mut places, (h, most), scratch, slowed);
        }
    }
}

/// Evaluates a hard constraint at the start of the substep; `None` if it was satisfied there. Writes its gradients to `local`.
fn solved(one: ConstraintRef, plan: &Plan, places: &Places, local: &mut Local) -> Option<Solved> {
    let mut pair = [0; 2];
    let rows = one.rows(plan, &mut pair);
    local.take(places, rows);
    let Local { starts, gradients, .. } = local;
    let origin = places.origin[places.at(rows[0])];
    let points = Points { now: starts, starts, origin, gradient_at: GradientAt::Current };
    solve_equation(one.equation(plan), &points, gradients)
}
