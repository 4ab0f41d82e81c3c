//! Triangle mesh: a sheet, or the surface of a solid that need not be convex.
//!
//! # Inside and outside
//!
//! The side of a point is determined at a face by its normal, at an edge by the sum of the normals of the two faces, at a vertex by the sum of the normals of
//! all faces weighted by their angles there: these *pseudo-normals* are correct for every closed surface (Bærentzen and Aanæs 2005).

use glam::Vec3;

use super::coarse::DistanceGrid;
use super::convex::BEND_COSINE;
use super::extent::around;
use super::fault::{first_out_of_range, is_length};
use super::local_face::{Reachable, reachable};
use super::ridges::Ridges;
use super::surface::{SpherePath, SphereSlide, Surface, is_near, skin, slide};
use super::tree::AabbTree;
use super::triangle::{ClosestPoint, Feature, Triangle};
use super::{Nearest, ShapeFault, ShapeTouch};
use crate::coincident::first_coincident;

/// Triangles with their acceleration structures.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mesh {
    /// Distinct vertex positions, metres.
    pub(super) vertices: Vec<Vec3>,
    /// Triangles that have an area, in the order of the tree.
    pub(super) triangles: Vec<[u32; 3]>,
    pieces: Vec<Triangle>,
    tree: AabbTree,
    distances: DistanceGrid,
    bounds: (Vec3, Vec3),
    skin: f32,
    /// Pseudo-normals of each triangle; empty for a sheet.
    pseudo_normals: Vec<PseudoNormals>,
}

/// Pseudo-normals of the edges and vertices of a triangle; not normalised.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct PseudoNormals {
    edges: [Vec3; 3],
    corners: [Vec3; 3],
}

/// Maximum number of triangles and of vertices: indices must leave room for those of tree nodes.
const MAX_INDEXED: usize = 1_000_000_000;

impl Mesh {
    /// Validates the numbers, drops triangles without an area, and determines whether the rest is closed.
    pub(super) fn new(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, ShapeFault> {
        if triangles.len() > MAX_INDEXED || vertices.len() > MAX_INDEXED {
            return Err(ShapeFault::TooMany);
        }
        if let Some(point) = first_out_of_range(vertices) {
            return Err(ShapeFault::Point(point));
        }
        let is_out_of_range = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= vertices.len());
        if let Some(triangle) = triangles.iter().position(is_out_of_range) {
            return Err(ShapeFault::Corner(triangle));
        }
        let (vertices, triangles) = welded(vertices, triangles);
        let piece = |t: &[u32; 3]| Triangle::new(t.map(|i| vertices[i as usize]));
        let (triangles, pieces): (Vec<_>, Vec<_>) = triangles
            .into_iter()
            .map(|t| (t, piece(&t)))
            .filter(|(_, piece)| piece.normal != Vec3::ZERO)
            .unzip();
        let used: Vec<Vec3> = pieces.iter().flat_map(|piece| piece.corners).collect();
        let bounds = around(&used);
        if pieces.is_empty() {
            return Err(ShapeFault::NoArea);
        }
        if !is_length((bounds.1 - bounds.0).max_element()) {
            return Err(ShapeFault::Size);
        }
        let piece_bounds: Vec<_> = pieces.iter().map(Triangle::bounds).collect();
        let (tree, order) = AabbTree::new(&piece_bounds);
        let triangles: Vec<[u32; 3]> = order.iter().map(|&i| triangles[i as usize]).collect();
        let pieces: Vec<Triangle> = order.iter().map(|&i| pieces[i as usize]).collect();
        let pseudo_normals = pseudo_normals(vertices.len(), &triangles, &pieces);
        // The distances can be computed only once the mesh exists.
        let unmeasured = DistanceGrid::new(bounds, 1, |_, _| 0.0);
        let count = pieces.len();
        let skin = skin(bounds);
        let mut mesh = Self {
            vertices,
            triangles,
            pieces,
            tree,
            distances: unmeasured,
            bounds,
            skin,
            pseudo_normals,
        };
        mesh.distances = DistanceGrid::new(bounds, count, |p, most| mesh.signed(p, most).distance);
        Ok(mesh)
    }

    /// Whether it is closed.
    pub(super) fn is_solid(&self) -> bool {
        !self.pseudo_normals.is_empty()
    }

    /// Its [ridges](super::ridges).
    pub(super) fn ridges(&self) -> Ridges {
        let normals: Vec<Vec3> = self.pieces.iter().map(|piece| piece.normal).collect();
        Ridges::of(&self.vertices, &self.triangles, &normals, self.is_solid())
    }

