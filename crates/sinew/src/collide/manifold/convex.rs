//! Pairs that use `parry3d`: cylinders and hulls (Gilbert–Johnson–Keerthi, then clipped features), and convex shapes on triangles.
//!
//! `parry3d` manifolds keep data of the previous call. They are cleared before each query, so that the same input gives the same bits whatever the previous
//! queries were.

use glam::Vec3;
use parry3d::bounding_volume::BoundingVolume;
use parry3d::math::{Pose, Vector};
use parry3d::query::details::NormalConstraints;
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d::shape::{Shape as ParryShape, Triangle, TrianglePseudoNormals};

use super::super::shape::{Kind, Shape, from_parry, pose};
use super::boxes::BoxPairs;
use super::features::{ShapeOrTriangle, best_face, contacts, of_face};
use super::reduce::reduced;
use super::round::{limit, rim};
use super::{Frame, Manifold, Point};

/// Buffers reused between calls; they do not influence results.
#[derive(Default)]
pub(crate) struct ManifoldScratch {
    pub(super) boxes: BoxPairs,
    manifold: ContactManifold<(), ()>,
}

/// Two convex shapes of any kind.
pub(super) fn collide(
    a: &Shape,
    b: &Shape,
    a_in_b: &Frame,
    reach: f32,
    scratch: &mut ManifoldScratch,
) -> Option<Manifold> {
    if !a_in_b.translation.is_finite() {
        return None;
    }
    let of = ShapeOrTriangle::Shape(b);
    touch((b.parry(), &of), None, a, a_in_b, &pose(a_in_b), reach, scratch)
}

/// A convex shape on each nearby triangle of a mesh or heightfield.
pub(super) fn on_triangles(
    a: &Shape,
    b: &Shape,
    a_in_b: &Frame,
    reach: f32,
    scratch: &mut ManifoldScratch,
    out: &mut dyn FnMut(&Manifold),
) {
    if !a_in_b.translation.is_finite() {
        return;
    }
    let pose = pose(a_in_b);
    let bounds = a.parry().compute_aabb(&pose).loosened(reach);
    let mut on = |part: u32, triangle: &Triangle, normals: Option<TrianglePseudoNormals>| {
        let normals = normals.as_ref().map(|normals| normals as &dyn NormalConstraints);
        let of = ShapeOrTriangle::Triangle([triangle.a, triangle.b, triangle.c].map(from_parry));
        let found = touch((triangle, &of), normals, a, a_in_b, &pose, reach, scratch);
        if let Some(manifold) = found.filter(Manifold::is_sound) {
            let kinds = [a.kind(), b.kind()];
            let mut manifold = Manifold { part, ..manifold };
            manifold.note_rounding(kinds, a_in_b);
            out(&manifold);
        }
    };
    if let Some(mesh) = b.parry().as_trimesh() {
        for i in mesh.bvh().intersect_aabb(&bounds) {
            if (i as usize) < mesh.num_triangles() {
                on(i, &mesh.triangle(i), mesh.triangle_normal_constraints(i));
            }
        }
    } else if let Some(field) = b.parry().as_heightfield() {
        field.map_elements_in_local_aabb(&bounds, &mut |i, triangle| {
            on(i, triangle, field.triangle_normal_constraints(i));
        });
    }
}

/// Distance at which touching or overlapping shapes are queried, as a share of the smallest half extent of the first one. `parry3d` computes the normal of two
/// separated shapes from their nearest points, which rounding displaces by 1e-7 of their size: at a hundredth of the size the error is 1e-5 rad. For shapes
/// that touch exactly it returns no normal.
const APART: f32 = 0.01;
/// Greatest number of queries in which the shapes are moved apart to that distance; then the last result is used.
const QUERIES: u32 = 4;
/// By what share of [`APART`] an edge or corner must be farther apart than a face to be preferred: a shape that lies on a face keeps it.
const BIAS: f32 = 0.1;

/// The manifold of two convex shapes. Where they touch or overlap, the normal is that of the face of least overlap. Where an edge or a corner touches, the
/// normal is found at a distance: the first shape is moved out along the last normal found, which does not change which features are nearest.
fn touch(
    (b, of): (&dyn ParryShape, &ShapeOrTriangle),
    normals: Option<&dyn NormalConstraints>,
    a: &Shape,
    a_in_b: &Frame,
    pose: &Pose,
    reach: f32,
    scratch: &mut ManifoldScratch,
) -> Option<Manifold> {
    let apart = APART * a.parry().compute_local_aabb().half_extents().min_element();
    let query = Query { a: a.parry(), b, normals, pose, reach, apart };
    let is_round = matches!(a.kind(), Kind::Sphere { .. } | Kind::Capsule { .. });
    let found = &mut scratch.manifold;
    let nearest = query.run(is_round, found)?;
    let own = ShapeOrTriangle::Shape(a);
    let mut normal = of_face(&own, of, a_in_b, from_parry(found.local_n1));
    // Round shapes have a normal up to a depth of their radius anyway; and `parry3d` adjusts the normals of mesh triangles to the neighbouring surface.
    if !is_round && normals.is_none() && nearest < 0.5 * apart {
        let face = best_face(&own, of, a_in_b);
        normal = face.filter(|face| face.0 >= nearest - BIAS * apart).map_or(normal, |face| face.1);
    }
    along_normal(a, of, a_in_b, normal, (reach, 0.02 * apart), found)
}

