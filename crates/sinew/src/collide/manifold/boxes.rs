//! Box and box, the pair that a pile of boxes asks for most.
//!
//! Two convex bodies are apart by the greatest of their separations along any direction; for boxes that overlap, the greatest is one of 15: along
//! the 3 normals of `b`, the 3 of `a`, and the 9 products of an edge of each. With `a`'s axes `Rⱼ` and centre `t` in the coordinates of `b`, and
//! `cᵢⱼ = eᵢ·Rⱼ`:
//!
//! ```text
//! face i of b:  |tᵢ| - hbᵢ - Σⱼ haⱼ |cᵢⱼ|
//! face j of a:  |t·Rⱼ| - haⱼ - Σᵢ hbᵢ |cᵢⱼ|
//! edges i, j:   (|t·(eᵢ×Rⱼ)| - Σₖ hbₖ |eₖ·(eᵢ×Rⱼ)| - Σₖ haₖ |Rₖ·(eᵢ×Rⱼ)|) / √(1 - cᵢⱼ²)
//! ```
//!
//! A separation beyond reach ends the search. Otherwise the body with the face clips the other's most opposite face; two edges have one point.
//! Boxes that are apart, past the rims of each other's faces, may be nearest at a corner or two edges, along none of the 15.

use glam::{Vec3, Vec3A, Vec3Swizzles};
use smallvec::SmallVec;

use super::clip::Polygon;
use super::reduce::{choose, reduced};
use super::{Frame, Manifold, Point, inverse};

/// Two boxes of half sizes `ha` and `hb`, metres.
pub(super) fn collide(ha: Vec3, hb: Vec3, a_in_b: &Frame, reach: f32) -> Manifold {
    let pair = BoxPair::new(ha, hb, a_in_b);
    let Some(axes) = pair.separate(reach) else { return Manifold::default() };
    let most = axes.face_separation.max(axes.edge_separation);
    let mut faces = Manifold::default();
    if !axes.past {
        faces = pair.faces(axes.face, reach);
    }
    if !axes.edge_wins {
        if faces.len > 0 && (most <= 0.0 || faces.nearest() <= most + axes.bias) {
            return faces;
        }
    } else if faces.len > 1
        && (faces.nearest() - most).abs() <= axes.bias
        && pair.lies(&axes, &faces)
    {
        return faces;
    } else if let Some(manifold) = pair.edges(axes.edge, most > 0.0) {
        return manifold;
    }
    if most > 0.0 {
        // What is nearest is a corner or two edges past the rim of that face; or the face saw it after all.
        let edges =
            if axes.edge_separation > 0.0 { pair.nearest_of_edges(axes.edge) } else { None };
        let past = corners(&pair, reach, edges);
        return if past.nearest() < faces.nearest() - axes.bias { past } else { faces };
    }
    if faces.len == 0 && axes.edge_separation > f32::NEG_INFINITY {
        // They overlap by so little that the bias took an axis along which nothing is found.
        return pair.edges(axes.edge, false).unwrap_or_default();
    }
    faces
}

/// What is worth knowing about two boxes: everything in the coordinates of `b`.
struct BoxPair<'a> {
    pub(super) ha: [f32; 3],
    pub(super) hb: [f32; 3],
    pub(super) frame: &'a Frame,
    /// Axes of `a`.
    axes: [Vec3; 3],
    /// `c[i][j]`: axis `i` of `b` times axis `j` of `a`.
    c: [[f32; 3]; 3],
    t: [f32; 3],
}

/// The axes of least overlap, or greatest distance.
struct Axes {
    /// Of the faces: 0, 1, 2 of `b`; 3, 4, 5 of `a`.
    face: usize,
    face_separation: f32,
    /// Of the edges: an axis of `b` and one of `a`.
    edge: (usize, usize),
    edge_separation: f32,
    /// What an axis must be better by, metres.
    bias: f32,
    /// Whether the edges' is.
    edge_wins: bool,
    /// Whether the one with the face has the other past its rim.
    past: bool,
}

/// Edges closer to parallel than this (squared sine) have no product worth the name; a face's normal is as good there.
const PARALLEL: f32 = 1e-6;

