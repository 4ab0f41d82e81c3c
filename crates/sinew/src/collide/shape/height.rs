//! Heightfield: heights over a grid, and the solid ground beneath them.
//!
//! The cells under a segment are found by index, without a search. It is solid below the surface, so the height of a point tells whether it is inside.

use glam::Vec3;

use super::convex::Convex as _;
use super::fault::{is_coordinate, is_length, is_size};
use super::flat::Cuboid;
use super::local_face::{Reachable, reachable};
use super::ridges::{Face, Ridge, Ridges};
use super::surface::{SpherePath, SphereSlide, Surface, first_crossing, is_near, skin, slide};
use super::triangle::{ClosestPoint, Feature, Triangle};
use super::{Nearest, ShapeFault, ShapeTouch};

/// Heights over a grid that is centred at the origin.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Heights {
    columns: usize,
    rows: usize,
    /// Row by row, metres.
    heights: Vec<f32>,
    /// Unit normals of the two triangles of each cell, row by row.
    normals: Vec<[Vec3; 2]>,
    /// Size of the rectangle, metres; y is 1, since its scale is in the heights.
    size: Vec3,
    bounds: (Vec3, Vec3),
    skin: f32,
}

/// Depth of the ground below the lowest point, as a share of the longer side: enough that a solver that has not converged pushes nothing through.
const GROUND_DEPTH: f32 = 0.05;

/// Maximum number of pushes for a sphere that began below the surface; the last one is straight up.
const ROUNDS: usize = 4;

