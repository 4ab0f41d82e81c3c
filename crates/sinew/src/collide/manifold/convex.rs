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

use super::super::distance::to_triangle;
use super::super::shape::{Kind, Shape, from_parry, pose, to_parry};
use super::boxes::BoxPairs;
use super::coplanar::TriangleContacts;
use super::features::{ContactPoints, ShapeOrTriangle, best_face, contacts, of_face};
use super::reduce::reduced;
use super::round::{limit, rim};
use super::{FLAT_COSINE, FLAT_SINE, Frame, Manifold, Point, roundings};

/// Buffers reused between calls; they do not influence results.
#[derive(Default)]
pub(crate) struct ManifoldScratch {
    pub(super) boxes: BoxPairs,
    manifold: ContactManifold<(), ()>,
    triangles: TriangleContacts,
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
    let found = &mut scratch.manifold;
    let (normal, points) = touch((b.parry(), &of), None, a, a_in_b, &pose(a_in_b), reach, found)?;
    Some(reduced(normal, reach, &points))
}

/// The normals that a triangle of a mesh or heightfield may have: those of its pseudo-normals, on the side where the shape is.
///
/// A shape that lies on coplanar triangles touches the next one at an edge, from the side: the direction of their nearest points is level, and rounding
/// decides whether it points up or down. On a solid that contact is dropped if it points down, on a sheet it would be one from below.
#[derive(Clone)]
struct TriangleNormals {
    pseudo_normals: TrianglePseudoNormals,
    /// The face normal on the side of the shape.
    face: Vector,
    /// Height of the lowest point of the shape above the triangle's plane on that side, metres.
    height: f32,
}

impl TriangleNormals {
    /// Which side of a sheet the shape is on is where its overlap with the plane of the triangle is least.
    fn new(
        pseudo_normals: TrianglePseudoNormals,
        a: &ShapeOrTriangle,
        a_in_b: &Frame,
        p: Vec3,
    ) -> Self {
        let face = from_parry(pseudo_normals.face);
        let height = above(a, a_in_b, face, p);
        let behind =
            if pseudo_normals.two_sided { above(a, a_in_b, -face, p) } else { f32::NEG_INFINITY };
        let (face, height) = if height >= behind {
            (pseudo_normals.face, height)
        } else {
            (-pseudo_normals.face, behind)
        };
        Self { pseudo_normals, face, height }
    }
}

impl NormalConstraints for TriangleNormals {
    fn project_local_normal_mut(&self, normal: &mut Vector) -> bool {
        let up = normal.dot(self.face);
        // A level one, or one of the face, on the wrong side. Others are those of a sheet's rim.
        if up < 0.0 && (up > -FLAT_SINE || self.pseudo_normals.two_sided && up < -FLAT_COSINE) {
            *normal -= self.face * (2.0 * up);
        }
        self.pseudo_normals.project_local_normal_mut(normal)
    }
}

/// Height of the lowest point of a shape above the plane through `p` with the unit normal `up`, metres; in the coordinates of the second shape.
fn above(a: &ShapeOrTriangle, a_in_b: &Frame, up: Vec3, p: Vec3) -> f32 {
    up.dot(a_in_b.translation - p) - a.reach(a_in_b.turn_back(-up))
}

