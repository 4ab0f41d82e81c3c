//! Whether a mesh is anywhere near, at one look: how far it is from the middle of each cell of a coarse grid.
//!
//! A distance changes by no more than the way one goes. So from that of a cell's middle follows how near the surface can be to any point at least and
//! at most, and, if it is not nearer than the point is to the middle, on which side of it the point is.

use glam::Vec3;

/// Distances from a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Coarse {
    low: Vec3,
    /// Of a cell, metres.
    size: Vec3,
    cells: [usize; 3],
    /// From the middle of each cell, metres; negative inside. A finite number each.
    distances: Vec<f32>,
}

/// Cells along the longest side at most: 4096 of them take 16 KiB, half of a core's first cache, and some ms to make.
const MOST: f32 = 16.0;

impl Coarse {
    /// Measures a surface within a box. `distance(point, at_most)` is asked with what it cannot be above.
    pub(super) fn new(
        (low, high): (Vec3, Vec3),
        triangles: usize,
        mut distance: impl FnMut(Vec3, f32) -> f32,
    ) -> Self {
        let extent = high - low;
        // About as many cells as triangles: a grid finer than these tells nothing new.
        let along = libm::cbrtf(triangles as f32).clamp(4.0, MOST);
        let edge = extent.max_element() / along;
        let cells = extent.to_array().map(|side| (side / edge).ceil().clamp(1.0, MOST) as usize);
        let size = extent / Vec3::from_array(cells.map(|n| n as f32));
        let mut grid = Self { low, size, cells, distances: Vec::new() };
        let (mut last, mut at_most) = (low, f32::INFINITY);
        for i in 0..cells[0] * cells[1] * cells[2] {
            let middle = grid.middle(i);
            // With some room for rounding.
            let found = distance(middle, (at_most + (middle - last).length()) * 1.001);
            grid.distances.push(found);
            (last, at_most) = (middle, found.abs());
        }
        grid
    }

    /// The distance of the surface from some place near a point, metres, and how far that place is from the point.
    #[inline]
    pub(super) fn near(&self, p: Vec3) -> (f32, f32) {
        let [nx, ny, nz] = self.cells;
        let along = |axis: usize, count: usize| {
            let share = (p[axis] - self.low[axis]) / self.size[axis];
            // A flat mesh has cells without a height, and 0/0 becomes 0.
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