/// What an axis must be better by, as a share of the overlap and of the smallest half size, to be taken instead of one that comes before it (faces of
/// `b`, then of `a`, then edges): a box at rest, whose overlaps are noise, keeps its face and its four points.
const BIAS: (f32, f32) = (0.03, 2e-3);

/// Cosine of the angle by which what lies on a face may lean: 6 degrees. What leans by more comes down on other points too far away to be of
/// interest.
const LEANS: f32 = 0.995;

/// What is nearer to the rim of a face than this share of its size was cut there, or nearly so.
const RIM: f32 = 1e-4;

/// What rounding leaves in a separation, as a share of the numbers that it is a difference of: a few units in the last place.
const ROUNDING: f32 = 5e-7;

/// The axes after an axis.
const NEXT: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

impl<'a> BoxPair<'a> {
    #[inline(always)]
    fn new(ha: Vec3, hb: Vec3, frame: &'a Frame) -> Self {
        let r = &frame.rotation;
        let axes = [r.x_axis, r.y_axis, r.z_axis];
        let [x, y, z] = axes;
        let c = [[x.x, y.x, z.x], [x.y, y.y, z.y], [x.z, y.z, z.z]];
        Self { ha: ha.into(), hb: hb.into(), frame, axes, c, t: frame.translation.into() }
    }

    /// The best axes; nothing if the boxes are further apart than `reach`, or not anywhere.
    #[inline(always)]
    fn separate(&self, reach: f32) -> Option<Axes> {
        let Self { ha, hb, c, t, axes, .. } = self;
        // Three axes at a time: the rows of `c`, by axis of `b`, and its columns, by axis of `a`.
        let rows = [Vec3A::from(c[0]), Vec3A::from(c[1]), Vec3A::from(c[2])];
        let sizes = [rows[0].abs(), rows[1].abs(), rows[2].abs()];
        let size = |h: &[f32; 3]| h[0].min(h[1]).min(h[2]);
        let small = BIAS.1 * size(ha).min(size(hb));
        let bias = |separation: f32| small + BIAS.0 * separation.abs();
        let (mut face, mut most) = (0, f32::NEG_INFINITY);
        // How far apart they are at least, squared, and along how many axes: of each box, because its axes are across each other.
        let (mut squared, mut beyond) = ([0.0; 2], [0; 2]);
        let mut note = |of: usize, apart: f32| {
            squared[of] += apart.max(0.0) * apart.max(0.0);
            beyond[of] += usize::from(apart > 0.0);
        };
        let columns = [Vec3A::from(axes[0]), Vec3A::from(axes[1]), Vec3A::from(axes[2])];
        let taken = columns[0].abs() * ha[0] + columns[1].abs() * ha[1] + columns[2].abs() * ha[2];
        let of_b = Vec3A::from(*t).abs() - Vec3A::from(*hb) - taken;
        if of_b.cmpgt(Vec3A::splat(reach)).any() {
            return None;
        }
        for (i, apart) in of_b.to_array().into_iter().enumerate() {
            note(0, apart);
            if apart > most {
                (face, most) = (i, apart);
            }
        }
        let threshold = most + bias(most);
        let mut of_a = threshold;
        let along = rows[0] * t[0] + rows[1] * t[1] + rows[2] * t[2];
        let taken = sizes[0] * hb[0] + sizes[1] * hb[1] + sizes[2] * hb[2];
        let apart = along.abs() - Vec3A::from(*ha) - taken;
        if apart.cmpgt(Vec3A::splat(reach)).any() {
            return None;
        }
        for (j, apart) in apart.to_array().into_iter().enumerate() {
            note(1, apart);
            if apart > of_a {
                (face, of_a, most) = (3 + j, apart, apart);
            }
        }
        if squared[0].max(squared[1]) > reach * reach {
            return None;
        }
        let (mut edge, mut edge_separation) = ((0, 0), f32::NEG_INFINITY);
        let unlikely = most.min(0.0);
        let (first, second) = (Vec3A::new(ha[1], ha[2], ha[0]), Vec3A::new(ha[2], ha[0], ha[1]));
        for i in 0..3 {
            let (i1, i2) = NEXT[i];
            let along = (rows[i1] * t[i2] - rows[i2] * t[i1]).abs();
            let turned = sizes[i];
            let extent = sizes[i2] * hb[i1]
                + sizes[i1] * hb[i2]
                + first * turned.zxy()
                + second * turned.yzx();
            // Where the edges are near parallel, the quotient is of two small numbers: what rounding may have added to it is taken off.
            let apart = along - extent - (along + extent) * ROUNDING;
            // The divisor is no more than 1: what is negative becomes more so.
            if !apart.cmpgt(Vec3A::splat(unlikely)).any() {
                continue;
            }
            for (j, apart) in apart.to_array().into_iter().enumerate() {
                if apart > unlikely {
                    let square = 1.0 - c[i][j] * c[i][j];
                    let apart = apart / square.max(PARALLEL).sqrt();
                    if square > PARALLEL && apart > edge_separation {
                        (edge, edge_separation) = ((i, j), apart);
                    }
                }
            }
        }
        if edge_separation > reach || most.is_nan() || !t.iter().all(|x| x.is_finite()) {
            return None;
        }
        let bias = bias(most);
        let edge_wins = edge_separation > most + bias;
        Some(Axes {
            face,
            face_separation: most,
            edge,
            edge_separation,
            bias,
            edge_wins,
            past: beyond[face / 3] > 1,
        })
    }

