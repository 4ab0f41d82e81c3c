//! Narrow phase: contact manifolds of two shapes, each a normal and up to four points. A manifold is a function of the two shapes and their relative frame
//! alone; nothing is kept here between calls. Body contacts keep manifolds in `body_contact::contact_cache`.
//!
//! | file | contents |
//! |---|---|
//! | `boxes` | box and box, eight pairs at a time: separating axes, face clipping, and corners where no face is opposite a face |
//! | `half_space` | convex shape and half-space |
//! | `round` | spheres; capsule and capsule |
//! | `rod` | capsule and box |
//! | `convex` | cylinders and hulls, and convex shapes on meshes and heightfields: normals from `parry3d`, points from `features` |
//! | `coplanar` | one manifold for all coplanar triangles that a shape touches |
//! | `ghost` | contacts with inner edges of a floor made of several shapes, which are none |
//! | `reduce` | reduction of many contact points to four |
//! | `broad` | broad phase: pairs of overlapping AABBs |

mod boxes;
mod broad;
mod convex;
mod coplanar;
mod features;
mod ghost;
mod half_space;
mod reduce;
mod rod;
mod round;
#[cfg(test)]
mod tests;

use glam::Vec3;

use super::frame::Frame;
use super::shape::{Kind, Shape};
use super::words::{Reader, Write};
use crate::lanes::InstructionSet;

pub(crate) use boxes::BoxPairs;
pub(crate) use broad::{Aabb, BlockSearch, Broad, ClusterSearch, EightBoxes, NO_GROUP};
pub(crate) use convex::ManifoldScratch;
pub(crate) use ghost::{ContactWith, MovingBody, MovingShape, is_ghost};

/// A pair of nearby points, one on each surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Point {
    /// On the surface of the first shape, in its coordinates, metres.
    pub(crate) on_a: Vec3,
    /// On the surface of the second shape, in its coordinates, metres.
    pub(crate) on_b: Vec3,
    /// Separation from `on_b` to `on_a` along the normal, metres; negative where the shapes overlap.
    pub(crate) distance: f32,
}

/// Up to four contact points with a common normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Manifold {
    /// Unit vector in the coordinates of the second shape, from it towards the first.
    pub(crate) normal: Vec3,
    points: [Point; 4],
    len: u32,
    /// Index of the triangle of a mesh or heightfield, of several coplanar ones the least; 0 for convex shapes.
    pub(crate) part: u32,
    /// Rounding radii of the two shapes, metres; 0 where a shape is not round. A sphere touches a face below its centre however it has rolled, a capsule and a
    /// lying cylinder below their axes. The point that stays fixed in a round shape is therefore the centre of the rounding, one radius inside the surface.
    pub(crate) radii: [f32; 2],
    /// Whether each shape is round about its own y axis only, as a cylinder is. Its radius is then measured to the axis, not along the normal.
    pub(crate) axial: [bool; 2],
    /// How far the shapes can slide on each other, at least, before the manifold changes, metres: the distance to the rim of a face. 0 where it is not known.
    pub(crate) slide_limit: f32,
    /// Slope of one surface against the other where the deepest point is not a corner but lies at the rim of the other shape. As the shape slides or turns, it
    /// touches there with other points of its surface, which are higher or lower by this much per metre. 0 elsewhere, and where it is not known.
    pub(crate) slope: f32,
}

impl Manifold {
    /// A manifold without points.
    fn new(normal: Vec3) -> Self {
        Self { normal, ..Self::default() }
    }

    /// A manifold with a single point.
    fn single(normal: Vec3, on_a: Vec3, on_b: Vec3, distance: f32) -> Self {
        let mut manifold = Self::new(normal);
        manifold.push(Point { on_a, on_b, distance });
        manifold
    }

    /// Adds a point; a fifth is dropped.
    fn push(&mut self, point: Point) {
        if let Some(place) = self.points.get_mut(self.len as usize) {
            *place = point;
            self.len += 1;
        }
    }

