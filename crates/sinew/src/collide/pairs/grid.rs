//! Broad phase grid: participants are sorted by cell, and each is tested against those in the cells around its own.
//!
//! # Cells
//!
//! The reach of a participant is its radius plus its allowance. With cells as wide as twice the greatest reach, all neighbours are in the 27 cells around a
//! participant's own. So that one large or fast particle does not make all cells large, there are levels: each holds participants whose reaches are within a
//! factor of two, in cells for the greatest of them. A participant is tested on its own level and on those of the larger ones.
//!
//! Cells are not stored. The slot of a cell in the table of its level is `x + y s + z t` modulo the size of the table, a power of two between two and four
//! times the number of participants, after M. Müller's dense hash (*Ten minute physics* 11). Where the box about all participants has no more cells than that,
//! `s` and `t` are the sides of the box, and no two cells share a slot. Otherwise they are large odd numbers, and a slot may hold several cells far from each
//! other, whose participants the distance test separates. Either way three cells adjacent along x are one contiguous range of the sorted participants.

use glam::DVec3;

use super::super::filter::ContactFilter;
use super::participants::Participants;
use crate::lanes::{LANES, Lanes, kernel};

/// Participants sorted by cell. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct PairGrid {
    levels: Vec<GridLevel>,
    /// Reach of each participant, metres.
    reach: Vec<f32>,
    /// Level of each participant, that of the largest first, and its slot there.
    level: Vec<u8>,
    slot: Vec<u32>,
    /// Start of each slot among the sorted participants, all levels one after the other, each followed by an end.
    starts: Vec<u32>,
    /// The participants, by level and slot; padded by one register of zeros, so that the last can be loaded whole.
    sorted: Sorted,
    /// Added to reaches against the rounding of `sorted`, metres.
    slack: f32,
    /// Minimum corner of the bounds, metres from the origin of the first participant.
    low: DVec3,
}

#[derive(Clone, Debug, Default)]
struct Sorted {
    participant: Vec<u32>,
    /// Body index, as a float so that it can be compared in lanes.
    body: Vec<f32>,
    /// Position in metres from `low`, and the reach.
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    reach: Vec<f32>,
}

/// A grid for participants of similar reach.
#[derive(Clone, Copy, Debug, Default)]
struct GridLevel {
    /// Greatest reach of its participants, metres.
    reach: f32,
    count: u32,
    /// Cells per metre.
    per_metre: f64,
    /// Slot stride from one row of cells to the next, and from one layer to the next.
    row: u32,
    layer: u32,
    /// Number of slots minus one.
    mask: u32,
    /// Its first slot.
    first: u32,
}

/// Maximum number of levels. The last one takes all smaller participants.
const LEVELS: usize = 12;

impl PairGrid {
    /// Sorts the participants into cells. The reach of each is its radius plus its allowance, metres.
    pub(super) fn fill(&mut self, participants: &Participants, allowances: &[f32]) {
        self.reach.clear();
        let columns = participants.radius.iter().zip(allowances);
        self.reach.extend(columns.map(|(radius, allowance)| radius + allowance));
        self.measure(participants);
        self.count(participants);
        self.sort(participants);
    }

