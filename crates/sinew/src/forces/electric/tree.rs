//! Many charges: those that are near act one by one, far groups of them as one (Barnes and Hut 1986).
//!
//! # What a group does
//!
//! With `c` the mean place of the charges of a group, weighted by their magnitudes, `Q = Σ q` and `D = Σ q (x - c)`, the potential at a far
//! point is that of a charge and of a dipole,
//!
//! ```text
//! φ = Q/s + D·d/s³        d = x - c,  s² = ‖d‖² + ε²
//! E = -∇φ = (Q d - D)/s³ + 3 (D·d) d/s⁵
//! ```
//!
//! and the next term is smaller by (size/distance)². Charges of one sign have no dipole about their own mean. Where signs are mixed `Q` is near
//! zero, and the dipole is most of what a group does: without it the error is 2.6 times as large (4096 charges, opening 0.5).
//!
//! A group acts as one on a target at the distance `r` if no charge of it is farther than `opening · r` from `c`.
//!
//! # The tree
//!
//! Sixteen neighbours at a time are the targets, and the leaves. The charges are halved by a plane across their longest extent, and the halves
//! again, always at a multiple of sixteen: every leaf but the last is full, the tree is as deep as the logarithm of their number wherever
//! they are, and needs no pointers: a node with `n` leaves is followed by those of its first half and then by those of its second, `2n - 1` in
//! all. (Of an octree along a Morton curve the leaves are half empty, and charges crowded in one place make it deep.) Ties are broken by the row, so
//! the tree and all sums are functions of the particles alone.
//!
//! The sixteen share one walk. Differences to a group are taken in `f64` from the middle of the sixteen, so that they keep their digits
//! wherever in the world they are.
//!
//! # What is lost
//!
//! Momentum: a group acts on a target, and the target on the members of the group one by one or in other groups, so the forces add up to
//! nothing only as well as they are approximated. Measured on charges of either sign, spread evenly, where most of what far groups do cancels
//! (error: root mean square, as a share of that of the forces; sum: of all forces, as a share of the sum of their magnitudes; milliseconds on
//! one core of a shared machine, where all pairs take 2.4 to 3.8 ns a pair: 20 ms for the 4096, 7 to 8 s for the 65 536):
//!
//! | opening | error, 4096 | error, 65 536 | sum, 65 536 | ms, 4096 | ms, 65 536 |
//! |---|---|---|---|---|---|
//! | 0.4 | 0.20 % | 0.31 % | 1e-5 | 9 | 180 |
//! | 0.5 | 0.38 % | 0.53 % | 4e-5 | 4.3 | 120 to 145 |
//! | 0.6 | 0.60 % | 0.80 % | 3e-5 | 3.4 | 90 to 100 |
//! | 0.7 | 0.85 % | 1.13 % | 5e-5 | 2.9 | 70 to 110 |
//!
//! For 5000 charges of one sign, at 0.5, the error is 0.54 %, and the sum of the forces 1e-3 of their magnitudes.
//!
//! Taken charge by charge, each error relative to that charge's own force, the root mean square is some seven times that: it is made
//! of the few charges on which large forces nearly cancel.

use core::ops::Range;

use glam::{DVec3, Vec3};

use super::Electric;
use super::columns::{Columns, Item, LANES, Lanes, NEAR};
use super::pairs::add;

/// The charges in the order of the tree's leaves, and its nodes from the root on.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    pub items: Vec<Item>,
    nodes: Vec<Node>,
    /// Ranges of leaves yet to be halved.
    pending: Vec<(u32, u32)>,
    near: Vec<(u32, u32)>,
    far: Vec<u32>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    /// Mean place of the charges, weighted by their magnitudes, metres.
    centre: DVec3,
    /// Distance of the farthest one from it, metres; exactly zero where all are at one point.
    reach: f64,
    /// C.
    charge: f64,
    /// C·m.
    dipole: DVec3,
    /// Middle of the box around the charges, and distance to its corners, metres.
    middle: DVec3,
    radius: f64,
    /// The first of its leaves, and how many there are.
    first: u32,
    leaves: u32,
}

