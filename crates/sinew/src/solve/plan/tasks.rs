//! Tasks: islands distributed to threads. Each task has ranges of rows and of constraints that no other task has.

use core::ops::Range;

use super::Plan;
use crate::lanes::LANES;
use crate::threads::TASKS;

/// Consecutive islands, solved one after the other by one thread.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Task {
    pub(crate) islands: Range<usize>,
    /// All rows of these islands, and of no others.
    pub(crate) rows: Range<u32>,
    /// Their ranges among the plan's distances and constraints.
    pub(crate) distances: Range<usize>,
    pub(crate) constraints: Range<usize>,
    /// Range of its instance batches in the plan.
    pub(crate) instance_batches: Range<usize>,
    /// Whether it is a single island that is worth being divided into clusters for several threads.
    pub(crate) large: bool,
}

impl Plan {
    /// The tasks for a single worker (`alone`), or for several. A single worker gains nothing from many tasks: where a task boundary separates bodies of the
    /// same topology, the two tasks are merged, so that the bodies make larger [instance batches](super::instance_batches).
    pub(crate) fn tasks(&self, alone: bool) -> impl Iterator<Item = Task> {
        let joins = move |one: &Task, next: &Task| {
            alone
                && self
                    .instance_batches
                    .have_same_topology(one.instance_batches.clone(), next.instance_batches.clone())
        };
        self.tasks.chunk_by(joins).filter_map(|tasks| Some(tasks.first()?.to(tasks.last()?)))
    }
}

impl Task {
    /// The task from this one to `last`, inclusive.
    fn to(&self, last: &Self) -> Self {
        Self {
            islands: self.islands.start..last.islands.end,
            rows: self.rows.start..last.rows.end,
            distances: self.distances.start..last.distances.end,
            constraints: self.constraints.start..last.constraints.end,
            instance_batches: self.instance_batches.start..last.instance_batches.end,
            large: self.large,
        }
    }
}

/// Least number of constraints of a large island. Solving them takes about ten times as long as it takes to hand work to a thread.
const LARGE_ISLAND: usize = 16_384;

/// Least work of a task that is handed to a thread, in particles: about 30 µs.
const MIN_WORK: usize = 8192;

/// Divides a plan into tasks of about equal work. Islands whose rows interleave go into the same task.
pub(super) fn cut(plan: &Plan) -> Vec<Task> {
    let mut tasks: Vec<Task> = Vec::new();
    let work =
        |task: &Task| task.rows.len() + 4 * (task.distances.len() + 4 * task.constraints.len());
    let all = plan.rows + 4 * (plan.distances.len() + 4 * plan.constraints.len());
    let share = (all / TASKS).max(MIN_WORK);
    // End of the rows of all islands so far.
    let mut reach = 0;
    let (mut distance, mut constraint) = (0, 0);
    for (number, island) in plan.islands.list.iter().enumerate() {
        let members = &plan.islands.members[island.members.clone()];
        let (Some(&first), Some(&last)) = (members.first(), members.last()) else { continue };
        let (distances, constraints) = (distance, constraint);
        for group in &plan.groups[island.groups.clone()] {
            match group.kind {
                super::GroupKind::Constraints => constraint += group.range.len(),
                _ => distance += group.range.len(),
            }
        }
        let large = distance - distances + constraint - constraints >= LARGE_ISLAND
            && members.len() == (last - first) as usize + 1;
        // Small islands are dealt out in eights, the size of an instance batch.
        let whole = |task: &Task| task.islands.len().is_multiple_of(LANES) || !island.is_small();
        let full = |task: &Task| task.large || large || (work(task) >= share && whole(task));
        let begin = match tasks.last() {
            None => true,
            Some(task) => first >= reach && full(task) && tasks.len() < TASKS,
        };
        if begin {
            tasks.push(Task {
                islands: number..number,
                rows: first..first,
                distances: distances..distances,
                constraints: constraints..constraints,
                instance_batches: 0..0,
                large: false,
            });
        }
        reach = reach.max(last + 1);
        if let Some(task) = tasks.last_mut() {
            task.islands.end = number + 1;
            task.rows.end = reach;
            (task.distances.end, task.constraints.end) = (distance, constraint);
            task.large = large && task.islands.len() == 1;
        }
    }
    tasks
}
