//! Boxes that are near each other all the time, the bones of a figure or links of a rope, searched as one: the grid finds which clusters are near
//! each other, and boxes are compared with those of their own cluster and of clusters that are near.
//!
//! A bone has eleven others of its figure around it. To a grid that is a crowd of boxes of many sizes, each of which looks into some thirty cells,
//! for what is known from the start; compared one with the other they are 66 pairs, and a hundred figures are a hundred boxes of like size.
//!
//! # Candidates that last
//!
//! The grid has enlarged boxes in it: with a margin, and with the way that each goes on in the next steps. The pairs of those are candidates as long as
//! the boxes stay within them, which in a heap is many steps; of the candidates those that overlap now are handed out, so that nobody sees for how long
//! they have lasted. A few that have left theirs are looked for one by one; when they are many, all are taken in afresh.

use glam::Vec3;

use super::grid::BoxEntry;
use super::{Broad, is_box, overlap};

/// Boxes in a cluster, at most: of a long rope a few links are together, all of them lie across the whole level.
const MOST: usize = 16;

/// By how much boxes are enlarged on each side, as a share of their largest extent; and for how many further steps they go on as they go.
const MARGIN: f32 = 0.06;
const STEPS: f32 = 3.0;
/// One by the share of all clusters that may have left their enlarged boxes before all are taken in afresh.
const FEW: usize = 32;

/// A search for boxes that overlap, some of which are known to be near each other.
#[derive(Default)]
pub(crate) struct ClusterSearch {
    /// Where the enlarged boxes are.
    broad: Broad,
    /// The first box of each cluster, and how many boxes there are.
    starts: Vec<u32>,
    /// What each cluster is in; left as it was where all boxes are alone.
    boxes: Vec<(Vec3, Vec3)>,
    /// The enlarged boxes, the clusters that they are of, and the pairs of those that overlap; sorted.
    enlarged: Vec<(Vec3, Vec3)>,
    enlarged_starts: Vec<u32>,
    candidates: Vec<[u32; 2]>,
    /// Clusters that have left theirs, ascending.
    left: Vec<u32>,
    /// Where boxes were when they were taken in anew within a step, and whether they were.
    anew: Broad,
    is_anew: bool,
    /// Scratch: clusters that are near each other, or near one that has moved; those of them of which one has left its enlarged box; boxes of a cluster, and
    /// of those near it.
    near: Vec<[u32; 2]>,
    others_near: Vec<[u32; 2]>,
    around: Vec<u32>,
    own: Vec<BoxEntry>,
    others: Vec<BoxEntry>,
}

impl ClusterSearch {
    /// Takes boxes in (least and greatest corner), and all pairs `[a, b]`, `a < b`, of those that overlap or touch; sorted. One with NaN, or with
    /// less than no extent, overlaps nothing. A box that is `joined` is near the one before it; `way` is how far one goes on in a step, metres, as far as is
    /// known.
    pub(crate) fn pairs(
        &mut self,
        bounds: &[(Vec3, Vec3)],
        joined: impl Fn(usize) -> bool,
        way: impl Fn(usize) -> Vec3,
        out: &mut Vec<[u32; 2]>,
    ) {
        self.is_anew = false;
        self.lay_out(bounds.len(), joined);
        if self.all_are_alone() {
            self.find_near(bounds, bounds, way);
            out.clear();
            out.extend_from_slice(&self.near);
            return;
        }
        self.unite(bounds);
        let boxes = core::mem::take(&mut self.boxes);
        self.find_near(&boxes, bounds, way);
        self.boxes = boxes;
        let Self { starts, boxes, near, own, others, .. } = self;
        out.clear();
        let mut near = near.iter().peekable();
        for (cluster, around) in boxes.iter().enumerate() {
            own.clear();
            own.extend(members(starts, cluster, bounds));
            others.clear();
            let whole = BoxEntry::new(around, 0);
            while let Some(&[_, other]) = near.next_if(|pair| pair[0] as usize == cluster) {
                let theirs = members(starts, other as usize, bounds);
                others.extend(theirs.filter(|one| one.overlaps(&whole)));
            }
            for (i, one) in own.iter().enumerate() {
                let mut compare = |other: &BoxEntry| {
                    if one.overlaps(other) {
                        out.push([one.number, other.number]);
                    }
                };
                own[i + 1..].iter().for_each(&mut compare);
                others.iter().for_each(compare);
            }
        }
    }

    /// Finds the pairs of clusters whose boxes overlap or touch; sorted.
    fn find_near(
        &mut self,
        boxes: &[(Vec3, Vec3)],
        bounds: &[(Vec3, Vec3)],
        way: impl Fn(usize) -> Vec3,
    ) {
        if !self.are_within(boxes) {
            self.enlarge(bounds, way);
        }
        let Self { broad, enlarged, candidates, left, near, others_near, around, .. } = self;
        near.clear();
        near.extend(candidates.iter().filter(|pair| {
            let [a, b] = pair.map(|cluster| &boxes[cluster as usize]);
            is_box(a) && is_box(b) && overlap(a, b)
        }));
        if left.is_empty() {
            return;
        }
        let has_left = |cluster: u32| left.binary_search(&cluster).is_ok();
        near.retain(|&[a, b]| !has_left(a) && !has_left(b));
        others_near.clear();
        for &cluster in left.iter() {
            let own = &boxes[cluster as usize];
            around.clear();
            broad.around(own, enlarged, around);
            let others = around.iter().filter(|&&other| !has_left(other));
            // Of two that have left theirs the first one asks.
            for &other in others.chain(left.iter().filter(|&&other| other > cluster)) {
                let theirs = &boxes[other as usize];
                if is_box(theirs) && overlap(own, theirs) {
                    others_near.push([cluster.min(other), cluster.max(other)]);
                }
            }
        }
        others_near.sort_unstable();
        merge(near, others_near);
    }

