//! Shortest paths along the rods of a graph, and across the triangles that the rods form.
//!
//! Along the rods of a square with both diagonals, a path is up to 8 % longer than the straight line, and a tether of that length would engage too late. So a
//! path may cross a triangle: from its side of length `c`, whose ends are at `a` and `b` from the source, to its third corner, at `p` and `q` from those ends.
//! Unfolded into a plane, the source is where the circles of radius `a` and `b` meet on one side, and the corner where those of `p` and `q` meet on the other:
//!
//! ```text
//! source (s, -√(a² - s²)),  s = (a² + c² - b²)/2c        corner (t, √(p² - t²)),  t = (p² + c² - q²)/2c
//! ```
//!
//! If the line between the two crosses the side, it is the path.
//!
//! **This is an upper bound whatever shape the cloth is in**, and whatever the rods' positions were when it was computed. By Stewart's theorem, a point that
//! divides the side as `u : 1 - u` is no farther from the source than `√((1 - u) a² + u b² - u (1 - u) c²)` if the side's ends are no farther than `a` and `b`,
//! and this is its distance in the plane. The rest of the path lies within a triangle whose sides are rods. So no tether requires more than the rods that it
//! stands for.
//!
//! The order is Dijkstra's; paths across triangles are as in Novotni and Klein, *Computing Geodesic Distances on Triangular Meshes*, 2002.
//!
//! # Tears
//!
//! The result does not depend on the order of the search: each particle has the shortest of the paths that its neighbours offer, and a path continues only from
//! a particle nearer to the source. So when some rods have changed, a field can be [updated](RodGraph::update) where it depended on them (dynamic shortest
//! paths; Ramalingam and Reps, *An Incremental Algorithm for a Generalization of the Shortest-Path Problem*, 1996), with the bits of one computed from scratch.
//! Behind a tear those particles are its shadow, as seen from the source.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::solve::rod_graph::{RodEnd, RodGraph};

/// No particle, and no rod.
const NONE: u32 = u32::MAX;

/// The distance of each particle from the nearest of some sources.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::solve) struct DistanceField {
    paths: Vec<Path>,
}

/// The shortest path of a particle. Of several of equal length, the first in the order of these fields.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Path {
    /// Metres; infinite where no rods lead.
    length: f64,
    /// Greater than the steps of the particles that it crosses, so that of two at equal distance one counts as nearer.
    steps: u32,
    /// Index of the source.
    source: u32,
    /// The particles that it crosses: the farther end of the side that it crosses, and the other end, if there is one. A source has neither.
    over: [u32; 2],
}

impl Path {
    const UNKNOWN: Self = Self { length: f64::INFINITY, steps: NONE, source: 0, over: [NONE; 2] };

    fn is_known(&self) -> bool {
        self.length < f64::INFINITY
    }

    fn is_of_a_source(&self) -> bool {
        self.is_known() && self.over[0] == NONE
    }

    /// Whether it crosses a particle.
    fn leads_over(&self, particle: u32) -> bool {
        self.over.contains(&particle)
    }

    /// The sorting order of particles, nearest first: length, steps and index. The bits of non-negative lengths sort as the lengths do.
    fn order(&self, particle: u32) -> (u64, u32, u32) {
        (self.length.to_bits(), self.steps, particle)
    }
}

impl DistanceField {
    /// The reached particles other than the sources, farthest first, each with the previous one on its path and the index of the rod between them.
    pub(in crate::solve) fn inwards(&self, graph: &RodGraph) -> Vec<(u32, u32, u32)> {
        let known = |i: &u32| {
            let path = self.paths[*i as usize];
            path.is_known() && !path.is_of_a_source()
        };
        let mut reached: Vec<u32> = (0..self.paths.len() as u32).filter(known).collect();
        reached.sort_unstable_by_key(|&i| Reverse(self.paths[i as usize].order(i)));
        let each = reached.into_iter().filter_map(|i| {
            let before = self.paths[i as usize].over[0];
            let rod = graph.rods_of(i).iter().find(|rod| rod.to == before)?;
            Some((i, before, rod.number))
        });
        each.collect()
    }

    /// Metres; infinite where no rods lead.
    pub(super) fn length(&self, particle: u32) -> f64 {
        self.paths[particle as usize].length
    }

    /// Index of the nearest source.
    pub(super) fn source(&self, particle: u32) -> u32 {
        self.paths[particle as usize].source
    }
}

