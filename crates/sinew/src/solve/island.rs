//! One island: particles that constraints connect, solved until they hold or the sweeps are spent, whatever happens elsewhere.

use std::time::Instant;

use super::item::{Item, Local, Manner, constraint_error, distance_error};
use super::momentum::Momenta;
use super::plan::{Island, Kind, Plan};
use super::rods::Columns;
use super::{Order, SolverReport, cascade, jacobi, worst_first};
use crate::constraints::{Contacts, Direction, Distance, Pace};
use crate::lanes::{InstructionSet, Lanes, Work, with};
use crate::particles::{Particles, Places};

/// What solving needs and nobody saves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    local: Local,
    items: Vec<Item>,
    asked: jacobi::Asked,
    queue: worst_first::Queue,
    columns: Columns,
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
    instructions: InstructionSet,
    scratch: &mut Scratch,
    report: &mut SolverReport,
) {
    forget_multipliers(plan);
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
        let places = Places::all(particles);
        let work = Solve { places, contacts, plan, island: &island, manner, scratch };
        let Solved { sweeps, converged, touched } = with(instructions, work);
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

/// Starts the sums of a substep afresh; hard rods have none.
fn forget_multipliers(plan: &mut Plan) {
    let Plan { bundles, groups, lambdas, multipliers, .. } = plan;
    for bundle in bundles {
        let all = &groups[bundle.groups.clone()];
        let (Some(first), Some(last)) = (all.first(), all.last()) else { continue };
        let range = first.range.start..last.range.end;
        match first.kind {
            Kind::Rods => {}
            Kind::Distances => lambdas[range].fill(0.0),
            Kind::Constraints => multipliers[range].fill(0.0),
        }
    }
}

/// Takes from islands that nothing outside holds the momentum that round-off gave them. To be called when velocities have been derived.
pub(crate) fn keep_momentum(particles: &mut Particles, plan: &Plan, scratch: &Scratch) {
    for (island, before) in plan.islands.iter().zip(&scratch.free) {
        if let Some(before) = before {
            before.restore(particles, plan, island);
        }
    }
}

/// One island to be swept.
struct Solve<'a> {
    places: Places<'a>,
    contacts: &'a Contacts,
    plan: &'a mut Plan,
    island: &'a Island,
    manner: Manner,
    scratch: &'a mut Scratch,
}

/// How that went.
struct Solved {
    sweeps: u32,
    /// Whether it met its tolerance.
    converged: bool,
    /// Whether it touched anything.
    touched: bool,
}

impl Work for Solve<'_> {
    type Output = Solved;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Solved {
        let Self { mut places, contacts, plan, island, manner, scratch } = self;
        let Scratch { local, items, asked, queue, columns, .. } = scratch;
        let (places, settings) = (&mut places, &island.settings);
        if settings.order != Order::Cascade {
            list_items(plan, island, items);
        }
        let mut touched = false;
        for sweep in 1..=settings.max_sweeps {
            let found = match settings.order {
                Order::Cascade => cascade::sweep::<L>(places, plan, island, manner, local, columns),
                Order::Jacobi => jacobi::sweep(places, plan, island, items, manner, local, asked),
                Order::WorstFirst => {
                    let tolerance = settings.tolerance;
                    worst_first::sweep(places, plan, island, items, manner, local, queue, tolerance)
                }
            };
            let depth = touch(places, contacts, &plan.members[island.members.clone()]);
            touched |= depth > 0.0;
            if found.max(depth) <= settings.tolerance {
                return Solved { sweeps: sweep, converged: true, touched };
            }
        }
        Solved { sweeps: settings.max_sweeps, converged: false, touched }
    }
}

/// Measures what is left, moving nothing: largest error of the hard constraints in metres, and largest strain of the hard distances.
pub(crate) fn measure(
    particles: &mut Particles,
    contacts: &Contacts,
    plan: &Plan,
    instructions: InstructionSet,
    scratch: &mut Scratch,
    report: &mut SolverReport,
) {
    (report.error, report.strain) = (0.0, 0.0);
    let (places, local) = (Places::all(particles), &mut scratch.local);
    with(instructions, Measure { places, contacts, plan, local, report });
}

struct Measure<'a> {
    places: Places<'a>,
    contacts: &'a Contacts,
    plan: &'a Plan,
    local: &'a mut Local,
    report: &'a mut SolverReport,
}

impl Work for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { places, contacts, plan, local, report } = self;
        for (island, own) in plan.islands.iter().zip(&mut report.islands) {
            let (mut error, mut strain) = (0.0_f32, 0.0_f32);
            for group in &plan.groups[island.groups.clone()] {
                let range = group.range.clone();
                let (left, share) = match group.kind {
                    Kind::Rods => {
                        let (runs, blocks) = (group.runs.clone(), group.blocks.clone());
                        plan.rods.measure::<L>(places.position, runs, blocks)
                    }
                    Kind::Distances => distance_errors(&places, &plan.distances[range]),
                    Kind::Constraints => {
                        let each = plan.constraints[range].iter();
                        let errors = each.map(|c| constraint_error(&places, c, local));
                        (errors.fold(0.0, f32::max), 0.0)
                    }
                };
                (error, strain) = (error.max(left), strain.max(share));
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
                let start = (starts[b] - starts[a]).truncate();
                let along = now.dot(start);
                let squares = now.length_squared() * start.length_squared();
                along < 0.0 || along * along < COS_SQUARED * squares
            })
        },
    )
}

/// Projects some particles out of every plane and into every box once; returns the deepest it found, metres.
fn touch(places: &mut Places, contacts: &Contacts, rows: &[u32]) -> f32 {
    if contacts.is_empty() {
        return 0.0;
    }
    rows.iter().map(|&row| contacts.project(places, row)).fold(0.0, f32::max)
}
