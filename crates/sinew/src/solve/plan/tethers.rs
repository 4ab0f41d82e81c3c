//! The tethers and spans of a plan's islands, found from their rods and pins when those have changed.

use super::{GroupKind, Plan};
use crate::constraints::{Bound, Distance, Softness};
use crate::hash::fnv;
use crate::islands::{Island, member_index};
use crate::particles::Particles;
use crate::solve::rod_graph::RodGraph;
use crate::solve::tethers::{IslandTethers, PinFields, Spans, TetherPaths, Tethers};
use crate::solve::tie_rods::TieRods;

/// Islands of no more particles get no tethers: only one or two rods lie between any particle and its pin.
const SMALL: usize = 3;

impl Plan {
    /// Updates the tethers of the islands for this step. `Island::free` has to be up to date.
    pub(crate) fn tether(&mut self, particles: &Particles) {
        let mut tethers = core::mem::take(&mut self.tethers);
        let mut before = Vec::new();
        if core::mem::take(&mut tethers.stale) {
            let islands = &mut self.islands.list;
            before = keep(&mut tethers.islands, islands, |island| &mut island.tethers);
            keep(&mut tethers.spans, islands, |island| &mut island.spans);
            keep(&mut tethers.graphs, islands, |island| &mut island.rod_graph);
            keep(&mut tethers.tie_rods, islands, |island| &mut island.tie_rods);
            // The rods were renumbered.
            tethers.islands.iter_mut().for_each(|made| made.paths = None);
        }
        for number in 0..self.islands.list.len() {
            let island = &self.islands.list[number];
            let spans = island.microsteps > 1 && island.has_long_range() && island.spans.is_none();
            if spans {
                tethers.spans.push(self.spans(number));
                self.islands.list[number].spans = Some(tethers.spans.len() as u32 - 1);
            }
            let island = &self.islands.list[number];
            if island.microsteps > 1 && island.rod_graph.is_none() {
                tethers.graphs.push(self.graph(island));
                self.islands.list[number].rod_graph = Some(tethers.graphs.len() as u32 - 1);
            }
            self.find_tie_rods(number, particles, &mut tethers);
            let island = &mut self.islands.list[number];
            let small = island.members.len() <= SMALL && !island.measured;
            if small {
                island.tethers = None;
            }
            if small || island.groups.is_empty() || island.rigid || !island.has_long_range() {
                continue;
            }
            let island = &self.islands.list[number];
            let members = &self.islands.members[island.members.clone()];
            let held = |row: &u32| particles.position[*row as usize].w == 0.0;
            let own = tethers.made(island);
            let pins = || members.iter().copied().filter(held);
            if own.map_or(island.free, |own| own.pins.iter().copied().eq(pins())) {
                continue;
            }
            let place = match island.tethers {
                Some(place) => place as usize,
                None => tethers.islands.len(),
            };
            let pins: Vec<u32> = if island.free { Vec::new() } else { pins().collect() };
            let key = self.key(island, &pins);
            let known = before.iter().position(|other| other.key == key);
            // Many consecutive islands may have the same topology.
            let equal = tethers.islands.last().filter(|last| last.key == key);
            let (fields, each) = match (known, equal) {
                (Some(at), _) => {
                    let known = before.swap_remove(at);
                    (known.fields, known.each)
                }
                (None, Some(equal)) => (None, equal.each.clone()),
                (None, None) if pins.is_empty() => Default::default(),
                (None, None) => {
                    let mut same = before.iter_mut().filter(|other| other.pins == pins);
                    let known = same.find_map(|other| other.fields.take());
                    let sources = self.places(island, &pins);
                    let fields = match tethers.graph_of(island) {
                        Some(graph) => PinFields::of(graph, sources, known),
                        None => PinFields::of(&self.graph(island), sources, known),
                    };
                    let each = fields.lengths();
                    (Some(fields), each)
                }
            };
            let begin = island.members.start;
            let run = island.contiguous.start - begin..island.contiguous.end - begin;
            let made = IslandTethers::of((members, run), (key, pins), fields, each);
            if place == tethers.islands.len() {
                tethers.islands.push(made);
            } else {
                tethers.islands[place] = made;
            }
            self.islands.list[number].tethers = Some(place as u32);
        }
        for island in self.islands.list.iter().filter(|island| island.measured) {
            let Some(place) = island.tethers else { continue };
            let made = &mut tethers.islands[place as usize];
            if made.paths.is_none() && !made.blocks.is_empty() {
                made.paths = Some(self.paths(island, &made.pins));
            }
        }
        self.tethers = tethers;
    }

