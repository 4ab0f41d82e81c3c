//! The edges of a mesh and the triangles at each of them: folds, borders and neighbours.

use super::{Fold, NONE};
use crate::union_find::UnionFind;

/// All edges of some triangles, sorted.
pub(in crate::recipes) struct Edges {
    pub(in crate::recipes) list: Vec<Edge>,
    /// For each particle, where in `list` the edges begin whose lower end it is; then the end of the list.
    starts: Vec<u32>,
}

/// An edge, and the triangles at it.
#[derive(Clone, Copy, Default)]
pub(in crate::recipes) struct Edge {
    /// Its particles, the lower one first.
    pub(in crate::recipes) ends: [u32; 2],
    /// The opposite corners, the lower one first; `NONE` if there is no second triangle. If there are more than two triangles, those of the first two.
    pub(super) opposite: [u32; 2],
    /// Number of triangles that have this edge.
    pub(super) triangles: u32,
}

impl Edges {
    /// The edges of triangles between this many particles. Of several triangles with the same corners, in either winding, only the first is kept.
    ///
    /// The sides of the triangles are bucketed by their lower end, so that only a handful have to be sorted at a time: by the higher end, the opposite corner
    /// and the triangle.
    pub(super) fn of(triangles: &mut Vec<[u32; 3]>, particles: usize) -> Self {
        let lowers = |&[a, b, c]: &[u32; 3]| [a.min(b), b.min(c), c.min(a)];
        let starts = bucket_starts(particles, triangles.iter().flat_map(lowers));
        let mut next = starts.clone();
        let mut bucketed = vec![0; 3 * triangles.len()];
        for (triangle, corners) in (0..).zip(triangles.iter()) {
            for (k, lower) in (0..).zip(lowers(corners)) {
                let place = &mut next[lower as usize];
                bucketed[*place as usize] = 3 * triangle + k;
                *place += 1;
            }
        }
        let side = |&number: &u32| {
            let t = triangles[number as usize / 3];
            let k = number as usize % 3;
            let higher = t[k].max(t[(k + 1) % 3]);
            (join(higher, t[(k + 2) % 3]), number / 3)
        };
        // A closed mesh has three edges for every two triangles, an open one somewhat more.
        let mut list = Vec::with_capacity(triangles.len() * 7 / 4);
        let (mut repeated, mut sides) = (Vec::new(), Vec::new());
        for (lower, span) in (0..).zip(starts.windows(2)) {
            sides.clear();
            sides.extend(bucketed[span[0] as usize..span[1] as usize].iter().map(side));
            // Among equal sides that of the earlier triangle comes first.
            sides.sort_unstable();
            sides.dedup_by(|later, first| {
                let same = later.0 == first.0;
                if same {
                    repeated.push(later.1);
                }
                same
            });
            for edge in sides.chunk_by(|a, b| a.0 >> 32 == b.0 >> 32) {
                list.push(Edge {
                    ends: [lower, (edge[0].0 >> 32) as u32],
                    opposite: [edge[0].0 as u32, edge.get(1).map_or(NONE, |side| side.0 as u32)],
                    triangles: edge.len() as u32,
                });
            }
        }
        without(triangles, repeated);
        Self { starts: bucket_starts(particles, list.iter().map(|edge| edge.ends[0])), list }
    }

    /// The same edges after renumbering the particles.
    pub(super) fn renumbered(mut self, places: &[u32]) -> Self {
        if places.iter().zip(0..).all(|(&place, old)| place == old) {
            return self;
        }
        let place = |old: u32| places.get(old as usize).copied().unwrap_or(NONE);
        for edge in &mut self.list {
            for pair in [&mut edge.ends, &mut edge.opposite] {
                let [a, b] = pair.map(place);
                *pair = [a.min(b), a.max(b)];
            }
        }
        sort(&mut self.list, places.len(), |edge| edge.ends[0], |edge| edge.ends[1].into());
        Self {
            starts: bucket_starts(places.len(), self.list.iter().map(|edge| edge.ends[0])),
            ..self
        }
    }

    /// The edges whose lower end is `particle`.
    pub(super) fn of_lower(&self, particle: u32) -> &[Edge] {
        let [from, to] = [0, 1].map(|i| self.starts[particle as usize + i] as usize);
        &self.list[from..to]
    }

    /// The edge between two particles.
    pub(super) fn between(&self, a: u32, b: u32) -> Option<&Edge> {
        let own = self.of_lower(a.min(b));
        own.binary_search_by_key(&a.max(b), |edge| edge.ends[1]).ok().map(|found| &own[found])
    }

