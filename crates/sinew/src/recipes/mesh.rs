//! Converts a render mesh to the triangles of a body. A render mesh has several vertices at one point of its surface wherever texture coordinates or normals
//! are discontinuous; without welding, the body would tear at those seams.

mod edges;
mod grid;
mod order;

use core::ops::Range;

use glam::{DVec3, Vec3};

pub(super) use self::edges::{Edges, sort};
use super::limits::MAX_PARTICLES;
use super::nearest::{NearestSearch, bounds};

/// A mesh with its seams closed: the result of [`weld`], in an order that suits the solver.
///
/// Particles are numbered piece by piece, such that connected particles have close numbers. A piece that is a grid (cells cut in two along either diagonal) is
/// numbered row by row, and the result is bitwise the same however the mesh was shuffled. Any other piece keeps the order of its vertices if that order is
/// good.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weld {
    /// Position of each particle, metres: that of the first of its vertices.
    pub positions: Vec<Vec3>,
    /// The triangles of the mesh, as particle indices, with their original winding, each rotated to start at its lowest corner, sorted; without degenerate and
    /// repeated ones.
    pub triangles: Vec<[u32; 3]>,
    /// The particle that each vertex of the mesh follows. A vertex that is in no valid triangle follows the nearest particle.
    pub vertices: Vec<u32>,
    /// Every edge of a triangle once, as `[lower, higher]`, sorted.
    pub edges: Vec<[u32; 2]>,
    /// Every edge between exactly two triangles, sorted by edge. Where three or more triangles meet, opposite corners are not defined.
    pub bends: Vec<Fold>,
    /// The connected pieces, in the order of their first vertices in the mesh.
    pub pieces: Vec<Piece>,
}

/// A connected piece of a mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Piece {
    /// Its particles.
    pub particles: Range<u32>,
    /// For a grid, the number of particles in a row, which is along the longer side. `None` for any other shape.
    pub columns: Option<u32>,
}

/// Two triangles that share an edge, and may fold about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fold {
    /// The edge that they share, `[lower, higher]`.
    pub edge: [u32; 2],
    /// For each triangle the corner that is not on the edge, `[lower, higher]`.
    pub opposite: [u32; 2],
}

/// Why a mesh is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshFault {
    /// There are no vertices, or no triangles.
    #[error("its mesh has no vertices or no triangles")]
    Empty,
    /// The number of indices is not a multiple of three.
    #[error("its mesh is not made of triangles: it has {0} indices")]
    NotTriangles(usize),
    /// There are more vertices than the maximum number of particles.
    #[error("its mesh has more than 16777216 vertices")]
    TooMany,
    /// A vertex has a coordinate that is NaN or infinite.
    #[error("vertex {0} of its mesh is not at a finite position")]
    NotFinite(usize),
    /// An index is beyond the last vertex.
    #[error("its mesh names vertex {index}, but has {vertices}")]
    IndexOutOfRange {
        /// The index.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// The tolerance is NaN, infinite or negative.
    #[error("the tolerance for welding its mesh is not a finite length")]
    Tolerance,
    /// No triangle has an area, or none is larger than the tolerance.
    #[error("all triangles of its mesh are degenerate")]
    AllDegenerate,
}

/// Closes the seams of a triangle list: vertices within `tolerance` metres become one particle.
///
/// - Vertices are processed in order; each joins the nearest earlier vertex that has a particle of its own and is within the tolerance. So no particle is
///   within the tolerance of another, and a fine mesh does not collapse along a chain of near vertices. As long as the vertices of a seam are closer together
///   than the tolerance and all others farther apart than twice that, the order of the vertices affects only the numbering. A tolerance of 0 merges only equal
///   positions.
/// - Triangles that lose a corner by this, or that are thinner than a millionth of their longest edge (what rounding makes of collinear points), are dropped;
///   so are repetitions of a triangle in either winding, which two-sided meshes have.
/// - Vertices that no remaining triangle uses make no particles.
///
/// O(n log n) in the number of vertices and triangles. Fails with a [`MeshFault`].
pub fn weld(positions: &[Vec3], indices: &[u32], tolerance: f32) -> Result<Weld, MeshFault> {
    let Welded { positions, triangles, vertices, edges, pieces } =
        weld_with_edges(positions, indices, tolerance)?;
    let (bends, edges) = (edges.bends().collect(), edges.list.iter().map(|e| e.ends).collect());
    Ok(Weld { positions, triangles, vertices, edges, bends, pieces })
}

