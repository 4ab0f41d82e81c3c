//! Bounding volume hierarchy of triangles or edges: AABBs, split at the median until few are left.
//!
//! Nodes are stored in depth-first order, each with the index of the next node outside of its subtree, so that traversal needs no stack and no memory. Results
//! do not depend on the order of traversal, because of two equally near triangles the one with the lower index counts.

use std::ops::Range;

use glam::Vec3;

/// AABBs of things that are numbered.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct AabbTree {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// The next node outside of this subtree.
    next: u32,
    /// Range of what is in it; empty for an inner node.
    first: u32,
    end: u32,
}

/// Maximum number in a leaf: testing a triangle costs about as much as testing a box.
const LEAF: usize = 4;

impl AabbTree {
    /// Builds the tree over bounds (low, high), and returns the order that what has them must be put in.
    pub(super) fn new(bounds: &[(Vec3, Vec3)]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
        let mut tree = Self::default();
        tree.split(bounds, &mut order, 0);
        (tree, order)
    }

    /// The range of the next leaf whose bounds (low, high) pass `keep`, as do those of all nodes above. `cursor` starts at 0.
    #[inline]
    pub(super) fn next(
        &self,
        cursor: &mut u32,
        keep: impl Fn(Vec3, Vec3) -> bool,
    ) -> Option<Range<usize>> {
        while let Some(node) = self.nodes.get(*cursor as usize) {
            if !keep(node.low, node.high) {
                *cursor = node.next;
                continue;
            }
            *cursor += 1;
            if node.end > node.first {
                return Some(node.first as usize..node.end as usize);
            }
        }
        None
    }

    fn split(&mut self, bounds: &[(Vec3, Vec3)], order: &mut [u32], first: u32) {
        let (mut low, mut high) = (Vec3::INFINITY, -Vec3::INFINITY);
        let (mut least, mut most) = (low, high);
        let middle = |i: u32| {
            let (low, high) = bounds[i as usize];
            low + high
        };
        for &i in order.iter() {
            let (from, to) = bounds[i as usize];
            (low, high) = (low.min(from), high.max(to));
            (least, most) = (least.min(middle(i)), most.max(middle(i)));
        }
        let own = self.nodes.len();
        let leaf = order.len() <= LEAF;
        let end = if leaf { first + order.len() as u32 } else { first };
        self.nodes.push(Node { low, high, next: 0, first, end });
        if leaf {
            order.sort_unstable();
        } else {
            let axis = (most - least).max_position();
            let half = order.len() / 2;
            order.select_nth_unstable_by(half, |&i, &j| {
                middle(i)[axis].total_cmp(&middle(j)[axis]).then(i.cmp(&j))
            });
            let (below, above) = order.split_at_mut(half);
            self.split(bounds, below, first);
            self.split(bounds, above, first + half as u32);
        }
        self.nodes[own].next = self.nodes.len() as u32;
    }
}
