//! Many charges: near ones act individually, far groups as one (Barnes and Hut 1986).
//!
//! # The field of a group
//!
//! With `c` the mean position of the charges of a group, weighted by their magnitudes, `Q = Σ q` and `D = Σ q (x - c)`, the potential at a far point is that of
//! a monopole and a dipole,
//!
//! ```text
//! φ = Q/s + D·d/s³        d = x - c,  s² = ‖d‖² + ε²
//! E = -∇φ = (Q d - D)/s³ + 3 (D·d) d/s⁵
//! ```
//!
//! and the next term is smaller by (size/distance)². Charges of one sign have no dipole about their own mean. For mixed signs `Q` is near zero and the dipole
//! is most of the field: without it the error is 2.6 times as large (4096 charges, opening 0.5).
//!
//! A group acts as one on a target at the distance `r` if none of its charges is farther than `opening · r` from `c`.
//!
//! # The tree
//!
//! The targets are leaves of eight neighbouring charges, one for each lane. The charges are halved by a plane across their longest extent, and the halves
//! again, always at a multiple of eight. So every leaf but the last is full, the depth is the logarithm of the number of leaves whatever the distribution, and
//! no pointers are needed: a node with `n` leaves is followed by the subtree of its first half and then by that of its second, `2n - 1` nodes in all. (The
//! leaves of an octree along a Morton curve are half empty, and crowded charges make it deep.) Ties are broken by the row, so the tree and all sums depend on
//! the particles alone.
//!
//! Up to eight leaves, a bunch, share one [traversal](super::walk). Differences to a group are computed in `f64` from the middle of the bunch, so that they are
//! accurate anywhere in the world.
//!
//! # Accuracy
//!
//! Momentum is not conserved exactly: a group acts on a target, but the target acts on the members of the group individually or in other groups, so the forces
//! cancel only to the accuracy of the approximation. Measured on evenly distributed charges of either sign, where the contributions of far groups mostly cancel
//! (error: root mean square, as a share of that of the forces; sum: of all forces, as a share of the sum of their magnitudes; milliseconds on one core of a
//! shared machine with AVX2, where all pairs take 0.78 ns a pair: 6.5 ms for the 4096, 1.7 s for the 65 536):
//!
//! | opening | error, 4096 | error, 65 536 | sum, 65 536 | ms, 4096 | ms, 65 536 |
//! |---|---|---|---|---|---|
//! | 0.4 | 0.30 % | 0.43 % | 2e-5 | 2.8 | 75 |
//! | 0.45 | 0.41 % | 0.56 % | 3e-5 | 2.4 | 63 |
//! | 0.5 | 0.55 % | 0.73 % | 4e-5 | 2.2 | 55 |
//! | 0.6 | 0.86 % | 1.12 % | 5e-5 | 1.8 | 44 |
//!
//! For 5000 charges of one sign, at 0.45, the error is 0.48 %, and the sum of the forces 1e-3 of their magnitudes.
//!
//! If each charge's error is taken relative to its own force, the root mean square is some seven times that. It is dominated by the few charges on which large
//! forces nearly cancel.

use core::ops::Range;

use glam::{DVec3, Vec3, Vec4};

use super::Electric;
use super::columns::{ChargeColumns, ChargeNode, ChargedParticle, Group, LEAF, Targets, add};
use super::walk::{Walk, make_room};
use crate::lanes::{InstructionSet, LANES, Lanes, Vector, kernel};

/// The charges in the order of the tree's leaves, and its nodes from the root on.
#[derive(Clone, Debug, Default)]
pub(super) struct ChargeTree {
    pub items: Vec<ChargedParticle>,
    nodes: Vec<ChargeNode>,
    /// Ranges of leaves that are still to be split.
    pending: Vec<(u32, u32)>,
    walk: Walk,
    /// The far nodes in the frame of the current bunch.
    groups: Vec<Group>,
}

impl ChargeTree {
    /// Builds the tree of these charges.
    pub(super) fn of(items: Vec<ChargedParticle>) -> Self {
        let mut tree = Self { items, ..Self::default() };
        tree.build();
        tree
    }

    /// Sorts the charges into leaves, and computes the nodes.
    pub(super) fn build(&mut self) {
        let leaves = self.items.len().div_ceil(LEAF) as u32;
        self.nodes.clear();
        self.pending.clear();
        if leaves > 0 {
            self.pending.push((0, leaves));
        }
        while let Some((first, end)) = self.pending.pop() {
            let range = members(&self.items, first, end);
            let items = &mut self.items[range];
            let (low, high) = bounds(items);
            if end - first > 1 {
                let half = first + (end - first) / 2;
                let size = high - low;
                let axis = if size.x >= size.y.max(size.z) {
                    0
                } else if size.y >= size.z {
                    1
                } else {
                    2
                };
                items.select_nth_unstable_by((half - first) as usize * LEAF, |a, b| {
                    a.at[axis].total_cmp(&b.at[axis]).then(a.row.cmp(&b.row))
                });
                self.pending.push((half, end));
                self.pending.push((first, half));
            } else {
                // The selection fixes which charges are in a leaf, but not their order.
                by_row(items);
            }
            self.nodes.push(ChargeNode {
                middle: (low + high) * 0.5,
                radius: (high - low).length() * 0.5,
                first,
                leaves: end - first,
                ..ChargeNode::default()
            });
        }
        // Only now are the charges in their final order, so that the sums do not depend on the order of the splits.
        for node in &mut self.nodes {
            node.sum_up(&self.items[members(&self.items, node.first, node.first + node.leaves)]);
        }
    }