    /// Whether two edges that cross are of boxes that lie on each other with these faces, and lean a little. The deepest corner is far from the other
    /// box then, so that the face seems to overlap by more than the edges do; but where the two are on each other it says the same, and it holds what
    /// rocks there by more points than one.
    fn lies(&self, axes: &Axes, faces: &Manifold) -> bool {
        self.meet(axes.edge).2.dot(faces.normal) > LEANS
    }

    /// The faces along a normal (0, 1, 2 of `b`; 3, 4, 5 of `a`), clipped.
    #[inline(always)]
    fn faces(&self, face: usize, reach: f32) -> Manifold {
        let Self { ha, hb, frame, c, t, .. } = self;
        if face < 3 {
            return clipped(hb, face, ha, c, t, reach, None);
        }
        let [x, y, z] = *c;
        let turned = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
        let along = |row: &[f32; 3]| -(row[0] * t[0] + row[1] * t[1] + row[2] * t[2]);
        let back = [along(&turned[0]), along(&turned[1]), along(&turned[2])];
        clipped(ha, face - 3, hb, &turned, &back, reach, Some(frame))
    }

    /// The point of two edges, if it is on both of them; or the nearest to it that is, unless it `must` be.
    fn edges(&self, edge: (usize, usize), must: bool) -> Option<Manifold> {
        let (p, q, normal, over) = self.meet(edge);
        // A thousandth of an edge over its end is on it.
        if must && over > 1.001 {
            return None;
        }
        Some(Manifold::single(normal, self.frame.local(p), q, (p - q).dot(normal)))
    }

    /// The nearest points of two edges, on `a` and on `b`, if they are on both of them; their ends are corners.
    fn nearest_of_edges(&self, edge: (usize, usize)) -> Option<[Vec3; 2]> {
        let (p, q, _, over) = self.meet(edge);
        (over < 0.9999).then_some([p, q])
    }

    /// Nearest points of the two edges (on `a`, on `b`) that face each other along the product of their directions, that product towards `a`, and how
    /// far along an edge the lines' nearest points are, 1 at its end.
    ///
    /// With `d` between their midpoints, `u` along `a`'s and `s` along `b`'s: `d + u Rⱼ - s eᵢ` is across both, which is two linear equations.
    fn meet(&self, (i, j): (usize, usize)) -> (Vec3, Vec3, Vec3, f32) {
        let Self { ha, hb, axes, c, frame, .. } = self;
        let along_b = Vec3::AXES[i];
        let product = along_b.cross(axes[j]);
        let product = if product.dot(frame.translation) < 0.0 { -product } else { product };
        let normal = product / (1.0 - c[i][j] * c[i][j]).max(PARALLEL).sqrt();
        let (mut q, mut p) = (Vec3::ZERO, frame.translation);
        for k in [NEXT[i].0, NEXT[i].1] {
            q[k] = hb[k].copysign(normal[k]);
        }
        for k in [NEXT[j].0, NEXT[j].1] {
            p -= axes[k] * ha[k].copysign(axes[k].dot(normal));
        }
        let d = p - q;
        let (db, da, cosine) = (d[i], d.dot(axes[j]), c[i][j]);
        let square = (1.0 - cosine * cosine).max(PARALLEL);
        let (s, u) = ((db - cosine * da) / square, (cosine * db - da) / square);
        let over = (s.abs() / hb[i]).max(u.abs() / ha[j]);
        let (s, u) = (s.max(-hb[i]).min(hb[i]), u.max(-ha[j]).min(ha[j]));
        (p + axes[j] * u, q + along_b * s, normal, over)
    }
}

