//! Finds chains among the rods of an island.

use core::ops::Range;

use super::Link;
use super::segments::{Rests, rests_of};
use crate::constraints::Distance;

/// The chains of a plan, by island. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct Chains {
    /// Range of the links of each.
    pub(super) each: Vec<Range<usize>>,
    pub(super) links: Vec<Link>,
    /// Range of the segment lengths of each chain; empty where it is too short to be divided into segments.
    segments: Vec<Range<usize>>,
    rests: Vec<Rests>,
    graph: RodGraph,
}

/// Fewest rods of a chain. Shorter ones are solved as fast by sweeps. The second entry applies to islands with more rods than particles, as of boxes and bones:
/// there a chain has to be longer than a limb.
const MIN_RODS: [usize; 2] = [2, 4];

/// Longer chains are divided into segments. No body of an instance batch has this many particles, and those need the same bits when solved alone.
pub(in crate::solve) const LONG: usize = 64;

/// Islands of more particles are searched for chains only if they have no more rods than particles. The others are cloth, and the plan of torn cloth has to be
/// updated within a millisecond.
const MAX_DENSE: usize = 512;

/// No rod.
const NONE: u32 = u32::MAX;

/// The rods of an island as an adjacency list.
#[derive(Clone, Debug, Default)]
struct RodGraph {
    /// For each rod the member indices of its ends, its plan index, and its length.
    rods: Vec<(u32, u32, u32, f32)>,
    /// Offset in `at` of the rods of each member.
    begin: Vec<u32>,
    at: Vec<u32>,
    /// Whether each rod is in a chain already.
    taken: Vec<bool>,
}

impl Chains {
    /// Truncates to the first `chains` chains; keeps the memory.
    pub(in crate::solve) fn truncate(&mut self, chains: usize) {
        self.each.truncate(chains);
        self.links.truncate(self.each.last().map_or(0, |links| links.end));
        self.segments.truncate(chains);
        self.rests.truncate(self.segments.last().map_or(0, |rests| rests.end));
    }

    /// Finds the chains of an island with these members and `count` hard equality distances, each given with its plan index; returns their range.
    pub(in crate::solve) fn find<'a>(
        &mut self,
        members: &[u32],
        count: usize,
        rods: impl Iterator<Item = (u32, &'a Distance)>,
    ) -> Range<usize> {
        let begin = self.each.len();
        let is_dense = count > members.len();
        let fewest = MIN_RODS[usize::from(is_dense)];
        if count >= fewest && !(is_dense && members.len() > MAX_DENSE) {
            self.graph.build(members, rods);
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

    /// The links of a chain.
    pub(in crate::solve) fn links(&self, number: usize) -> &[Link] {
        &self.links[self.each[number].clone()]
    }

    /// The segment lengths of a chain; empty if it is not divided.
    pub(super) fn rests(&self, number: usize) -> &[Rests] {
        &self.rests[self.segments[number].clone()]
    }
}

impl RodGraph {
    fn build<'a>(&mut self, members: &[u32], rods: impl Iterator<Item = (u32, &'a Distance)>) {
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
        // The remaining ones are rings.
        for member in 0..all {
            if let Some(rod) = self.untaken(member) {
                self.walk(member, rod, members, each, links);
            }
        }
    }

    /// Follows the rods from a member on, beginning with one of its own, until they branch or end.
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