/// A far group, as the targets at hand see it.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Its centre, metres from the middle of the targets.
    centre: Vec3,
    charge: f32,
    dipole: Vec3,
}

impl Tree {
    /// The tree of these charges.
    pub(super) fn of(items: Vec<Item>) -> Self {
        let mut tree = Self { items, ..Self::default() };
        tree.grow();
        tree
    }

    /// Sorts the charges into leaves, and sums up the nodes.
    pub(super) fn grow(&mut self) {
        let leaves = self.items.len().div_ceil(LANES) as u32;
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
                items.select_nth_unstable_by((half - first) as usize * LANES, |a, b| {
                    a.at[axis].total_cmp(&b.at[axis]).then(a.row.cmp(&b.row))
                });
                self.pending.push((half, end));
                self.pending.push((first, half));
            } else {
                // Which sixteen they are is settled, but not in which order they were left.
                items.sort_unstable_by_key(|item| item.row);
            }
            self.nodes.push(Node {
                middle: (low + high) * 0.5,
                radius: (high - low).length() * 0.5,
                first,
                leaves: end - first,
                ..Node::default()
            });
        }
        // Only now are the charges in their final order, and a sum does not depend on how they were halved.
        for node in &mut self.nodes {
            node.sum_up(&self.items[members(&self.items, node.first, node.first + node.leaves)]);
        }
    }

    /// Adds the forces on all charges, near and far; `columns` are those of [`items`](Self::items).
    pub(super) fn sum(&mut self, columns: &mut Columns, law: &Electric) {
        let scale = f64::from(law.constant.abs().sqrt());
        let softening = law.softening * law.softening;
        for n in 0..self.nodes.len() {
            let node = self.nodes[n];
            if node.leaves > 1 {
                continue;
            }
            self.walk(&node, law.opening);
            let first = node.first as usize * LANES;
            let targets = columns.targets(first);
            let aside = self.aside(&node);
            let mut total = [[0.0; LANES]; 3];
            for &far in &self.far {
                let group = self.nodes[far as usize].seen_from(node.middle, scale);
                add(&mut total, &group.forces(&aside, &targets.charge, softening));
            }
            for &(start, end) in &self.near {
                for k in start as usize * LANES..end as usize * LANES {
                    add(&mut total, &columns.forces_of(k, &targets, softening));
                }
            }
            columns.add(first, &total);
        }
    }

    /// `Σ q_a q_b/√(‖d‖² + ε²)` over all pairs, near ones as they are and far ones by their groups, C²/m.
    pub(super) fn potential(&mut self, law: &Electric) -> f64 {
        let softening = f64::from(law.softening) * f64::from(law.softening);
        let mut twice = 0.0;
        for n in 0..self.nodes.len() {
            let node = self.nodes[n];
            if node.leaves > 1 {
                continue;
            }
            self.walk(&node, law.opening);
            for k in members(&self.items, node.first, node.first + 1) {
                let target = self.items[k];
                let mut sum = 0.0;
                for &far in &self.far {
                    // At one point with the target, it may be one of them.
                    let own = node.first.wrapping_sub(self.nodes[far as usize].first)
                        < self.nodes[far as usize].leaves;
                    let own = if own { target.charge } else { 0.0 };
                    sum += self.nodes[far as usize].potential(target.at, softening, own);
                }
                for &(start, end) in &self.near {
                    for j in members(&self.items, start, end) {
                        let r2 = (target.at - self.items[j].at).length_squared() + softening;
                        if j != k && r2 > 0.0 {
                            sum += self.items[j].charge / r2.sqrt();
                        }
                    }
                }
                twice += target.charge * sum;
            }
        }
        0.5 * twice
    }

    /// Finds what acts on the charges of a leaf: the nodes that act as one, and ranges of leaves that do not.
    fn walk(&mut self, targets: &Node, opening: f32) {
        let per_reach = 1.0 / f64::from(opening);
        self.far.clear();
        self.near.clear();
        let mut n = 0;
        while let Some(node) = self.nodes.get(n) {
            let least = node.reach * per_reach + targets.radius;
            let whole = 2 * node.leaves as usize - 1;
            // Charges at one point are a single charge, however near.
            if node.reach == 0.0 || (node.centre - targets.middle).length_squared() > least * least
            {
                self.far.push(n as u32);
                n += whole;
            } else {
                if node.leaves == 1 {
                    match self.near.last_mut() {
                        Some((_, end)) if *end == node.first => *end += 1,
                        _ => self.near.push((node.first, node.first + 1)),
                    }
                }
                n += 1;
            }
        }
    }

    /// The charges of a leaf, metres from its middle.
    fn aside(&self, leaf: &Node) -> [Lanes; 3] {
        let mut aside = [[0.0; LANES]; 3];
        for (l, k) in members(&self.items, leaf.first, leaf.first + 1).enumerate() {
            let d = (self.items[k].at - leaf.middle).as_vec3().to_array();
            (0..3).for_each(|axis| aside[axis][l] = d[axis]);
        }
        aside
    }
}

