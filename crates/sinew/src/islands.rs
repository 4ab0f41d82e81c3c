//! Islands: sets of particles that constraints connect, found by union-find. Each is solved by itself, with settings of its own; contacts look up the island of
//! a particle here.

use core::ops::Range;

use crate::constraints::GradientAt;
use crate::settings::SolverSettings;
use crate::union_find::UnionFind;

/// The islands of a world. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Islands {
    /// In the order of their first particles. Every particle is in one.
    pub(crate) list: Vec<Island>,
    /// The rows of the particles, island after island, ascending in each.
    pub(crate) members: Vec<u32>,
    /// The number of each particle's island.
    pub(crate) of: Vec<u32>,
    /// For each island whether it is dormant: asleep as in the last step, with nothing done to it. Empty, with `dormant_number` 0, if no island is; while
    /// `dormant_number` stays the same, so does this list.
    pub(crate) dormant: Vec<bool>,
    pub(crate) dormant_number: u64,
    /// Runs of islands of one particle each that no constraint holds, in this step.
    pub(crate) singles: Vec<Singles>,
    /// Rows of single particles that body colliders may touch in this step, ascending.
    pub(crate) rows_near_colliders: Vec<u32>,
}

/// Consecutive islands of one particle each, in consecutive rows: they have no constraints to sweep, and only the particles that may touch something are
/// visited.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Singles {
    pub(crate) islands: Range<usize>,
    pub(crate) rows: Range<u32>,
}

/// Marks a row that is in no island yet.
const NONE: u32 = u32::MAX;

/// Shortest run that is kept as one: handling a run costs as much as visiting some islands one by one.
const MIN_RUN: usize = 16;

impl Singles {
    /// The part of this run within a range of islands.
    pub(crate) fn among(&self, islands: &Range<usize>) -> Self {
        let first = self.islands.start.max(islands.start).min(self.islands.end);
        let end = self.islands.end.min(islands.end).max(first);
        let row = |number: usize| self.rows.start + (number - self.islands.start) as u32;
        Self { islands: first..end, rows: row(first)..row(end) }
    }
}

/// Particles that constraints connect, and those constraints. All ranges are into the lists of the [`Plan`](crate::solve).
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Island {
    /// Its constraint groups in the plan.
    pub(crate) groups: Range<usize>,
    /// Its cluster batches in the plan.
    pub(crate) cluster_batches: Range<usize>,
    /// Its particles in [`Islands::members`].
    pub(crate) members: Range<usize>,
    /// The longest part of `members` whose rows are consecutive.
    pub(crate) contiguous: Range<usize>,
    /// Whether a compound in it moves as an explicit rigid body, which keeps its own momenta.
    pub(crate) rigid: bool,
    /// Whether a constraint in it may hold on to the world ([`Equation::is_internal`](crate::constraints::Equation::is_internal)).
    pub(crate) external: bool,
    /// Whether all its particles have one origin in this step.
    pub(crate) one_origin: bool,
    /// Whether nothing outside holds it in this step: its constraints are among its own particles, of which none is pinned.
    pub(crate) free: bool,
    /// Rows of the one or two pinned particles that hold it in this step, if nothing else outside does: it turns about that point (the same row twice), or about
    /// the axis through both. Not for large islands without chains, and not for those that take microsteps.
    pub(crate) pivot: Option<[u32; 2]>,
    /// Whether it sleeps through this step.
    pub(crate) asleep: bool,
    /// Whether loads of constraints in it are measured, so that it is solved by itself.
    pub(crate) measured: bool,
    /// Whether strains of distances in it are measured, so that the errors the solver leaves are not [relaxed](crate::solve) when the step ends.
    pub(crate) strain_measured: bool,
    /// Whether it moves as one rigid state in this step: its constraints are not swept, and its particles follow.
    pub(crate) is_rigid_state: bool,
    /// Its chains in the plan.
    pub(crate) chains: Range<usize>,
    /// Index of its tethers in the plan, if it has any.
    pub(crate) tethers: Option<u32>,
    /// Index of its spans in the plan.
    pub(crate) spans: Option<u32>,
    /// Index of its rod graph in the plan, and of its tie rods.
    pub(crate) rod_graph: Option<u32>,
    pub(crate) tie_rods: Option<u32>,
    /// Whether a body collider is part of it.
    pub(crate) has_body_colliders: bool,
    /// Whether a spring acts on it in this step.
    pub(crate) has_springs: bool,
    /// How it is solved in this step: the world's settings merged with those of the bodies in it; `max_sweeps` is for one microstep.
    pub(crate) settings: SolverSettings,
    /// Microsteps in each substep, 1 or more.
    pub(crate) microsteps: u32,
    /// Most sweeps, in each sweep of large cloth, over the parts tied to it.
    pub(crate) tie_sweeps: u32,
    /// Whether one of its bodies may touch particles of another body in this step; valid only for islands that take microsteps.
    pub(crate) may_touch_others: bool,
    /// The same, contacts of a body with itself included.
    pub(crate) may_touch_any: bool,
    /// Whether a body collider has pressed on one of its particles in this step; valid only for islands that take microsteps.
    pub(crate) pressed: bool,
}

