//! Box against box, the most frequent pair in piles of boxes: eight pairs in SIMD lanes.
//!
//! The distance of two convex bodies is their greatest separation along any direction; for overlapping boxes the greatest is along one of 15 axes (`axes`). A
//! separation greater than reach ends the search. Otherwise the box with the best face clips the most opposed face of the other (`faces`). Two edges have one
//! point, and separated boxes that are past the rims of each other's faces may be nearest at a corner or two edges, along none of the 15 (`edges`).
//!
//! Pairs are queued and compared eight at a time. Clipping eight faces takes as long as clipping two one by one, so nothing is lost if some of the eight pairs
//! turn out to be apart. Pairs with crossing edges or corners are handled one by one.

mod axes;
pub(super) mod edges;
mod faces;

use glam::Vec3;

use super::super::shape::{Kind, Shape};
use super::{FLAT_COSINE, Frame, Manifold};
use crate::lanes::{InstructionSet, LANES, Lanes, SetLanes, kernel};
use axes::{Axes, WidePairs};
use edges::{BEFORE_END, ON_EDGE};

/// A queue of box pairs, and their manifolds.
#[derive(Clone, Debug, Default)]
pub(crate) struct BoxPairs {
    eights: Vec<WidePairs>,
    len: usize,
    found: Vec<Manifold>,
}

impl BoxPairs {
    /// Removes all pairs.
    pub(crate) fn clear(&mut self) {
        self.eights.clear();
        self.len = 0;
    }

    /// Adds a pair of shapes, the first at `a_in_b` in the coordinates of the second, to be compared up to `reach` metres. Returns the number of the pair, or
    /// `None` if the shapes are not two boxes.
    #[inline(always)]
    pub(crate) fn push(
        &mut self,
        [a, b]: [&Shape; 2],
        a_in_b: &Frame,
        reach: f32,
    ) -> Option<usize> {
        let (Kind::Box { half_size: a }, Kind::Box { half_size: b }) = (a.kind(), b.kind()) else {
            return None;
        };
        let (number, lane) = (self.len, self.len % LANES);
        if lane == 0 {
            self.eights.push(WidePairs::NONE);
        }
        if let Some(eight) = self.eights.last_mut() {
            eight.put(lane, [a, b], a_in_b, reach);
        }
        self.len += 1;
        Some(number)
    }

    /// Computes the manifolds of all pairs, by pair number. Those of pairs out of reach, or with a frame that is not finite, have no points.
    pub(crate) fn collide(&mut self, instructions: InstructionSet) -> &[Manifold] {
        self.found.clear();
        self.found.resize(self.len, Manifold::default());
        collide_wide(&self.eights, &mut self.found, instructions);
        &self.found
    }
}

kernel!(
    /// Compares the pairs, each up to its reach.
    fn collide_wide<L: Lanes>(eights: &[WidePairs], found: &mut [Manifold]) {
        for (number, eight) in eights.iter().enumerate() {
            let loaded = eight.loaded::<L>();
            let best = loaded.separate();
            let near = best.near.bits();
            if near == 0 {
                continue;
            }
            let (faces, best) = (faces::clip(&loaded, &best), best.in_lanes());
            for lane in SetLanes(near) {
                let axes = best.of(lane);
                let (mut manifold, nearest) = (faces.of(lane), faces.nearest[lane]);
                // If a face is the best axis and has points, they are the manifold.
                let most = axes.face_separation;
                let is_least = (most <= 0.0) & (manifold.len > 0) | (nearest <= most + axes.bias);
                if axes.edge_wins | !is_least {
                    manifold = edge_or_corner_manifold(&eight.pair(lane), &axes, manifold);
                }
                if manifold.is_sound() {
                    found[LANES * number + lane] = manifold;
                }
            }
        }
    }
);

/// The manifold of a pair whose faces are not, or may not be, nearest; `faces` is the manifold of the faces.
#[inline(never)]
fn edge_or_corner_manifold(pair: &BoxPair, axes: &Axes, faces: Manifold) -> Manifold {
    let most = axes.face_separation.max(axes.edge_separation);
    if axes.edge_wins {
        let edges = pair.nearest_on_edges(axes.edge);
        let is_face = faces.len > 1
            && (faces.nearest() - most).abs() <= axes.bias
            && edges.normal.dot(faces.normal) > FLAT_COSINE;
        if is_face {
            return faces;
        }
        if most <= 0.0 || edges.over <= ON_EDGE {
            return edges.manifold(&pair.frame);
        }
    }
    if most > 0.0 {
        // The nearest points are a corner or two edges past the rim of that face; or the face manifold has them after all.
        let edges = (axes.edge_separation > 0.0).then(|| pair.nearest_on_edges(axes.edge));
        let past = pair.corners(edges.filter(|edges| edges.over < BEFORE_END));
        return if past.nearest() < faces.nearest() - axes.bias { past } else { faces };
    }
    if faces.len == 0 && axes.edge_separation > f32::NEG_INFINITY {
        // The overlap is so small that the bias selected an axis along which nothing was found.
        return pair.nearest_on_edges(axes.edge).manifold(&pair.frame);
    }
    faces
}

/// Two boxes, `a` in the coordinates of `b`.
#[derive(Clone, Copy, Debug)]
struct BoxPair {
    /// Half sizes of `a` and of `b`, metres.
    half_sizes: [Vec3; 2],
    /// Frame of `a` in the coordinates of `b`.
    frame: Frame,
    /// Greatest distance at which a manifold has points, metres.
    reach: f32,
}

/// The two axes after each axis.
const NEXT: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];
