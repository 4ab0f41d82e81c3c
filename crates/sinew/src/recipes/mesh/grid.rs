//! Detects a mesh that is a rectangular grid of cells, each cut in two along either diagonal. It is detected from the triangles alone: whatever the order of
//! triangles and vertices, and however it is bent, stretched or sheared.
//!
//! # Detection
//!
//! A grid of `W × H` particles is a disc with one border of `B = 2(W + H) - 4` edges. With `W·H` particles, the sides are the roots of `x² - (B/2 + 2) x +
//! W·H`. Its corners are on the border, as far apart as the sides are long, and have at most two triangles; so only a few positions on the border are
//! candidates, mostly one. From a corner the first row and the first column are known: they are the border. Then, cell after cell, the triangle below the upper
//! side `ab` of a cell determines the cell:
//!
//! ```text
//! a──b      its third corner is c, which is known: the diagonal is bc, and d is across it
//! │  │
//! c──d      or else it is d: the diagonal is ad, and what is across it must be c
//! ```
//!
//! If no particle occurs twice and there are as many triangles as the cells need, the mesh is a grid: no two cells share a triangle, so all were used.

use core::cmp::Ordering;

use glam::{DVec3, Vec3};

use super::NONE;
use super::edges::Edges;

/// Finds grids among the pieces of a mesh.
pub(super) struct Finder<'a> {
    positions: &'a [Vec3],
    edges: &'a Edges,
    /// The neighbours of each particle along the border.
    border: Vec<[u32; 2]>,
    /// The attempt in which each particle was last put into a row; counts from 1.
    put: Vec<u32>,
    attempt: u32,
}

/// The particles of a grid, row by row.
pub(super) struct ParticleGrid {
    pub(super) order: Vec<u32>,
    /// Number of particles in a row.
    pub(super) columns: u32,
}

/// A candidate placement of the grid's corners on the border.
struct Placement {
    /// Sum of the cosines of the four corner angles: the closer to right angles, the smaller.
    bluntness: f64,
    /// Where on the border the first row begins, and whether it runs backwards along the border.
    first: usize,
    backwards: bool,
}

impl<'a> Finder<'a> {
    pub(super) fn new(positions: &'a [Vec3], edges: &'a Edges) -> Self {
        let particles = positions.len();
        Self {
            positions,
            edges,
            border: vec![[NONE; 2]; particles],
            put: vec![0; particles],
            attempt: 0,
        }
    }

    /// The rows of a connected piece, if it is a grid.
    ///
    /// A row runs along the longer side: the solver processes runs of distances along a row, or between one row and the next, without a gather, and these runs
    /// are as long as the rows. The first row starts at the corner that comes first: the highest, and among equally high ones that with the lowest x, then z.
    /// In a square it runs towards the neighbour that comes first. So shuffling a mesh changes nothing, and a square in the xy plane is numbered as by
    /// [`cloth_grid`](crate::recipes::cloth_grid).
    pub(super) fn find(&mut self, piece: &[u32]) -> Option<ParticleGrid> {
        let border = self.walk_border(piece)?;
        let sides = self.sides(piece, border.len())?;
        let mut placements = self.placements(&border, sides);
        let [columns, rows] = sides;
        // The most rectangular candidate is right in most cases. In a mesh where all of the border consists of possible corners, such as a fan, there are many
        // candidates; the search is limited to a few passes over the whole piece.
        placements.sort_by(|a, b| {
            let place = |placement: &Placement| self.positions[border[placement.first] as usize];
            a.bluntness.total_cmp(&b.bluntness).then_with(|| compare(place(a), place(b)))
        });
        let mut budget = 4 * piece.len();
        placements.iter().find_map(|placement| {
            let along = |steps: usize| {
                let steps = steps % border.len();
                let back = if placement.backwards { border.len() - steps } else { steps };
                border[(placement.first + back) % border.len()]
            };
            if budget == 0 {
                return None;
            }
            let order = self.fill(sides, along, &mut budget)?;
            debug_assert_eq!(order.len(), columns * rows);
            Some(ParticleGrid { order, columns: columns as u32 })
        })
    }

    /// The particles of the border in order, if there is exactly one border.
    fn walk_border(&mut self, piece: &[u32]) -> Option<Vec<u32>> {
        let mut length = 0;
        for edge in piece.iter().flat_map(|&v| self.edges.of_lower(v)) {
            if edge.triangles == 1 {
                length += 1;
                for (from, to) in [(0, 1), (1, 0)] {
                    let next = &mut self.border[edge.ends[from] as usize];
                    *next.iter_mut().find(|free| **free == NONE)? = edge.ends[to];
                }
            } else if edge.triangles > 2 {
                return None;
            }
        }
        let begin = *piece.iter().find(|&&v| self.border[v as usize][0] != NONE)?;
        let mut walked = Vec::with_capacity(length);
        let (mut before, mut here) = (NONE, begin);
        while walked.len() < length {
            walked.push(here);
            let [one, other] = self.border[here as usize];
            (before, here) = (here, if one == before { other } else { one });
            if here == begin {
                break;
            }
        }
        (walked.len() == length && here == begin).then_some(walked)
    }