    /// The corners of all triangles.
    pub(super) fn corners(&self) -> impl Iterator<Item = Vec3> {
        self.pieces.iter().flat_map(|piece| piece.corners)
    }

    /// See [`Shape::touch`](super::Shape::touch).
    pub(super) fn touch(&self, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        let reach = radius.max(self.skin);
        if !(is_near(self.bounds, from, to, reach) && radius.is_finite()) {
            return None;
        }
        let (distance, off) = self.distances.sample(to);
        let distance = if self.is_solid() { distance } else { distance.abs() };
        if distance - off > reach + (to - from).length() {
            return None;
        }
        match slide(self, from, to, reach) {
            SphereSlide::Clear => None,
            SphereSlide::Moved(touch) => touch,
            SphereSlide::Inside => {
                let (near, at_start) = (self.nearest(to), self.nearest(from));
                if near.normal.dot(at_start.normal) >= BEND_COSINE {
                    return near.push_out(reach);
                }
                ShapeTouch::new(at_start.normal, reach + at_start.normal.dot(at_start.point - to))
            }
        }
    }

    /// See [`Shape::reachable`](super::Shape::reachable).
    pub(super) fn reachable(&self, at: Vec3, way: f32, radius: f32) -> Reachable {
        let reach = radius.max(self.skin);
        let (distance, off) = self.distances.sample(at);
        let distance = if self.is_solid() { distance } else { distance.abs() };
        if distance - off > reach + way {
            return Reachable::Nothing;
        }
        reachable(self, at, (way, reach, self.skin))
    }

    /// Calls `call` with the triangles whose bounds (low, high) pass `keep`, as must those of the nodes above.
    pub(super) fn near(&self, keep: &dyn Fn(Vec3, Vec3) -> bool, call: &mut dyn FnMut([Vec3; 3])) {
        let mut cursor = 0;
        while let Some(range) = self.tree.next(&mut cursor, keep) {
            for piece in &self.pieces[range] {
                let (low, high) = piece.bounds();
                if keep(low, high) {
                    call(piece.corners);
                }
            }
        }
    }

    /// See [`Shape::nearest`](super::Shape::nearest).
    pub(super) fn nearest(&self, p: Vec3) -> Nearest {
        let (distance, off) = self.distances.sample(p);
        self.signed(p, (distance.abs() + off) * 1.001)
    }

    /// The nearest point, given an upper bound of the distance.
    fn signed(&self, p: Vec3, at_most: f32) -> Nearest {
        let mut best: Option<(usize, ClosestPoint)> = None;
        // A little more, so that a distance equal to the bound is found.
        let mut least = at_most * at_most * 1.001 + f32::MIN_POSITIVE;
        let mut cursor = 0;
        let away = |low: Vec3, high: Vec3| (p - p.min(high).max(low)).length_squared();
        while let Some(range) = self.tree.next(&mut cursor, |low, high| away(low, high) <= least) {
            for i in range {
                let close = self.pieces[i].closest(p);
                let nearer = best.is_none_or(|(other, best)| {
                    close.square < best.square || (close.square == best.square && i < other)
                });
                if nearer && close.square <= least {
                    (least, best) = (close.square, Some((i, close)));
                }
            }
        }
        // `None` only if the point is not finite.
        let Some((i, close)) = best else {
            return Nearest { point: p, normal: Vec3::Y, distance: f32::INFINITY };
        };
        let (distance, toward) = (close.square.sqrt(), p - close.point);
        let is_in_front = self.is_in_front(i, &close, p);
        let normal = if close.feature == Feature::Face || distance <= 0.25 * self.skin {
            let up = self.is_solid() || is_in_front;
            if up { self.pieces[i].normal } else { -self.pieces[i].normal }
        } else {
            let sign = if is_in_front || !self.is_solid() { 1.0 } else { -1.0 };
            toward / (sign * distance)
        };
        let inside = self.is_solid() && !is_in_front;
        Nearest { point: close.point, normal, distance: if inside { -distance } else { distance } }
    }

