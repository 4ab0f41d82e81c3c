//! Blocks of consecutive boxes that are close to each other, such as the triangles of a cloth or the bones of a ragdoll: up to eight boxes are searched as one,
//! and the boxes of two nearby blocks are compared eight at a time.

use core::ops::Range;

use glam::Vec3;

use super::eight::EightBoxes;
use super::{Broad, NO_GROUP, are_compared, is_box};
use crate::lanes::{LANES, Lanes, SetLanes, Work, with};
use crate::not_cloned::NotCloned;
use crate::threads::{ExecutionContext, each_chunk};

/// Finds overlapping boxes of triangles and particles: all of them, and then those of boxes that are put elsewhere.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockSearch {
    blocks: Vec<BoxBlock>,
    /// A tree over the blocks: the bounds of eight blocks are a block of the lowest level, those of eight of these one of the next, up to a level of one.
    levels: Vec<Vec<BoxBlock>>,
    /// The bounds and the group of each block, and the pairs of overlapping blocks.
    bounds: Vec<(Vec3, Vec3)>,
    groups: Vec<u32>,
    near: Vec<[u32; 2]>,
    broad: NotCloned<Broad>,
    /// The pairs of each chunk of a search.
    of_chunks: Vec<Vec<[u32; 2]>>,
}

/// Least numbers of blocks, and of boxes that are put elsewhere, that are worth a task: each takes some 20 µs.
const CHUNK_BLOCKS: usize = 256;
const CHUNK_QUERIES: usize = 64;

/// Consecutive boxes of one group.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxBlock {
    pub(super) first: u32,
    count: u32,
    boxes: EightBoxes,
}

impl BlockSearch {
    /// Finds all pairs `[i, j]`, `i < j`, of boxes (least and greatest corner) that overlap or touch and are not of one [group](NO_GROUP), sorted. Boxes from
    /// `last` on are not triangles, and are not compared with each other.
    pub(crate) fn pairs(
        &mut self,
        boxes: &[(Vec3, Vec3)],
        of: impl Fn(usize) -> u32,
        last: usize,
        execution: ExecutionContext<'_>,
        out: &mut Vec<[u32; 2]>,
    ) {
        let Self { blocks, bounds, groups, near, broad, of_chunks, .. } = self;
        blocks.clear();
        bounds.clear();
        groups.clear();
        for (i, &(least, most)) in boxes.iter().enumerate() {
            let group = of(i);
            let room = blocks.last().is_some_and(|block| block.count < LANES as u32);
            if !room || groups.last() != Some(&group) || i == last {
                blocks.push(BoxBlock::new(i as u32));
                bounds.push((Vec3::INFINITY, Vec3::NEG_INFINITY));
                groups.push(group);
            }
            let (Some(block), Some(bounds)) = (blocks.last_mut(), bounds.last_mut()) else { break };
            if block.push(&(least, most)) {
                *bounds = (bounds.0.min(least), bounds.1.max(most));
            }
        }
        broad.0.pairs_of_groups(bounds, groups, near);
        let (blocks, groups, near, last) = (&blocks[..], &groups[..], &near[..], last as u32);
        let found =
            each_chunk(execution.workers, blocks, CHUNK_BLOCKS, of_chunks, |first, chunk, out| {
                out.clear();
                let range = first..first + chunk.len();
                let from = near.partition_point(|pair| (pair[0] as usize) < first);
                let near = &near[from..];
                with(
                    execution.instructions,
                    CompareBlocks { blocks, range, groups, near, last, out },
                );
            });
        out.clear();
        found.iter().for_each(|found| out.extend_from_slice(found));
        self.build_tree();
    }

    fn build_tree(&mut self) {
        self.levels.iter_mut().for_each(Vec::clear);
        for level in 0.. {
            if self.levels.len() == level {
                self.levels.push(Vec::new());
            }
            let (below, here) = self.levels.split_at_mut(level);
            let below = below.last().unwrap_or(&self.blocks);
            for (number, block) in (0..).zip(below) {
                if number % LANES as u32 == 0 {
                    here[0].push(BoxBlock::new(number));
                }
                if let Some(top) = here[0].last_mut() {
                    top.push(&block.boxes.bounds());
                }
            }
            if here[0].len() <= 1 {
                break;
            }
        }
    }