    /// Finds the tie rods of an island that takes microsteps, if they are not up to date.
    fn find_tie_rods(&mut self, number: usize, particles: &Particles, tethers: &mut Tethers) {
        let (island, edits) = (&self.islands.list[number], particles.edits());
        let known = island.tie_rods.map(|place| &tethers.tie_rods[place as usize]);
        let is_known = known.is_some_and(|known| known.edits == edits);
        if island.microsteps <= 1 || is_known {
            return;
        }
        let body = |row: u32| particles.body[row as usize];
        let rods = self.rods(island).filter(|(_, d)| body(d.a) != body(d.b));
        let mut tied: Vec<u32> = rods.flat_map(|(_, d)| [d.a, d.b]).collect();
        let groups = self.groups[island.groups.clone()].iter();
        let constraints = groups.filter(|group| group.kind == GroupKind::Constraints);
        for constraint in constraints.flat_map(|group| &self.constraints[group.range.clone()]) {
            let rows = &constraint.rows;
            let of_several = rows.iter().any(|&row| body(row) != body(rows[0]));
            if of_several && constraint.kind.equation().softness().is_hard() {
                tied.extend(rows);
            }
        }
        tied.sort_unstable();
        tied.dedup();
        let found = match tethers.graph_of(island) {
            Some(graph) if !tied.is_empty() => {
                let members = &self.islands.members[island.members.clone()];
                TieRods::of(graph, members, self.places(island, &tied), edits)
            }
            _ => TieRods::none(edits),
        };
        match self.islands.list[number].tie_rods {
            Some(place) => tethers.tie_rods[place as usize] = found,
            None => {
                tethers.tie_rods.push(found);
                self.islands.list[number].tie_rods = Some(tethers.tie_rods.len() as u32 - 1);
            }
        }
    }

    /// The spans of an island, within its contiguous run of rows.
    fn spans(&self, number: usize) -> Spans {
        let island = &self.islands.list[number];
        let run = self.contiguous_rows(island);
        let within = |d: &&Distance| run.contains(&d.a) && run.contains(&d.b);
        Spans::of(run.start, run.len(), self.rods(island).map(|(_, d)| d).filter(within))
    }

    /// The paths of an island's tethers along its rods.
    fn paths(&self, island: &Island, pins: &[u32]) -> TetherPaths {
        let (graph, sources) = (self.graph(island), self.places(island, pins));
        let nearest = graph.field(&sources);
        let fields = PinFields::of(&graph, sources, None);
        let numbers: Vec<u32> = self.rods(island).map(|(number, _)| number).collect();
        let inwards = [Some(&nearest), fields.from(0), fields.from(1)].map(|field| {
            let all = field.into_iter().flat_map(|field| field.inwards(&graph));
            all.map(|(member, before, rod)| (member, before, numbers[rod as usize])).collect()
        });
        TetherPaths { far: fields.far, inwards }
    }

    /// The hard distances of an island that hold particles together, with their plan indices.
    fn rods(&self, island: &Island) -> impl Iterator<Item = (u32, &Distance)> {
        let groups = self.groups[island.groups.clone()].iter();
        groups
            .filter(|group| group.kind != GroupKind::Constraints)
            .flat_map(|group| {
                (group.range.start as u32..).zip(&self.distances[group.range.clone()])
            })
            .filter(|(_, d)| is_rod_or_rope(d))
    }

    fn key(&self, island: &Island, pins: &[u32]) -> u64 {
        let first = self.islands.members[island.members.start];
        let rods = self.rods(island);
        let rods = rods.flat_map(|(_, d)| [d.a - first, d.b - first, d.rest.to_bits()]);
        let pins = pins.iter().map(|pin| pin - first);
        fnv([island.members.len() as u32].into_iter().chain(rods).chain(pins))
    }

    /// The hard distances of an island, as rods between member indices.
    fn graph(&self, island: &Island) -> RodGraph {
        let members = &self.islands.members[island.members.clone()];
        let place = member_index(members);
        let rod =
            |(_, d): (u32, &Distance)| (place(d.a), place(d.b), d.rest, d.bound == Bound::AtMost);
        let rods: Vec<_> = self.rods(island).map(rod).collect();
        RodGraph::shortest(members.len(), &rods)
    }

    /// Member indices of rows in an island.
    fn places(&self, island: &Island, rows: &[u32]) -> Vec<u32> {
        let members = &self.islands.members[island.members.clone()];
        rows.iter().copied().map(member_index(members)).collect()
    }
}

/// Keeps the entries that islands still refer to, in island order, updates their indices, and returns the entries that are no longer used.
fn keep<T>(
    list: &mut Vec<T>,
    islands: &mut [Island],
    own: impl Fn(&mut Island) -> &mut Option<u32>,
) -> Vec<T> {
    let mut before: Vec<Option<T>> = core::mem::take(list).into_iter().map(Some).collect();
    for place in islands.iter_mut().map(own) {
        let kept = place.and_then(|place| before[place as usize].take());
        *place = kept.map(|kept| {
            list.push(kept);
            list.len() as u32 - 1
        });
    }
    before.into_iter().flatten().collect()
}

/// Whether a distance holds its particles together without yielding, so that a tether may rely on it.
fn is_rod_or_rope(d: &Distance) -> bool {
    d.softness == Softness::Hard && d.bound != Bound::AtLeast
}