/// A [`Weld`] with its full edge data, which is cheaper to reuse for large meshes.
pub(super) struct Welded {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) vertices: Vec<u32>,
    pub(super) edges: Edges,
    pub(super) pieces: Vec<Piece>,
}

/// Implementation of [`weld`].
pub(super) fn weld_with_edges(
    positions: &[Vec3],
    indices: &[u32],
    tolerance: f32,
) -> Result<Welded, MeshFault> {
    check(positions, indices, tolerance)?;
    let mut used = vec![false; positions.len()];
    for &index in indices {
        used[index as usize] = true;
    }
    let representatives = representatives(positions, &used, tolerance);
    let joined = indices.chunks_exact(3).map(|t| [0, 1, 2].map(|k| representatives[t[k] as usize]));
    let mut triangles = Vec::with_capacity(joined.len());
    triangles.extend(joined.filter(|&t| has_area(positions, t)));
    if triangles.is_empty() {
        return Err(MeshFault::AllDegenerate);
    }
    let mut particles = number(&mut triangles, positions.len());
    let first = |v: usize| particles[v] != NONE && representatives[v] == v as u32;
    let found: Vec<Vec3> =
        (0..positions.len()).filter(|&v| first(v)).map(|v| positions[v]).collect();
    let edges = Edges::of(&mut triangles, found.len());
    let (order, pieces) = order::ordered(&found, &edges);
    let places = renumber(&order, &mut particles, &mut triangles);
    let edges = edges.renumbered(&places);
    let kept: Vec<Vec3> = order.iter().map(|&old| found[old as usize]).collect();
    Ok(Welded {
        vertices: followed(positions, &kept, &representatives, &particles),
        positions: kept,
        triangles,
        edges,
        pieces,
    })
}

/// Marks a missing vertex or particle.
const NONE: u32 = u32::MAX;

fn check(positions: &[Vec3], indices: &[u32], tolerance: f32) -> Result<(), MeshFault> {
    if positions.is_empty() || indices.is_empty() {
        return Err(MeshFault::Empty);
    }
    if !indices.len().is_multiple_of(3) {
        return Err(MeshFault::NotTriangles(indices.len()));
    }
    if positions.len() as u64 > MAX_PARTICLES {
        return Err(MeshFault::TooMany);
    }
    if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
        return Err(MeshFault::NotFinite(vertex));
    }
    let vertices = positions.len();
    if let Some(&index) = indices.iter().find(|&&i| i as usize >= vertices) {
        return Err(MeshFault::IndexOutOfRange { index, vertices });
    }
    if !(tolerance.is_finite() && tolerance >= 0.0) {
        return Err(MeshFault::Tolerance);
    }
    Ok(())
}

/// For each used vertex its representative, itself or an earlier vertex; `NONE` for unused ones.
///
/// Uses a hash grid with several times as many chains as vertices; a chain shared by two cells costs time but does not affect the result. A cell is 8
/// tolerances wide: a second cell rarely has to be searched, and a cell does not hold many points that are farther apart than the tolerance. The size is
/// bounded below so that cell numbers are exact in `f64`.
fn representatives(positions: &[Vec3], used: &[bool], tolerance: f32) -> Vec<u32> {
    let [low, high] = bounds(positions.iter().copied()).map(Vec3::as_dvec3);
    let reach = f64::from(tolerance);
    let size = (8.0 * reach).max((high - low).max_element() / (1_u64 << 50) as f64);
    let scale = if size > 0.0 { 1.0 / size } else { 0.0 };
    // Truncation rounds down, because all values are positive. Offset by half a cell, so that a flat mesh does not lie on a cell boundary.
    let cell = |p: DVec3| ((p - low) * scale + 1.5).to_array().map(|x| x as i64);
    let mut heads = vec![NONE; 4 * positions.len().next_power_of_two()];
    let mut next = vec![NONE; positions.len()];
    let mut representatives = vec![NONE; positions.len()];
    for v in (0..positions.len()).filter(|&v| used[v]) {
        let at = positions[v].as_dvec3();
        let mut best = (reach * reach, NONE);
        let mut search = |chain: usize| {
            let mut representative = heads[chain];
            while representative != NONE {
                let away = at.distance_squared(positions[representative as usize].as_dvec3());
                best = nearer(best, (away, representative));
                representative = next[representative as usize];
            }
        };
        let own = chain(cell(at), heads.len());
        let [low, high] = [cell(at - reach), cell(at + reach)];
        if low == high {
            search(own);
        } else {
            block(low, high).for_each(|cell| search(chain(cell, heads.len())));
        }
        if best.1 == NONE {
            best.1 = v as u32;
            (next[v], heads[own]) = (heads[own], best.1);
        }
        representatives[v] = best.1;
    }
    representatives
}