/// Two convex shapes, the first one at a pose in the other's coordinates.
struct Query<'a> {
    a: &'a dyn ParryShape,
    b: &'a dyn ParryShape,
    normals: Option<&'a dyn NormalConstraints>,
    pose: &'a Pose,
    reach: f32,
    apart: f32,
}

impl Query<'_> {
    /// Queries `parry3d` once, or until the shapes are [`APART`]. Returns their distance, metres; minus infinity if `parry3d` finds none; and `None` if they
    /// are further apart than `reach`.
    fn run(&self, once: bool, found: &mut ContactManifold<(), ()>) -> Option<f32> {
        let Self { a, b, normals, pose, reach, apart } = *self;
        let (mut away, mut nearest) = (Vector::ZERO, f32::NEG_INFINITY);
        for _ in 0..QUERIES {
            found.clear();
            (found.local_n1, found.local_n2) = (Vector::ZERO, Vector::ZERO);
            let moved = Pose::from_parts(pose.translation + away, pose.rotation);
            let reach = reach + away.length();
            DefaultQueryDispatcher
                .contact_manifold_convex_convex(&moved, b, a, normals, None, reach, found)
                .ok()?;
            let normal = found.local_n1;
            let distance = found.points.iter().map(|point| point.dist).reduce(f32::min);
            let Some(distance) = distance.filter(|_| normal.length_squared() > 0.5) else {
                let is_far = normal == Vector::ZERO || is_between(normal, b, a, &moved);
                let none = found.points.is_empty() && is_far;
                return (!none).then_some(f32::NEG_INFINITY);
            };
            nearest = distance - normal.dot(away);
            if once || distance >= 0.5 * apart {
                break;
            }
            away += normal * (apart - distance);
        }
        Some(nearest)
    }
}

/// Whether a plane across `direction` separates two shapes.
fn is_between(direction: Vector, b: &dyn ParryShape, a: &dyn ParryShape, pose: &Pose) -> bool {
    let (Some(a), Some(b)) = (a.as_support_map(), b.as_support_map()) else { return true };
    let gap = |direction: Vector| {
        let nearest = a.support_point(pose, -direction) - b.local_support_point(direction);
        nearest.dot(direction)
    };
    gap(direction) > 0.0 || gap(-direction) > 0.0
}

/// The contact points along a normal, with distances at the first shape's actual pose: those of the features, plus the nearest point found by the query where
/// it is deeper by more than rounding.
fn along_normal(
    a: &Shape,
    b: &ShapeOrTriangle,
    a_in_b: &Frame,
    normal: Vec3,
    (reach, rounding): (f32, f32),
    found: &ContactManifold<(), ()>,
) -> Option<Manifold> {
    let mut points = contacts(&ShapeOrTriangle::Shape(a), b, a_in_b, normal);
    // Maps a point of a capsule's axis to its surface, across the axis except at the ends.
    let towards_b = a_in_b.turn_back(-normal);
    let surface = |axis: Vec3| match a.kind() {
        Kind::Capsule { radius, half_height } => {
            let along = limit(axis.y, half_height);
            Vec3::Y * along + rim(Vec3::Y, along, half_height, towards_b) * radius
        }
        _ => axis,
    };
    let radius = if let Kind::Capsule { radius, .. } = a.kind() { radius } else { 0.0 };
    let seen = |on_a: Vec3, on_b: Vec3| {
        let on_a = surface(on_a);
        Point { on_a, on_b, distance: (a_in_b.point(on_a) - on_b).dot(normal) }
    };
    for point in &mut points {
        *point = seen(point.on_a, point.on_b);
    }
    let nearest = found
        .points
        .iter()
        .map(|point| {
            seen(
                from_parry(point.local_p2) - from_parry(found.local_n2) * radius,
                from_parry(point.local_p1),
            )
        })
        .reduce(|least, point| if point.distance < least.distance { point } else { least });
    let deepest = points.iter().map(|point| point.distance).fold(f32::INFINITY, f32::min);
    points.extend(nearest.filter(|nearest| nearest.distance < deepest - rounding));
    Some(reduced(normal, reach, &points))
}
