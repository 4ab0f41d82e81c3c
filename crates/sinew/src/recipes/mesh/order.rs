//! Orders the particles by their connections: what is near in the mesh is near in memory, and grids are in rows.
//!
//! The solver is fastest where distances are in step, from `a` to `b`, from `a + 1` to `b + 1` and so on: it loads both ends without a gather. Otherwise both
//! ends of a distance should be close in number, for the cache and so that a range of rows is a connected patch of the body. The bandwidth of an order is the
//! largest difference between the ends of any edge.

use glam::Vec3;

use super::edges::{Edges, Neighbours};
use super::grid::{Finder, ParticleGrid};
use super::{NONE, Piece};

/// The particles in their new order, given by their old numbers, and the pieces.
///
/// Connected pieces follow each other in the order of their first particles. A grid is ordered row by row ([`grid`](super::grid)); any other piece breadth
/// first from a peripheral particle, or in its old order if that is as good. Linear in the number of triangles, but for the sorting of neighbours.
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
                order.extend(search.narrow_order(piece));
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
    /// The search in which each particle was last visited; counts from 1.
    visited: Vec<u32>,
    searches: u32,
    /// The place of each particle in the order that is being measured.
    places: Vec<u32>,
}

/// Maximum number of attempts to find a longer path from periphery to periphery. Two are enough in most cases.
const MAX_ATTEMPTS: u32 = 6;

impl<'a> BreadthFirst<'a> {
    fn new(edges: &'a Edges, particles: usize) -> Self {
        let ties = edges.list.iter().map(|edge| edge.ends);
        Self {
            edges,
            neighbours: Neighbours::of(ties, particles),
            visited: vec![0; particles],
            searches: 0,
            places: vec![NONE; particles],
        }
    }

    /// The connected piece of a particle in breadth-first order, the number of levels, and where the last level begins.
    fn levels(&mut self, from: u32) -> (Vec<u32>, usize, usize) {
        self.searches += 1;
        self.visited[from as usize] = self.searches;
        let mut found = vec![from];
        let (mut depth, mut level) = (0, 0..1);
        loop {
            for place in level.clone() {
                for &next in self.neighbours.around(found[place]) {
                    if self.visited[next as usize] != self.searches {
                        self.visited[next as usize] = self.searches;
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

    /// Orders a connected piece for a small bandwidth. The old order is that of the mesh's author, often in rings or rows. It is kept if it has the smaller
    /// bandwidth, or if it has more edges in step and at most twice the bandwidth.
    fn narrow_order(&mut self, piece: Vec<u32>) -> Vec<u32> {
        let breadth_first = self.breadth_first(&piece);
        let [old, new] = [&piece, &breadth_first].map(|order| self.measure(order));
        let stays = old.bandwidth <= new.bandwidth
            || old.in_step > new.in_step && old.bandwidth <= 2 * new.bandwidth;
        if stays { piece } else { breadth_first }
    }

    /// The order of Cuthill and `McKee` (*Reducing the bandwidth of sparse symmetric matrices*, 1969): breadth first from a peripheral particle; the new
    /// neighbours of each particle are sorted by their number of neighbours, fewest first, then by their old order.
    fn breadth_first(&mut self, piece: &[u32]) -> Vec<u32> {
        let begin = self.peripheral(piece);
        self.searches += 1;
        self.visited[begin as usize] = self.searches;
        let mut order = Vec::with_capacity(piece.len());
        order.push(begin);
        let mut place = 0;
        while let Some(&here) = order.get(place) {
            let fresh = order.len();
            for &next in self.neighbours.around(here) {
                if self.visited[next as usize] != self.searches {
                    self.visited[next as usize] = self.searches;
                    order.push(next);
                }
            }
            order[fresh..].sort_by_key(|&v| self.degree(v));
            place += 1;
        }
        order
    }

    /// A particle at the periphery (George and Liu, *An implementation of a pseudoperipheral node finder*, 1979): repeatedly goes to a farthest particle, as
    /// long as the distance grows.
    fn peripheral(&mut self, piece: &[u32]) -> u32 {
        let fewest = |list: &[u32], own: &Self| list.iter().copied().min_by_key(|&v| own.degree(v));
        let mut best = fewest(piece, self).unwrap_or_default();
        let mut farthest = 0;
        for _ in 0..MAX_ATTEMPTS {
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

/// Quality measures of an order.
struct Measure {
    /// Largest difference between the ends of an edge.
    bandwidth: u32,
    /// Number of edges whose ends' successors are also connected by an edge.
    in_step: u32,
}
