//! Finds chains among the rods of an island.

use core::ops::Range;

use super::Link;
use super::segments::{Rests, rests_of};
use crate::constraints::Distance;
use crate::islands::member_index;
use crate::solve::rod_graph::{RodEnd, RodGraph};

/// The chains of a plan, by island. Scratch, never saved.
#[derive(Clone, Debug, Default)]
pub(in crate::solve) struct Chains {
    /// Range of the links of each.
    pub(super) each: Vec<Range<usize>>,
    pub(super) links: Vec<Link>,
    /// Range of the segment lengths of each chain; empty where it is too short to be divided into segments.
    segments: Vec<Range<usize>>,
    rests: Vec<Rests>,
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

/// A search for the chains of one island.
struct Search<'a> {
    members: &'a [u32],
    /// Fewest rods of a chain.
    fewest: usize,
    /// The rods between member indices.
    graph: RodGraph,
    /// The plan index of each rod.
    numbers: Vec<u32>,
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
            Search::new(members, fewest, rods).run(&mut self.each, &mut self.links);
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

impl<'a> Search<'a> {
    fn new<'d>(
        members: &'a [u32],
        fewest: usize,
        distances: impl Iterator<Item = (u32, &'d Distance)>,
    ) -> Self {
        let place = member_index(members);
        let (numbers, rods): (Vec<_>, Vec<_>) =
            distances.map(|(number, d)| (number, (place(d.a), place(d.b), d.rest, false))).unzip();
        let (graph, taken) = (RodGraph::new(members.len(), &rods), vec![false; rods.len()]);
        Self { members, fewest, graph, numbers, taken }
    }

    fn untaken(&self, member: u32) -> Option<RodEnd> {
        let rods = self.graph.rods_of(member).iter();
        rods.copied().find(|rod| !self.taken[rod.number as usize])
    }

    /// Whether a chain may lead through a member.
    fn is_inner(&self, member: u32) -> bool {
        self.graph.rods_of(member).len() == 2
    }

    fn run(&mut self, each: &mut Vec<Range<usize>>, links: &mut Vec<Link>) {
        let all = self.members.len() as u32;
        for member in 0..all {
            while !self.is_inner(member)
                && let Some(rod) = self.untaken(member)
            {
                self.walk(member, rod, each, links);
            }
        }
        // The remaining ones are rings.
        for member in 0..all {
            if let Some(rod) = self.untaken(member) {
                self.walk(member, rod, each, links);
            }
        }
    }

    /// Follows the rods from a member on, beginning with one of its own, until they branch or end.
    fn walk(
        &mut self,
        from: u32,
        rod: RodEnd,
        each: &mut Vec<Range<usize>>,
        links: &mut Vec<Link>,
    ) {
        let begin = links.len();
        links.push(Link { rows: [self.members[from as usize]; 2], rods: [NONE; 2], rest: 0.0 });
        let mut along = Some(rod);
        while let Some(RodEnd { to, number, rest, .. }) = along {
            self.taken[number as usize] = true;
            if to == from {
                break;
            }
            let (row, rod) = (self.members[to as usize], self.numbers[number as usize]);
            match links[begin..].last_mut() {
                Some(Link { rows: [one, other], rods: [_, knot], .. })
                    if rest == 0.0 && one == other =>
                {
                    (*other, *knot) = (row, rod);
                }
                _ => links.push(Link { rows: [row; 2], rods: [rod, NONE], rest }),
            }
            along = if self.is_inner(to) { self.untaken(to) } else { None };
        }
        if links.len() - begin > self.fewest {
            each.push(begin..links.len());
        } else {
            links.truncate(begin);
        }
    }
}
