//! Islands: particles that constraints connect, found by union-find. Each is solved by itself, with settings of its own; contacts ask who is in which.

use core::ops::Range;

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
    /// For each island whether it is dormant: asleep as in the last step, without anything being done to it. Empty, with the number 0, where none is; and as
    /// long as the number is another one, the same are.
    pub(crate) dormant: Vec<bool>,
    pub(crate) dormant_number: u64,
    /// Stretches of islands of one particle each that no constraint holds, in this step.
    pub(crate) singles: Vec<Singles>,
    /// Rows of single particles that body colliders may come to touch in this step, ascending.
    pub(crate) near_shapes: Vec<u32>,
}

/// Islands one behind the other of a particle each, in rows one behind the other: there is nothing to sweep, and only what may touch something is looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Singles {
    pub(crate) islands: Range<usize>,
    pub(crate) rows: Range<u32>,
}

/// No island.
const NONE: u32 = u32::MAX;

/// Fewer islands in a stretch are taken one by one: to know a stretch costs as much as to look at some of them.
const STRETCH: usize = 16;

impl Singles {
    /// Those of some islands.
    pub(crate) fn among(&self, islands: &Range<usize>) -> Self {
        let first = self.islands.start.max(islands.start).min(self.islands.end);
        let end = self.islands.end.min(islands.end).max(first);
        let row = |number: usize| self.rows.start + (number - self.islands.start) as u32;
        Self { islands: first..end, rows: row(first)..row(end) }
    }
}

/// Particles that constraints connect, and those constraints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Island {
    /// Where its groups are among the plan's.
    pub(crate) groups: Range<usize>,
    /// Where its cluster batches are.
    pub(crate) cluster_batches: Range<usize>,
    /// Where its particles are among the plan's members.
    pub(crate) members: Range<usize>,
    /// The most of them whose rows follow each other.
    pub(crate) run: Range<usize>,
    /// Whether a compound in it moves as an explicit rigid body, which keeps its own momenta.
    pub(crate) rigid: bool,
    /// Whether a constraint in it may hold on to the world ([`Equation::is_internal`](crate::constraints::Equation::is_internal)).
    pub(crate) external: bool,
    /// Whether all its particles have one origin in this step.
    pub(crate) one_origin: bool,
    /// Whether nothing outside holds it in this step: its constraints are among its own particles, of which none is pinned.
    pub(crate) free: bool,
    /// Whether it sleeps through this step.
    pub(crate) asleep: bool,
    /// Whether loads of constraints in it are measured, so that it is solved by itself.
    pub(crate) measured: bool,
    /// Whether it is measured how far distances in it are stretched, so that what the solver leaves is not [relaxed](crate::solve).
    pub(crate) strain_measured: bool,
    /// Whether it moves as one rigid state in this step: its constraints are not swept, and its particles follow.
    pub(crate) one_state: bool,
    /// Where its chains are among the plan's.
    pub(crate) chains: Range<usize>,
    /// Which of the plan's tethers are its own.
    pub(crate) tethers: Option<u32>,
    /// Which of the plan's spans are its own.
    pub(crate) spans: Option<u32>,
    /// Which of the plan's rod graphs is its own, and which tie rods are.
    pub(crate) rod_graph: Option<u32>,
    pub(crate) tie_rods: Option<u32>,
    /// Whether a part of it collides as a rigid shape.
    pub(crate) has_solids: bool,
    /// Whether a spring pulls on it in this step.
    pub(crate) has_springs: bool,
    /// How it is solved in this step: the world's settings, and those of the bodies in it; the sweeps are those of a microstep.
    pub(crate) settings: SolverSettings,
    /// The microsteps that it takes in each substep, 1 or more.
    pub(crate) microsteps: u32,
    /// How often what is tied to large cloth is swept in each sweep of that, at the most.
    pub(crate) sweeps_of_parts: u32,
    /// Whether a body of its particles may come to touch particles of another one in this step; asked of what takes microsteps.
    pub(crate) meets_others: bool,
    /// Whether one may come to touch particles of another one, or its own.
    pub(crate) meets_any: bool,
    /// Whether a body collider has pressed on one of its particles in this step.
    pub(crate) pressed: bool,
}

/// An island of no more particles is small: eight of them with their velocities and all fit into a core's first cache, 32 kB and a half, and so are solved
/// side by side. Larger ones have enough of each colour to fill the lanes.
pub(crate) const SMALL_ISLAND: usize = 64;

impl Island {
    /// Whether it may be in an [instance batch](crate::solve): its tethers are held once in a substep then, and those of a large one before each sweep.
    pub(crate) fn is_small(&self) -> bool {
        self.members.len() <= SMALL_ISLAND
    }

    /// Whether nobody is to sweep its constraints in this step.
    pub(crate) fn is_left_alone(&self) -> bool {
        self.asleep || self.one_state
    }

    /// Whether chains in it are solved at once. Where everything walks to rest sweeps do: with them a rope between two pins still moved by micrometres after
    /// 20 000 such steps.
    pub(crate) fn has_chains(&self) -> bool {
        self.settings.long_range && !self.settings.statics && !self.chains.is_empty()
    }

    /// Whether it goes through each substep in several microsteps.
    pub(crate) fn takes_microsteps(&self) -> bool {
        self.microsteps > 1 && !self.is_left_alone()
    }
}

impl Islands {
    /// Finds the stretches of single particles, when it is known what sleeps in a step.
    pub(crate) fn find_singles(&mut self) {
        let Self { list, members, singles, .. } = self;
        singles.clear();
        let mut stretch = Singles::default();
        let mut keep = |stretch: &Singles| {
            if stretch.islands.len() >= STRETCH {
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

    /// Notes which islands body colliders have pressed on, by rows of theirs.
    pub(crate) fn note_pressed(&mut self, rows: impl Iterator<Item = u32>) {
        for row in rows {
            let island = self.of.get(row as usize).and_then(|&own| self.list.get_mut(own as usize));
            island.into_iter().for_each(|island| island.pressed = true);
        }
    }

    /// Numbers the sets of connected particles by their first ones, and lists the members of each, ascending; but for the first `kept` islands, which are what
    /// they were.
    pub(crate) fn number(&mut self, kept: usize, connected: &mut UnionFind) {
        let Self { list, members, of, .. } = self;
        list.truncate(kept);
        let mut begin = list.last().map_or(0, |island| island.members.end);
        // Whoever is in none of those that are kept has none yet.
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
            island.run = longest_run(members, island.members.clone());
        }
    }

    /// The particles that are not in the first `kept` islands, island after island.
    pub(crate) fn members_from(&self, kept: usize) -> &[u32] {
        let begin = self.list[..kept].last().map_or(0, |island| island.members.end);
        self.members.get(begin..).unwrap_or(&[])
    }
}

/// The longest run, and of several the first, of rows that follow each other, among these of some members.
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

    /// Islands of so many particles each, with a constraint where there are several.
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
        // Two tied ones, thirty single ones of which one sleeps, three tied ones, and too few to be worth it.
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