    /// Computes the levels and the bounds of all participants.
    fn measure(&mut self, participants: &Participants) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut most = 0.0_f32;
        for (i, place) in participants.place.iter().enumerate() {
            if place.x.is_finite() {
                (low, high) = (low.min(*place), high.max(*place));
                most = most.max(self.reach[i]);
            }
        }
        self.levels.clear();
        self.levels.resize(LEVELS, GridLevel::default());
        self.level.clear();
        for (i, place) in participants.place.iter().enumerate() {
            if !place.x.is_finite() {
                self.level.push(u8::MAX);
                continue;
            }
            let reach = self.reach[i];
            // log2 of the ratio to the greatest reach, rounded down: the exponent of the `f32`.
            let exponent = ((most / reach).to_bits() >> 23).saturating_sub(127);
            let number = (exponent as usize).min(LEVELS - 1);
            let level = &mut self.levels[number];
            level.count += 1;
            level.reach = level.reach.max(reach);
            self.level.push(number as u8);
        }
        if most == 0.0 {
            (low, high) = (DVec3::ZERO, DVec3::ZERO);
        }
        self.low = low;
        let size = high - low;
        // Each coordinate is rounded by at most 2⁻²⁴ of itself, a difference by twice that along each of three axes; reaches and squares add some more.
        self.slack = (size.max_element() * 4e-7) as f32 + most * 1e-5;
        let mut first = 0;
        for level in self.levels.iter_mut().filter(|level| level.count > 0) {
            level.lay_out(size, f64::from(level.reach + self.slack));
            level.first = first;
            first += level.mask + 2;
        }
        self.starts.clear();
        self.starts.resize(first as usize + 1, 0);
    }

    /// Counts the participants of each slot, and sums up to the end of each.
    fn count(&mut self, participants: &Participants) {
        self.slot.clear();
        for (place, &number) in participants.place.iter().zip(&self.level) {
            if number == u8::MAX {
                self.slot.push(0);
                continue;
            }
            let level = &self.levels[number as usize];
            let slot = level.slot(*place - self.low);
            self.slot.push(slot);
            self.starts[(level.first + slot) as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
    }

    fn sort(&mut self, participants: &Participants) {
        let Self { levels, level, slot, starts, sorted, low, reach: reaches, .. } = self;
        let count = participants.rows.len();
        sorted.participant.resize(count, 0);
        let Sorted { body, x, y, z, reach, .. } = sorted;
        for column in [body, x, y, z, reach] {
            column.resize(count + LANES, 0.0);
        }
        // From the last one down, so that the participants of a slot stay in order and `starts` ends up at the beginning of each slot.
        for i in (0..count).rev().filter(|&i| level[i] != u8::MAX) {
            let mark = &mut starts[(levels[level[i] as usize].first + slot[i]) as usize];
            *mark -= 1;
            let (at, place) = (*mark as usize, (participants.place[i] - *low).as_vec3());
            sorted.participant[at] = i as u32;
            (sorted.x[at], sorted.y[at], sorted.z[at]) = (place.x, place.y, place.z);
            sorted.reach[at] = reaches[i];
            sorted.body[at] = participants.body[i] as f32;
        }
    }
}

impl GridLevel {
    /// Lays out cells for a reach in a box of a size, metres.
    fn lay_out(&mut self, size: DVec3, reach: f64) {
        self.per_metre = 0.5 / reach;
        let slots = (2 * self.count).next_power_of_two().max(64);
        self.mask = slots - 1;
        // One more on either side, since the neighbours of border cells are visited.
        let cells = (size * self.per_metre).floor() + 3.0;
        if cells.x * cells.y * cells.z <= f64::from(slots) {
            self.row = cells.x as u32;
            self.layer = self.row * cells.y as u32;
        } else {
            // From Teschner et al., *Optimized spatial hashing*, 2003: large, odd and coprime.
            (self.row, self.layer) = (19_349_663, 83_492_791);
        }
    }

    #[inline(always)]
    fn slot(&self, place: DVec3) -> u32 {
        let cell = place * self.per_metre;
        // Truncation is rounding down: no coordinate is negative, also not those of small participants tested on a coarser level.
        let number = |x: f64| (x as i64 as u32).wrapping_add(1);
        let (x, y, z) = (number(cell.x), number(cell.y), number(cell.z));
        let (y, z) = (y.wrapping_mul(self.row), z.wrapping_mul(self.layer));
        x.wrapping_add(y).wrapping_add(z) & self.mask
    }
}

kernel!(
    /// Lists every pair of participants within reach of each other.
    /// Goes cell by cell, so that the data of neighbouring cells is in the cache. Each participant is tested against half of the cells about its own; the other
    /// half tests against it.
    pub(super) fn list_candidates<L: Lanes>(
        grid: &PairGrid,
        participants: &Participants,
        filter: &ContactFilter,
        found: &mut Vec<[u32; 2]>,
    ) {
        let takes_part = grid.level.iter().filter(|level| **level != u8::MAX).count();
        let (mut beside, mut larger) = (CellRanges::default(), CellRanges::default());
        let mut last = None;
        for &i in &grid.sorted.participant[..takes_part] {
            let i = i as usize;
            let (own, slot) = (grid.level[i], grid.slot[i]);
            let query = Query::<L>::new(grid, (participants, filter), i);
            // Participants of one slot are consecutive and share the ranges.
            if last != Some((own, slot)) {
                last = Some((own, slot));
                beside.find(grid, own, slot, OWN_LINE);
            }
            for (range, of_own_line) in beside.iter() {
                query.test(found, range, of_own_line);
            }
            for number in 0..own {
                let level = &grid.levels[number as usize];
                if level.count == 0 {
                    continue;
                }
                larger.find(grid, number, level.slot(participants.place[i] - grid.low), 0);
                for (range, _) in larger.iter() {
                    query.test(found, range, false);
                }
            }
        }
    }
);

/// Of the nine lines of cells along x, counted from below, the one through the participant's own cell.
const OWN_LINE: u32 = 4;

/// Ranges of the sorted participants in some lines of cells about a cell.
#[derive(Default)]
struct CellRanges {
    /// Start and end of each.
    each: [[u32; 2]; 18],
    count: usize,
    /// How many of them belong to the line through the cell itself.
    of_own_line: usize,
}

impl CellRanges {
    /// The ranges about a slot of a level, starting at one of the nine lines.
    fn find(&mut self, grid: &PairGrid, level: u8, slot: u32, first_line: u32) {
        let level = &grid.levels[level as usize];
        let slots = level.mask + 1;
        (self.count, self.of_own_line) = (0, 0);
        for line in first_line..9 {
            let beside = (line % 3).wrapping_sub(1).wrapping_mul(level.row);
            let below = (line / 3).wrapping_sub(1).wrapping_mul(level.layer);
            let left = slot.wrapping_add(beside).wrapping_add(below).wrapping_sub(1) & level.mask;
            // Three slots, which may wrap around the end of the table.
            let end = left + 3;
            self.add(grid, level, [left, end.min(slots)]);
            if end > slots {
                self.add(grid, level, [0, end - slots]);
            }
            if line == OWN_LINE {
                self.of_own_line = self.count;
            }
        }
    }

    /// Adds the participants in a range of slots of a level, if there are any.
    fn add(&mut self, grid: &PairGrid, level: &GridLevel, slots: [u32; 2]) {
        // Not `array::map`, which compiles to several function calls.
        let start = |slot: u32| grid.starts[(level.first + slot) as usize];
        let range = [start(slots[0]), start(slots[1])];
        if range[0] < range[1] {
            self.each[self.count] = range;
            self.count += 1;
        }
    }

    /// Each range, and whether it belongs to the line through the cell itself; such ranges come first.
    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = ([u32; 2], bool)> {
        let each = self.each[..self.count].iter().enumerate();
        each.map(|(number, range)| (*range, number < self.of_own_line))
    }
}

/// The participant whose neighbours are sought, broadcast to all lanes.
struct Query<'a, L> {
    sorted: &'a Sorted,
    number: usize,
    x: L,
    y: L,
    z: L,
    reach: L,
    /// Its body, if that does not collide with itself: most neighbours belong to it.
    own: Option<L>,
}

