//! Which boxes overlap at all: so that shapes that are far from each other are never compared.
//!
//! Boxes of like size go into one grid, whose cells are as large as the largest of them along each axis: by its lower corner a box is in one cell,
//! and whatever overlaps it has its own lower corner in that cell or in one of those around it. The grid is folded over (a cell's place is its
//! coordinates modulo powers of two), so that it stays small however far apart they lie, and along x neighbours stay neighbours in memory. Boxes of
//! half the size get a grid of their own; those of a grid look into the larger ones, too. A few, or endless ones (floors, half-spaces), are no grid,
//! but are compared with everything.
//!
//! Boxes that are near each other all the time are searched as one (`clusters`).
//!
//! Sweeping along one axis would compare more: in a pile of 1000 each box has some 150 others beside it there, and 14 to compare here.

mod aabb;
mod clusters;
mod grid;

use glam::Vec3;

pub(crate) use aabb::Aabb;
pub(crate) use clusters::ClusterSearch;
pub(crate) use grid::NO_GROUP;
use grid::{BoxGrid, are_compared};

/// A search for boxes that overlap. What it keeps between calls is memory alone.
#[derive(Default)]
pub(crate) struct Broad {
    /// Class of size, and number, of each box that is one.
    sizes: Vec<(u16, u32)>,
    /// How many boxes there are of a class; then, which of the levels it belongs to.
    classes: Vec<u32>,
    /// Boxes by level, and in each by number.
    levels: Vec<Level>,
    /// Grids, from the largest cells down; only the first ones are filled.
    grids: Vec<BoxGrid>,
    filled: usize,
    /// Compared with everything.
    apart: Vec<u32>,
    /// Pairs in the order in which they were found; then by their second number.
    found: Vec<[u32; 2]>,
    sorted: Vec<[u32; 2]>,
    counts: Vec<u32>,
}

/// Boxes of like size.
#[derive(Default)]
struct Level {
    /// Their largest extents along each axis, metres.
    largest: Vec3,
    boxes: Vec<u32>,
}

/// A class of sizes is what numbers have in common but for the last 20 bits: an eighth of an octave.
const CLASS_SHIFT: u32 = 4;
const CLASSES_PER_OCTAVE: usize = 8;

/// Boxes of a size that are no more than this are compared with everything: 27 cells cost as much.
const FEW: usize = 8;

impl Broad {
    /// Takes boxes in (least and greatest corner). One with NaN, or with less than no extent, overlaps nothing.
    pub(crate) fn fill(&mut self, bounds: &[(Vec3, Vec3)]) {
        self.filled = self.sort_out(bounds, &[]);
    }

    /// Takes them in, and all pairs `[a, b]`, `a < b`, of those that overlap or touch; sorted.
    pub(crate) fn pairs(&mut self, bounds: &[(Vec3, Vec3)], out: &mut Vec<[u32; 2]>) {
        self.pairs_of_groups(bounds, &[], out);
    }

    /// The same, less the pairs of one group each: `groups` has that of each box, or [`NO_GROUP`] for none. It may end before they do.
    pub(crate) fn pairs_of_groups(
        &mut self,
        bounds: &[(Vec3, Vec3)],
        groups: &[u32],
        out: &mut Vec<[u32; 2]>,
    ) {
        self.filled = self.sort_out(bounds, groups);
        self.found.clear();
        let Self { grids: kept, apart, found, filled, .. } = self;
        let grids = &kept[..*filled];
        let group = |i: u32| groups.get(i as usize).copied().unwrap_or(NO_GROUP);
        for (i, a) in apart.iter().enumerate() {
            let (bounds_a, group_a) = (bounds[*a as usize], group(*a));
            let mut compare = |b: u32, bounds_b: (Vec3, Vec3)| {
                if are_compared(group_a, group(b)) && overlap(&bounds_a, &bounds_b) {
                    found.push([(*a).min(b), (*a).max(b)]);
                }
            };
            apart[i + 1..].iter().for_each(|&b| compare(b, bounds[b as usize]));
            for grid in grids {
                grid.each(&mut compare);
            }
        }
        for (i, grid) in grids.iter().enumerate() {
            grid.within(found);
            for larger in &grids[..i] {
                grid.among(larger, found);
            }
        }
        self.sort(bounds.len(), out);
    }

    /// Adds the numbers of the boxes that one overlaps or touches, which need not be one of them. `bounds` are those that were taken in.
    pub(crate) fn around(&self, one: &(Vec3, Vec3), bounds: &[(Vec3, Vec3)], out: &mut Vec<u32>) {
        if !is_box(one) {
            return;
        }
        for grid in &self.grids[..self.filled] {
            grid.around(one, out);
        }
        let apart = self.apart.iter().copied();
        out.extend(apart.filter(|&other| overlap(one, &bounds[other as usize])));
    }

    /// Makes the grids, and says how many.
    fn sort_out(&mut self, bounds: &[(Vec3, Vec3)], groups: &[u32]) -> usize {
        let Self { sizes, classes, levels, grids, apart, .. } = self;
        sizes.clear();
        apart.clear();
        classes.clear();
        classes.resize(usize::from(u16::MAX >> CLASS_SHIFT) + 1, 0);
        for (i, (least, most)) in bounds.iter().enumerate() {
            if is_box(&(*least, *most)) {
                let size = (*most - *least).max_element();
                // Infinity less itself is NaN, which `max_element` may pass over.
                if size < 1e9 && least.is_finite() && most.is_finite() {
                    let class = (size.to_bits() >> (16 + CLASS_SHIFT)) as u16;
                    classes[usize::from(class)] += 1;
                    sizes.push((class, i as u32));
                } else {
                    apart.push(i as u32);
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
        // Nobody who looks is much smaller than the smallest of all, or finds more by smaller cells.
        let smallest = levels[..count].last().map_or(0.0, |level| level.largest.max_element());
        let mut made = 0;
        for level in &levels[..count] {
            if level.boxes.len() <= FEW {
                apart.extend_from_slice(&level.boxes);
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

    /// The pairs found, by their second number and then, keeping that order, by their first: two passes, however they lie.
    fn sort(&mut self, boxes: usize, out: &mut Vec<[u32; 2]>) {
        let Self { found, sorted, counts, .. } = self;
        out.clear();
        out.resize(found.len(), [0; 2]);
        sorted.resize(found.len(), [0; 2]);
        by_number(found, sorted, 1, boxes, counts);
        by_number(sorted, out, 0, boxes, counts);
    }
}

/// Makes levels of classes of sizes, from the largest down, each of no more than an octave; says how many, and writes each class's into its place.
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

/// Sorts by one of the two numbers, keeping the order of equals.
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

/// Whether it is a box: false where a number is NaN.
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
