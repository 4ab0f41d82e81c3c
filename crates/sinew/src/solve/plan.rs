//! The plan: distances sorted into islands, and within an island into colours, so that no two of a colour share a particle.
//!
//! An **island** is a set of particles that distances connect. Each is swept until it holds, or its sweeps are spent, by itself: what happens
//! in one never changes a bit in another, however hard it works.
//!
//! **Colours**: in the order in which a game adds them, each constraint waits for the particle that the last one moved, and stiff cloth swept
//! outwards from its pins pumps up energy until it bursts. Colour by colour, neighbours in the plan are independent: a core overlaps them, and
//! the sweep has no direction. The price is one bit mask per particle while compiling.

use core::ops::Range;

use crate::constraints::{Bound, Constraint, Distance, Law};
use crate::solve::SolverSettings;

/// The distances and constraints in solving order, and what a sweep needs beside them. Compiled when the topology changes; scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// The distances, island after island, group after group; within a group in the order given.
    pub(crate) distances: Vec<Distance>,
    /// The multiplier that each distance has summed up in this substep.
    pub(crate) lambdas: Vec<f32>,
    /// All other constraints, in the same way.
    pub(crate) constraints: Vec<Constraint>,
    /// The multiplier that each constraint has summed up in this substep.
    pub(crate) multipliers: Vec<f32>,
    /// The groups of both. In an island what is soft or one-sided comes first, then the hard rods, colour by colour: bones have the last word
    /// over the limits of their joints. Rigid shapes come after those.
    pub(crate) groups: Vec<Group>,
    /// The islands, in the order of their first particles. Every particle is in one.
    pub(crate) islands: Vec<Island>,
    /// The rows of the particles, island after island, ascending in each.
    pub(crate) members: Vec<u32>,
    /// The number of each particle's island.
    pub(crate) island_of: Vec<u32>,
    /// How many rows it was compiled for.
    pub(crate) rows: usize,
    compiling: Compiling,
}

/// Constraints of one kind and one colour: no two share a particle, except in the overflow.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group {
    /// Which list they are in, and which kernel serves them.
    pub(crate) kind: Kind,
    /// Where they are in that list.
    pub(crate) range: Range<usize>,
}

/// The kinds of groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Of the plan's constraints, by their equations.
    Constraints,
    /// Of the plan's distances, by the general kernel.
    Distances,
    /// Of the plan's distances, hard ones of equality, by the shortest kernel.
    Rods,
}

/// Particles that constraints connect, and those constraints.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Island {
    /// Where its groups are among the plan's.
    pub(crate) groups: Range<usize>,
    /// Where its particles are among the plan's members.
    pub(crate) members: Range<usize>,
    /// Whether a compound in it moves as an explicit rigid body, which keeps its own momenta.
    pub(crate) rigid: bool,
    /// How it is solved in this step: the world's settings, and those of the bodies in it.
    pub(crate) settings: SolverSettings,
}

/// What compiling needs; kept for its memory.
#[derive(Clone, Debug, Default)]
struct Compiling {
    /// The colours that each particle's constraints have used.
    used: Vec<u64>,
    /// Union-find: towards the first particle of the island.
    parent: Vec<u32>,
    /// Sorting key, list and number of each sound constraint.
    keys: Vec<(u64, Kind, u32)>,
}

/// The colour of what found no other: a particle in more than 64 constraints. Solved one after the other, which is always right.
const OVERFLOW: u32 = 64;
/// Room for the colours of one rank of groups.
const RANK: u32 = 128;
/// The rank of distances: after the laws that precede them.
const DISTANCES: u32 = 32;
/// The rank of rods, after the rest of their island.
const RODS: u32 = 33;
/// The rank of rigid shapes.
const RIGID: u32 = 34;