/// Face `i` of a box of half sizes `h`, and the most opposite face of one with half sizes `k`, axes `c` (by rows) and centre `t`: `b` and `a` of the
/// manifold, or `a` and `b` if the frame of `a` is given.
fn clipped(
    h: &[f32; 3],
    i: usize,
    k: &[f32; 3],
    c: &[[f32; 3]; 3],
    t: &[f32; 3],
    reach: f32,
    swap: Option<&Frame>,
) -> Manifold {
    let (i1, i2) = NEXT[i];
    let side = 1.0_f32.copysign(t[i]);
    let mut j = 0;
    for other in 1..3 {
        if c[i][other].abs() > c[i][j].abs() {
            j = other;
        }
    }
    let (j1, j2) = NEXT[j];
    // Across and above the face: the other box's centre, and its axes.
    let centre = Vec3::new(t[i1], t[i2], side * t[i] - h[i]);
    let axis = |j: usize, k: f32| Vec3::new(c[i1][j] * k, c[i2][j] * k, side * c[i][j] * k);
    let middle = centre - axis(j, k[j].copysign(c[i][j] * side));
    let (e1, e2) = (axis(j1, k[j1]), axis(j2, k[j2]));
    let corners = [middle + e1 + e2, middle - e1 + e2, middle - e1 - e2, middle + e1 - e2];
    let polygon = Polygon::cut(corners, h[i1], h[i2]);
    let corners = polygon.corners();
    let chosen = choose(corners.len(), reach, Vec3::Z, |n| corners[n].z, |n| corners[n]);
    // Back from there: to the face's own coordinates, and to those of the other. Not component by component, whose numbers vary.
    let [x, y, z] = [Vec3::AXES[i1], Vec3::AXES[i2], Vec3::AXES[i] * side];
    let [own_x, own_y, own_z] = [Vec3::from(c[i1]), Vec3::from(c[i2]), Vec3::from(c[i]) * side];
    let base = z * h[i];
    let mut manifold = Manifold::new(swap.map_or(z, |frame| frame.turn(-z)));
    let at_rim = |p: Vec3| (p.x.abs() > h[i1] * (1.0 - RIM)) | (p.y.abs() > h[i2] * (1.0 - RIM));
    if let [first, others @ ..] = chosen.as_slice() {
        let mut lowest = corners[*first];
        for &n in others {
            lowest = if corners[n].z < lowest.z { corners[n] } else { lowest };
        }
        if at_rim(lowest) {
            manifold.slope = (1.0 - c[i][j] * c[i][j]).max(0.0).sqrt();
        }
    }
    for &n in chosen.as_slice() {
        let p = corners[n];
        let from = p - centre;
        let on_face = base + x * p.x + y * p.y;
        let on_other = own_x * from.x + own_y * from.y + own_z * from.z;
        let (on_a, on_b) = if swap.is_some() { (on_face, on_other) } else { (on_other, on_face) };
        manifold.push(Point { on_a, on_b, distance: p.z });
    }
    manifold
}

/// Where two boxes are nearest, if that is within reach and they do not touch. `edges` are the nearest points of
/// the two edges that face each other, on `a` and on `b`, where there are such.
///
/// The nearest points of two boxes that are apart are a corner of one and a point of the other, or two edges along whose product the boxes are as far
/// apart.
fn corners(pair: &BoxPair, reach: f32, edges: Option<[Vec3; 2]>) -> Manifold {
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
