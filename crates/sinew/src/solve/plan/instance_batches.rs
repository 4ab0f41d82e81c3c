//! Instance batches of a plan: consecutive islands of the same topology, found at compilation. For how they are solved see
//! [`instances`](crate::solve::instances).

use core::ops::Range;

use super::{ConstraintGroup, GroupKind, Plan, Task};
use crate::constraints::{Constraint, Distance};
use crate::islands::{Island, SMALL_ISLAND};
use crate::lanes::LANES;
use crate::solve::chains::LONG;
use crate::solve::rods::ends;
use crate::solve::wide::{InstancedConstraints, InstancedGroup, InstancedGroups};

// A body solved in a batch has to give the same bits as when solved alone.
const _: () = assert!(SMALL_ISLAND <= LONG);

/// Fewest islands of a batch. A batch costs as much as two or three of its bodies solved alone, and less where it is solved together with other batches.
const MIN_ISLANDS: usize = 3;

/// The instance batches of a plan.
#[derive(Clone, Debug, Default)]
pub(crate) struct InstanceBatches {
    pub(in crate::solve) all: Vec<InstanceBatch>,
    pub(in crate::solve) parts: Vec<InstancePart>,
    pub(in crate::solve) rods: Vec<InstancedRod>,
    pub(in crate::solve) chains: Vec<Range<usize>>,
    pub(in crate::solve) links: Vec<InstancedLink>,
    pub(in crate::solve) instanced: InstancedConstraints,
}

/// Up to eight consecutive islands that have the same constraints, with contiguous rows. Fewer than [`MIN_ISLANDS`] only where they continue identical ones of
/// the last batch.
#[derive(Clone, Debug)]
pub(in crate::solve) struct InstanceBatch {
    pub(in crate::solve) islands: Range<usize>,
    /// The first row of the first island, and the number of rows of each.
    pub(in crate::solve) first: u32,
    pub(in crate::solve) members: u32,
    /// The parts of a sweep, in its order.
    pub(in crate::solve) parts: Range<usize>,
    /// The chains with which a sweep begins.
    pub(in crate::solve) chains: Range<usize>,
    /// Number of constraints that may accumulate a multiplier.
    pub(in crate::solve) multipliers: usize,
    /// Bodies of batches with the same number are identical, lengths and angles included. `None` if the bodies of this batch differ.
    topology: Option<usize>,
}

/// Constraints of one kind that a sweep solves one after the other.
#[derive(Clone, Debug)]
pub(in crate::solve) enum InstancePart {
    /// Range in the instance batches' rods.
    Rods(Range<usize>),
    Constraints(InstancedGroup),
}

/// A hard rod of each of eight bodies, between particles of the same member indices.
#[derive(Clone, Copy, Debug)]
pub(in crate::solve) struct InstancedRod {
    pub(in crate::solve) a: u32,
    pub(in crate::solve) b: u32,
    pub(in crate::solve) rest: [f32; LANES],
}

/// A chain link of each of eight bodies, between particles of the same member indices.
#[derive(Clone, Copy, Debug)]
pub(in crate::solve) struct InstancedLink {
    /// Member indices of both particles; the same twice where there is only one.
    pub(in crate::solve) at: [u32; 2],
    pub(in crate::solve) rest: [f32; LANES],
}

impl InstanceBatches {
    /// Whether the last of some instance batches and the first of others have identical bodies.
    pub(crate) fn have_same_topology(&self, some: Range<usize>, others: Range<usize>) -> bool {
        match (self.all[some].last(), self.all[others].first()) {
            (Some(last), Some(first)) => last.has_same_topology(first),
            _ => false,
        }
    }
}

impl InstanceBatch {
    /// All rows of its bodies.
    pub(in crate::solve) fn rows(&self) -> Range<u32> {
        self.first..self.first + self.islands.len() as u32 * self.members
    }

    /// Whether solving `bodies` of its bodies in the batch is cheaper than solving them alone.
    pub(in crate::solve) fn is_worthwhile(&self, bodies: usize) -> bool {
        // Identical bodies are compacted with those of other batches.
        bodies >= if self.topology.is_some() { 1 } else { MIN_ISLANDS.min(self.islands.len()) }
    }

    /// Whether the bodies of both batches are identical, lengths and angles included.
    pub(in crate::solve) fn has_same_topology(&self, other: &Self) -> bool {
        self.topology.is_some() && self.topology == other.topology
    }

    /// The index of particle `i` of each body, relative to row `begin`. Unused lanes repeat the last body: they compute and write the same values.
    #[inline(always)]
    pub(in crate::solve) fn places(&self, begin: u32, i: u32) -> [u32; LANES] {
        let last = self.islands.len() as u32 - 1;
        let mut places = [0; LANES];
        for (place, lane) in places.iter_mut().zip(0..) {
            *place = self.first - begin + last.min(lane) * self.members + i;
        }
        places
    }
}