/// A convex shape on the nearby triangles of a mesh or heightfield: a manifold for each plane of them, in the order of its first triangle.
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
    let own = ShapeOrTriangle::Shape(a);
    let ManifoldScratch { manifold, triangles, .. } = scratch;
    triangles.clear();
    let mut on = |part: u32, triangle: &Triangle, normals: Option<TrianglePseudoNormals>| {
        let corners = [triangle.a, triangle.b, triangle.c].map(from_parry);
        let normals =
            normals.map(|normals| TriangleNormals::new(normals, &own, a_in_b, corners[0]));
        let (of, normals) = (ShapeOrTriangle::Triangle(corners), normals.as_ref());
        let found = if let Kind::Sphere { radius } = a.kind() {
            ball_on_triangle(radius, a_in_b, corners, normals, reach)
        } else {
            touch((triangle, &of), normals, a, a_in_b, &pose, reach, manifold)
        };
        if let Some((normal, points)) = found {
            let roundings = roundings([a.kind(), b.kind()], a_in_b, normal, &points);
            triangles.push(part, (normal, &points), roundings, reach);
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
    triangles.each_plane(&mut |manifold| {
        if manifold.is_sound() {
            out(&manifold);
        }
    });
}

/// A ball on a triangle. Where the triangle does not allow the normal there, the ball touches it along one that it allows only if its centre is above the
/// triangle that way, to rounding: of a ball above the edge of two triangles, one of them has to be touched.
fn ball_on_triangle(
    radius: f32,
    a_in_b: &Frame,
    corners: [Vec3; 3],
    normals: Option<&TriangleNormals>,
    reach: f32,
) -> Option<(Vec3, ContactPoints)> {
    let (centre, corners) = (a_in_b.translation.as_dvec3(), corners.map(Vec3::as_dvec3));
    let [i, j, k] = to_triangle(centre, corners);
    let nearest = corners[0] * i + corners[1] * j + corners[2] * k;
    let between = (centre - nearest).as_vec3();
    let length = between.length();
    if length > radius + reach {
        return None;
    }
    let face = normals.map_or(Vec3::Y, |normals| from_parry(normals.face));
    let mut normal = if length > 1e-6 * radius { between / length } else { face };
    if let Some(normals) = normals {
        let allowed = from_parry(normals.project_local_normal(to_parry(normal))?);
        let aside = between - allowed * allowed.dot(between);
        let rounding = 1e-4 * radius + 1e-6 * a_in_b.translation.abs().max_element();
        if allowed.dot(normal) < 0.999 && aside.length() > rounding {
            return None;
        }
        normal = allowed;
    }
    let on_a = a_in_b.turn_back(normal * -radius);
    let distance = between.dot(normal) - radius;
    let point = Point { on_a, on_b: nearest.as_vec3(), distance };
    Some((normal, [point].into_iter().collect()))
}

/// Distance at which touching or overlapping shapes are queried, as a share of the smallest half extent of the first one. `parry3d` computes the normal of two
/// separated shapes from their nearest points, which rounding displaces by 1e-7 of their size: at a hundredth of the size the error is 1e-5 rad. For shapes
/// that touch exactly it returns no normal.
const APART: f32 = 0.01;
/// Greatest number of queries in which the shapes are moved apart to that distance; then the last result is used.
const QUERIES: u32 = 4;
/// By what share of [`APART`] an edge or corner must be farther apart than a face to be preferred: a shape that lies on a face keeps it.
const BIAS: f32 = 0.1;

/// The normal and all contact points of two convex shapes. Where a face separates them most, or they overlap least along it, the normal is that of the face.
/// Where an edge or a corner touches, it is found at a distance: the first shape is moved out along the last normal found, which does not change which features
/// are nearest.
fn touch(
    (b, of): (&dyn ParryShape, &ShapeOrTriangle),
    normals: Option<&TriangleNormals>,
    a: &Shape,
    a_in_b: &Frame,
    pose: &Pose,
    reach: f32,
    found: &mut ContactManifold<(), ()>,
) -> Option<(Vec3, ContactPoints)> {
    let apart = APART * a.parry().compute_local_aabb().half_extents().min_element();
    let query = Query { a: a.parry(), b, normals, pose, reach, apart };
    let is_round = matches!(a.kind(), Kind::Sphere { .. } | Kind::Capsule { .. });
    let nearest = query.run(is_round, found)?;
    let own = ShapeOrTriangle::Shape(a);
    let seen = normals
        .filter(|_| !is_round && nearest == f32::NEG_INFINITY)
        .map_or(found.local_n1, |normals| normals.face);
    let mut normal = of_face(&own, of, a_in_b, from_parry(seen));
    // Round shapes have a normal up to a depth of their radius anyway; and `parry3d` adjusts the normals of mesh triangles to the neighbouring surface.
    if !is_round && normals.is_none() {
        let seen = if nearest > f32::NEG_INFINITY {
            separation(&own, of, a_in_b, normal)
        } else {
            f32::NEG_INFINITY
        };
        let bias = if seen < 0.5 * apart { BIAS * apart } else { 0.0 };
        let face = best_face(&own, of, a_in_b);
        normal = face.filter(|face| face.0 >= seen - bias).map_or(normal, |face| face.1);
    }
    Some((normal, along_normal(a, of, a_in_b, normal, 0.02 * apart, found)))
}

/// Separation of two shapes along a unit direction, metres. It is greatest along their normal, so of two directions the one along which it is greater is nearer to
/// that. For cylinders, what `parry3d` takes for their nearest points may be 0.4 mm farther apart than those, and a normal 7 mrad off: on seams, cylinders hopped.
fn separation(a: &ShapeOrTriangle, b: &ShapeOrTriangle, a_in_b: &Frame, along: Vec3) -> f32 {
    above(a, a_in_b, along, Vec3::ZERO) - b.reach(along)
}

/// Two convex shapes, the first one at a pose in the other's coordinates.
struct Query<'a> {
    a: &'a dyn ParryShape,
    b: &'a dyn ParryShape,
    normals: Option<&'a TriangleNormals>,
    pose: &'a Pose,
    reach: f32,
    apart: f32,
}

