//! Anything convex and what is solid below its own zero height: the lowest points of it that are within reach.

use glam::Vec3;
use smallvec::SmallVec;

use super::super::shape::Kind;
use super::reduce::reduced;
use super::round::rim;
use super::{Frame, Manifold, Point, ROLLS, across_axis};

/// A shape at a frame, in the coordinates of the half-space. Nothing for what is no solid.
pub(super) fn collide(kind: Kind, frame: &Frame, reach: f32) -> Manifold {
    let r = &frame.rotation;
    // The vertical in the shape's own coordinates.
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

/// A point of the shape, and the one of the ground below or above it.
fn point(on_a: Vec3, frame: &Frame) -> Point {
    let place = frame.point(on_a);
    Point { on_a, on_b: Vec3::new(place.x, 0.0, place.z), distance: place.y }
}

/// Those within reach, four at most.
#[inline(always)]
fn gather<const N: usize>(points: [Vec3; N], frame: &Frame, reach: f32) -> Manifold {
    reduced(Vec3::Y, reach, &points.map(|on_a| point(on_a, frame)))
}

/// The corners of a box's lowest face: its lowest corner and lowest edge are among them.
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

/// Points of a cylinder's rims, along y: of each one the lowest; of one that stands on an end, the lowest, the highest and the two between of that.
fn cylinder(radius: f32, half_height: f32, up: Vec3, frame: &Frame, reach: f32) -> Manifold {
    let (out, steep) = across_axis(up);
    // One that stands (to 0.06°) would otherwise turn its points with every rounding.
    let down = if steep > 1e-3 { -out } else { Vec3::X };
    let (down, across) = (down * radius, Vec3::new(-down.z, 0.0, down.x) * radius);
    let lower = Vec3::Y * if up.y > 0.0 { -half_height } else { half_height };
    if steep > ROLLS {
        return gather([lower + down, down - lower], frame, reach);
    }
    gather([lower + down, lower + across, lower - down, lower - across], frame, reach)
}
