//! The cascade: constraints enforced one after the other, again and again, until they all hold well enough (Gauss–Seidel).

use core::ops::Range;

use crate::constraints::{Contacts, project, project_rod};
use crate::particles::Particles;
use crate::solve::{Plan, SolverReport, SolverSettings};

/// Sweeps each island until the largest error met in it is within the tolerance, at most `max_sweeps` times; adds to the report.
///
/// Distances come first, colour by colour, contacts last: what must not be seen to fail, a foot in the ground, has the last word. The
/// order never changes from substep to substep, because alternating it pumps energy. A sweep's error is what it *found*, before it
/// corrected it: reaching the tolerance therefore costs no extra pass, and is never claimed too early.
pub(crate) fn cascade(
    particles: &mut Particles,
    contacts: &Contacts,
    plan: &mut Plan,
    settings: &SolverSettings,
    h: f32,
    report: &mut SolverReport,
) {
    plan.lambdas.fill(0.0);
    let compliance_scale = 1.0 / (h * h);
    let mut most = 0;
    for number in 0..plan.islands.len() {
        let island = plan.islands[number].clone();
        let mut converged = false;
        for sweep in 1..=settings.max_sweeps {
            let found = sweep_distances(particles, plan, island.groups.clone(), compliance_scale)
                .max(sweep_contacts(particles, contacts, &plan.members[island.members.clone()]));
            most = most.max(sweep);
            if found <= settings.tolerance {
                converged = true;
                break;
            }
        }
        report.converged &= converged;
    }
    report.sweeps += most;
    report.most_sweeps = report.most_sweeps.max(most);
}

/// Measures what is left, moving nothing: largest error of the hard constraints in metres, and largest strain of the hard distances.
pub(crate) fn measure(
    particles: &Particles,
    contacts: &Contacts,
    plan: &Plan,
    report: &mut SolverReport,
) {
    let (mut error, mut strain) = (0.0_f32, 0.0_f32);
    for distance in plan.distances.iter().filter(|d| d.compliance == 0.0) {
        let (a, b) = (distance.a as usize, distance.b as usize);
        if particles.inverse_mass(a) + particles.inverse_mass(b) == 0.0 {
            continue;
        }
        let left = distance.error(particles.position(a), particles.position(b));
        error = error.max(left);
        if distance.rest > 0.0 {
            strain = strain.max(left / distance.rest);
        }
    }
    report.error = (0..particles.len()).map(|i| contacts.error(particles, i)).fold(error, f32::max);
    report.strain = strain;
}

/// Projects every distance of some groups once and returns the largest error found among the hard ones, metres.
fn sweep_distances(
    particles: &mut Particles,
    plan: &mut Plan,
    groups: Range<usize>,
    compliance_scale: f32,
) -> f32 {
    let positions = particles.position.as_mut_slice();
    let mut worst = 0.0_f32;
    for group in &plan.groups[groups] {
        let distances = &plan.distances[group.range.clone()];
        if group.rods {
            for d in distances {
                worst = worst.max(project_rod(positions, d.a, d.b, d.rest));
            }
            continue;
        }
        for (d, lambda) in distances.iter().zip(&mut plan.lambdas[group.range.clone()]) {
            let scaled = d.compliance * compliance_scale;
            let error = project(positions, d.a, d.b, d.rest, scaled, d.bound, lambda);
            // A soft distance is not meant to be kept, so it does not ask for another sweep.
            if d.compliance == 0.0 {
                worst = worst.max(error);
            }
        }
    }
    worst
}

/// Projects some particles out of every plane and into every box once; returns the deepest it found, metres.
fn sweep_contacts(particles: &mut Particles, contacts: &Contacts, rows: &[u32]) -> f32 {
    if contacts.is_empty() {
        return 0.0;
    }
    rows.iter().map(|&row| contacts.project(particles, row as usize)).fold(0.0, f32::max)
}
