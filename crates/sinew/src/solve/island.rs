//! One island: particles that constraints connect, solved until they hold or the sweeps are spent, whatever happens elsewhere.

use std::time::Instant;

use super::item::{Item, Local, Manner, constraint_error, distance_error};
use super::momentum::Momenta;
use super::plan::{Island, Kind, Plan};
use super::{Order, SolverReport, cascade, jacobi, worst_first};
use crate::constraints::{Contacts, Direction, Pace};
use crate::particles::Particles;

/// What solving needs and nobody saves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    local: Local,
    items: Vec<Item>,
    asked: jacobi::Asked,
    queue: worst_first::Queue,
    /// The momenta that each island is to keep, if nothing outside acts on it through a constraint.
    free: Vec<Option<Momenta>>,
}

/// Sweeps each island until the largest error met in it is within its tolerance, at most `max_sweeps` times; adds to the report.
///
/// Constraints come first, contacts last: what must not be seen to fail, a foot in the ground, has the last word. A sweep's error is what it
/// *found*, before it corrected it: reaching the tolerance therefore costs no extra pass, and is never claimed too early.
pub(crate) fn solve(
    particles: &mut Particles,
    contacts: &Contacts,
    plan: &mut Plan,
    h: f32,
    scratch: &mut Scratch,
    report: &mut SolverReport,
) {
    plan.lambdas.fill(0.0);
    plan.multipliers.fill(0.0);
    let mut most = 0;
    scratch.free.clear();
    for number in 0..plan.islands.len() {
        let island = plan.islands[number].clone();
        let began = island.settings.timed.then(Instant::now);
        let mut direction = island.settings.direction;
        if direction == Direction::StepStart && turns_too_fast(particles, plan, &island) {
            direction = Direction::Nearest;
            report.islands[number].fallbacks += 1;
        }
        let pace = Pace { h, sweeps: island.settings.max_sweeps };
        let manner = Manner { pace, direction };
        let free = Momenta::to_keep(particles, plan, &island, direction);
        let (sweeps, converged, touched) =
            solve_one(particles, contacts, plan, &island, manner, scratch);
        scratch.free.push(free.filter(|_| !touched));
        most = most.max(sweeps);
        report.converged &= converged;
        let own = &mut report.islands[number];
        own.sweeps += sweeps;
        own.converged &= converged;
        own.seconds += began.map_or(0.0, |began| began.elapsed().as_secs_f64());
    }
    report.sweeps += most;
    report.most_sweeps = report.most_sweeps.max(most);
}

/// Takes from islands that nothing outside holds the momentum that round-off gave them. To be called when velocities have been derived.
pub(crate) fn keep_momentum(particles: &mut Particles, plan: &Plan, scratch: &Scratch) {
    for (island, before) in plan.islands.iter().zip(&scratch.free) {
        if let Some(before) = before {
            before.restore(particles, plan, island);
        }
    }
}

/// Sweeps one island; returns how often, whether it met its tolerance, and whether it touched anything.
fn solve_one(
    particles: &mut Particles,
    contacts: &Contacts,
    plan: &mut Plan,
    island: &Island,
    manner: Manner,
    scratch: &mut Scratch,
) -> (u32, bool, bool) {
    let Scratch { local, items, asked, queue, .. } = scratch;
    let settings = &island.settings;
    if settings.order != Order::Cascade {
        list_items(plan, island, items);
    }
    let mut touched = false;
    for sweep in 1..=settings.max_sweeps {
        let found = match settings.order {
            Order::Cascade => cascade::sweep(particles, plan, island, manner, local),
            Order::Jacobi => jacobi::sweep(particles, plan, island, items, manner, local, asked),
            Order::WorstFirst => {
                let tolerance = settings.tolerance;
                worst_first::sweep(particles, plan, island, items, manner, local, queue, tolerance)
            }
        };
        let depth = touch(particles, contacts, &plan.members[island.members.clone()]);
        touched |= depth > 0.0;
        if found.max(depth) <= settings.tolerance {
            return (sweep, true, touched);
        }
    }
    (settings.max_sweeps, false, touched)
}

/// Measures what is left, moving nothing: largest error of the hard constraints in metres, and largest strain of the hard distances.
pub(crate) fn measure(
    particles: &Particles,
    contacts: &Contacts,
    plan: &Plan,
    scratch: &mut Scratch,
    report: &mut SolverReport,
) {
    let local = &mut scratch.local;
    (report.error, report.strain) = (0.0, 0.0);
    for (island, own) in plan.islands.iter().zip(&mut report.islands) {
        let (mut error, mut strain) = (0.0_f32, 0.0_f32);
        for group in &plan.groups[island.groups.clone()] {
            if group.kind == Kind::Constraints {
                let constraints = plan.constraints[group.range.clone()].iter();
                error = constraints
                    .map(|c| constraint_error(particles, c, local))
                    .fold(error, f32::max);
                continue;
            }
            for d in &plan.distances[group.range.clone()] {
                let left = distance_error(particles, d);
                error = error.max(left);
                strain = if d.rest > 0.0 { strain.max(left / d.rest) } else { strain };
            }
        }
        if !contacts.is_empty() {
            let rows = &plan.members[island.members.clone()];
            let deepest = rows.iter().map(|&row| contacts.error(particles, row as usize));
            error = deepest.fold(error, f32::max);
        }
        (own.error, own.strain) = (error, strain);
        report.error = report.error.max(error);
        report.strain = report.strain.max(strain);
    }
}

/// Lists the constraints of an island in solving order.
fn list_items(plan: &Plan, island: &Island, items: &mut Vec<Item>) {
    items.clear();
    for group in &plan.groups[island.groups.clone()] {
        items.extend(group.range.clone().map(|n| Item { kind: group.kind, number: n as u32 }));
    }
}

/// Whether a rod of the island turns so far in this substep that the direction that it had at the start says little about the one it needs.
///
/// A bond that turns by θ is corrected along a line that is off by θ, with a gain of 1/cos θ: harmless at 20°, without bound at 90°. And where one
/// bond of an island goes wrong its neighbours follow, so all of it goes back.
fn turns_too_fast(particles: &Particles, plan: &Plan, island: &Island) -> bool {
    /// cos² of 0.35 rad.
    const COS_SQUARED: f32 = 0.882_43;
    let (positions, starts) = (&particles.position, &particles.start);
    plan.groups[island.groups.clone()].iter().filter(|group| group.kind == Kind::Rods).any(
        |group| {
            plan.distances[group.range.clone()].iter().any(|d| {
                let (a, b) = (d.a as usize, d.b as usize);
                let now = (positions[b] - positions[a]).truncate();
                let start = starts[b] - starts[a];
                let along = now.dot(start);
                let squares = now.length_squared() * start.length_squared();
                along < 0.0 || along * along < COS_SQUARED * squares
            })
        },
    )
}

/// Projects some particles out of every plane and into every box once; returns the deepest it found, metres.
fn touch(particles: &mut Particles, contacts: &Contacts, rows: &[u32]) -> f32 {
    if contacts.is_empty() {
        return 0.0;
    }
    rows.iter().map(|&row| contacts.project(particles, row as usize)).fold(0.0, f32::max)
}