/// The most particles of a small island: eight such islands, velocities and all, take about 32 kB, which a core's first-level cache holds, and so are solved
/// side by side in lanes. Larger islands have enough constraints of each colour to fill the lanes by themselves.
pub(crate) const SMALL_ISLAND: usize = 64;

impl Island {
    /// Whether it may be in an [instance batch](crate::solve). The tethers of a small island are projected once in a substep, those of a large one before each
    /// sweep.
    pub(crate) fn is_small(&self) -> bool {
        self.members.len() <= SMALL_ISLAND
    }

    /// Whether its constraints are not swept in this step.
    pub(crate) fn is_skipped(&self) -> bool {
        self.asleep || self.is_rigid_state
    }

    /// Whether hard distances in it are also enforced over long ranges. Not where corrections along the start of the substep are to conserve energy: neither in
    /// the substeps in which such an island falls back to the nearest point, where they would close at once what all substeps before have left open.
    pub(crate) fn has_long_range(&self) -> bool {
        self.settings.long_range && self.settings.gradient_at == GradientAt::Current
    }

    /// Whether its chains are solved directly. In statics they are swept instead: solved directly, a rope between two pins still moved by micrometres after 20
    /// 000 such steps.
    pub(crate) fn has_chains(&self) -> bool {
        self.has_long_range() && !self.settings.statics && !self.chains.is_empty()
    }

    /// Whether it goes through each substep in several microsteps.
    pub(crate) fn takes_microsteps(&self) -> bool {
        self.microsteps > 1 && !self.is_skipped()
    }
}

/// The index of a row among the ascending rows of an island's members.
pub(crate) fn member_index(members: &[u32]) -> impl Fn(u32) -> u32 {
    let (first, last) = (members[0], members[members.len() - 1]);
    let in_a_row = (last - first) as usize + 1 == members.len();
    move |row| match in_a_row {
        true => row - first,
        false => members.partition_point(|&member| member < row) as u32,
    }
}

impl Islands {
    /// Finds the runs of single particles. Called once it is known which islands sleep in the step.
    pub(crate) fn find_singles(&mut self) {
        let Self { list, members, singles, .. } = self;
        singles.clear();
        let mut stretch = Singles::default();
        let mut keep = |stretch: &Singles| {
            if stretch.islands.len() >= MIN_RUN {
                singles.push(stretch.clone());
            }
        };
        for (number, island) in list.iter().enumerate() {
            let is_single = island.members.len() == 1
                && island.groups.is_empty()
                && !(island.asleep || island.measured || island.rigid);
            if !is_single {
                continue;
            }
            let row = members[island.members.start];
            if stretch.islands.end != number || stretch.rows.end != row {
                keep(&stretch);
                stretch = Singles { islands: number..number, rows: row..row };
            }
            (stretch.islands.end, stretch.rows.end) = (number + 1, row + 1);
        }
        keep(&stretch);
    }

