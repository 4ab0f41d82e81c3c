//! One grid of boxes of similar size.

use glam::{IVec3, Vec3};

use super::aabb::Aabb;

/// A box in a grid.
#[derive(Clone, Copy)]
struct BoxEntry {
    bounds: Aabb,
    number: u32,
    /// Boxes of one group are not compared with each other, except for [`NO_GROUP`].
    group: u32,
}

/// The group of boxes that belong to none.
pub(crate) const NO_GROUP: u32 = u32::MAX;

/// Whether boxes of two groups are compared.
#[inline(always)]
pub(super) fn are_compared(group: u32, other: u32) -> bool {
    group != other || group == NO_GROUP
}

impl BoxEntry {
    fn new(bounds: &(Vec3, Vec3), number: u32) -> Self {
        Self { bounds: Aabb::new(*bounds), number, group: NO_GROUP }
    }

    /// Whether two boxes overlap or touch.
    #[inline(always)]
    fn overlaps(&self, other: &Self) -> bool {
        self.bounds.overlaps(&other.bounds)
    }
}

/// Boxes sorted by the cell of their lower corner.
#[derive(Default)]
pub(super) struct BoxGrid {
    entries: Vec<BoxEntry>,
    /// Index of each cell's first entry, then the number of entries.
    starts: Vec<u32>,
    /// Cells per metre along each axis.
    density: Vec3,
    /// Largest extents of a box in the grid, slightly enlarged, metres.
    size: Vec3,
    /// Number of cells along each axis: powers of two.
    cells: IVec3,
}

/// Cells per box: more cells mean fewer comparisons, but more memory to traverse.
const CELLS_PER_BOX: usize = 4;

impl BoxGrid {
    /// Fills the grid; `largest` are the greatest extents of any of the boxes, and no cell is smaller than `least`, metres. Cells are as large as the boxes
    /// along each axis separately: otherwise stairs of 40 m by 10 by 1 would all be in one cell.
    pub(super) fn fill(
        &mut self,
        (largest, least): (Vec3, f32),
        these: &[u32],
        (bounds, groups): (&[(Vec3, Vec3)], &[u32]),
    ) {
        // Boxes without extent need cells too, and the inverse of a cell's size must be finite.
        let cell = largest.max(Vec3::splat(least.max(1e-6)));
        (self.density, self.size) = (cell.recip(), cell * 1.0001);
        let (mut least, mut most) = (IVec3::MAX, IVec3::MIN);
        for i in these {
            let at = self.cell(bounds[*i as usize].0);
            (least, most) = (least.min(at), most.max(at));
        }
        self.lay_out(least, most, these.len());
        self.starts.clear();
        self.starts.resize((self.cells.x * self.cells.y * self.cells.z) as usize + 1, 0);
        self.entries.clear();
        self.entries.resize(these.len(), BoxEntry::new(&(Vec3::ZERO, Vec3::ZERO), 0));
        for i in these {
            let cell = self.place(self.cell(bounds[*i as usize].0));
            self.starts[cell + 1] += 1;
        }
        for i in 1..self.starts.len() {
            self.starts[i] += self.starts[i - 1];
        }
        for &number in these {
            let one = &bounds[number as usize];
            let cell = self.place(self.cell(one.0));
            let next = &mut self.starts[cell];
            let group = groups.get(number as usize).copied().unwrap_or(NO_GROUP);
            self.entries[*next as usize] = BoxEntry { group, ..BoxEntry::new(one, number) };
            *next += 1;
        }
        // Filling has advanced each start to the next one's.
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }

    /// Chooses the number of cells along each axis to cover the range, but no more in all than some per box: beyond that the longest axis is folded.
    fn lay_out(&mut self, least: IVec3, most: IVec3, count: usize) {
        let limit = (count * CELLS_PER_BOX).next_power_of_two().max(64) as i64;
        let mut cells = [0, 1, 2].map(|i| {
            let range = i64::from(most[i]) - i64::from(least[i]) + 1;
            // A query visits three cells in a row, which must be distinct.
            (range.max(4) as u64).next_power_of_two() as i64
        });
        let all =
            |cells: &[i64; 3]| cells.iter().fold(1_i64, |product, n| product.saturating_mul(*n));
        while all(&cells) > limit {
            let longest = if cells[0] >= cells[1] && cells[0] >= cells[2] {
                0
            } else if cells[1] >= cells[2] {
                1
            } else {
                2
            };
            cells[longest] /= 2;
        }
        self.cells = IVec3::new(cells[0] as i32, cells[1] as i32, cells[2] as i32);
    }

