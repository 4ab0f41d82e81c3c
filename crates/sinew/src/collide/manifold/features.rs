//! Contact points of two convex shapes along a given normal, from the opposing features: corners, edges and faces with any number of corners, clipped to each
//! other's outline. (`parry3d` keeps only the first four corners of a face, so that a prism of seven sides stood on half of its end and fell over.)

use glam::Vec3;
use smallvec::SmallVec;

use super::super::shape::{Kind, Shape};
use super::{FLAT_COSINE, FLAT_SINE, Frame, Point, across_axis};

/// Corners in order about the normal: one for a corner, two for an edge, three or more for a face.
type FeatureCorners = SmallVec<[Vec3; 16]>;
/// Contact points of two shapes before their reduction to four.
pub(super) type ContactPoints = SmallVec<[Point; 16]>;

/// Number of corners that approximate a cylinder's end. Their polygon covers 97 % of its area.
const CYLINDER_CORNERS: usize = 16;
/// Largest angle between a normal and the normal of a face for it to be replaced by the latter, rad: a normal found from nearest points is no more accurate
/// than that.
const FACE_TOLERANCE: f32 = 3e-3;
/// Sine of the angle between two edges from which they cross in a single point: 8°. With a single point a capsule would roll about it.
pub(super) const CROSSING_SINE: f32 = 0.14;

/// How far outside of a face a point still counts as above it, as a share of the length of its side there: an edge that lies along the common side of two
/// triangles would otherwise, by rounding, be above neither.
const CUT: f32 = 1e-5;

/// One side of a pair.
pub(super) enum ShapeOrTriangle<'a> {
    /// A shape that can move.
    Shape(&'a Shape),
    /// A triangle of a mesh or heightfield.
    Triangle([Vec3; 3]),
}

/// Contact points along a unit normal from `b` to `a`, in the coordinates of `b`. Empty where a corner touches a corner or two edges cross: those are the
/// nearest points of the shapes, and are not computed from features.
pub(super) fn contacts(
    a: &ShapeOrTriangle,
    b: &ShapeOrTriangle,
    a_in_b: &Frame,
    normal: Vec3,
) -> ContactPoints {
    let (t, u) = normal.any_orthonormal_pair();
    let flat = |p: Vec3| Vec3::new(p.dot(t), p.dot(u), p.dot(normal));
    let mut own = a.feature(a_in_b.turn_back(-normal));
    own.iter_mut().for_each(|p| *p = flat(a_in_b.point(*p)));
    let mut theirs = b.feature(normal);
    theirs.iter_mut().for_each(|p| *p = flat(*p));
    let (own, theirs) = (outline(own, 0.0), outline(theirs, 0.0));
    let up = [plane(&own), plane(&theirs)];
    let steep = up.map(|up| up.map_or(f32::INFINITY, |up| up.truncate().length() / up.z.abs()));
    // Corners of the clipped feature, with the heights of both surfaces there.
    let pairs: SmallVec<[(Vec3, f32); 16]> = match up {
        [None, None] => {
            return along(&own, &theirs, |p| t * p.x + u * p.y + normal * p.z, a_in_b);
        }
        [_, Some(up)] if steep[1] <= steep[0] => {
            let height =
                |p: Vec3| theirs[0].z - (p - theirs[0]).truncate().dot(up.truncate()) / up.z;
            cut(own, &theirs).into_iter().map(|p| (p, height(p))).collect()
        }
        [Some(up), _] => {
            let height = |p: Vec3| own[0].z - (p - own[0]).truncate().dot(up.truncate()) / up.z;
            cut(theirs, &own).into_iter().map(|p| (p.with_z(height(p)), p.z)).collect()
        }
        [None, Some(_)] => return ContactPoints::new(),
    };
    let place = |p: Vec3, z: f32| t * p.x + u * p.y + normal * z;
    let points = pairs.into_iter().map(|(p, z)| {
        let (on_a, on_b) = (place(p, p.z), place(p, z));
        Point { on_a: a_in_b.local(on_a), on_b, distance: (on_a - on_b).dot(normal) }
    });
    points.collect()
}

/// The face normal of one of the shapes that replaces `normal` (from `b` to `a`), if one is within [`FACE_TOLERANCE`] of it; else `normal`.
pub(super) fn of_face(
    a: &ShapeOrTriangle,
    b: &ShapeOrTriangle,
    a_in_b: &Frame,
    normal: Vec3,
) -> Vec3 {
    let (mut best, mut least) = (normal, FACE_TOLERANCE * FACE_TOLERANCE);
    let mut try_out = |face: Vec3| {
        let off = (face - normal).length_squared();
        if off < least {
            (best, least) = (face, off);
        }
    };
    b.each_face(&mut |face, _| try_out(face));
    a.each_face(&mut |face, _| try_out(a_in_b.turn(-face)));
    best
}