impl Heights {
    /// Validates the numbers.
    pub(super) fn new(
        columns: usize,
        rows: usize,
        heights: &[f32],
        size: Vec3,
    ) -> Result<Self, ShapeFault> {
        if columns < 2 || rows < 2 {
            return Err(ShapeFault::Grid);
        }
        // Triangles are indexed by `u32`, two a cell.
        if columns.checked_mul(rows) != Some(heights.len()) || heights.len() > (1 << 30) {
            return Err(ShapeFault::Heights);
        }
        if !is_size(size) {
            return Err(ShapeFault::Size);
        }
        let cell = Vec3::new(size.x / (columns - 1) as f32, 1.0, size.z / (rows - 1) as f32);
        if !(is_length(cell.x) && is_length(cell.z)) {
            return Err(ShapeFault::Size);
        }
        let heights: Vec<f32> = heights.iter().map(|height| height * size.y).collect();
        if let Some(height) = heights.iter().position(|height| !is_coordinate(*height)) {
            return Err(ShapeFault::Altitude(height));
        }
        let least = heights.iter().copied().fold(f32::INFINITY, f32::min);
        let most = heights.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let (half, floor) = (size * 0.5, least - GROUND_DEPTH * size.x.max(size.z));
        let bounds = (Vec3::new(-half.x, floor, -half.z), Vec3::new(half.x, most, half.z));
        let size = size.with_y(1.0);
        let (normals, skin) = (Vec::new(), skin(bounds));
        let mut field = Self { columns, rows, heights, normals, size, bounds, skin };
        let cells = (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| (column, row)));
        let normals = cells.map(|(column, row)| {
            field.corners(column, row).map(|corners| Triangle::new(corners).normal)
        });
        field.normals = normals.collect();
        Ok(field)
    }

    /// The same heightfield in another size.
    pub(super) fn scaled(&self, factor: Vec3) -> Result<Self, ShapeFault> {
        Self::new(self.columns, self.rows, &self.heights, self.size * factor)
    }

    /// All of its numbers, three at a time: columns and size, then the heights.
    pub(super) fn numbers(&self) -> impl Iterator<Item = Vec3> {
        // As many rows as there are heights for.
        let grid = Vec3::new(self.columns as f32, self.size.x, self.size.z);
        core::iter::once(grid).chain(self.heights.iter().map(|&height| Vec3::new(height, 0.0, 0.0)))
    }

    /// Number of columns and of rows.
    pub(super) fn grid(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// Height of a grid point, metres.
    pub(super) fn height(&self, column: usize, row: usize) -> f32 {
        self.heights[row * self.columns + column]
    }

    /// Size of the rectangle along x and z, metres.
    pub(super) fn size(&self) -> Vec3 {
        self.size
    }

    /// Its [ridges](super::ridges).
    pub(super) fn ridges(&self) -> Ridges {
        let (columns, rows) = (self.columns - 1, self.rows - 1);
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        let found = cells.flat_map(|(column, row)| {
            // As in `corners`.
            let [low, high] = self.cell(column, row);
            let ([a, b, c], d) = (low.corners, high.corners[1]);
            let face = |ends: [Vec3; 2], triangle: &Triangle, opposite: Vec3| {
                Face::new(ends, opposite, triangle.normal)
            };
            // Between the triangle at a side of this cell and that of the cell beyond, unless the field ends there.
            let beside = |ends: [Vec3; 2], own: Face, beyond: Option<(Triangle, usize)>| {
                let other =
                    beyond.map(|(other, opposite)| face(ends, &other, other.corners[opposite]));
                match other {
                    Some(other) => Ridge::between(ends, [own, other], true),
                    None => Ridge::end(ends, [own; 2], true),
                }
            };
            let before = |column: usize, row: usize| self.cell(column, row)[1];
            let left = column.checked_sub(1).map(|column| (before(column, row), 0));
            let back = row.checked_sub(1).map(|row| (before(column, row), 2));
            let middle = [face([b, c], &low, a), face([b, c], &high, d)];
            [
                Ridge::between([b, c], middle, true),
                beside([a, b], face([a, b], &low, c), left),
                beside([a, c], face([a, c], &low, b), back),
                (column + 1 == columns)
                    .then(|| beside([c, d], face([c, d], &high, b), None))
                    .flatten(),
                (row + 1 == rows).then(|| beside([b, d], face([b, d], &high, c), None)).flatten(),
            ]
        });
        Ridges::new(found.flatten())
    }

    /// See [`Shape::touch`](super::Shape::touch).
    pub(super) fn touch(&self, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        let reach = radius.max(self.skin);
        if !(is_near(self.bounds, from, to, reach) && radius.is_finite()) {
            return None;
        }
        if let Some(touch) = self.touch_side(from, to, reach) {
            return Some(touch);
        }
        match slide(self, from, to, reach) {
            SphereSlide::Clear => None,
            SphereSlide::Moved(touch) => self.keep_above(from, to, reach, touch?),
            SphereSlide::Inside => self.lift(to, reach),
        }
    }

    /// See [`Shape::reachable`](super::Shape::reachable).
    pub(super) fn reachable(&self, at: Vec3, way: f32, radius: f32) -> Reachable {
        reachable(self, at, (way, radius.max(self.skin), self.skin))
    }

    /// Where a slope has pushed the sphere sideways into the ground, through a side that has no triangles, lifts it; if it then is beyond another slope, moves
    /// it back to its start.
    fn keep_above(
        &self,
        from: Vec3,
        to: Vec3,
        reach: f32,
        touch: ShapeTouch,
    ) -> Option<ShapeTouch> {
        let shift = touch.normal * touch.depth;
        let sunk = |place: Vec3| {
            self.is_inside(place, None) || self.touch_side(from, place, reach).is_some()
        };
        if !sunk(to + shift) {
            return Some(touch);
        }
        let up = self.lift(to + shift, reach).map_or(Vec3::ZERO, |up| up.normal * up.depth);
        let place = to + shift + up;
        let free = !sunk(place) && first_crossing(self, from, place).is_none();
        ShapeTouch::between(Vec3::ZERO, if free { shift + up } else { from - to })
    }

    /// See [`Shape::nearest`](super::Shape::nearest); sides and bottom do not count.
    pub(super) fn nearest(&self, p: Vec3) -> Nearest {
        let (low, high) = self.bounds;
        let over = p.max(low).min(high).with_y(p.y);
        // The surface point straight below is an upper bound of the distance.
        let level =
            self.triangle_at(over).map_or(high.y, |(triangle, _)| height_at(&triangle, over));
        let reach = ((p - over.with_y(level)).length() + self.skin) * 1.001;
        let mut best: Option<(u32, ClosestPoint, Triangle)> = None;
        self.visit(&SpherePath::new(p, p, reach), &mut |i, triangle| {
            let close = triangle.closest(p);
            let nearer = best.as_ref().is_none_or(|(other, best, _)| {
                close.square < best.square || (close.square == best.square && i < *other)
            });
            if nearer {
                best = Some((i, close, *triangle));
            }
        });
        // `None` only if the point is not finite.
        let Some((_, close, triangle)) = best else {
            return Nearest { point: p, normal: Vec3::Y, distance: f32::INFINITY };
        };
        let inside = self.is_inside(p, None);
        let (distance, sign) = (close.square.sqrt(), if inside { -1.0 } else { 1.0 });
        let normal = if close.feature == Feature::Face || distance <= self.skin {
            triangle.normal
        } else {
            (p - close.point) / (sign * distance)
        };
        Nearest { point: close.point, normal, distance: sign * distance }
    }

    /// Calls `call` with the triangles within a box whose own bounds (low, high) pass `keep`.
    pub(super) fn near(
        &self,
        (low, high): (Vec3, Vec3),
        keep: &dyn Fn(Vec3, Vec3) -> bool,
        call: &mut dyn FnMut([Vec3; 3]),
    ) {
        for column in self.cells_along([low.x, high.x], 0) {
            for row in self.cells_along([low.z, high.z], 2) {
                for triangle in self.cell(column, row) {
                    let (low, high) = triangle.bounds();
                    if keep(low, high) {
                        call(triangle.corners);
                    }
                }
            }
        }
    }

    /// Moves a sphere that came through a side or the bottom back out there.
    fn touch_side(&self, from: Vec3, to: Vec3, reach: f32) -> Option<ShapeTouch> {
        let (low, high) = self.bounds;
        let inside = from.cmpgt(low).all() && from.with_y(low.y).cmplt(high).all();
        if inside {
            return None;
        }
        let middle = (low + high) * 0.5;
        let block = Cuboid { half_size: ((high - low) * 0.5).max(Vec3::splat(self.skin)) };
        let entry = block.enter(from - middle, to - from, 1.0)?;
        let place = from + (to - from) * entry.share;
        let below = self
            .triangle_at(place)
            .is_some_and(|(triangle, _)| place.y < height_at(&triangle, place));
        let side = entry.normal.y <= 0.0 && below;
        let depth = reach + entry.offset - entry.normal.dot(to - middle);
        if side { ShapeTouch::new(entry.normal, depth) } else { None }
    }

    /// Lifts a sphere from below the surface, by the planes of the triangles above it.
    fn lift(&self, to: Vec3, reach: f32) -> Option<ShapeTouch> {
        let (mut shift, mut single) = (Vec3::ZERO, None);
        for round in 0..ROUNDS {
            let place = to + shift;
            let Some((triangle, _)) = self.triangle_at(place) else { break };
            let normal = triangle.normal;
            let depth = reach - normal.dot(place - triangle.corners[0]);
            if depth <= reach * 1e-5 {
                break;
            }
            single = if round == 0 { ShapeTouch::new(normal, depth) } else { None };
            // A steep triangle would lift it too far.
            let up = Vec3::Y * (depth / normal.y.max(0.1));
            shift += if round == ROUNDS - 1 { up } else { normal * depth };
        }
        single.or_else(|| ShapeTouch::between(Vec3::ZERO, shift))
    }

    /// The triangle above or below a point, and its index; `None` beyond the rectangle.
    fn triangle_at(&self, p: Vec3) -> Option<(Triangle, u32)> {
        let [u, v] = [self.along(p.x, 0), self.along(p.z, 2)];
        // The last point of a row must not be lost to rounding.
        let over = |x: f32, size: f32| x.abs() <= 0.5 * size * (1.0 + 1e-6);
        if !(over(p.x, self.size.x) && over(p.z, self.size.z)) {
            return None;
        }
        let (column, row) = ((u as usize).min(self.columns - 2), (v as usize).min(self.rows - 2));
        let half = usize::from(u - column as f32 + v - row as f32 > 1.0);
        let number = 2 * (row * (self.columns - 1) + column) + half;
        Some((self.cell(column, row)[half], number as u32))
    }

    /// A coordinate in units of cells.
    fn along(&self, x: f32, axis: usize) -> f32 {
        (x / self.size[axis] + 0.5) * self.cell_count(axis) as f32
    }

    fn cell_count(&self, axis: usize) -> usize {
        if axis == 0 { self.columns - 1 } else { self.rows - 1 }
    }

    /// The cells from one coordinate to another along an axis, and one more on either side, for rounding.
    fn cells_along(&self, [low, high]: [f32; 2], axis: usize) -> core::ops::Range<usize> {
        let count = self.cell_count(axis);
        let first = (self.along(low, axis) - 0.01).max(0.0) as usize;
        let end = (self.along(high, axis) + 1.01).max(0.0) as usize;
        first.min(count)..end.min(count)
    }

    /// The two triangles of a cell: first the one at its lowest x and z.
    #[inline]
    fn cell(&self, column: usize, row: usize) -> [Triangle; 2] {
        let [low, high] = self.corners(column, row);
        let [of_low, of_high] = self.normals[row * (self.columns - 1) + column];
        [Triangle { corners: low, normal: of_low }, Triangle { corners: high, normal: of_high }]
    }

    /// The corners of those.
    #[inline]
    fn corners(&self, column: usize, row: usize) -> [[Vec3; 3]; 2] {
        let at = |i: usize, j: usize| self.point(column + i, row + j);
        let [a, b, c, d] = [at(0, 0), at(0, 1), at(1, 0), at(1, 1)];
        [[a, b, c], [b, d, c]]
    }

    /// A grid point, computed in the same way for all cells around it.
    fn point(&self, column: usize, row: usize) -> Vec3 {
        let across =
            |i: usize, count: usize, size: f32| (i as f32 / (count - 1) as f32 - 0.5) * size;
        let x = across(column, self.columns, self.size.x);
        Vec3::new(x, self.height(column, row), across(row, self.rows, self.size.z))
    }
}

