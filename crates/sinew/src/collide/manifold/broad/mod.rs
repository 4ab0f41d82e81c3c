//! Broad phase: finds pairs of overlapping AABBs, so that only nearby shapes reach the narrow phase.
//!
//! Boxes of similar size share a grid whose cells are as large as the largest of them along each axis. A box is in the cell of its lower corner, and every box
//! that overlaps it has its own lower corner in that cell or a neighbouring one. The grid is folded (a cell's index is its coordinates modulo powers of two),
//! so that it stays small however far apart the boxes lie, and neighbours along x are neighbours in memory. Boxes of half the size have a grid of their own,
//! and are compared with the grids of larger boxes too. Small sets and unbounded boxes (floors, half-spaces) have no grid; they are compared with everything.
//!
//! Consecutive boxes that are close to each other are searched as one, and compared eight at a time (`blocks`): thousands of triangles afresh each time, parts
//! of bodies with candidates that last for several steps (`clusters`).
//!
//! Sweep-and-prune along one axis would compare more: in a pile of 1000 boxes each overlaps some 150 others along the axis, and is compared with 14 here.

mod aabb;
mod blocks;
mod clusters;
mod eight;
mod grid;

use glam::Vec3;

pub(crate) use aabb::Aabb;
pub(crate) use blocks::BlockSearch;
pub(crate) use clusters::ClusterSearch;
pub(crate) use eight::EightBoxes;
pub(crate) use grid::NO_GROUP;
use grid::{BoxGrid, are_compared};

/// Finds overlapping boxes. Only allocations are kept between calls, and what [`query`](Self::query) reads.
#[derive(Default)]
pub(crate) struct Broad {
    /// Size class and number of each valid box.
    sizes: Vec<(u16, u32)>,
    /// Number of boxes of each size class; after grouping, the level of the class.
    classes: Vec<u32>,
    /// Boxes by level, and by number in each level.
    levels: Vec<Level>,
    /// Grids from the largest cells to the smallest; only the first `grid_count` are in use.
    grids: Vec<BoxGrid>,
    grid_count: usize,
    /// Boxes without a grid, compared with everything.
    ungridded: Vec<u32>,
    /// Pairs in the order in which they were found; then sorted by their second number.
    found: Vec<[u32; 2]>,
    sorted: Vec<[u32; 2]>,
    counts: Vec<u32>,
}

/// Boxes of similar size.
#[derive(Default)]
struct Level {
    /// Largest extents along each axis, metres.
    largest: Vec3,
    boxes: Vec<u32>,
}

/// A size class contains the `f32`s that differ in the last 20 bits only: an eighth of an octave.
const CLASS_SHIFT: u32 = 4;
const CLASSES_PER_OCTAVE: usize = 8;

/// A level of at most this many boxes has no grid and is compared with everything: a search of 27 cells costs as much.
const MAX_UNGRIDDED: usize = 8;

impl Broad {
    /// Builds the grids of some boxes (least and greatest corner). A box with a NaN or a negative extent overlaps nothing.
    pub(crate) fn fill(&mut self, bounds: &[(Vec3, Vec3)]) {
        self.grid_count = self.build_grids(bounds, &[]);
    }

    /// Builds the grids and finds all pairs `[a, b]`, `a < b`, of boxes that overlap or touch, sorted.
    pub(crate) fn pairs(&mut self, bounds: &[(Vec3, Vec3)], out: &mut Vec<[u32; 2]>) {
        self.pairs_of_groups(bounds, &[], out);
    }

    /// [`pairs`](Self::pairs) without those of two boxes of one group. `groups` has the group of each box, or [`NO_GROUP`]; boxes beyond its end have none.
    pub(crate) fn pairs_of_groups(
        &mut self,
        bounds: &[(Vec3, Vec3)],
        groups: &[u32],
        out: &mut Vec<[u32; 2]>,
    ) {
        self.grid_count = self.build_grids(bounds, groups);
        self.found.clear();
        let Self { grids: kept, ungridded, found, grid_count, .. } = self;
        let grids = &kept[..*grid_count];
        let group = |i: u32| groups.get(i as usize).copied().unwrap_or(NO_GROUP);
        for (i, a) in ungridded.iter().enumerate() {
            let (bounds_a, group_a) = (bounds[*a as usize], group(*a));
            let mut compare = |b: u32, bounds_b: (Vec3, Vec3)| {
                if are_compared(group_a, group(b)) && overlap(&bounds_a, &bounds_b) {
                    found.push([(*a).min(b), (*a).max(b)]);
                }
            };
            ungridded[i + 1..].iter().for_each(|&b| compare(b, bounds[b as usize]));
            for grid in grids {
                grid.each(&mut compare);
            }
        }
        for (i, grid) in grids.iter().enumerate() {
            grid.pairs_within(found);
            for larger in &grids[..i] {
                grid.pairs_with(larger, found);
            }
        }
        self.sort(bounds.len(), out);
    }