    /// The cell of a point; saturates at ± 2³¹ cells.
    #[inline(always)]
    fn cell(&self, point: Vec3) -> IVec3 {
        let at = point * self.density;
        IVec3::new(floor(at.x), floor(at.y), floor(at.z))
    }

    /// Index of a cell in memory.
    #[inline(always)]
    fn place(&self, cell: IVec3) -> usize {
        let IVec3 { x, y, z } = cell & (self.cells - 1);
        ((z * self.cells.y + y) * self.cells.x + x) as usize
    }

    /// Calls `then` with each box.
    pub(super) fn each(&self, mut then: impl FnMut(u32, (Vec3, Vec3))) {
        for entry in &self.entries {
            then(entry.number, entry.bounds.corners());
        }
    }

    /// Adds the pairs of overlapping boxes within the grid. Each is found from the box that is first in memory.
    pub(super) fn pairs_within(&self, found: &mut Vec<[u32; 2]>) {
        for (i, entry) in self.entries.iter().enumerate() {
            let mut add = |other| found.push(pair(entry.number, other));
            self.query(entry, i + 1, &mut add);
        }
    }

    /// Adds the pairs of a box of this grid and one of a grid of larger boxes.
    pub(super) fn pairs_with(&self, larger: &Self, found: &mut Vec<[u32; 2]>) {
        for entry in &self.entries {
            let mut add = |other| found.push(pair(entry.number, other));
            larger.query(entry, 0, &mut add);
        }
    }

    /// Adds the numbers of the boxes that a given box overlaps or touches.
    pub(super) fn overlapping(&self, one: &(Vec3, Vec3), found: &mut Vec<u32>) {
        self.query(&BoxEntry::new(one, 0), 0, &mut |other| found.push(other));
    }

    /// Passes on the boxes that a box overlaps or touches, from the entry `first` on.
    #[inline(always)]
    fn query(&self, entry: &BoxEntry, first: usize, out: &mut impl FnMut(u32)) {
        let (least, most) = entry.bounds.corners();
        // Enlarged slightly, for what rounding has taken off an extent.
        let from = self.cell(least - self.size - least.abs() * 3e-7);
        let to = self.cell(most);
        // Number of further cells along an axis; at most each cell of a row once.
        let span =
            |i: usize| (to[i].wrapping_sub(from[i]) as u32).min(self.cells[i] as u32 - 1) as i32;
        let [nx, ny, nz] = [span(0), span(1), span(2)];
        let mask = self.cells - 1;
        let x = from.x & mask.x;
        // Beyond the fold the row continues at its beginning.
        let over = x + nx - mask.x;
        let end = if over > 0 { mask.x } else { x + nx };
        for z in 0..=nz {
            let z = from.z.wrapping_add(z) & mask.z;
            for y in 0..=ny {
                let y = from.y.wrapping_add(y) & mask.y;
                let row = (z * self.cells.y + y) * self.cells.x;
                self.compare(entry, first, row + x, row + end, out);
                if over > 0 {
                    self.compare(entry, first, row, row + over - 1, out);
                }
            }
        }
    }

    /// Compares a box with those of consecutive cells of a row.
    #[inline(always)]
    fn compare(
        &self,
        entry: &BoxEntry,
        first: usize,
        from: i32,
        to: i32,
        out: &mut impl FnMut(u32),
    ) {
        let start = (self.starts[from as usize] as usize).max(first);
        let end = self.starts[to as usize + 1] as usize;
        if start >= end {
            return;
        }
        for other in &self.entries[start..end] {
            if are_compared(entry.group, other.group) && entry.overlaps(other) {
                out(other.number);
            }
        }
    }
}

/// Two numbers, the lesser first.
#[inline(always)]
fn pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Floor, saturating. `f32::floor` is a function call on processors without an instruction for it.
#[inline(always)]
fn floor(x: f32) -> i32 {
    let whole = x as i32;
    if whole as f32 > x { whole.saturating_sub(1) } else { whole }
}