/// Body indices below this are exact in `f32`.
const EXACT: u32 = 1 << 24;

impl<'a, L: Lanes> Query<'a, L> {
    #[inline(always)]
    fn new(
        grid: &'a PairGrid,
        (participants, filter): (&'a Participants, &'a ContactFilter),
        number: usize,
    ) -> Self {
        let place = (participants.place[number] - grid.low).as_vec3();
        let body = participants.body[number];
        let alone = body < EXACT && !filter.body(body).with_itself;
        Self {
            sorted: &grid.sorted,
            number,
            x: L::splat(place.x),
            y: L::splat(place.y),
            z: L::splat(place.z),
            reach: L::splat(grid.reach[number] + grid.slack),
            own: if alone { Some(L::splat(body as f32)) } else { None },
        }
    }

    /// Adds the participants within reach in a range of the sorted ones. In its own line every participant is tested against all, so only those `after` it are
    /// added.
    #[inline(always)]
    fn test(&self, found: &mut Vec<[u32; 2]>, [first, end]: [u32; 2], after: bool) {
        let Self { sorted, number, .. } = self;
        let (mut at, end) = (first as usize, end as usize);
        while at < end {
            let x = self.x - eight::<L>(&sorted.x, at);
            let y = self.y - eight::<L>(&sorted.y, at);
            let z = self.z - eight::<L>(&sorted.z, at);
            let reach = self.reach + eight::<L>(&sorted.reach, at);
            let distance = x * x + y * y + z * z;
            let mut bits = distance.lt(reach * reach).bits();
            if let Some(own) = self.own {
                bits &= !eight::<L>(&sorted.body, at).same(own).bits();
            }
            if end - at < LANES {
                bits &= (1 << (end - at)) - 1;
            }
            while bits != 0 {
                let other = sorted.participant[at + bits.trailing_zeros() as usize] as usize;
                bits &= bits - 1;
                if other > *number || !after {
                    found.push([(*number).min(other) as u32, (*number).max(other) as u32]);
                }
            }
            at += LANES;
        }
    }
}

#[inline(always)]
fn eight<L: Lanes>(column: &[f32], at: usize) -> L {
    match column[at..].first_chunk() {
        Some(eight) => L::load(eight),
        None => L::zero(),
    }
}
