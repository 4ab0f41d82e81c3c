//! Boxes that are nearest at two edges or at a corner.

use glam::Vec3;
use smallvec::SmallVec;

use super::super::reduce::reduced;
use super::super::{Point, inverse};
use super::axes::PARALLEL;
use super::{BoxPair, Frame, Manifold, NEXT};

/// Greatest place of the lines' nearest point along an edge, 1 at its end, at which it counts as on the edge: 0.1 % beyond.
pub(super) const ON_EDGE: f32 = 1.001;
/// Greatest such place at which the point counts as inside the edge rather than a corner.
pub(super) const BEFORE_END: f32 = 0.9999;

/// The nearest points of two edges.
pub(super) struct Edges {
    /// On `a` and on `b`, in the coordinates of `b`, metres.
    points: [Vec3; 2],
    /// The product of the edges' directions, unit, pointing towards `a`.
    pub(super) normal: Vec3,
    /// How far along the edges the lines' nearest points are, the farther of the two; 1 at the end.
    pub(super) over: f32,
}

impl Edges {
    /// The manifold of this point.
    pub(super) fn manifold(&self, frame: &Frame) -> Manifold {
        let [p, q] = self.points;
        Manifold::single(self.normal, frame.local(p), q, (p - q).dot(self.normal))
    }
}

impl BoxPair {
    /// The nearest points of two edges that face each other: an axis of `b` and one of `a`.
    ///
    /// With `d` between their midpoints, `u` along `a`'s and `s` along `b`'s: `d + u Rⱼ - s eᵢ` is across both, which gives two linear equations.
    pub(super) fn nearest_on_edges(&self, (i, j): (usize, usize)) -> Edges {
        let Self { half_sizes: [ha, hb], frame, .. } = self;
        let r = &frame.rotation;
        let axes = [r.x_axis, r.y_axis, r.z_axis];
        let (along_b, cosine) = (Vec3::AXES[i], axes[j][i]);
        let product = along_b.cross(axes[j]);
        let product = if product.dot(frame.translation) < 0.0 { -product } else { product };
        let square = (1.0 - cosine * cosine).max(PARALLEL);
        let normal = product / square.sqrt();
        let (mut q, mut p) = (Vec3::ZERO, frame.translation);
        for k in [NEXT[i].0, NEXT[i].1] {
            q[k] = hb[k].copysign(normal[k]);
        }
        for k in [NEXT[j].0, NEXT[j].1] {
            p -= axes[k] * ha[k].copysign(axes[k].dot(normal));
        }
        let d = p - q;
        let (db, da) = (d[i], d.dot(axes[j]));
        let (s, u) = ((db - cosine * da) / square, (cosine * db - da) / square);
        let over = (s.abs() / hb[i]).max(u.abs() / ha[j]);
        let (s, u) = (s.max(-hb[i]).min(hb[i]), u.max(-ha[j]).min(ha[j]));
        Edges { points: [p + axes[j] * u, q + along_b * s], normal, over }
    }

    /// The manifold of two separated boxes that are nearest at corners or edges, empty beyond reach. `edges` are the nearest points of the two edges that face
    /// each other, if there are such.
    ///
    /// The nearest points of two separated boxes are a corner of one and a point of the other, or they lie on two edges along whose product the boxes are as
    /// far apart.
    pub(super) fn corners(&self, edges: Option<Edges>) -> Manifold {
        let Self { half_sizes: [ha, hb], frame, reach } = *self;
        let frame = &frame;
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
                // Two corners that coincide within rounding are already a pair.
                if (ha - p.abs()).max_element() > 1e-5 * ha.max_element() {
                    pairs.push([frame.point(p), q]);
                }
            }
        }
        pairs.extend(edges.map(|edges| edges.points));
        let (mut least, mut nearest) = (f32::INFINITY, Vec3::ZERO);
        for [p, q] in &pairs {
            let squared = (p - q).length_squared();
            if squared < least {
                (least, nearest) = (squared, p - q);
            }
        }
        let length = least.sqrt();
        // A distance of a few rounding errors has no direction.
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
}

/// Distances of the eight corners of a box from another box.
struct Gaps {
    /// Metres².
    squared: [f32; 8],
}

impl Gaps {
    /// The corners of a box of half sizes `k` at a frame, and a box of half sizes `h` in whose coordinates the frame is.
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
pub(in super::super) const SIGNS: [Vec3; 8] = [
    Vec3::new(-1.0, -1.0, -1.0),
    Vec3::new(1.0, -1.0, -1.0),
    Vec3::new(-1.0, 1.0, -1.0),
    Vec3::new(1.0, 1.0, -1.0),
    Vec3::new(-1.0, -1.0, 1.0),
    Vec3::new(1.0, -1.0, 1.0),
    Vec3::new(-1.0, 1.0, 1.0),
    Vec3::new(1.0, 1.0, 1.0),
];