/// The face along whose normal the shapes are farthest apart, or overlap least: the separation, metres, and the normal from `b` to `a` in the coordinates of
/// `b`. `None` where neither shape has a face.
pub(super) fn best_face(
    a: &ShapeOrTriangle,
    b: &ShapeOrTriangle,
    a_in_b: &Frame,
) -> Option<(f32, Vec3)> {
    let (own, theirs) = (a_in_b.point(a.inside()), b.inside());
    let mut best: Option<(f32, Vec3)> = None;
    // The separation is at most the height of an inner point of the other shape above the plane; this cheap bound excludes most faces.
    let is_less = |most: f32, best: &Option<(f32, Vec3)>| best.is_some_and(|best| most <= best.0);
    let mut try_out = |most: f32, normal: Vec3, apart: &dyn Fn() -> f32| {
        if is_less(most, &best) {
            return;
        }
        let apart = apart();
        if !is_less(apart, &best) {
            best = Some((apart, normal));
        }
    };
    b.each_face(&mut |normal, offset| {
        let apart = || {
            let lowest = -a.reach(a_in_b.turn_back(-normal));
            normal.dot(a_in_b.translation) + lowest - offset
        };
        try_out(normal.dot(own) - offset, normal, &apart);
    });
    a.each_face(&mut |normal, offset| {
        let normal = a_in_b.turn(-normal);
        let least = normal.dot(a_in_b.translation) - offset;
        try_out(least - normal.dot(theirs), normal, &|| least - b.reach(normal));
    });
    best
}