    /// Whether a point is on the front side of the nearest triangle.
    fn is_in_front(&self, i: usize, close: &ClosestPoint, p: Vec3) -> bool {
        let pseudo_normals = self.pseudo_normals.get(i).copied().unwrap_or_default();
        let normal = match close.feature {
            Feature::Edge(k) if self.is_solid() => pseudo_normals.edges[usize::from(k)],
            Feature::Corner(k) if self.is_solid() => pseudo_normals.corners[usize::from(k)],
            Feature::Face | Feature::Edge(_) | Feature::Corner(_) => {
                let triangle = &self.pieces[i];
                return triangle.normal.dot(p - triangle.corners[0]) >= 0.0;
            }
        };
        normal.dot(p - close.point) >= 0.0
    }
}

impl Surface for Mesh {
    #[inline(always)]
    fn visit(&self, path: &SpherePath, call: &mut impl FnMut(u32, &Triangle)) {
        let mut cursor = 0;
        while let Some(range) = self.tree.next(&mut cursor, |low, high| path.may_overlap(low, high))
        {
            for i in range {
                call(i as u32, &self.pieces[i]);
            }
        }
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    fn front_only(&self) -> bool {
        self.is_solid()
    }

    fn is_away_from_rim(&self, _at: Vec3, _distance: f32) -> bool {
        true
    }

    fn is_inside(&self, p: Vec3, near: Option<&(u32, ClosestPoint, Triangle)>) -> bool {
        if !self.is_solid() {
            return false;
        }
        if let Some((i, close, _)) = near {
            return !self.is_in_front(*i as usize, close, p);
        }
        let (distance, off) = self.distances.sample(p);
        // Where the grid is too coarse to decide, the triangles do.
        if distance.abs() > off { distance < 0.0 } else { self.nearest(p).distance < 0.0 }
    }
}

/// Merges vertices at the same position, in the order of first appearance, and drops triangles that have a position twice.
fn welded(vertices: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let first = first_coincident(vertices);
    let mut number = vec![u32::MAX; vertices.len()];
    let mut places = Vec::new();
    for i in 0..vertices.len() {
        if first[i] == i as u32 {
            number[i] = places.len() as u32;
            places.push(vertices[i] + Vec3::ZERO);
        }
    }
    let corner = |i: u32| number[first[i as usize] as usize];
    let distinct = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    (places, triangles.iter().map(|t| t.map(corner)).filter(distinct).collect())
}

/// The pseudo-normals, if every edge belongs to two triangles with opposite directions and the volume is positive; empty otherwise.
fn pseudo_normals(
    vertices: usize,
    triangles: &[[u32; 3]],
    pieces: &[Triangle],
) -> Vec<PseudoNormals> {
    // Both ends of an edge as one number, the first in the upper half.
    let joined = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
    let side = |t: &[u32; 3], k: usize| joined(t[k], t[(k + 1) % 3]);
    let mut sides: Vec<(u64, u32)> =
        (0..).zip(triangles).flat_map(|(i, t)| [0, 1, 2].map(|k| (side(t, k), i))).collect();
    sides.sort_unstable();
    let opposite = |side: u64| {
        let back = side.rotate_left(32);
        let at = sides.partition_point(|(other, _)| *other < back);
        sides.get(at).filter(|(other, _)| *other == back).map(|(_, i)| *i as usize)
    };
    let twice = sides.windows(2).any(|pair| pair[0].0 == pair[1].0);
    // Relative to a vertex, so that a small mesh far from the origin keeps its precision.
    let origin = pieces[0].corners[0].as_dvec3();
    let volume = |piece: &Triangle| {
        let [a, b, c] = piece.corners.map(|corner| corner.as_dvec3() - origin);
        a.dot(b.cross(c))
    };
    let closed = !twice && sides.iter().all(|(side, _)| opposite(*side).is_some());
    if !closed || pieces.iter().map(volume).sum::<f64>() <= 0.0 {
        return Vec::new();
    }
    let mut corners = vec![Vec3::ZERO; vertices];
    for (t, piece) in triangles.iter().zip(pieces) {
        for k in 0..3 {
            let at = |j: usize| piece.corners[(k + j) % 3].as_dvec3();
            let (a, b) = ((at(1) - at(0)).normalize(), (at(2) - at(0)).normalize());
            let angle = libm::atan2(a.cross(b).length(), a.dot(b));
            corners[t[k] as usize] += piece.normal * angle as f32;
        }
    }
    let own = |(t, piece): (&[u32; 3], &Triangle)| {
        let other = |k| opposite(side(t, k)).map_or(Vec3::ZERO, |i| pieces[i].normal);
        PseudoNormals {
            edges: [0, 1, 2].map(|k| piece.normal + other(k)),
            corners: t.map(|i| corners[i as usize]),
        }
    };
    triangles.iter().zip(pieces).map(own).collect()
}
