//! Boxes that are near each other all the time, the bones of a figure or links of a rope, searched as one: the grid finds which clusters are near
//! each other, and boxes are compared with those of their own cluster and of clusters that are near.
//!
//! A bone has eleven others of its figure around it. To a grid that is a crowd of boxes of many sizes, each of which looks into some thirty cells,
//! for what is known from the start; compared one with the other they are 66 pairs, and a hundred figures are a hundred boxes of like size.

use glam::Vec3;

use super::grid::BoxEntry;
use super::{Broad, is_box, overlap};

/// Boxes in a cluster, at most: of a long rope a few links are together, all of them lie across the whole level.
const MOST: usize = 16;

/// A search for boxes that overlap, some of which are known to be near each other.
#[derive(Default)]
pub(crate) struct ClusterSearch {
    broad: Broad,
    /// The first box of each cluster, and how many boxes there are.
    starts: Vec<u32>,
    /// What each cluster is in; left as it was where all boxes are alone.
    boxes: Vec<(Vec3, Vec3)>,
    /// Scratch: clusters that are near each other, or near one that has moved; boxes of a cluster, and of those near it.
    near: Vec<[u32; 2]>,
    around: Vec<u32>,
    own: Vec<BoxEntry>,
    others: Vec<BoxEntry>,
}

impl ClusterSearch {
    /// Takes boxes in (least and greatest corner), and all pairs `[a, b]`, `a < b`, of those that overlap or touch; sorted. One with NaN, or with
    /// less than no extent, overlaps nothing. A box that is `joined` is near the one before it.
    pub(crate) fn pairs(
        &mut self,
        bounds: &[(Vec3, Vec3)],
        joined: impl Fn(usize) -> bool,
        out: &mut Vec<[u32; 2]>,
    ) {
        self.lay_out(bounds.len(), joined);
        if self.all_are_alone() {
            return self.broad.pairs(bounds, out);
        }
        self.unite(bounds);
        let Self { broad, starts, boxes, near, own, others, .. } = self;
        broad.pairs(boxes, near);
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

    /// Takes boxes of the same clusters in from elsewhere.
    pub(crate) fn fill(&mut self, bounds: &[(Vec3, Vec3)]) {
        if self.all_are_alone() {
            return self.broad.fill(bounds);
        }
        self.unite(bounds);
        self.broad.fill(&self.boxes);
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
        self.broad.around(own, boxes, &mut self.around);
        let near = |other: u32| {
            let theirs = &bounds[other as usize];
            other != number && is_box(own) && is_box(theirs) && overlap(own, theirs)
        };
        let pair = |other: u32| [number.min(other), number.max(other)];
        for &cluster in &self.around {
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
            let own = &bounds[ends[0] as usize..ends[1] as usize];
            let all = own.iter().copied().filter(is_box);
            all.reduce(|(low, high), (least, most)| (low.min(least), high.max(most)))
                .unwrap_or((Vec3::NAN, Vec3::NAN))
        }));
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