impl ShapeOrTriangle<'_> {
    /// A point inside the shape.
    fn inside(&self) -> Vec3 {
        match self {
            Self::Triangle(corners) => (corners[0] + corners[1] + corners[2]) / 3.0,
            Self::Shape(shape) => match shape.kind() {
                Kind::Hull(corners) => corners.iter().sum::<Vec3>() / corners.len() as f32,
                _ => Vec3::ZERO,
            },
        }
    }

    /// Support distance along a unit direction, metres from the shape's origin.
    pub(super) fn reach(&self, direction: Vec3) -> f32 {
        let farthest = |corners: &[Vec3]| {
            corners.iter().map(|p| p.dot(direction)).fold(f32::NEG_INFINITY, f32::max)
        };
        let shape = match self {
            Self::Triangle(corners) => return farthest(corners),
            Self::Shape(shape) => shape,
        };
        match shape.kind() {
            Kind::Hull(corners) => farthest(corners),
            Kind::Box { half_size } => direction.abs().dot(half_size),
            Kind::Sphere { radius } => radius,
            Kind::Capsule { radius, half_height } => radius + half_height * direction.y.abs(),
            Kind::Cylinder { radius, half_height } => {
                radius * across_axis(direction).1 + half_height * direction.y.abs()
            }
            Kind::HalfSpace | Kind::InsideBox | Kind::Mesh | Kind::HeightField => f32::INFINITY,
        }
    }

    /// Calls `each` with the outward normal of each face and its support distance, metres from the shape's origin.
    fn each_face(&self, each: &mut dyn FnMut(Vec3, f32)) {
        let shape = match *self {
            Self::Triangle([p, q, r]) => {
                if let Some(normal) = (q - p).cross(r - p).try_normalize() {
                    each(normal, normal.dot(p));
                    each(-normal, -normal.dot(p));
                }
                return;
            }
            Self::Shape(shape) => shape,
        };
        match shape.kind() {
            Kind::Hull(_) => shape.faces().for_each(|(normal, offset)| each(normal, offset)),
            Kind::Box { half_size } => {
                for (axis, half) in Vec3::AXES.into_iter().zip(half_size.to_array()) {
                    each(axis, half);
                    each(-axis, half);
                }
            }
            Kind::Cylinder { half_height, .. } => {
                each(Vec3::Y, half_height);
                each(-Vec3::Y, half_height);
            }
            Kind::HalfSpace => each(Vec3::Y, 0.0),
            _ => (),
        }
    }

    /// The face with the given normal: the exact normal, and its support distance, metres from the shape's origin. `None` if there is none.
    pub(super) fn face_along(&self, normal: Vec3) -> Option<(Vec3, f32)> {
        let mut found = None;
        self.each_face(&mut |face, offset| {
            if (face - normal).length_squared() < FACE_TOLERANCE * FACE_TOLERANCE {
                found = Some((face, offset));
            }
        });
        found
    }

    /// Corners of the feature that is farthest along a unit direction, in any order: of the faces across it, of an edge, or one corner. For a capsule, the ends
    /// of its axis.
    fn feature(&self, direction: Vec3) -> FeatureCorners {
        // Both ends of a long shape, whatever its tilt: points out of reach are discarded later.
        let ends = |half: f32, beside: Vec3| -> FeatureCorners {
            [half, -half].map(|y| beside + Vec3::Y * y).into_iter().collect()
        };
        let shape = match *self {
            Self::Triangle(corners) => {
                let [p, q, r] = corners;
                let normal = (q - p).cross(r - p);
                let is_face = normal.dot(direction).abs() > FLAT_COSINE * normal.length();
                return if is_face {
                    corners.into_iter().collect()
                } else {
                    edge(&corners, direction)
                };
            }
            Self::Shape(shape) => shape,
        };
        match shape.kind() {
            Kind::Hull(corners) => {
                let face: FeatureCorners = shape.corners_towards(direction, FLAT_COSINE).collect();
                if face.is_empty() { edge(corners, direction) } else { face }
            }
            Kind::Box { half_size } => {
                // Both ends of every axis that lies across the direction.
                let sides = direction.abs().cmple(Vec3::splat(FLAT_SINE)).bitmask();
                let corners = (0..8_u32).map(|bits| {
                    let sign = |axis: usize| if bits >> axis & 1 == 1 { 1.0 } else { -1.0 };
                    (bits, Vec3::from_array([0, 1, 2].map(sign)))
                });
                let ahead = Vec3::ONE.copysign(direction);
                let is_ahead = |sign: Vec3| sides | sign.cmpeq(ahead).bitmask() == 7;
                let chosen = corners.filter(|(_, sign)| is_ahead(*sign));
                chosen.map(|(_, sign)| sign * half_size).collect()
            }
            Kind::Capsule { half_height, .. } => ends(half_height, Vec3::ZERO),
            Kind::Cylinder { radius, half_height } => {
                let (out, sine) = across_axis(direction);
                if sine > FLAT_SINE {
                    return ends(half_height, out * radius);
                }
                let (x, z) = (out * radius, Vec3::new(-out.z, 0.0, out.x) * radius);
                let end = Vec3::Y * half_height.copysign(direction.y);
                let step = core::f32::consts::TAU / CYLINDER_CORNERS as f32;
                let corner = |i: usize| {
                    let (sine, cosine) = libm::sincosf(step * i as f32);
                    end + x * cosine + z * sine
                };
                (0..CYLINDER_CORNERS).map(corner).collect()
            }
            Kind::Sphere { .. }
            | Kind::HalfSpace
            | Kind::InsideBox
            | Kind::Mesh
            | Kind::HeightField => FeatureCorners::new(),
        }
    }
}

/// The corner farthest along a direction, and the corner towards which the line from it falls least, if its slope is less than [`FLAT_SINE`].
fn edge(corners: &[Vec3], direction: Vec3) -> FeatureCorners {
    let mut best = (f32::NEG_INFINITY, Vec3::ZERO);
    for &p in corners {
        let height = p.dot(direction);
        if height > best.0 {
            best = (height, p);
        }
    }
    let (top, mut least, mut feature) = (best.1, FLAT_SINE, FeatureCorners::new());
    feature.push(top);
    for &p in corners {
        let slope = (top - p).dot(direction) / (top - p).length();
        if slope < least {
            least = slope;
            feature.truncate(1);
            feature.push(p);
        }
    }
    feature
}

/// The points of a flat contact area that span it: the corners of its outline, seen along its normal, and the deepest point. Points nearer than `rounding` metres
/// to another, or to the line between two others, are left out.
pub(super) fn spanning(points: &[Point], normal: Vec3, rounding: f32) -> ContactPoints {
    let (t, u) = normal.any_orthonormal_pair();
    // The number of a point takes the place of its height, which an outline passes on.
    let numbered = points.iter().enumerate();
    let flat = numbered.map(|(i, p)| Vec3::new(p.on_b.dot(t), p.on_b.dot(u), i as f32));
    let corners = outline(flat.collect(), rounding);
    let mut chosen: ContactPoints = corners.iter().map(|p| points[p.z as usize]).collect();
    chosen.dedup_by(|a, b| a.on_b.distance_squared(b.on_b) <= rounding * rounding);
    let deepest = |points: &[Point]| {
        points.iter().copied().reduce(|p, q| if q.distance < p.distance { q } else { p })
    };
    if let [Some(of_chosen), Some(of_all)] = [deepest(&chosen), deepest(points)]
        && of_all.distance < of_chosen.distance - rounding
    {
        chosen.push(of_all);
    }
    chosen
}

