//! Which rods of an island are a chain.

use core::ops::Range;

use super::Link;
use super::segments::{Rests, rests_of};
use crate::constraints::Distance;

/// The chains of a plan, island after island. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct Chains {
    /// Where the links of each are.
    pub(super) each: Vec<Range<usize>>,
    pub(super) links: Vec<Link>,
    /// Of each chain where the lengths of its segments are; none where it is too short to be cut into some.
    segments: Vec<Range<usize>>,
    rests: Vec<Rests>,
    graph: RodGraph,
}

/// A chain of fewer rods is done as fast by sweeps; and where there are more rods than particles, in boxes and bones, what looks like a chain is one if it is
/// longer than a limb.
const FEWEST: [usize; 2] = [2, 4];

/// Longer chains are cut into segments: so many particles as no body has that may be solved side by side with others, for those have to have the same bits alone.
pub(in crate::solve) const LONG: usize = 64;

/// Islands of more particles have their chains looked for only where there are no more rods than particles: they are cloth, and of cloth that is torn the plan
/// is to be mended in a millisecond.
const LARGE: usize = 512;

/// No rod.
const NONE: u32 = u32::MAX;

/// Which particles of an island are tied to which.
#[derive(Clone, Debug, Default)]
struct RodGraph {
    /// Of each rod its ends among the members, its number among the plan's distances, and its length.
    rods: Vec<(u32, u32, u32, f32)>,
    /// Where the rods of each member begin in `at`.
    begin: Vec<u32>,
    at: Vec<u32>,
    /// Which rods are in a chain.
    taken: Vec<bool>,
}

impl Chains {
    /// Forgets all but the first so many, and keeps the memory.
    pub(in crate::solve) fn truncate(&mut self, chains: usize) {
        self.each.truncate(chains);
        self.links.truncate(self.each.last().map_or(0, |links| links.end));
        self.segments.truncate(chains);
        self.rests.truncate(self.segments.last().map_or(0, |rests| rests.end));
    }

    /// Finds those of an island with these members and so many hard distances of equality, each with its number in the plan; returns which they are.
    pub(in crate::solve) fn find<'a>(
        &mut self,
        members: &[u32],
        count: usize,
        rods: impl Iterator<Item = (u32, &'a Distance)>,
    ) -> Range<usize> {
        let begin = self.each.len();
        let is_dense = count > members.len();
        let fewest = FEWEST[usize::from(is_dense)];
        if count >= fewest && !(is_dense && members.len() > LARGE) {
            self.graph.weave(members, rods);
            self.graph.chains((members, fewest), &mut self.each, &mut self.links);
            for links in &self.each[begin..] {
                let (links, first) = (&self.links[links.clone()], self.rests.len());
                if links.len() > LONG {
                    self.rests.extend(rests_of(links));
                }
                self.segments.push(first..self.rests.len());
            }
        }
        begin..self.each.len()
    }

    /// One of them.
    pub(in crate::solve) fn links(&self, number: usize) -> &[Link] {
        &self.links[self.each[number].clone()]
    }

    /// The lengths of its segments, if it is cut into some.
    pub(super) fn rests(&self, number: usize) -> &[Rests] {
        &self.rests[self.segments[number].clone()]
    }
}

impl RodGraph {
    fn weave<'a>(&mut self, members: &[u32], rods: impl Iterator<Item = (u32, &'a Distance)>) {
        let place = |row: u32| members.partition_point(|&member| member < row) as u32;
        self.rods.clear();
        self.rods.extend(rods.map(|(rod, d)| (place(d.a), place(d.b), rod, d.rest)));
        self.begin.clear();
        self.begin.resize(members.len() + 1, 0);
        for &(a, b, ..) in &self.rods {
            self.begin[a as usize + 1] += 1;
            self.begin[b as usize + 1] += 1;
        }
        for member in 0..members.len() {
            self.begin[member + 1] += self.begin[member];
        }
        let mut next = self.begin.clone();
        self.at.clear();
        self.at.resize(2 * self.rods.len(), 0);
        for (number, &(a, b, ..)) in self.rods.iter().enumerate() {
            for end in [a, b] {
                self.at[next[end as usize] as usize] = number as u32;
                next[end as usize] += 1;
            }
        }
        self.taken.clear();
        self.taken.resize(self.rods.len(), false);
    }

    /// The rods of a member.
    fn of(&self, member: u32) -> &[u32] {
        &self.at[self.begin[member as usize] as usize..self.begin[member as usize + 1] as usize]
    }

    fn untaken(&self, member: u32) -> Option<u32> {
        self.of(member).iter().copied().find(|&rod| !self.taken[rod as usize])
    }

    fn chains(
        &mut self,
        members: (&[u32], usize),
        each: &mut Vec<Range<usize>>,
        links: &mut Vec<Link>,
    ) {
        let all = members.0.len() as u32;
        let inner = |graph: &Self, member: u32| graph.of(member).len() == 2;
        for member in 0..all {
            while !inner(self, member)
                && let Some(rod) = self.untaken(member)
            {
                self.walk(member, rod, members, each, links);
            }
        }
        // What is left are rings.
        for member in 0..all {
            if let Some(rod) = self.untaken(member) {
                self.walk(member, rod, members, each, links);
            }
        }
    }

    /// Takes the rods from a member on, along one of its own, as far as there is one way.
    fn walk(
        &mut self,
        from: u32,
        rod: u32,
        (members, fewest): (&[u32], usize),
        each: &mut Vec<Range<usize>>,
        links: &mut Vec<Link>,
    ) {
        let begin = links.len();
        links.push(Link { rows: [members[from as usize]; 2], rods: [NONE; 2], rest: 0.0 });
        let (mut here, mut along) = (from, Some(rod));
        while let Some(rod) = along {
            self.taken[rod as usize] = true;
            let (a, b, rod, rest) = self.rods[rod as usize];
            here = if a == here { b } else { a };
            if here == from {
                break;
            }
            let row = members[here as usize];
            match links[begin..].last_mut() {
                Some(Link { rows: [one, other], rods: [_, knot], .. })
                    if rest == 0.0 && one == other =>
                {
                    (*other, *knot) = (row, rod);
                }
                _ => links.push(Link { rows: [row; 2], rods: [rod, NONE], rest }),
            }
            along = if self.of(here).len() == 2 { self.untaken(here) } else { None };
        }
        if links.len() - begin > fewest {
            each.push(begin..links.len());
        } else {
            links.truncate(begin);
        }
    }
}
