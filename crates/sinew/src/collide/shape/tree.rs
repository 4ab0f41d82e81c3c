//! Which of many triangles are near: boxes in boxes, split at the middle one until few are left.
//!
//! The boxes stand in the order in which they are asked, each with the number of the next one that is not within it; so to go through them takes no
//! stack and no memory. What comes out never depends on how the boxes are split, because of two equally near triangles the first one counts.

use std::ops::Range;

use glam::Vec3;

use super::triangle::Triangle;

/// Boxes around triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TriangleTree {
    boxes: Vec<Node>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// The box after all that are within this one.
    next: u32,
    /// Its triangles, if there is no box within.
    first: u32,
    end: u32,
}

/// Triangles in a box that is not split: to look at one costs about as much as at a box.
const LEAF: usize = 4;

impl TriangleTree {
    /// Sorts triangles into boxes, and tells the order in which they then have to be.
    pub(super) fn new(triangles: &[Triangle]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut tree = Self::default();
        tree.split(triangles, &mut order, 0);
        (tree, order)
    }

    /// The triangles in the next smallest box that `keep` lets pass, by its lowest and highest coordinates, as all those around it. `cursor` begins
    /// at 0.
    #[inline]
    pub(super) fn next(
        &self,
        cursor: &mut u32,
        keep: impl Fn(Vec3, Vec3) -> bool,
    ) -> Option<Range<usize>> {
        while let Some(node) = self.boxes.get(*cursor as usize) {
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

    fn split(&mut self, triangles: &[Triangle], order: &mut [u32], first: u32) {
        let (mut low, mut high) = (Vec3::INFINITY, -Vec3::INFINITY);
        let (mut least, mut most) = (low, high);
        let middle = |i: u32| {
            let (low, high) = triangles[i as usize].bounds();
            low + high
        };
        for &i in order.iter() {
            let (from, to) = triangles[i as usize].bounds();
            (low, high) = (low.min(from), high.max(to));
            (least, most) = (least.min(middle(i)), most.max(middle(i)));
        }
        let own = self.boxes.len();
        let leaf = order.len() <= LEAF;
        let end = if leaf { first + order.len() as u32 } else { first };
        self.boxes.push(Node { low, high, next: 0, first, end });
        if leaf {
            order.sort_unstable();
        } else {
            let wide = most - least;
            let axis = if wide.x >= wide.y && wide.x >= wide.z {
                0
            } else if wide.y >= wide.z {
                1
            } else {
                2
            };
            let half = order.len() / 2;
            order.select_nth_unstable_by(half, |&i, &j| {
                middle(i)[axis].total_cmp(&middle(j)[axis]).then(i.cmp(&j))
            });
            let (below, above) = order.split_at_mut(half);
            self.split(triangles, below, first);
            self.split(triangles, above, first + half as u32);
        }
        self.boxes[own].next = self.boxes.len() as u32;
    }
}