impl InstanceBatches {
    /// Finds the instance batches of a plan and assigns them to its tasks.
    pub(crate) fn find(&mut self, plan: &mut Plan) {
        let Self { all, parts, rods, instanced, chains, links } = self;
        all.clear();
        parts.clear();
        rods.clear();
        instanced.truncate(&Default::default());
        chains.clear();
        links.clear();
        let mut tasks = core::mem::take(&mut plan.tasks);
        for task in &mut tasks {
            task.instance_batches = self.find_in(plan, task);
        }
        plan.tasks = tasks;
    }

    fn find_in(&mut self, plan: &Plan, task: &Task) -> Range<usize> {
        let first = self.all.len();
        let mut islands = task.islands.clone();
        while let Some(leader) = islands.next() {
            if !is_eligible(plan, &plan.islands.list[leader]) {
                continue;
            }
            let mut end = leader + 1;
            while end < islands.end && follows(plan, end) && has_same_constraints(plan, leader, end)
            {
                end += 1;
            }
            for begin in (leader..end).step_by(LANES) {
                let some = begin..end.min(begin + LANES);
                let joins = |last: &InstanceBatch| {
                    let is_same = || is_same_topology(plan, last.islands.start, begin);
                    last.topology.is_some() && last.islands.end == begin && is_same()
                };
                if some.len() >= MIN_ISLANDS || self.all.last().is_some_and(joins) {
                    self.add(plan, some);
                }
            }
            islands.start = end;
        }
        first..self.all.len()
    }

    /// Adds a batch of islands that have the same constraints.
    fn add(&mut self, plan: &Plan, islands: Range<usize>) {
        let lanes: [&Island; LANES] = core::array::from_fn(|lane| {
            &plan.islands.list[(islands.start + lane).min(islands.end - 1)]
        });
        let first = lanes.map(|island| plan.islands.members[island.members.start]);
        let (begin, mut multipliers) = (self.parts.len(), 0);
        for number in 0..lanes[0].groups.len() {
            let groups = lanes.map(|island| &plan.groups[island.groups.start + number]);
            let group = groups[0];
            if group.kind == GroupKind::Rods {
                let each = groups.map(|group| &plan.distances[group.range.clone()]);
                self.add_rods(each, first, begin);
                continue;
            }
            // Islands with groups that have no eight-lane kernel have been excluded by `is_eligible`.
            let Some(which) = &group.wide else { continue };
            let constraint_batches = &plan.constraint_batches;
            let part = if group.kind == GroupKind::Distances {
                let each = groups.map(|group| &plan.distances[group.range.clone()]);
                Some(self.instanced.add_distances(&InstancedGroups {
                    each,
                    first,
                    constraint_batches,
                    which,
                    multipliers,
                }))
            } else {
                let each = groups.map(|group| &plan.constraints[group.range.clone()]);
                self.instanced.add(&InstancedGroups {
                    each,
                    first,
                    constraint_batches,
                    which,
                    multipliers,
                })
            };
            let Some(part) = part else {
                self.parts.truncate(begin);
                return;
            };
            multipliers += group.range.len();
            let joined = match self.parts[begin..].last_mut() {
                Some(InstancePart::Constraints(last)) => last.append(&part),
                _ => false,
            };
            if !joined {
                self.parts.push(InstancePart::Constraints(part));
            }
        }
        let members = lanes[0].members.len() as u32;
        let parts = begin..self.parts.len();
        let chains = self.add_chains(plan, lanes.map(|island| &island.chains), first);
        let topology = self.topology(plan, &islands);
        self.all.push(InstanceBatch {
            islands,
            first: first[0],
            members,
            parts,
            chains,
            multipliers,
            topology,
        });
    }

    /// The topology number of the last batch, if these islands are identical to its bodies, or else a new one; `None` if they differ among themselves.
    fn topology(&self, plan: &Plan, islands: &Range<usize>) -> Option<usize> {
        let leader = islands.start;
        let last =
            self.all.last().filter(|last| is_same_topology(plan, last.islands.start, leader));
        let identical = islands.clone().skip(1).all(|other| is_same_topology(plan, leader, other));
        identical.then(|| last.and_then(|last| last.topology).unwrap_or(self.all.len()))
    }

    /// Adds the chains of islands that all have the same ones.
    fn add_chains(
        &mut self,
        plan: &Plan,
        each: [&Range<usize>; LANES],
        first: [u32; LANES],
    ) -> Range<usize> {
        let begin = self.chains.len();
        for number in 0..each[0].len() {
            let lanes = each.map(|chains| plan.chains.links(chains.start + number));
            let start = self.links.len();
            self.links.extend((0..lanes[0].len()).map(|place| InstancedLink {
                at: lanes[0][place].rows.map(|row| row - first[0]),
                rest: lanes.map(|links| links[place].rest),
            }));
            self.chains.push(start..self.links.len());
        }
        begin..self.chains.len()
    }