impl Plan {
    /// Compiles the valid ones among `distances` and `constraints`, for `particles` rows. Keeps its memory.
    ///
    /// Greedy colouring: each constraint takes the lowest colour that none of its particles has used. The grid of a cloth needs 8 colours
    /// that way, a mesh some 13. A pinned particle (of infinite mass) belongs to the island of what hangs on it, and joins several into one.
    pub(crate) fn compile(
        &mut self,
        distances: &[Distance],
        constraints: &[Constraint],
        particles: usize,
    ) {
        self.rows = particles;
        let sound: Vec<bool> = constraints.iter().map(|c| c.fault(particles).is_none()).collect();
        let bound = || constraints.iter().zip(0..).zip(&sound).filter(|(_, sound)| **sound);
        let kept = || {
            distances
                .iter()
                .zip(0..)
                .filter(|(d, _): &(&Distance, u32)| d.fault(particles).is_none())
        };

        let parent = &mut self.compiling.parent;
        parent.clear();
        parent.extend(0..particles as u32);
        for (d, _) in kept() {
            unite(parent, d.a, d.b);
        }
        for ((c, _), _) in bound() {
            c.rows.iter().for_each(|&row| unite(parent, c.rows[0], row));
        }
        self.number_islands(particles);

        let Compiling { used, keys, .. } = &mut self.compiling;
        used.clear();
        used.resize(particles, 0);
        keys.clear();
        for (distance, number) in kept() {
            let rod = distance.softness.is_hard() && distance.bound == Bound::Equal;
            let colour = colour(used, &[distance.a, distance.b]);
            let (rank, kind) = if rod { (RODS, Kind::Rods) } else { (DISTANCES, Kind::Distances) };
            let island = self.island_of[distance.a as usize];
            keys.push((key(island, rank, colour), kind, number));
        }
        for ((constraint, number), _) in bound() {
            let colour = colour(used, &constraint.rows);
            let rigid = matches!(constraint.law, Law::Rigid(_));
            let rank = if rigid { RIGID } else { constraint.law.rank() };
            let island = self.island_of[constraint.rows[0] as usize];
            keys.push((key(island, rank, colour), Kind::Constraints, number));
        }
        // Every key has one kind, and numbers are unique in it.
        keys.sort_unstable_by_key(|&(key, _, number)| (key, number));

        let keys = core::mem::take(&mut self.compiling.keys);
        self.take_in_order(distances, constraints, &keys);
        self.compiling.keys = keys;
    }

    /// Copies the constraints in the order of their keys, and cuts them into groups.
    fn take_in_order(
        &mut self,
        distances: &[Distance],
        constraints: &[Constraint],
        keys: &[(u64, Kind, u32)],
    ) {
        self.distances.clear();
        self.constraints.clear();
        self.groups.clear();
        for run in keys.chunk_by(|(one, ..), (other, ..)| one == other) {
            let (island, kind) = ((run[0].0 >> 32) as usize, run[0].1);
            let numbers = run.iter().map(|&(.., number)| number as usize);
            let range = if kind == Kind::Constraints {
                self.constraints.extend(numbers.map(|number| constraints[number].clone()));
                self.constraints.len() - run.len()..self.constraints.len()
            } else {
                self.distances.extend(numbers.map(|number| distances[number]));
                self.distances.len() - run.len()..self.distances.len()
            };
            let island = &mut self.islands[island];
            if island.groups.is_empty() {
                island.groups = self.groups.len()..self.groups.len();
            }
            island.groups.end += 1;
            self.groups.push(Group { kind, range });
        }
        self.lambdas.clear();
        self.lambdas.resize(self.distances.len(), 0.0);
        self.multipliers.clear();
        self.multipliers.resize(self.constraints.len(), 0.0);
    }

    /// Numbers the islands by their first particles, and lists the members of each.
    fn number_islands(&mut self, particles: usize) {
        let (parent, island) = (&mut self.compiling.parent, &mut self.island_of);
        self.islands.clear();
        island.clear();
        for row in 0..particles as u32 {
            let first = root(parent, row);
            let number = if first == row {
                self.islands.push(Island::default());
                self.islands.len() as u32 - 1
            } else {
                island[first as usize]
            };
            island.push(number);
            self.islands[number as usize].members.end += 1;
        }
        let mut begin = 0;
        for island in &mut self.islands {
            let count = island.members.end;
            island.members = begin..begin;
            begin += count;
        }
        self.members.clear();
        self.members.resize(particles, 0);
        for (row, &number) in island.iter().enumerate() {
            let members = &mut self.islands[number as usize].members;
            self.members[members.end] = row as u32;
            members.end += 1;
        }
    }
}

fn key(island: u32, rank: u32, colour: u32) -> u64 {
    u64::from(island) << 32 | u64::from(rank * RANK + colour)
}

