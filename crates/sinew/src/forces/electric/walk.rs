//! Tree traversal: finds which nodes act on a leaf as one, and which leaves act charge by charge. One traversal serves eight leaves, one for each lane.
//!
//! Neighbouring leaves need nearly the same nodes. Where a node is far for only some of the eight, the traversal descends for the others alone. So each node is
//! visited once instead of up to eight times, with fewer cache misses and mispredicted branches.

use glam::Vec4;

use super::columns::ChargeNode;
use crate::lanes::{LANES, Lanes, SetLanes, Vector};

/// The result of a traversal for each of eight leaves; it keeps its allocations between calls.
#[derive(Clone, Debug, Default)]
pub(super) struct Walk {
    /// Nodes that act as one on some of the leaves.
    pub far: Vec<u32>,
    /// For each leaf, the indices in `far` of those that act on it.
    pub far_of: [Vec<u32>; LANES],
    /// For each leaf, the ranges of leaves that act on it charge by charge.
    pub near: [Vec<(u32, u32)>; LANES],
}

/// A subtree, up to node `end`, and the mask of the leaves for which it is being visited.
#[derive(Clone, Copy, Default)]
struct Below {
    end: usize,
    leaves: u32,
}

/// Maximum depth: the tree is as deep as the logarithm of the number of leaves, a `u32`, plus one for the root.
const DEEPEST: usize = 33;

impl Walk {
    /// Traverses the tree for the up to eight leaves below node `n`; `per_reach` is the inverse of the opening.
    ///
    /// A node is far for a leaf if its distance exceeds the sum of its reach over the opening and the radius of the leaf. Distances are in `f32` from the
    /// middle of the eight leaves, so a borderline node may be classified either way, but the same on every machine.
    #[inline(always)]
    pub(super) fn walk<L: Lanes>(&mut self, nodes: &[ChargeNode], n: usize, per_reach: f64) {
        // At least what a leaf needs in most cases among 65 536 charges.
        let longest = |most: usize, len: usize| most.max(len);
        let far_of = self.far_of.iter().map(Vec::len).fold(512, longest);
        let near = self.near.iter().map(Vec::len).fold(64, longest);
        let far = self.far.len().max(1024);
        make_room(&mut self.far, far);
        self.far_of.iter_mut().for_each(|list| make_room(list, far_of));
        self.near.iter_mut().for_each(|list| make_room(list, near));
        let bunch = &nodes[n];
        let middle = bunch.middle;
        let mut places = [Vec4::ZERO; LANES];
        let leaves = nodes[n..n + bunch.subtree_len()].iter().filter(|node| node.leaves == 1);
        for (place, leaf) in places.iter_mut().zip(leaves) {
            *place = (leaf.middle - middle).as_vec3().extend(leaf.radius as f32);
        }
        let (places, radius) = Vector::<L>::of(L::run(&places, 0));
        let all = 0xFF >> (LANES - (bunch.leaves as usize).min(LANES));
        let mut below = [Below::default(); DEEPEST];
        below[0] = Below { end: nodes.len(), leaves: all };
        let (mut depth, mut n) = (0, 0);
        while let Some(node) = nodes.get(n) {
            while n >= below[depth].end {
                depth -= 1;
            }
            let active = below[depth].leaves;
            let size = L::splat((node.reach * per_reach) as f32) + radius;
            let d = places - Vector::splat((node.centre - middle).as_vec3());
            let beyond = (size * size).lt(d.length_squared()).bits();
            // Coincident charges act as a single charge, however near.
            let far = active & if node.reach == 0.0 { all } else { beyond };
            let near = active & !far;
            if far != 0 {
                let number = self.far.len() as u32;
                self.far.push(n as u32);
                SetLanes(far).for_each(|leaf| self.far_of[leaf].push(number));
            }
            if near == 0 {
                n += node.subtree_len();
                continue;
            }
            if node.leaves == 1 {
                SetLanes(near).for_each(|leaf| push_leaf(&mut self.near[leaf], node.first));
            } else {
                depth += 1;
                below[depth] = Below { end: n + node.subtree_len(), leaves: near };
            }
            n += 1;
        }
    }
}

/// Clears a list and reserves twice its recent length, so that moving charges do not cause frequent small reallocations.
pub(super) fn make_room<T>(list: &mut Vec<T>, lately: usize) {
    list.clear();
    if list.capacity() < 2 * lately {
        list.reserve(4 * lately);
    }
}

/// Appends a leaf to the ranges.
#[inline]
fn push_leaf(ranges: &mut Vec<(u32, u32)>, leaf: u32) {
    match ranges.last_mut() {
        Some((_, end)) if *end == leaf => *end += 1,
        _ => ranges.push((leaf, leaf + 1)),
    }
}