    /// Puts a box of the last [`pairs`](Self::pairs) elsewhere.
    pub(crate) fn put(&mut self, i: usize, one: &(Vec3, Vec3)) {
        let mut number = self.blocks.partition_point(|block| block.first as usize <= i) - 1;
        let block = &mut self.blocks[number];
        block.boxes.set(i - block.first as usize, one);
        let mut bounds = block.boxes.bounds();
        for level in &mut self.levels {
            let Some(top) = level.get_mut(number / LANES) else { break };
            top.boxes.set(number % LANES, &bounds);
            (bounds, number) = (top.boxes.bounds(), number / LANES);
        }
    }

    /// Finds the pairs of [`pairs`](Self::pairs) of which one is among `these`, each of which has a mark in `is_one`, and whose boxes are in `boxes`; sorted.
    pub(crate) fn around(
        &mut self,
        (these, is_one): (&[u32], &[bool]),
        boxes: &[(Vec3, Vec3)],
        last: usize,
        execution: ExecutionContext<'_>,
        out: &mut Vec<[u32; 2]>,
    ) {
        let (mut of_chunks, last) = (core::mem::take(&mut self.of_chunks), last as u32);
        let search = &*self;
        let found =
            each_chunk(execution.workers, these, CHUNK_QUERIES, &mut of_chunks, |_, these, out| {
                out.clear();
                with(
                    execution.instructions,
                    QueryBlocks { search, these, is_one, boxes, last, out },
                );
            });
        out.clear();
        found.iter().for_each(|found| out.extend_from_slice(found));
        // As one number, so that a comparison has no branch.
        out.sort_unstable_by_key(|&[i, j]| u64::from(i) << 32 | u64::from(j));
        self.of_chunks = of_chunks;
    }
}

impl BoxBlock {
    /// An empty block; its first box will be number `first`.
    pub(super) fn new(first: u32) -> Self {
        Self { first, count: 0, boxes: EightBoxes::EMPTY }
    }

    /// Adds a box to the next lane, and returns whether it is valid.
    pub(super) fn push(&mut self, one: &(Vec3, Vec3)) -> bool {
        let lane = self.count as usize;
        self.count += 1;
        self.boxes.set(lane, one)
    }
}

/// Adds the pairs of overlapping boxes, sorted, of nearby blocks and within each block.
pub(super) struct CompareBlocks<'a> {
    pub(super) blocks: &'a [BoxBlock],
    /// The blocks whose pairs with those after them are added.
    pub(super) range: Range<usize>,
    /// The [group](NO_GROUP) of each block, whose boxes are not compared with each other; blocks beyond its end have none.
    pub(super) groups: &'a [u32],
    /// Pairs of nearby blocks, sorted, from those of the first block of the range on.
    pub(super) near: &'a [[u32; 2]],
    /// Blocks from this box on are compared only with those before.
    pub(super) last: u32,
    pub(super) out: &'a mut Vec<[u32; 2]>,
}

impl Work for CompareBlocks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { blocks, range, groups, mut near, last, out } = self;
        for number in range {
            let block = &blocks[number];
            if block.first >= last {
                break;
            }
            let mut count = 0;
            while count < near.len() && near[count][0] as usize == number {
                count += 1;
            }
            let (own, others) = near.split_at(count);
            near = others;
            for lane in 0..block.count as usize {
                let one = block.boxes.lane(lane);
                let i = block.first + lane as u32;
                if groups.get(number).is_none_or(|&group| group == NO_GROUP) {
                    let behind = u32::MAX << (lane + 1);
                    for other in SetLanes(block.boxes.overlapping::<L>(one) & behind) {
                        out.push([i, block.first + other as u32]);
                    }
                }
                for &[_, other] in own {
                    let theirs = &blocks[other as usize];
                    for lane in SetLanes(theirs.boxes.overlapping::<L>(one)) {
                        out.push([i, theirs.first + lane as u32]);
                    }
                }
            }
        }
    }
}

/// Adds the pairs of some boxes and of all that they overlap.
struct QueryBlocks<'a> {
    search: &'a BlockSearch,
    these: &'a [u32],
    is_one: &'a [bool],
    boxes: &'a [(Vec3, Vec3)],
    last: u32,
    out: &'a mut Vec<[u32; 2]>,
}

