//! The order of the particles, by who is tied to whom: what is near in the mesh is near in memory, and what can be solved row by row is in rows.
//!
//! The solver is quickest where ties run in step, from `a` to `b`, from `a + 1` to `b + 1` and so on: it reads both ends without gathering. Beyond
//! that it wants both ends of a tie close by, in the cache as in number, so that a stretch of the rows is a patch of the body. How far apart the
//! ends of any tie are, at most, is the bandwidth.

use glam::Vec3;

use super::edges::{Edges, Neighbours};
use super::grid::{Finder, ParticleGrid};
use super::{NONE, Piece};

/// The particles in their new order, by their old numbers, and the pieces of it.
///
/// Each connected piece by itself, in the order of their first particles: a grid row by row ([`grid`](super::grid)); another one breadth first from
/// its edge, or as it was if that is as good. Linear in the number of triangles, but for the sorting of neighbours.
pub(super) fn ordered(positions: &[Vec3], edges: &Edges) -> (Vec<u32>, Vec<Piece>) {
    let mut grids = Finder::new(positions, edges);
    let mut search = None;
    let (mut order, mut pieces) = (Vec::with_capacity(positions.len()), Vec::new());
    for piece in edges.pieces(positions.len()) {
        let begin = order.len() as u32;
        let columns = match grids.find(&piece) {
            Some(ParticleGrid { order: rows, columns }) => {
                order.extend(rows);
                Some(columns)
            }
            None => {
                let search =
                    search.get_or_insert_with(|| BreadthFirst::new(edges, positions.len()));
                order.extend(search.short_ties(piece));
                None
            }
        };
        pieces.push(Piece { particles: begin..order.len() as u32, columns });
    }
    (order, pieces)
}

/// Breadth-first searches.
struct BreadthFirst<'a> {
    edges: &'a Edges,
    neighbours: Neighbours,
    /// The search in which each particle was last seen; counts from 1.
    seen: Vec<u32>,
    searches: u32,
    /// The place of each particle in the order that is being looked at.
    places: Vec<u32>,
}

/// How often the way from edge to edge is sought to be longer. It is mostly after two.
const TRIES: u32 = 6;

impl<'a> BreadthFirst<'a> {
    fn new(edges: &'a Edges, particles: usize) -> Self {
        let ties = edges.list.iter().map(|edge| edge.ends);
        Self {
            edges,
            neighbours: Neighbours::of(ties, particles),
            seen: vec![0; particles],
            searches: 0,
            places: vec![NONE; particles],
        }
    }

    /// The connected piece of a particle, level by level, how many levels there are, and where the last one begins.
    fn levels(&mut self, from: u32) -> (Vec<u32>, usize, usize) {
        self.searches += 1;
        self.seen[from as usize] = self.searches;
        let mut found = vec![from];
        let (mut depth, mut level) = (0, 0..1);
        loop {
            for place in level.clone() {
                for &next in self.neighbours.around(found[place]) {
                    if self.seen[next as usize] != self.searches {
                        self.seen[next as usize] = self.searches;
                        found.push(next);
                    }
                }
            }
            if level.end == found.len() {
                return (found, depth, level.start);
            }
            (depth, level) = (depth + 1, level.end..found.len());
        }
    }

    /// A connected piece in an order of short ties. It comes, and may stay, in its old order: that of who made the mesh, often in rings or rows.
    /// It stays if it has the smaller bandwidth, or more ties that run in step and no more than twice the bandwidth.
    fn short_ties(&mut self, piece: Vec<u32>) -> Vec<u32> {
        let breadth_first = self.breadth_first(&piece);
        let [old, new] = [&piece, &breadth_first].map(|order| self.measure(order));
        let stays = old.bandwidth <= new.bandwidth
            || old.in_step > new.in_step && old.bandwidth <= 2 * new.bandwidth;
        if stays { piece } else { breadth_first }
    }

    /// The order of Cuthill and `McKee` (*Reducing the bandwidth of sparse symmetric matrices*, 1969): breadth first from a particle at the very
    /// edge, of each particle's new neighbours those with the fewest neighbours first, then as they were.
    fn breadth_first(&mut self, piece: &[u32]) -> Vec<u32> {
        let begin = self.edge_of(piece);
        self.searches += 1;
        self.seen[begin as usize] = self.searches;
        let mut order = Vec::with_capacity(piece.len());
        order.push(begin);
        let mut place = 0;
        while let Some(&here) = order.get(place) {
            let fresh = order.len();
            for &next in self.neighbours.around(here) {
                if self.seen[next as usize] != self.searches {
                    self.seen[next as usize] = self.searches;
                    order.push(next);
                }
            }
            order[fresh..].sort_by_key(|&v| self.degree(v));
            place += 1;
        }
        order
    }

    /// A particle from which it is far to the other end (George and Liu, *An implementation of a pseudoperipheral node finder*, 1979): from the
    /// farthest one on and on, as long as that is farther.
    fn edge_of(&mut self, piece: &[u32]) -> u32 {
        let fewest = |list: &[u32], own: &Self| list.iter().copied().min_by_key(|&v| own.degree(v));
        let mut best = fewest(piece, self).unwrap_or_default();
        let mut farthest = 0;
        for _ in 0..TRIES {
            let (found, depth, last) = self.levels(best);
            if depth <= farthest {
                break;
            }
            farthest = depth;
            best = fewest(&found[last..], self).unwrap_or(best);
        }
        best
    }

    fn degree(&self, particle: u32) -> usize {
        self.neighbours.around(particle).len()
    }

    fn measure(&mut self, order: &[u32]) -> Measure {
        for (place, &v) in (0..).zip(order) {
            self.places[v as usize] = place;
        }
        let mut measure = Measure { bandwidth: 0, in_step: 0 };
        for edge in order.iter().flat_map(|&v| self.edges.of_lower(v)) {
            let [a, b] = edge.ends.map(|v| self.places[v as usize]);
            measure.bandwidth = measure.bandwidth.max(a.abs_diff(b));
            let next = |place: u32| order.get(place as usize + 1);
            if let (Some(&a), Some(&b)) = (next(a), next(b)) {
                measure.in_step += u32::from(self.edges.between(a, b).is_some());
            }
        }
        measure
    }
}

/// What an order is good for.
struct Measure {
    /// How far apart the ends of a tie are at most.
    bandwidth: u32,
    /// How many ties there are whose ends' successors are tied, too.
    in_step: u32,
}
