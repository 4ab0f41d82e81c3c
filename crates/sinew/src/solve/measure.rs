//! What is left to correct, for the report.

use super::SolverReport;
use super::island::Room;
use super::item::{constraint_error, distance_error};
use super::plan::{Group, Kind, Plan};
use crate::collide::Touch;
use crate::constraints::Distance;
use crate::lanes::InstructionSet;
use crate::particles::{Particles, Places};

/// Measures what is left, moving nothing: largest error of the hard constraints in metres, and largest strain of the hard distances. Islands that
/// went as a wave have been measured on the way.
pub(crate) fn measure(
    particles: &mut Particles,
    contacts: &Touch,
    plan: &Plan,
    instructions: InstructionSet,
    room: &mut Room,
    report: &mut SolverReport,
) {
    (report.error, report.strain) = (0.0, 0.0);
    let places = Places::all(particles);
    plan.flocks.measure(places.position, &mut room.spots, &mut report.islands, instructions);
    for (island, own) in plan.islands.iter().zip(&mut report.islands) {
        let (mut error, mut strain) = (0.0_f32, 0.0_f32);
        // What broke was put back after it was measured.
        let measured = core::mem::take(&mut own.measured) && report.frozen.is_empty();
        if measured {
            (error, strain) = (own.error, own.strain);
        }
        let bundles = if measured { 0..0 } else { island.bundles.clone() };
        for bundle in &plan.bundles[bundles] {
            let groups = &plan.groups[bundle.groups.clone()];
            if bundle.columns {
                let each = groups.iter().map(Group::rods);
                let rows = bundle.rows.clone();
                let (left, share) =
                    plan.rods.measure_columns(&places, each, rows, &mut room.columns, instructions);
                (error, strain) = (error.max(left), strain.max(share));
                continue;
            }
            for group in groups {
                let range = group.range.clone();
                let laws = group.wide.as_ref().filter(|_| group.kind == Kind::Constraints);
                if let Some(which) = laws {
                    error = error.max(plan.laws.measure(&places, which, instructions));
                    continue;
                }
                let (left, share) = match group.kind {
                    Kind::Rods => {
                        let (runs, blocks) = (group.runs.clone(), group.blocks.clone());
                        plan.rods.measure(places.position, runs, blocks, instructions)
                    }
                    Kind::Distances => distance_errors(&places, &plan.distances[range]),
                    Kind::Constraints => {
                        let each = plan.constraints[range].iter();
                        let errors = each.map(|c| constraint_error(&places, c, &mut room.local));
                        (errors.fold(0.0, f32::max), 0.0)
                    }
                };
                (error, strain) = (error.max(left), strain.max(share));
            }
        }
        if !contacts.is_empty() {
            let rows = plan.members[island.members.clone()].iter();
            let deepest = rows.map(|&row| contacts.error(&places, row));
            error = deepest.fold(error, f32::max);
        }
        (own.error, own.strain) = (error, strain);
        report.error = report.error.max(error);
        report.strain = report.strain.max(strain);
    }
}

/// The largest error of some distances, metres, and the largest share of a rest length.
fn distance_errors(places: &Places, distances: &[Distance]) -> (f32, f32) {
    let (mut error, mut strain) = (0.0_f32, 0.0_f32);
    for d in distances {
        let left = distance_error(places, d);
        error = error.max(left);
        strain = if d.rest > 0.0 { strain.max(left / d.rest) } else { strain };
    }
    (error, strain)
}
