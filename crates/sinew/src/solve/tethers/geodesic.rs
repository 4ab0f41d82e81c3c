//! The shortest ways along a web of rods: over the triangles that they span, not only along the rods.
//!
//! Along the rods of a square with both diagonals a way is up to 8 % longer than the straight line, and a tether of that length would hold too late. So
//! the way may cross a triangle: from its side of length `c`, whose ends are `a` and `b` from the source, to its third corner, `p` and `q` from those ends.
//! Unfolded into a plane, the source is where circles of `a` and `b` meet on the one side, the corner where those of `p` and `q` meet on the other:
//!
//! ```text
//! source (s, -√(a² - s²)),  s = (a² + c² - b²)/2c        corner (t, √(p² - t²)),  t = (p² + c² - q²)/2c
//! ```
//!
//! and if the line between the two crosses the side, it is the way.
//!
//! **It is a bound whatever shape the cloth is in**, and however the web was bent when it was made. A point that divides the side as `u : 1 - u` is, by
//! Stewart's theorem, no farther from the source than `√((1 - u) a² + u b² - u (1 - u) c²)` if its ends are no farther than `a` and `b`, and that is
//! how far it is in the plane; the rest of the way is within a triangle whose sides are rods. So no tether asks for more than the rods it stands for.
//!
//! The order is Dijkstra's; ways over triangles as in Novotni and Klein, *Computing Geodesic Distances on Triangular Meshes*, 2002.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

/// Particles and the rods between them.
pub(super) struct Web {
    /// Where the rods of each particle begin, and in the end their number.
    first: Vec<u32>,
    /// The other end of each, its number, and its length, metres.
    rods: Vec<(u32, u32, f64)>,
}

/// How far each particle is from the nearest of some sources.
pub(super) struct DistanceField {
    length: Vec<f64>,
    source: Vec<u32>,
    /// The particle before each on its way along rods, and the number of the rod between the two.
    toward: Vec<(u32, u32)>,
    /// All that were reached, each after the one before it on its way: those in one place are equally far.
    order: Vec<u32>,
}

impl DistanceField {
    /// The particles that rods lead to, less the sources, the farthest first, with the one before each on its way and the number of the rod between.
    pub(super) fn inwards(&self) -> Vec<(u32, u32, u32)> {
        let each = self.order.iter().rev().map(|&i| (i, self.toward[i as usize]));
        let reached = each.filter(|(_, (_, rod))| *rod != u32::MAX);
        reached.map(|(i, (before, rod))| (i, before, rod)).collect()
    }

    /// Metres; infinite where no rods lead.
    pub(super) fn length(&self, particle: u32) -> f64 {
        self.length[particle as usize]
    }

    /// Which of the sources it is.
    pub(super) fn source(&self, particle: u32) -> u32 {
        self.source[particle as usize]
    }
}

impl Web {
    /// Of so many particles.
    pub(super) fn new(particles: usize, rods: &[(u32, u32, f32)]) -> Self {
        let mut first = vec![0_u32; particles + 1];
        for &(a, b, _) in rods {
            first[a as usize + 1] += 1;
            first[b as usize + 1] += 1;
        }
        for particle in 0..particles {
            first[particle + 1] += first[particle];
        }
        let (mut next, mut all) = (first.clone(), vec![(0, 0, 0.0); 2 * rods.len()]);
        for (&(a, b, rest), number) in rods.iter().zip(0..) {
            for (from, to) in [(a, b), (b, a)] {
                let place = &mut next[from as usize];
                all[*place as usize] = (to, number, f64::from(rest));
                *place += 1;
            }
        }
        Self { first, rods: all }
    }

    fn rods_of(&self, particle: u32) -> &[(u32, u32, f64)] {
        let at = particle as usize;
        &self.rods[self.first[at] as usize..self.first[at + 1] as usize]
    }

    /// How far each particle is from the nearest of some.
    pub(super) fn field(&self, sources: &[u32]) -> DistanceField {
        let particles = self.first.len() - 1;
        let (mut length, mut source) = (vec![f64::INFINITY; particles], vec![0; particles]);
        let mut toward = vec![(0, u32::MAX); particles];
        let (mut done, mut order) = (vec![false; particles], Vec::with_capacity(particles));
        // Beside which particle each was seen last, and how long the rod between the two is.
        let mut beside = vec![(u32::MAX, 0.0_f64); particles];
        let mut open = BinaryHeap::new();
        for (number, &particle) in (0..).zip(sources) {
            (length[particle as usize], source[particle as usize]) = (0.0, number);
            // The bits of numbers that are not negative order as they do.
            open.push(Reverse((0_u64, particle)));
        }
        while let Some(Reverse((_, near))) = open.pop() {
            if core::mem::replace(&mut done[near as usize], true) {
                continue;
            }
            order.push(near);
            let (a, own) = (length[near as usize], source[near as usize]);
            for &(other, _, c) in self.rods_of(near) {
                beside[other as usize] = (near, c);
            }
            for &(corner, number, p) in self.rods_of(near) {
                let at = corner as usize;
                if done[at] {
                    continue;
                }
                let mut best = a + p;
                for &(other, _, q) in self.rods_of(corner) {
                    let (i, (seen, c)) = (other as usize, beside[other as usize]);
                    if seen == near && done[i] && source[i] == own {
                        best = best.min(across([a, length[i]], c, [p, q]));
                    }
                }
                if best < length[at] {
                    (length[at], source[at], toward[at]) = (best, own, (near, number));
                    open.push(Reverse((best.to_bits(), corner)));
                }
            }
        }
        DistanceField { length, source, toward, order }
    }
}

/// The way across a side of length `c`, as above; infinite if the straight line does not cross it, or those lengths make no triangles.
fn across([a, b]: [f64; 2], c: f64, [p, q]: [f64; 2]) -> f64 {
    let along = |near: f64, far: f64| (near * near + c * c - far * far) / (2.0 * c);
    let (s, t) = (along(a, b), along(p, q));
    let (below, above) = (a * a - s * s, p * p - t * t);
    // Also of a side of no length.
    if !(below > 0.0 && above > 0.0) {
        return f64::INFINITY;
    }
    let (below, above) = (below.sqrt(), above.sqrt());
    let crossing = s + (t - s) * below / (below + above);
    if !(0.0..=c).contains(&crossing) {
        return f64::INFINITY;
    }
    let (x, y) = (t - s, below + above);
    (x * x + y * y).sqrt()
}