    fn add_rods(&mut self, each: [&[Distance]; LANES], first: [u32; LANES], begin: usize) {
        let start = self.rods.len();
        for place in 0..each[0].len() {
            let (a, b) = ends(&each[0][place]);
            let rest = each.map(|rods| rods[place].rest);
            self.rods.push(InstancedRod { a: a - first[0], b: b - first[0], rest });
        }
        match self.parts[begin..].last_mut() {
            Some(InstancePart::Rods(rods)) => rods.end = self.rods.len(),
            _ => self.parts.push(InstancePart::Rods(start..self.rods.len())),
        }
    }
}

/// Whether an island may be in an instance batch.
fn is_eligible(plan: &Plan, island: &Island) -> bool {
    let members = &plan.islands.members[island.members.clone()];
    let (Some(&first), Some(&last)) = (members.first(), members.last()) else { return false };
    let wide = |group: &ConstraintGroup| group.kind == GroupKind::Rods || group.wide.is_some();
    !island.groups.is_empty()
        && island.is_small()
        && (last - first) as usize + 1 == members.len()
        && plan.groups[island.groups.clone()].iter().all(wide)
        && plan.cluster_batches[island.cluster_batches.clone()]
            .iter()
            .all(|cluster_batch| !cluster_batch.columns)
}

/// Whether the rows of an island begin where those of the previous one end.
fn follows(plan: &Plan, number: usize) -> bool {
    let members = |number: usize| &plan.islands.members[plan.islands.list[number].members.clone()];
    match (members(number - 1).last(), members(number).first()) {
        (Some(&last), Some(&first)) => last + 1 == first,
        _ => false,
    }
}

/// Whether two islands have the same constraints between the same member indices, apart from lengths and angles.
fn has_same_constraints(plan: &Plan, one: usize, other: usize) -> bool {
    let (one, other) = (&plan.islands.list[one], &plan.islands.list[other]);
    if one.members.len() != other.members.len()
        || one.groups.len() != other.groups.len()
        || !is_eligible(plan, other)
    {
        return false;
    }
    let first = |island: &Island| plan.islands.members[island.members.start];
    let shift = first(other) - first(one);
    let groups = |island: &Island| &plan.groups[island.groups.clone()];
    groups(one).iter().zip(groups(other)).all(|(one, other)| {
        let cut = match (&one.wide, &other.wide) {
            (Some(one), Some(other)) => one.has_same_layout(other),
            (None, None) => true,
            _ => false,
        };
        if one.kind != other.kind || one.range.len() != other.range.len() || !cut {
            return false;
        }
        let ranges = || (one.range.clone(), other.range.clone());
        if one.kind == GroupKind::Constraints {
            let (a, b) = ranges();
            let pairs = plan.constraints[a].iter().zip(&plan.constraints[b]);
            return pairs.into_iter().all(|(a, b)| constraints_match(a, b, shift));
        }
        let (a, b) = ranges();
        let mut pairs = plan.distances[a].iter().zip(&plan.distances[b]);
        pairs.all(|(a, b)| {
            (a.a + shift, a.b + shift) == (b.a, b.b)
                && a.softness == b.softness
                && a.bound == b.bound
                // Rods of zero length are joints, on which the chains depend.
                && (a.rest == 0.0) == (b.rest == 0.0)
        })
    })
}

/// Whether two islands have the same constraints, lengths and angles included.
fn is_same_topology(plan: &Plan, one: usize, other: usize) -> bool {
    let groups = |number: usize| &plan.groups[plan.islands.list[number].groups.clone()];
    let lengths =
        |group: &ConstraintGroup| plan.distances[group.range.clone()].iter().map(|d| d.rest);
    let constraint_batches =
        |group: &ConstraintGroup| plan.constraints[group.range.clone()].iter().map(|c| &c.kind);
    has_same_constraints(plan, one, other)
        && groups(one).iter().zip(groups(other)).all(|(one, other)| match one.kind {
            GroupKind::Constraints => constraint_batches(one).eq(constraint_batches(other)),
            GroupKind::Distances | GroupKind::Rods => lengths(one).eq(lengths(other)),
        })
}

fn constraints_match(one: &Constraint, other: &Constraint, shift: u32) -> bool {
    let (equation, other_equation) = (one.kind.equation(), other.kind.equation());
    one.rows.len() == other.rows.len()
        && one.rows.iter().zip(&other.rows).all(|(&a, &b)| a + shift == b)
        && core::mem::discriminant(&one.kind) == core::mem::discriminant(&other.kind)
        && equation.softness() == other_equation.softness()
        && equation.bound() == other_equation.bound()
        && equation.is_range() == other_equation.is_range()
}
