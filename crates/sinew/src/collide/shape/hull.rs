//! Convex hull: nearest point and ray entry by the planes of its faces, and exact at its edges and vertices.
//!
//! Inside, the nearest face is the one whose plane is nearest. Outside, the nearest point is on one of the faces that the point is in front of, and no nearer
//! than its plane, so most faces are never tested. For a sphere that stays in front of a plane, that plane alone decides.

use glam::{DVec3, Vec3};

use super::convex::{Convex, Entry};
use super::fault::{first_out_of_range, is_length};
use super::triangle::{Feature, Triangle};
use super::{Nearest, ShapeFault, ShapeTouch};
use crate::convex_hull::{ConvexHullFault, convex_hull};

/// Vertices and faces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ConvexHull {
    /// Vertices, metres.
    pub(super) points: Vec<Vec3>,
    /// Vertex indices, counter-clockwise from outside; the triangles of a face are consecutive.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The same triangles with coordinates.
    pieces: Vec<Triangle>,
    faces: Vec<Face>,
    /// Rounding of coordinates, as a distance in metres.
    tolerance: f32,
}

/// A plane that has all vertices behind it, and the triangles in it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    /// Outward unit vector.
    normal: Vec3,
    /// Extent of the hull along the normal, metres from the origin.
    offset: f32,
    /// Range of its triangles.
    first: u32,
    end: u32,
}

/// Triangles belong to one face if all vertices are this close to its plane, as a share of the extent: somewhat more than the rounding of coordinates.
const IN_PLANE: f64 = 1e-6;

/// Above this number triangles are not merged to faces, since that takes quadratic time.
const MAX_TO_MERGE: usize = 4096;