    /// Adds the numbers of the boxes that `one` overlaps or touches; it need not be one of them. `bounds` are the boxes that the grids were built from.
    pub(crate) fn query(&self, one: &(Vec3, Vec3), bounds: &[(Vec3, Vec3)], out: &mut Vec<u32>) {
        if !is_box(one) {
            return;
        }
        for grid in &self.grids[..self.grid_count] {
            grid.overlapping(one, out);
        }
        let ungridded = self.ungridded.iter().copied();
        out.extend(ungridded.filter(|&other| overlap(one, &bounds[other as usize])));
    }

    /// Builds the grids and returns their number.
    fn build_grids(&mut self, bounds: &[(Vec3, Vec3)], groups: &[u32]) -> usize {
        let Self { sizes, classes, levels, grids, ungridded, .. } = self;
        sizes.clear();
        ungridded.clear();
        classes.clear();
        classes.resize(usize::from(u16::MAX >> CLASS_SHIFT) + 1, 0);
        for (i, (least, most)) in bounds.iter().enumerate() {
            if is_box(&(*least, *most)) {
                let size = (*most - *least).max_element();
                // Infinity minus itself is NaN, which `max_element` may ignore.
                if size < 1e9 && least.is_finite() && most.is_finite() {
                    let class = (size.to_bits() >> (16 + CLASS_SHIFT)) as u16;
                    classes[usize::from(class)] += 1;
                    sizes.push((class, i as u32));
                } else {
                    ungridded.push(i as u32);
                }
            }
        }
        let count = group(classes, levels);
        for &(class, i) in &*sizes {
            let (least, most) = bounds[i as usize];
            let level = &mut levels[classes[usize::from(class)] as usize];
            level.largest = level.largest.max(most - least);
            level.boxes.push(i);
        }
        // No box is much smaller than those of the smallest level, so that smaller cells would not exclude more.
        let smallest = levels[..count].last().map_or(0.0, |level| level.largest.max_element());
        let mut made = 0;
        for level in &levels[..count] {
            if level.boxes.len() <= MAX_UNGRIDDED {
                ungridded.extend_from_slice(&level.boxes);
                continue;
            }
            if made == grids.len() {
                grids.push(BoxGrid::default());
            }
            grids[made].fill((level.largest, smallest), &level.boxes, (bounds, groups));
            made += 1;
        }
        made
    }

    /// Sorts the pairs found: by their second number, then stably by their first, in two counting passes.
    fn sort(&mut self, boxes: usize, out: &mut Vec<[u32; 2]>) {
        let Self { found, sorted, counts, .. } = self;
        out.clear();
        out.resize(found.len(), [0; 2]);
        sorted.resize(found.len(), [0; 2]);
        by_number(found, sorted, 1, boxes, counts);
        by_number(sorted, out, 0, boxes, counts);
    }
}

/// Groups size classes into levels of at most an octave each, from the largest down; replaces each class's count by its level and returns the number of levels.
fn group(classes: &mut [u32], levels: &mut Vec<Level>) -> usize {
    let (mut count, mut top) = (0, usize::MAX);
    for class in (0..classes.len()).rev() {
        if classes[class] == 0 {
            continue;
        }
        if count == 0 || top - class >= CLASSES_PER_OCTAVE {
            top = class;
            count += 1;
            if levels.len() < count {
                levels.push(Level::default());
            }
            levels[count - 1].boxes.clear();
            levels[count - 1].largest = Vec3::ZERO;
        }
        classes[class] = count as u32 - 1;
    }
    count
}

/// Counting sort by one of the two numbers; stable.
fn by_number(
    from: &[[u32; 2]],
    to: &mut [[u32; 2]],
    place: usize,
    boxes: usize,
    counts: &mut Vec<u32>,
) {
    counts.clear();
    counts.resize(boxes + 1, 0);
    for pair in from {
        counts[pair[place] as usize + 1] += 1;
    }
    for i in 0..boxes {
        counts[i + 1] += counts[i];
    }
    for pair in from {
        let next = &mut counts[pair[place] as usize];
        to[*next as usize] = *pair;
        *next += 1;
    }
}

/// Whether a box is valid: false where a number is NaN or an extent is negative.
#[inline(always)]
fn is_box((least, most): &(Vec3, Vec3)) -> bool {
    least.cmple(*most).all()
}

/// Whether two boxes overlap or touch.
#[inline(always)]
fn overlap(a: &(Vec3, Vec3), b: &(Vec3, Vec3)) -> bool {
    (a.0.x <= b.1.x)
        & (b.0.x <= a.1.x)
        & (a.0.y <= b.1.y)
        & (b.0.y <= a.1.y)
        & (a.0.z <= b.1.z)
        & (b.0.z <= a.1.z)
}

#[cfg(test)]
mod tests;