impl RodGraph {
    /// The distance of each particle from the nearest of these sources.
    pub(in crate::solve) fn field(&self, sources: &[u32]) -> DistanceField {
        let mut field = DistanceField { paths: vec![Path::UNKNOWN; self.particles()] };
        let mut search = Search::of(self, &mut field);
        for (source, &particle) in (0..).zip(sources) {
            search.offer(particle, Path { length: 0.0, steps: 0, source, over: [NONE; 2] });
        }
        search.run();
        field
    }

    /// Updates a field that was correct before the rods of the `changed` particles, and of no others, changed: to the bits of a [new one](Self::field).
    pub(super) fn update(&self, field: &mut DistanceField, changed: &[u32]) {
        // A side of a triangle may be, or have been, between two of them.
        let mut beside: Vec<u32> =
            changed.iter().flat_map(|&one| self.rods_of(one)).map(|rod| rod.to).collect();
        beside.sort_unstable();
        let corners = beside.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        let mut affected: Vec<u32> = changed.iter().copied().chain(corners).collect();
        // Nearest first: the paths that theirs depend on are then correct, or discarded.
        affected.sort_unstable_by_key(|&one| field.paths[one as usize].order(one));
        affected.dedup();
        let mut search = Search::of(self, field);
        for particle in affected {
            search.recheck(particle);
        }
        search.recover();
        search.run();
    }
}

/// The search for shortest paths.
///
/// Particles that are final, as far as is known, extend paths to others. The others are open: the nearest open particle becomes final, as no shorter path to it
/// can be found any more.
struct Search<'a> {
    graph: &'a RodGraph,
    paths: &'a mut [Path],
    states: Vec<State>,
    /// The open particles, nearest first; and outdated entries.
    open: BinaryHeap<Reverse<(u64, u32, u32)>>,
    /// Particles that have lost their paths and have to be recomputed from their neighbours.
    lost: Vec<u32>,
    /// For each particle, the neighbour from which it was last marked, and the length of the rod between the two.
    marks: Vec<(u32, f32)>,
}

/// State of the search for a particle's path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Final,
    Open,
    Lost,
}

impl<'a> Search<'a> {
    fn of(graph: &'a RodGraph, field: &'a mut DistanceField) -> Self {
        let particles = field.paths.len();
        Self {
            graph,
            paths: &mut field.paths,
            states: vec![State::Final; particles],
            open: BinaryHeap::new(),
            lost: Vec::new(),
            marks: vec![(NONE, 0.0); particles],
        }
    }

    /// Continues until all are final.
    fn run(&mut self) {
        while let Some(Reverse(order)) = self.open.pop() {
            let near = order.2;
            let (path, state) = (self.paths[near as usize], &mut self.states[near as usize]);
            if *state == State::Open && path.order(near) == order {
                *state = State::Final;
                self.extend_from(near);
                self.lose_dependents();
                self.recover();
            }
        }
    }

    /// Offers the neighbours of a particle that has become final the paths across it, and those across it and another final one.
    fn extend_from(&mut self, near: u32) {
        let (graph, own) = (self.graph, self.paths[near as usize]);
        self.mark_neighbours(near);
        for &RodEnd { to: corner, rest: p, .. } in graph.rods_of(near) {
            let known = self.paths[corner as usize].order(corner);
            if self.is_final(corner) && known < own.order(near) {
                continue;
            }
            let mut best = along(&own, near, p);
            for &RodEnd { to: other, rest: q, .. } in graph.rods_of(corner) {
                let (marked_from, c) = self.marks[other as usize];
                if marked_from == near && self.is_final(other) {
                    let ends = [own, self.paths[other as usize]];
                    best = first_of(best, across_side(ends, [near, other], c, [p, q]));
                }
            }
            self.offer(corner, best);
        }
    }

    /// Assigns a path to a particle if it is shorter than its present one. Paths across that particle are then discarded.
    fn offer(&mut self, particle: u32, path: Path) {
        let at = particle as usize;
        if path >= self.paths[at] {
            return;
        }
        let was_final = self.is_final(particle);
        (self.paths[at], self.states[at]) = (path, State::Open);
        self.open.push(Reverse(path.order(particle)));
        if was_final {
            self.lose_those_over(particle);
        }
    }

    /// Discards the path of a particle, and those across it, if its final neighbours do not offer the same path as the best one.
    fn recheck(&mut self, particle: u32) {
        let path = self.paths[particle as usize];
        if self.states[particle as usize] == State::Final
            && !path.is_of_a_source()
            && self.best(particle) != path
        {
            self.lose(particle);
            self.lose_dependents();
        }
    }