    /// The connected pieces: the particles of each, ascending, in the order of their first particles.
    pub(super) fn pieces(&self, particles: usize) -> Vec<Vec<u32>> {
        let mut connected = UnionFind::default();
        connected.reset(particles);
        for edge in &self.list {
            connected.unite(edge.ends[0], edge.ends[1]);
        }
        let mut pieces: Vec<Vec<u32>> = Vec::new();
        let mut numbers = vec![0; particles];
        for particle in 0..particles as u32 {
            let first = connected.root(particle);
            if first == particle {
                numbers[particle as usize] = pieces.len();
                pieces.push(Vec::new());
            }
            pieces[numbers[first as usize]].push(particle);
        }
        pieces
    }

    /// The edges between exactly two triangles.
    pub(in crate::recipes) fn bends(&self) -> impl Iterator<Item = Fold> {
        let inner = self.list.iter().filter(|edge| edge.triangles == 2);
        inner.map(|edge| Fold { edge: edge.ends, opposite: edge.opposite })
    }
}

impl Edge {
    /// The opposite corner in the triangle whose opposite corner is not `corner`; `None` at a border.
    pub(super) fn across(&self, corner: u32) -> Option<u32> {
        let [low, high] = self.opposite;
        let other = if low == corner { high } else { low };
        (other != NONE).then_some(other)
    }
}

/// The neighbours of each particle.
pub(super) struct Neighbours {
    list: Vec<u32>,
    starts: Vec<u32>,
}

impl Neighbours {
    /// Built from sorted pairs of particles, which makes the neighbours of each particle sorted too.
    pub(super) fn of(pairs: impl Iterator<Item = [u32; 2]> + Clone, particles: usize) -> Self {
        let starts = bucket_starts(particles, pairs.clone().flatten());
        let mut next = starts.clone();
        let mut list = vec![0; starts[particles] as usize];
        // The lower neighbours first, in the order of the lower ends, and then the higher ones.
        for [a, b] in pairs.clone() {
            list[next[b as usize] as usize] = a;
            next[b as usize] += 1;
        }
        for [a, b] in pairs {
            list[next[a as usize] as usize] = b;
            next[a as usize] += 1;
        }
        Self { list, starts }
    }

    /// The neighbours of `particle`, ascending.
    pub(super) fn around(&self, particle: u32) -> &[u32] {
        let [from, to] = [0, 1].map(|i| self.starts[particle as usize + i] as usize);
        &self.list[from..to]
    }
}

/// Sorts items by particle, then by a key. There are only a handful of items for each particle, so they are bucketed by particle first, which takes a fraction
/// of the time of sorting them all.
pub(in crate::recipes) fn sort<T: Copy>(
    items: &mut Vec<T>,
    particles: usize,
    particle: impl Fn(&T) -> u32,
    key: impl Fn(&T) -> u64,
) {
    let starts = bucket_starts(particles, items.iter().map(&particle));
    let mut next = starts.clone();
    // Sorts keys with item numbers: equal keys stay in order, and the sort is compiled once instead of for each item type.
    let mut order = vec![(0, 0); items.len()];
    for (number, item) in (0..).zip(items.iter()) {
        let place = &mut next[particle(item) as usize];
        order[*place as usize] = (key(item), number);
        *place += 1;
    }
    sort_spans(&mut order, &starts);
    *items = order.iter().map(|&(_, number)| items[number as usize]).collect();
}

/// Sorts each of the spans between two starts.
fn sort_spans(order: &mut [(u64, u32)], starts: &[u32]) {
    for span in starts.windows(2) {
        order[span[0] as usize..span[1] as usize].sort_unstable();
    }
}

/// Packs two numbers into one, the first in the upper half.
pub(super) fn join(high: u32, low: u32) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}

/// Bucket offsets: where the items of each particle begin when they are bucketed by particle, and the end of the last bucket.
fn bucket_starts(particles: usize, items: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut starts = vec![0; particles + 1];
    items.for_each(|item| starts[item as usize + 1] += 1);
    let mut sum = 0;
    for start in &mut starts {
        sum += *start;
        *start = sum;
    }
    starts
}

/// Removes the triangles with these numbers, which may contain duplicates.
fn without(triangles: &mut Vec<[u32; 3]>, mut numbers: Vec<u32>) {
    if numbers.is_empty() {
        return;
    }
    numbers.sort_unstable();
    numbers.dedup();
    let mut gone = numbers.into_iter().peekable();
    let mut number = 0..;
    triangles.retain(|_| gone.next_if_eq(&number.next().unwrap_or(NONE)).is_none());
}
