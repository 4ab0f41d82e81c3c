//! Which two are near each other: members sorted by the cell that they are in, and each asked for those in the cells around its own.
//!
//! # Cells
//!
//! The reach of a member is its radius and its margin. Where the cells are as wide as two of the greatest reaches, who is near is in one of the 27
//! cells around one's own. So that one large or fast member does not make all cells large, there are levels: in each are members of reaches within a
//! factor of two, in cells for the greatest of them. A member asks on its own level and on those of the larger ones.
//!
//! Cells have no memory of their own. A cell's slot in the table of its level is `x + y s + z t` modulo the size of the table, a power of two between
//! two and four times the number of members, after M. Müller's dense hash (*Ten minute physics* 11). Where the box about all members has no more
//! cells than that, `s` and `t` are the box's sides, and no two cells share a slot; otherwise they are large odd numbers, and a slot may hold several
//! cells, far from each other, whose members the distance sorts out. Either way the three cells next to each other along x are one stretch of the
//! sorted members.

use glam::DVec3;

use super::super::filter::ContactFilter;
use super::participants::Participants;
use crate::lanes::{LANES, Lanes, kernel};

/// Members by cell. Scratch.
#[derive(Clone, Debug, Default)]
pub(super) struct PairGrid {
    levels: Vec<GridLevel>,
    /// Of each member how far it reaches, metres.
    reach: Vec<f32>,
    /// Of each member its level, largest members first, and its slot there.
    level: Vec<u8>,
    slot: Vec<u32>,
    /// Where each slot begins among the sorted members, all levels one after the other, each with an end.
    starts: Vec<u32>,
    /// The members, by level and slot; after them as many that are nowhere as there are lanes.
    sorted: Sorted,
    /// What is added to reaches against the rounding of `sorted`, metres.
    slack: f32,
    /// The least coordinates, metres from the origin of the first.
    low: DVec3,
}

#[derive(Clone, Debug, Default)]
struct Sorted {
    participant: Vec<u32>,
    /// The number of its body.
    body: Vec<f32>,
    /// Metres from `low`, and the reach.
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    reach: Vec<f32>,
}

/// Cells for members of a size.
#[derive(Clone, Copy, Debug, Default)]
struct GridLevel {
    /// Its greatest reach, metres.
    reach: f32,
    count: u32,
    /// Cells a metre.
    per_metre: f64,
    /// Slots from one row of cells to the next, and from one layer.
    row: u32,
    layer: u32,
    /// Slots less one.
    mask: u32,
    /// Its first slot.
    first: u32,
}

/// The levels there may be. The last one takes all who are smaller yet.
const LEVELS: usize = 12;

impl PairGrid {
    /// Sorts the members.
    /// Each reaches as far as its radius and its allowance, metres.
    pub(super) fn fill(&mut self, participants: &Participants, allowances: &[f32]) {
        self.reach.clear();
        let columns = participants.radius.iter().zip(allowances);
        self.reach.extend(columns.map(|(radius, allowance)| radius + allowance));
        self.measure(participants);
        self.count(participants);
        self.sort(participants);
    }

    /// Finds the levels and the box about all.
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
            // How often it goes into the greatest, as a power of two: the exponent of an `f32`.
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
        // Each coordinate is rounded by 2⁻²⁴ of itself at most, a difference by twice that along each of three axes; and reaches and squares by some
        // more.
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

    /// Counts who is in each slot, and where it ends.
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
        // From the last one down, so that each slot's members end up in their order and its mark at its beginning.
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
    /// For members of a reach in a box of a size, metres.
    fn lay_out(&mut self, size: DVec3, reach: f64) {
        self.per_metre = 0.5 / reach;
        let slots = (2 * self.count).next_power_of_two().max(64);
        self.mask = slots - 1;
        // And one on either side, for the asking.
        let cells = (size * self.per_metre).floor() + 3.0;
        if cells.x * cells.y * cells.z <= f64::from(slots) {
            self.row = cells.x as u32;
            self.layer = self.row * cells.y as u32;
        } else {
            // Of Teschner and others, *Optimized spatial hashing*, 2003: large, odd, and without a common measure.
            (self.row, self.layer) = (19_349_663, 83_492_791);
        }
    }