impl Query<'_> {
    /// Queries `parry3d` once, or until the shapes are [`APART`]. Returns their distance, metres; minus infinity if `parry3d` finds none; and `None` if they
    /// are further apart than `reach`.
    fn run(&self, once: bool, found: &mut ContactManifold<(), ()>) -> Option<f32> {
        let Self { a, b, normals, pose, reach, apart } = *self;
        let constraints = normals.map(|normals| normals as &dyn NormalConstraints);
        let (mut away, mut nearest) = (Vector::ZERO, f32::NEG_INFINITY);
        // What lies on a triangle is first moved along its face normal: the direction of nearest points that touch is rounding.
        let lies = normals.filter(|normals| !once && normals.height.abs() <= apart);
        let mut lifted = lies.map(|normals| normals.face * (apart - normals.height));
        for _ in 0..QUERIES {
            found.clear();
            (found.local_n1, found.local_n2) = (Vector::ZERO, Vector::ZERO);
            let moved = Pose::from_parts(pose.translation + away, pose.rotation);
            let reach = reach + away.length();
            DefaultQueryDispatcher
                .contact_manifold_convex_convex(&moved, b, a, constraints, None, reach, found)
                .ok()?;
            let normal = found.local_n1;
            let distance = found.points.iter().map(|point| point.dist).reduce(f32::min);
            let Some(distance) = distance.filter(|_| normal.length_squared() > 0.5) else {
                if let Some(lifted) = lifted.take() {
                    away = lifted;
                    continue;
                }
                let is_far = normal == Vector::ZERO || is_between(normal, b, a, (&moved, reach));
                let none = found.points.is_empty() && is_far;
                return (!none).then_some(f32::NEG_INFINITY);
            };
            nearest = distance - normal.dot(away);
            if once || distance >= 0.5 * apart {
                break;
            }
            away = lifted.take().unwrap_or(away + normal * (apart - distance));
        }
        Some(nearest)
    }
}

/// Whether a plane across `direction` separates two shapes by more than `reach`, metres.
fn is_between(
    direction: Vector,
    b: &dyn ParryShape,
    a: &dyn ParryShape,
    (pose, reach): (&Pose, f32),
) -> bool {
    let (Some(a), Some(b)) = (a.as_support_map(), b.as_support_map()) else { return true };
    let gap = |direction: Vector| {
        let nearest = a.support_point(pose, -direction) - b.local_support_point(direction);
        nearest.dot(direction)
    };
    gap(direction) > reach || gap(-direction) > reach
}

/// The contact points along a normal, with distances at the first shape's actual pose: those of the features, plus the nearest point found by the query where
/// it is deeper by more than rounding.
fn along_normal(
    a: &Shape,
    b: &ShapeOrTriangle,
    a_in_b: &Frame,
    normal: Vec3,
    rounding: f32,
    found: &ContactManifold<(), ()>,
) -> ContactPoints {
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
    points
}
