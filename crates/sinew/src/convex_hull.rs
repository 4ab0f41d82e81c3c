//! The convex hull of a set of points. For solids that are given by their corners alone.
//!
//! # The method
//!
//! Four points that span a volume make a tetrahedron; each further point outside of the hull so far replaces the faces visible from it by a cone from their rim
//! to itself (the incremental hull; Preparata, Hong 1977). A face is visible from a point if the point is strictly on its outer side.
//!
//! That test decides everything, and in rounded numbers it gives contradictory answers where four points are nearly in a plane, after which the hull is no
//! closed surface any more. So the points are first put on a grid of 2³⁰ steps along their extent (finer by far than `f32`), and from there on everything is
//! integer arithmetic, exactly: differences take 31 bits, cross products 63, the determinant 95 of the 128 available. A point exactly in the plane of a face
//! then counts as "not visible", which is safe: a hull whose points are moved inward by an infinitesimal amount has the same visible faces, so the visible
//! region is connected and has one rim; and no edge of the rim is collinear with the point, because each borders on a visible face.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};

/// Why points have no hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConvexHullFault {
    /// A point with a coordinate that is NaN or infinite.
    #[error("point {0} is not at a finite position")]
    NotFinite(usize),
    /// Fewer than four points.
    #[error("there are fewer than four points")]
    TooFew,
    /// More points than the limit of 65 536.
    #[error("there are more than 65536 points")]
    TooMany,
    /// All points coincide, or lie on a line or in a plane.
    #[error("the points all lie in a plane")]
    Flat,
}

/// Most points of a hull. The work is proportional to their number times that of the faces; 65 536 points on a sphere take some tens of seconds.
const MAX_POINTS: usize = 1 << 16;

/// Grid steps from the centre of the points' bounding box to its farthest side: half of the 2³⁰ steps along the extent.
const STEPS: f64 = (1_u64 << 29) as f64;

/// The triangles of the convex hull of `points`, as indices into `points`, counter-clockwise from outside: a closed surface. Points that are inside, that
/// coincide with another, or (for the most part) that lie within a face are in no triangle. The result depends on the points and their order alone.
///
/// It is exact up to 1e-9 of the extent of the points. The time grows with the number of points times that of triangles: 1000 points take some milliseconds.
///
/// # Errors
/// What [`ConvexHullFault`] lists.
pub fn convex_hull(points: &[Vec3]) -> Result<Vec<[u32; 3]>, ConvexHullFault> {
    if let Some(point) = points.iter().position(|p| !p.is_finite()) {
        return Err(ConvexHullFault::NotFinite(point));
    }
    if points.len() < 4 {
        return Err(ConvexHullFault::TooFew);
    }
    if points.len() > MAX_POINTS {
        return Err(ConvexHullFault::TooMany);
    }
    let grid = on_grid(points);
    let mut faces = first_four(&grid).ok_or(ConvexHullFault::Flat)?;
    for p in 0..grid.len() as u32 {
        let at = grid[p as usize];
        if !faces.iter().any(|face| face.is_visible_from(at)) {
            continue;
        }
        let (visible, kept): (Vec<HullTriangle>, Vec<HullTriangle>) =
            faces.iter().partition(|face| face.is_visible_from(at));
        faces = kept;
        let sides = |t: [u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        let all: BTreeSet<(u32, u32)> =
            visible.iter().flat_map(|face| sides(face.corners)).collect();
        // A directed edge whose reverse is not visible is on the rim.
        for &(a, b) in all.iter().filter(|&&(a, b)| !all.contains(&(b, a))) {
            faces.push(HullTriangle::new(&grid, [a, b, p]));
        }
    }
    Ok(faces.into_iter().map(|face| face.corners).collect())
}

/// A point in grid steps.
type GridPoint = [i64; 3];

/// A triangle and its plane.
#[derive(Clone, Copy)]
struct HullTriangle {
    corners: [u32; 3],
    at: GridPoint,
    /// Outward, twice the triangle's area long.
    normal: GridPoint,
}

impl HullTriangle {
    fn new(grid: &[GridPoint], corners: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|i| grid[i as usize]);
        Self { corners, at: a, normal: cross(minus(b, a), minus(c, a)) }
    }

    fn is_visible_from(&self, p: GridPoint) -> bool {
        dot(self.normal, minus(p, self.at)) > 0
    }
}

fn minus(a: GridPoint, b: GridPoint) -> GridPoint {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: GridPoint, b: GridPoint) -> GridPoint {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: GridPoint, b: GridPoint) -> i128 {
    (0..3).map(|k| i128::from(a[k]) * i128::from(b[k])).sum()
}

/// The points in grid steps from the centre of their bounding box.
fn on_grid(points: &[Vec3]) -> Vec<GridPoint> {
    let low = points.iter().copied().fold(Vec3::INFINITY, Vec3::min).as_dvec3();
    let high = points.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max).as_dvec3();
    let (middle, reach) = ((low + high) * 0.5, (high - low).max_element() * 0.5);
    let scale = if reach > 0.0 { STEPS / reach } else { 0.0 };
    let node = |p: &Vec3| ((p.as_dvec3() - middle) * scale).round().to_array().map(|x| x as i64);
    points.iter().map(node).collect()
}

/// A tetrahedron of four points that span a volume, facing outward; `None` if there are no such points.
fn first_four(grid: &[GridPoint]) -> Option<Vec<HullTriangle>> {
    // Each is the farthest from those before, so that most points are inside of the tetrahedron. In `f64`: only whether a distance is zero must be exact.
    let farthest = |far: &dyn Fn(GridPoint) -> f64| {
        let mut best = (0.0, None);
        for (i, &p) in (0..).zip(grid) {
            let away = far(p);
            if away > best.0 {
                best = (away, Some(i));
            }
        }
        best.1
    };
    let float = |v: GridPoint| DVec3::from_array(v.map(|x| x as f64));
    let origin = grid[0];
    let b: u32 = farthest(&|p| float(minus(p, origin)).length_squared())?;
    let along = minus(grid[b as usize], origin);
    let c: u32 = farthest(&|p| float(cross(along, minus(p, origin))).length_squared())?;
    let normal = cross(along, minus(grid[c as usize], origin));
    let d: u32 = farthest(&|p| dot(normal, minus(p, origin)).unsigned_abs() as f64)?;
    let above = dot(normal, minus(grid[d as usize], origin)) > 0;
    let [b, c] = if above { [c, b] } else { [b, c] };
    let corners = [[0, b, c], [0, c, d], [0, d, b], [b, d, c]];
    Some(corners.map(|t| HullTriangle::new(grid, t)).to_vec())
}

#[cfg(test)]
mod tests;
