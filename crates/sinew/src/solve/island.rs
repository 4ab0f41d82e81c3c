//! One island: particles that constraints connect, solved until they hold or the sweeps are spent, whatever happens elsewhere.

use std::time::Instant;

use super::flock::{Herd, Spot};
use super::item::{Item, Local, Manner};
use super::momentum::Excess;
use super::plan::{Island, Kind, Plan, Task};
use super::rest::Rest;
use super::sums::Sums;
use super::wave::Wave;
use super::world::Machine;
use super::{IslandReport, Order, cascade, jacobi, worst_first};
use crate::collide::{Presses, Touch};
use crate::constraints::{Direction, Pace};
use crate::lanes::Columns;
use crate::particles::Places;

/// What a thread needs while it solves. Scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Room {
    pub(super) local: Local,
    pub(super) columns: Columns,
    items: Vec<Item>,
    asked: jacobi::Asked,
    queue: worst_first::Queue,
    pub(super) herd: Herd,
    /// Of measuring them.
    pub(super) spots: Vec<Spot>,
    /// What is left of a task beside its flocks.
    pub(super) rest: Rest,
    /// Where a large island is meanwhile.
    pub(super) wave: Wave,
    /// Islands whose corrections gave them what has to be taken off again.
    pub(super) excesses: Vec<(u32, Excess)>,
}

impl Room {
    /// Begins with a task.
    pub(super) fn begin(&mut self, task: &Task) {
        self.rest.reset(task);
        self.excesses.clear();
    }
}

/// What solving needs to know, the same for all islands.
#[derive(Clone, Copy)]
pub(crate) struct Common<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) contacts: &'a Touch,
    /// Length of the substep, seconds.
    pub(crate) h: f32,
    /// How much of it a derived velocity is the mean of, seconds.
    pub(crate) lag: f32,
    /// Magnitude of gravity, m/s².
    pub(crate) gravity: f32,
    /// Which substep of the step it is, counted from 0.
    pub(crate) substep: u32,
    pub(crate) machine: Machine<'a>,
}

/// What makes one sweep over an island, and returns the largest error that it found, metres.
pub(super) trait Sweeper {
    fn sweep(&mut self, places: &mut Places, sums: &mut Sums, manner: Manner) -> f32;
}

/// One worker, in whatever order the island asks for.
pub(super) struct InOrder<'a> {
    plan: &'a Plan,
    island: &'a Island,
    room: &'a mut Room,
}

impl<'a> InOrder<'a> {
    pub(super) fn new(plan: &'a Plan, island: &'a Island, room: &'a mut Room) -> Self {
        if island.settings.order != Order::Cascade {
            list_items(plan, island, &mut room.items);
        }
        Self { plan, island, room }
    }
}

impl Sweeper for InOrder<'_> {
    fn sweep(&mut self, places: &mut Places, sums: &mut Sums, manner: Manner) -> f32 {
        let Self { plan, island, room } = self;
        if island.settings.order == Order::Cascade {
            let bundles = island.bundles.clone();
            return cascade::sweep(places, plan, bundles, sums, manner, room);
        }
        let Room { local, items, asked, queue, .. } = *room;
        if island.settings.order == Order::Jacobi {
            return jacobi::sweep(places, plan, sums, island, items, manner, local, asked);
        }
        let tolerance = island.settings.tolerance;
        worst_first::sweep(places, plan, sums, island, items, manner, local, queue, tolerance)
    }
}

/// Solves an island; returns what its corrections gave it and should not have.
///
/// Constraints come first, contacts last: what must not be seen to fail, a foot in the ground, has the last word. A sweep's error is what it
/// *found*, before it corrected it: reaching the tolerance therefore costs no extra pass, and is never claimed too early.
pub(super) fn solve(
    common: Common,
    island: &Island,
    places: &mut Places,
    sums: &mut Sums,
    presses: &mut Presses,
    report: &mut IslandReport,
    mut sweeper: impl Sweeper,
) -> Option<Excess> {
    let Common { plan, h, machine, .. } = common;
    let (settings, rows) = (&island.settings, &plan.members[island.members.clone()]);
    let began = settings.timed.then(Instant::now);
    let mut direction = settings.direction;
    if direction == Direction::StepStart && turns_too_fast(places, plan, island) {
        direction = Direction::Nearest;
        report.fallbacks += 1;
    }
    forget(plan, island, sums);
    let pace = Pace { h, sweeps: settings.max_sweeps };
    let manner = Manner { pace, direction, instructions: machine.instructions };
    let (mut sweeps, mut converged, mut touched) = (0, false, false);
    while sweeps < settings.max_sweeps && !converged {
        let found =
            if island.groups.is_empty() { 0.0 } else { sweeper.sweep(places, sums, manner) };
        let depth = touch(common, places, presses, rows);
        touched |= depth > 0.0;
        sweeps += 1;
        converged = found.max(depth) <= settings.tolerance;
    }
    report.sweeps += sweeps;
    report.most_sweeps = report.most_sweeps.max(sweeps);
    report.last_sweeps = sweeps;
    report.converged &= converged;
    let keeps_angular = direction == Direction::StepStart || settings.keep_spin;
    let free = island.free && !touched;
    let excess = if free { Excess::of(places, rows, h, keeps_angular) } else { None };
    report.seconds += began.map_or(0.0, |began| began.elapsed().as_secs_f64());
    excess
}

/// Starts the multipliers of an island afresh.
fn forget(plan: &Plan, island: &Island, sums: &mut Sums) {
    for group in &plan.groups[island.groups.clone()] {
        match group.kind {
            // Hard rods have none that matter.
            Kind::Rods => {}
            Kind::Distances => sums.of_distances(group.range.clone()).fill(0.0),
            Kind::Constraints => sums.of_constraints(group.range.clone()).fill(0.0),
        }
    }
}

/// Lists the constraints of an island in solving order.
fn list_items(plan: &Plan, island: &Island, items: &mut Vec<Item>) {
    items.clear();
    for group in &plan.groups[island.groups.clone()] {
        items.extend(group.range.clone().map(|n| Item { kind: group.kind, number: n as u32 }));
    }
}

/// cos² of 0.35 rad.
pub(super) const COS_SQUARED: f32 = 0.882_43;

/// Whether a rod of the island turns so far in this substep that the direction that it had at the start says little about the one it needs.
///
/// A bond that turns by θ is corrected along a line that is off by θ, with a gain of 1/cos θ: harmless at 20°, without bound at 90°. And where one
/// bond of an island goes wrong its neighbours follow, so all of it goes back.
fn turns_too_fast(places: &Places, plan: &Plan, island: &Island) -> bool {
    let mut rods = plan.groups[island.groups.clone()]
        .iter()
        .filter(|group| group.kind == Kind::Rods)
        .flat_map(|group| &plan.distances[group.range.clone()]);
    rods.any(|d| {
        let (a, b) = (places.at(d.a), places.at(d.b));
        let now = (places.position[b] - places.position[a]).truncate();
        let start = (places.start[b] - places.start[a]).truncate();
        let along = now.dot(start);
        let squares = now.length_squared() * start.length_squared();
        along < 0.0 || along * along < COS_SQUARED * squares
    })
}

/// Projects some particles out of whatever stands in the world once; returns the deepest it found, metres.
fn touch(common: Common, places: &mut Places, presses: &mut Presses, rows: &[u32]) -> f32 {
    let Common { contacts, substep, .. } = common;
    if contacts.is_empty() {
        return 0.0;
    }
    let depths = rows.iter().map(|&row| contacts.project(places, presses, row, substep));
    depths.fold(0.0, f32::max)
}
