//! Measures the remaining errors, for the report.

use super::constraint_ref::{constraint_error, distance_error};
use super::lane_particles::LaneParticles;
use super::plan::{ConstraintGroup, GroupKind, Plan};
use super::report::SolverReport;
use super::sweep_scratch::SweepScratch;
use crate::collide::ParticleContacts;
use crate::constraints::Distance;
use crate::islands::Islands;
use crate::lanes::InstructionSet;
use crate::particles::{Particles, Places};

/// Measures without moving anything: the largest error of the hard constraints, metres, and the largest strain of the hard distances. Islands that were solved
/// as a wavefront have been measured already.
pub(crate) fn measure(
    particles: &mut Particles,
    contacts: &ParticleContacts,
    plan: &Plan,
    instructions: InstructionSet,
    (sweep_scratch, lane_particles): (&mut SweepScratch, &mut Vec<LaneParticles>),
    report: &mut SolverReport,
) {
    (report.error, report.strain) = (0.0, 0.0);
    report.converged &= report.islands.iter().all(|island| island.converged);
    // A rigid state has no constraint errors.
    for (island, own) in plan.islands.list.iter().zip(&mut report.islands) {
        own.measured |= island.is_rigid_state;
    }
    let mut places = Places::all(particles);
    plan.instance_batches.measure(
        places.position,
        lane_particles,
        &mut report.islands,
        instructions,
    );
    for (number, (island, own)) in plan.islands.list.iter().zip(&mut report.islands).enumerate() {
        let (mut error, mut strain) = (0.0_f32, 0.0_f32);
        // Frozen particles were put back after that measurement, so it no longer holds.
        let measured = core::mem::take(&mut own.measured) && report.frozen.is_empty();
        if measured {
            (error, strain) = (own.error, own.strain);
        }
        let cluster_batches = if measured { 0..0 } else { island.cluster_batches.clone() };
        for cluster_batch in &plan.cluster_batches[cluster_batches] {
            let groups = &plan.groups[cluster_batch.groups.clone()];
            if cluster_batch.columns && cluster_batch.kind == GroupKind::Distances {
                // Compliant distances have no error.
                continue;
            }
            if cluster_batch.columns {
                let each = groups.iter().map(ConstraintGroup::rods);
                let rows = cluster_batch.rows.clone();
                let (left, share) = plan.rods.measure_columns(
                    &places,
                    each,
                    rows,
                    &mut sweep_scratch.columns,
                    instructions,
                );
                (error, strain) = (error.max(left), strain.max(share));
                continue;
            }
            for group in groups {
                let range = group.range.clone();
                let constraint_batches =
                    group.wide.as_ref().filter(|_| group.kind == GroupKind::Constraints);
                if let Some(which) = constraint_batches {
                    error = error.max(plan.constraint_batches.measure(
                        &mut places,
                        which,
                        instructions,
                    ));
                    continue;
                }
                let (left, share) = match group.kind {
                    GroupKind::Rods => {
                        let (runs, blocks) = (group.runs.clone(), group.blocks.clone());
                        plan.rods.measure(places.position, runs, blocks, instructions)
                    }
                    GroupKind::Distances => distance_errors(&places, &plan.distances[range]),
                    GroupKind::Constraints => {
                        let each = plan.constraints[range].iter();
                        let errors =
                            each.map(|c| constraint_error(&places, c, &mut sweep_scratch.local));
                        (errors.fold(0.0, f32::max), 0.0)
                    }
                };
                (error, strain) = (error.max(left), strain.max(share));
            }
        }
        // The particles of a rigid state do not touch anything by themselves.
        if !contacts.is_empty() && !island.is_rigid_state {
            let rows = &plan.islands.members[island.members.clone()];
            error = error.max(contacts.island_error(&places, (number, rows), instructions));
        }
        (own.error, own.strain) = (error, strain);
        report.error = report.error.max(error);
        report.strain = report.strain.max(strain);
    }
}

/// The largest error of some distances, metres, and the largest error as a share of the rest length.
fn distance_errors(places: &Places, distances: &[Distance]) -> (f32, f32) {
    let (mut error, mut strain) = (0.0_f32, 0.0_f32);
    for d in distances {
        let left = distance_error(places, d);
        error = error.max(left);
        strain = if d.rest > 0.0 { strain.max(left / d.rest) } else { strain };
    }
    (error, strain)
}

/// Adds the penetrations of body colliders into each other and into static geometry, metres, each given with a row of the body. An island with a penetration
/// above its tolerance has not converged.
pub(crate) fn measure_overlaps(
    overlaps: impl Iterator<Item = (u32, f32)>,
    islands: &Islands,
    report: &mut SolverReport,
) {
    for (row, left) in overlaps {
        let Some(&number) = islands.of.get(row as usize) else { continue };
        let island = &mut report.islands[number as usize];
        island.error = island.error.max(left);
        island.converged &= left <= islands.list[number as usize].settings.tolerance;
        report.error = report.error.max(left);
        report.converged &= island.converged;
    }
}