impl Surface for Heights {
    fn visit(&self, path: &SpherePath, call: &mut impl FnMut(u32, &Triangle)) {
        let margin = path.margin;
        let cells = |from: f32, to: f32, axis: usize| {
            self.cells_along([from.min(to) - margin, from.max(to) + margin], axis)
        };
        let (from, to) = (path.from, path.to);
        for column in cells(from.x, to.x, 0) {
            // The part of the segment that is within reach of this column.
            let (low, high) =
                (self.point(column, 0).x - margin, self.point(column + 1, 0).x + margin);
            let motion = to - from;
            let share = |x: f32| ((x - from.x) / motion.x).clamp(0.0, 1.0);
            let slow = motion.x.abs() <= margin;
            let (s, t) = if slow { (0.0, 1.0) } else { (share(low), share(high)) };
            let (z, w) = (from.z + motion.z * s, from.z + motion.z * t);
            for row in cells(z, w, 2) {
                let corners = [(0, 0), (0, 1), (1, 0), (1, 1)];
                let heights = corners.map(|(i, j)| self.height(column + i, row + j));
                let least = heights.into_iter().fold(f32::INFINITY, f32::min);
                let most = heights.into_iter().fold(f32::NEG_INFINITY, f32::max);
                let low = self.point(column, row).with_y(least);
                let high = self.point(column + 1, row + 1).with_y(most);
                if path.may_overlap(low, high) {
                    let number = 2 * (row * (self.columns - 1) + column) as u32;
                    let [first, second] = self.cell(column, row);
                    call(number, &first);
                    call(number + 1, &second);
                }
            }
        }
    }

    /// Includes the ground.
    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    fn front_only(&self) -> bool {
        true
    }

    fn is_away_from_rim(&self, at: Vec3, distance: f32) -> bool {
        let over = |x: f32, size: f32| x.abs() + distance < 0.5 * size;
        over(at.x, self.size.x) && over(at.z, self.size.z) && at.y > self.bounds.0.y + distance
    }

    fn is_inside(&self, p: Vec3, _near: Option<&(u32, ClosestPoint, Triangle)>) -> bool {
        p.y > self.bounds.0.y
            && self.triangle_at(p).is_some_and(|(triangle, _)| p.y < height_at(&triangle, p))
    }
}

/// Height of the plane of a triangle at a point, metres. The normal is never horizontal: the triangle has a width along x and z.
fn height_at(triangle: &Triangle, p: Vec3) -> f32 {
    let (n, a) = (triangle.normal, triangle.corners[0]);
    let down = n.x * (p.x - a.x) + n.z * (p.z - a.z);
    a.y - down / n.y.max(f32::MIN_POSITIVE)
}