impl Node {
    fn sum_up(&mut self, items: &[Item]) {
        let (mut weight, mut centre) = (0.0, DVec3::ZERO);
        for item in items {
            weight += item.charge.abs();
            centre += (item.at - self.middle) * item.charge.abs();
        }
        self.centre = self.middle;
        if self.radius > 0.0 && weight > 0.0 {
            self.centre += centre / weight;
        }
        let mut reach2 = 0.0_f64;
        for item in items {
            let d = item.at - self.centre;
            self.charge += item.charge;
            self.dipole += d * item.charge;
            reach2 = reach2.max(d.length_squared());
        }
        // Not the round-off of the middle of one point.
        if self.radius > 0.0 {
            self.reach = reach2.sqrt();
        } else {
            self.centre = items[0].at;
            self.dipole = DVec3::ZERO;
        }
    }

    fn seen_from(&self, middle: DVec3, scale: f64) -> Group {
        Group {
            centre: (self.centre - middle).as_vec3(),
            charge: (self.charge * scale) as f32,
            dipole: (self.dipole * scale).as_vec3(),
        }
    }

    /// Potential at `point` without Coulomb's constant, C/m; of the charge alone, less `own`, where all of it is at that very point.
    fn potential(&self, point: DVec3, softening: f64, own: f64) -> f64 {
        let d = point - self.centre;
        let s2 = d.length_squared() + softening;
        if s2 == 0.0 {
            return 0.0;
        }
        let s = s2.sqrt();
        (self.charge - own) / s + self.dipole.dot(d) / (s2 * s)
    }
}

impl Group {
    /// The force on each target, N but for the sign of Coulomb's constant.
    #[inline(always)]
    fn forces(&self, aside: &[Lanes; 3], charge: &Lanes, softening: f32) -> [Lanes; 3] {
        let (c, p) = (self.centre, self.dipole);
        let mut forces = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let (dx, dy, dz) = (aside[0][l] - c.x, aside[1][l] - c.y, aside[2][l] - c.z);
            let r2 = dx * dx + dy * dy + dz * dz + softening;
            let r2 = if r2 > NEAR { r2 } else { NEAR };
            let inverse2 = 1.0 / r2;
            let strength = (charge[l] * inverse2) * (inverse2 * r2.sqrt());
            let along = self.charge + 3.0 * (p.x * dx + p.y * dy + p.z * dz) * inverse2;
            forces[0][l] = (along * dx - p.x) * strength;
            forces[1][l] = (along * dy - p.y) * strength;
            forces[2][l] = (along * dz - p.z) * strength;
        }
        forces
    }
}

/// The charges of leaves `first` to `end`.
fn members(items: &[Item], first: u32, end: u32) -> Range<usize> {
    first as usize * LANES..(end as usize * LANES).min(items.len())
}

/// The box around charges.
fn bounds(items: &[Item]) -> (DVec3, DVec3) {
    let first = items[0].at;
    items.iter().fold((first, first), |(low, high), item| (low.min(item.at), high.max(item.at)))
}