    /// Discards the path of a particle that is no source.
    fn lose(&mut self, particle: u32) {
        let at = particle as usize;
        if !self.paths[at].is_of_a_source() && self.states[at] != State::Lost {
            (self.paths[at], self.states[at]) = (Path::UNKNOWN, State::Lost);
            self.lost.push(particle);
        }
    }

    fn lose_those_over(&mut self, particle: u32) {
        let graph = self.graph;
        for &RodEnd { to: corner, .. } in graph.rods_of(particle) {
            if self.paths[corner as usize].leads_over(particle) {
                self.lose(corner);
            }
        }
    }

    /// Discards the paths across particles that have lost theirs, transitively.
    fn lose_dependents(&mut self) {
        let mut next = 0;
        while let Some(&particle) = self.lost.get(next) {
            self.lose_those_over(particle);
            next += 1;
        }
    }

    /// Assigns the best paths that final neighbours offer to the particles that have lost theirs.
    fn recover(&mut self) {
        while let Some(particle) = self.lost.pop() {
            let best = self.best(particle);
            if self.states[particle as usize] == State::Lost {
                self.states[particle as usize] = State::Final;
            }
            self.offer(particle, best);
        }
    }

    /// The best path that the final neighbours of a particle offer.
    fn best(&mut self, particle: u32) -> Path {
        self.mark_neighbours(particle);
        let graph = self.graph;
        let mut best = Path::UNKNOWN;
        for &RodEnd { to: near, rest: p, .. } in
            graph.rods_of(particle).iter().filter(|rod| self.is_final(rod.to))
        {
            let own = self.paths[near as usize];
            best = first_of(best, along(&own, near, p));
            for &RodEnd { to: other, rest: c, .. } in graph.rods_of(near) {
                let (marked_from, q) = self.marks[other as usize];
                if marked_from == particle && other > near && self.is_final(other) {
                    let ends = [own, self.paths[other as usize]];
                    best = first_of(best, across_side(ends, [near, other], c, [p, q]));
                }
            }
        }
        best
    }

    /// Whether a particle has a path that is final as far as is known.
    fn is_final(&self, particle: u32) -> bool {
        self.states[particle as usize] == State::Final && self.paths[particle as usize].is_known()
    }

    /// Marks the neighbours of a particle.
    fn mark_neighbours(&mut self, particle: u32) {
        for &RodEnd { to, rest, .. } in self.graph.rods_of(particle) {
            self.marks[to as usize] = (particle, rest);
        }
    }
}

fn first_of(one: Path, other: Path) -> Path {
    if other < one { other } else { one }
}

/// The path extended from a particle along a rod of length `p`.
fn along(own: &Path, near: u32, p: f32) -> Path {
    Path {
        length: own.length + f64::from(p),
        steps: own.steps.saturating_add(1),
        source: own.source,
        over: [near, NONE],
    }
}

/// The path across the side of length `c` between two particles, which are at `p` and `q` from the corner. Unknown if their paths lead to different sources, or
/// if the corner would be nearer than they are: then its path crosses other particles.
fn across_side(ends: [Path; 2], numbers: [u32; 2], c: f32, rods: [f32; 2]) -> Path {
    let second = ends[0].order(numbers[0]) < ends[1].order(numbers[1]);
    let [far, near] = if second { [1, 0] } else { [0, 1] };
    let (own, other) = (ends[far], ends[near]);
    if own.source != other.source {
        return Path::UNKNOWN;
    }
    let length =
        across([own.length, other.length], c.into(), [rods[far].into(), rods[near].into()]);
    if length < own.length || length == f64::INFINITY {
        return Path::UNKNOWN;
    }
    Path {
        length,
        steps: own.steps.max(other.steps).saturating_add(1),
        source: own.source,
        over: [numbers[far], numbers[near]],
    }
}

/// The length of the path across a side of length `c`, as above; infinite if the straight line does not cross it, or if the lengths form no triangles.
fn across([a, b]: [f64; 2], c: f64, [p, q]: [f64; 2]) -> f64 {
    let along = |near: f64, far: f64| (near * near + c * c - far * far) / (2.0 * c);
    let (s, t) = (along(a, b), along(p, q));
    let (below, above) = (a * a - s * s, p * p - t * t);
    // False also for a side of no length.
    if !(below > 0.0 && above > 0.0) {
        return f64::INFINITY;
    }
    let (below, above) = (below.sqrt(), above.sqrt());
    let (x, y) = (t - s, below + above);
    // Where it crosses the side, times `y`.
    if !(0.0..=c * y).contains(&(s * above + t * below)) {
        return f64::INFINITY;
    }
    (x * x + y * y).sqrt()
}
