//! Violations are recovered at a bounded speed, whatever kind of constraint is violated.
//!
//! What a hard constraint is violated by when a substep begins, because it was spawned so, or because a contact has pushed harder than it could hold, is
//! corrected by the sweeps like all else; but what is moved by a length in a substep leaves with that length by the time of one. A short rod between particles
//! that were far apart flung them at as much as may be, 500 m/s. Of a constraint that is kept nothing gets faster towards it. So what closes a violation that
//! is older than the substep may do so at the speed at which an overlap is recovered, and no faster: the rest is taken off the velocities of its particles, by
//! the impulse along its gradient that does it, which keeps their momenta.
//!
//! Ragdolls that begin inside of something are flung otherwise: by contacts, which move limbs at up to 10 m/s in their own place and at a multiple of it at
//! their ends. With this alone one of 252 came to 151 m/s, and to 29 where contacts recover by 20 falls; `body_contact` bounds those.
//!
//! It costs where a sweep has met a violation of so much, and nothing elsewhere. Islands that are swept in columns, which are cloth, are left out, and so
//! are those that take microsteps.

use super::constraint_ref::{ConstraintRef, Local, list_constraint_refs};
use super::context::{SolveContext, SubstepParameters};
use super::plan::Plan;
use super::report::IslandReport;
use super::sweep_scratch::SweepScratch;
use crate::collide::recovery;
use crate::constraints::{GradientAt, Points, Solved, solve_equation};
use crate::islands::Island;
use crate::particles::{Particles, Places};

/// Rounds over the violated constraints of an island, each of which may make others faster.
const ROUNDS: u32 = 4;

impl Plan {
    /// Whether the velocities of an island are bounded where it was violated.
    pub(crate) fn bounds_recovery(&self, island: &Island) -> bool {
        let cluster_batches = &self.cluster_batches[island.cluster_batches.clone()];
        !(island.takes_microsteps() || island.is_left_alone() || island.rigid)
            && cluster_batches.iter().all(|cluster_batch| !cluster_batch.has_rods_in_columns())
    }
}

/// Takes off the velocities that an island has after a substep of `h` seconds what recovers violations faster than by `most` metres in it.
fn limit_recovery(
    plan: &Plan,
    island: &Island,
    places: &mut Places,
    (h, most): (f32, f32),
    scratch: &mut SweepScratch,
) {
    let SweepScratch { local, constraint_refs, .. } = scratch;
    list_constraint_refs(plan, island, constraint_refs);
    constraint_refs.retain(|one| {
        one.is_hard(plan) && solved(*one, plan, places, local).is_some_and(|own| most < own.error)
    });
    for _ in 0..ROUNDS {
        let mut changed = false;
        for one in &*constraint_refs {
            let Some(own) = solved(*one, plan, places, local) else { continue };
            let mut pair = [0; 2];
            let rows = one.rows(plan, &mut pair).iter();
            let rates = rows.clone().zip(&local.gradients);
            let velocity = |row: &u32| places.velocity[places.at(*row)].truncate();
            let rate: f32 = rates.map(|(row, by)| by.dot(velocity(row))).sum();
            // A value of so much is a metre.
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
        }
        if !changed {
            break;
        }
    }
}

impl SolveContext<'_> {
    /// Takes off the velocities of the island of a number, when they have been derived, what recovers violations too fast.
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
            limit_recovery(self.plan, island, places, bounds, scratch);
        }
    }
}

/// The same of all islands, after substeps that have been taken phase by phase.
pub(crate) fn limit_all_recoveries(
    particles: &mut Particles,
    plan: &Plan,
    (h, g): (f32, f32),
    reports: &mut [IslandReport],
    scratch: &mut SweepScratch,
) {
    let mut places = Places::all(particles);
    for (island, report) in plan.islands.list.iter().zip(reports) {
        if core::mem::take(&mut report.violated) && plan.bounds_recovery(island) {
            let most = recovery(h, g);
            limit_recovery(plan, island, &mut places, (h, most), scratch);
        }
    }
}

/// The value of a hard constraint where the substep began, if it is violated there; its gradients are those of `local`.
fn solved(one: ConstraintRef, plan: &Plan, places: &Places, local: &mut Local) -> Option<Solved> {
    let mut pair = [0; 2];
    let rows = one.rows(plan, &mut pair);
    local.take(places, rows);
    let Local { starts, gradients, .. } = local;
    let origin = places.origin[places.at(rows[0])];
    let points = Points { now: starts, starts, origin, gradient_at: GradientAt::Current };
    solve_equation(one.equation(plan), &points, gradients)
}