    /// The points. A manifold returned by [`collide`] has at least one.
    pub(crate) fn points(&self) -> &[Point] {
        &self.points[..self.len as usize]
    }

    /// The least distance of the points, metres; infinite without points.
    fn nearest(&self) -> f32 {
        self.points().iter().fold(f32::INFINITY, |least, point| least.min(point.distance))
    }

    /// The same manifold with the two shapes exchanged; `b_in_a` is the frame of the second shape in the coordinates of the first.
    fn swapped(&self, b_in_a: &Frame) -> Self {
        let ([ra, rb], [a, b]) = (self.radii, self.axial);
        let (radii, axial) = ([rb, ra], [b, a]);
        let mut manifold = Self { normal: b_in_a.turn(-self.normal), radii, axial, ..*self };
        for point in &mut manifold.points[..self.len as usize] {
            (point.on_a, point.on_b) = (point.on_b, point.on_a);
        }
        manifold
    }

    /// The same manifold, transformed by `at` from the coordinates of a part of the second shape to those of the shape.
    fn placed(mut self, at: &Frame) -> Self {
        self.normal = at.turn(self.normal);
        for point in &mut self.points[..self.len as usize] {
            point.on_b = at.point(point.on_b);
        }
        self
    }

    /// Appends the manifold to serialized words.
    pub(crate) fn write(&self, words: &mut Vec<u32>) {
        let Self { normal, points, len, part, radii, axial, slide_limit, slope } = self;
        words.vec3(*normal);
        words.push(*len);
        for point in points {
            words.vec3(point.on_a);
            words.vec3(point.on_b);
            words.float(point.distance);
        }
        words.push(*part);
        words.extend([radii[0].to_bits(), radii[1].to_bits()]);
        words.extend(axial.map(u32::from));
        words.extend([slide_limit.to_bits(), slope.to_bits()]);
    }

    /// Reads a manifold from serialized words.
    pub(crate) fn read(reader: &mut Reader) -> Option<Self> {
        let normal = reader.vec3()?;
        let len = reader.word().filter(|&len| len <= 4)?;
        let mut points = [Point::default(); 4];
        for point in &mut points {
            let (on_a, on_b) = (reader.vec3()?, reader.vec3()?);
            *point = Point { on_a, on_b, distance: reader.float()? };
        }
        let part = reader.word()?;
        let radii = [reader.float()?, reader.float()?];
        let axial = [reader.word()? != 0, reader.word()? != 0];
        let (slide_limit, slope) = (reader.float()?, reader.float()?);
        Some(Self { normal, points, len, part, radii, axial, slide_limit, slope })
    }

    /// Whether either shape is round.
    pub(crate) fn is_round(&self) -> bool {
        self.radii != [0.0; 2]
    }

    /// The points that stay fixed in each shape, given the frame of the first when the manifold was computed: the surface point, or the centre of the rounding.
    pub(crate) fn anchors(&self, point: &Point, a_in_b: &Frame) -> [Vec3; 2] {
        self.anchors_about(point, a_in_b, self.axial)
    }

    /// The same with axial roundness given by the argument instead of [`axial`](Self::axial).
    #[inline(always)]
    pub(crate) fn anchors_about(
        &self,
        point: &Point,
        a_in_b: &Frame,
        axial: [bool; 2],
    ) -> [Vec3; 2] {
        let [own, theirs] = self.radii;
        let mut anchors =
            [point.on_a + a_in_b.turn_back(self.normal) * own, point.on_b - self.normal * theirs];
        if axial[0] {
            (anchors[0].x, anchors[0].z) = (0.0, 0.0);
        }
        if axial[1] {
            (anchors[1].x, anchors[1].z) = (0.0, 0.0);
        }
        anchors
    }