impl ConvexHull {
    /// Validates the points and computes the faces.
    pub(super) fn new(points: &[Vec3]) -> Result<Self, ShapeFault> {
        if let Some(point) = first_out_of_range(points) {
            return Err(ShapeFault::Point(point));
        }
        let triangles = convex_hull(points)?;
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let corners: Vec<Vec3> = used.iter().map(|&i| points[i as usize]).collect();
        let number = |i: u32| used.partition_point(|&other| other < i) as u32;
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(number)).collect();
        Self::of_triangles(corners, &triangles)
    }

    /// Validates the size and computes the faces from known vertices and triangles. The triangles of a hull result in the same hull again.
    pub(super) fn of_triangles(
        corners: Vec<Vec3>,
        triangles: &[[u32; 3]],
    ) -> Result<Self, ShapeFault> {
        let (low, high) = super::extent::around(&corners);
        let extent = (high - low).max_element();
        if !is_length(extent) {
            return Err(ShapeFault::Size);
        }
        let hull = Self::merged(corners, triangles, f64::from(extent) * IN_PLANE);
        // A body thinner than rounding has no inside.
        let depth = |face: &Face| {
            let least =
                hull.points.iter().map(|p| face.normal.dot(*p)).fold(f32::INFINITY, f32::min);
            f64::from(face.offset - least)
        };
        if hull.faces.is_empty()
            || hull.faces.iter().any(|face| depth(face) <= f64::from(extent) * IN_PLANE)
        {
            return Err(ConvexHullFault::Flat.into());
        }
        Ok(hull)
    }

    /// Merges coplanar triangles. The largest come first, because their planes are the most accurate.
    fn merged(points: Vec<Vec3>, triangles: &[[u32; 3]], near: f64) -> Self {
        let wide = |t: [u32; 3]| t.map(|i| points[i as usize].as_dvec3());
        let normal = |t: [u32; 3]| {
            let [a, b, c] = wide(t);
            (b - a).cross(c - a)
        };
        let mut order: Vec<usize> = (0..triangles.len()).collect();
        let area = |i: usize| normal(triangles[i]).length_squared();
        order.sort_by(|&i, &j| area(j).total_cmp(&area(i)).then(i.cmp(&j)));
        let mut planes: Vec<(DVec3, f64, Vec<usize>)> = Vec::new();
        for i in order {
            let cross = normal(triangles[i]);
            let corners = wide(triangles[i]);
            let same = |(n, offset, _): &&mut (DVec3, f64, Vec<usize>)| {
                n.dot(cross) >= 0.0 && corners.iter().all(|c| (n.dot(*c) - *offset).abs() <= near)
            };
            let merge = triangles.len() <= MAX_TO_MERGE;
            if let Some(plane) = planes.iter_mut().find(|plane| merge && same(plane)) {
                plane.2.push(i);
                continue;
            }
            // A sliver without an area has no plane of its own; its edges belong to its neighbours.
            if let Some(unit) = cross.try_normalize() {
                planes.push((unit, unit.dot(corners[0]), vec![i]));
            }
        }
        let (mut sorted, mut faces) = (Vec::new(), Vec::new());
        for (unit, _, members) in planes {
            let first = sorted.len() as u32;
            sorted.extend(members.iter().map(|&i| triangles[i]));
            let normal = unit.as_vec3();
            let offset = points.iter().map(|p| normal.dot(*p)).fold(f32::NEG_INFINITY, f32::max);
            faces.push(Face { normal, offset, first, end: sorted.len() as u32 });
        }
        let piece = |t: &[u32; 3]| Triangle::new(t.map(|i| points[i as usize]));
        let pieces = sorted.iter().map(piece).collect();
        Self { points, triangles: sorted, pieces, faces, tolerance: near as f32 }
    }

    /// The outward normals of its faces, and its extent along each, metres from the origin.
    pub(super) fn faces(&self) -> impl Iterator<Item = (Vec3, f32)> {
        self.faces.iter().map(|face| (face.normal, face.offset))
    }

    /// Vertices of the faces whose normals are within an angle of a unit direction, given by its cosine; some of them several times.
    pub(super) fn corners_towards(
        &self,
        direction: Vec3,
        cosine: f32,
    ) -> impl Iterator<Item = Vec3> {
        let faces = self.faces.iter().filter(move |face| face.normal.dot(direction) > cosine);
        let triangles =
            faces.flat_map(|face| &self.triangles[face.first as usize..face.end as usize]);
        triangles.flatten().map(|&i| self.points[i as usize])
    }

    /// See [`Shape::touch`](super::Shape::touch).
    pub(super) fn touch(&self, from: Vec3, to: Vec3, radius: f32) -> Option<ShapeTouch> {
        let (mut front, mut best) = (0, f32::NEG_INFINITY);
        for (i, face) in self.faces.iter().enumerate() {
            let distance = face.normal.dot(to) - face.offset;
            if distance >= radius && face.normal.dot(from) >= face.offset {
                return None;
            }
            if distance > best {
                (front, best) = (i, distance);
            }
        }
        self.touch_near(self.nearest_from(to, front, best), from, to, radius)
    }

    /// The nearest point, given the face with the greatest signed distance of `p` from its plane, and that distance.
    fn nearest_from(&self, p: Vec3, front: usize, best: f32) -> Nearest {
        let face = &self.faces[front];
        let mut nearest =
            Nearest { point: p - face.normal * best, normal: face.normal, distance: best };
        if best <= 0.0 {
            return nearest;
        }
        // If `p` is above that face, the nearest point is on it. If not, its triangles come first, then those of all faces that could be nearer.
        let mut least = f32::INFINITY;
        for i in std::iter::once(front).chain((0..self.faces.len()).filter(|&i| i != front)) {
            let face = &self.faces[i];
            let distance = face.normal.dot(p) - face.offset;
            if distance <= 0.0 || distance * distance >= least {
                continue;
            }
            for piece in &self.pieces[face.first as usize..face.end as usize] {
                let close = piece.closest(p);
                if close.square >= least {
                    continue;
                }
                least = close.square;
                let (point, away) = (close.point, least.sqrt());
                // Near an edge the direction to the nearest point is the normal; above a face, or almost on it, that of its plane is more accurate.
                if close.feature == Feature::Face || away <= self.tolerance {
                    let (normal, point) = (face.normal, p - face.normal * distance);
                    nearest = Nearest { point, normal, distance };
                } else {
                    nearest = Nearest { point, normal: (p - point) / away, distance: away };
                }
                if i == front && close.feature == Feature::Face {
                    return nearest;
                }
            }
        }
        nearest
    }
}

impl Convex for ConvexHull {
    fn nearest(&self, p: Vec3) -> Nearest {
        let (mut front, mut best) = (0, f32::NEG_INFINITY);
        for (i, face) in self.faces.iter().enumerate() {
            let distance = face.normal.dot(p) - face.offset;
            if distance > best {
                (front, best) = (i, distance);
            }
        }
        self.nearest_from(p, front, best)
    }

    fn enter(&self, from: Vec3, motion: Vec3, max: f32) -> Option<Entry> {
        let mut entry: Option<Entry> = None;
        let mut exit = max;
        for face in &self.faces {
            let (height, rise) = (face.normal.dot(from) - face.offset, face.normal.dot(motion));
            if height >= 0.0 {
                let sinks = rise < 0.0;
                if !sinks {
                    return None;
                }
                let share = -height / rise;
                if entry.is_none_or(|entry| share > entry.share) {
                    entry = Some(Entry { share, normal: face.normal, offset: face.offset });
                }
            } else if rise > 0.0 {
                exit = exit.min(-height / rise);
            }
        }
        entry.filter(|entry| entry.share <= exit)
    }
}