    /// Number of particles along the longer and the shorter side, if the piece is a grid.
    fn sides(&self, piece: &[u32], border: usize) -> Option<[usize; 2]> {
        let sum = border / 2 + 2;
        let rest = (sum * sum).checked_sub(4 * piece.len())?;
        let root = rest.isqrt();
        let [long, short] = [sum + root, sum.checked_sub(root)?].map(|twice| twice / 2);
        let own = piece.iter().flat_map(|&v| self.edges.of_lower(v));
        let triangles = own.map(|edge| edge.triangles as usize).sum::<usize>() / 3;
        let fits = border.is_multiple_of(2)
            && root * root == rest
            && short >= 2
            && long * short == piece.len()
            && triangles == 2 * (long - 1) * (short - 1);
        fits.then_some([long, short])
    }

    /// All placements of a grid with these sides on a border, up to rotation and reflection.
    fn placements(&self, border: &[u32], [columns, rows]: [usize; 2]) -> Vec<Placement> {
        let length = border.len();
        let at = |place: usize| border[place % length];
        // A corner belongs to one cell, so it has one or two triangles and at most three edges.
        let blunt: Vec<bool> = (0..length)
            .map(|k| {
                let [before, here, after] = [k + length - 1, k, k + 1].map(at);
                let third = self.edges.between(before, here).map(|edge| edge.opposite[0]);
                let other = self.edges.between(here, after).map(|edge| edge.opposite[0]);
                !(third == Some(after) || third == other)
            })
            .collect();
        let turns = if columns == rows { length / 4 } else { length / 2 };
        let corners = |first: usize| {
            [first, first + columns - 1, first + length / 2, first + length / 2 + columns - 1]
                .map(|place| place % length)
        };
        let possible = (0..turns).map(corners).filter(|four| four.iter().all(|&k| !blunt[k]));
        possible.map(|four| self.placement(border, four, columns == rows)).collect()
    }

    /// Chooses the starting corner and the direction. From the second and the fourth corner, the longer side is behind.
    fn placement(&self, border: &[u32], corners: [usize; 4], square: bool) -> Placement {
        let length = border.len();
        let place = |k: usize| self.positions[border[k % length] as usize];
        let cosine = |k: usize| {
            let here = place(k).as_dvec3();
            let [a, b]: [DVec3; 2] =
                [k + 1, k + length - 1].map(|next| place(next).as_dvec3() - here);
            -a.dot(b) / (a.length_squared() * b.length_squared()).sqrt()
        };
        let [a, b, c, d] = corners.map(cosine);
        let mut best = 0;
        for k in 1..4 {
            if compare(place(corners[k]), place(corners[best])) == Ordering::Less {
                best = k;
            }
        }
        let first = corners[best];
        let backwards = if square {
            compare(place(first + length - 1), place(first + 1)) == Ordering::Less
        } else {
            best % 2 == 1
        };
        Placement { bluntness: (a + c) + (b + d), first, backwards }
    }

    /// Visits all cells, row by row; `None` if one does not fit. `along` gives the border from the first corner on.
    fn fill(
        &mut self,
        [columns, rows]: [usize; 2],
        along: impl Fn(usize) -> u32,
        budget: &mut usize,
    ) -> Option<Vec<u32>> {
        self.attempt += 1;
        let length = 2 * (columns + rows) - 4;
        let mut order = Vec::with_capacity(columns * rows);
        // For each upper side of the cells of a row, the corner of the triangle above it.
        let mut above = vec![NONE; columns - 1];
        order.extend((0..columns).map(&along));
        order.iter().for_each(|&v| self.put[v as usize] = self.attempt);
        for row in 1..rows {
            let mut c = along(length - row);
            self.put(&mut order, c)?;
            for (column, above) in above.iter_mut().enumerate() {
                *budget = budget.checked_sub(1)?;
                let upper = (row - 1) * columns + column;
                let [a, b] = [order[upper], order[upper + 1]];
                let below = self.edges.between(a, b)?.across(*above)?;
                let d = if below == c {
                    *above = b;
                    self.edges.between(b, c)?.across(a)?
                } else {
                    *above = a;
                    (self.edges.between(a, below)?.across(b) == Some(c)).then_some(below)?
                };
                self.put(&mut order, d)?;
                c = d;
            }
        }
        Some(order)
    }

    /// Appends a particle to a row; `None` if it is in one already.
    fn put(&mut self, order: &mut Vec<u32>, particle: u32) -> Option<()> {
        let put = &mut self.put[particle as usize];
        if *put == self.attempt {
            return None;
        }
        *put = self.attempt;
        order.push(particle);
        Some(())
    }
}

/// Order of corners: from top to bottom, from left to right, from back to front.
fn compare(a: Vec3, b: Vec3) -> Ordering {
    let by = |a: f32, b: f32| a.partial_cmp(&b).unwrap_or(Ordering::Equal);
    by(b.y, a.y).then(by(a.x, b.x)).then(by(a.z, b.z))
}
