//! The pairs that `parry3d` finds: cylinders and hulls (Gilbert, Johnson and Keerthi's search, then clipped features), and what is convex on
//! triangles.
//!
//! Its own manifolds remember the last call; they are emptied before each, so that the same input gives the same bits whatever was asked before.

use glam::Vec3;
use parry3d::bounding_volume::BoundingVolume;
use parry3d::math::{Pose, Rotation, Vector};
use parry3d::query::details::NormalConstraints;
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d::shape::{Shape as ParryShape, Triangle, TrianglePseudoNormals};
use smallvec::SmallVec;

use super::super::Shape;
use super::super::shape::Kind;
use super::reduce::reduced;
use super::round::{limit, rim};
use super::{Frame, Manifold, Point, radius};

/// What is kept between calls, for its memory alone.
#[derive(Default)]
pub(crate) struct Scratch {
    manifold: ContactManifold<(), ()>,
}

/// Two convex shapes of any kind.
pub(super) fn collide(
    a: &Shape,
    b: &Shape,
    a_in_b: &Frame,
    reach: f32,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    if !a_in_b.translation.is_finite() {
        return None;
    }
    touch(b.parry(), None, a, a_in_b, &pose(a_in_b), reach, scratch)
}

/// A convex shape on each of the triangles of a mesh or a heightfield that it is near.
pub(super) fn on_triangles(
    a: &Shape,
    b: &Shape,
    a_in_b: &Frame,
    reach: f32,
    scratch: &mut Scratch,
    out: &mut impl FnMut(&Manifold),
) {
    if !a_in_b.translation.is_finite() {
        return;
    }
    let pose = pose(a_in_b);
    let bounds = a.parry().compute_aabb(&pose).loosened(reach);
    let mut on = |part: u32, triangle: &Triangle, normals: Option<TrianglePseudoNormals>| {
        let normals = normals.as_ref().map(|normals| normals as &dyn NormalConstraints);
        let found = touch(triangle, normals, a, a_in_b, &pose, reach, scratch);
        if let Some(manifold) = found.filter(Manifold::is_sound) {
            out(&Manifold { part, radii: [radius(a.kind()), 0.0], ..manifold });
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

/// One call of the library's, afresh.
fn touch(
    b: &dyn ParryShape,
    normals: Option<&dyn NormalConstraints>,
    a: &Shape,
    a_in_b: &Frame,
    pose: &Pose,
    reach: f32,
    scratch: &mut Scratch,
) -> Option<Manifold> {
    let (kind, found) = (a.kind(), &mut scratch.manifold);
    found.clear();
    (found.local_n1, found.local_n2) = (Vector::ZERO, Vector::ZERO);
    DefaultQueryDispatcher
        .contact_manifold_convex_convex(pose, b, a.parry(), normals, None, reach, found)
        .ok()?;
    let normal = ours(found.local_n1);
    // The library takes a capsule for a line, and goes straight from there along the normal: into it, where the normal is not across the line.
    let towards_b = ours(found.local_n2);
    let round = |p: Vec3| match kind {
        Kind::Capsule { radius, half_height } => {
            let along = limit((p - towards_b * radius).y, half_height);
            Vec3::Y * along + rim(Vec3::Y, along, half_height, towards_b) * radius
        }
        _ => p,
    };
    let points: SmallVec<[Point; 16]> = found
        .points
        .iter()
        .map(|point| {
            let (on_a, on_b) = (round(ours(point.local_p2)), ours(point.local_p1));
            Point { on_a, on_b, distance: (a_in_b.point(on_a) - on_b).dot(normal) }
        })
        .collect();
    Some(reduced(normal, reach, &points))
}

/// A frame in the library's form. The quaternion of a rotation, by the largest of its four terms.
fn pose(frame: &Frame) -> Pose {
    let r = &frame.rotation;
    let [x, y, z] = [r.x_axis, r.y_axis, r.z_axis];
    let squares = [
        1.0 + x.x + y.y + z.z,
        1.0 + x.x - y.y - z.z,
        1.0 - x.x + y.y - z.z,
        1.0 - x.x - y.y + z.z,
    ];
    let (w, i, j, k) = if squares[0] >= 1.0 {
        (squares[0], y.z - z.y, z.x - x.z, x.y - y.x)
    } else if squares[1] >= squares[2] && squares[1] >= squares[3] {
        (y.z - z.y, squares[1], x.y + y.x, z.x + x.z)
    } else if squares[2] >= squares[3] {
        (z.x - x.z, x.y + y.x, squares[2], y.z + z.y)
    } else {
        (x.y - y.x, z.x + x.z, y.z + z.y, squares[3])
    };
    let length = (w * w + i * i + j * j + k * k).sqrt();
    let rotation = Rotation::from_xyzw(i / length, j / length, k / length, w / length);
    Pose::from_parts(theirs(frame.translation), rotation)
}

fn ours(v: Vector) -> Vec3 {
    Vec3::new(v.x, v.y, v.z)
}

fn theirs(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}
