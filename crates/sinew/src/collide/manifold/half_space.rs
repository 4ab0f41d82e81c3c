//! Convex shapes against a half-space, which is solid below y = 0 of its frame: the lowest points within reach.

use glam::Vec3;
use smallvec::SmallVec;

use super::super::shape::Kind;
use super::reduce::reduced;
use super::round::rim;
use super::{FLAT_SINE, Frame, Manifold, Point, across_axis};

/// The manifold of a shape at `frame`, in the coordinates of the half-space. Empty for shapes that are not solids.
pub(super) fn collide(kind: Kind, frame: &Frame, reach: f32) -> Manifold {
    let r = &frame.rotation;
    // The vertical in the shape's coordinates.
    let up = Vec3::new(r.x_axis.y, r.y_axis.y, r.z_axis.y);
    let height = |local: Vec3| up.dot(local) + frame.translation.y;
    match kind {
        Kind::Sphere { radius } => gather([up * -radius], frame, reach),
        Kind::Capsule { radius, half_height } => {
            let lowest =
                |along: f32| Vec3::Y * along + rim(Vec3::Y, along, half_height, -up) * radius;
            gather([lowest(half_height), lowest(-half_height)], frame, reach)
        }
        Kind::Box { half_size } => gather(lowest_face(half_size, up), frame, reach),
        Kind::Cylinder { radius, half_height } => cylinder(radius, half_height, up, frame, reach),
        Kind::Hull(corners) => {
            let near = corners.iter().filter(|corner| height(**corner) <= reach);
            let points: SmallVec<[Point; 16]> = near.map(|&corner| point(corner, frame)).collect();
            reduced(Vec3::Y, reach, &points)
        }
        Kind::HalfSpace | Kind::InsideBox | Kind::Mesh | Kind::HeightField => Manifold::default(),
    }
}

/// A point of the shape and its projection onto the plane.
fn point(on_a: Vec3, frame: &Frame) -> Point {
    let place = frame.point(on_a);
    Point { on_a, on_b: Vec3::new(place.x, 0.0, place.z), distance: place.y }
}

/// Manifold of the points within reach, at most four.
#[inline(always)]
fn gather<const N: usize>(points: [Vec3; N], frame: &Frame, reach: f32) -> Manifold {
    reduced(Vec3::Y, reach, &points.map(|on_a| point(on_a, frame)))
}

/// The corners of a box's lowest face; they include its lowest corner and lowest edge.
#[inline(always)]
fn lowest_face(half_size: Vec3, up: Vec3) -> [Vec3; 4] {
    let steep = up.abs();
    let (x, y, z) = if steep.y >= steep.x && steep.y >= steep.z {
        (Vec3::X, Vec3::Y, Vec3::Z)
    } else if steep.x >= steep.z {
        (Vec3::Y, Vec3::X, Vec3::Z)
    } else {
        (Vec3::X, Vec3::Z, Vec3::Y)
    };
    let [x, y, z] = [x, y, z].map(|axis| axis * half_size);
    let centre = if y.dot(up) > 0.0 { -y } else { y };
    [centre + x + z, centre - x + z, centre - x - z, centre + x - z]
}

/// Points on the rims of a cylinder along y: if it lies, the lowest of each rim; if it stands on an end, the lowest and highest points of that rim and the two
/// between.
fn cylinder(radius: f32, half_height: f32, up: Vec3, frame: &Frame, reach: f32) -> Manifold {
    let (down, steep) = across_axis(-up);
    let (down, across) = (down * radius, Vec3::new(-down.z, 0.0, down.x) * radius);
    let lower = Vec3::Y * if up.y > 0.0 { -half_height } else { half_height };
    if steep > FLAT_SINE {
        return gather([lower + down, down - lower], frame, reach);
    }
    gather([lower + down, lower + across, lower - down, lower - across], frame, reach)
}
