//! Broad phase for boxes that stay close to each other, such as the bones of a ragdoll or the links of a rope. They form clusters: the grid finds pairs of
//! nearby clusters, and boxes are compared with those of their own and of nearby clusters.
//!
//! A bone has eleven other bones of its ragdoll around it. In a grid they are a dense group of boxes of many sizes, each of which would search some thirty
//! cells to find pairs that are known in advance. Compared directly, eight at a time, they are
//! 66 pairs, and a hundred ragdolls are two hundred clusters of similar size.
//!
//! # Lasting candidates
//!
//! The grid holds enlarged boxes: with a margin, and extended by the displacement expected over the next steps. Pairs of enlarged boxes remain candidates as
//! long as every box stays within its enlarged box, which in a heap is many steps. Only candidates that overlap now are returned, so the result does not depend
//! on the age of the list. If a few clusters have left their enlarged boxes, they are queried one by one; if many have, all enlarged boxes are rebuilt.

use glam::Vec3;

use super::blocks::{BoxBlock, CompareBlocks};
use super::{Broad, is_box, overlap};
use crate::lanes::{InstructionSet, LANES, with};

/// Greatest number of boxes in a cluster: those of a [`BoxBlock`]. One cluster of all links of a long rope would extend across the level anyway.
const MAX_BOXES: usize = LANES;

/// Margin on each side of an enlarged box, as a share of the box's largest extent, and the number of further steps whose expected displacement it covers.
const MARGIN: f32 = 0.06;
const AHEAD_STEPS: f32 = 3.0;
/// All enlarged boxes are rebuilt when more than 1/`REBUILD_DIVISOR` of the clusters have left theirs.
const REBUILD_DIVISOR: usize = 32;

/// Finds overlapping boxes, some of which are known to be close to each other.
#[derive(Default)]
pub(crate) struct ClusterSearch {
    /// Grid of the enlarged boxes.
    broad: Broad,
    /// First box of each cluster, then the number of boxes.
    starts: Vec<u32>,
    /// Bounds of each cluster; not updated where every cluster is a single box.
    boxes: Vec<(Vec3, Vec3)>,
    /// The enlarged boxes, the `starts` that they belong to, and their overlapping pairs, sorted.
    enlarged: Vec<(Vec3, Vec3)>,
    enlarged_starts: Vec<u32>,
    candidates: Vec<[u32; 2]>,
    /// Clusters that have left their enlarged boxes, ascending.
    left: Vec<u32>,
    /// Grid of the boxes as they were when [`fill`](Self::fill) was called within the step, and whether it was.
    refilled: Broad,
    is_refilled: bool,
    /// Scratch: nearby pairs of clusters; those of which one has left its enlarged box; query results; the boxes of each cluster.
    near: Vec<[u32; 2]>,
    near_outside: Vec<[u32; 2]>,
    around: Vec<u32>,
    blocks: Vec<BoxBlock>,
}

impl ClusterSearch {
    /// Finds all pairs `[a, b]`, `a < b`, of boxes (least and greatest corner) that overlap or touch, sorted. A box with a NaN or a negative extent overlaps
    /// nothing. A `joined` box is close to the one before it; `displacement` is the expected displacement of a box in a step, metres.
    pub(crate) fn pairs(
        &mut self,
        bounds: &[(Vec3, Vec3)],
        joined: impl Fn(usize) -> bool,
        displacement: impl Fn(usize) -> Vec3,
        instructions: InstructionSet,
        out: &mut Vec<[u32; 2]>,
    ) {
        self.is_refilled = false;
        self.form_clusters(bounds.len(), joined);
        if self.are_all_single() {
            self.find_near(bounds, bounds, displacement);
            out.clear();
            out.extend_from_slice(&self.near);
            return;
        }
        self.find_bounds(bounds);
        let boxes = core::mem::take(&mut self.boxes);
        self.find_near(&boxes, bounds, displacement);
        self.boxes = boxes;
        let Self { starts, blocks, near, .. } = self;
        blocks.clear();
        blocks.extend(starts.windows(2).map(|ends| {
            let mut block = BoxBlock::new(ends[0]);
            for one in &bounds[ends[0] as usize..ends[1] as usize] {
                block.push(one);
            }
            block
        }));
        out.clear();
        let (range, groups, last) = (0..blocks.len(), &[][..], u32::MAX);
        with(instructions, CompareBlocks { blocks, range, groups, near, last, out });
    }

    /// Finds the pairs of clusters whose boxes overlap or touch, sorted.
    fn find_near(
        &mut self,
        boxes: &[(Vec3, Vec3)],
        bounds: &[(Vec3, Vec3)],
        displacement: impl Fn(usize) -> Vec3,
    ) {
        if !self.few_are_outside(boxes) {
            self.enlarge(bounds, displacement);
        }
        let Self { broad, enlarged, candidates, left, near, near_outside, around, .. } = self;
        near.clear();
        near.extend(candidates.iter().filter(|pair| {
            let [a, b] = pair.map(|cluster| &boxes[cluster as usize]);
            is_box(a) && is_box(b) && overlap(a, b)
        }));
        if left.is_empty() {
            return;
        }
        let is_outside = |cluster: u32| left.binary_search(&cluster).is_ok();
        near.retain(|&[a, b]| !is_outside(a) && !is_outside(b));
        near_outside.clear();
        for &cluster in left.iter() {
            let own = &boxes[cluster as usize];
            around.clear();
            broad.query(own, enlarged, around);
            let others = around.iter().filter(|&&other| !is_outside(other));
            // Each pair of clusters that have both left is found from the first of them.
            for &other in others.chain(left.iter().filter(|&&other| other > cluster)) {
                let theirs = &boxes[other as usize];
                if is_box(theirs) && overlap(own, theirs) {
                    near_outside.push([cluster.min(other), cluster.max(other)]);
                }
            }
        }
        near_outside.sort_unstable();
        merge(near, near_outside);
    }