/// The chain of a cell; the number of chains is a power of two. Each coordinate is mixed by the finaliser of `SplitMix64`.
fn chain(cell: [i64; 3], chains: usize) -> usize {
    let mix = |hash: u64, x: i64| {
        let z = (hash ^ x as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb) ^ z >> 31
    };
    cell.into_iter().fold(0, mix) as usize & (chains - 1)
}

/// The nearer of two candidates; the earlier one if they are equally near.
fn nearer(a: (f64, u32), b: (f64, u32)) -> (f64, u32) {
    if b < a { b } else { a }
}

/// All cells between two corners.
fn block(from: [i64; 3], to: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let row = move |x, y| (from[2]..=to[2]).map(move |z| [x, y, z]);
    let plane = move |x| (from[1]..=to[1]).flat_map(move |y| row(x, y));
    (from[0]..=to[0]).flat_map(plane)
}

/// Whether the corners of a triangle are distinct and not collinear.
fn has_area(positions: &[Vec3], t: [u32; 3]) -> bool {
    let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
    let longest =
        (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    let twice_area_squared = (b - a).cross(c - a).length_squared();
    t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && twice_area_squared > 1e-12 * longest * longest
}

/// Renumbers the corners of triangles without gaps, in the order of the vertices; returns each corner's new number.
fn number(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut numbers = vec![NONE; vertices];
    for &corner in triangles.iter().flatten() {
        numbers[corner as usize] = 0;
    }
    for (particle, number) in (0..).zip(numbers.iter_mut().filter(|number| **number == 0)) {
        *number = particle;
    }
    for corner in triangles.iter_mut().flatten() {
        *corner = numbers[*corner as usize];
    }
    numbers
}

/// Renumbers particles to their places in `order`, and sorts the triangles by the new numbers. Returns the places.
fn renumber(order: &[u32], particles: &mut [u32], triangles: &mut Vec<[u32; 3]>) -> Vec<u32> {
    let mut places = vec![NONE; order.len()];
    for (place, &old) in (0..).zip(order) {
        places[old as usize] = place;
    }
    let place = |old: u32| places.get(old as usize).copied().unwrap_or(NONE);
    particles.iter_mut().for_each(|particle| *particle = place(*particle));
    for triangle in triangles.iter_mut() {
        let [a, b, c] = triangle.map(place);
        let lowest = a.min(b).min(c);
        *triangle = if a == lowest {
            [a, b, c]
        } else if b == lowest {
            [b, c, a]
        } else {
            [c, a, b]
        };
    }
    sort(triangles, order.len(), |t| t[0], |t| edges::join(t[1], t[2]));
    places
}

/// The particle of each vertex: that of its representative, or else the nearest.
fn followed(
    positions: &[Vec3],
    kept: &[Vec3],
    representatives: &[u32],
    particles: &[u32],
) -> Vec<u32> {
    let mut nearest = None;
    let particle = |(&representative, &position): (&u32, &Vec3)| match particles
        .get(representative as usize)
    {
        Some(&particle) if particle != NONE => particle,
        _ => nearest.get_or_insert_with(|| NearestSearch::new(kept)).find(position),
    };
    representatives.iter().zip(positions).map(particle).collect()
}

#[cfg(test)]
mod tests;