    /// Marks the islands of these rows as pressed on by body colliders.
    pub(crate) fn mark_pressed(&mut self, rows: impl Iterator<Item = u32>) {
        for row in rows {
            let island = self.of.get(row as usize).and_then(|&own| self.list.get_mut(own as usize));
            island.into_iter().for_each(|island| island.pressed = true);
        }
    }

    /// Numbers the sets of connected particles by their first rows, and lists the members of each, ascending. The first `kept` islands stay as they are.
    pub(crate) fn number(&mut self, kept: usize, connected: &mut UnionFind) {
        let Self { list, members, of, .. } = self;
        list.truncate(kept);
        let mut begin = list.last().map_or(0, |island| island.members.end);
        // Rows outside of the kept islands have no island yet.
        members.get(begin..).unwrap_or(&[]).iter().for_each(|&row| of[row as usize] = NONE);
        of.resize(connected.len(), NONE);
        for row in 0..connected.len() {
            if of[row] != NONE {
                continue;
            }
            let first = connected.root(row as u32) as usize;
            if first == row {
                of[row] = list.len() as u32;
                list.push(Island::default());
            } else {
                of[row] = of[first];
            }
            list[of[row] as usize].members.end += 1;
        }
        for island in &mut list[kept..] {
            let count = island.members.end;
            island.members = begin..begin;
            begin += count;
        }
        members.resize(begin, 0);
        for (row, &number) in of.iter().enumerate().filter(|(_, number)| **number >= kept as u32) {
            let span = &mut list[number as usize].members;
            members[span.end] = row as u32;
            span.end += 1;
        }
        for island in &mut list[kept..] {
            island.contiguous = longest_run(members, island.members.clone());
        }
    }

    /// The rows that are not in the first `kept` islands, island after island.
    pub(crate) fn members_from(&self, kept: usize) -> &[u32] {
        let begin = self.list[..kept].last().map_or(0, |island| island.members.end);
        self.members.get(begin..).unwrap_or(&[])
    }
}

/// The longest range of `of` in which the rows in `members` are consecutive; the first of equals.
fn longest_run(members: &[u32], of: Range<usize>) -> Range<usize> {
    let (mut begin, mut longest) = (of.start, of.start..of.start);
    for end in of.start + 1..=of.end {
        if end == of.end || members[end] != members[end - 1] + 1 {
            if end - begin > longest.len() {
                longest = begin..end;
            }
            begin = end;
        }
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Islands of these sizes, with a constraint in each that has several particles.
    fn islands(sizes: impl IntoIterator<Item = usize>) -> Islands {
        let sizes: Vec<usize> = sizes.into_iter().collect();
        let mut connected = UnionFind::default();
        connected.reset(sizes.iter().sum());
        let mut first = 0;
        for size in &sizes {
            (first + 1..first + size).for_each(|row| connected.unite(first as u32, row as u32));
            first += size;
        }
        let mut islands = Islands::default();
        islands.number(0, &mut connected);
        for island in islands.list.iter_mut().filter(|island| island.members.len() > 1) {
            island.groups = 0..1;
        }
        islands
    }

    #[test]
    fn stretches_of_single_particles_end_where_something_else_stands() {
        // Two connected particles, thirty single ones of which one sleeps, three connected ones, and nine single ones: too short a run.
        let mut all = islands([2].into_iter().chain([1; 30]).chain([3]).chain([1; 9]));
        all.list[12].asleep = true;
        all.find_singles();
        let found: Vec<_> =
            all.singles.iter().map(|one| (one.islands.clone(), one.rows.clone())).collect();
        assert_eq!(found, [(13..31, 14..32)]);
        let among = |islands: Range<usize>| all.singles[0].among(&islands);
        assert_eq!((among(0..20).islands, among(0..20).rows), (13..20, 14..21));
        assert_eq!((among(20..40).islands, among(20..40).rows), (20..31, 21..32));
        assert!(among(0..5).islands.is_empty() && among(33..40).islands.is_empty());
    }
}
