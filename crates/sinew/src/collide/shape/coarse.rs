//! A coarse distance grid of a mesh for early rejection: the signed distance at the centre of each cell.
//!
//! A distance function changes by no more than the distance moved. So the distance at the centre of a cell bounds the distance at any other point from below
//! and above, and tells on which side the point is, unless the surface is nearer to the centre than the point.

use glam::Vec3;

/// Signed distances from a surface on a grid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DistanceGrid {
    low: Vec3,
    /// Size of a cell, metres.
    size: Vec3,
    cells: [usize; 3],
    /// At the centre of each cell, metres; negative inside. All are finite.
    distances: Vec<f32>,
}

/// Maximum number of cells along the longest side: 4096 cells take 16 KiB, half of a core's L1 cache, and a few ms to compute.
const MAX_CELLS: f32 = 16.0;

impl DistanceGrid {
    /// Samples a surface within a box. `distance(point, at_most)` is called with an upper bound of the distance.
    pub(super) fn new(
        (low, high): (Vec3, Vec3),
        triangles: usize,
        mut distance: impl FnMut(Vec3, f32) -> f32,
    ) -> Self {
        let extent = high - low;
        // About as many cells as triangles: a finer grid tells nothing new.
        let along = libm::cbrtf(triangles as f32).clamp(4.0, MAX_CELLS);
        let edge = extent.max_element() / along;
        let cells =
            extent.to_array().map(|side| (side / edge).ceil().clamp(1.0, MAX_CELLS) as usize);
        let size = extent / Vec3::from_array(cells.map(|n| n as f32));
        let mut grid = Self { low, size, cells, distances: Vec::new() };
        let (mut last, mut at_most) = (low, f32::INFINITY);
        for i in 0..cells[0] * cells[1] * cells[2] {
            let middle = grid.middle(i);
            // A little more, for rounding.
            let found = distance(middle, (at_most + (middle - last).length()) * 1.001);
            grid.distances.push(found);
            (last, at_most) = (middle, found.abs());
        }
        grid
    }

    /// The distance of the surface from the centre of the cell of a point, metres, and the distance of that centre from the point.
    #[inline]
    pub(super) fn sample(&self, p: Vec3) -> (f32, f32) {
        let [nx, ny, nz] = self.cells;
        let along = |axis: usize, count: usize| {
            let share = (p[axis] - self.low[axis]) / self.size[axis];
            // A flat mesh has cells of no height, and 0/0 becomes 0.
            (share.max(0.0) as usize).min(count - 1)
        };
        let i = (along(2, nz) * ny + along(1, ny)) * nx + along(0, nx);
        (self.distances[i], (p - self.middle(i)).length())
    }

    fn middle(&self, i: usize) -> Vec3 {
        let [nx, ny, _] = self.cells;
        let place = Vec3::new((i % nx) as f32, (i / nx % ny) as f32, (i / (nx * ny)) as f32);
        self.low + (place + Vec3::splat(0.5)) * self.size
    }
}