/// The lowest colour that none of the particles has used, which they now have; [`OVERFLOW`] if there is none.
fn colour(used: &mut [u64], rows: &[u32]) -> u32 {
    let taken = rows.iter().fold(0, |taken, &row| taken | used[row as usize]);
    let colour = (!taken).trailing_zeros();
    if colour < OVERFLOW {
        rows.iter().for_each(|&row| used[row as usize] |= 1 << colour);
    }
    colour
}

/// Joins the islands of two particles, towards the smaller row, so that the root of an island is its first particle.
fn unite(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

/// The first particle of the island of `row`, shortening the way for the next time (path halving).
fn root(parent: &mut [u32], mut row: u32) -> u32 {
    while parent[row as usize] != row {
        let up = parent[parent[row as usize] as usize];
        parent[row as usize] = up;
        row = up;
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_distances_of_a_colour_share_a_particle_and_none_is_lost() {
        let mut distances = Vec::new();
        let (columns, rows) = (13, 9);
        let at = |c: u32, r: u32| r * columns + c;
        for r in 0..rows {
            for c in 0..columns {
                for (dc, dr) in [(1, 0), (0, 1), (1, 1), (2, 0)] {
                    if c + dc < columns && r + dr < rows {
                        distances.push(Distance::new(at(c, r), at(c + dc, r + dr), 1.0));
                    }
                }
            }
        }
        let mut plan = Plan::default();
        plan.compile(&distances, &[], (columns * rows) as usize);
        assert_eq!(plan.distances.len(), distances.len());
        assert!(plan.groups.len() <= 16, "{}", plan.groups.len());
        for group in &plan.groups {
            let mut seen = std::collections::BTreeSet::new();
            for distance in &plan.distances[group.range.clone()] {
                assert!(seen.insert(distance.a) && seen.insert(distance.b));
            }
        }
    }

    #[test]
    fn a_hub_of_a_hundred_spokes_overflows_and_is_still_all_there() {
        let distances: Vec<_> = (1..=100).map(|i| Distance::new(0, i, 1.0)).collect();
        let mut plan = Plan::default();
        plan.compile(&distances, &[], 101);
        assert_eq!(plan.distances.len(), 100);
        assert_eq!(plan.groups.len(), 65);
        assert_eq!(plan.groups.last().unwrap().range.len(), 36);
    }

    #[test]
    fn islands_are_what_distances_connect_and_loose_particles_are_islands_too() {
        let distances =
            [Distance::new(4, 1, 1.0), Distance::new(0, 3, 1.0), Distance::new(3, 5, 1.0)];
        let mut plan = Plan::default();
        plan.compile(&distances, &[], 7);
        let members: Vec<_> =
            plan.islands.iter().map(|i| &plan.members[i.members.clone()]).collect();
        assert_eq!(members, [&[0, 3, 5][..], &[1, 4], &[2], &[6]]);
        let groups: Vec<_> = plan.islands.iter().map(|i| i.groups.len()).collect();
        assert_eq!(groups, [2, 1, 0, 0]);
        assert_eq!(plan.distances, [distances[1], distances[2], distances[0]]);
    }

    #[test]
    fn an_island_is_compiled_the_same_whatever_stands_beside_it() {
        let body = |first: u32| (0..5).map(move |i| Distance::new(first + i, first + i + 1, 1.0));
        let (mut alone, mut beside) = (Plan::default(), Plan::default());
        alone.compile(&body(0).collect::<Vec<_>>(), &[], 6);
        beside.compile(&body(6).chain(body(0)).collect::<Vec<_>>(), &[], 12);
        assert_eq!(beside.distances[..5], alone.distances[..]);
        assert_eq!(beside.groups[..2], alone.groups[..]);
    }

    #[test]
    fn a_faulty_distance_is_left_out_and_the_rest_keeps_its_order() {
        let good = [Distance::new(0, 1, 1.0), Distance::new(2, 3, 2.0)];
        let bad = Distance::new(1, 1, 1.0);
        let (mut with, mut without) = (Plan::default(), Plan::default());
        with.compile(&[good[0], bad, good[1], Distance::new(0, 9, 1.0)], &[], 4);
        without.compile(&good, &[], 4);
        assert_eq!(with.distances, without.distances);
        assert_eq!(with.groups, without.groups);
    }
}