    #[inline(always)]
    fn slot(&self, place: DVec3) -> u32 {
        let cell = place * self.per_metre;
        // No coordinate is negative, but those of small members who ask on a level of larger ones are not, either: towards zero is down.
        let number = |x: f64| (x as i64 as u32).wrapping_add(1);
        let (x, y, z) = (number(cell.x), number(cell.y), number(cell.z));
        let (y, z) = (y.wrapping_mul(self.row), z.wrapping_mul(self.layer));
        x.wrapping_add(y).wrapping_add(z) & self.mask
    }
}

kernel!(
    /// Asks for every member who is near it.
    /// Cell by cell, so that those who are asked for are in the cache. Each asks for those in half of the cells about its own, and is asked for from
    /// the other half.
    pub(super) fn list_candidates<L: Lanes>(
        grid: &PairGrid,
        participants: &Participants,
        filter: &ContactFilter,
        found: &mut Vec<[u32; 2]>,
    ) {
        let takes_part = grid.level.iter().filter(|level| **level != u8::MAX).count();
        let (mut beside, mut larger) = (Stretches::default(), Stretches::default());
        let mut last = None;
        for &i in &grid.sorted.participant[..takes_part] {
            let i = i as usize;
            let (own, slot) = (grid.level[i], grid.slot[i]);
            let asker = Asker::<L>::new(grid, (participants, filter), i);
            // Those of one slot follow each other, and ask the same.
            if last != Some((own, slot)) {
                last = Some((own, slot));
                beside.find(grid, own, slot, OWN_LINE);
            }
            for (stretch, of_own_line) in beside.iter() {
                asker.ask(found, stretch, of_own_line);
            }
            for number in 0..own {
                let level = &grid.levels[number as usize];
                if level.count == 0 {
                    continue;
                }
                larger.find(grid, number, level.slot(participants.place[i] - grid.low), 0);
                for (stretch, _) in larger.iter() {
                    asker.ask(found, stretch, false);
                }
            }
        }
    }
);

/// Of the nine lines of cells, counted from below, that through one's own cell.
const OWN_LINE: u32 = 4;

/// Where those are among the sorted members who are in some lines of cells about one.
#[derive(Default)]
struct Stretches {
    /// The first, and the first behind.
    each: [[u32; 2]; 18],
    count: usize,
    /// So many of them are of the line through the cell itself.
    of_own_line: usize,
}

impl Stretches {
    /// Those about a slot of a level, from one of the nine lines on.
    fn find(&mut self, grid: &PairGrid, level: u8, slot: u32, first_line: u32) {
        let level = &grid.levels[level as usize];
        let slots = level.mask + 1;
        (self.count, self.of_own_line) = (0, 0);
        for line in first_line..9 {
            let beside = (line % 3).wrapping_sub(1).wrapping_mul(level.row);
            let below = (line / 3).wrapping_sub(1).wrapping_mul(level.layer);
            let left = slot.wrapping_add(beside).wrapping_add(below).wrapping_sub(1) & level.mask;
            // Three slots, which may go round the end of the table.
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

    /// Takes those in some slots of a level, if there are any.
    fn add(&mut self, grid: &PairGrid, level: &GridLevel, slots: [u32; 2]) {
        // No `array::map`, which is a call of several functions.
        let start = |slot: u32| grid.starts[(level.first + slot) as usize];
        let stretch = [start(slots[0]), start(slots[1])];
        if stretch[0] < stretch[1] {
            self.each[self.count] = stretch;
            self.count += 1;
        }
    }

    /// Each of them, and whether it is of the line through the cell itself: so it is where that is the first.
    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = ([u32; 2], bool)> {
        let each = self.each[..self.count].iter().enumerate();
        each.map(|(number, stretch)| (*stretch, number < self.of_own_line))
    }
}

/// Who asks, in all lanes.
struct Asker<'a, L> {
    sorted: &'a Sorted,
    number: usize,
    x: L,
    y: L,
    z: L,
    reach: L,
    /// The number of its body, if that does not touch itself: most who are near are of it.
    own: Option<L>,
}

/// Numbers of bodies below that are a number in `f32` each.
const EXACT: u32 = 1 << 24;

impl<'a, L: Lanes> Asker<'a, L> {
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

    /// Notes who is near in a stretch of the sorted ones; where all of a line ask each other, only those `after` it.
    #[inline(always)]
    fn ask(&self, found: &mut Vec<[u32; 2]>, [first, end]: [u32; 2], after: bool) {
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