    /// Whether all clusters but a few are within their enlarged boxes; collects those few in `left`.
    fn few_are_outside(&mut self, boxes: &[(Vec3, Vec3)]) -> bool {
        let Self { starts, enlarged, enlarged_starts, left, .. } = self;
        if starts != enlarged_starts {
            return false;
        }
        left.clear();
        for (number, (own, wide)) in (0..).zip(boxes.iter().zip(&*enlarged)) {
            // An invalid box overlaps nothing, wherever it is.
            if is_box(own) && !(wide.0.cmple(own.0) & own.1.cmple(wide.1)).all() {
                left.push(number);
            }
        }
        left.len() * REBUILD_DIVISOR <= boxes.len()
    }

    /// Makes the enlarged boxes and finds their overlapping pairs.
    fn enlarge(&mut self, bounds: &[(Vec3, Vec3)], displacement: impl Fn(usize) -> Vec3) {
        let Self { broad, starts, enlarged, enlarged_starts, candidates, left, .. } = self;
        let wide = |i: usize| {
            let (low, high) = bounds[i];
            let (margin, displacement) =
                (MARGIN * (high - low).max_element(), AHEAD_STEPS * displacement(i));
            let wide = (
                low + displacement.min(Vec3::ZERO) - margin,
                high + displacement.max(Vec3::ZERO) + margin,
            );
            // Infinity minus itself is NaN.
            if is_box(&wide) { wide } else { (low, high) }
        };
        enlarged.clear();
        enlarged.extend(starts.windows(2).map(|ends| {
            let own = (ends[0] as usize..ends[1] as usize).filter(|&i| is_box(&bounds[i]));
            union_of(own.map(wide))
        }));
        enlarged_starts.clone_from(starts);
        left.clear();
        broad.pairs(enlarged, candidates);
    }

    /// Rebuilds the grid within a step from the current places of the boxes; the clusters stay the same.
    pub(crate) fn fill(&mut self, bounds: &[(Vec3, Vec3)]) {
        self.is_refilled = true;
        if self.are_all_single() {
            return self.refilled.fill(bounds);
        }
        self.find_bounds(bounds);
        self.refilled.fill(&self.boxes);
    }

    /// Adds the pairs of one box, which may have moved since the grid was built, and the boxes that it overlaps or touches; some pairs more than once. `moved`
    /// lists the boxes that have moved, ascending; `bounds` are the current boxes.
    pub(crate) fn query(
        &mut self,
        number: u32,
        bounds: &[(Vec3, Vec3)],
        moved: &[u32],
        out: &mut Vec<[u32; 2]>,
    ) {
        let own = &bounds[number as usize];
        let boxes = if self.are_all_single() { bounds } else { &self.boxes };
        self.around.clear();
        if self.is_refilled {
            self.refilled.query(own, boxes, &mut self.around);
        } else {
            self.broad.query(own, &self.enlarged, &mut self.around);
            self.around.extend(&self.left);
        }
        let near = |other: u32| {
            let theirs = &bounds[other as usize];
            other != number && is_box(own) && is_box(theirs) && overlap(own, theirs)
        };
        let pair = |other: u32| [number.min(other), number.max(other)];
        for &cluster in &self.around {
            // The enlarged box overlaps, but perhaps not the actual one.
            if !overlap(own, &boxes[cluster as usize]) {
                continue;
            }
            for other in self.starts[cluster as usize]..self.starts[cluster as usize + 1] {
                if near(other) && moved.binary_search(&other).is_err() {
                    out.push(pair(other));
                }
            }
        }
        out.extend(moved.iter().filter(|&&other| near(other)).map(|&other| pair(other)));
    }

    /// Forms clusters of consecutive boxes.
    fn form_clusters(&mut self, count: usize, joined: impl Fn(usize) -> bool) {
        self.starts.clear();
        let mut first = 0;
        for i in 0..count {
            if i == 0 || i - first == MAX_BOXES || !joined(i) {
                first = i;
                self.starts.push(i as u32);
            }
        }
        self.starts.push(count as u32);
    }

    /// Whether every cluster is a single box.
    fn are_all_single(&self) -> bool {
        self.starts.last().is_none_or(|&count| self.starts.len() == count as usize + 1)
    }

    /// Computes the bounds of each cluster.
    fn find_bounds(&mut self, bounds: &[(Vec3, Vec3)]) {
        let Self { starts, boxes, .. } = self;
        boxes.clear();
        boxes.extend(starts.windows(2).map(|ends| {
            union_of(bounds[ends[0] as usize..ends[1] as usize].iter().copied().filter(is_box))
        }));
    }
}

/// The union of some boxes; an invalid box if there are none.
fn union_of(boxes: impl Iterator<Item = (Vec3, Vec3)>) -> (Vec3, Vec3) {
    boxes
        .reduce(|(low, high), (least, most)| (low.min(least), high.max(most)))
        .unwrap_or((Vec3::NAN, Vec3::NAN))
}

/// Merges a sorted list into another; they have no element in common.
fn merge(into: &mut Vec<[u32; 2]>, from: &[[u32; 2]]) {
    let mut left = into.len();
    into.extend_from_slice(from);
    // From the end, so that each element is moved once.
    let mut to = into.len();
    for &one in from.iter().rev() {
        while left > 0 && into[left - 1] > one {
            (left, to) = (left - 1, to - 1);
            into[to] = into[left];
        }
        to -= 1;
        into[to] = one;
    }
}