    /// Adds the forces on all charges, near and far; `columns` are those of [`items`](Self::items).
    pub(super) fn sum(
        &mut self,
        columns: &mut ChargeColumns,
        electric: &Electric,
        instructions: InstructionSet,
    ) {
        sum_leaves(self, columns, electric, instructions);
    }

    /// `Σ q_a q_b/√(‖d‖² + ε²)` over all pairs, near ones individually and far ones by their groups, C²/m.
    pub(super) fn potential(&mut self, electric: &Electric) -> f64 {
        let softening = f64::from(electric.softening) * f64::from(electric.softening);
        let mut twice = 0.0;
        let mut bunches = Bunches::default();
        while let Some(bunch) = bunches.next(&self.nodes) {
            let (nodes, walk) = (&self.nodes, &mut self.walk);
            sum_walk(nodes, walk, bunch, electric.opening, InstructionSet::best());
            let bunch = &self.nodes[bunch];
            for (lane, leaf) in (bunch.first..bunch.first + bunch.leaves).enumerate() {
                for k in members(&self.items, leaf, leaf + 1) {
                    let target = self.items[k];
                    twice += target.charge * self.potential_at(k, lane, softening);
                }
            }
        }
        0.5 * twice
    }

    /// Potential at charge `k`, without Coulomb's constant, C/m. Its leaf is number `lane` of the last walk.
    fn potential_at(&self, k: usize, lane: usize, softening: f64) -> f64 {
        let target = self.items[k];
        let mut sum = 0.0;
        for &far in &self.walk.far_of[lane] {
            let node = &self.nodes[self.walk.far[far as usize] as usize];
            // A node at the same point as the target may contain it.
            let own = members(&self.items, node.first, node.first + node.leaves).contains(&k);
            sum += node.potential(target.at, softening, if own { target.charge } else { 0.0 });
        }
        for &(start, end) in &self.walk.near[lane] {
            for j in members(&self.items, start, end) {
                let r2 = (target.at - self.items[j].at).length_squared() + softening;
                if j != k && r2 > 0.0 {
                    sum += self.items[j].charge / r2.sqrt();
                }
            }
        }
        sum
    }
}

/// Iterates over the bunches: the topmost nodes of at most eight leaves, in order.
#[derive(Default)]
struct Bunches {
    at: usize,
}

impl Bunches {
    #[inline]
    fn next(&mut self, nodes: &[ChargeNode]) -> Option<usize> {
        while nodes.get(self.at)?.leaves > LANES as u32 {
            self.at += 1;
        }
        let bunch = self.at;
        self.at += nodes[bunch].subtree_len();
        Some(bunch)
    }
}

/// Sorts the charges of a leaf by row; insertion sort, for so few.
fn by_row(items: &mut [ChargedParticle]) {
    for end in 1..items.len() {
        let mut at = end;
        while at > 0 && items[at - 1].row > items[at].row {
            items.swap(at - 1, at);
            at -= 1;
        }
    }
}

kernel!(
    /// Finds the near and far nodes for the leaves of a bunch.
    fn sum_walk<L: Lanes>(nodes: &[ChargeNode], walk: &mut Walk, bunch: usize, opening: f32) {
        walk.walk::<L>(nodes, bunch, 1.0 / f64::from(opening));
    }
);

kernel!(
    /// Adds the forces on the charges of each leaf.
    fn sum_leaves<L: Lanes>(
        tree: &mut ChargeTree,
        columns: &mut ChargeColumns,
        electric: &Electric,
    ) {
        let ChargeColumns { charges, origins, forces } = columns;
        let ChargeTree { items, nodes, walk, groups, .. } = tree;
        let scale = f64::from(electric.constant.abs().sqrt());
        let softening = electric.softening * electric.softening;
        let per_reach = 1.0 / f64::from(electric.opening);
        let mut bunches = Bunches::default();
        while let Some(n) = bunches.next(nodes) {
            walk.walk::<L>(nodes, n, per_reach);
            let bunch = &nodes[n];
            let far = walk.far.iter().map(|&far| &nodes[far as usize]);
            make_room(groups, walk.far.len());
            groups.extend(far.map(|node| Group::of(node, bunch.middle, scale)));
            for (lane, leaf) in (bunch.first..bunch.first + bunch.leaves).enumerate() {
                let first = leaf as usize * LEAF;
                let targets = Targets::<L>::of(charges, origins, first, softening);
                let mut aside = [Vec4::ZERO; LANES];
                for (aside, item) in aside.iter_mut().zip(&items[members(items, leaf, leaf + 1)]) {
                    *aside = (item.at - bunch.middle).as_vec3().extend(0.0);
                }
                let (place, _) = Vector::of(L::run(&aside, 0));
                let mut total = Vector::splat(Vec3::ZERO);
                for &far in &walk.far_of[lane] {
                    total += targets.forces_of_group(place, &groups[far as usize]);
                }
                for &(start, end) in &walk.near[lane] {
                    let near = start as usize * LEAF..end as usize * LEAF;
                    for (charge, origin) in charges[near.clone()].iter().zip(&origins[near]) {
                        total += targets.forces_of(charge, origin);
                    }
                }
                add(forces, first, total);
            }
        }
    }
);

/// The charges of leaves `first` to `end`.
fn members(items: &[ChargedParticle], first: u32, end: u32) -> Range<usize> {
    first as usize * LEAF..(end as usize * LEAF).min(items.len())
}

/// Bounding box of some charges.
fn bounds(items: &[ChargedParticle]) -> (DVec3, DVec3) {
    let first = items[0].at;
    items.iter().fold((first, first), |(low, high), item| (low.min(item.at), high.max(item.at)))
}