impl Work for QueryBlocks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { search, these, is_one, boxes, last, out } = self;
        let BlockSearch { blocks, levels, groups, .. } = search;
        let Some(root) = levels.iter().position(|level| level.len() == 1) else { return };
        for &i in these {
            let own = blocks.partition_point(|block| block.first <= i) - 1;
            let one = &boxes[i as usize];
            if !is_box(one) {
                continue;
            }
            let one = [one.0.to_array(), one.1.to_array()];
            // For each level the number of the block visited there, and a bit for each of its lanes that is still to be.
            let mut path = [(0_usize, 0_u32); MAX_LEVELS];
            let mut level = root;
            path[root] = (0, levels[root][0].boxes.overlapping::<L>(one));
            loop {
                let (number, lanes) = path[level];
                if lanes == 0 {
                    if level == root {
                        break;
                    }
                    level += 1;
                    continue;
                }
                path[level].1 = lanes & (lanes - 1);
                let number = number * LANES + lanes.trailing_zeros() as usize;
                if level > 0 {
                    level -= 1;
                    path[level] = (number, levels[level][number].boxes.overlapping::<L>(one));
                    continue;
                }
                let block = &blocks[number];
                if !are_compared(groups[own], groups[number]) || i.min(block.first) >= last {
                    continue;
                }
                for lane in SetLanes(block.boxes.overlapping::<L>(one)) {
                    let other = block.first + lane as u32;
                    // A pair of two of them is added for the first.
                    if other > i || other < i && !is_one[other as usize] {
                        out.push([i.min(other), i.max(other)]);
                    }
                }
            }
        }
    }
}

/// Levels of a tree, at most: more than are needed for as many boxes as there are numbers.
const MAX_LEVELS: usize = 11;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::InstructionSet;

    #[test]
    fn it_finds_what_comparing_all_with_all_finds_in_the_same_order() {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1_u64 << 24) as f32
        };
        for (count, last, size) in [(300, 250, 0.2), (70, 70, 0.5), (9, 0, 1.0), (0, 0, 1.0)] {
            let mut boxes: Vec<_> = (0..count)
                .map(|_| {
                    let least = Vec3::new(next(), next(), next());
                    (least, least + size * Vec3::new(next(), next(), next()))
                })
                .collect();
            let mut groups: Vec<u32> = (0..count as u32).map(|i| i / 41 % 3).collect();
            for i in (0..count).step_by(23) {
                boxes[i].0 = [Vec3::NAN, Vec3::splat(9.0)][i % 2];
                groups[i] = NO_GROUP;
            }
            let mut expected = Vec::new();
            for i in 0..last.min(count) {
                for j in i + 1..count {
                    let [a, b] = [boxes[i], boxes[j]];
                    let is_box = |(least, most): (Vec3, Vec3)| least.cmple(most).all();
                    let overlap = a.0.cmple(b.1).all() && b.0.cmple(a.1).all();
                    let compared = groups[i] != groups[j] || groups[i] == NO_GROUP;
                    if is_box(a) && is_box(b) && overlap && compared {
                        expected.push([i as u32, j as u32]);
                    }
                }
            }
            for instructions in [InstructionSet::best(), InstructionSet::Scalar] {
                let execution = ExecutionContext { instructions, workers: None };
                let mut found = vec![[1, 1]];
                let of = |i: usize| groups[i];
                let mut search = BlockSearch::default();
                search.pairs(&boxes, of, last, execution, &mut found);
                assert_eq!(found, expected);
                // All are put elsewhere and back.
                let these: Vec<u32> = (0..count as u32).step_by(7).collect();
                (0..count).for_each(|i| search.put(i, &(Vec3::splat(2.0), Vec3::splat(3.0))));
                (0..count).for_each(|i| search.put(i, &boxes[i]));
                let is_one: Vec<bool> = (0..count).map(|i| i % 7 == 0).collect();
                search.around((&these, &is_one), &boxes, last, execution, &mut found);
                let of_these = |pair: &[u32; 2]| pair.iter().any(|i| i % 7 == 0);
                assert_eq!(found, expected.iter().copied().filter(of_these).collect::<Vec<_>>());
            }
            assert!(count < 70 || expected.len() > 20, "{}", expected.len());
        }
    }
}