    /// Sets the rounding radii of both shapes.
    #[inline(always)]
    fn note_rounding(&mut self, kinds: [Kind; 2], a_in_b: &Frame) {
        (self.radii, self.axial) = roundings(kinds, a_in_b, self.normal, self.points());
    }

    /// Whether there are points and all numbers are finite: NaN and infinity times zero are NaN, and so is a sum with them.
    #[inline(always)]
    fn is_sound(&self) -> bool {
        let mut sum = self.normal;
        for point in self.points() {
            sum += point.on_a + point.on_b + point.distance;
        }
        self.len > 0 && sum.dot(Vec3::ZERO) == 0.0
    }
}

/// Passes each manifold of `a` and `b` to `out` where they are no further apart than `reach` metres (0 or more); `a_in_b` is the frame of `a` in the
/// coordinates of `b`.
///
/// Two convex shapes give one manifold; meshes and heightfields give one for each plane of their nearby triangles, by ascending
/// [`part`](Manifold::part), and the inside of a box gives one for each wall. There is none for
/// two shapes that cannot move (half-spaces, insides of boxes, meshes, heightfields), and none if the frame is not finite.
pub(crate) fn collide(
    a: &Shape,
    b: &Shape,
    a_in_b: &Frame,
    reach: f32,
    scratch: &mut ManifoldScratch,
    out: &mut dyn FnMut(&Manifold),
) {
    if rank(a.kind()) <= rank(b.kind()) {
        return in_order(a, b, a_in_b, reach, scratch, out);
    }
    let b_in_a = inverse(a_in_b);
    in_order(b, a, &b_in_a, reach, scratch, &mut |manifold| out(&manifold.swapped(a_in_b)));
}

/// Whether a shape gives a manifold for each plane of its triangles near another shape.
pub(crate) fn is_of_triangles(shape: &Shape) -> bool {
    match shape.kind() {
        Kind::Mesh | Kind::HeightField => true,
        // `parry3d` represents a hull with degenerate faces as a mesh.
        Kind::Hull(_) => shape.parry().as_trimesh().is_some(),
        _ => false,
    }
}

/// [`collide`] for two shapes in the order of their [`rank`], so that each pair of kinds is written once.
fn in_order(
    a: &Shape,
    b: &Shape,
    a_in_b: &Frame,
    reach: f32,
    scratch: &mut ManifoldScratch,
    out: &mut dyn FnMut(&Manifold),
) {
    let mut found = match (a.kind(), b.kind()) {
        (Kind::HalfSpace | Kind::InsideBox | Kind::Mesh | Kind::HeightField, _) => return,
        (kind, Kind::HalfSpace) => {
            Manifold { slide_limit: f32::INFINITY, ..half_space::collide(kind, a_in_b, reach) }
        }
        (kind, Kind::InsideBox) => {
            for wall in b.half_spaces() {
                let found = half_space::collide(kind, &a_in_b.from_within(&wall), reach);
                let found = Manifold { slide_limit: f32::INFINITY, ..found };
                if found.is_sound() {
                    let mut found = found.placed(&wall);
                    found.note_rounding([kind, Kind::InsideBox], a_in_b);
                    out(&found);
                }
            }
            return;
        }
        (_, Kind::Mesh | Kind::HeightField) => {
            return convex::on_triangles(a, b, a_in_b, reach, scratch, out);
        }
        (_, Kind::Hull(_)) if is_of_triangles(b) => {
            return convex::on_triangles(a, b, a_in_b, reach, scratch, out);
        }
        (Kind::Box { .. }, Kind::Box { .. }) => {
            let pairs = &mut scratch.boxes;
            pairs.clear();
            pairs.push([a, b], a_in_b, reach);
            pairs.collide(InstructionSet::best()).first().copied().unwrap_or_default()
        }
        (Kind::Sphere { radius }, _) => round::sphere(radius, b, a_in_b, reach).unwrap_or_default(),
        (
            Kind::Capsule { radius, half_height },
            Kind::Capsule { radius: other, half_height: other_half },
        ) => round::capsules([radius, half_height], [other, other_half], a_in_b, reach)
            .unwrap_or_default(),
        (Kind::Capsule { radius, half_height }, Kind::Box { half_size }) => {
            rod::collide([radius, half_height], half_size, a_in_b, reach).unwrap_or_default()
        }
        _ => convex::collide(a, b, a_in_b, reach, scratch).unwrap_or_default(),
    };
    if found.is_sound() {
        found.note_rounding([a.kind(), b.kind()], a_in_b);
        out(&found);
    }
}