/// The convex hull of some points by x and y, counter-clockwise (A. M. Andrew's monotone chain, 1979). Points nearer to the line between two others than a
/// hundred-thousandth of the extent, or than `rounding` metres, count as lying on it.
fn outline(mut places: FeatureCorners, rounding: f32) -> FeatureCorners {
    if places.len() < 3 {
        return places;
    }
    places.sort_unstable_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    let (first, last) = (places[0], places[places.len() - 1]);
    let squared = (last - first).truncate().length_squared();
    let thin = (1e-5 * squared).max(rounding * squared.sqrt());
    let mut corners = FeatureCorners::new();
    let turns = |p: Vec3, q: Vec3, r: Vec3| (q - p).truncate().perp_dot((r - p).truncate()) > thin;
    let half = |places: &mut dyn Iterator<Item = Vec3>, corners: &mut FeatureCorners| {
        let from = corners.len();
        for r in places {
            while let [.., p, q] = corners[from..] {
                if turns(p, q, r) {
                    break;
                }
                corners.pop();
            }
            corners.push(r);
        }
        // The end of one half is the beginning of the other.
        corners.pop();
    };
    half(&mut places.iter().copied(), &mut corners);
    half(&mut places.iter().rev().copied(), &mut corners);
    if corners.len() < 2 { [first, last].into_iter().collect() } else { corners }
}

/// A normal of the plane of a face, pointing up, not normalised; `None` if it is not a face (M. E. Newell).
fn plane(corners: &FeatureCorners) -> Option<Vec3> {
    let from = corners.first().filter(|_| corners.len() > 2)?;
    let pairs = corners[1..].windows(2);
    let sum: Vec3 = pairs.map(|pair| (pair[0] - from).cross(pair[1] - from)).sum();
    (sum.z > 0.0).then_some(sum)
}

/// Clips a feature to the prism above and below a face.
fn cut(mut feature: FeatureCorners, face: &FeatureCorners) -> FeatureCorners {
    for (i, &p) in face.iter().enumerate() {
        let along = (face[(i + 1) % face.len()] - p).truncate();
        let inside = |q: Vec3| along.perp_dot((q - p).truncate()) + CUT * along.length_squared();
        let before = core::mem::take(&mut feature);
        let Some(&last) = before.last() else { break };
        // An edge is not closed: no segment leads from its end back to its start.
        let mut was = if before.len() > 2 { Some((last, inside(last))) } else { None };
        for &q in &before {
            let at_q = inside(q);
            if let Some((p, at_p)) = was.filter(|(_, at_p)| (*at_p < 0.0) != (at_q < 0.0)) {
                feature.push(p + (q - p) * (at_p / (at_p - at_q)));
            }
            if at_q >= 0.0 {
                feature.push(q);
            }
            was = Some((q, at_q));
        }
    }
    feature
}

/// The ends of the common part of two nearly parallel edges; empty where they cross, or where either is a corner.
fn along(
    own: &FeatureCorners,
    theirs: &FeatureCorners,
    place: impl Fn(Vec3) -> Vec3,
    a_in_b: &Frame,
) -> ContactPoints {
    let (&[p, p1], &[q, q1]) = (own.as_slice(), theirs.as_slice()) else {
        return ContactPoints::new();
    };
    let (d, e) = ((p1 - p).truncate(), (q1 - q).truncate());
    let lengths = d.length() * e.length();
    if lengths <= 0.0 || d.perp_dot(e).abs() > CROSSING_SINE * lengths {
        return ContactPoints::new();
    }
    // Places of the ends of `b`'s edge along `a`'s, as fractions of its length.
    let at = |r: Vec3| (r - p).truncate().dot(d) / d.length_squared();
    let (from, to) = (at(q).min(at(q1)).max(0.0), at(q).max(at(q1)).min(1.0));
    if to < from {
        return ContactPoints::new();
    }
    let point = |share: f32| {
        let on_a = p + (p1 - p) * share;
        let theirs = (on_a - q).truncate().dot(e) / e.length_squared();
        let on_b = q + (q1 - q) * theirs.clamp(0.0, 1.0);
        let (distance, on_a) = (on_a.z - on_b.z, place(on_a));
        Point { on_a: a_in_b.local(on_a), on_b: place(on_b), distance }
    };
    [from, to].map(point).into_iter().collect()
}