    /// Whether all but a few are in their enlarged boxes; notes those few.
    fn are_within(&mut self, boxes: &[(Vec3, Vec3)]) -> bool {
        let Self { starts, enlarged, enlarged_starts, left, .. } = self;
        if starts != enlarged_starts {
            return false;
        }
        left.clear();
        for (number, (own, wide)) in (0..).zip(boxes.iter().zip(&*enlarged)) {
            // What is no box overlaps nothing, wherever it is.
            if is_box(own) && !(wide.0.cmple(own.0) & own.1.cmple(wide.1)).all() {
                left.push(number);
            }
        }
        left.len() * FEW <= boxes.len()
    }

    /// Makes enlarged boxes, and finds the pairs of those.
    fn enlarge(&mut self, bounds: &[(Vec3, Vec3)], way: impl Fn(usize) -> Vec3) {
        let Self { broad, starts, enlarged, enlarged_starts, candidates, left, .. } = self;
        let wide = |i: usize| {
            let (low, high) = bounds[i];
            let (margin, way) = (MARGIN * (high - low).max_element(), STEPS * way(i));
            let wide = (low + way.min(Vec3::ZERO) - margin, high + way.max(Vec3::ZERO) + margin);
            // Infinity less itself is NaN.
            if is_box(&wide) { wide } else { (low, high) }
        };
        enlarged.clear();
        enlarged.extend(starts.windows(2).map(|ends| {
            let own = (ends[0] as usize..ends[1] as usize).filter(|&i| is_box(&bounds[i]));
            united(own.map(wide))
        }));
        enlarged_starts.clone_from(starts);
        left.clear();
        broad.pairs(enlarged, candidates);
    }

    /// Takes boxes of the same clusters in from elsewhere.
    pub(crate) fn fill(&mut self, bounds: &[(Vec3, Vec3)]) {
        self.is_anew = true;
        if self.all_are_alone() {
            return self.anew.fill(bounds);
        }
        self.unite(bounds);
        self.anew.fill(&self.boxes);
    }

    /// Adds the pairs of one box, which may lie elsewhere than when it was taken in, and of those that it overlaps or touches; some more than once.
    /// `moved` lists those of the boxes, ascending, that lie elsewhere now; `bounds` are where all are.
    pub(crate) fn around(
        &mut self,
        number: u32,
        bounds: &[(Vec3, Vec3)],
        moved: &[u32],
        out: &mut Vec<[u32; 2]>,
    ) {
        let own = &bounds[number as usize];
        let boxes = if self.all_are_alone() { bounds } else { &self.boxes };
        self.around.clear();
        if self.is_anew {
            self.anew.around(own, boxes, &mut self.around);
        } else {
            self.broad.around(own, &self.enlarged, &mut self.around);
            self.around.extend(&self.left);
        }
        let near = |other: u32| {
            let theirs = &bounds[other as usize];
            other != number && is_box(own) && is_box(theirs) && overlap(own, theirs)
        };
        let pair = |other: u32| [number.min(other), number.max(other)];
        for &cluster in &self.around {
            // Enlarged it is near, and perhaps not otherwise.
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

    /// Makes clusters of boxes that follow each other.
    fn lay_out(&mut self, count: usize, joined: impl Fn(usize) -> bool) {
        self.starts.clear();
        let mut first = 0;
        for i in 0..count {
            if i == 0 || i - first == MOST || !joined(i) {
                first = i;
                self.starts.push(i as u32);
            }
        }
        self.starts.push(count as u32);
    }

    /// Whether each cluster is one box.
    fn all_are_alone(&self) -> bool {
        self.starts.last().is_none_or(|&count| self.starts.len() == count as usize + 1)
    }

    /// What each cluster is in.
    fn unite(&mut self, bounds: &[(Vec3, Vec3)]) {
        let Self { starts, boxes, .. } = self;
        boxes.clear();
        boxes.extend(starts.windows(2).map(|ends| {
            united(bounds[ends[0] as usize..ends[1] as usize].iter().copied().filter(is_box))
        }));
    }
}

/// What boxes are in together; no box if there are none.
fn united(boxes: impl Iterator<Item = (Vec3, Vec3)>) -> (Vec3, Vec3) {
    boxes
        .reduce(|(low, high), (least, most)| (low.min(least), high.max(most)))
        .unwrap_or((Vec3::NAN, Vec3::NAN))
}

/// Merges a sorted list into another one; they have nothing in common.
fn merge(into: &mut Vec<[u32; 2]>, from: &[[u32; 2]]) {
    let mut left = into.len();
    into.extend_from_slice(from);
    // From behind, so that each is moved once.
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

/// The boxes of a cluster.
fn members(
    starts: &[u32],
    cluster: usize,
    bounds: &[(Vec3, Vec3)],
) -> impl Iterator<Item = BoxEntry> {
    let numbers = starts[cluster]..starts[cluster + 1];
    let good = numbers.filter(|&number| is_box(&bounds[number as usize]));
    good.map(|number| BoxEntry::new(&bounds[number as usize], number))
}
