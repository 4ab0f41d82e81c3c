//! Two boxes apart, past the rims of each other's faces: what is nearest is a corner, or two edges.

use glam::Vec3;
use smallvec::SmallVec;

use super::boxes::Pair;
use super::reduce::reduced;
use super::{Frame, Manifold, Point, inverse};

/// Where two boxes are nearest, if that is within reach and they do not touch. `edges` are the nearest points of
/// the two edges that face each other, on `a` and on `b`, where there are such.
///
/// The nearest points of two boxes that are apart are a corner of one and a point of the other, or two edges along whose product the boxes are as far
/// apart.
pub(super) fn corners(pair: &Pair, reach: f32, edges: Option<[Vec3; 2]>) -> Manifold {
    let (ha, hb) = (Vec3::from(pair.ha), Vec3::from(pair.hb));
    let frame = pair.frame;
    let (of_a, of_b) = (Gaps::new(ha, hb, frame), Gaps::new(hb, ha, &inverse(frame)));
    let mut pairs: SmallVec<[[Vec3; 2]; 17]> = SmallVec::new();
    let within = reach * reach;
    for (corner, squared) in SIGNS.iter().zip(of_a.squared) {
        if squared <= within {
            let p = frame.point(corner * ha);
            pairs.push([p, p.max(-hb).min(hb)]);
        }
    }
    for (corner, squared) in SIGNS.iter().zip(of_b.squared) {
        if squared <= within {
            let q = corner * hb;
            let p = frame.local(q).max(-ha).min(ha);
            // Two corners, to rounding, are a pair already.
            if (ha - p.abs()).max_element() > 1e-5 * ha.max_element() {
                pairs.push([frame.point(p), q]);
            }
        }
    }
    pairs.extend(edges);
    let (mut least, mut nearest) = (f32::INFINITY, Vec3::ZERO);
    for [p, q] in &pairs {
        let squared = (p - q).length_squared();
        if squared < least {
            (least, nearest) = (squared, p - q);
        }
    }
    let length = least.sqrt();
    // What is not farther than a few roundings has no direction.
    let touching = 1e-6 * (ha.max_element() + hb.max_element());
    if !(length > touching && length <= reach) {
        return Manifold::default();
    }
    let normal = nearest / length;
    let mut points: SmallVec<[Point; 17]> = SmallVec::new();
    for [p, q] in pairs {
        let distance = (p - q).dot(normal);
        // Within 5°: edges that are parallel, or nearly, touch along a line.
        if distance > 0.996 * (p - q).length() {
            points.push(Point { on_a: frame.local(p), on_b: q, distance });
        }
    }
    reduced(normal, reach, &points)
}

/// How far the corners of a box are from another, all eight side by side.
struct Gaps {
    /// Metres².
    squared: [f32; 8],
}

impl Gaps {
    /// The corners of a box of half sizes `k` at a frame, and the box of half sizes `h` in whose coordinates that is.
    #[inline(always)]
    fn new(k: Vec3, h: Vec3, frame: &Frame) -> Self {
        let (r, t) = (&frame.rotation, frame.translation);
        let (x, y, z) = (r.x_axis * k.x, r.y_axis * k.y, r.z_axis * k.z);
        let along = |t: f32, x: f32, y: f32, z: f32, h: f32| {
            let low = [t - x - y, t + x - y, t - x + y, t + x + y];
            let all = [
                low[0] - z,
                low[1] - z,
                low[2] - z,
                low[3] - z,
                low[0] + z,
                low[1] + z,
                low[2] + z,
                low[3] + z,
            ];
            all.map(|p| (p.abs() - h).max(0.0))
        };
        let dx = along(t.x, x.x, y.x, z.x, h.x);
        let dy = along(t.y, x.y, y.y, z.y, h.y);
        let dz = along(t.z, x.z, y.z, z.z, h.z);
        let mut squared = [0.0; 8];
        for i in 0..8 {
            squared[i] = dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i];
        }
        Self { squared }
    }
}

/// The corners of a cube.
pub(super) const SIGNS: [Vec3; 8] = [
    Vec3::new(-1.0, -1.0, -1.0),
    Vec3::new(1.0, -1.0, -1.0),
    Vec3::new(-1.0, 1.0, -1.0),
    Vec3::new(1.0, 1.0, -1.0),
    Vec3::new(-1.0, -1.0, 1.0),
    Vec3::new(1.0, -1.0, 1.0),
    Vec3::new(-1.0, 1.0, 1.0),
    Vec3::new(1.0, 1.0, 1.0),
];