/// Sine of the greatest tilt at which a shape still lies on a face, an edge or an end: 6°. If it is tilted by more, its other points are too high to matter.
const FLAT_SINE: f32 = 0.1;
/// Cosine of that angle.
const FLAT_COSINE: f32 = 0.995;

/// By how much an axis must be better to be preferred to one that comes before it (faces before edges): a share of the overlap, plus a share of the smallest
/// half size of a box. A shape at rest, whose overlaps are noise, keeps its face and its points.
const BIAS: (f32, f32) = (0.03, 2e-3);

/// Rounding radii of two shapes that touch at some points along a normal, metres, and whether each is round about its y axis only.
type Roundings = ([f32; 2], [bool; 2]);

/// The [`Roundings`] of two shapes in contact.
#[inline(always)]
fn roundings(kinds: [Kind; 2], a_in_b: &Frame, normal: Vec3, points: &[Point]) -> Roundings {
    let towards_b = a_in_b.turn_back(-normal);
    let own = rounding(kinds[0], towards_b, points.iter().map(|point| point.on_a));
    let theirs = rounding(kinds[1], normal, points.iter().map(|point| point.on_b));
    ([own.0, theirs.0], [own.1, theirs.1])
}

/// The rounding radius of a shape that touches at some points, metres (0 if it is not round there), and whether it is round about its y axis only.
#[inline(always)]
fn rounding(kind: Kind, outwards: Vec3, mut points: impl Iterator<Item = Vec3>) -> (f32, bool) {
    match kind {
        Kind::Sphere { radius } | Kind::Capsule { radius, .. } => (radius, false),
        Kind::Cylinder { radius, .. } => {
            let (out, sine) = across_axis(outwards);
            let near = 1e-3 * radius;
            let is_lowest =
                |p: Vec3| (Vec3::new(p.x, 0.0, p.z) - out * radius).length_squared() < near * near;
            let rolls = sine > FLAT_SINE && points.all(is_lowest);
            if rolls { (radius, true) } else { (0.0, false) }
        }
        _ => (0.0, false),
    }
}

/// The unit direction across the y axis that is nearest to a direction, and the sine of the angle between the direction and the axis. Within 0.06° of the axis
/// it is x, or the points of a cylinder that stands upright would rotate with every rounding error.
#[inline(always)]
fn across_axis(direction: Vec3) -> (Vec3, f32) {
    let across = Vec3::new(direction.x, 0.0, direction.z);
    let sine = across.length();
    (if sine > 1e-3 { across / sine } else { Vec3::X }, sine)
}

/// Order of the two shapes of a pair: simple shapes before complex ones, shapes that can move before those that cannot.
fn rank(kind: Kind) -> u8 {
    match kind {
        Kind::Sphere { .. } => 0,
        Kind::Capsule { .. } => 1,
        Kind::Box { .. } => 2,
        Kind::Cylinder { .. } => 3,
        Kind::Hull(..) => 4,
        Kind::HalfSpace => 5,
        Kind::Mesh => 6,
        Kind::HeightField => 7,
        Kind::InsideBox => 8,
    }
}

/// The inverse of a frame.
fn inverse(frame: &Frame) -> Frame {
    Frame { translation: -frame.turn_back(frame.translation), rotation: frame.rotation.transpose() }
}
