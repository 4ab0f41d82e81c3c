//! Box and box, the pair that a pile of boxes asks for most: eight pairs at a time.
//!
//! Two convex bodies are apart by the greatest of their separations along any direction; for boxes that overlap, the greatest is one of 15 (`axes`). A
//! separation beyond reach ends the search. Otherwise the body with the face clips the other's most opposite face (`faces`); two edges have one point, and boxes
//! that are apart, past the rims of each other's faces, may be nearest at a corner or two edges, along none of the 15 (`edges`).
//!
//! Pairs come in a list, and are compared by eights: to clip eight faces takes as long as to clip two one by one, so that nothing is lost where some of an eight
//! are found to be apart. What has crossing edges or corners is looked at by itself.

mod axes;
pub(super) mod edges;
mod faces;

use glam::Vec3;

use super::super::shape::{Kind, Shape};
use super::{Frame, Manifold};
use crate::lanes::{InstructionSet, LANES, Lanes, SetLanes, kernel};
use axes::{Axes, WidePairs};
use edges::{BEFORE_END, LEANS, ON_EDGE};

/// Pairs of boxes that are to be compared, and their manifolds.
#[derive(Clone, Debug, Default)]
pub(crate) struct BoxPairs {
    eights: Vec<WidePairs>,
    len: usize,
    found: Vec<Manifold>,
}

impl BoxPairs {
    /// Forgets all pairs.
    pub(crate) fn clear(&mut self) {
        self.eights.clear();
        self.len = 0;
    }

    /// Adds two shapes, where the first one is in the coordinates of the second one, to be compared up to a reach, metres, and says which pair of the list they
    /// are. `None` where they are not two boxes.
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

    /// Compares them: their manifolds by the numbers of the pairs, without points where two are out of reach, or not anywhere.
    pub(crate) fn collide(&mut self, instructions: InstructionSet) -> &[Manifold] {
        self.found.clear();
        self.found.resize(self.len, Manifold::default());
        collide_wide(&self.eights, &mut self.found, instructions);
        &self.found
    }
}

kernel!(
    /// Compares eights of pairs, each up to its reach.
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
                // Where a face is the best there is, and has points, those are it.
                let most = axes.face_separation;
                let is_least = (most <= 0.0) & (manifold.len > 0) | (nearest <= most + axes.bias);
                if axes.edge_wins | !is_least {
                    manifold = beside_faces(&eight.pair(lane), &axes, manifold);
                }
                if manifold.is_sound() {
                    found[LANES * number + lane] = manifold;
                }
            }
        }
    }
);

/// The manifold of two whose faces are not, or may not be, what is nearest of them; these are the points of the faces.
#[inline(never)]
fn beside_faces(pair: &BoxPair, axes: &Axes, faces: Manifold) -> Manifold {
    let most = axes.face_separation.max(axes.edge_separation);
    if axes.edge_wins {
        let edges = pair.meet(axes.edge);
        let is_face = faces.len > 1
            && (faces.nearest() - most).abs() <= axes.bias
            && edges.normal.dot(faces.normal) > LEANS;
        if is_face {
            return faces;
        }
        if most <= 0.0 || edges.over <= ON_EDGE {
            return edges.manifold(&pair.frame);
        }
    }
    if most > 0.0 {
        // What is nearest is a corner or two edges past the rim of that face; or the face saw it after all.
        let edges = (axes.edge_separation > 0.0).then(|| pair.meet(axes.edge));
        let past = pair.corners(edges.filter(|edges| edges.over < BEFORE_END));
        return if past.nearest() < faces.nearest() - axes.bias { past } else { faces };
    }
    if faces.len == 0 && axes.edge_separation > f32::NEG_INFINITY {
        // They overlap by so little that the bias took an axis along which nothing is found.
        return pair.meet(axes.edge).manifold(&pair.frame);
    }
    faces
}

/// Two boxes, `a` as seen from `b`.
#[derive(Clone, Copy, Debug)]
struct BoxPair {
    /// Half sizes of `a` and of `b`, metres.
    half_sizes: [Vec3; 2],
    /// Where `a` is in the coordinates of `b`; its axes are `a`'s.
    frame: Frame,
    /// How far apart what is looked for may be, metres.
    reach: f32,
}

/// The axes after an axis.
const NEXT: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];
