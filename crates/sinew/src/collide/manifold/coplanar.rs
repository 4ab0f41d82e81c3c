//! One manifold for all coplanar triangles that a shape touches, so that a floor that is a mesh costs no more than a plane.
//!
//! A box above eight triangles of a floor has a contact with each, of three or four points, most of them inside of its face: thirty points that hold it no better
//! than its four corners, and eight manifolds that the solver sweeps one by one. The contacts of triangles in one plane are therefore joined: of all their points
//! those that span the outline of the contact area are kept, and [`reduced`] to four.

use core::ops::Range;

use glam::Vec3;

use super::features::spanning;
use super::reduce::reduced;
use super::{Manifold, Point, Roundings};

/// Angle between the normals of triangles up to which they count as coplanar, rad: rounding of a mesh's corners, not a bend. At the middle of a contact area of a
/// metre such a bend is 0.2 mm high.
const COPLANAR: f32 = 1e-3;
/// Rounding of contact points, as a share of the largest coordinate: four units in the last place.
const ROUNDING: f32 = 2.5e-7;
/// The same, at most, as a share of the contact area's extent: five kilometres from the origin of its mesh, where a millimetre is rounding, a box of 2 cm still has
/// four corners.
const ROUNDED_SHARE: f32 = 0.01;

/// Contacts of a convex shape with single triangles. Scratch.
#[derive(Default)]
pub(super) struct TriangleContacts {
    found: Vec<TriangleContact>,
    points: Vec<Point>,
    /// The points of the triangles of one plane.
    of_plane: Vec<Point>,
}

/// Contact points of a convex shape with one triangle.
struct TriangleContact {
    part: u32,
    normal: Vec3,
    /// A cylinder rolls over the triangles below it, and is above those ahead of it with other points of its side.
    roundings: Roundings,
    points: Range<usize>,
    /// Whether it has been joined to that of an earlier triangle.
    joined: bool,
}

impl TriangleContacts {
    pub(super) fn clear(&mut self) {
        self.found.clear();
        self.points.clear();
    }

    /// Adds the contact with a triangle, of points no farther than `reach` metres; one without points is dropped.
    pub(super) fn push(
        &mut self,
        part: u32,
        (normal, points): (Vec3, &[Point]),
        roundings: Roundings,
        reach: f32,
    ) {
        let from = self.points.len();
        self.points.extend(points.iter().filter(|point| point.distance <= reach));
        let points = from..self.points.len();
        if !points.is_empty() {
            self.found.push(TriangleContact { part, normal, roundings, points, joined: false });
        }
    }

    /// Passes a manifold for each plane to `out`, by ascending triangles.
    pub(super) fn each_plane(&mut self, out: &mut dyn FnMut(Manifold)) {
        let Self { found, points, of_plane } = self;
        // A mesh reports its triangles in any order.
        found.sort_unstable_by_key(|one| one.part);
        for first in 0..found.len() {
            let [one, others @ ..] = &mut found[first..] else { return };
            if one.joined {
                continue;
            }
            let (normal, corner) = (one.normal, points[one.points.start].on_b);
            let rounding = ROUNDING * corner.abs().max_element();
            of_plane.clear();
            of_plane.extend_from_slice(&points[one.points.clone()]);
            for other in others.iter_mut().filter(|other| !other.joined) {
                let apart = points[other.points.start].on_b - corner;
                let is_coplanar = other.roundings == one.roundings
                    && (other.normal - normal).length_squared() < COPLANAR * COPLANAR
                    && apart.dot(normal).abs() <= COPLANAR * apart.length() + rounding;
                if is_coplanar {
                    other.joined = true;
                    of_plane.extend_from_slice(&points[other.points.clone()]);
                }
            }
            let manifold = if of_plane.len() > one.points.len() {
                let extent = of_plane.iter().map(|point| point.on_b.distance(corner));
                let extent = extent.fold(0.0, f32::max);
                let rounding = rounding.min(ROUNDED_SHARE * extent);
                reduced(normal, f32::INFINITY, &spanning(of_plane, normal, rounding))
            } else {
                reduced(normal, f32::INFINITY, of_plane)
            };
            let (radii, axial) = one.roundings;
            out(Manifold { part: one.part, radii, axial, ..manifold });
        }
    }
}
